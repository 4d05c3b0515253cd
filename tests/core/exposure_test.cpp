#include <gtest/gtest.h>

#include <gpsrecon/core/exposure.h>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

/// Light on the side of the given normals, and on the other.
struct Sides {
  std::vector<double> lit, other;
  Sides(const Mixture& mixture, const std::vector<Vec3>& normals) {
    const Exposure e = exposure(mixture);
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const bool same = e.axis[i].dot(normals[i]) > 0;
      lit.push_back(same ? e.front[i] : e.back[i]);
      other.push_back(same ? e.back[i] : e.front[i]);
    }
  }
  static double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  }
};

TEST(Exposure, NothingAndAlone) {
  EXPECT_TRUE(exposure(Mixture{}).front.empty());
  Mixture one = test::tangent_discs(test::fibonacci_sphere(1));
  const Exposure e = exposure(one);
  // Its own density is the same on either side, and is left out.
  EXPECT_DOUBLE_EQ(e.front[0], 1);
  EXPECT_DOUBLE_EQ(e.back[0], 1);
  EXPECT_EQ(e.bent_normal[0], Vec3::Zero());
}

TEST(Exposure, ASphereIsLitFromOutside) {
  const test::SampledShape sphere = test::fibonacci_sphere(800);
  const Mixture mixture = test::tangent_discs(sphere);
  const Sides sides(mixture, sphere.normals);
  const Exposure e = exposure(mixture);
  for (std::size_t i = 0; i < sphere.points.size(); ++i) {
    EXPECT_GT(sides.lit[i], 8 * sides.other[i]) << i;
    EXPECT_LE(sides.lit[i], 1) << i;
    EXPECT_NEAR(e.axis[i].norm(), 1, 1e-12);
    EXPECT_GT(e.bent_normal[i].normalized().dot(sphere.normals[i]), 0.98) << i;
    EXPECT_LE(e.bent_normal[i].norm(), 0.5);  // of an evenly bright hemisphere
  }
}

TEST(Exposure, ALayerLetsThroughWhatItIsSaidTo) {
  // Inside a ball of n shells each ray crosses one layer more: the light falls by exp(-3 / cosine) per shell, whose
  // mean over directions through concentric shells is that of right angles.
  const test::SampledShape outer = test::fibonacci_sphere(3000, 10), middle = test::fibonacci_sphere(1500, 5);
  Mixture mixture = test::joined(test::tangent_discs(outer), test::tangent_discs(middle));
  const std::size_t inner = mixture.size();
  const test::SampledShape probe = test::fibonacci_sphere(40, 0.5);
  mixture = test::joined(mixture, test::tangent_discs(probe));
  std::vector<Vec3> normals = outer.normals;
  normals.insert(normals.end(), middle.normals.begin(), middle.normals.end());
  normals.insert(normals.end(), probe.normals.begin(), probe.normals.end());
  const Sides sides(mixture, normals);
  const auto share = [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += sides.lit[i];
    return sum / static_cast<double>(end - begin);
  };
  const double unshaded = share(0, outer.points.size());
  const double through_one = share(outer.points.size(), inner), through_two = share(inner, mixture.size());
  // Discs a finite distance apart leave the layer uneven: exp(-3) is 0.050.
  EXPECT_GT(through_one / unshaded, 0.02);
  EXPECT_LT(through_one / unshaded, 0.08);
  EXPECT_GT(through_two / through_one, 0.02);
  EXPECT_LT(through_two / through_one, 0.08);
}

TEST(Exposure, BothSidesOfAFlatSheetGetTheSame) {
  const Mixture mixture = test::tangent_discs(test::rectangle(600, 2, 2, 5));
  const Exposure e = exposure(mixture);
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    // Not exactly: oblique rays meet the discs on one side of this one upwards, those on the other side downwards.
    EXPECT_NEAR(e.front[i], e.back[i], 0.01);
    EXPECT_NEAR(e.bent_normal[i].z(), 0, 0.01);
  }
}

