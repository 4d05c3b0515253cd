#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/clop/kernel.h>
#include <gpsrecon/clop/project.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/neighbors.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cstring>

#include "support/random.h"
#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::cloud_of;
using test::Random;

/// The attraction alone.
ProjectOptions still(double h, int iterations) {
  ProjectOptions options;
  options.support_radius = h;
  options.iterations = iterations;
  options.repulsion = 0;
  options.convergence = 0;
  return options;
}

/// Positions of one particle after every iteration.
template <class Target>
std::vector<Vec3> path(const Vec3& start, const Target& target, ProjectOptions options) {
  std::vector<Vec3> places{start};
  options.on_iteration = [&](const ProjectionProgress& p) { places.push_back(p.positions[0]); };
  project(cloud_of({start}), target, options);
  return places;
}

/// ∫ x Σ_s w_s g_s(x) κ(|x - q|) dx / ∫ Σ_s w_s g_s(x) κ(|x - q|) dx (Preiner et al. 2014, Eq. 15) by the trapezoidal
/// rule in the coordinates in which one Gaussian of the kernel times one of the mixture is round: exact to rounding for
/// integrands this smooth. The product itself is never formed in closed form: the integrand is evaluated as printed.
class Integral {
 public:
  Integral(const Mixture& mixture, const Vec3& q) : mixture_(mixture), q_(q) {}

  /// Adds the term weight · exp(-r²/(2 deviation²)) of the kernel.
  void add(double weight, double deviation) {
    for (std::size_t s = 0; s < mixture_.size(); ++s) {
      const Mat3 sigma = mixture_.covariances[s].matrix();
      const Mat3 precision = sigma.inverse();
      const double normaliser = 1 / std::sqrt((2 * std::numbers::pi * sigma).determinant());
      const auto integrand = [&](const Vec3& x) {
        const Vec3 d = x - mixture_.means[s];
        return mixture_.weights[s] * normaliser * std::exp(-0.5 * d.dot(precision * d)) * weight *
               std::exp(-(x - q_).squaredNorm() / (2 * deviation * deviation));
      };
      // Where to integrate; what is integrated does not know of it.
      const Mat3 joint = precision + Mat3::Identity() / (deviation * deviation);
      const Vec3 peak = joint.inverse() * (precision * mixture_.means[s] + q_ / (deviation * deviation));
      const Mat3 spread = Eigen::LLT<Mat3>(joint.inverse()).matrixL();
      constexpr double step = 0.5;
      constexpr int n = 17;
      const double cell = std::pow(step, 3) * spread.determinant();
      for (int i = -n; i <= n; ++i)
        for (int j = -n; j <= n; ++j)
          for (int k = -n; k <= n; ++k) {
            const Vec3 x = peak + spread * (step * Vec3(i, j, k));
            const double w = cell * integrand(x);
            total_ += w;
            moment_ += w * (x - q_);
          }
    }
  }
  Vec3 mean() const { return q_ + moment_ / total_; }

 private:
  const Mixture& mixture_;
  Vec3 q_;
  double total_ = 0;
  Vec3 moment_ = Vec3::Zero();
};

Mixture random_mixture(std::size_t n, Random& random, double low, double high) {
  Mixture mixture;
  for (std::size_t s = 0; s < n; ++s) {
    mixture.means.push_back(0.3 * random.vector());
    mixture.covariances.push_back(random.covariance(low, high));
    mixture.weights.push_back(random.uniform(0.5, 20));
  }
  return mixture;
}

TEST(Clop, ForceIsTheIntegralOfTheDensityTimesTheKernel) {
  Random random(3);
  for (const KernelCoefficients coefficients : {KernelCoefficients::published, KernelCoefficients::tail})
    for (int trial = 0; trial < 12; ++trial) {
      const double h = random.uniform(0.6, 1.5);
      // All within reach, so that the rule which Gaussians count plays no part.
      const Mixture mixture = random_mixture(3, random, 1e-4, 0.04);
      ProjectOptions options = still(h, 2);
      options.kernel = coefficients;
      const std::vector<Vec3> places = path(0.2 * random.vector(), mixture, options);

      Integral first(mixture, places[0]);
      first.add(1, h / std::sqrt(32.0));
      EXPECT_LT((places[1] - first.mean()).norm(), 1e-6 * h) << "trial " << trial;

      Integral second(mixture, places[1]);
      const KernelFit kernel = kernel_fit(coefficients);
      for (std::size_t k = 0; k < 3; ++k) second.add(kernel.weight[k], kernel.deviation[k] * h);
      EXPECT_LT((places[2] - second.mean()).norm(), 1e-6 * h) << "trial " << trial;
    }
}

