
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/scan/gallery.h>
#include <gpsrecon/scan/gyroid.h>
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <memory>
#include <ostream>
#include <regex>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

Vec3 random_point(std::uint64_t stream, std::uint64_t i, double half_width) {
  const auto coordinate = [&](std::uint64_t k) { return half_width * (2 * random_uniform(7, stream, 3 * i + k) - 1); };
  return {coordinate(0), coordinate(1), coordinate(2)};
}

struct NamedShape {
  std::string name;
  std::shared_ptr<const Shape> shape;
  int genus;
  double tolerance = 1e-13;  ///< of the distance, in bounding radii
};

void PrintTo(const NamedShape& shape, std::ostream* out) {
  *out << shape.name;
}

std::vector<NamedShape> shapes() {
  std::vector<NamedShape> list = {
      {"cylinder", std::make_shared<Lathe>(make_cylinder(1, 2)), 0},
      {"cuboid", std::make_shared<Cuboid>(Vec3(1, 2, 0.5)), 0},
      {"lens", std::make_shared<Lathe>(Profile({0, -0.8}).line_to({2, 0}).line_to({0, 0.8})), 0},
      {"ball", std::make_shared<TurnedBall>(2), 0}};
  for (const GalleryShape& shape : gallery())
    list.push_back({std::regex_replace(shape.name, std::regex("-"), "_"), make_shape(shape.name), 1 - shape.euler / 2,
                    shape.name == "gyroid" ? 1e-9 : 1e-13});
  return list;
}

class ShapeTest : public ::testing::TestWithParam<NamedShape> {
 protected:
  const Shape& shape() const { return *GetParam().shape; }
  double radius() const { return shape().bounding_radius(); }
  double tolerance() const { return GetParam().tolerance * radius(); }
};

INSTANTIATE_TEST_SUITE_P(Shapes, ShapeTest, ::testing::ValuesIn(shapes()),
                         [](const auto& instance) { return instance.param.name; });

// Together the next two tests prove the distance exact: a function that changes by no more than the way travelled is at
// most the distance from its zero set in absolute value, and a zero at just that distance makes it equal.
TEST_P(ShapeTest, DistanceIsReachedByAPointOfTheSurface) {
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const Vec3 p = random_point(0, i, 1.2 * radius());
    const ShapePoint q = shape().closest(p);
    ASSERT_NEAR(shape().distance(q.point), 0, tolerance()) << p.transpose();
    ASSERT_NEAR((p - q.point).norm(), std::abs(q.distance), tolerance()) << p.transpose();
    ASSERT_LE(q.point.norm(), radius() * (1 + 1e-13));
  }
}

TEST_P(ShapeTest, DistanceChangesNoFasterThanOneMoves) {
  for (const double step : {1.0, 1e-2, 1e-5}) {
    for (std::uint64_t i = 0; i < 20'000; ++i) {
      const Vec3 a = random_point(1, i, 1.2 * radius()), b = a + random_point(2, i, step * radius());
      ASSERT_LE(std::abs(shape().distance(a) - shape().distance(b)), (a - b).norm() + tolerance())
          << a.transpose() << " | " << b.transpose();
    }
  }
}

TEST_P(ShapeTest, GradientIsThatOfTheDistance) {
  const double h = 1e-7 * radius();
  int smooth = 0, jumps = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    // Near the surface, on both sides of it.
    const ShapePoint q = shape().closest(random_point(3, i, 1.2 * radius()));
    const Vec3 p = q.point + random_point(4, i, 0.02 * radius());
    // A convex crease at distance d bends the distance by 1/d, so differences over h are off by h/4d.
    if (std::abs(shape().distance(p)) < 1e-3 * radius()) continue;
    Vec3 difference = Vec3::Zero();
    bool jump = false;
    for (int k = 0; k < 3; ++k) {
      const ShapePoint ahead = shape().closest(p + h * Vec3::Unit(k)), behind = shape().closest(p - h * Vec3::Unit(k));
      difference[k] = (ahead.distance - behind.distance) / (2 * h);
      // Where the closest point jumps the distance has a kink: the bisector of a crease.
      jump = jump || (ahead.point - behind.point).norm() > 50 * h;
    }
    ASSERT_NEAR(shape().gradient(p).norm(), 1, 1e-6);
    if (jump) {
      ++jumps;
      continue;
    }
    ++smooth;
    ASSERT_LT((difference - shape().gradient(p)).norm(), 1e-4) << p.transpose();
    ASSERT_NEAR(difference.norm(), 1, 1e-4) << p.transpose();
  }
  EXPECT_LT(jumps, smooth / 1000);
}

