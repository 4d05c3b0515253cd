#pragma once

#include <gpsrecon/core/parallel.h>
#include <gpsrecon/core/vec.h>
#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

namespace gpsrecon {

/// A sparse linear map from old vertices (columns) to new ones (rows). Row r has the columns
/// indices[offsets[r] .. offsets[r + 1]) with as many weights from weights[masks[r]] on: rows of one kind share their
/// weights, because a subdivision scheme has only one mask per valence. A column may occur twice in a row.
template <class Weight>
struct Stencils {
  std::size_t columns = 0;
  std::vector<std::uint32_t> offsets{0};
  std::vector<Index> indices;
  std::vector<std::uint32_t> masks;
  std::vector<Weight> weights;

  std::size_t rows() const { return masks.size(); }
  std::span<const Index> row_indices(std::size_t r) const {
    return {indices.data() + offsets[r], indices.data() + offsets[r + 1]};
  }
  std::span<const Weight> row_weights(std::size_t r) const {
    return {weights.data() + masks[r], offsets[r + 1] - offsets[r]};
  }
  /// Appends weights that rows can share; returns where they begin.
  std::uint32_t add_mask(std::span<const Weight> mask) {
    const std::size_t begin = weights.size();
    weights.resize(begin + mask.size());
    std::copy(mask.begin(), mask.end(), weights.data() + begin);
    return static_cast<std::uint32_t>(begin);
  }
  /// Appends a row of `length` entries with the weights from `mask` on; its indices are the caller's to fill.
  void add_row(std::uint32_t mask, std::size_t length) {
    masks.push_back(mask);
    offsets.push_back(static_cast<std::uint32_t>(offsets.back() + length));
  }
  std::span<Index> row_indices(std::size_t r) { return {indices.data() + offsets[r], indices.data() + offsets[r + 1]}; }
};

/// The shared masks of one kind of vertex, one per number of faces around it, made when first needed.
class MasksByCount {
 public:
  explicit MasksByCount(std::span<const Index> counts)
      : begin_(counts.empty() ? 0 : *std::max_element(counts.begin(), counts.end()) + std::size_t{1}, no_index) {}
  template <class Make>
  std::uint32_t find_or_add(Index count, const Make& make) {
    if (begin_[count] == no_index) begin_[count] = make();
    return begin_[count];
  }

 private:
  std::vector<std::uint32_t> begin_;
};

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

/// Σ_j weight_j values[index_j] of row r. `part` picks the scalar out of a weight (&LimitWeight::u, ...).
template <class T, class Weight, class Part = std::identity>
T apply_row(const Stencils<Weight>& table, std::size_t r, std::span<const T> values, Part part = {}) {
  const auto indices = table.row_indices(r);
  const auto weights = table.row_weights(r);
  T sum = detail::zero<T>();
  for (std::size_t j = 0; j < indices.size(); ++j) sum += std::invoke(part, weights[j]) * values[indices[j]];
  return sum;
}

/// out = S values, for numbers or fixed-size Eigen vectors, in parallel.
/// Precondition: values.size() == columns, out.size() == rows.
template <class T, class Weight, class Part = std::identity>
void apply(const Stencils<Weight>& table, std::span<const std::type_identity_t<T>> values, std::span<T> out,
           const RunContext& context = {}, Part part = {}) {
  parallel_for(table.rows(), context, [&](std::size_t r) { out[r] = apply_row<T>(table, r, values, part); });
}

/// out = Sᵀ values, summed in the order of the rows.
/// Precondition: values.size() == rows, out.size() == columns.
template <class T, class Weight, class Part = std::identity>
void apply_transposed(const Stencils<Weight>& table, std::span<const std::type_identity_t<T>> values, std::span<T> out,
                      Part part = {}) {
  std::fill(out.begin(), out.end(), detail::zero<T>());
  for (std::size_t r = 0; r < table.rows(); ++r) {
    const auto indices = table.row_indices(r);
    const auto weights = table.row_weights(r);
    for (std::size_t j = 0; j < indices.size(); ++j) out[indices[j]] += std::invoke(part, weights[j]) * values[r];
  }
}

/// The table of `second` after `first`, with every column once per row. O(sum of the products of row lengths).
/// Precondition: second.columns == first.rows.
StencilTable compose(const StencilTable& second, const StencilTable& first);

}  // namespace gpsrecon