TEST(Clop, GaussiansThatDoNotCountHardlyMatter) {
  // A sheet of wide, flat Gaussians that reaches far beyond the ball, against the sum over all of them as printed.
  const test::SampledShape plane = test::rectangle(400, 4, 4, 5);
  const Mixture mixture = test::tangent_discs(plane, 1.0, 0.1);
  const double h = 2 * mixture.spacing;
  Random random(8);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 start = random.vector() + Vec3(0, 0, random.uniform(-0.3, 0.3) * h);
    const std::vector<Vec3> places =
        path({start.x(), start.y(), 0.5 * h * random.uniform(-1, 1)}, mixture, still(h, 2));
    const KernelFit kernel = kernel_fit(KernelCoefficients::published);
    double total = 0;
    Vec3 sum = Vec3::Zero();
    for (std::size_t s = 0; s < mixture.size(); ++s)
      for (std::size_t k = 0; k < 3; ++k) {
        const double variance = std::pow(kernel.deviation[k] * h, 2);
        const Mat3 lambda = mixture.covariances[s].matrix() + variance * Mat3::Identity();
        const Vec3 d = mixture.means[s] - places[1];
        const double w = mixture.weights[s] * kernel.weight[k] * std::pow(variance, 1.5) /
                         std::sqrt(lambda.determinant()) * std::exp(-0.5 * d.dot(lambda.inverse() * d));
        total += w;
        sum += w * variance * (lambda.inverse() * d);
      }
    EXPECT_LT((places[2] - places[1] - sum / total).norm(), 1e-3 * h);
  }
}

TEST(Clop, KernelAgainstTheOneItStandsFor) {
  // The errors that kernel.h states.
  const KernelFit published = kernel_fit(KernelCoefficients::published), tail = kernel_fit(KernelCoefficients::tail);
  const auto error = [](const KernelFit& fit, double r) { return fit(r) / (theta(r) / r) - 1; };
  std::printf("    r   published      tail\n");
  for (const double r : {0.002, 0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.06, 0.08, 0.12, 0.16, 0.2, 0.3, 0.4, 0.5})
    std::printf("%5.2f   %8.1f%%  %7.1f%%\n", r, 100 * error(published, r), 100 * error(tail, r));
  EXPECT_NEAR(error(published, 0.3), -0.44, 0.01);
  double lowest = 0, highest = 0;
  for (double r = 0.015; r < 0.08; r += 0.001) {
    lowest = std::min(lowest, error(tail, r));
    highest = std::max(highest, error(tail, r));
  }
  EXPECT_NEAR(error(tail, 0.01), -0.28, 0.01);
  EXPECT_GT(lowest, -0.1);
  EXPECT_LT(highest, 0.18);
  for (double r = 0.08; r <= 0.4; r += 0.001) EXPECT_LT(std::abs(error(tail, r)), 0.055) << r;
}

TEST(Clop, VanishingCovariancesAreLopWithTheSameKernel) {
  Random random(11);
  Mixture mixture;
  for (int s = 0; s < 40; ++s) {
    mixture.means.push_back(random.vector(-0.4, 0.4));
    mixture.covariances.push_back(Sym3::identity(1e-24));
    mixture.weights.push_back(random.uniform(1, 5));
  }
  const double h = 1;
  const KernelFit kernel = kernel_fit(KernelCoefficients::published);
  for (int trial = 0; trial < 20; ++trial) {
    const std::vector<Vec3> places = path(random.vector(-0.2, 0.2), mixture, still(h, 3));
    for (std::size_t k = 0; k + 1 < places.size(); ++k) {
      double total = 0;
      Vec3 sum = Vec3::Zero();
      for (std::size_t j = 0; j < mixture.size(); ++j) {
        const double r = (mixture.means[j] - places[k]).norm();
        if (r > h) continue;
        const double w = mixture.weights[j] * (k == 0 ? theta(r) : kernel(r));
        total += w;
        sum += w * mixture.means[j];
      }
      EXPECT_LT((places[k + 1] - sum / total).norm(), 1e-9);
    }
  }
}

