#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/clop/normals.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/hem/hem.h>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <limits>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::Random;
using test::SampledShape;
using testing::HasSubstr;

constexpr double degree = std::numbers::pi / 180;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double between_axes(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

double largest_angle(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, between_axes(a[i], b[i]));
  return largest;
}

bool are_unit(const std::vector<Vec3>& normals) {
  return std::all_of(normals.begin(), normals.end(),
                     [](const Vec3& n) { return std::abs(n.norm() - 1) < 1e-12; });  // false for NaN
}

Vec3 at_angles(double polar, double around) {
  return {std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar)};
}

/// Points that all have the same kernel weight around the origin, with the given normals.
PointCloud ring_of(const std::vector<Vec3>& axes) {
  PointCloud cloud;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(axes.size());
    cloud.positions.emplace_back(std::cos(turn), std::sin(turn), 0);
  }
  cloud.normals = axes;
  return cloud;
}

const std::vector<Vec3> origin{Vec3::Zero()};
const NormalOptions to_the_end{.h = 4, .iterations = 1000, .convergence = 1e-12};

/// A flat Gaussian per point, with an axis.
Mixture mixture_of(const std::vector<Vec3>& means, const std::vector<Vec3>& axes, double variance,
                   double normal_variance) {
  Mixture m;
  m.means = means;
  m.covariances.assign(means.size(), Sym3::identity(variance));
  m.weights.assign(means.size(), 1.0);
  m.normals = axes;
  m.normal_variances.assign(means.size(), normal_variance);
  return m;
}

/// The axis of least summed squared sines, by another solver.
Vec3 least_squares_axis(const std::vector<Vec3>& axes, const std::vector<double>& weights) {
  Mat3 scatter = Mat3::Zero();
  for (std::size_t j = 0; j < axes.size(); ++j) scatter += weights[j] * axes[j] * axes[j].transpose();
  return Eigen::SelfAdjointEigenSolver<Mat3>(scatter).eigenvectors().col(2);
}

TEST(Weiszfeld, median_of_four_axes_is_where_their_diagonals_cross) {
  // Of four points of a convex quadrilateral, however lopsided, the median is the crossing of the diagonals: every
  // other point is farther from the ends of both.
  const Vec3 crossing = at_angles(0.4, 1);
  const Vec3 u = crossing.cross(Vec3::UnitX()).normalized(), v = crossing.cross(u);
  const auto along = [&](const Vec3& direction, double angle) -> Vec3 {
    return std::cos(angle) * crossing + std::sin(angle) * direction;
  };
  const Vec3 slanted = (u + v).normalized();
  const std::vector<Vec3> axes{along(u, 0.1), -along(u, -0.5), along(slanted, 0.3), along(slanted, -0.2)};
  EXPECT_LT(between_axes(weiszfeld_normals(origin, ring_of(axes), to_the_end)[0], crossing), 1e-6);
}

TEST(Weiszfeld, of_a_symmetric_ring_is_its_centre) {
  std::vector<Vec3> axes;
  axes.reserve(7);
  for (int i = 0; i < 7; ++i) axes.push_back((i % 2 == 0 ? 1 : -1) * at_angles(0.6, 2 * std::numbers::pi * i / 7));
  EXPECT_LT(between_axes(weiszfeld_normals(origin, ring_of(axes), to_the_end)[0], Vec3::UnitZ()), 1e-9);
}

TEST(Weiszfeld, stays_with_an_axis_that_has_half_of_the_weight) {
  Random random(3, test::sampling);
  for (const double outliers : {0.1, 0.3, 0.45}) {
    std::vector<Vec3> axes(100, Vec3::UnitZ());
    for (int i = 0; i < static_cast<int>(100 * outliers); ++i)
      axes[static_cast<std::size_t>(i)] = at_angles(random.uniform(0.3, 1.4), random.uniform(0, 1));
    EXPECT_LT(between_axes(weiszfeld_normals(origin, ring_of(axes), to_the_end)[0], Vec3::UnitZ()), 1e-4) << outliers;
    // The axis of least squares, where it starts, does not.
    EXPECT_GT(between_axes(weiszfeld_normals(origin, ring_of(axes), {.h = 4, .iterations = 0})[0], Vec3::UnitZ()),
              0.1 * outliers);
  }
}

