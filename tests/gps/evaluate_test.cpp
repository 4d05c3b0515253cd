// Exact evaluation of limit surfaces against limit masks, refinement, differences and analytic shapes.

#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/infer.h>
#include <gpsrecon/gps/patch_table.h>
#include <gpsrecon/gps/refined_connectivity.h>
#include <gpsrecon/gps/refined_parameters.h>
#include <gpsrecon/gps/refinement_levels.h>
#include <gpsrecon/gps/subdivide.h>
#include <gtest/gtest.h>

#include <limits>

#include "gps/surface_shapes.h"
#include "support/covmeshes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using namespace test;

/// Refinement and limit masks: an independent way to limit points and normals.
Mesh by_masks(const CovMesh& control, int levels) {
  if (control.rules.scheme == Scheme::loop) return subdivide(control, {.levels = levels});
  Mesh refined;
  Connectivity topology = manifold_connectivity(control.faces, control.vertices.size());
  std::vector<DualPoint> dual;
  for (std::size_t v = 0; v < control.vertices.size(); ++v) dual.push_back(to_dual(control.vertices.component(v)));
  refined.faces = control.faces;
  for (int level = 0; level < levels; ++level) {
    dual = refine_values<DualPoint>(CatmullClarkScheme::step(topology, control.rules), dual, {});
    refined.faces = refined_quads(topology);
    topology = refine_to_quads(topology);
  }
  const LimitTable table = tabulate(CatmullClarkScheme::limit(topology, control.rules, false));
  for (std::size_t v = 0; v < dual.size(); ++v) {
    const DualMap map(apply_row<DualPoint>(table.row(v), dual, &LimitWeight::position));
    refined.positions.push_back(map.mean());
    refined.normals.push_back(map.tangent(apply_row<DualPoint>(table.row(v), dual, &LimitWeight::u))
                                  .cross(map.tangent(apply_row<DualPoint>(table.row(v), dual, &LimitWeight::v)))
                                  .normalized());
  }
  return refined;
}

class Evaluation : public testing::TestWithParam<Shape> {
 protected:
  const Mesh& mesh() const { return GetParam().mesh; }
  const SurfaceRules& rules() const { return GetParam().rules; }
  bool triangular() const { return rules().scheme == Scheme::loop; }
  CovMesh control(std::uint64_t seed = 1, double low = 0.05, double high = 0.5) const {
    return with_rules(with_random_covariances(mesh(), seed, low, high), rules());
  }
  SurfaceParameter random_parameter(const SurfaceEvaluator& surface, Random& random) const {
    SurfaceParameter parameter{static_cast<Index>(random.below(surface.patch_count())), random.uniform(0, 1),
                               random.uniform(0, 1)};
    if (triangular() && parameter.u + parameter.v > 1) parameter.u = 1 - parameter.u, parameter.v = 1 - parameter.v;
    return parameter;
  }
};

// The masks and the refinement are an independent way to the same points.
TEST_P(Evaluation, AgreesWithLimitMasksOfEveryLevel) {
  const CovMesh covmesh = control();
  const SurfaceEvaluator surface(covmesh);
  for (const int levels : {0, 1, 2, 5}) {
    if (levels == 5 && mesh().faces.size() > 64) continue;
    // The masks at the vertices of other than quadrilaterals are known after one step.
    if (levels == 0 && !triangular() && !mesh().faces.all_of_size(4)) continue;
    const Mesh refined = by_masks(covmesh, levels);
    const std::vector<SurfaceParameter> parameters =
        refined_parameters(covmesh.faces, refined.faces, refined.positions.size(), levels, rules().scheme);
    double largest = 0, largest_turn = 0;
    for (std::size_t v = 0; v < parameters.size(); ++v) {
      if (parameters[v].patch == no_index) continue;
      const SurfacePoint p = surface.evaluate(parameters[v]);
      largest = std::max(largest, (p.position - refined.positions[v]).norm());
      // Nearly parallel tangents leave the normal fewer digits; vertices of two faces have no tangent plane at all.
      if (!GetParam().name.ends_with("pillow") && p.u.cross(p.v).norm() > 1e-4 * p.u.norm() * p.v.norm())
        largest_turn = std::max(largest_turn, (p.normal - refined.normals[v]).norm());
    }
    EXPECT_LT(largest, 2e-14) << levels;
    EXPECT_LT(largest_turn, 1e-9) << levels;
  }
}

