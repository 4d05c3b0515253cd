#include <gtest/gtest.h>
#include <algorithm>
#include <numbers>

#include <gpsrecon/hem/initial_mixture.h>
#include <Eigen/Eigenvalues>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::Random;

double angle_of_axes(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b)));
}

/// Distance to the k-th of the points nearest to points[i], itself the first.
double reach(const std::vector<Vec3>& points, std::size_t i, std::size_t k) {
  std::vector<double> distances;
  for (const Vec3& p : points) distances.push_back((p - points[i]).norm());
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(k - 1), distances.end());
  return distances[k - 1];
}

TEST(InitialMixture, IsotropicKernels) {
  const PointCloud cloud = test::random_sphere(100, 31).cloud();
  const Mixture m = initial_mixture(cloud, Neighbors(cloud.positions), {.sigma0 = 0.125},
                                    {.initial = InitialCovariance::isotropic}, {});
  ASSERT_NO_THROW(validate(m));
  EXPECT_EQ(m.means, cloud.positions);
  EXPECT_EQ(m.sigma0, 0.125);
  EXPECT_TRUE(m.normals.empty());
  for (std::size_t i = 0; i < m.size(); ++i) {
    EXPECT_EQ(m.covariances[i], Sym3::identity(0.015625));
    EXPECT_EQ(m.weights[i], 1.0);
  }
}

TEST(InitialMixture, LocalCovarianceOfAPlane) {
  // A tilted plane: the smallest axis is the normal with deviation σ0, the largest has sqrt(A² + σ0²) by construction.
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  PointCloud cloud = test::rectangle(500, 1, 1, 32).cloud();
  for (Vec3& p : cloud.positions) p = turn * p;
  const double spacing = 0.1, sigma0 = 0.04;  // nowhere sparser than this, rim included
  const Mixture m =
      initial_mixture(cloud, Neighbors(cloud.positions), {sigma0, spacing}, {.initial = InitialCovariance::local}, {});
  ASSERT_NO_THROW(validate(m));
  for (const Sym3& covariance : m.covariances) {
    const Eigen3 e = eigen_decomposition(covariance);
    EXPECT_LT(angle_of_axes(e.vectors.col(0), turn.col(2)), 1e-6);
    EXPECT_NEAR(e.values[0], sigma0 * sigma0, 1e-14);
    EXPECT_NEAR(e.values[2], spacing * spacing + sigma0 * sigma0, 1e-14);
  }
}

TEST(InitialMixture, GaussiansWidenWhereTheCloudIsSparse) {
  // A square grid has λmax = spacing² k/(4π) around a point up to the shape of the neighbourhood, so where the grid is
  // s times wider than `spacing` the squared spacing is 0.6 s² times that, between 1 and 9 times; σ0² grows by 0.16 of
  // it.
  const double spacing = 0.01, sigma0 = 0.004;
  for (const double s : {0.5, 1.0, 2.0, 3.0, 6.0}) {
    PointCloud cloud;
    for (int i = -6; i <= 6; ++i)
      for (int j = -6; j <= 6; ++j) cloud.positions.push_back(s * spacing * Vec3(i, j, 0));
    const std::size_t center = cloud.size() / 2;
    const Mixture m = initial_mixture(cloud, Neighbors(cloud.positions), {sigma0, spacing},
                                      {.initial = InitialCovariance::local, .neighbors = 21}, {});
    const Eigen3 e = eigen_decomposition(m.covariances[center]);
    // The 21 nearest points of the grid are those with i² + j² <= 5.
    double sum = 0;
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j <= 2; ++j)
        if (i * i + j * j <= 5) sum += i * i;
    const double largest = s * s * spacing * spacing * sum / 21;
    const double squared =
        std::clamp(0.6 * 4 * std::numbers::pi * largest / 21, spacing * spacing, 9 * spacing * spacing);
    const double kernel = sigma0 * sigma0 + 0.16 * (squared - spacing * spacing);
    EXPECT_NEAR(e.values[2], squared + kernel, 1e-12 * squared) << s;
    EXPECT_NEAR(e.values[0], kernel, 1e-12 * squared) << s;
    EXPECT_EQ(squared > spacing * spacing, s >= 2) << s;
    EXPECT_EQ(squared < 9 * spacing * spacing, s <= 3) << s;
  }
}

TEST(InitialMixture, LocalCovarianceIsThatOfTheNeighbours) {
  // Second implementation: sort all distances, two-pass covariance.
  Random random(33);
  PointCloud cloud;
  for (int i = 0; i < 120; ++i) cloud.positions.push_back(random.vector(0, 1));
  const int k = 9;
  const double spacing = 0.2, sigma0 = 0.05;
  const Mixture m = initial_mixture(cloud, Neighbors(cloud.positions), {sigma0, spacing},
                                    {.initial = InitialCovariance::local, .neighbors = k}, {});
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double radius = reach(cloud.positions, i, k);
    std::vector<Vec3> near;
    for (const Vec3& p : cloud.positions)
      if ((p - cloud.positions[i]).norm() <= radius) near.push_back(p);
    ASSERT_EQ(near.size(), static_cast<std::size_t>(k));
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : near) mean += p / k;
    Mat3 covariance = Mat3::Zero();
    for (const Vec3& p : near) covariance += (p - mean) * (p - mean).transpose() / k;
    const double largest = Eigen::SelfAdjointEigenSolver<Mat3>(covariance).eigenvalues()[2];
    const double squared =
        std::clamp(0.6 * 4 * std::numbers::pi * largest / k, spacing * spacing, 9 * spacing * spacing);
    const Mat3 expected =
        squared / largest * covariance + (sigma0 * sigma0 + 0.16 * (squared - spacing * spacing)) * Mat3::Identity();
    EXPECT_LT((m.covariances[i].matrix() - expected).norm(), 1e-14);
  }
}