// The sum has one minimum where all axes lie within 45 degrees of one (Afsari 2011). With others among them it may have
// several, and the one found is that from which no way leads down.
TEST(Weiszfeld, minimises_the_weighted_sum_of_angles) {
  Random random(1, test::sampling);
  for (int trial = 0; trial < 8; ++trial) {
    PointCloud cloud;
    std::vector<double> weights;
    const double h = 1.5;
    const bool outliers = trial % 2 == 1;
    const Mat3 turned = random.rotation();
    for (int i = 0; i < 40; ++i) {
      cloud.positions.push_back(random.vector(-0.6, 0.6));
      cloud.weights.push_back(random.uniform(0.5, 2));
      const double tilt = 45 * degree * random.uniform(), around = 2 * std::numbers::pi * random.uniform();
      const Vec3 axis = outliers && i % 4 == 0 ? random.direction() : Vec3(turned * at_angles(tilt, around));
      cloud.normals.push_back((random.uniform() < 0.5 ? -3 : 3) * axis);  // neither sign nor length matters
      const double r = cloud.positions.back().norm() / (h / 4);
      weights.push_back(cloud.positions.back().norm() <= h ? cloud.weights.back() * std::exp(-r * r) : 0);
    }
    const auto cost = [&](const Vec3& n) {
      double sum = 0;
      for (std::size_t j = 0; j < cloud.size(); ++j) sum += weights[j] * between_axes(cloud.normals[j] / 3, n);
      return sum;
    };
    NormalOptions options = to_the_end;
    options.h = h;
    const Vec3 found = weiszfeld_normals(origin, cloud, options)[0];
    // A grid of directions, then finer and finer ones around the best.
    const SampledShape grid = test::fibonacci_sphere(20000);
    Vec3 best = outliers ? found
                         : *std::min_element(grid.normals.begin(), grid.normals.end(),
                                             [&](const Vec3& a, const Vec3& b) { return cost(a) < cost(b); });
    for (double step = outliers ? 0.005 : 0.02; step > 1e-8; step *= 0.7) {
      const Vec3 u = best.unitOrthogonal(), v = best.cross(u), center = best;
      for (int turn = 0; turn < 12; ++turn) {
        const double angle = turn * 30 * degree;
        const Vec3 candidate = (center + step * (std::cos(angle) * u + std::sin(angle) * v)).normalized();
        if (cost(candidate) < cost(best)) best = candidate;
      }
    }
    // A median that is one of the axes is found to within the angle below which weights grow no more.
    EXPECT_LT(cost(found), cost(best) * (1 + 1e-5)) << trial;
    EXPECT_LT(between_axes(found, best), 1e-4) << trial;
  }
}

TEST(Weiszfeld, out_of_reach_is_the_normal_of_the_nearest_point) {
  const SampledShape sphere = test::random_sphere(100, 1);
  PointCloud cloud = sphere.cloud();
  cloud.normals = sphere.normals;
  const Vec3 away = cloud.positions[42] * 50;
  EXPECT_LT(between_axes(weiszfeld_normals(std::vector<Vec3>{away}, cloud, {.h = 0.1})[0], cloud.normals[42]), 1e-9);
}

TEST(Weiszfeld, signs_of_the_axes_do_not_matter) {
  Random random(5, test::sampling);
  SampledShape shape = test::box(400, {1, 1, 1}, 4);
  PointCloud cloud = shape.cloud();
  for (const Vec3& n : shape.normals) cloud.normals.push_back((n + 0.2 * random.normal3()).normalized());
  PointCloud flipped = cloud;
  for (Vec3& n : flipped.normals)
    if (random.uniform() < 0.5) n = -n;
  const NormalOptions options{.h = 0.8};
  EXPECT_EQ(weiszfeld_normals(cloud.positions, cloud, options), weiszfeld_normals(cloud.positions, flipped, options));
  Mixture mixture = mixture_of(cloud.positions, cloud.normals, 0.01, 0.05);
  Mixture flipped_mixture = mixture;
  flipped_mixture.normals = flipped.normals;
  EXPECT_EQ(csw_normals(cloud.positions, mixture, options), csw_normals(cloud.positions, flipped_mixture, options));
}