TEST(Lop, IsTheEquationAsPrinted) {
  Random random(12);
  PointCloud points;
  for (int j = 0; j < 60; ++j) points.positions.push_back(random.vector(-0.5, 0.5));
  const double h = 0.8;
  for (const bool balance : {false, true}) {
    ProjectOptions options = still(h, 3);
    options.balance = balance;
    const std::vector<Vec3> places = path(random.vector(-0.2, 0.2), points, options);
    for (std::size_t k = 0; k + 1 < places.size(); ++k) {
      double total = 0;
      Vec3 sum = Vec3::Zero();
      for (const Vec3& p : points.positions) {
        double density = 1;  // Eq. 25
        for (const Vec3& other : points.positions)
          if (&other != &p && (other - p).norm() <= h) density += theta((other - p).norm() / h);
        const double r = (p - places[k]).norm() / h;
        if (r > 1) continue;
        ASSERT_GT(r, 1 / 139.0);  // so that the limit at the singularity plays no part
        const double w = (k == 0 ? theta(r) : theta(r) / r) / (balance ? density : 1);
        total += w;
        sum += w * p;
      }
      EXPECT_LT((places[k + 1] - sum / total).norm(), 1e-12);
    }
  }
}

TEST(Lop, FindsTheLocalMedian) {
  // At the fixed point Σ θ_j u_j = 0, u_j the unit vectors to the points: what Weiszfeld's iteration converges to.
  Random random(13);
  PointCloud points;
  for (int j = 0; j < 30; ++j) points.positions.push_back(random.vector(-0.3, 0.3));
  ProjectOptions options = still(1, 1000);
  options.balance = false;
  const Vec3 q = path({0.02, 0.03, 0.04}, points, options).back();
  Vec3 gradient = Vec3::Zero();
  for (const Vec3& p : points.positions) {
    ASSERT_GT((p - q).norm(), 1 / 139.0);
    if ((p - q).norm() <= 1) gradient += theta((p - q).norm()) * (p - q).normalized();
  }
  EXPECT_LT(gradient.norm(), 1e-9);
}

TEST(Repulsion, IsTheEquationAsPrinted) {
  // The moments of the last iteration are computed from the positions of the one before.
  const test::SampledShape plane = test::rectangle(300, 1, 1, 15);
  ProjectOptions options;
  options.support_radius = 0.3;
  options.iterations = 4;
  options.repulsion_interval = 1;
  options.convergence = 0;
  std::vector<Vec3> before, repulsion;
  options.on_iteration = [&](const ProjectionProgress& p) {
    if (p.iteration == 3) before.assign(p.positions.begin(), p.positions.end());
    repulsion.assign(p.repulsion.begin(), p.repulsion.end());
  };
  project(cloud_of(plane.points), plane.cloud(), options);
  for (std::size_t i = 0; i < before.size(); ++i) {
    double total = 0;
    Vec3 sum = Vec3::Zero();
    for (std::size_t j = 0; j < before.size(); ++j) {
      const double r = (before[i] - before[j]).norm();
      if (j == i || r > 0.15) continue;
      const double beta = theta(r / 0.3) / r;
      total += beta;
      sum += beta * (before[i] - before[j]);
    }
    EXPECT_LT((repulsion[i] - (total > 0 ? Vec3(sum / total) : Vec3::Zero())).norm(), 1e-12);
  }
}

TEST(Repulsion, IsRenewedAsOftenAsAskedAndInTheLastIteration) {
  const test::SampledShape plane = test::rectangle(200, 1, 1, 15);
  ProjectOptions options;
  options.support_radius = 0.3;
  options.iterations = 7;
  options.repulsion_interval = 3;
  options.convergence = 0;
  std::vector<std::vector<Vec3>> moments;
  options.on_iteration = [&](const ProjectionProgress& p) {
    moments.emplace_back(p.repulsion.begin(), p.repulsion.end());
  };
  project(cloud_of(plane.points), plane.cloud(), options);
  const auto renewed = [&](std::size_t iteration) { return moments[iteration - 1] != moments[iteration - 2]; };
  EXPECT_TRUE(renewed(2));
  EXPECT_FALSE(renewed(3));
  EXPECT_FALSE(renewed(4));
  EXPECT_TRUE(renewed(5));
  EXPECT_FALSE(renewed(6));
  EXPECT_TRUE(renewed(7));
}

