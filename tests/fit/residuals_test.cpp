#include <gpsrecon/fit/residuals.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/covmeshes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::sphere_cloud;
using test::sphere_mesh;

/// A surface near the unit sphere with its samples.
struct Sampled {
  CovMesh mesh;
  LimitSurface surface;
  SurfaceSamples samples;
  explicit Sampled(double radius, int level = 2)
      : mesh(sphere_mesh(level, radius)),
        surface(mesh.faces, mesh.vertices.size(), 2),
        samples(surface.evaluate(mesh.vertices)) {}
};

void expect_closest(const Assignment& assignment, const SurfaceSamples& samples, const PointCloud& cloud) {
  ASSERT_EQ(assignment.sample.size(), cloud.size());
  ASSERT_EQ(assignment.offset.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3& p = cloud.positions[i];
    double closest2 = std::numeric_limits<double>::infinity();
    for (const Vec3& q : samples.positions) closest2 = std::min(closest2, (p - q).squaredNorm());
    const Index s = assignment.sample[i];
    EXPECT_NEAR((p - samples.positions[s]).squaredNorm(), closest2, 1e-15) << i;
    EXPECT_NEAR(assignment.offset[i], (p - samples.positions[s]).dot(samples.normals[s]), 1e-15) << i;
  }
}

TEST(Residuals, PointsBelongToTheClosestSample) {
  const Sampled sampled(0.97);
  const PointCloud cloud = sphere_cloud(500, 0.05);
  expect_closest(assign_points(sampled.samples, cloud, {}), sampled.samples, cloud);
}

TEST(Residuals, PointsFollowSamplesThatMove) {
  const Sampled before(0.97);
  const PointCloud cloud = sphere_cloud(500, 0.05);
  Assignment assignment = assign_points(before.samples, cloud, {});
  CovMesh mesh = before.mesh;
  const Mat3 rotation(Eigen::AngleAxisd(0.1, Vec3(1, 2, 3).normalized()));
  for (Vec3& mean : mesh.vertices.means) mean = rotation * mean;
  const SurfaceSamples after = before.surface.evaluate(mesh.vertices);
  reassign_points(after, sample_graph(before.surface), cloud, {}, assignment);
  expect_closest(assignment, after, cloud);
}

TEST(Residuals, SampleGraphHoldsTheEdgesOfTheFaces) {
  const Sampled sampled(1, 1);
  const SampleGraph graph = sample_graph(sampled.surface);
  ASSERT_EQ(graph.offset.size(), sampled.surface.sample_count() + 1);
  std::vector<std::pair<Index, Index>> found, expected;
  for (Index s = 0; s < sampled.surface.sample_count(); ++s)
    for (std::uint32_t e = graph.offset[s]; e < graph.offset[s + 1]; ++e) found.emplace_back(s, graph.next[e]);
  const FaceList& faces = sampled.surface.faces();
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      expected.emplace_back(faces[f][k], faces[f][(k + 1) % 3]);
      expected.emplace_back(faces[f][(k + 1) % 3], faces[f][k]);
    }
  std::sort(found.begin(), found.end());
  std::sort(expected.begin(), expected.end());
  expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
  EXPECT_EQ(found, expected);
}

TEST(Residuals, MedianOffsetIgnoresSigns) {
  EXPECT_EQ(median_offset({{}, {-3, 1, 2}}), 2);
  EXPECT_EQ(median_offset({{}, {5, -7, 0, -1, 6}}), 5);
}

TEST(Residuals, SumsAreBiweights) {
  const Sampled sampled(0.97);
  PointCloud cloud = sphere_cloud(3000, 0.03);
  test::Random random(3, test::sampling);
  for (int i = 0; i < 100; ++i) cloud.positions.push_back(random.uniform(1.2, 2) * random.direction());
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.weights.push_back(random.uniform(0.5, 2));
  std::vector<char> held_out(cloud.size());
  for (char& held : held_out) held = random.uniform() < 0.2;
  const Assignment assignment = assign_points(sampled.samples, cloud, {});
  const double scale = median_offset(assignment);
  const Residuals found = robust_residuals(sampled.surface, assignment, cloud, held_out, scale);

  const std::vector<Index> control = sampled.surface.control_of_samples();
  std::vector<double> weight(sampled.surface.sample_count(), 0.0), moment = weight, square = weight;
  std::size_t wider = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    // The definition: the median of |offset| over all points whose sample grew from the same control vertex.
    std::vector<double> around;
    for (std::size_t j = 0; j < cloud.size(); ++j)
      if (control[assignment.sample[j]] == control[assignment.sample[i]])
        around.push_back(std::abs(assignment.offset[j]));
    std::sort(around.begin(), around.end());
    const double local = around.size() < 3 ? scale : std::clamp(around[around.size() / 2], scale, 4 * scale);
    wider += local > scale;
    const double d = assignment.offset[i], u = d / (4.685 * 1.4826 * local);
    if (held_out[i] || std::abs(u) >= 1) continue;
    const double w = cloud.weights[i] * std::pow(1 - u * u, 2);
    weight[assignment.sample[i]] += w;
    moment[assignment.sample[i]] += w * d;
    square[assignment.sample[i]] += w * d * d;
  }
  EXPECT_GT(wider, 100U);
  for (std::size_t s = 0; s < weight.size(); ++s) {
    EXPECT_NEAR(found.weight[s], weight[s], 1e-12);
    EXPECT_NEAR(found.moment[s], moment[s], 1e-12);
    EXPECT_NEAR(found.square[s], square[s], 1e-12);
  }
}

// Where most points lie in the surface exactly the scale is zero: nothing else counts, and nothing is NaN.
TEST(Residuals, AScaleOfZeroKeepsExactPointsOnly) {
  const Sampled sampled(1);
  PointCloud cloud;
  cloud.positions.assign(sampled.samples.positions.begin(), sampled.samples.positions.begin() + 50);
  cloud.positions.push_back(1.5 * cloud.positions.front());
  const Assignment assignment = assign_points(sampled.samples, cloud, {});
  const Residuals sums = robust_residuals(sampled.surface, assignment, cloud, std::vector<char>(51, 0), 0);
  EXPECT_EQ(std::accumulate(sums.weight.begin(), sums.weight.end(), 0.0), 50);
  EXPECT_EQ(std::accumulate(sums.square.begin(), sums.square.end(), 0.0), 0);
}

}  // namespace
}  // namespace gpsrecon
