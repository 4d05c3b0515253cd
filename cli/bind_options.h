#pragma once

#include <gpsrecon/io/io.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <optional>
#include <string>

#include "arguments.h"
#include "inputs.h"

namespace gpsrecon::cli {

// What several commands declare the same way, beyond the fields of one struct.

/// Which points are used and, if not null, what their columns mean.
void bind_points(Arguments& arguments, ScaleOptions& scale, AttributeOptions* attributes);
/// Kernel width and reduction.
void bind_mixture(Arguments& arguments, HemOptions& options);
/// Whether the chain projects the points.
void bind_chain_projection(Arguments& arguments, ReconstructOptions& options);
/// The rules of the surface as they were given on the command line: what was not is left to the covariance mesh.
struct GivenRules {
  std::optional<Scheme> scheme = {};
  std::optional<LoopWeights> weights = {};
  std::optional<CornerRule> corners = {};

  void bind(Arguments& arguments, const SurfaceRules& defaults);
  /// The same for a command whose input has rules of its own.
  void bind(Arguments& arguments);
  /// `rules` with what was given in place of theirs.
  SurfaceRules over(const SurfaceRules& rules) const;
  /// A mesh read from `path`, likewise. InputError if its faces do not go with the scheme.
  CovMesh over(CovMesh mesh, const std::string& path) const;

 private:
  void bind(Arguments& arguments, const SurfaceRules* defaults);
};

/// How PLY outputs are encoded.
void bind_encoding(Arguments& arguments, PlyEncoding& encoding);

}  // namespace gpsrecon::cli
