#pragma once

#include <gpsrecon/core/frame.h>
#include <gpsrecon/core/vec.h>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace gpsrecon {

using Color = std::array<std::uint8_t, 3>;  ///< red, green, blue, 0..255

/// A named column of one number per point or vertex (intensity, classification, ...).
struct ScalarColumn {
  std::string name;
  std::vector<double> values;
};

/// Points with optional attributes. Every attribute is either empty or as long as `positions`.
struct PointCloud {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;
  std::vector<Color> colors;
  std::vector<double> weights;  ///< number of coincident input points each stands for; empty means 1 each
  std::vector<Vec3> sensors;    ///< where the sensor stood for each point (columns sx sy sz)
  std::vector<ScalarColumn> scalars;
  Frame frame;  ///< the frame the positions (and sensors) are given in

  std::size_t size() const { return positions.size(); }
  bool empty() const { return positions.empty(); }
  double weight(std::size_t i) const { return weights.empty() ? 1.0 : weights[i]; }
};

/// Throws InvariantError, naming the attribute and the first offending index, unless all attributes have the length of
/// `positions` and all positions are finite and all weights positive. O(n).
void validate(const PointCloud& cloud);

/// Length of the diagonal of the axis-aligned bounding box, in the units of `positions`; 0 for an empty range.
double bounding_box_diagonal(const std::vector<Vec3>& positions);

/// The points `keep` (indices into the cloud, in the wanted order) with all their attributes.
PointCloud select(const PointCloud& cloud, const std::vector<Index>& keep);

}  // namespace gpsrecon
