#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/edit.h>
#include <gpsrecon/gps/subdivide.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "support/covmeshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

using testing::HasSubstr;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double relative_distance(const Sym3& a, const Sym3& b) {
  return (a.matrix() - b.matrix()).norm() / b.matrix().norm();
}

/// Largest relative difference of the covariances of two meshes.
double max_difference(const CovMesh& a, const CovMesh& b) {
  double max = 0;
  for (std::size_t v = 0; v < a.vertices.size(); ++v)
    max = std::max(max, relative_distance(a.vertices.covariances[v], b.vertices.covariances[v]));
  return max;
}

CovMesh test_mesh(std::uint64_t seed = 3) {
  return with_random_covariances(irregular_sphere(seed), seed + 1);
}

CovMesh edited(const CovMesh& mesh, const std::vector<EditStep>& steps) {
  Edit result = edit(mesh, steps);
  validate(result.mesh);
  EXPECT_EQ(result.steps.size(), steps.size());
  EXPECT_EQ(result.mesh.faces, mesh.faces);
  EXPECT_EQ(result.mesh.vertices.means, mesh.vertices.means);
  EXPECT_EQ(result.mesh.vertices.weights, mesh.vertices.weights);
  return result.mesh;
}

std::string refusal(const CovMesh& mesh, const std::vector<EditStep>& steps) {
  try {
    edit(mesh, steps);
  } catch (const OptionError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Edit, NoStepChangesNothing) {
  const CovMesh mesh = test_mesh();
  EXPECT_EQ(edited(mesh, {}).vertices.covariances, mesh.vertices.covariances);
}

TEST(Edit, ScalingBackIsTheIdentity) {
  const CovMesh mesh = test_mesh();
  // Powers of two are exact.
  EXPECT_EQ(
      edited(mesh, {{SelectAll{}, ScaleCovariance{8}}, {SelectAll{}, ScaleCovariance{0.125}}}).vertices.covariances,
      mesh.vertices.covariances);
  for (const double s : {3.7, 1e9, 1e-12})
    EXPECT_LT(
        max_difference(edited(mesh, {{SelectAll{}, ScaleCovariance{s}}, {SelectAll{}, ScaleCovariance{1 / s}}}), mesh),
        1e-15);
}

TEST(Edit, OneFactorForAllLeavesTheSurface) {
  const CovMesh mesh = test_mesh();
  const Mesh before = subdivide(mesh, {.levels = 2}),
             after = subdivide(edited(mesh, {{SelectAll{}, ScaleCovariance{1e6}}}), {.levels = 2});
  EXPECT_LT(max_distance(before.positions, after.positions), 1e-12);
}

TEST(Edit, FlatteningAnEigenvectorChangesItsEigenvalueAlone) {
  const CovMesh mesh = test_mesh();
  for (const Axis axis : {Axis::smallest, Axis::middle, Axis::largest})
    for (const double factor : {1e-4, 0.3, 1.0, 25.0}) {
      const CovMesh flat = edited(mesh, {{SelectAll{}, FlattenCovariance{.axis = axis, .factor = factor}}});
      for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        const Eigen3 e = eigen_decomposition(mesh.vertices.covariances[v]);
        Vec3 values = e.values;
        values[static_cast<int>(axis)] *= factor;
        const Mat3 expected = e.vectors * values.asDiagonal() * e.vectors.transpose();
        EXPECT_LT(relative_distance(flat.vertices.covariances[v], Sym3::from_matrix(expected)), 1e-13);
      }
    }
}

TEST(Edit, FlatteningADirectionIsExactInItsVariance) {
  const CovMesh mesh = test_mesh();
  const Vec3 direction(1, -2, 0.5), unit = direction.normalized();
  // The length of the direction counts for nothing, not even where its square is out of range.
  for (const double length : {1.0, -7.0, 1e-200}) {
    const CovMesh flat = edited(mesh, {{SelectAll{}, FlattenCovariance{Axis::given, length * direction, 0.04}}});
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const Sym3& before = mesh.vertices.covariances[v];
      const Sym3& after = flat.vertices.covariances[v];
      EXPECT_NEAR(after.quadratic_form(unit) / before.quadratic_form(unit), 0.04, 1e-13);
      // It is a squeeze of space along the axis, so volumes follow, and what lies across stays.
      EXPECT_NEAR(after.determinant() / before.determinant(), 0.04, 1e-12);
      const Vec3 across = unit.unitOrthogonal();
      EXPECT_NEAR(after.quadratic_form(across) / before.quadratic_form(across), 1, 1e-13);
    }
  }
}

