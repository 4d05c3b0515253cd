#pragma once

#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/vec.h>
#include <gpsrecon/gps/surface_weights.h>
#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
#include <type_traits>
#include <vector>

namespace gpsrecon::internal {

/// Where the weights of a row lie among those of all kinds of rows.
struct Mask {
  std::uint32_t begin = 0, length = 0;
};

/// Weights of the rows of a map, each kind once.
template <class Weight>
class MaskStore {
 public:
  std::span<const Weight> weights(const Mask& mask) const { return {weights_.data() + mask.begin, mask.length}; }
  const std::vector<Weight>& weights() const { return weights_; }
  std::size_t longest() const { return longest_; }
  Mask add(std::span<const Weight> mask) {
    const Mask range{static_cast<std::uint32_t>(weights_.size()), static_cast<std::uint32_t>(mask.size())};
    weights_.resize(range.begin + mask.size());
    std::copy(mask.begin(), mask.end(), weights_.data() + range.begin);
    longest_ = std::max(longest_, mask.size());
    return range;
  }
  /// The masks of one kind, by a number such as the valence: add(make(count)) where `counts` has it, else empty.
  template <class Make>
  std::vector<Mask> add_by_count(std::span<const Index> counts, const Make& make) {
    std::vector<Mask> by_count;
    for (const Index count : counts) {
      if (count >= by_count.size()) by_count.resize(count + std::size_t{1});
      if (by_count[count].length == 0) by_count[count] = add(make(count));
    }
    return by_count;
  }

 private:
  std::vector<Weight> weights_;
  std::size_t longest_ = 0;
};

/// Rows that are worked out from connectivity when they are needed, instead of being stored.
template <class Rows>
concept RowSource = requires(const Rows& source, std::size_t r, std::span<Index> indices) {
  typename Rows::Weight;
  { source.columns() } -> std::convertible_to<std::size_t>;
  { source.rows() } -> std::convertible_to<std::size_t>;
  { source.masks() } -> std::convertible_to<const MaskStore<typename Rows::Weight>&>;
  { source.mask(r) } -> std::convertible_to<Mask>;
  source.fill(r, indices);  // as many as the mask is long
};

/// Row r of a map. `room` is for the indices of rows that are not stored: longest_row(rows) of them.
template <class Weight>
Row<Weight> read_row(const Stencils<Weight>& table, std::size_t r, Index*) {
  return table.row(r);
}
template <RowSource Rows>
Row<typename Rows::Weight> read_row(const Rows& source, std::size_t r, Index* room) {
  const Mask mask = source.mask(r);
  const std::span<Index> indices(room, mask.length);
  source.fill(r, indices);
  return {indices, source.masks().weights(mask)};
}
template <class Weight>
std::size_t column_count(const Stencils<Weight>& table) {
  return table.columns;
}
template <RowSource Rows>
std::size_t column_count(const Rows& source) {
  return source.columns();
}
template <class Weight>
std::size_t longest_row(const Stencils<Weight>&) {
  return 0;
}
template <RowSource Rows>
std::size_t longest_row(const Rows& source) {
  return source.masks().longest();
}

/// Calls body(r, row) for the rows from `begin` to `end`. Rows are read some ahead and their values fetched: they lie
/// all over memory, and waiting for them would take half the time.
template <class T, class Rows, class Values, class Body>
void for_each_row(const Rows& rows, std::size_t begin, std::size_t end, const Values& values, const Body& body) {
  constexpr std::size_t ahead = 16, cache_line = 64;
  const std::size_t longest = longest_row(rows);
  std::vector<Index> room(ahead * longest);
  std::array<Row<typename Rows::Weight>, ahead> waiting;
  for (std::size_t first = begin; first < end; first += ahead) {
    const std::size_t count = std::min(ahead, end - first);
    for (std::size_t k = 0; k < count; ++k) {
      waiting[k] = read_row(rows, first + k, room.data() + k * longest);
      for (const Index i : waiting[k].indices) {
        const char* const value = reinterpret_cast<const char*>(&values[i]);
        for (std::size_t byte = 0; byte < sizeof(T); byte += cache_line) __builtin_prefetch(value + byte);
        __builtin_prefetch(value + sizeof(T) - 1);
      }
    }
    for (std::size_t k = 0; k < count; ++k) body(first + k, waiting[k]);
  }
}

/// The rows, stored. O(entries).
template <RowSource Rows>
Stencils<typename Rows::Weight> tabulate(const Rows& source, const RunContext& context = {}) {
  Stencils<typename Rows::Weight> table;
  table.columns = source.columns();
  table.weights = source.masks().weights();
  table.masks.resize(source.rows());
  table.offsets.resize(source.rows() + 1);
  parallel_for(source.rows(), context, [&](std::size_t r) {
    const Mask mask = source.mask(r);
    table.masks[r] = mask.begin;
    table.offsets[r + 1] = mask.length;
  });
  std::partial_sum(table.offsets.begin(), table.offsets.end(), table.offsets.begin());
  table.indices.resize(table.offsets.back());
  parallel_for(source.rows(), context, [&](std::size_t r) {
    const std::size_t begin = table.offsets[r];
    source.fill(r, {table.indices.data() + begin, table.offsets[r + 1] - begin});
  });
  return table;
}

/// Scalar weights: one refinement step, or limit positions alone.
using StencilTable = Stencils<double>;

/// Weights of the limit position and of two tangents u, v of the limit surface, with u × v on the outer side.
struct LimitWeight {
  double position, u, v;
};
using LimitTable = Stencils<LimitWeight>;

namespace detail {
template <class T>
T zero() {
  if constexpr (std::is_arithmetic_v<T>) {
    return T{0};
  } else {
    return T::Zero();
  }
}
}  // namespace detail

/// Σ_j weight_j values[index_j]. `part` picks the scalar out of a weight (&LimitWeight::u, ...).
template <class T, class Weight, class Values, class Part = std::identity>
T apply_row(const Row<Weight>& row, const Values& values, Part part = {}) {
  T sum = detail::zero<T>();
  for (std::size_t j = 0; j < row.indices.size(); ++j)
    sum += std::invoke(part, row.weights[j]) * values[row.indices[j]];
  return sum;
}

/// out = S values, for numbers or fixed-size Eigen vectors, in parallel; S stored or not.
/// Precondition: values.size() == columns, out.size() == rows.
template <class T, class Rows, class Values, class Part = std::identity>
void apply(const Rows& rows, const Values& values, std::span<T> out, const RunContext& context = {}, Part part = {}) {
  parallel_blocks(rows.rows(), context, [&](std::size_t, std::size_t begin, std::size_t end) {
    for_each_row<T>(rows, begin, end, values, [&](std::size_t r, const Row<typename Rows::Weight>& row) {
      out[r] = apply_row<T>(row, values, part);
    });
  });
}

/// out += Sᵀ values, summed in the order of the rows.
/// Precondition: values.size() == rows, out.size() == columns.
template <class T, class Weight, class Part = std::identity>
void add_transposed(const Stencils<Weight>& table, std::span<const std::type_identity_t<T>> values, std::span<T> out,
                    Part part = {}) {
  for (std::size_t r = 0; r < table.rows(); ++r) {
    const Row<Weight> row = table.row(r);
    for (std::size_t j = 0; j < row.indices.size(); ++j)
      out[row.indices[j]] += std::invoke(part, row.weights[j]) * values[r];
  }
}

/// Two arrays as one.
template <class T>
struct JoinedValues {
  std::span<const T> first, second;
  const T& operator[](std::size_t i) const { return i < first.size() ? first[i] : second[i - first.size()]; }
};

/// One refinement step of a scheme: the points of the faces from the old vertices, where the scheme has such points,
/// and from the old vertices followed by those points the other new vertices. In the order of new vertices the points
/// of the faces are the last.
template <class FaceRows, class PointRows>
struct RefinementStep {
  FaceRows faces;
  PointRows points;