TEST_P(ShapeTest, NormalLeadsAwayFromTheSurface) {
  const double step = 1e-6 * radius();
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const ShapePoint q = shape().closest(random_point(5, i, 1.2 * radius()));
    const double side = q.distance > 0 ? step : -step;
    ASSERT_NEAR(q.normal.norm(), 1, 1e-12);
    ASSERT_NEAR(shape().distance(q.point + side * q.normal), side, 1e-9 * radius()) << q.point.transpose();
  }
}

/// A solid as the union of closed cubes of a grid, those whose centre lies inside.
class Voxels {
 public:
  Voxels(const Shape& solid, int n) : n_(n), filled_(static_cast<std::size_t>(n * n * n)) {
    const double size = 2.1 * solid.bounding_radius() / n;
    for (int x = 0; x < n; ++x)
      for (int y = 0; y < n; ++y)
        for (int z = 0; z < n; ++z)
          filled_[at(x, y, z)] = solid.distance(size * (Vec3(x, y, z).array() + 0.5 - 0.5 * n).matrix()) < 0;
  }

  /// Number of connected components of the union of the filled cubes (which join wherever they touch), or of what is
  /// left (joined across faces only).
  int components(bool filled) const {
    std::vector<char> seen(filled_.size());
    std::vector<Eigen::Vector3i> stack;
    int count = 0;
    for (int x = 0; x < n_; ++x)
      for (int y = 0; y < n_; ++y)
        for (int z = 0; z < n_; ++z) {
          if (seen[at(x, y, z)] != 0 || is_filled(x, y, z) != filled) continue;
          ++count;
          stack.emplace_back(x, y, z);
          seen[at(x, y, z)] = 1;
          while (!stack.empty()) {
            const Eigen::Vector3i c = stack.back();
            stack.pop_back();
            for (int k = 0; k < 27; ++k) {
              const Eigen::Vector3i step(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
              if (!filled && step.squaredNorm() != 1) continue;
              const Eigen::Vector3i next = c + step;
              if (next.minCoeff() < 0 || next.maxCoeff() >= n_ || seen[at(next.x(), next.y(), next.z())] != 0 ||
                  is_filled(next.x(), next.y(), next.z()) != filled)
                continue;
              seen[at(next.x(), next.y(), next.z())] = 1;
              stack.push_back(next);
            }
          }
        }
    return count;
  }

  /// Vertices - edges + faces - cubes of the union.
  int euler() const {
    int sum = 0;
    // The cells of the complex have doubled coordinates 0..2n; odd ones are extended in that direction. A cell is there
    // if a cube that contains it is.
    for (int x = 0; x <= 2 * n_; ++x)
      for (int y = 0; y <= 2 * n_; ++y)
        for (int z = 0; z <= 2 * n_; ++z) {
          bool there = false;
          for (int i = (x - 1) >> 1; i <= x >> 1; ++i)
            for (int j = (y - 1) >> 1; j <= y >> 1; ++j)
              for (int k = (z - 1) >> 1; k <= z >> 1; ++k)
                there = there || (touches(x, i) && touches(y, j) && touches(z, k) && is_filled(i, j, k));
          if (there) sum += (x + y + z) % 2 == 0 ? 1 : -1;
        }
    return sum;
  }

 private:
  /// Whether the closed interval [2i, 2i + 2] contains the cell x.
  static bool touches(int x, int i) { return 2 * i <= x && x <= 2 * i + 2; }
  std::size_t at(int x, int y, int z) const {
    const auto n = static_cast<std::size_t>(n_);
    return (static_cast<std::size_t>(x) * n + static_cast<std::size_t>(y)) * n + static_cast<std::size_t>(z);
  }
  bool is_filled(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < n_ && y < n_ && z < n_ && filled_[at(x, y, z)] != 0;
  }
  int n_;
  std::vector<char> filled_;
};

TEST_P(ShapeTest, IsOnePieceOfTheStatedGenus) {
  if (!shape().is_closed()) GTEST_SKIP() << "bounds no solid";
  // The slower of the distances is asked less often; its shape has no parts as thin as others.
  const Voxels voxels(shape(), GetParam().name == "gyroid" ? 40 : 80);
  EXPECT_EQ(voxels.components(true), 1);
  EXPECT_EQ(voxels.components(false), 1);
  // Connected and without cavities: the Euler number is 1 minus the number of independent handles.
  EXPECT_EQ(voxels.euler(), 1 - GetParam().genus);
}

TEST(Shapes, AgreeWithTheirFormulas) {
  const Lathe sphere = make_sphere(1.5), torus = make_torus(2, 0.7), cylinder = make_cylinder(1, 2);
  const Cuboid cuboid(Vec3(1, 2, 0.5));
  const TurnedBall ball(2);
  const RoundedBox rounded(Vec3(1.5, 2, 1), 0.4);
  const auto box_distance = [](const auto& beyond) {
    return beyond.cwiseMax(0).matrix().norm() + std::min(beyond.maxCoeff(), 0.0);
  };
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const Vec3 p = random_point(6, i, 3);
    const double rho = std::hypot(p.x(), p.y());
    ASSERT_NEAR(sphere.distance(p), p.norm() - 1.5, 1e-14);
    ASSERT_NEAR(ball.distance(p), p.norm() - 2, 1e-14);
    ASSERT_NEAR(torus.distance(p), std::hypot(rho - 2, p.z()) - 0.7, 1e-14);
    ASSERT_NEAR(cylinder.distance(p), box_distance(Eigen::Array2d(rho - 1, std::abs(p.z()) - 2)), 1e-14);
    ASSERT_NEAR(rounded.distance(p),
                box_distance(Eigen::Array3d(p.array().abs() - Eigen::Array3d(1.1, 1.6, 0.6))) - 0.4, 1e-14);
    ASSERT_NEAR(cuboid.distance(p), box_distance(Eigen::Array3d(p.array().abs() - Eigen::Array3d(1, 2, 0.5))), 1e-14);
  }
}