TEST_P(Evaluation, DerivativesAreThoseOfCentralDifferences) {
  const SurfaceEvaluator surface(control());
  Random random(9);
  int tried = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const SurfaceParameter p = random_parameter(surface, random);
    const double distance = std::min({p.u + p.v, 1 - p.u + p.v, p.u + 1 - p.v, 2 - p.u - p.v}), h = 2e-4 * distance;
    // Across the seams between polynomials the third derivative jumps.
    const auto near_seam = [&](double x) {
      for (double cell = 1; cell > distance / 16; cell /= 2)
        if (std::abs(x / cell - std::round(x / cell)) * cell < 4 * h) return true;
      return false;
    };
    if (near_seam(p.u) || near_seam(p.v) || (triangular() && near_seam(p.u + p.v))) continue;
    const SurfacePoint at = surface.evaluate(p);
    const auto difference = [&](double du, double dv, Vec3 SurfacePoint::*part) -> Vec3 {
      const auto across = [&](double step) -> Vec3 {
        return surface.evaluate({p.patch, p.u + du * step, p.v + dv * step}).*part -
               surface.evaluate({p.patch, p.u - du * step, p.v - dv * step}).*part;
      };
      return (8 * across(h) - across(2 * h)) / (12 * h);
    };
    // Truncation is h⁴ times a fifth derivative, which grows towards irregular vertices; rounding 1e-15 / h.
    const double first = 1e-10 / distance, second = 1e-9 / distance / distance;
    EXPECT_LT((difference(1, 0, &SurfacePoint::position) - at.u).norm(), first);
    EXPECT_LT((difference(0, 1, &SurfacePoint::position) - at.v).norm(), first);
    EXPECT_LT((difference(1, 0, &SurfacePoint::u) - at.uu).norm(), second);
    EXPECT_LT((difference(0, 1, &SurfacePoint::u) - at.uv).norm(), second);
    EXPECT_LT((difference(1, 0, &SurfacePoint::v) - at.uv).norm(), second);
    EXPECT_LT((difference(0, 1, &SurfacePoint::v) - at.vv).norm(), second);
    ++tried;
  }
  EXPECT_GT(tried, 100);
}

// A point of an edge: its parameters in the two faces.
TEST_P(Evaluation, MeetsAcrossEdges) {
  if (!triangular() && !mesh().faces.all_of_size(4)) GTEST_SKIP() << "edges of polygons are halves of two patches";
  if (GetParam().name.ends_with("pillow")) GTEST_SKIP() << "two sheets fold at their edges";
  const SurfaceEvaluator surface(control());
  const Connectivity edges = manifold_connectivity(mesh().faces, mesh().positions.size());
  const int n = triangular() ? 3 : 4;
  const auto parameter = [&](Index h, double t) -> SurfaceParameter {
    const double x[] = {0, 1, 1, 0}, y[] = {0, 0, 1, 1}, p[] = {0, 1, 0}, q[] = {0, 0, 1};
    const int i = static_cast<int>(h) % n, j = (i + 1) % n;
    const double* u = triangular() ? p : x;
    const double* v = triangular() ? q : y;
    return {h / static_cast<Index>(n), (1 - t) * u[i] + t * u[j], (1 - t) * v[i] + t * v[j]};
  };
  for (Index h = 0; h < edges.corners.size(); ++h) {
    const Index other = edges.opposite[h];
    if (other == no_index || other < h) continue;
    for (const double t : {0.0625, 0.25, 0.3, 0.5, 0.7, 0.9375}) {
      const SurfacePoint a = surface.evaluate(parameter(h, t)), b = surface.evaluate(parameter(other, 1 - t));
      EXPECT_LT((a.position - b.position).norm(), 1e-14);
      if (a.u.cross(a.v).norm() < 1e-3 * a.u.norm() * a.v.norm()) continue;
      EXPECT_LT((a.normal - b.normal).norm(), 1e-11);
      // The second derivatives are continuous, too, as those of splines: a curvature is the same from both sides.
      const Curvature k = curvature(a), l = curvature(b);
      const double size = 1 + std::abs(k.k1) + std::abs(k.k2);
      EXPECT_NEAR(k.k1, l.k1, 1e-9 * size);
      EXPECT_NEAR(k.k2, l.k2, 1e-9 * size);
    }
  }
}