TEST(ContinuousWeiszfeld, without_variances_is_the_discrete_one_with_its_kernel) {
  // Eq. 27 in the tangent plane with α̂ for 1/d, written down anew.
  const std::array<std::array<double, 2>, 3> terms{
      {{11.4527327, 0.117719940}, {29.8858795, 0.032869803}, {97.7605615, 0.010097481}}};
  Random random(7, test::sampling);
  for (int trial = 0; trial < 5; ++trial) {
    const double h = 2;
    std::vector<Vec3> points, axes;
    std::vector<double> spatial;
    for (int i = 0; i < 30; ++i) {
      points.push_back(random.vector(-0.5, 0.5));
      axes.push_back((Vec3::UnitZ() + 0.5 * random.normal3()).normalized());
      spatial.push_back(std::exp(-16 * points.back().squaredNorm() / (h * h)));
    }
    Vec3 n = least_squares_axis(axes, spatial);
    for (int step = 0; step < 25; ++step) {
      Vec3 sum = Vec3::Zero();
      double total = 0;
      for (std::size_t j = 0; j < axes.size(); ++j) {
        const Vec3 m = axes[j].dot(n) < 0 ? Vec3(-axes[j]) : axes[j];
        const double d = std::acos(std::min(1.0, m.dot(n)));
        double alpha = 0;
        for (const auto& [weight, deviation] : terms)
          alpha += weight * std::exp(-0.5 * d * d / std::pow(deviation * std::numbers::pi, 2));
        sum += spatial[j] * alpha * d * (m - m.dot(n) * n).normalized();
        total += spatial[j] * alpha;
      }
      const Vec3 move = sum / total;
      n = std::cos(move.norm()) * n + std::sin(move.norm()) * move.normalized();
    }
    const Mixture mixture = mixture_of(points, axes, 1e-14, 0);
    const NormalOptions options{.h = h, .iterations = 25, .convergence = 0};
    EXPECT_LT(between_axes(csw_normals(origin, mixture, options)[0], n), 1e-9) << trial;
  }
}

TEST(ContinuousWeiszfeld, one_step_is_the_expectation_that_eq_31_asks_for) {
  // ∫ x Ω(x) dx / ∫ Ω(x) dx over the tangent plane, by the midpoint rule.
  const std::array<std::array<double, 2>, 3> terms{
      {{11.4527327, 0.117719940}, {29.8858795, 0.032869803}, {97.7605615, 0.010097481}}};
  Mixture mixture = mixture_of({{0.1, 0, 0}, {-0.3, 0.2, 0}, {0, -0.2, 0.1}},
                               {at_angles(0.3, 0), at_angles(0.4, 2), at_angles(0.1, 4)}, 0.01, 0);
  mixture.covariances[1] = Sym3::diagonal(0.04, 0.02, 0.001);
  mixture.weights = {1, 3, 2};
  mixture.normal_variances = {0.08, 0.02, 0.3};  // of the angle in both directions: half of it per axis
  const double h = 1;
  std::vector<double> spatial, weights;
  for (std::size_t s = 0; s < 3; ++s) {
    const Mat3 widened = mixture.covariances[s].matrix() + h * h / 32 * Mat3::Identity();
    const Vec3& mean = mixture.means[s];
    spatial.push_back(std::exp(-0.5 * mean.dot(widened.inverse() * mean)) / std::sqrt(widened.determinant()));
    weights.push_back(spatial[s] * mixture.weights[s]);
  }
  const Vec3 n = least_squares_axis(mixture.normals, weights);
  const Vec3 u = n.unitOrthogonal(), v = n.cross(u);
  const double range = 3, cell = 0.005;
  Vec3 sum = Vec3::Zero();
  double total = 0;
  std::vector<Vec3> centers;
  for (const Vec3& axis : mixture.normals) {
    const Vec3 m = axis.dot(n) < 0 ? Vec3(-axis) : axis;
    centers.push_back(std::acos(m.dot(n)) * (m - m.dot(n) * n).normalized());
  }
  for (double a = -range + cell / 2; a < range; a += cell)
    for (double b = -range + cell / 2; b < range; b += cell) {
      const Vec3 x = a * u + b * v;
      double alpha = 0, density = 0;
      for (const auto& [weight, deviation] : terms)
        alpha += weight * std::exp(-0.5 * x.squaredNorm() / std::pow(deviation * std::numbers::pi, 2));
      for (std::size_t s = 0; s < 3; ++s) {
        const double variance = mixture.normal_variances[s] / 2;
        density += weights[s] * std::exp(-0.5 * (x - centers[s]).squaredNorm() / variance) / variance;
      }
      sum += alpha * density * x;
      total += alpha * density;
    }
  const Vec3 move = sum / total;
  const Vec3 expected = std::cos(move.norm()) * n + std::sin(move.norm()) * move.normalized();
  EXPECT_GT(move.norm(), 0.01);
  const Vec3 found = csw_normals(origin, mixture, {.h = h, .iterations = 1})[0];
  EXPECT_LT(between_axes(found, expected), 1e-6);
}