TEST(Edit, FlatteningIsUndoneByItsInverse) {
  const CovMesh mesh = test_mesh();
  const auto along = [](double factor) { return FlattenCovariance{Axis::given, Vec3(1, 1, 3), factor}; };
  EXPECT_LT(max_difference(edited(mesh, {{SelectAll{}, along(0.01)}, {SelectAll{}, along(100)}}), mesh), 1e-12);
}

TEST(Edit, ConvolutionAddsCovariances) {
  const CovMesh mesh = test_mesh();
  const Sym3 kernel = Random(8).covariance(0.001, 0.5);
  const CovMesh smooth = edited(mesh, {{SelectAll{}, SmoothCovariance{kernel}}});
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    EXPECT_EQ(smooth.vertices.covariances[v], mesh.vertices.covariances[v] + kernel);
  // Twice a kernel is once the kernel of twice its covariance; and what was added can be taken away.
  const CovMesh twice =
      edited(mesh, {{SelectAll{}, SmoothCovariance{kernel}}, {SelectAll{}, SmoothCovariance{kernel}}});
  EXPECT_LT(max_difference(twice, edited(mesh, {{SelectAll{}, SmoothCovariance{2 * kernel}}})), 1e-15);
  EXPECT_LT(max_difference(edited(smooth, {{SelectAll{}, SharpenCovariance{kernel}}}), mesh), 1e-13);
  // A plane kernel is one, too.
  EXPECT_EQ(edited(mesh, {{SelectAll{}, SmoothCovariance{Sym3::diagonal(1, 0, 0)}}}).vertices.covariances[5].xx,
            mesh.vertices.covariances[5].xx + 1);
}

TEST(Edit, SharpeningStopsAtTheFloor) {
  const CovMesh mesh = test_mesh();
  const double variance = 0.05, floor = 1e-4;
  const Edit sharp = edit(mesh, {{SelectAll{}, SharpenCovariance{Sym3::identity(variance), floor}}});
  std::size_t floored = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Eigen3 before = eigen_decomposition(mesh.vertices.covariances[v]);
    const Vec3 after = eigen_decomposition(sharp.mesh.vertices.covariances[v]).values;
    const double lowest = floor * before.values[2];
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(after[k], std::max(before.values[k] - variance, lowest), 1e-13 * before.values[2]);
    if (before.values[0] - variance < lowest) ++floored;
  }
  EXPECT_GT(floored, 0u);
  EXPECT_LT(floored, mesh.vertices.size());
  EXPECT_EQ(sharp.steps[0].floored, floored);
  // A kernel wider than everything leaves small balls.
  const CovMesh tiny = edited(mesh, {{SelectAll{}, SharpenCovariance{Sym3::identity(100), floor}}});
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const double largest = eigen_decomposition(mesh.vertices.covariances[v]).values[2];
    EXPECT_LT(relative_distance(tiny.vertices.covariances[v], Sym3::identity(floor * largest)), 1e-10);
  }
}

TEST(Edit, AnisotropyFallsWithSmoothing) {
  // Section 5: a wide isotropic kernel leads to equal balls, and those to the linear scheme.
  const CovMesh mesh = test_mesh();
  const Mesh linear = subdivide(with_equal_covariances(irregular_sphere(3), Sym3::identity()));
  double last = std::numeric_limits<double>::infinity();
  for (const double variance : {1.0, 1e2, 1e4, 1e6}) {
    const Mesh smooth = subdivide(edited(mesh, {{SelectAll{}, SmoothCovariance{Sym3::identity(variance)}}}));
    const double difference = max_distance(smooth.positions, linear.positions);
    EXPECT_LT(difference, 0.2 * last);
    last = difference;
  }
  EXPECT_LT(last, 1e-5);
}

TEST(Edit, SettingForgets) {
  const CovMesh mesh = test_mesh();
  const Sym3 covariance = Random(4).covariance(0.1, 10);
  const CovMesh set = edited(mesh, {{SelectAll{}, ScaleCovariance{3}}, {SelectAll{}, SetCovariance{covariance}}});
  for (const Sym3& c : set.vertices.covariances) EXPECT_EQ(c, covariance);
}