TEST_P(Evaluation, IsFiniteAndFlaggedAtIrregularVertices) {
  const SurfaceEvaluator surface(control());
  for (Index patch = 0; patch < surface.patch_count(); ++patch) {
    std::vector<SurfaceParameter> parameters;
    for (const double distance : {0.0, 1e-300, 0x1p-60, 0x1p-51, 0x1p-49, 0x1p-30, 0x1p-10})
      for (const auto& [u, v] : {std::pair{distance, 0.0}, {0.0, distance}, {distance, distance}})
        parameters.push_back({patch, u, v});
    parameters.push_back({patch, 1, 0});
    parameters.push_back({patch, 0, 1});
    const std::vector<SurfacePoint> points = surface.evaluate(parameters);
    const std::vector<Curvature> curvatures = surface.curvatures(parameters);
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const SurfacePoint& p = points[i];
      EXPECT_TRUE((p.position + p.u + p.v + p.uu + p.uv + p.vv + p.normal).allFinite());
      const Curvature& c = curvatures[i];
      EXPECT_TRUE(std::isfinite(c.mean + c.gaussian + c.k1 + c.k2) && (c.direction1 + c.direction2).allFinite());
      EXPECT_TRUE(c.k1 >= c.k2);
      if (p.extraordinary) {
        EXPECT_FALSE(c.exact);
      }
      // The first 15 parameters approach the vertex.
      if (i < 15) {
        EXPECT_LT((p.position - points[0].position).norm(), 1e-5);
      }
      if (i < 9) {
        EXPECT_LT((p.position - points[0].position).norm(), 1e-9);
      }
    }
  }
}

TEST_P(Evaluation, FollowsAffineMaps) {
  Random random(12);
  Mat3 map = Mat3::Identity() + 0.4 * random.matrix();
  const Vec3 shift = 3 * random.vector();
  CovMesh before = control(), after = before;
  for (std::size_t v = 0; v < after.vertices.size(); ++v) {
    after.vertices.means[v] = map * before.vertices.means[v] + shift;
    after.vertices.covariances[v] = congruence(map, before.vertices.covariances[v]);
  }
  const SurfaceEvaluator first(before), second(after);
  for (int i = 0; i < 50; ++i) {
    const SurfaceParameter parameter = random_parameter(first, random);
    const SurfacePoint p = first.evaluate(parameter), q = second.evaluate(parameter);
    EXPECT_LT((map * p.position + shift - q.position).norm(), 1e-12);
    EXPECT_LT((map * p.u - q.u).norm(), 1e-11 * (1 + p.u.norm()));
    EXPECT_LT((map * p.uv - q.uv).norm(), 1e-10 * (1 + p.uv.norm()));
    EXPECT_LT((map * p.vv - q.vv).norm(), 1e-10 * (1 + p.vv.norm()));
  }
}

TEST_P(Evaluation, IgnoresAGlobalFactorOfCovariances) {
  CovMesh before = control(), after = before;
  for (Sym3& c : after.vertices.covariances) c *= 1e-7;
  const SurfaceEvaluator first(before), second(after);
  Random random(14);
  for (int i = 0; i < 50; ++i) {
    const SurfaceParameter parameter = random_parameter(first, random);
    const SurfacePoint p = first.evaluate(parameter), q = second.evaluate(parameter);
    EXPECT_LT((p.position - q.position).norm(), 1e-13);
    EXPECT_LT((p.uu - q.uu).norm(), 1e-11 * (1 + p.uu.norm()));
    EXPECT_LT((p.covariance.matrix() * 1e-7 - q.covariance.matrix()).norm(), 1e-13 * q.covariance.trace());
  }
}

