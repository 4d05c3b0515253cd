#include "datasets/virtual_scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/random.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numeric>
#include <string>

#include "datasets/example.h"

namespace gpsrecon::datasets {
namespace {

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
  const TurnedBall solid = example_solid();
  const double radius = solid.bounding_radius();
  const VirtualScan result = scan(solid, options_of(5000));
  ASSERT_EQ(result.cloud.size(), 5000u);
  EXPECT_NO_THROW(validate(result.cloud));
  for (std::size_t i = 0; i < result.cloud.size(); ++i) {
    const Vec3& p = result.cloud.positions[i];
    const Vec3& sensor = result.cloud.sensors[i];
    ASSERT_EQ(p, result.surface[i]);
    ASSERT_NEAR(solid.distance(p), 0, 1e-9 * radius);
    ASSERT_NEAR(sensor.norm(), 4 * radius, 1e-12 * radius);
    ASSERT_GT(-ray_of(result, i).dot(result.cloud.normals[i]), std::cos(1.3) - 1e-9);
    ASSERT_GT(solid.distance(p + 1e-6 * radius * result.cloud.normals[i]), 0);
    // Nothing stands between sensor and point.
    for (int step = 1; step < 400; ++step)
      ASSERT_GT(solid.distance(p + (sensor - p) * (0.5 * step / 400)), 0) << p.transpose();
  }
}

TEST(VirtualScan, NoiseIsNormalAlongTheRay) {
  const TurnedBall solid = example_solid();
  ScanOptions options = options_of(20'000);
  options.noise = 0.05;
  const VirtualScan result = scan(solid, options);
  std::vector<double> noise(result.cloud.size());
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const Vec3 error = result.cloud.positions[i] - result.surface[i];
    noise[i] = error.dot(ray_of(result, i)) / options.noise;
    ASSERT_NEAR(error.norm(), options.noise * std::abs(noise[i]), 1e-12);
  }
  expect_standard_normal(noise);
}

// On flat faces the distance from the surface is the noise times the cosine of the incidence.
TEST(VirtualScan, DistanceFromTheSolidIsTheNoiseTimesTheCosine) {
  const Cuboid solid(Vec3(3, 2, 1));
  ScanOptions options = options_of(20'000);
  options.noise = 1e-5;
  const VirtualScan result = scan(solid, options);
  std::vector<double> scaled(result.cloud.size());
  for (std::size_t i = 0; i < scaled.size(); ++i)
    scaled[i] = solid.distance(result.cloud.positions[i]) /
                (options.noise * std::abs(ray_of(result, i).dot(result.cloud.normals[i])));
  expect_standard_normal(scaled);
}

TEST(VirtualScan, RegistrationMovesEachViewRigidly) {
  const TurnedBall solid = example_solid();
  ScanOptions options = options_of(3000);
  options.registration_shift = 0.3;
  options.registration_angle = 0.05;
  const VirtualScan result = scan(solid, options);
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
  options.registration_shift = 0.01;
  std::vector<double> shifts;
  {
    const VirtualScan result = scan(sphere, options);
    for (std::size_t i = 0; i < result.cloud.size(); ++i) {
      if (i > 0 && result.view[i] == result.view[i - 1]) continue;
      const Vec3 shift = (result.cloud.positions[i] - result.surface[i]) / options.registration_shift;
      shifts.insert(shifts.end(), {shift.x(), shift.y(), shift.z()});
    }
  }
  EXPECT_GT(shifts.size(), 6000u);
  expect_standard_normal(shifts);

  // A point s moves by ω × s, so its component along any unit vector u across s is normal too.
  options.registration_shift = 0;
  options.registration_angle = 1e-5;
  const VirtualScan result = scan(sphere, options);
  std::vector<double> turns;
  for (std::size_t i = 0; i < result.cloud.size(); ++i) {
    if (i > 0 && result.view[i] == result.view[i - 1]) continue;
    const Vec3 across = result.surface[i].unitOrthogonal();
    turns.push_back(across.dot(result.cloud.positions[i] - result.surface[i]) / options.registration_angle);
  }
  expect_standard_normal(turns);
}

TEST(VirtualScan, HasAsManyOutliersAsAskedFor) {
  const TurnedBall solid = example_solid();
  ScanOptions options = options_of(20'000);
  options.noise = 0.05;
  options.outliers = 500;
  const VirtualScan result = scan(solid, options);
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
      ASSERT_LT(error.norm(), 6 * options.noise);
    }
  }
  const double mean = std::accumulate(places.begin(), places.end(), 0.0) / 500;
  EXPECT_NEAR(mean, 0.5, 4 / std::sqrt(12.0 * 500));  // four standard errors of the mean of a uniform distribution
  EXPECT_TRUE(scan(solid, options_of(100)).outliers.empty());

  options.outliers = options.points;
  EXPECT_EQ(scan(solid, options).outliers.size(), options.points);
}

TEST(VirtualScan, IsTheSameForAnyNumberOfThreads) {
  const TurnedBall solid = example_solid();
  ScanOptions options = example_scan();
  options.points = 30'000;
  RunContext context;
  context.threads = 1;
  const VirtualScan alone = scan(solid, options, context);
  for (const int threads : {2, 4}) {
    context.threads = threads;
    const VirtualScan other = scan(solid, options, context);
    EXPECT_EQ(other.cloud.positions, alone.cloud.positions);
    EXPECT_EQ(other.cloud.normals, alone.cloud.normals);
    EXPECT_EQ(other.cloud.sensors, alone.cloud.sensors);
    EXPECT_EQ(other.view, alone.view);
    EXPECT_EQ(other.outliers, alone.outliers);
  }
  context.seed = 2;
  const VirtualScan reseeded = scan(solid, options, context);
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
  EXPECT_THAT(message([](ScanOptions& o) { o.points = 0; }), HasSubstr("points = 0"));
  EXPECT_THAT(message([](ScanOptions& o) { o.views = 0; }), HasSubstr("views = 0"));
  EXPECT_THAT(message([](ScanOptions& o) { o.distance = 1; }), HasSubstr("distance = 1"));
  EXPECT_THAT(message([](ScanOptions& o) { o.max_incidence = 2; }), HasSubstr("max_incidence = 2"));
  EXPECT_THAT(message([](ScanOptions& o) { o.noise = -1; }), HasSubstr("noise = -1"));
  EXPECT_THAT(message([](ScanOptions& o) { o.noise = NAN; }), HasSubstr("noise = nan"));
  EXPECT_THAT(message([](ScanOptions& o) { o.registration_shift = -1; }), HasSubstr("registration_shift = -1"));
  EXPECT_THAT(message([](ScanOptions& o) { o.registration_angle = -1; }), HasSubstr("registration_angle = -1"));
  EXPECT_THAT(message([](ScanOptions& o) { o.outliers = o.points + 1; }), HasSubstr("outliers = 100001"));
  EXPECT_EQ(message([](ScanOptions&) {}), "accepted");
}

TEST(VirtualScan, SaysWhenNothingIsSeen) {
  ScanOptions options = options_of(100);
  options.max_incidence = 1e-9;
  EXPECT_THROW(scan(Cuboid(Vec3(3, 2, 1)), options), NoSurfaceError);
}

TEST(VirtualScan, StopsWhenAskedTo) {
  const std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  EXPECT_THROW(scan(make_sphere(1), options_of(100), context), Cancelled);
}

// No part of the example is hidden from all views.
TEST(Example, IsScannedAllOver) {
  const TurnedBall solid = example_solid();
  RunContext context;
  context.seed = example_seed;
  const VirtualScan result = scan(solid, example_scan(), context);
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

TEST(Example, FileHoldsTheScan) {
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) / "gpsrecon_example_test.ply";
  const std::string command = std::string(GPSRECON_MAKE_EXAMPLE) + " '" + path.string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::filesystem::remove(path);
  const std::string end = "end_header\n";
  const std::size_t start = bytes.find(end) + end.size();
  EXPECT_THAT(bytes.substr(0, start), HasSubstr("\nelement vertex 100000\n"));

  RunContext context;
  context.seed = example_seed;
  const VirtualScan expected = scan(example_solid(), example_scan(), context);
  ASSERT_EQ(bytes.size() - start, expected.cloud.size() * 3 * sizeof(float));
  for (std::size_t i = 0; i < expected.cloud.size(); ++i) {
    float stored[3];
    std::memcpy(stored, bytes.data() + start + i * sizeof stored, sizeof stored);
    for (int k = 0; k < 3; ++k) ASSERT_EQ(stored[k], static_cast<float>(expected.cloud.positions[i][k]));
  }
}

}  // namespace
}  // namespace gpsrecon::datasets
