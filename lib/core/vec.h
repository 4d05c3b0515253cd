#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace gpsrecon {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

/// Index of a vertex, component, face or point. 2^32 - 1 marks "none".
using Index = std::uint32_t;
inline constexpr Index no_index = 0xFFFFFFFFu;

}  // namespace gpsrecon
