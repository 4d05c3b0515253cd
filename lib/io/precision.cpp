#include "precision.h"

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/point_cloud.h>

namespace gpsrecon::internal::io {

bool float_suffices(const std::vector<Vec3>& positions) {
  const double tolerance = 1e-6 * bounding_box_diagonal(positions);
  for (const Vec3& p : positions)
    if (!((p.cast<float>().cast<double>() - p).norm() <= tolerance)) return false;
  return true;
}

}  // namespace gpsrecon::internal::io