TEST(InitialMixture, NormalsFromPrincipalComponentsOfASphere) {
  const test::SampledShape sphere = test::random_sphere(2000, 34);
  const Mixture m = initial_mixture(sphere.cloud(), Neighbors(sphere.cloud().positions), {.sigma0 = 0.1},
                                    {.initial = InitialCovariance::isotropic, .normals = true}, {});
  ASSERT_NO_THROW(validate(m));
  ASSERT_EQ(m.normals.size(), 2000U);
  for (std::size_t i = 0; i < m.size(); ++i) {
    // The fitted normal is one of those that the sphere has in the neighbourhood.
    EXPECT_LT(angle_of_axes(m.normals[i], sphere.normals[i]), reach(sphere.points, i, 16));
    EXPECT_EQ(m.normal_variances[i], 0.0);
  }
}

TEST(InitialMixture, NormalsOfTheCloudAreNormalised) {
  PointCloud cloud = test::fibonacci_sphere(500).cloud();
  for (const Vec3& p : cloud.positions) cloud.normals.push_back(3.7 * p);
  cloud.normals[4] = Vec3::Zero();  // unknown
  cloud.normals[400] = Vec3::Constant(std::nan(""));
  const Mixture m = initial_mixture(cloud, Neighbors(cloud.positions), {.sigma0 = 0.1},
                                    {.initial = InitialCovariance::isotropic, .normals = true}, {});
  ASSERT_NO_THROW(validate(m));
  for (std::size_t i = 0; i < m.size(); ++i)
    if (i != 4 && i != 400) {
      EXPECT_LT((m.normals[i] - cloud.positions[i]).norm(), 1e-15);
    } else {  // estimated
      EXPECT_LT(angle_of_axes(m.normals[i], cloud.positions[i]), reach(cloud.positions, i, 16));
    }
}

TEST(InitialMixture, BalancedWeightsAreEqualPerArea) {
  // On a square grid the sum of a Gaussian over the grid is its integral times the density, to exp(-π²q²/a²) for
  // width q and grid size a: the balanced weight of a point is then the area it stands for. A cut-off at 3q leaves
  // out e⁻⁹ of the integral.
  PointCloud cloud;
  const double dense = 0.5, sparse = 1;
  for (int x = 0; x < 48; ++x)
    for (int y = 0; y < 48; ++y) cloud.positions.emplace_back(-dense * (x + 0.5), dense * y, 0);
  for (int x = 0; x < 24; ++x)
    for (int y = 0; y < 24; ++y) cloud.positions.emplace_back(sparse * (x + 0.5), sparse * y, 0);
  const Mixture m = initial_mixture(cloud, Neighbors(cloud.positions), {1, 1},
                                    {.initial = InitialCovariance::isotropic, .balance = true}, {});
  ASSERT_NO_THROW(validate(m));
  const double total = std::accumulate(m.weights.begin(), m.weights.end(), 0.0);
  EXPECT_NEAR(total, static_cast<double>(cloud.size()), 1e-9);
  double unit = 0;  // weight per area, from the first inner point
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3& p = cloud.positions[i];
    if (std::abs(p.x()) < 5 || std::abs(p.x()) > 19 || p.y() < 5 || p.y() > 18) continue;
    const double area = p.x() < 0 ? dense * dense : sparse * sparse;
    if (unit == 0) unit = m.weights[i] / area;
    EXPECT_NEAR(m.weights[i] / area / unit, 1, 1e-3);
  }
}

TEST(InitialMixture, BalanceCountsCoincidentPoints) {
  // A point of weight three is as dense, and as heavy, as three points.
  Random random(35);
  PointCloud merged, apart;
  for (int i = 0; i < 400; ++i) {
    merged.positions.push_back(random.vector(0, 5));
    merged.weights.push_back(static_cast<double>(1 + random.below(3)));
    for (int k = 0; k < merged.weights.back(); ++k) apart.positions.push_back(merged.positions.back());
  }
  const Kernel kernel{1, 0.5};
  const HemOptions options{.initial = InitialCovariance::isotropic, .balance = true};
  const Mixture one = initial_mixture(merged, Neighbors(merged.positions), kernel, options, {}),
                many = initial_mixture(apart, Neighbors(apart.positions), kernel, options, {});
  for (std::size_t i = 0, k = 0; i < one.size(); ++i) {
    double together = 0;
    for (const std::size_t end = k + static_cast<std::size_t>(merged.weights[i]); k < end; ++k)
      together += many.weights[k];
    EXPECT_NEAR(one.weights[i], together, 1e-12);
  }
}

}  // namespace
}  // namespace gpsrecon
