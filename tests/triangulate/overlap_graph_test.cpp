#include <gtest/gtest.h>

#include <gpsrecon/triangulate/front.h>
#include <gpsrecon/triangulate/overlap_graph.h>
#include <Eigen/LU>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::Random;

/// Gaussians of all sizes and shapes, flat ones too.
Mixture random_mixture(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  Mixture m;
  for (std::size_t i = 0; i < n; ++i) {
    const Mat3 turn = Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
                          .normalized()
                          .toRotationMatrix();
    const auto deviation = [&] { return std::exp(random.uniform(-4.5, -1.5)); };
    const double a = deviation(), b = deviation(), c = deviation();
    m.means.push_back(random.vector(-0.5, 0.5));
    m.covariances.push_back(congruence(turn, Sym3::diagonal(a * a, b * b, c * c)));
    m.weights.push_back(1);
  }
  return m;
}

/// Preiner et al. 2019, Eq. 19, as it is printed.
double brute_log_overlap(const Gaussian& a, const Gaussian& b) {
  const Mat3 sa = a.covariance.matrix(), sb = b.covariance.matrix(), mean = 0.5 * (sa + sb);
  const Vec3 d = a.mean - b.mean;
  const double distance = 0.125 * d.dot(mean.inverse() * d) +
                          0.5 * std::log(mean.determinant() / std::sqrt(sa.determinant() * sb.determinant()));
  return -distance;
}

TEST(OverlapGraph, EqualsBruteForce) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    for (const double least : {0.3, 0.01, 1e-5}) {
      const Mixture m = random_mixture(400, seed);
      const OverlapGraph graph = overlap_graph(m, least, {});
      ASSERT_EQ(graph.offset.size(), m.size() + 1);
      std::size_t links = 0;
      for (Index i = 0; i < m.size(); ++i)
        for (Index j = 0; j < m.size(); ++j) {
          const double* found = graph.find(i, j);
          if (i == j) {
            EXPECT_EQ(found, nullptr);
            continue;
          }
          const double expected = brute_log_overlap(m.component(i), m.component(j));
          ASSERT_EQ(found != nullptr, expected >= std::log(least)) << i << " " << j << " " << expected;
          if (found == nullptr) continue;
          ++links;
          EXPECT_NEAR(*found, expected, 1e-9);
          EXPECT_LE(*found, 0);
          EXPECT_EQ(*found, *graph.find(j, i));
        }
      EXPECT_EQ(links, graph.links.size());
      EXPECT_GT(links, 100U);
    }
}

TEST(OverlapGraph, RowsAreSorted) {
  const OverlapGraph graph = overlap_graph(random_mixture(300, 4), 0.01, {});
  for (Index i = 0; i < 300; ++i)
    EXPECT_TRUE(std::is_sorted(graph[i].begin(), graph[i].end(), [](auto& a, auto& b) { return a.to < b.to; }));
}

TEST(OverlapGraph, ReachesAsFarAsTheBoundAllows) {
  // Two equal Gaussians with the overlap 0.01 exactly: |Δμ|² = 8 λ ln 100 along an axis, the largest distance there is.
  const Sym3 covariance = Sym3::diagonal(0.04, 0.0025, 0.0001);
  const double reach = std::sqrt(8 * std::log(100) * 0.04);
  for (const double factor : {1 - 1e-9, 1 + 1e-9}) {
    Mixture m;
    m.means = {Vec3(0.3, 0, 0), Vec3(0.3 + factor * reach, 0, 0)};
    m.covariances.assign(2, covariance);
    m.weights.assign(2, 1.0);
    EXPECT_EQ(overlap_graph(m, 0.01, {}).links.size(), factor < 1 ? 2U : 0U);
  }
}

TEST(OverlapGraph, IsAffineInvariant) {
  const Mixture m = random_mixture(300, 5);
  const OverlapGraph reference = overlap_graph(m, 0.01, {});
  Mat3 map;
  map << 2, 0.3, -1, 0, 0.5, 0.2, 0.7, -0.4, 1.5;
  Mixture image = m;
  for (Vec3& mean : image.means) mean = map * mean + Vec3(3, -1, 2);
  for (Sym3& covariance : image.covariances) covariance = congruence(map, covariance);
  const OverlapGraph graph = overlap_graph(image, 0.01, {});
  ASSERT_EQ(graph.offset, reference.offset);
  for (std::size_t k = 0; k < graph.links.size(); ++k) {
    EXPECT_EQ(graph.links[k].to, reference.links[k].to);
    EXPECT_NEAR(graph.links[k].log_overlap, reference.links[k].log_overlap, 1e-9);
  }
}

TEST(OverlapGraph, SameForAnyNumberOfThreads) {
  const Mixture m = test::tangent_discs(test::random_sphere(3000, 6));
  RunContext context;
  context.threads = 1;
  const OverlapGraph reference = overlap_graph(m, 0.01, context);
  for (const int threads : {2, 4, 8}) {
    context.threads = threads;
    const OverlapGraph graph = overlap_graph(m, 0.01, context);
    ASSERT_EQ(graph.offset, reference.offset);
    for (std::size_t k = 0; k < graph.links.size(); ++k) {
      EXPECT_EQ(graph.links[k].to, reference.links[k].to);
      EXPECT_EQ(graph.links[k].log_overlap, reference.links[k].log_overlap);
    }
  }
}

TEST(OverlapGraph, OfNothingAndOfOne) {
  EXPECT_TRUE(overlap_graph({}, 0.01, {}).links.empty());
  EXPECT_TRUE(overlap_graph(random_mixture(1, 7), 0.01, {}).links.empty());
}

TEST(SheetNormals, FlatGaussiansHaveOneAndOthersNone) {
  const double kernel = 0.1;
  Random random(8);
  Mixture m;
  m.sigma0 = kernel;
  std::vector<Vec3> axes;
  const auto add = [&](double across, double middle, double along) {  // variances without the kernel
    const Vec3 normal = random.direction(), u = normal.unitOrthogonal(), v = normal.cross(u);
    m.means.push_back(random.vector(0, 1));
    m.covariances.push_back(across * Sym3::outer(normal) + middle * Sym3::outer(u) + along * Sym3::outer(v) +
                            Sym3::identity(kernel * kernel));
    m.weights.push_back(1);
    axes.push_back(normal);
  };
  add(0, 1, 2);
  add(0.2, 1, 1.1);
  add(0.3, 1, 1);      // too thick
  add(1e-3, 1e-3, 1);  // a crease: a line has no side
  const std::vector<Vec3> normals = sheet_normals(m, {});
  for (const std::size_t i : {0, 1}) EXPECT_NEAR(std::abs(normals[i].dot(axes[i])), 1, 1e-12);
  for (const std::size_t i : {2, 3}) EXPECT_EQ(normals[i], Vec3::Zero());
}

TEST(SheetNormals, PointsThatNeverMergedHaveNone) {
  // An orphan is still the isotropic kernel: it knows nothing of a sheet.
  Mixture m;
  for (const double sigma0 : {0.1, 0.037, 1.0 / 3}) {
    m.sigma0 = sigma0;
    m.means = {Vec3(0, 0, 0)};
    m.covariances = {Sym3::identity(sigma0 * sigma0)};
    m.weights = {1};
    EXPECT_EQ(sheet_normals(m, {})[0], Vec3::Zero());
  }
}

}  // namespace
}  // namespace gpsrecon