TEST(ContinuousWeiszfeld, one_huge_gaussian_reaches_as_far_as_it_is_large) {
  // Far from the small ones only the huge one, though its centre is far too, is within reach.
  Mixture mixture =
      mixture_of({{0, 0, 0}, {0.1, 0, 0}, {50, 0, 0}}, {Vec3::UnitX(), Vec3::UnitX(), Vec3::UnitY()}, 1e-4, 0);
  mixture.covariances[2] = Sym3::identity(100);
  const std::vector<Vec3> queries{{20, 0, 0}, {0, 0, 0}, {-1e6, 0, 0}};
  const std::vector<Vec3> normals = csw_normals(queries, mixture, {.h = 0.1});
  EXPECT_LT(between_axes(normals[0], Vec3::UnitY()), 1e-9);
  EXPECT_LT(between_axes(normals[1], Vec3::UnitX()), 1e-3);
  EXPECT_LT(between_axes(normals[2], Vec3::UnitX()), 1e-9);  // of the nearest
}

/// Two half planes that meet in the y axis at the angle given, with noise along their normals.
SampledShape roof(std::size_t n, double interior_angle, double noise, std::uint64_t seed) {
  Random random(seed, test::sampling);
  SampledShape shape;
  for (std::size_t i = 0; i < n; ++i) {
    const double side = i % 2 == 0 ? 1 : -1, slope = (std::numbers::pi - interior_angle) / 2;
    const Vec3 down(side * std::cos(slope), 0, -std::sin(slope));
    shape.normals.emplace_back(side * std::sin(slope), 0, std::cos(slope));
    shape.points.push_back(random.uniform(0, 0.5) * down + random.uniform(-0.5, 0.5) * Vec3::UnitY());
  }
  shape.area = 1;
  test::add_noise(shape, noise, seed + 1);
  return shape;
}

TEST(ContinuousWeiszfeld, keeps_a_crease_within_two_degrees) {
  // Flatter ones than that are as wide as the kernel is on the sphere, and blur.
  for (const double interior : {90 * degree, 120 * degree}) {
    const SampledShape shape = roof(10000, interior, 0.0003, 11);
    const double spacing = shape.spacing();
    PointCloud cloud = shape.cloud();
    cloud.normals = pca_normals(cloud.positions, cloud.positions, {.neighbors = 12});
    const Mixture mixture = build_mixture(cloud, {.flat_levels = 0, .normals = true});
    EXPECT_LT(mixture.size(), 1000u);
    const auto share_within_two_degrees = [&](double distance, const auto& normals_at) {
      std::vector<Vec3> queries, truth;
      for (int i = -60; i <= 60; ++i)
        for (const Vec3& normal : roof(2, interior, 0, 1).normals) {
          const Vec3 down = (normal.x() > 0 ? 1 : -1) * Vec3::UnitY().cross(normal);
          queries.push_back(distance * spacing * down + i * 0.005 * Vec3::UnitY());
          truth.push_back(normal);
        }
      const std::vector<Vec3> normals = normals_at(queries);
      double within = 0;
      for (std::size_t i = 0; i < normals.size(); ++i) within += between_axes(normals[i], truth[i]) < 2 * degree;
      return within / static_cast<double>(normals.size());
    };
    const auto csw = [&](const auto& queries) { return csw_normals(queries, mixture, {.h = 20 * spacing}); };
    const auto pca = [&](const auto& queries) { return pca_normals(queries, cloud.positions, {.neighbors = 12}); };
    for (const double distance : {3.0, 5.0, 8.0})
      EXPECT_EQ(share_within_two_degrees(distance, csw), 1) << interior / degree << " " << distance;
    // Closer, it depends on where the Gaussians at the ridge came to lie. Of 20 draws the least were 94 % at two
    // spacings and 67 % at one, where planes had at most 15 %.
    EXPECT_GT(share_within_two_degrees(2, csw), 0.9) << interior / degree;
    EXPECT_GT(share_within_two_degrees(1, csw), 0.5) << interior / degree;
    EXPECT_LT(share_within_two_degrees(1, pca), 0.2) << interior / degree;
  }
}

