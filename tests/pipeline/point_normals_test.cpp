#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/pipeline/point_normals.h>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::scaled;
using test::shifted;

PointNormalsOptions by(NormalMethod method) {
  PointNormalsOptions options;
  options.method = method;
  return options;
}

constexpr NormalMethod methods[] = {NormalMethod::pca, NormalMethod::weiszfeld, NormalMethod::csw};

TEST(PointNormals, do_not_depend_on_units_or_place) {
  const PointCloud cloud = test::on_grid(test::noisy_sphere(1500, 0.01));
  for (const NormalMethod method : methods) {
    const std::vector<Vec3> normals = point_normals(cloud, by(method)).normals;
    EXPECT_EQ(point_normals(scaled(cloud, 0x1p-30), by(method)).normals, normals);
    EXPECT_EQ(point_normals(scaled(cloud, 0x1p40), by(method)).normals, normals);
    // A mixture is rounded to what a file would hold, in world coordinates; one iteration more or less turns a normal
    // by no more than the bound of convergence, and the next few.
    const std::vector<Vec3> elsewhere = point_normals(shifted(cloud, {4096, -8192, 1024}), by(method)).normals;
    if (method != NormalMethod::csw) {
      EXPECT_EQ(elsewhere, normals);
    }
    const std::vector<Vec3> in_millimetres = point_normals(scaled(cloud, 1000), by(method)).normals;
    for (std::size_t i = 0; i < normals.size(); ++i) {
      EXPECT_LT((normals[i] - elsewhere[i]).norm(), 1e-3);
      EXPECT_LT((normals[i] - in_millimetres[i]).norm(), 1e-3);
    }
  }
}

TEST(PointNormals, do_not_depend_on_the_order_of_the_points) {
  const PointCloud cloud = test::noisy_sphere(2000, 0.01);
  std::vector<Index> order(cloud.size());
  std::iota(order.begin(), order.end(), Index{0});
  test::Random(1).shuffle(order);
  for (const NormalMethod method : methods) {
    const std::vector<Vec3> normals = point_normals(cloud, by(method)).normals;
    const std::vector<Vec3> shuffled = point_normals(select(cloud, order), by(method)).normals;
    for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(shuffled[i], normals[order[i]]);
  }
}

TEST(PointNormals, a_mixture_in_a_frame_of_its_own_serves_as_well) {
  const PointCloud cloud = test::noisy_sphere(3000, 0.01);
  PointNormalsOptions options = by(NormalMethod::csw);
  options.support_radius = Length::of_diagonal(0.1);
  Mixture mixture = build_mixture(cloud, {.flat_levels = 0, .normals = true});
  const std::vector<Vec3> normals = point_normals(cloud, options, {.mixture = &mixture}).normals;
  mixture.frame = {Vec3(1, 2, 3), -3};
  for (Vec3& m : mixture.means) m = mixture.frame.to_local(m);
  for (Sym3& c : mixture.covariances) c *= 64;
  const std::vector<Vec3> moved = point_normals(cloud, options, {.mixture = &mixture}).normals;
  for (std::size_t i = 0; i < normals.size(); ++i) EXPECT_LT((normals[i] - moved[i]).norm(), 1e-9);
  mixture.normals.clear();
  mixture.normal_variances.clear();
  EXPECT_THROW(point_normals(cloud, options, {.mixture = &mixture}), InputError);
}

TEST(PointNormals, isolated_points_have_normals_but_do_not_count) {
  PointCloud cloud = test::noisy_sphere(3000, 0.003);
  const std::vector<Vec3> normals = point_normals(cloud).normals;
  cloud.positions.insert(cloud.positions.end(), {Vec3(4, 0, 0), Vec3(0, 5, 0)});
  const std::vector<Vec3> with_outliers = point_normals(cloud).normals;
  ASSERT_EQ(with_outliers.size(), 3002u);
  for (const Vec3& n : with_outliers) EXPECT_NEAR(n.norm(), 1, 1e-12);
  for (std::size_t i = 0; i < 3000; ++i) EXPECT_LT((with_outliers[i] - normals[i]).norm(), 1e-6);
}

}  // namespace
}  // namespace gpsrecon
