#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/random.h>
#include <gpsrecon/scan/gallery.h>
#include <gpsrecon/scan/virtual_scan.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

constexpr double degree = std::numbers::pi / 180;

using ::testing::HasSubstr;

/// Fails unless the samples look like a standard normal distribution: mean and variance within four standard errors,
/// and the empirical distribution (Kolmogorov, Smirnov) within the bound exceeded with probability 0.001.
void expect_standard_normal(std::vector<double> samples) {
  std::sort(samples.begin(), samples.end());
  const auto n = static_cast<double>(samples.size());
  double mean = 0, variance = 0, largest = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    mean += samples[i] / n;
    variance += samples[i] * samples[i] / n;
    const double expected = 0.5 * std::erfc(-samples[i] / std::sqrt(2.0));
    largest = std::max({largest, expected - static_cast<double>(i) / n, static_cast<double>(i + 1) / n - expected});
  }
  EXPECT_NEAR(mean, 0, 4 / std::sqrt(n));
  EXPECT_NEAR(variance, 1, 4 * std::sqrt(2 / n));
  EXPECT_LT(largest * std::sqrt(n), 1.95);
}

ScanOptions options_of(std::size_t points) {
  ScanOptions options;
  options.points = points;
  return options;
}

Vec3 ray_of(const VirtualScan& scan, std::size_t i) {
  return (scan.surface[i] - scan.cloud.sensors[i]).normalized();
}

TEST(VirtualScan, WithoutErrorsLiesOnTheVisibleSurface) {
  const TurnedBall solid = make_workpiece();
  const double radius = solid.bounding_radius();
  const VirtualScan result = virtual_scan(solid, options_of(5000));
  ASSERT_EQ(result.cloud.size(), 5000u);
  EXPECT_NO_THROW(validate(result.cloud));
  for (std::size_t i = 0; i < result.cloud.size(); ++i) {
    const Vec3& p = result.cloud.positions[i];
    const Vec3& sensor = result.cloud.sensors[i];
    ASSERT_EQ(p, result.surface[i]);
    ASSERT_NEAR(solid.distance(p), 0, 1e-9 * radius);
    ASSERT_NEAR(sensor.norm(), 4 * radius, 1e-12 * radius);
    ASSERT_GT(-ray_of(result, i).dot(result.cloud.normals[i]), std::cos(ScanOptions().max_incidence * degree) - 1e-9);
    ASSERT_GT(solid.distance(p + 1e-6 * radius * result.cloud.normals[i]), 0);
    // Nothing stands between sensor and point.
    for (int step = 1; step < 400; ++step)
      ASSERT_GT(solid.distance(p + (sensor - p) * (0.5 * step / 400)), 0) << p.transpose();
  }
}

TEST(VirtualScan, NoiseIsNormalAlongTheRay) {
  const TurnedBall solid = make_workpiece();
  ScanOptions options = options_of(20'000);
  options.noise = Length::of_diagonal(0.0006);
  const double sigma = options.noise.number() * solid.diagonal();
  const VirtualScan result = virtual_scan(solid, options);
  std::vector<double> noise(result.cloud.size());
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const Vec3 error = result.cloud.positions[i] - result.surface[i];
    noise[i] = error.dot(ray_of(result, i)) / sigma;
    ASSERT_NEAR(error.norm(), sigma * std::abs(noise[i]), 1e-12);
  }
  expect_standard_normal(noise);
}