TEST(Normals, of_a_smooth_surface_are_right) {
  SampledShape sphere = test::random_sphere(8000, 2);
  test::add_noise(sphere, 0.005, 3);
  PointCloud cloud = sphere.cloud();
  const std::vector<Vec3> pca = pca_normals(cloud.positions, cloud.positions);
  cloud.normals = pca;
  const std::vector<Vec3> weiszfeld = weiszfeld_normals(cloud.positions, cloud);
  const Mixture mixture = build_mixture(cloud, {.flat_levels = 0, .normals = true});
  const std::vector<Vec3> csw = csw_normals(cloud.positions, mixture);
  const auto mean_angle = [&](const std::vector<Vec3>& normals) {
    double sum = 0;
    for (std::size_t i = 0; i < normals.size(); ++i) sum += between_axes(normals[i], sphere.normals[i]) / degree;
    return sum / static_cast<double>(normals.size());
  };
  // Noise turns a plane by 0.04 rad per axis, 2.9° on average, where the number of neighbours answers it.
  EXPECT_LT(mean_angle(pca), 3.5);
  EXPECT_LT(mean_angle(weiszfeld), mean_angle(pca));
  EXPECT_LT(mean_angle(csw), mean_angle(pca));
}

TEST(Normals, follow_rigid_motions_and_scaling) {
  SampledShape shape = test::box(3000, {1, 0.7, 0.5}, 5);
  test::add_noise(shape, 0.01, 6);
  const Mat3 rotation = Eigen::AngleAxisd(0.7, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  PointCloud cloud = shape.cloud(), moved;
  for (const Vec3& p : cloud.positions) moved.positions.push_back(37 * (rotation * p) + Vec3(5, -3, 8));
  const NormalOptions options{.convergence = 0};
  const std::vector<Vec3> pca = pca_normals(cloud.positions, cloud.positions, options),
                          moved_pca = pca_normals(moved.positions, moved.positions, options);
  cloud.normals = pca;
  moved.normals = moved_pca;
  Mixture mixture = mixture_of(cloud.positions, pca, 0.001, 0.02), moved_mixture = mixture;
  moved_mixture.means = moved.positions;
  moved_mixture.normals = moved_pca;
  for (Sym3& c : moved_mixture.covariances) c *= 37 * 37;
  const auto turned = [&](std::vector<Vec3> normals) {
    for (Vec3& n : normals) n = rotation * n;
    return normals;
  };
  // A plane that two of its three extents leave open, or two medians of equal cost, may turn rounding into more.
  EXPECT_LT(largest_angle(turned(pca), moved_pca), 1e-9);
  EXPECT_LT(largest_angle(turned(weiszfeld_normals(cloud.positions, cloud, options)),
                          weiszfeld_normals(moved.positions, moved, options)),
            1e-7);
  EXPECT_LT(largest_angle(turned(csw_normals(cloud.positions, mixture, options)),
                          csw_normals(moved.positions, moved_mixture, options)),
            1e-7);
}

TEST(Normals, do_not_depend_on_threads) {
  SampledShape shape = test::box(6000, {1, 0.7, 0.5}, 5);
  test::add_noise(shape, 0.01, 6);
  PointCloud cloud = shape.cloud();
  std::vector<std::vector<Vec3>> results[3];
  for (const int threads : {1, 2, 5}) {
    RunContext context;
    context.threads = threads;
    cloud.normals.clear();
    results[0].push_back(pca_normals(cloud.positions, cloud.positions, {}, context));
    cloud.normals = results[0].front();
    results[1].push_back(weiszfeld_normals(cloud.positions, cloud, {}, context));
    results[2].push_back(
        csw_normals(cloud.positions, mixture_of(cloud.positions, cloud.normals, 1e-3, 0.01), {}, context));
  }
  for (const auto& result : results)
    for (const auto& normals : result) EXPECT_EQ(normals, result.front());
}

TEST(Normals, of_scan_lines_come_from_several_lines) {
  // Points on lines 25 times as far apart as the points on them: twelve neighbours are on one line.
  std::vector<Vec3> points;
  for (int line = 0; line < 12; ++line)
    for (int i = 0; i < 600; ++i) points.emplace_back(i * 0.01, line * 0.25, 0);
  const std::vector<Vec3> queries{{3, 0.75, 0}, {2.004, 1, 0}};
  const std::vector<Vec3> normals = pca_normals(queries, points, {.neighbors = 12});
  for (const Vec3& n : normals) EXPECT_LT(between_axes(n, Vec3::UnitZ()), 1e-6);
}

TEST(Normals, of_planes_through_few_or_equal_points) {
  const std::vector<Vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const Vec3& n : pca_normals(corners, corners, {.neighbors = 50}))
    EXPECT_LT(between_axes(n, Vec3::UnitZ()), 1e-12);
  std::vector<Vec3> repeated;
  repeated.reserve(300);
  for (int i = 0; i < 300; ++i) repeated.push_back(corners[static_cast<std::size_t>(i % 3)]);
  EXPECT_TRUE(are_unit(pca_normals(repeated, repeated)));
  PointCloud cloud;
  cloud.positions = repeated;
  cloud.normals.assign(300, Vec3::UnitZ());
  EXPECT_TRUE(are_unit(weiszfeld_normals(repeated, cloud)));
  cloud.normals.assign(300, Vec3::Zero());  // none that counts
  EXPECT_TRUE(are_unit(weiszfeld_normals(repeated, cloud)));
}