TEST(Shapes, AnswerAtCentresAndOnAxes) {
  EXPECT_DOUBLE_EQ(make_sphere(1.5).distance(Vec3::Zero()), -1.5);
  EXPECT_DOUBLE_EQ(TurnedBall(2).distance(Vec3::Zero()), -2);
  EXPECT_DOUBLE_EQ(TurnedBall(2).diagonal(), Vec3(4, 4, 4).norm());
  EXPECT_DOUBLE_EQ(Cuboid(Vec3(1, 2, 0.5)).distance(Vec3::Zero()), -0.5);
  EXPECT_DOUBLE_EQ(make_torus(2, 0.7).distance(Vec3::Zero()), 1.3);
  EXPECT_DOUBLE_EQ(make_torus(2, 0.7).distance(Vec3(0, 2, 0)), -0.7);
  EXPECT_DOUBLE_EQ(make_cylinder(1, 2).distance(Vec3(0, 0, 5)), 3);
  const Lathe cone(Profile({0, -1}).line_to({1, -1}).line_to({0, 1}));
  EXPECT_LT((cone.closest(Vec3(0, 0, 2)).normal - Vec3::UnitZ()).norm(), 1e-15);  // at the apex
  EXPECT_NEAR(make_workpiece().distance(Vec3::Zero()), 9, 1e-12);                 // on the axis of the bore
}