/// Standard deviation of nearest-neighbour distances over their mean.
double irregularity(std::span<const Vec3> points) {
  const Neighbors index(points);
  std::vector<Neighbor> near;
  std::vector<double> d;
  double mean = 0, square = 0;
  for (const Vec3& p : points) {
    index.nearest(p, 2, near);
    d.push_back(near[1].distance);
    mean += d.back() / static_cast<double>(points.size());
  }
  for (const double x : d) square += (x - mean) * (x - mean) / static_cast<double>(points.size());
  return std::sqrt(square) / mean;
}

Mixture sphere_mixture(std::size_t n) {
  return test::tangent_discs(test::fibonacci_sphere(n), 0.6, 0.1);
}

TEST(Repulsion, RegularityFallsMonotonically) {
  // Smaller is more regular. With the repulsion renewed in every iteration, as reuse makes it oscillate.
  const Mixture mixture = sphere_mixture(2000);
  const PointCloud particles = test::random_sphere(2000, 21).cloud();
  ProjectOptions options;
  options.support_radius = 6 * mixture.spacing;
  options.repulsion_interval = 1;
  options.convergence = 0;
  std::vector<double> series;
  options.on_iteration = [&](const ProjectionProgress& p) { series.push_back(irregularity(p.positions)); };
  project(particles, mixture, options);
  for (std::size_t k = 2; k < series.size(); ++k) EXPECT_LT(series[k], series[k - 1] + 1e-3) << "iteration " << k + 1;
  EXPECT_LT(series.back(), 0.5 * irregularity(particles.positions));
}

TEST(Project, CommutesWithRigidMotionsAndScales) {
  Random random(17);
  const test::SampledShape shape = test::torus(1500, 1, 0.4);
  const Mixture mixture = test::tangent_discs(shape);
  const PointCloud particles = cloud_of({shape.points.begin(), shape.points.begin() + 400});
  const Mat3 r = random.rotation();
  const Vec3 t = random.vector();
  for (const double scale : {1.0, 1000.0}) {
    const auto moved = [&](std::vector<Vec3> points) {
      for (Vec3& p : points) p = scale * (r * p + t);
      return points;
    };
    Mixture moved_mixture = mixture;
    moved_mixture.means = moved(mixture.means);
    for (Sym3& c : moved_mixture.covariances) c = congruence(scale * r, c);
    ProjectOptions options;
    options.support_radius = 5 * mixture.spacing;
    options.iterations = 6;
    const std::vector<Vec3> expected_clop = moved(project(particles, mixture, options).positions);
    const std::vector<Vec3> expected_wlop = moved(project(particles, shape.cloud(), options).positions);
    options.support_radius *= scale;
    const PointCloud moved_particles = cloud_of(moved(particles.positions));
    const std::vector<Vec3> clop = project(moved_particles, moved_mixture, options).positions;
    const std::vector<Vec3> wlop = project(moved_particles, cloud_of(moved(shape.points)), options).positions;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      EXPECT_LT((clop[i] - expected_clop[i]).norm(), 1e-9 * scale);
      EXPECT_LT((wlop[i] - expected_wlop[i]).norm(), 1e-9 * scale);
    }
  }
}

TEST(Project, PowersOfTwoChangeNoBit) {
  const test::SampledShape shape = test::torus(800, 1, 0.4);
  Mixture mixture = test::tangent_discs(shape);
  ProjectOptions options;
  options.support_radius = 5 * mixture.spacing;
  const std::vector<Vec3> once = project(shape.cloud(), mixture, options).positions;
  std::vector<Vec3> points = shape.points;
  for (Vec3& p : points) p *= 1024;
  for (Vec3& p : mixture.means) p *= 1024;
  for (Sym3& c : mixture.covariances) c *= 1024.0 * 1024.0;
  options.support_radius *= 1024;
  const std::vector<Vec3> scaled = project(cloud_of(points), mixture, options).positions;
  for (std::size_t i = 0; i < once.size(); ++i) EXPECT_EQ(1024 * once[i], scaled[i]);
}

