#include <gpsrecon/triangulate/light_components.h>
#include <gpsrecon/triangulate/triangulate.h>
#include <gtest/gtest.h>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

/// A jittered sheet of 15 x 15 flat Gaussians of weight 40 at unit spacing, and then single points beside
/// and above its rim.
constexpr Index sheet_size = 225, stray_count = 20;
Mixture sheet_with_strays() {
  test::Random random(52);
  test::SampledShape sheet;
  for (int i = 0; i < 15; ++i)
    for (int j = 0; j < 15; ++j)
      sheet.points.emplace_back(i + random.uniform(-0.2, 0.2), j + random.uniform(-0.2, 0.2), 0);
  sheet.normals.assign(sheet.points.size(), Vec3::UnitZ());
  sheet.area = sheet_size;
  Mixture mixture = test::tangent_discs(sheet, 0.6, 0.15);
  mixture.weights.assign(sheet_size, 40);
  Mixture strays;
  for (Index i = 0; i < stray_count; ++i) {
    const double x = (i % 2 == 0 ? -1 : 15) + random.uniform(-0.2, 0.2), y = random.uniform(1, 13);
    strays.means.emplace_back(x, y, random.uniform(0.4, 0.6));
  }
  strays.covariances.assign(stray_count, Sym3::identity(0.04));
  strays.weights.assign(stray_count, 1);
  return test::joined(mixture, strays);
}

double highest(const CovMesh& mesh) {
  double z = 0;
  for (const Index v : mesh.faces.corners) z = std::max(z, mesh.vertices.means[v].z());
  return z;
}

TEST(LightComponents, AreTheStraysOverASheet) {
  const Mixture mixture = sheet_with_strays();
  std::vector<Index> strays(stray_count);
  std::iota(strays.begin(), strays.end(), sheet_size);
  const OverlapGraph graph = overlap_graph(mixture, 0.01, {});
  EXPECT_EQ(light_components(mixture, graph, 0.1), strays);
  // The bound is a share of the median: 1 is not below 40 / 40.
  EXPECT_TRUE(light_components(mixture, graph, 1.0 / 40).empty());
  EXPECT_EQ(light_components(mixture, graph, 1.001 / 40), strays);
  EXPECT_TRUE(light_components(mixture, graph, 0).empty());
}

TEST(LightComponents, AreLeftOutAndCounted) {
  const Mixture mixture = sheet_with_strays();
  const Triangulation result = triangulate(mixture);
  EXPECT_EQ(result.light_components, stray_count);
  EXPECT_EQ(result.light_weight, stray_count);
  EXPECT_EQ(result.leftover_components, 0U);
  EXPECT_EQ(result.mesh.vertices.size(), sheet_size);
  EXPECT_EQ(highest(result.mesh), 0);

  const Triangulation all = triangulate(mixture, {.min_weight_share = 0});
  EXPECT_EQ(all.light_components, 0U);
  EXPECT_EQ(all.light_weight, 0);
  EXPECT_GT(highest(all.mesh), 0.3);  // the rim reached for them
}

TEST(LightComponents, AreNoneWhereAllWeighTheSame) {
  for (const double weight : {1.0, 40.0}) {
    Mixture mixture = sheet_with_strays();
    mixture.weights.assign(mixture.size(), weight);
    EXPECT_TRUE(light_components(mixture, overlap_graph(mixture, 0.01, {}), 0.999).empty());
  }
}

TEST(LightComponents, DoNotOverlapNothing) {
  Mixture mixture;
  mixture.means = {Vec3(0, 0, 0), Vec3(100, 0, 0), Vec3(101, 0, 0)};
  mixture.covariances.assign(3, Sym3::identity());
  mixture.weights = {1e-9, 1, 50};
  EXPECT_EQ(light_components(mixture, overlap_graph(mixture, 0.01, {}), 0.1), std::vector<Index>{1});
}

TEST(LightComponents, GraphWithoutThemIsThatOfTheOthers) {
  const Mixture mixture = sheet_with_strays();
  const OverlapGraph graph = overlap_graph(mixture, 0.01, {});
  const std::vector<Index> dropped = {0, 7, 8, 100, sheet_size + 3};
  const OverlapGraph kept = without(graph, dropped);
  ASSERT_EQ(kept.offset.size(), graph.offset.size());
  EXPECT_EQ(kept.offset.back(), kept.links.size());
  const auto is_dropped = [&](Index i) { return std::binary_search(dropped.begin(), dropped.end(), i); };
  for (Index i = 0; i < mixture.size(); ++i)
    for (Index j = 0; j < mixture.size(); ++j) {
      const double *before = graph.find(i, j), *after = kept.find(i, j);
      if (before == nullptr || is_dropped(i) || is_dropped(j)) {
        EXPECT_EQ(after, nullptr) << i << " " << j;
      } else {
        ASSERT_NE(after, nullptr) << i << " " << j;
        EXPECT_EQ(*after, *before);
      }
    }
  const OverlapGraph same = without(graph, {});
  EXPECT_EQ(same.offset, graph.offset);
  EXPECT_EQ(same.links.size(), graph.links.size());
}

}  // namespace
}  // namespace gpsrecon