TEST_P(Evaluation, IsFiniteForNeedlesAndDiscs) {
  // The most that covariance meshes may hold.
  const SurfaceEvaluator surface(control(21, 1.001e-12, 1));
  Random random(15);
  for (int i = 0; i < 100; ++i) {
    const SurfaceParameter parameter = random_parameter(surface, random);
    const SurfacePoint p = surface.evaluate(parameter);
    EXPECT_TRUE((p.position + p.u + p.v + p.uu + p.uv + p.vv + p.normal).allFinite());
    const Curvature c = curvature(p);
    EXPECT_TRUE(std::isfinite(c.k1 + c.k2 + c.mean + c.gaussian));
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Evaluation, testing::ValuesIn(all_shapes()), name_of);

TEST(SurfaceEvaluator, DoesNotDependOnThreads) {
  const CovMesh control = with_random_covariances(with_holes(irregular_sphere(8), 11), 3, 0.05, 0.5);
  std::vector<SurfaceParameter> parameters;
  Random random(3);
  for (int i = 0; i < 5000; ++i)
    parameters.push_back({static_cast<Index>(random.below(control.faces.size())), 0.5 * random.uniform(0, 1),
                          0.5 * random.uniform(0, 1)});
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  const SurfaceEvaluator a(control, one), b(control, four);
  const std::vector<SurfacePoint> p = a.evaluate(parameters, one), q = b.evaluate(parameters, four);
  const std::vector<Curvature> k = a.curvatures(parameters, one), l = b.curvatures(parameters, four);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    ASSERT_EQ(p[i].position, q[i].position);
    ASSERT_EQ(p[i].vv, q[i].vv);
    ASSERT_EQ(k[i].k1, l[i].k1);
  }
}

TEST(SurfaceEvaluator, RefusesPlacesOffTheSurface) {
  const SurfaceEvaluator surface(with_equal_covariances(octahedron(), Sym3::identity()));
  EXPECT_THROW(surface.evaluate({8, 0, 0}), OptionError);
  EXPECT_THROW(surface.evaluate({0, 0.6, 0.6}), OptionError);
  EXPECT_THROW(surface.evaluate({0, -0.1, 0}), OptionError);
  EXPECT_THROW(surface.evaluate({0, std::numeric_limits<double>::quiet_NaN(), 0}), OptionError);
  EXPECT_THROW(SurfaceEvaluator(with_equal_covariances(cube(), Sym3::identity())), InvariantError);
}

TEST(SurfaceEvaluator, NumbersThePatchesOfPolygons) {
  const SurfaceEvaluator surface(
      with_rules(with_equal_covariances(mixed_polygons(), Sym3::identity()), {.scheme = Scheme::catmull_clark}));
  const std::size_t expected[] = {1, 3, 3, 1, 5};
  Index first = 0;
  for (std::size_t f = 0; f < 5; ++f) {
    EXPECT_EQ(surface.first_patch(f), first);
    EXPECT_EQ(surface.patches_of(f), expected[f]);
    first += static_cast<Index>(expected[f]);
  }
  EXPECT_EQ(surface.patch_count(), first);
}

// Analytic curvature: a paraboloid-like bicubic is reproduced by splines; a plane has none.
TEST(Curvature, OfKnownDerivatives) {
  SurfacePoint p{};
  // z = (3 x² - 2 y²)/2 at the origin, by parameters that are neither orthogonal nor of unit length.
  const Vec3 u(2, 0, 0), v(1, 3, 0);
  const auto bend = [](const Vec3& a, const Vec3& b) { return Vec3(0.3, -0.2, 3 * a.x() * b.x() - 2 * a.y() * b.y()); };
  p.u = u, p.v = v, p.uu = bend(u, u), p.uv = bend(u, v), p.vv = bend(v, v);
  p.normal = Vec3(0, 0, 1);
  const Curvature c = curvature(p);
  EXPECT_NEAR(c.k1, 2, 1e-14);
  EXPECT_NEAR(c.k2, -3, 1e-14);
  EXPECT_NEAR(c.mean, -0.5, 1e-14);
  EXPECT_NEAR(c.gaussian, -6, 1e-14);
  EXPECT_NEAR(std::abs(c.direction1.y()), 1, 1e-14);
  EXPECT_NEAR(std::abs(c.direction2.x()), 1, 1e-14);
  const FundamentalForms f = fundamental_forms(p);
  const double det = f.E * f.G - f.F * f.F;
  EXPECT_NEAR((f.L * f.N - f.M * f.M) / det, -6, 1e-14);
  EXPECT_NEAR((f.E * f.N - 2 * f.F * f.M + f.G * f.L) / (2 * det), 0.5, 1e-14);
}

