#pragma once

#include <gpsrecon/io/io.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <optional>
#include <string>

#include "arguments.h"
#include "inputs.h"

namespace gpsrecon::cli {

// Every options struct as flags, once: the chain and the command of a stage declare the same ones. The structs hold
// the defaults and check the ranges.

void bind_scale(Arguments& arguments, ScaleOptions& options);
/// What the columns of the points mean.
void bind_attributes(Arguments& arguments, AttributeOptions& options);
/// Kernel width and reduction.
void bind_hem(Arguments& arguments, ReconstructOptions& options);
/// What chooses or checks the kernel width by a search: of the chain, which has all stages.
void bind_scale_choice(Arguments& arguments, ReconstructOptions& options);
/// How points are projected, of the command `project`.
void bind_projection(Arguments& arguments, ProjectionOptions& options);
/// Whether the chain projects them.
void bind_chain_projection(Arguments& arguments, ReconstructOptions& options);
void bind_triangulate(Arguments& arguments, ReconstructOptions& options);
/// Where the sensor stood, of bind_triangulate() and of the fit.
void bind_sensor(Arguments& arguments, ReconstructOptions& options);
void bind_fit(Arguments& arguments, FitOptions& options);

/// The rules of the surface as they were given on the command line: what was not is left to the covariance mesh.
class GivenRules {
 public:
  void bind(Arguments& arguments, const SurfaceRules& defaults);
  /// The same for a command whose input has rules of its own.
  void bind(Arguments& arguments);
  /// `rules` with what was given in place of theirs.
  SurfaceRules over(const SurfaceRules& rules) const;
  /// A mesh read from `path`, likewise. InputError if its faces do not go with the scheme.
  CovMesh over(CovMesh mesh, const std::string& path) const;

 private:
  void bind(Arguments& arguments, const SurfaceRules* defaults);

  std::optional<Scheme> scheme_;
  std::optional<LoopWeights> weights_;
  std::optional<CornerRule> corners_;
};

void bind_subdivide(Arguments& arguments, ReconstructOptions& options);

/// How PLY outputs are encoded.
void bind_encoding(Arguments& arguments, PlyEncoding& encoding);

}  // namespace gpsrecon::cli