  std::size_t new_vertices() const { return points.rows() + faces.rows(); }
};

/// Values at the new vertices. `room` more are reserved for what comes after them.
template <class T, class FaceRows, class PointRows>
std::vector<T> refine_values(const RefinementStep<FaceRows, PointRows>& step, std::span<const T> values,
                             const RunContext& context, std::size_t room = 0) {
  std::vector<T> refined;
  refined.reserve(step.new_vertices() + room);
  refined.resize(step.new_vertices());
  const std::span<T> points = std::span<T>(refined).first(step.points.rows());
  const std::span<T> faces = std::span<T>(refined).subspan(step.points.rows());
  if (faces.empty()) {
    apply<T>(step.points, values, points, context);
  } else {
    apply<T>(step.faces, values, faces, context);
    apply<T>(step.points, JoinedValues<T>{values, faces}, points, context);
  }
  return refined;
}

/// The transpose of refine_values.
template <class T>
std::vector<T> coarsen_values(const RefinementStep<StencilTable, StencilTable>& step, std::span<const T> values) {
  const std::size_t old = step.faces.columns;
  std::vector<T> coarse(step.points.columns, detail::zero<T>());
  add_transposed<T>(step.points, values.first(step.points.rows()), coarse);
  for (std::size_t f = 0; f < step.faces.rows(); ++f) coarse[old + f] += values[step.points.rows() + f];
  const std::span<T> all(coarse);
  add_transposed<T>(step.faces, all.subspan(old), all.first(old));
  coarse.resize(old);
  return coarse;
}

}  // namespace gpsrecon::internal
