// Exact evaluation of limit surfaces against limit masks, refinement, differences and analytic shapes.

#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/infer.h>
#include <gpsrecon/gps/patch_table.h>
#include <gpsrecon/gps/refined_parameters.h>
#include <gtest/gtest.h>

#include <limits>

#include "gps/meshes.h"

namespace gpsrecon {
namespace {

using namespace test;

struct Shape {
  std::string name;
  Mesh mesh;
  EvaluateOptions options;
};

void PrintTo(const Shape& shape, std::ostream* out) {
  *out << shape.name;
}

Mesh shaken(Mesh mesh, std::uint64_t seed, double size = 0.2) {
  RandomSequence random(seed);
  for (Vec3& p : mesh.positions) p += size * random.vector();
  return mesh;
}

Mesh with_isolated_vertex(Mesh mesh) {
  mesh.positions.insert(mesh.positions.begin(), Vec3(7, 8, 9));
  for (Index& v : mesh.faces.corners) ++v;
  return mesh;
}

/// Two triangles back to back: vertices of valence two.
Mesh pillow() {
  return make_mesh({{0, 0, 0}, {1, 0, 0.1}, {0, 1, 0.2}}, {{0, 1, 2}, {0, 2, 1}});
}

std::vector<Shape> all_shapes() {
  std::vector<Shape> shapes;
  for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp}) {
    const std::string rule = corners == CornerRule::smooth ? "_smooth" : "_sharp";
    const EvaluateOptions options{.corners = corners};
    shapes.push_back({"triangle" + rule, make_mesh({{0, 0, 0}, {1, 0, 0.1}, {0, 1, 0.2}}, {{0, 1, 2}}), options});
    shapes.push_back({"grid" + rule, shaken(grid(5, 4), 6), options});
    shapes.push_back({"strip" + rule, shaken(grid(4, 1), 7), options});
    for (const Index n : {2, 3, 4, 5, 6, 7, 12})
      shapes.push_back({"open_fan_" + std::to_string(n) + rule, fan(n, false, n), options});
  }
  for (const Index n : {3, 4, 5, 6, 7, 12, 64})
    shapes.push_back({"closed_fan_" + std::to_string(n), fan(n, true, n), {}});
  shapes.push_back({"open_fan_64", fan(64, false, 64), {}});
  shapes.push_back({"pillow", pillow(), {}});
  shapes.push_back({"tetrahedron", tetrahedron(), {}});
  shapes.push_back({"octahedron", octahedron(), {}});
  shapes.push_back({"torus", torus(7, 5), {}});
  shapes.push_back({"irregular", irregular_sphere(3), {}});
  shapes.push_back({"holes", with_holes(irregular_sphere(4), 11), {}});
  shapes.push_back({"isolated", with_isolated_vertex(octahedron()), {}});
  shapes.push_back({"warren", irregular_sphere(5), {.weights = LoopWeights::warren}});
  return shapes;
}

std::string name_of(const testing::TestParamInfo<Shape>& info) {
  return info.param.name;
}

class Evaluation : public testing::TestWithParam<Shape> {
 protected:
  const Mesh& mesh() const { return GetParam().mesh; }
  const EvaluateOptions& options() const { return GetParam().options; }
  bool triangular() const { return options().scheme == Scheme::loop; }
  CovMesh control(std::uint64_t seed = 1, double low = 0.05, double high = 0.5) const {
    return with_random_covariances(mesh(), seed, low, high);
  }
  SubdivideOptions subdivision(int levels) const {
    return {.levels = levels, .weights = options().weights, .corners = options().corners};
  }
  SurfaceParameter random_place(const SurfaceEvaluator& surface, RandomSequence& random) const {
    SurfaceParameter place{static_cast<Index>(random.below(surface.patch_count())), random.uniform(0, 1),
                           random.uniform(0, 1)};
    if (triangular() && place.u + place.v > 1) place.u = 1 - place.u, place.v = 1 - place.v;
    return place;
  }
};

// The masks and the refinement are an independent way to the same points.
TEST_P(Evaluation, AgreesWithLimitMasksOfEveryLevel) {
  const CovMesh covmesh = control();
  const SurfaceEvaluator surface(covmesh, options());
  for (const int levels : {0, 1, 2, 5}) {
    if (levels == 5 && mesh().faces.size() > 100) continue;
    const Mesh refined = subdivide(covmesh, subdivision(levels));
    const std::vector<SurfaceParameter> places =
        refined_parameters(covmesh.faces, refined.faces, refined.positions.size(), levels, options().scheme);
    double largest = 0, largest_turn = 0;
    for (std::size_t v = 0; v < places.size(); ++v) {
      if (places[v].patch == no_index) continue;
      const SurfacePoint p = surface.evaluate(places[v]);
      largest = std::max(largest, (p.position - refined.positions[v]).norm());
      // Nearly parallel tangents (near vertices of two faces) leave the normal fewer digits.
      if (p.u.cross(p.v).norm() > 1e-4 * p.u.norm() * p.v.norm())
        largest_turn = std::max(largest_turn, (p.normal - refined.normals[v]).norm());
    }
    EXPECT_LT(largest, 2e-14) << levels;
    EXPECT_LT(largest_turn, 1e-9) << levels;
  }
}

TEST_P(Evaluation, DerivativesAreThoseOfCentralDifferences) {
  const SurfaceEvaluator surface(control(), options());
  RandomSequence random(9);
  int tried = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const SurfaceParameter p = random_place(surface, random);
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

INSTANTIATE_TEST_SUITE_P(Shapes, Evaluation, testing::ValuesIn(all_shapes()), name_of);

}  // namespace
}  // namespace gpsrecon
