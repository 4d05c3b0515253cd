// Preiner et al. 2019, section 5: what the shape of a covariance does to the surface; section 7.1: modelling with it.

#include <gpsrecon/gps/edit.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/parallel.h>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace gpsrecon {

using namespace internal;
namespace {

/// Eigenvalues this close, relative to the largest, have no eigenvectors of their own.
constexpr double equal_eigenvalues = 1e-9;
/// Traces outside of [1 / this, this] are too near the end of the range of numbers to be inverted.
constexpr double largest_trace = 1e280;

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

// ---- checks of what does not depend on the mesh ----

void check_factor(const char* field, double factor) {
  if (!(factor >= 1e-12 && factor <= 1e12))
    throw OptionError(std::string(field) + ": " + to_text(factor) + " is not in [1e-12, 1e12]");
}

void check_direction(const char* field, const Vec3& direction) {
  if (!direction.allFinite() || direction.isZero(0))
    throw OptionError(std::string(field) + ": " + to_text(direction) + " is not a direction");
}

void check_kernel(const char* field, const Sym3& kernel) {
  const bool finite = kernel.all_finite();
  const Vec3 values = finite ? eigen_decomposition(kernel).values : Vec3::Zero();
  if (!finite || values[0] < -min_eigenvalue_ratio * std::abs(values[2]))
    throw OptionError(std::string(field) + ": is not a covariance (finite, no variance below zero)");
}

void check_selection(const VertexSelection& selection) {
  std::visit(Overloaded{[](const SelectAll&) {},
                        [](const SelectIndices& s) {
                          if (s.ranges.empty()) throw OptionError("select indices: is an empty list");
                          for (const auto& [first, last] : s.ranges)
                            if (first > last)
                              throw OptionError("select indices: " + std::to_string(first) + " is above " +
                                                std::to_string(last));
                        },
                        [](const SelectBox& s) {
                          if (!(s.low.array() <= s.high.array()).all())
                            throw OptionError("select box: " + to_text(s.low) + " is not below " + to_text(s.high) +
                                              " in every axis");
                        },
                        [](const SelectHalfSpace& s) {
                          check_direction("select plane: normal", s.normal);
                          if (!s.point.allFinite())
                            throw OptionError("select plane: point: " + to_text(s.point) + " is not finite");
                        },
                        [](const SelectNearest& s) {
                          if (s.count == 0) throw OptionError("select nearest: count: 0 is not at least 1");
                          if (!s.point.allFinite())
                            throw OptionError("select nearest: point: " + to_text(s.point) + " is not finite");
                        }},
             selection);
}

void check_operation(const CovarianceOperation& operation) {
  std::visit(Overloaded{[](const ScaleCovariance& o) { check_factor("scale: factor", o.factor); },
                        [](const FlattenCovariance& o) {
                          check_factor("flatten: factor", o.factor);
                          if (o.axis == Axis::given) check_direction("flatten: direction", o.direction);
                        },
                        [](const SmoothCovariance& o) { check_kernel("smooth: kernel", o.kernel); },
                        [](const SharpenCovariance& o) {
                          check_kernel("sharpen: kernel", o.kernel);
                          if (!(o.floor >= min_eigenvalue_ratio && o.floor <= 1))
                            throw OptionError("sharpen: floor: " + to_text(o.floor) + " is not in [1e-12, 1]");
                        },
                        [](const SetCovariance& o) {
                          const bool finite = o.covariance.all_finite();
                          const Vec3 values = finite ? eigen_decomposition(o.covariance).values : Vec3::Zero();
                          if (!(values[2] > 0) || values[0] < min_eigenvalue_ratio * values[2])
                            throw OptionError(
                                "set: covariance: is not positive definite (finite, smallest eigenvalue at least 1e-12 "
                                "times the largest)");
                        }},
             operation);
}

// ---- selections ----

template <class Keep>
std::vector<Index> vertices_where(const Mixture& vertices, const Keep& keep) {
  std::vector<Index> selected;
  for (Index v = 0; v < vertices.size(); ++v)
    if (keep(vertices.frame.to_world(vertices.means[v]))) selected.push_back(v);
  return selected;
}

std::vector<Index> listed(const Mixture& vertices, const SelectIndices& s) {
  std::vector<char> in_list(vertices.size(), 0);
  for (const auto& [first, last] : s.ranges) {
    if (last >= vertices.size())
      throw OptionError("select indices: there is no vertex " + std::to_string(last) + " among " +
                        std::to_string(vertices.size()) + ", counted from 0");
    std::fill(in_list.begin() + first, in_list.begin() + last + 1, 1);
  }
  std::vector<Index> selected;
  for (Index v = 0; v < in_list.size(); ++v)
    if (in_list[v] != 0) selected.push_back(v);
  return selected;
}

std::vector<Index> nearest(const Mixture& vertices, const SelectNearest& s) {
  if (s.count > vertices.size())
    throw OptionError("select nearest: count: " + std::to_string(s.count) + " is more than the " +
                      std::to_string(vertices.size()) + " vertices");
  const Vec3 point = vertices.frame.to_local(s.point);
  std::vector<std::pair<double, Index>> order(vertices.size());
  for (Index v = 0; v < order.size(); ++v) order[v] = {(vertices.means[v] - point).squaredNorm(), v};
  const auto end = order.begin() + static_cast<std::ptrdiff_t>(s.count);
  std::nth_element(order.begin(), end - 1, order.end());
  std::vector<Index> selected;
  for (auto entry = order.begin(); entry != end; ++entry) selected.push_back(entry->second);
  std::sort(selected.begin(), selected.end());
  return selected;
}

// ---- operations, in local units ----

/// The operation with its lengths divided by `scale` (a power of two).
CovarianceOperation in_local_units(CovarianceOperation operation, double scale) {
  const double variances = 1 / (scale * scale);
  std::visit(Overloaded{[](ScaleCovariance&) {}, [](FlattenCovariance&) {},
                        [&](SmoothCovariance& o) { o.kernel *= variances; },
                        [&](SharpenCovariance& o) { o.kernel *= variances; },
                        [&](SetCovariance& o) { o.covariance *= variances; }},
             operation);
  return operation;
}

struct Edited {
  Sym3 covariance;
  bool floored = false, ambiguous_axis = false;
};

/// Raises eigenvalues to `floor` and keeps the eigenvectors.
void raise_eigenvalues(Edited& result, double floor) {
  const Eigen3 e = eigen_decomposition(result.covariance);
  if (e.values[0] >= floor) return;
  result.covariance = {};
  for (int k = 0; k < 3; ++k) result.covariance += std::max(e.values[k], floor) * Sym3::outer(e.vectors.col(k));
  result.floored = true;
}

Edited flatten(const Sym3& covariance, const FlattenCovariance& o) {
  Edited result;
  Vec3 axis = o.direction.stableNormalized();
  if (o.axis != Axis::given) {
    const Eigen3 e = eigen_decomposition(covariance);
    const int chosen = static_cast<int>(o.axis);
    axis = e.vectors.col(chosen);
    for (int other = 0; other < 3; ++other)
      if (other != chosen && std::abs(e.values[other] - e.values[chosen]) <= equal_eigenvalues * e.values[2])
        result.ambiguous_axis = true;
  }
  const Mat3 squeeze = Mat3::Identity() + (std::sqrt(o.factor) - 1) * axis * axis.transpose();
  result.covariance = congruence(squeeze, covariance);
  return result;
}

Edited sharpen(const Sym3& covariance, const SharpenCovariance& o) {
  Edited result{covariance - o.kernel};
  raise_eigenvalues(result, o.floor * eigen_decomposition(covariance).values[2]);
  return result;
}

Edited operate(const CovarianceOperation& operation, const Sym3& covariance) {
  Edited result = std::visit(Overloaded{[&](const ScaleCovariance& o) { return Edited{o.factor * covariance}; },
                                        [&](const FlattenCovariance& o) { return flatten(covariance, o); },
                                        [&](const SmoothCovariance& o) { return Edited{covariance + o.kernel}; },
                                        [&](const SharpenCovariance& o) { return sharpen(covariance, o); },
                                        [&](const SetCovariance& o) { return Edited{o.covariance}; }},
                             operation);
  const Sym3 valid = floor_eigenvalues(result.covariance, min_eigenvalue_ratio);
  result.floored = result.floored || valid != result.covariance;
  result.covariance = valid;
  return result;
}

EditCounts run_step(Mixture& vertices, const EditStep& step, const RunContext& context) {
  const std::vector<Index> selected = selected_vertices(vertices, step.selection);
  const CovarianceOperation operation = in_local_units(step.operation, vertices.frame.scale());
  std::vector<Edited> edited(selected.size());
  parallel_for(selected.size(), context,
               [&](std::size_t i) { edited[i] = operate(operation, vertices.covariances[selected[i]]); });
  EditCounts counts;
  counts.selected = selected.size();
  for (std::size_t i = 0; i < selected.size(); ++i) {
    const double trace = edited[i].covariance.trace();
    if (!(trace >= 1 / largest_trace && trace <= largest_trace))
      throw OptionError("the covariance of vertex " + std::to_string(selected[i]) + " leaves the range of numbers");
    vertices.covariances[selected[i]] = edited[i].covariance;
    counts.floored += edited[i].floored ? 1 : 0;
    counts.ambiguous_axes += edited[i].ambiguous_axis ? 1 : 0;
  }
  return counts;
}

}  // namespace