/// A plane with a share of outliers, uniform in a slab as thick as `h` on one side of it, where a mean must be pulled.
struct Outliers {
  PointCloud cloud;
  std::vector<Vec3> inliers;
};
Outliers plane_with_outliers(double share, double height, std::uint64_t seed) {
  Random random(seed);
  Outliers result;
  const std::size_t n = 2000;
  for (std::size_t i = 0; i < n; ++i) {
    const bool outlier = random.uniform() < share;
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1);
    const double z = outlier ? random.uniform(0, height) : 0;
    result.cloud.positions.emplace_back(x, y, z);
    if (!outlier && std::max(std::abs(x), std::abs(y)) < 0.7) result.inliers.emplace_back(x, y, z);
  }
  return result;
}

Mixture small_balls(const PointCloud& cloud, double deviation) {
  Mixture mixture;
  mixture.means = cloud.positions;
  mixture.covariances.assign(cloud.size(), Sym3::identity(deviation * deviation));
  mixture.weights.assign(cloud.size(), 1.0);
  return mixture;
}

TEST(Project, ParticlesOfAPlaneWithOutliersStayInThePlane) {
  // All in the plane but a few points far off it: no force leaves the plane, for every model.
  Outliers data = plane_with_outliers(0, 0, 31);
  for (int k = 0; k < 60; ++k)
    data.cloud.positions.emplace_back(std::sin(3.0 * k), std::cos(5.0 * k), (k % 2 ? 0.4 : -0.4));
  ProjectOptions options;
  options.support_radius = 0.3;
  const PointCloud particles = cloud_of(data.inliers);
  for (const bool balance : {false, true}) {
    options.balance = balance;
    for (const Vec3& p : project(particles, data.cloud, options).positions) EXPECT_EQ(p.z(), 0);
  }
  for (const Vec3& p : project(particles, small_balls(data.cloud, 0.01), options).positions)
    EXPECT_LT(std::abs(p.z()), 1e-12);
}

TEST(Project, BreakdownCurve) {
  // Outliers on one side, up to 40 %: the mean moves as they become more, the median hardly.
  const double h = 0.4, height = 0.2;
  std::printf("outliers   mean    LOP     WLOP    CLOP   (offset / height of the outliers)\n");
  for (const double share : {0.0, 0.1, 0.2, 0.3, 0.4}) {
    const Outliers data = plane_with_outliers(share, height, 33);
    ProjectOptions options;
    options.support_radius = h;
    options.iterations = 15;
    options.repulsion = 0;
    const PointCloud particles = cloud_of({data.inliers.begin(), data.inliers.begin() + 100});
    const auto offset = [&](const PointCloud& projected) {
      double sum = 0;
      for (const Vec3& p : projected.positions) sum += p.z() / 100;
      return sum / height;
    };
    ProjectOptions first = options;
    first.iterations = 1;
    first.balance = false;
    const double mean = offset(project(particles, data.cloud, first));
    options.balance = false;
    const double lop = offset(project(particles, data.cloud, options));
    options.balance = true;
    const double wlop = offset(project(particles, data.cloud, options));
    const double clop = offset(project(particles, small_balls(data.cloud, 0.01), options));
    std::printf("  %4.0f %%  %6.3f  %6.3f  %6.3f  %6.3f\n", 100 * share, mean, lop, wlop, clop);
    // The mean of all points is at s/2 of the height, 0.2 for 40 %, that of the kernel at a third of it, and the
    // medians well below that for every share up to where medians break down.
    EXPECT_LT(std::max(lop, clop), 1e-9 + 0.65 * mean) << share;
    EXPECT_LT(std::max(lop, clop), 0.25 * share / 2 + 1e-9) << share;
  }
}

TEST(Project, NothingInReachIsANoOp) {
  const Mixture mixture = sphere_mixture(200);
  ProjectOptions options;
  options.support_radius = 0.2;
  const PointCloud far = cloud_of({{100, 0, 0}, {100, 0.01, 0}});
  EXPECT_EQ(project(far, mixture, options).positions, far.positions);
  EXPECT_EQ(project(far, test::fibonacci_sphere(200).cloud(), options).positions, far.positions);
  EXPECT_EQ(project(far, Mixture(), options).positions, far.positions);
  EXPECT_EQ(project(far, PointCloud(), options).positions, far.positions);
  EXPECT_TRUE(project(PointCloud(), mixture, options).empty());
  options.support_radius = 1e-200;  // absurd: nothing is that near, and what is at the very place stays there
  EXPECT_EQ(project(far, mixture, options).positions, far.positions);
}

