#pragma once

#include <gpsrecon/core/mixture.h>
#include <iterator>
#include <string>
#include <vector>

// The rows in which files hold a mixture, in world coordinates:
// x y z covxx covxy covxz covyy covyz covzz weight [nvx nvy nvz] [kernel] [outx outy outz].

namespace gpsrecon::internal {

inline constexpr const char* mixture_columns[] = {"x",     "y",      "z",     "covxx",  "covxy", "covxz",
                                                  "covyy", "covyz",  "covzz", "weight", "nvx",   "nvy",
                                                  "nvz",   "kernel", "outx",  "outy",   "outz"};
inline constexpr std::size_t mixture_column_count = std::size(mixture_columns);
inline constexpr std::size_t first_column_of_normals = 10, first_column_of_kernels = 13, first_column_of_outward = 14;

/// Which of the columns there are.
struct RowLayout {
  bool normals = false, kernels = false, outward = false;

  /// The columns, as places in mixture_columns.
  std::vector<std::size_t> columns() const;
};

struct MixtureRows {
  RowLayout layout;
  std::size_t row_size = first_column_of_normals;
  std::vector<double> values;  ///< row_size numbers per component

  explicit MixtureRows(const RowLayout& given, std::size_t count);
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