TEST(Edit, StepsActInTheirOrder) {
  const CovMesh mesh = test_mesh();
  const EditStep scale{SelectAll{}, ScaleCovariance{4}}, smooth{SelectAll{}, SmoothCovariance{Sym3::identity()}};
  const CovMesh scale_first = edited(mesh, {scale, smooth}), smooth_first = edited(mesh, {smooth, scale});
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Sym3& c = mesh.vertices.covariances[v];
    EXPECT_EQ(scale_first.vertices.covariances[v], 4 * c + Sym3::identity());
    EXPECT_EQ(smooth_first.vertices.covariances[v], 4 * (c + Sym3::identity()));
  }
  // All at once is one after the other.
  EXPECT_EQ(edited(edited(mesh, {scale}), {smooth}).vertices.covariances, scale_first.vertices.covariances);
}

TEST(Edit, CommutesWithSimilarities) {
  // Everything turned, scaled and moved, the operations and selections too.
  const CovMesh mesh = test_mesh();
  const Mat3 rotation = Random(11).rotation();
  const double scale = 12.5;
  const Vec3 shift(100, -50, 7);
  CovMesh moved = mesh;
  for (Vec3& p : moved.vertices.means) p = scale * (rotation * p) + shift;
  for (Sym3& c : moved.vertices.covariances) c = scale * scale * congruence(rotation, c);
  const Vec3 axis(1, 2.3, -0.8), point(0.2, 0.13, 0.05);
  const Sym3 kernel = Random(12).covariance(0.01, 0.02);
  const CovMesh a = edited(mesh, {{SelectHalfSpace{point, axis}, FlattenCovariance{Axis::given, axis, 0.1}},
                                  {SelectNearest{point, 20}, SmoothCovariance{kernel}},
                                  {SelectAll{}, FlattenCovariance{.axis = Axis::middle, .factor = 0.5}},
                                  {SelectNearest{axis, 5}, SharpenCovariance{kernel}}});
  const Vec3 axis_there = rotation * axis, point_there = scale * (rotation * point) + shift;
  const Sym3 kernel_there = scale * scale * congruence(rotation, kernel);
  const CovMesh b =
      edited(moved, {{SelectHalfSpace{point_there, axis_there}, FlattenCovariance{Axis::given, axis_there, 0.1}},
                     {SelectNearest{point_there, 20}, SmoothCovariance{kernel_there}},
                     {SelectAll{}, FlattenCovariance{.axis = Axis::middle, .factor = 0.5}},
                     {SelectNearest{scale * axis_there + shift, 5}, SharpenCovariance{kernel_there}}});
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    EXPECT_LT(
        relative_distance(b.vertices.covariances[v], scale * scale * congruence(rotation, a.vertices.covariances[v])),
        1e-11);
}

TEST(Edit, LengthsAndPlacesAreOfTheWorld) {
  const CovMesh world = test_mesh();
  CovMesh local = world;
  local.vertices.frame = {Vec3(10, -20, 30), 2};
  for (Vec3& p : local.vertices.means) p = local.vertices.frame.to_local(p);
  for (Sym3& c : local.vertices.covariances) c *= 1.0 / 16;
  const std::vector<EditStep> steps{{SelectBox{{-2, -2, 0}, {2, 2, 2}}, SmoothCovariance{Sym3::identity(0.3)}},
                                    {SelectNearest{{1, 0, 0}, 7}, SharpenCovariance{Sym3::identity(0.01)}},
                                    {SelectHalfSpace{{0, 0.2, 0}, {0, 1, 0}}, SetCovariance{Sym3::diagonal(1, 2, 3)}}};
  const CovMesh a = edited(world, steps);
  const Edit b = edit(local, steps);
  for (std::size_t v = 0; v < world.vertices.size(); ++v)
    EXPECT_LT(relative_distance(16 * b.mesh.vertices.covariances[v], a.vertices.covariances[v]), 1e-13);
}

