#include <gpsrecon/measure/held_out_error.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/meshes.h"
#include "support/shapes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

/// The triangles of level 7 lie this far inside the sphere, on average.
constexpr double chord = 4e-5;

std::vector<Vec3> sphere_points(double radius, double noise, std::uint64_t seed = 1) {
  SampledShape s = random_sphere(20000, seed, radius);
  add_noise(s, noise, seed + 1);
  return s.points;
}

TEST(HeldOutError, IsThatOfTheSurfaceWhateverTheNoise) {
  const Mesh mesh = sphere(7);
  for (const double radius : {0.98, 1.0, 1.03})
    for (const double noise : {0.0, 0.01, 0.04}) {
      const HeldOutError e = held_out_error(mesh, sphere_points(radius, noise));
      const double wanted = (radius - 1) * (radius - 1);
      EXPECT_NEAR(e.mean_square, wanted, 4 * e.standard_error + 2 * chord * (std::abs(radius - 1) + chord))
          << radius << " " << noise;
      EXPECT_NEAR(e.bound() * e.bound(), std::max(0.0, e.mean_square) + e.standard_error, 1e-15);
      EXPECT_GT(e.pairs, 10000u);
      // Products of two independent normal offsets deviate by the variance.
      if (radius == 1 && noise > 0) {
        EXPECT_NEAR(e.standard_error * std::sqrt(static_cast<double>(e.pairs)) / (noise * noise), 1, 0.1);
      }
    }
}

TEST(HeldOutError, DoesNotTakeOutliersForErrors) {
  std::vector<Vec3> points = sphere_points(1.02, 0.01);
  const double before = held_out_error(sphere(5), points).bound();
  Random random(5);
  for (int i = 0; i < 400; ++i) points.push_back(random.uniform(1.2, 3) * random.direction());
  EXPECT_NEAR(held_out_error(sphere(5), points).bound(), before, 0.1 * before);
}

// What lies together beyond the surface is no outlier: there the surface is wrong.
TEST(HeldOutError, SeesAPartThatIsMissing) {
  std::vector<Vec3> points = sphere_points(1, 0.01);
  const std::size_t n = points.size();
  Random random(6);
  for (std::size_t i = 0; i < n / 100; ++i) points.push_back(Vec3(1.3, 0, 0) + 0.05 * random.direction());
  EXPECT_NEAR(held_out_error(sphere(5), points).bound(), 0.3 * std::sqrt(0.01), 0.006);
}

TEST(HeldOutError, CountsPointsBeyondARimWithTheirDistance) {
  std::vector<Vec3> points;
  for (int i = 0; i < 200; ++i) points.emplace_back(0.005 * i, -0.5, 0.0);
  const HeldOutError e = held_out_error(square(0), points);
  EXPECT_GT(e.pairs, 50u);
  EXPECT_NEAR(std::sqrt(e.mean_square), 0.5, 1e-9);
}

TEST(HeldOutError, IsZeroWithoutPoints) {
  const HeldOutError e = held_out_error(sphere(1), {});
  EXPECT_EQ(e.bound(), 0);
  EXPECT_EQ(e.pairs, 0u);
}

}  // namespace
}  // namespace gpsrecon::test
