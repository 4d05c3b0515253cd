#pragma once

#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/scan/shapes.h>
#include <memory>

namespace gpsrecon::internal {

/// One labyrinth of the gyroid (Schoen 1970) inside a ball, all edges rounded: the solid f < 0 with the smooth maximum
/// f = (a + b + sqrt((a - b)² + w²)) / 2 of a = (sin x cos y + sin y cos z + sin z cos x) / √3 and b = (|p|² - R²) /
/// 2R. |∇f| <= 1 in the ball. Closest points are found from samples of the surface by Newton's method on f(q) = 0, p -
/// q ∥ ∇f(q); distances are within 1e-9 radii of the exact ones.
class Gyroid final : public Shape {
 public:
  /// The period of the gyroid is 2π. Throws OptionError unless both are positive and the rounding is below the radius.
  Gyroid(double ball_radius, double rounding);
  ShapePoint closest(const Vec3& p) const override;
  Mesh mesh(double tolerance) const override;
  /// |f|, over the largest gradient on the way.
  double clearance(const Vec3& p) const override;
  double bounding_radius() const override { return ball_radius_; }
  double diagonal() const override { return diagonal_; }

 private:
  struct Value;
  Value evaluate(const Vec3& p) const;
  double value(const Vec3& p) const;
  Vec3 on_surface(Vec3 p) const;
  Mesh net(double cell) const;
  Vec3 refine(const Vec3& p, const Vec3& start) const;

  double ball_radius_, rounding_, diagonal_;
  double curvature_;  ///< largest principal curvature at a sample
  std::vector<Vec3> samples_;
  std::unique_ptr<Neighbors> nearest_sample_;
};

}  // namespace gpsrecon::internal