TEST(Project, AbsurdlyWideKernelsGiveFinitePlaces) {
  const test::SampledShape sphere = test::fibonacci_sphere(200);
  const Mixture mixture = test::tangent_discs(sphere);
  ProjectOptions options;
  options.support_radius = 1e6;
  for (const Vec3& p : project(sphere.cloud(), mixture, options).positions) EXPECT_LT(p.norm(), 2);
  for (const Vec3& p : project(sphere.cloud(), sphere.cloud(), options).positions) EXPECT_LT(p.norm(), 2);
}

TEST(Project, CoincidingParticlesPart) {
  const Mixture mixture = sphere_mixture(1000);
  PointCloud particles;
  for (int k = 0; k < 50; ++k) particles.positions.push_back(Vec3(0, 0, 1));
  ProjectOptions options;
  options.support_radius = 6 * mixture.spacing;
  options.iterations = 30;
  options.convergence = 0;
  const std::vector<Vec3> parted = project(particles, mixture, options).positions;
  const Neighbors index(parted);
  std::vector<Neighbor> near;
  for (const Vec3& p : parted) {
    EXPECT_NEAR(p.norm(), 1, 0.05);
    index.nearest(p, 2, near);
    EXPECT_GT(near[1].distance, 0.02 * options.support_radius);
  }
}

TEST(Project, OnePointAndOneParticle) {
  ProjectOptions options;
  options.support_radius = 1;
  const PointCloud point = cloud_of({{0.1, 0.2, 0.3}});
  const Vec3 at = project(cloud_of({{0.1, 0.5, 0.3}}), point, options).positions[0];
  EXPECT_LT((at - point.positions[0]).norm(), 1e-12);
  EXPECT_EQ(project(point, point, options).positions, point.positions);
}

TEST(Project, SameBytesForAnyNumberOfThreads) {
  const test::SampledShape shape = test::torus(3000, 1, 0.4);
  const Mixture mixture = test::tangent_discs(shape);
  ProjectOptions options;
  options.support_radius = 5 * mixture.spacing;
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  EXPECT_EQ(project(shape.cloud(), mixture, options, one).positions,
            project(shape.cloud(), mixture, options, four).positions);
  EXPECT_EQ(project(shape.cloud(), shape.cloud(), options, one).positions,
            project(shape.cloud(), shape.cloud(), options, four).positions);
}

TEST(Project, StopsWhenNothingMovesAnyMore) {
  const Mixture mixture = sphere_mixture(500);
  ProjectOptions options = still(5 * mixture.spacing, 1000);
  options.convergence = 1e-3;
  int iterations = 0;
  double last = 1;
  options.on_iteration = [&](const ProjectionProgress& p) { iterations = p.iteration, last = p.largest_move; };
  project(test::fibonacci_sphere(100).cloud(), mixture, options);
  EXPECT_LT(iterations, 1000);
  EXPECT_LE(last, 1e-3 * options.support_radius);
}

TEST(Project, RefusesWhatMakesNoSense) {
  const auto refused = [](auto change) {
    ProjectOptions options;
    options.support_radius = 1;
    change(options);
    EXPECT_THROW(project(cloud_of({{0, 0, 0}}), sphere_mixture(10), options), OptionError);
  };
  refused([](ProjectOptions& o) { o.support_radius = 0; });
  refused([](ProjectOptions& o) { o.support_radius = std::numeric_limits<double>::quiet_NaN(); });
  refused([](ProjectOptions& o) { o.support_radius = std::numeric_limits<double>::infinity(); });
  refused([](ProjectOptions& o) { o.iterations = 0; });
  refused([](ProjectOptions& o) { o.repulsion = 0.5; });
  refused([](ProjectOptions& o) { o.repulsion = -0.1; });
  refused([](ProjectOptions& o) { o.repulsion_cutoff = 0; });
  refused([](ProjectOptions& o) { o.repulsion_interval = 0; });
  refused([](ProjectOptions& o) { o.convergence = -1; });
  ProjectOptions options;
  options.support_radius = 1;
  Mixture elsewhere = sphere_mixture(10);
  elsewhere.frame.exponent = 3;
  EXPECT_THROW(project(cloud_of({{0, 0, 0}}), elsewhere, options), InvariantError);
  EXPECT_THROW(project(cloud_of({{0, std::numeric_limits<double>::quiet_NaN(), 0}}), sphere_mixture(10), options),
               InvariantError);
}

}  // namespace
}  // namespace gpsrecon
