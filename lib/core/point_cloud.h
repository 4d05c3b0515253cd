#pragma once

#include <gpsrecon/core/frame.h>
#include <gpsrecon/core/vec.h>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace gpsrecon {

using Color = std::array<std::uint8_t, 3>;  ///< red, green, blue, 0..255

/// How the numbers of several points become one.
enum class ScalarKind {
  quantity,  ///< intensity, temperature, ...: by their average
  label,     ///< classification, segment, ...: by majority; numbers that are not among those given never arise
};

/// A named column of one number per point or vertex. Numbers for which is_missing() count for nothing.
struct ScalarColumn {
  std::string name;
  std::vector<double> values;
  ScalarKind kind = ScalarKind::quantity;
};

/// True for what stands for "not measured": NaN, infinities, and numbers of the size of the largest float, which some
/// programs write in their place.
bool is_missing(double value);

/// True if all numbers of the column, missing ones aside, are whole, as those of labels are.
bool is_whole(const ScalarColumn& column);

/// Makes the columns named in `labels` (without regard to case) labels. Throws OptionError, naming it, if there is no
/// such column or it holds a number that is not whole.
void mark_labels(std::vector<ScalarColumn>& columns, const std::vector<std::string>& labels);

/// Replaces `no_data` (compared as float, for columns that were stored as such) by NaN in all columns.
void mark_missing(std::vector<ScalarColumn>& columns, double no_data);

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

/// The points `keep` (indices into the cloud, in the wanted order) with all their attributes.
PointCloud select(const PointCloud& cloud, const std::vector<Index>& keep);

}  // namespace gpsrecon