TEST(Edit, SelectionsAreThoseOfBruteForce) {
  const CovMesh mesh = test_mesh();
  const std::vector<Vec3>& means = mesh.vertices.means;
  Random random(21);
  for (int round = 0; round < 20; ++round) {
    const Vec3 a = random.vector(), b = random.vector();
    const SelectBox box{a.cwiseMin(b) - Vec3::Constant(0.3), a.cwiseMax(b) + Vec3::Constant(0.3)};
    const SelectHalfSpace side{0.5 * a, b};
    const SelectNearest near{a, 1 + random.below(means.size())};
    std::vector<Index> in_box, on_side, order;
    for (Index v = 0; v < means.size(); ++v) {
      const Vec3& p = means[v];
      bool inside = true;
      for (int k = 0; k < 3; ++k) inside = inside && box.low[k] <= p[k] && p[k] <= box.high[k];
      if (inside) in_box.push_back(v);
      if (b.dot(p - 0.5 * a) >= 0) on_side.push_back(v);
      order.push_back(v);
    }
    std::stable_sort(order.begin(), order.end(),
                     [&](Index i, Index j) { return (means[i] - a).squaredNorm() < (means[j] - a).squaredNorm(); });
    order.resize(near.count);
    std::sort(order.begin(), order.end());
    if (!in_box.empty()) {
      EXPECT_EQ(selected_vertices(mesh.vertices, box), in_box);
    }
    if (!on_side.empty()) {
      EXPECT_EQ(selected_vertices(mesh.vertices, side), on_side);
    }
    EXPECT_EQ(selected_vertices(mesh.vertices, near), order);
  }
  EXPECT_EQ(selected_vertices(mesh.vertices, SelectIndices{{{7, 8}, {3, 3}, {8, 8}, {0, 0}, {2, 3}}}),
            (std::vector<Index>{0, 2, 3, 7, 8}));
  EXPECT_EQ(selected_vertices(mesh.vertices, SelectAll{}).size(), means.size());
}

TEST(Edit, BordersAndTiesAreDecided) {
  const CovMesh cube = with_equal_covariances(octahedron(), Sym3::identity());
  EXPECT_EQ(selected_vertices(cube.vertices, SelectHalfSpace{{0, 0, 0}, {5, 0, 0}}),
            (std::vector<Index>{0, 2, 3, 4, 5}));
  EXPECT_EQ(selected_vertices(cube.vertices, SelectBox{{0, 0, 0}, {1, 1, 1}}), (std::vector<Index>{0, 2, 4}));
  EXPECT_EQ(selected_vertices(cube.vertices, SelectNearest{{0, 0, 0}, 2}), (std::vector<Index>{0, 1}));
}

TEST(Edit, OnlyTheSelectionChanges) {
  const CovMesh mesh = test_mesh();
  const Edit result = edit(
      mesh, {{SelectIndices{{{4, 4}, {9, 9}}}, ScaleCovariance{2}}, {SelectIndices{{{9, 9}}}, ScaleCovariance{2}}});
  EXPECT_EQ(result.steps[0].selected, 2u);
  EXPECT_EQ(result.steps[1].selected, 1u);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    EXPECT_EQ(result.mesh.vertices.covariances[v], mesh.vertices.covariances[v] * (v == 4 ? 2 : v == 9 ? 4 : 1));
}

TEST(Edit, StaysValidHoweverFlat) {
  CovMesh mesh = test_mesh();
  std::vector<EditStep> steps(5, {SelectAll{}, FlattenCovariance{.axis = Axis::smallest, .factor = 1e-6}});
  const Edit result = edit(mesh, steps);
  validate(result.mesh);
  EXPECT_EQ(result.steps[0].floored, 0u);
  EXPECT_EQ(result.steps[4].floored, mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vec3 before = eigen_decomposition(mesh.vertices.covariances[v]).values;
    const Vec3 after = eigen_decomposition(result.mesh.vertices.covariances[v]).values;
    EXPECT_NEAR(after[1] / before[1], 1, 1e-9);
    EXPECT_NEAR(after[0] / after[2], min_eigenvalue_ratio, 1e-3 * min_eigenvalue_ratio);
  }
  EXPECT_TRUE(subdivide(result.mesh).positions[0].allFinite());
  // Out of the range of numbers.
  const std::vector<EditStep> shrink(40, {SelectAll{}, ScaleCovariance{1e-12}}),
      grow(40, {SelectAll{}, ScaleCovariance{1e12}});
  EXPECT_THAT(refusal(mesh, shrink), HasSubstr("leaves the range of numbers"));
  EXPECT_THAT(refusal(mesh, grow), HasSubstr("step 24: the covariance of vertex 0 leaves the range of numbers"));
}