// On flat faces the distance from the surface is the noise times the cosine of the incidence.
TEST(VirtualScan, DistanceFromTheSolidIsTheNoiseTimesTheCosine) {
  const Cuboid solid(Vec3(3, 2, 1));
  ScanOptions options = options_of(20'000);
  options.noise = Length::of_diagonal(1e-6);
  const double sigma = options.noise.number() * solid.diagonal();
  const VirtualScan result = virtual_scan(solid, options);
  std::vector<double> scaled(result.cloud.size());
  for (std::size_t i = 0; i < scaled.size(); ++i)
    scaled[i] =
        solid.distance(result.cloud.positions[i]) / (sigma * std::abs(ray_of(result, i).dot(result.cloud.normals[i])));
  expect_standard_normal(scaled);
}

TEST(VirtualScan, RegistrationMovesEachViewRigidly) {
  const TurnedBall solid = make_workpiece();
  ScanOptions options = options_of(3000);
  options.registration_shift = Length::of_diagonal(0.3 / solid.diagonal());
  options.registration_angle = 0.05 / degree;
  const VirtualScan result = virtual_scan(solid, options);
  double largest = 0;
  for (std::size_t i = 1; i < result.cloud.size(); ++i) {
    largest = std::max(largest, (result.cloud.positions[i] - result.surface[i]).norm());
    if (result.view[i] != result.view[i - 1]) continue;
    ASSERT_EQ(result.cloud.sensors[i], result.cloud.sensors[i - 1]);
    ASSERT_NEAR((result.cloud.positions[i] - result.cloud.positions[i - 1]).norm(),
                (result.surface[i] - result.surface[i - 1]).norm(), 1e-11);
  }
  EXPECT_GT(largest, 0.3);
}

TEST(VirtualScan, RegistrationErrorsAreNormal) {
  const Lathe sphere = make_sphere(1);
  ScanOptions options = options_of(4000);
  options.views = 4000;
  options.registration_shift = Length::of_diagonal(0.003);
  std::vector<double> shifts;
  {
    const VirtualScan result = virtual_scan(sphere, options);
    for (std::size_t i = 0; i < result.cloud.size(); ++i) {
      if (i > 0 && result.view[i] == result.view[i - 1]) continue;
      const Vec3 shift =
          (result.cloud.positions[i] - result.surface[i]) / (options.registration_shift.number() * sphere.diagonal());
      shifts.insert(shifts.end(), {shift.x(), shift.y(), shift.z()});
    }
  }
  EXPECT_GT(shifts.size(), 6000u);
  expect_standard_normal(shifts);

  // A point s moves by ω × s, so its component along any unit vector u across s is normal too.
  options.registration_shift = Length::of_diagonal(0);
  options.registration_angle = 1e-5 / degree;
  const VirtualScan result = virtual_scan(sphere, options);
  std::vector<double> turns;
  for (std::size_t i = 0; i < result.cloud.size(); ++i) {
    if (i > 0 && result.view[i] == result.view[i - 1]) continue;
    const Vec3 across = result.surface[i].unitOrthogonal();
    turns.push_back(across.dot(result.cloud.positions[i] - result.surface[i]) / (options.registration_angle * degree));
  }
  expect_standard_normal(turns);
}

TEST(VirtualScan, HasAsManyOutliersAsAskedFor) {
  const TurnedBall solid = make_workpiece();
  ScanOptions options = options_of(20'000);
  options.noise = Length::of_diagonal(0.0006);
  options.outlier_share = 0.025;
  const VirtualScan result = virtual_scan(solid, options);
  ASSERT_EQ(result.cloud.size(), 20'000u);
  ASSERT_EQ(result.outliers.size(), 500u);
  EXPECT_TRUE(std::is_sorted(result.outliers.begin(), result.outliers.end(), std::less_equal<>()));
  std::vector<double> places;
  for (std::size_t i = 0; i < result.cloud.size(); ++i) {
    const Vec3 ray = ray_of(result, i);
    const Vec3 error = result.cloud.positions[i] - result.surface[i];
    // The ray passes within 1e-10 radii of the surface point, 3 to 5 radii from the sensor; the outlier is at most 5
    // away.
    ASSERT_LT((error - error.dot(ray) * ray).norm(), 5.0 / 3 * 1.001e-10 * solid.bounding_radius());
    if (std::binary_search(result.outliers.begin(), result.outliers.end(), i)) {
      const double depth = (result.cloud.positions[i] - result.cloud.sensors[i]).norm() / solid.bounding_radius();
      places.push_back((depth - 3) / 2);
      ASSERT_GE(places.back(), 0);
      ASSERT_LE(places.back(), 1);
    } else {
      ASSERT_LT(error.norm(), 6 * options.noise.number() * solid.diagonal());
    }
  }
  const double mean = std::accumulate(places.begin(), places.end(), 0.0) / 500;
  EXPECT_NEAR(mean, 0.5, 4 / std::sqrt(12.0 * 500));  // four standard errors of the mean of a uniform distribution
  EXPECT_TRUE(virtual_scan(solid, options_of(100)).outliers.empty());

  options.outlier_share = 1;
  EXPECT_EQ(virtual_scan(solid, options).outliers.size(), options.points);
}

TEST(VirtualScan, NoiseGrowsTowardsGrazingRays) {
  const Lathe sphere = make_sphere(1);
  ScanOptions options = options_of(20'000);
  options.noise = Length::of_diagonal(1e-5);
  options.noise_growth = 0.5;
  const VirtualScan result = virtual_scan(sphere, options);
  std::vector<double> scaled(result.cloud.size());
  for (std::size_t i = 0; i < scaled.size(); ++i) {
    const Vec3 ray = ray_of(result, i);
    const double sigma = options.noise.number() * sphere.diagonal() / std::sqrt(-ray.dot(result.cloud.normals[i]));
    scaled[i] = (result.cloud.positions[i] - result.surface[i]).dot(ray) / sigma;
  }
  expect_standard_normal(scaled);
}

// The bias is no noise: of neighbours in the same view it is nearly the same, and over all points it is about centred,
// with the mean square of a product of two sine waves.
TEST(VirtualScan, BiasVariesSlowlyOverEachView) {
  const Lathe sphere = make_sphere(1);
  ScanOptions options = options_of(20'000);
  options.bias = Length::of_diagonal(0.01);
  const VirtualScan result = virtual_scan(sphere, options);
  const double amplitude = options.bias.number() * sphere.diagonal();
  std::vector<double> bias(result.cloud.size());
  double mean = 0, square = 0;
  for (std::size_t i = 0; i < bias.size(); ++i) {
    const Vec3 error = result.cloud.positions[i] - result.surface[i];
    bias[i] = error.dot(ray_of(result, i)) / amplitude;
    ASSERT_NEAR(error.norm(), amplitude * std::abs(bias[i]), 1e-12);
    ASSERT_LE(std::abs(bias[i]), 1);
    mean += bias[i] / 20'000;
    square += bias[i] * bias[i] / 20'000;
  }
  EXPECT_NEAR(mean, 0, 0.1);
  EXPECT_NEAR(square, 0.25, 0.05);
  const Neighbors places(result.surface);
  std::vector<Neighbor> near;
  for (std::size_t i = 0; i < bias.size(); i += 10) {
    places.within(result.surface[i], 0.05, near);
    for (const Neighbor& other : near)
      if (result.view[other.index] == result.view[i] && result.cloud.normals[i].dot(ray_of(result, i)) < -0.8) {
        // Five waves over the width of the image, about twice the sphere's radius, in either direction.
        ASSERT_NEAR(bias[other.index], bias[i], 5 * std::numbers::pi * std::numbers::sqrt2 * 0.05 * 1.4);
      }
  }
}

TEST(VirtualScan, SpikesMoveAlongTheRayByAtMostTheirLength) {
  const Lathe sphere = make_sphere(1);
  ScanOptions options = options_of(20'000);
  options.outlier_share = 0.01;
  options.spike_share = 0.1;
  options.spike_length = Length::of_diagonal(0.05);
  const VirtualScan result = virtual_scan(sphere, options);
  ASSERT_EQ(result.spikes.size(), 2000u);
  EXPECT_TRUE(std::is_sorted(result.spikes.begin(), result.spikes.end(), std::less_equal<>()));
  std::vector<Index> both;
  std::set_intersection(result.spikes.begin(), result.spikes.end(), result.outliers.begin(), result.outliers.end(),
                        std::back_inserter(both));
  EXPECT_TRUE(both.empty());
  double mean = 0;
  std::size_t moved = 0;
  for (std::size_t i = 0; i < result.cloud.size(); ++i) {
    const Vec3 error = result.cloud.positions[i] - result.surface[i];
    if (error.norm() > 0) ++moved;
    if (!std::binary_search(result.spikes.begin(), result.spikes.end(), i)) continue;
    const double length = error.dot(ray_of(result, i)) / (options.spike_length.number() * sphere.diagonal());
    ASSERT_LE(std::abs(length), 1);
    ASSERT_NEAR(error.norm(), std::abs(length) * options.spike_length.number() * sphere.diagonal(), 1e-12);
    mean += std::abs(length) / 2000;
  }
  EXPECT_EQ(moved, 2200u);
  EXPECT_NEAR(mean, 0.5, 4 / std::sqrt(12.0 * 2000));  // of a uniform distribution
}

TEST(VirtualScan, MeasuresTheBackOfASurfaceOnlyIfAskedTo) {
  const auto vase = make_shape("vase");
  ScanOptions options = options_of(5000);
  const auto seen_from_behind = [&](const VirtualScan& result) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < result.cloud.size(); ++i) {
      EXPECT_LT(ray_of(result, i).dot(result.cloud.normals[i]), 0);  // normals face the camera
      if (vase->closest(result.surface[i]).normal.dot(result.cloud.normals[i]) < 0) ++count;
    }
    return count;
  };
  EXPECT_EQ(seen_from_behind(virtual_scan(*vase, options)), 0u);
  options.both_sides = true;
  EXPECT_GT(seen_from_behind(virtual_scan(*vase, options)), 50u);
}

TEST(VirtualScan, QualitiesAreAsStated) {
  const ScanOptions s1 = scan_quality(ScanQuality::s1), s2 = scan_quality(ScanQuality::s2),
                    s3 = scan_quality(ScanQuality::s3);
  for (const ScanOptions& options : {s1, s2, s3}) EXPECT_NO_THROW(options.check());
  EXPECT_EQ(s1.points, 300'000u);
  EXPECT_EQ(s2.points, 150'000u);
  EXPECT_EQ(s3.points, 75'000u);
  EXPECT_EQ(s1.outlier_share, 0);
  EXPECT_GT(s3.spike_share, 0);
  EXPECT_LT(s3.max_incidence, s2.max_incidence);
}

TEST(VirtualScan, IsTheSameForAnyNumberOfThreads) {
  const TurnedBall solid = make_workpiece();
  ScanOptions options = scan_quality(ScanQuality::s3);
  options.points = 30'000;
  RunContext context;
  context.threads = 1;
  const VirtualScan alone = virtual_scan(solid, options, context);
  for (const int threads : {2, 4}) {
    context.threads = threads;
    const VirtualScan other = virtual_scan(solid, options, context);
    EXPECT_EQ(other.cloud.positions, alone.cloud.positions);
    EXPECT_EQ(other.cloud.normals, alone.cloud.normals);
    EXPECT_EQ(other.cloud.sensors, alone.cloud.sensors);
    EXPECT_EQ(other.view, alone.view);
    EXPECT_EQ(other.outliers, alone.outliers);
  }
  context.seed = 2;
  const VirtualScan reseeded = virtual_scan(solid, options, context);
  EXPECT_NE(reseeded.cloud.positions, alone.cloud.positions);
  EXPECT_NE(reseeded.outliers, alone.outliers);
}

TEST(VirtualScan, RefusesOptionsOutOfRange) {
  const auto message = [](const auto& change) -> std::string {
    ScanOptions options;
    change(options);
    try {
      options.check();
    } catch (const OptionError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(message([](ScanOptions& o) { o.points = 0; }), HasSubstr("points must be in [1, 4294967294], not 0"));
  EXPECT_THAT(message([](ScanOptions& o) { o.views = 0; }), HasSubstr("views must be in [1, 10000], not 0"));
  EXPECT_THAT(message([](ScanOptions& o) { o.distance = 1; }), HasSubstr("distance must be in (1, 1000], not 1"));
  EXPECT_THAT(message([](ScanOptions& o) { o.max_incidence = 91; }),
              HasSubstr("max-incidence must be in (0, 90] degrees, not 91"));
  EXPECT_THAT(message([](ScanOptions& o) { o.noise = Length::of_diagonal(-1); }),
              HasSubstr("noise must be >= 0, not -100%"));
  EXPECT_THAT(message([](ScanOptions& o) { o.noise = Length::of_diagonal(NAN); }), HasSubstr("noise must be"));
  EXPECT_THAT(message([](ScanOptions& o) { o.noise_growth = 5; }), HasSubstr("noise-growth must be in [0, 4], not 5"));
  EXPECT_THAT(message([](ScanOptions& o) { o.bias = Length::of_diagonal(-1); }),
              HasSubstr("bias must be >= 0, not -100%"));
  EXPECT_THAT(message([](ScanOptions& o) { o.registration_shift = Length::of_diagonal(-1); }),
              HasSubstr("registration must be >= 0, not -100%"));
  EXPECT_THAT(message([](ScanOptions& o) { o.registration_angle = 200; }),
              HasSubstr("registration-angle must be in [0, 180] degrees, not 200"));
  EXPECT_THAT(message([](ScanOptions& o) { o.outlier_share = 2; }), HasSubstr("outliers must be in [0, 1], not 2"));
  EXPECT_THAT(message([](ScanOptions& o) { o.spike_share = -1; }), HasSubstr("spikes must be in [0, 1], not -1"));
  EXPECT_THAT(message([](ScanOptions& o) { o.spike_length = Length::of_diagonal(-1); }),
              HasSubstr("spike-length must be >= 0, not -100%"));
  EXPECT_THAT(message([](ScanOptions& o) { o.outlier_share = o.spike_share = 0.75; }), HasSubstr("not 1.5"));
  EXPECT_EQ(message([](ScanOptions&) {}), "accepted");
}

TEST(VirtualScan, SaysWhenNothingIsSeen) {
  ScanOptions options = options_of(100);
  options.max_incidence = 1e-9;
  EXPECT_THROW(virtual_scan(Cuboid(Vec3(3, 2, 1)), options), NoSurfaceError);
}

TEST(VirtualScan, StopsWhenAskedTo) {
  const std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  EXPECT_THROW(virtual_scan(make_sphere(1), options_of(100), context), Cancelled);
}

// No part of the workpiece is hidden from all views.
TEST(Workpiece, IsScannedAllOver) {
  const TurnedBall solid = make_workpiece();
  RunContext context;
  ScanOptions options = options_of(100'000);
  options.views = 36;
  options.noise = Length::of_diagonal(0.0004);
  const VirtualScan result = virtual_scan(solid, options, context);
  const Neighbors points(result.cloud.positions);
  std::vector<Neighbor> found;
  double widest = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const auto coordinate = [&](std::uint64_t k) { return 40 * (2 * random_uniform(11, 0, 3 * i + k) - 1); };
    const Vec3 p(coordinate(0), coordinate(1), coordinate(2));
    points.nearest(solid.closest(p).point, 1, found);
    widest = std::max(widest, found.front().distance);
  }
  EXPECT_LT(widest, 1) << "millimetres from a point of the surface to the nearest measured one";
}

}  // namespace
}  // namespace gpsrecon