TEST(Normals, of_any_h_are_unit_vectors) {
  const SampledShape sphere = test::random_sphere(200, 1);
  PointCloud cloud = sphere.cloud();
  cloud.normals = sphere.normals;
  const Mixture mixture = mixture_of(cloud.positions, cloud.normals, 1e-4, 0);
  std::vector<Vec3> queries = cloud.positions;
  queries.insert(queries.end(), {Vec3(0, 0, 0), Vec3(1e9, 0, 0), Vec3(-1e50, 1, 1)});
  for (const double h : {1e-300, 1e-20, 1e-3, 1.0, 1e20, 1e100}) {
    EXPECT_TRUE(are_unit(weiszfeld_normals(queries, cloud, {.h = h}))) << h;
    EXPECT_TRUE(are_unit(csw_normals(queries, mixture, {.h = h}))) << h;
  }
  // Too narrow for more than the point itself, the median is its own normal.
  EXPECT_LT(largest_angle(weiszfeld_normals(cloud.positions, cloud, {.h = 1e-20}), cloud.normals), 1e-9);
}

TEST(Normals, refuse_what_has_none) {
  const std::vector<Vec3> two{{0, 0, 0}, {1, 0, 0}};
  EXPECT_THROW(pca_normals(two, two), NoSurfaceError);
  EXPECT_THROW(pca_normals(two, {}), NoSurfaceError);
  std::vector<Vec3> line;
  line.reserve(40);
  for (int i = 0; i < 40; ++i) line.push_back(i * Vec3(1, 2, 3));
  EXPECT_THROW(pca_normals(line, line), NoSurfaceError);
  EXPECT_THROW(pca_normals(std::vector<Vec3>(5, Vec3::UnitX()), std::vector<Vec3>(5, Vec3::UnitX())), NoSurfaceError);
  PointCloud cloud;
  EXPECT_THROW(weiszfeld_normals(two, cloud), InputError);
  cloud.positions = line;
  EXPECT_THROW(weiszfeld_normals(two, cloud), InputError);
  Mixture mixture = mixture_of(line, {}, 1, 0);
  EXPECT_THROW(csw_normals(two, Mixture{}), InputError);
  try {
    csw_normals(two, mixture);
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no normals"));
  }
  cloud.normals.assign(line.size(), Vec3::UnitX());
  EXPECT_THROW(weiszfeld_normals(std::vector<Vec3>{Vec3(0, nan, 0)}, cloud), InvariantError);
  const auto refused = [](const NormalOptions& options, const char* field) {
    try {
      options.check();
      ADD_FAILURE() << field;
    } catch (const OptionError& error) {
      EXPECT_THAT(error.what(), HasSubstr(field));
    }
  };
  refused({.neighbors = 2}, "neighbors");
  refused({.neighbors = 1001}, "neighbors");
  refused({.h = -1}, "h");
  refused({.h = nan}, "h");
  refused({.h = 1e200}, "h");
  refused({.iterations = -1}, "iterations");
  refused({.convergence = nan}, "convergence");
}

}  // namespace
}  // namespace gpsrecon