// The same solid put together from half-spaces, balls, cylinders and a cone instead of its outline.
TEST(Workpiece, IsInsideWhereItsPartsSay) {
  const TurnedBall solid = make_workpiece();
  const Mat3 pose = (Eigen::AngleAxisd(0.5, Vec3::UnitX()) * Eigen::AngleAxisd(0.3, Vec3::UnitY())).toRotationMatrix();
  const double fillet_z = (26.0 * 26 - 13 * 13 + 31 * 31) / 62, fillet_rho = std::sqrt(26.0 * 26 - fillet_z * fillet_z);
  const auto inside = [&](const Vec3& p) {
    const double around_x = std::hypot(p.y(), p.z()), around_y = std::hypot(p.x(), p.z());
    const double around_z = std::hypot(p.x(), p.y());
    const bool ball = p.norm() < 20;
    const bool boss = around_z < 9 && p.z() < 0 && p.z() > -27;
    const bool knob = (p - Vec3(0, 0, 31)).norm() < 7;
    const bool collar = p.z() > fillet_z * 20 / 26 && p.z() < 31 + (fillet_z - 31) * 7 / 13 && around_z < fillet_rho &&
                        std::hypot(around_z - fillet_rho, p.z() - fillet_z) > 6;
    const bool bore = around_x < 9;
    const bool flat = p.y() > std::sqrt(20 * 20 - 10.5 * 10.5);
    const double rim = std::sqrt(20.0 * 20 - 7 * 7);
    const bool pit = p.y() < -12 && around_y < 7 * (-p.y() - 12) / (rim - 12);
    return (ball || boss || knob || collar) && !bore && !flat && !pit;
  };
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    const Vec3 p = random_point(7, i, 40);
    ASSERT_EQ(solid.distance(p) < 0, inside(pose.transpose() * p)) << (pose.transpose() * p).transpose();
  }
}

// The clearance is what rays advance by: more than the distance would carry them through the surface.
TEST_P(ShapeTest, ClearanceIsPositiveAndNoMoreThanTheDistance) {
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const Vec3 p = random_point(8, i, 1.2 * radius());
    const double distance = std::abs(shape().distance(p));
    ASSERT_LE(shape().clearance(p), distance + tolerance()) << p.transpose();
    if (distance > 1e-6 * radius()) {
      ASSERT_GT(shape().clearance(p), 0.01 * distance) << p.transpose();
    }
  }
}

// A ray cast into an open surface goes through its mouth: only distances of either sign would stop it.
TEST(Shapes, OpenOnesHaveNoInside) {
  const auto vase = make_shape("vase");
  EXPECT_FALSE(vase->is_closed());
  EXPECT_DOUBLE_EQ(vase->distance(Vec3::Zero()), 1);
  const std::optional<SurfaceHit> hit = vase->first_hit(Vec3(0, 0, 5), -Vec3::UnitZ());
  ASSERT_TRUE(hit);
  EXPECT_NEAR((hit->point - Vec3(0, 0, -1)).norm(), 0, 1e-9);
  EXPECT_NEAR((hit->normal + Vec3::UnitZ()).norm(), 0, 1e-9);
}

TEST(Shapes, RefuseWhatMakesNone) {
  EXPECT_THROW(Profile({1, 0}).arc_left_to({2, 0}, {0, 0}), OptionError);   // ends not equally far from the centre
  EXPECT_THROW(Profile({1, 0}).arc_right_to({0, 1}, {0, 0}), OptionError);  // three quarters of a circle
  EXPECT_THROW(Prism({Profile({1, 0}).line_to({1, 1})}, 1), OptionError);   // not closed
  EXPECT_THROW(Prism({}, 1), OptionError);
  EXPECT_THROW(RoundedBox(Vec3(1, 2, 3), 1), OptionError);
  EXPECT_THROW(Knot(0.7), OptionError);
  EXPECT_THROW(Gyroid(1, 2), OptionError);
  EXPECT_THROW(make_shape("teapot"), OptionError);
  EXPECT_THROW(TurnedBall(1).add(Vec3::UnitZ(), Profile({0.5, 0.5}).line_to({0, 0.5})), OptionError);
  EXPECT_THROW(TurnedBall(1).add(Vec3::UnitZ(), Profile({0.6, 0.8}).line_to({0.5, 0})), OptionError);
}

}  // namespace
}  // namespace gpsrecon
