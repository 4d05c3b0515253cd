#pragma once

#include <gpsrecon/core/mixture.h>
#include <string>
#include <vector>

// Internal: the rows in which files hold a mixture, in world coordinates:
// x y z covxx covxy covxz covyy covyz covzz weight [nvx nvy nvz].

namespace gpsrecon::internal {

inline constexpr const char* mixture_columns[] = {"x",     "y",     "z",      "covxx", "covxy", "covxz", "covyy",
                                                  "covyz", "covzz", "weight", "nvx",   "nvy",   "nvz"};
inline constexpr std::size_t row_size_without_normals = 10;
inline constexpr std::size_t row_size_with_normals = 13;

struct MixtureRows {
  std::size_t row_size = row_size_without_normals;
  std::vector<double> values;  ///< row_size numbers per component

  std::size_t size() const { return values.size() / row_size; }
};

/// A name that the header of a file can hold and that is not among `taken`.
std::string property_name(const std::string& wanted, const std::vector<std::string>& taken);

/// The names of all columns but the scalars.
std::vector<std::string> gaussian_property_names(const Mixture& mixture);

MixtureRows to_rows(const Mixture& mixture);

/// The mixture in the given frame; sigma0 and spacing in units of the world.
Mixture from_rows(const MixtureRows& rows, const Frame& frame, double world_sigma0, double world_spacing);

}  // namespace gpsrecon::internal
