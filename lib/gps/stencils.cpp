#include <gpsrecon/gps/stencils.h>

namespace gpsrecon {

StencilTable compose(const StencilTable& second, const StencilTable& first) {
  StencilTable product;
  product.columns = first.columns;
  product.masks.reserve(second.rows());
  product.offsets.reserve(second.rows() + 1);
  // Where a column lies in the row at work; an entry from an earlier row points before the row's start.
  std::vector<std::size_t> slot(first.columns, 0);
  std::vector<bool> used(first.columns, false);
  for (std::size_t r = 0; r < second.rows(); ++r) {
    const std::size_t start = product.indices.size();
    product.masks.push_back(static_cast<std::uint32_t>(start));
    const auto middle = second.row_indices(r);
    const auto outer_weights = second.row_weights(r);
    for (std::size_t j = 0; j < middle.size(); ++j) {
      const auto inner = first.row_indices(middle[j]);
      const auto inner_weights = first.row_weights(middle[j]);
      for (std::size_t k = 0; k < inner.size(); ++k) {
        const Index column = inner[k];
        if (!used[column] || slot[column] < start) {
          used[column] = true;
          slot[column] = product.indices.size();
          product.indices.push_back(column);
          product.weights.push_back(0);
        }
        product.weights[slot[column]] += outer_weights[j] * inner_weights[k];
      }
    }
    product.offsets.push_back(static_cast<std::uint32_t>(product.indices.size()));
  }
  return product;
}

}  // namespace gpsrecon
