#include <gpsrecon/core/mixture_rows.h>

#include <algorithm>
#include <cmath>

namespace gpsrecon::internal {
namespace {

// Columns of zeros stand for normals that were never computed.
bool has_normals(const MixtureRows& rows) {
  for (std::size_t s = 0; s < rows.size(); ++s)
    if (!Vec3::Map(rows.values.data() + s * rows.row_size + first_column_of_normals).isZero(0)) return true;
  return false;
}

RowLayout layout_of(const Mixture& mixture) {
  return {
      .normals = !mixture.normals.empty(), .kernels = !mixture.kernels.empty(), .outward = !mixture.outward.empty()};
}

}  // namespace

std::vector<std::size_t> RowLayout::columns() const {
  std::vector<std::size_t> places;
  for (std::size_t c = 0; c < mixture_column_count; ++c) {
    const bool there = c < first_column_of_normals   ? true
                       : c < first_column_of_kernels ? normals
                       : c < first_column_of_outward ? kernels
                                                     : outward;
    if (there) places.push_back(c);
  }
  return places;
}

MixtureRows::MixtureRows(const RowLayout& given, std::size_t count)
    : layout(given), row_size(given.columns().size()), values(row_size * count) {}

std::vector<std::string> gaussian_property_names(const Mixture& mixture) {
  std::vector<std::string> names;
  for (const std::size_t c : layout_of(mixture).columns()) names.emplace_back(mixture_columns[c]);
  if (!mixture.colors.empty()) names.insert(names.end(), {"red", "green", "blue"});
  return names;
}

MixtureRows to_rows(const Mixture& mixture) {
  MixtureRows rows(layout_of(mixture), mixture.size());
  // Scaling by a power of two is exact, so covariances come back bit for bit.
  const double area = std::ldexp(1.0, 2 * mixture.frame.exponent);
  double* row = rows.values.data();
  for (std::size_t s = 0; s < mixture.size(); ++s, row += rows.row_size) {
    const Vec3 mean = mixture.frame.to_world(mixture.means[s]);
    const Sym3 cov = mixture.covariances[s] * area;
    const double numbers[] = {mean.x(), mean.y(), mean.z(), cov.xx, cov.xy,
                              cov.xz,   cov.yy,   cov.yz,   cov.zz, mixture.weights[s]};
    double* next = std::copy(std::begin(numbers), std::end(numbers), row);
    // A wrapped normal in three numbers: the axis, as long as its angular variance plus one.
    if (rows.layout.normals) {
      Vec3::Map(next) = (mixture.normal_variances[s] + 1) * mixture.normals[s];
      next += 3;
    }
    if (rows.layout.kernels) *next++ = std::ldexp(mixture.kernels[s], mixture.frame.exponent);
    if (rows.layout.outward) Vec3::Map(next) = mixture.outward[s];
  }
  return rows;
}

Mixture from_rows(const MixtureRows& rows, const Frame& frame, double world_sigma0, double world_spacing) {
  Mixture mixture;
  mixture.frame = frame;
  mixture.sigma0 = std::ldexp(world_sigma0, -frame.exponent);
  mixture.spacing = std::ldexp(world_spacing, -frame.exponent);
  const std::size_t n = rows.size();
  mixture.means.resize(n);
  mixture.covariances.resize(n);
  mixture.weights.resize(n);
  const bool with_normals = rows.layout.normals && has_normals(rows);
  if (with_normals) {
    mixture.normals.resize(n);
    mixture.normal_variances.resize(n);
  }
  if (rows.layout.kernels) mixture.kernels.resize(n);
  if (rows.layout.outward) mixture.outward.resize(n);
  const double area = std::ldexp(1.0, -2 * frame.exponent);
  const double* row = rows.values.data();
  for (std::size_t s = 0; s < n; ++s, row += rows.row_size) {
    mixture.means[s] = frame.to_local({row[0], row[1], row[2]});
    mixture.covariances[s] = Sym3{row[3], row[4], row[5], row[6], row[7], row[8]} * area;
    mixture.weights[s] = row[9];
    if (with_normals) {
      const Vec3 scaled = Vec3::Map(row + first_column_of_normals);
      const double length = scaled.norm();
      mixture.normals[s] = scaled / length;
      mixture.normal_variances[s] = std::max(0.0, length - 1);
    }
    const double* next = row + first_column_of_normals + (rows.layout.normals ? 3 : 0);
    if (rows.layout.kernels) mixture.kernels[s] = std::ldexp(*next++, -frame.exponent);
    if (rows.layout.outward) mixture.outward[s] = Vec3::Map(next);
  }
  return mixture;
}

std::string property_name(const std::string& wanted, const std::vector<std::string>& taken) {
  std::string name = wanted.empty() ? "scalar" : wanted;
  for (char& c : name)
    if (static_cast<unsigned char>(c) <= ' ' || c == '\x7f') c = '_';
  while (std::find(taken.begin(), taken.end(), name) != taken.end()) name += '_';
  return name;
}

}  // namespace gpsrecon::internal

namespace gpsrecon {

using namespace internal;

Mixture as_stored(const Mixture& mixture) {
  const double world_sigma0 = std::ldexp(mixture.sigma0, mixture.frame.exponent);
  const double world_spacing = std::ldexp(mixture.spacing, mixture.frame.exponent);
  Mixture stored = from_rows(to_rows(mixture), mixture.frame, world_sigma0, world_spacing);
  stored.colors = mixture.colors;
  stored.scalars = mixture.scalars;
  std::vector<std::string> taken = gaussian_property_names(mixture);
  for (ScalarColumn& column : stored.scalars) taken.push_back(column.name = property_name(column.name, taken));
  return stored;
}

}  // namespace gpsrecon