void EditStep::check() const {
  check_selection(selection);
  check_operation(operation);
}

std::vector<Index> selected_vertices(const Mixture& vertices, const VertexSelection& selection) {
  check_selection(selection);
  std::vector<Index> selected = std::visit(
      Overloaded{[&](const SelectAll&) {
                   std::vector<Index> all(vertices.size());
                   std::iota(all.begin(), all.end(), Index{0});
                   return all;
                 },
                 [&](const SelectIndices& s) { return listed(vertices, s); },
                 [&](const SelectBox& s) {
                   return vertices_where(vertices, [&](const Vec3& p) {
                     return (p.array() >= s.low.array()).all() && (p.array() <= s.high.array()).all();
                   });
                 },
                 [&](const SelectHalfSpace& s) {
                   const Vec3 normal = s.normal.stableNormalized();
                   return vertices_where(vertices, [&](const Vec3& p) { return normal.dot(p - s.point) >= 0; });
                 },
                 [&](const SelectNearest& s) { return nearest(vertices, s); }},
      selection);
  if (selected.empty()) throw OptionError("select: there is no vertex in it");
  return selected;
}

Edit edit(CovMesh mesh, const std::vector<EditStep>& steps, const RunContext& context) {
  validate(mesh);
  Edit result;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    try {
      steps[i].check();
      result.steps.push_back(run_step(mesh.vertices, steps[i], context));
    } catch (const OptionError& error) {
      throw OptionError("step " + std::to_string(i + 1) + ": " + error.what());
    }
  }
  validate(mesh);
  result.mesh = std::move(mesh);
  return result;
}

}  // namespace gpsrecon