TEST(Edit, CountsArbitraryAxes) {
  CovMesh mesh = with_equal_covariances(tetrahedron(), Sym3::identity(2));
  mesh.vertices.covariances[1] = Sym3::diagonal(1, 1, 5);
  mesh.vertices.covariances[2] = Sym3::diagonal(1, 5, 5);
  mesh.vertices.covariances[3] = Sym3::diagonal(1, 3, 5);
  const auto arbitrary = [&](Axis axis) {
    return edit(mesh, {{SelectAll{}, FlattenCovariance{.axis = axis}}}).steps[0].ambiguous_axes;
  };
  EXPECT_EQ(arbitrary(Axis::smallest), 2u);
  EXPECT_EQ(arbitrary(Axis::middle), 3u);
  EXPECT_EQ(arbitrary(Axis::largest), 2u);
  EXPECT_EQ(arbitrary(Axis::given), 0u);
}

TEST(Edit, RefusesWhatMakesNoSense) {
  const CovMesh mesh = test_mesh();
  const auto operation = [&](const CovarianceOperation& o) { return refusal(mesh, {{SelectAll{}, o}}); };
  const auto selection = [&](const VertexSelection& s) {
    return refusal(mesh, {{SelectAll{}, ScaleCovariance{2}}, {s, ScaleCovariance{2}}});
  };
  for (const double factor : {0.0, -1.0, 1e13, nan}) {
    EXPECT_THAT(operation(ScaleCovariance{factor}), HasSubstr("step 1: scale: factor: "));
    EXPECT_THAT(operation(FlattenCovariance{.factor = factor}), HasSubstr("step 1: flatten: factor: "));
  }
  for (const Vec3& direction : {Vec3(0, 0, 0), Vec3(0, nan, 1)}) {
    EXPECT_THAT(operation(FlattenCovariance{Axis::given, direction}), HasSubstr("flatten: direction: "));
    EXPECT_THAT(selection(SelectHalfSpace{{0, 0, 0}, direction}), HasSubstr("step 2: select plane: normal: "));
  }
  for (const Sym3& kernel : {Sym3::diagonal(1, -0.1, 1), Sym3::diagonal(nan, 1, 1), Sym3{1, 2, 0, 1, 0, 1}}) {
    EXPECT_THAT(operation(SmoothCovariance{kernel}), HasSubstr("smooth: kernel: "));
    EXPECT_THAT(operation(SharpenCovariance{kernel}), HasSubstr("sharpen: kernel: "));
    EXPECT_THAT(operation(SetCovariance{kernel}), HasSubstr("set: covariance: "));
  }
  EXPECT_THAT(operation(SetCovariance{Sym3::diagonal(1, 1, 0)}), HasSubstr("set: covariance: "));
  EXPECT_THAT(operation(SetCovariance{Sym3{}}), HasSubstr("set: covariance: "));
  for (const double floor : {0.0, 2.0, nan})
    EXPECT_THAT(operation(SharpenCovariance{Sym3::identity(), floor}), HasSubstr("sharpen: floor: "));
  EXPECT_THAT(selection(SelectIndices{}), HasSubstr("step 2: select indices: "));
  EXPECT_THAT(selection(SelectIndices{{{1, 2}, {5, 4}}}), HasSubstr("select indices: 5 is above 4"));
  EXPECT_THAT(selection(SelectIndices{{{3, static_cast<Index>(mesh.vertices.size())}}}),
              HasSubstr("there is no vertex "));
  EXPECT_THAT(selection(SelectBox{{0, 0, 1}, {1, 1, 0}}), HasSubstr("select box: "));
  EXPECT_THAT(selection(SelectBox{{nan, 0, 0}, {1, 1, 0}}), HasSubstr("select box: "));
  EXPECT_THAT(selection(SelectBox{{9, 9, 9}, {10, 10, 10}}), HasSubstr("there is no vertex in it"));
  EXPECT_THAT(selection(SelectHalfSpace{{9, 0, 0}, {1, 0, 0}}), HasSubstr("there is no vertex in it"));
  EXPECT_THAT(selection(SelectNearest{{0, 0, 0}, 0}), HasSubstr("select nearest: count: "));
  EXPECT_THAT(selection(SelectNearest{{0, 0, 0}, mesh.vertices.size() + 1}), HasSubstr("select nearest: count: "));
  EXPECT_THAT(selection(SelectNearest{{nan, 0, 0}}), HasSubstr("select nearest: point: "));
  CovMesh broken = mesh;
  broken.vertices.covariances[0] = Sym3{};
  EXPECT_THROW(edit(broken, {}), InvariantError);
}

}  // namespace
}  // namespace gpsrecon::test
