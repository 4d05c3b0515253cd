#pragma once

#include <gpsrecon/core/vec.h>
#include <vector>

// Internal to lib/io: when positions may be stored as `float`.

namespace gpsrecon::internal::io {

/// True if rounding to float moves no position by more than 1e-6 of the diagonal of their bounding box.
bool float_suffices(const std::vector<Vec3>& positions);

}  // namespace gpsrecon::internal::io