TEST(Exposure, TheSheetsOfAThinPlateShadeEachOtherDownToTheirThickness) {
  std::vector<double> contrast;
  for (const double gap : {6.0, 3.0, 1.0, 0.0}) {  // in deviations of a sheet
    const std::size_t n = 900;
    const double across = 0.1 * test::rectangle(n, 2, 2, 7).spacing();
    const test::SampledShape plate = test::two_sheets(n, 2, gap * across, 7);
    const Mixture lower = test::tangent_discs(test::rectangle(n, 2, 2, 7));  // for the spacing of one sheet
    Mixture mixture = test::tangent_discs(plate);
    for (Sym3& c : mixture.covariances) c = lower.covariances[0];
    const Sides sides(mixture, plate.normals);
    const double lit = Sides::mean(sides.lit), other = Sides::mean(sides.other);
    contrast.push_back((lit - other) / (lit + other));
  }
  EXPECT_GT(contrast[0], 0.7);
  EXPECT_GT(contrast[1], 0.6);
  EXPECT_GT(contrast[2], 0.15);
  EXPECT_NEAR(contrast[3], 0, 0.05);
}

TEST(Exposure, DependsNeitherOnUnitsNorOnWeightsNorOnThreads) {
  test::SampledShape shape = test::torus(1200, 1, 0.4);
  const Mixture mixture = test::tangent_discs(shape);
  RunContext one, two;
  one.threads = 1, two.threads = 2;
  const Exposure reference = exposure(mixture, one);
  Mixture other = mixture;
  for (Vec3& m : other.means) m *= 1024;
  for (Sym3& c : other.covariances) c *= 1024.0 * 1024;
  for (double& w : other.weights) w *= 8;
  const Exposure scaled = exposure(other, two);
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    EXPECT_NEAR(scaled.front[i], reference.front[i], 1e-12);
    EXPECT_NEAR(scaled.back[i], reference.back[i], 1e-12);
  }
  const Exposure again = exposure(mixture, two);
  EXPECT_EQ(again.front, reference.front);
  EXPECT_EQ(again.back, reference.back);
  EXPECT_EQ(again.bent_normal, reference.bent_normal);
}

TEST(Exposure, DensePartsLetNoLessThrough) {
  // Two spheres around the same probe: one of few components, one of nine times as many of the same weight each.
  std::vector<double> inside;
  for (const std::size_t n : {800, 7200}) {
    const test::SampledShape shell = test::fibonacci_sphere(n, 5), probe = test::fibonacci_sphere(40, 0.3);
    const Sides sides(test::joined(test::tangent_discs(probe), test::tangent_discs(shell)), probe.normals);
    inside.push_back(Sides::mean(sides.lit));
  }
  EXPECT_NEAR(inside[1] / inside[0], 1, 0.3);  // the discs are a little uneven
}

TEST(Exposure, NeedlesAndPancakesGiveNumbers) {
  test::Random random(8);
  Mixture mixture;
  for (int i = 0; i < 200; ++i) {
    mixture.means.push_back(random.vector(0, 1));
    const double across = std::pow(10, random.uniform(-9, 0)), along = std::pow(10, random.uniform(-9, 0));
    mixture.covariances.push_back(test::disc_covariance(random.direction(), along, across));
    mixture.weights.push_back(std::pow(10, random.uniform(-6, 6)));
  }
  const Exposure e = exposure(mixture);
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    EXPECT_GE(e.front[i], 0);
    EXPECT_LE(e.front[i], 1);
    EXPECT_GE(e.back[i], 0);
    EXPECT_LE(e.back[i], 1);
    EXPECT_LE(e.bent_normal[i].norm(), 1);
  }
}

TEST(Exposure, CanBeCancelled) {
  const std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  EXPECT_THROW(exposure(test::tangent_discs(test::fibonacci_sphere(100)), context), Cancelled);
}

}  // namespace
}  // namespace gpsrecon