/// Largest error of curvatures over a shape, relative to its largest curvature, at the middles of faces.
template <class Exact>
std::array<double, 2> curvature_errors(const Mesh& mesh, const SurfaceRules& rules, const Exact& exact) {
  const SurfaceEvaluator surface(with_rules(infer_covariances(mesh).mesh, rules));
  std::vector<SurfaceParameter> parameters;
  const double third = rules.scheme == Scheme::loop ? 1.0 / 3 : 0.5;
  for (Index f = 0; f < surface.patch_count(); ++f) parameters.push_back({f, third, third});
  const std::vector<SurfacePoint> points = surface.evaluate(parameters);
  const std::vector<Curvature> curvatures = surface.curvatures(parameters);
  std::array<double, 2> worst{0, 0};
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::array<double, 2> k = exact(points[i].position);
    worst[0] = std::max(worst[0], std::abs(curvatures[i].k1 - k[0]));
    worst[1] = std::max(worst[1], std::abs(curvatures[i].k2 - k[1]));
  }
  return worst;
}

std::array<double, 2> torus_curvature(const Vec3& p) {
  const double x = std::hypot(p.x(), p.y()) - 2;
  const double cosine = x / std::hypot(x, p.z());
  return {1 / 0.7, cosine / (2 + 0.7 * cosine)};
}

// Inferred covariances shrink a shape by its curvature times the squared spacing, and so the error falls by four as
// this halves.
TEST(Curvature, OfAnInferredTorusConvergesWithTheSquareOfTheSpacing) {
  double before = 0;
  for (const Index n : {24, 48, 96}) {
    const auto error = curvature_errors(torus(3 * n / 2, n), {}, torus_curvature);
    RecordProperty("torus_" + std::to_string(n), std::to_string(error[0]) + " " + std::to_string(error[1]));
    if (before > 0) {
      EXPECT_LT(error[0], 0.3 * before);
    }
    EXPECT_LT(error[1], error[0]);
    before = error[0];
  }
  EXPECT_LT(before, 0.01 / 0.7);
}

/// A cylinder of radius 1 along z, closed around, as quadrilaterals.
Mesh cylinder(Index n) {
  Mesh mesh;
  const Index rows = 8;
  for (Index z = 0; z < rows; ++z)
    for (Index i = 0; i < n; ++i) {
      const double a = 2 * std::numbers::pi * i / n;
      mesh.positions.emplace_back(std::cos(a), std::sin(a), 0.1 * z);
    }
  for (Index z = 0; z + 1 < rows; ++z)
    for (Index i = 0; i < n; ++i)
      mesh.faces.add(std::array{z * n + i, z * n + (i + 1) % n, (z + 1) * n + (i + 1) % n, (z + 1) * n + i});
  return mesh;
}

TEST(Curvature, OfACylinderConverges) {
  for (const Index n : {12, 24, 48}) {
    // Two rows from the rims, where there is a cylinder.
    const SurfaceEvaluator surface(with_rules(infer_covariances(cylinder(n)).mesh, {.scheme = Scheme::catmull_clark}));
    double worst = 0;
    for (Index f = 3 * n; f < 4 * n; ++f) {
      const Curvature c = curvature(surface.evaluate({f, 0.3, 0.6}));
      worst = std::max({worst, std::abs(c.k1 - 1), std::abs(c.k2)});
      EXPECT_NEAR(std::abs(c.direction2.z()), 1, 1e-6);
    }
    RecordProperty("cylinder_" + std::to_string(n), std::to_string(worst));
    EXPECT_LT(worst, 2 / static_cast<double>(n * n));
  }
}

// Near the six vertices of valence four the error does not fall, as Loop's rule gives the surface there the same
// relative error of curvature at every level; their share does, if slowly, as the error spreads.
TEST(Curvature, OfASphereConvergesInTheMean) {
  double before = 0;
  for (const int level : {2, 3, 4, 5}) {
    const SurfaceEvaluator surface(infer_covariances(sphere(level)).mesh);
    double sum = 0;
    for (Index f = 0; f < surface.patch_count(); ++f) {
      const Curvature c = curvature(surface.evaluate({f, 0.3, 0.3}));
      sum += std::pow(c.k1 - 1, 2) + std::pow(c.k2 - 1, 2);
    }
    const double rms = std::sqrt(sum / (2.0 * static_cast<double>(surface.patch_count())));
    RecordProperty("sphere_" + std::to_string(level), std::to_string(rms));
    if (before > 0) {
      EXPECT_LT(rms, 0.85 * before);
    }
    before = rms;
  }
  EXPECT_LT(before, 0.05);
}

}  // namespace
}  // namespace gpsrecon
