// Basis functions of subdivision surfaces: identities, differences, refinement, and their digits near irregular
// vertices.

#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/patch_table.h>
#include <gpsrecon/gps/refined_parameters.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "gps/surface_shapes.h"
#include "support/covmeshes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using namespace test;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

using Weights = std::array<double, 6>;
Weights parts(const JetWeight& w) {
  return {w.value, w.u, w.v, w.uu, w.uv, w.vv};
}

/// Shapes of every kind, and vertices of 1 to 40 faces, inside (from 2 or 3 on), on boundaries and at corners.
std::vector<Shape> shapes_and_valences() {
  std::vector<Shape> shapes = all_shapes();
  for (Index n = 1; n <= 40; ++n)
    for (const Scheme scheme : {Scheme::loop, Scheme::catmull_clark})
      for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp}) {
        if (corners == CornerRule::sharp && n > 1) continue;
        const bool loop = scheme == Scheme::loop;
        const std::string name = std::string(loop ? "triangles_" : "quads_") + std::to_string(n) +
                                 (corners == CornerRule::sharp ? "_sharp" : "");
        shapes.push_back({"open_" + name, loop ? fan(n, false, n) : quad_fan(n, false, n), {scheme, {}, corners}});
        if (n > 2) shapes.push_back({"closed_" + name, loop ? fan(n, true, n) : quad_fan(n, true, n), {scheme}});
      }
  shapes.push_back({"interior_valence_two", interior_valence_two(), {.scheme = Scheme::catmull_clark}});
  return shapes;
}

class BasisFunctions : public testing::TestWithParam<Shape> {
 protected:
  const Mesh& mesh() const { return GetParam().mesh; }
  const SurfaceRules& rules() const { return GetParam().rules; }
  PatchTable table() const { return PatchTable(mesh().faces, mesh().positions.size(), rules()); }
  CovMesh control() const { return with_rules(with_random_covariances(mesh(), 1, 0.05, 0.5), rules()); }

  /// Parameters of every patch: inside, on edges, close to its first corner and at it.
  std::vector<SurfaceParameter> parameters(const PatchTable& of) const {
    Random random(7);
    std::vector<SurfaceParameter> parameters;
    for (Index patch = 0; patch < of.patch_count(); ++patch) {
      for (int i = 0; i < 4; ++i) {
        SurfaceParameter p{patch, random.uniform(0, 1), random.uniform(0, 1)};
        if (of.triangular() && p.u + p.v > 1) p.u = 1 - p.u, p.v = 1 - p.v;
        parameters.push_back(p);
      }
      parameters.push_back({patch, 0, 0});
      parameters.push_back({patch, 1, 0});
      parameters.push_back({patch, 0.3, 0});
      parameters.push_back({patch, 0x1p-12, 0x1p-13});
      parameters.push_back({patch, 0, 0x1p-41});
    }
    return parameters;
  }
};

TEST_P(BasisFunctions, SumToOneAndTheirDerivativesToZero) {
  const PatchTable basis = table();
  const std::vector<SurfaceParameter> at = parameters(basis);
  const JetTable weights = basis.weights(at);
  ASSERT_EQ(weights.rows(), at.size());
  ASSERT_EQ(weights.columns, mesh().positions.size());
  for (std::size_t r = 0; r < at.size(); ++r) {
    const Row<JetWeight> row = weights.row(r);
    Weights sum{}, size{};
    for (std::size_t j = 0; j < row.indices.size(); ++j) {
      ASSERT_LT(row.indices[j], mesh().positions.size());
      if (j > 0) {
        ASSERT_LT(row.indices[j - 1], row.indices[j]);
      }
      EXPECT_GT(row.weights[j].value, -1e-16);
      for (std::size_t k = 0; k < 6; ++k) {
        sum[k] += parts(row.weights[j])[k];
        size[k] += std::abs(parts(row.weights[j])[k]);
      }
    }
    // A rounding for each that is added up here, and up to forty in what they are made by.
    const double roundings = epsilon * (40 + static_cast<double>(row.indices.size()));
    EXPECT_NEAR(sum[0], 1, roundings);
    for (std::size_t k = 1; k < 6; ++k) EXPECT_LE(std::abs(sum[k]), roundings * (1 + size[k])) << k;
  }
}

// Appendix B with the weights applied to the dual points outside.
TEST_P(BasisFunctions, GiveTheSurfaceThroughTheGaussianProduct) {
  const CovMesh covmesh = control();
  const SurfaceEvaluator surface(covmesh);
  const std::vector<SurfaceParameter> at = parameters(table());
  const JetTable weights = surface.weights(at);
  std::vector<DualPoint> dual;
  for (std::size_t v = 0; v < covmesh.vertices.size(); ++v) dual.push_back(to_dual(covmesh.vertices.component(v)));
  const std::vector<SurfacePoint> points = surface.evaluate(at);
  for (std::size_t r = 0; r < at.size(); ++r) {
    const auto applied = [&](double JetWeight::*part) { return apply_row<DualPoint>(weights.row(r), dual, part); };
    const DualMap map(applied(&JetWeight::value));
    const Vec3 u = map.tangent(applied(&JetWeight::u)), v = map.tangent(applied(&JetWeight::v));
    // Variances from 0.0025 to 0.25: a condition of 100, for the mean once and for tangents, of the mean, twice over.
    EXPECT_LT((map.mean() - points[r].position).norm(), 4 * 100 * epsilon);
    EXPECT_LT((u - points[r].u).norm(), 40 * 100 * epsilon * (1 + u.norm()));
    EXPECT_LT((v - points[r].v).norm(), 40 * 100 * epsilon * (1 + v.norm()));
  }
}

// The masks of uniform refinement, applied to any values, are another way to the values at its vertices.
TEST_P(BasisFunctions, AreThoseOfUniformRefinement) {
  const PatchTable basis = table();
  Random random(3);
  std::vector<Vec3> values(mesh().positions.size());
  for (Vec3& x : values) x = random.vector();
  for (const int levels : {0, 1, 3}) {
    if (levels == 0 && !basis.triangular() && !mesh().faces.all_of_size(4)) continue;
    const LimitSurface refined(mesh().faces, values.size(), levels, rules());
    const std::vector<SurfaceParameter> at =
        refined_parameters(mesh().faces, refined.faces(), refined.sample_count(), levels, rules().scheme);
    const std::vector<Vec3> expected = refined.to_samples<Vec3>(values);
    for (std::size_t s = 0; s < at.size(); ++s) {
      if (at[s].patch == no_index) continue;
      const JetTable weights = basis.weights({&at[s], 1});
      EXPECT_LT((apply_row<Vec3>(weights.row(0), values, &JetWeight::value) - expected[s]).norm(), 90 * epsilon)
          << levels;  // some twenty roundings of values of up to √3 a level, and in the weights
    }
  }
}

TEST_P(BasisFunctions, HaveTheDerivativesOfCentralDifferences) {
  const PatchTable basis = table();
  const auto dense = [&](const SurfaceParameter& p) {
    const JetTable weights = basis.weights({&p, 1});
    std::vector<Weights> all(mesh().positions.size(), Weights{});
    const Row<JetWeight> row = weights.row(0);
    for (std::size_t j = 0; j < row.indices.size(); ++j) all[row.indices[j]] = parts(row.weights[j]);
    return all;
  };
  // Inside polynomials, on regular leaves and one to three steps from irregular ones, and away from their seams. They
  // are of degree four at most, for which the differences are exact but for the rounding of weights, over the step.
  const double h = 1e-3, rounding = 20 * epsilon * 1.5 / h;
  for (Index patch = 0; patch < std::min<std::size_t>(basis.patch_count(), 12); ++patch)
    for (const auto& [u, v] : {std::pair{0.027, 0.02}, {0.05, 0.11}, {0.29, 0.13}, {0.4, 0.32}, {0.13, 0.64}}) {
      const std::vector<Weights> at = dense({patch, u, v});
      Weights bound;
      bound.fill(rounding);
      for (const Weights& w : at)
        for (std::size_t k = 0; k < 6; ++k) bound[k] += rounding * std::abs(w[k]);
      std::array<std::vector<Weights>, 4> to_u, to_v;
      const std::array<double, 4> steps{-2 * h, -h, h, 2 * h};
      for (std::size_t i = 0; i < 4; ++i) {
        to_u[i] = dense({patch, u + steps[i], v});
        to_v[i] = dense({patch, u, v + steps[i]});
      }
      for (std::size_t x = 0; x < at.size(); ++x) {
        const auto difference = [&](const std::array<std::vector<Weights>, 4>& to, std::size_t k) {
          return (8 * (to[2][x][k] - to[1][x][k]) - (to[3][x][k] - to[0][x][k])) / (12 * h);
        };
        EXPECT_NEAR(difference(to_u, 0), at[x][1], bound[0]);
        EXPECT_NEAR(difference(to_v, 0), at[x][2], bound[0]);
        EXPECT_NEAR(difference(to_u, 1), at[x][3], bound[1]);
        EXPECT_NEAR(difference(to_v, 1), at[x][4], bound[1]);
        EXPECT_NEAR(difference(to_u, 2), at[x][4], bound[2]);
        EXPECT_NEAR(difference(to_v, 2), at[x][5], bound[2]);
      }
    }
}

/// Σ over points of a leaf as a dense matrix: row i, column j holds the weight of point j in refined point i.
using Matrix = std::vector<std::vector<long double>>;
Matrix forward(const StencilTable& transposed, std::size_t rows) {
  const std::size_t n = transposed.rows();
  Matrix map(rows, std::vector<long double>(n, 0));
  for (std::size_t j = 1; j < n; ++j) {
    const Row<double> row = transposed.row(j);
    for (std::size_t e = 0; e < row.indices.size(); ++e) map[row.indices[e]][j] = row.weights[e];
  }
  for (std::vector<long double>& row : map) {
    row[0] = 1;
    for (std::size_t j = 1; j < n; ++j) row[0] -= row[j];
  }
  return map;
}

// What the steps do with the differences of the points from the vertex, in long double, and forwards instead of
// transposed. Parameters (3/4, 1/8), (1/8, 3/4) and (3/8, 3/8) times 2^-d.
TEST_P(BasisFunctions, KeepTheirDigitsAtAnyDepth) {
  const PatchTable basis = table();
  std::vector<bool> tried(basis.kinds().size(), false);
  for (Index l = 0; l < basis.leaves().size(); ++l) {
    const PatchTable::Leaf& leaf = basis.leaves()[l];
    if (leaf.kind == 0 || tried[leaf.kind]) continue;
    tried[leaf.kind] = true;
    const PatchTable::Kind& kind = basis.kinds()[leaf.kind];
    const std::size_t n = kind.point_count();
    const Matrix step = forward(kind.step, n);
    // Differences of unit values from that of point 0.
    Matrix values(n, std::vector<long double>(n, 0));
    for (std::size_t i = 1; i < n; ++i) values[i][i] = 1;
    for (std::size_t i = 0; i < n; ++i) values[i][0] = i == 0 ? 0 : -1;
    const auto times = [&](const Matrix& map, const Matrix& x) {
      Matrix result(map.size(), std::vector<long double>(n, 0));
      for (std::size_t i = 0; i < map.size(); ++i)
        for (std::size_t k = 0; k < n; ++k)
          if (map[i][k] != 0)
            for (std::size_t j = 0; j < n; ++j) result[i][j] += map[i][k] * x[k][j];
      return result;
    };
    for (int depth = 0; depth <= 47; ++depth) {
      if (depth > 0) {
        values = times(step, values);
        for (std::size_t i = n; i-- > 0;)
          for (std::size_t j = 0; j < n; ++j) values[i][j] -= values[0][j];
      }
      if (depth % 5 != 0 && depth != 47) continue;
      for (const std::size_t part : {0, 1, 2}) {
        double s = part == 0 ? 0.75 : part == 1 ? 0.125 : 0.375, t = part == 0 ? 0.125 : part == 1 ? 0.75 : 0.375;
        if (!basis.triangular() && part == 1) s = t = 0.625;
        if (!basis.triangular() && part == 2) s = 0.125, t = 0.75;
        PatchRow<2> row;
        basis.point_weights({l, std::ldexp(s, -depth), std::ldexp(t, -depth), 1, 0, 0, 1}, row);
        ASSERT_EQ(row.weights.size(), n);
        s *= 2, t *= 2;
        const bool upside_down = basis.triangular() && part == 2;
        const double scale = (upside_down ? -2 : 2) * std::ldexp(1.0, depth);
        std::vector<BasisWeight<2>> polynomials;
        const auto add = [&](const auto& functions) { polynomials.assign(functions.begin(), functions.end()); };
        if (basis.triangular())
          add(upside_down ? box_spline_basis<2>(1 - s, 1 - t)
                          : box_spline_basis<2>(part == 0 ? s - 1 : s, part == 0 ? t : t - 1));
        else
          add(bicubic_basis<2>(part == 2 ? s : s - 1, part == 0 ? t : t - 1));
        const Matrix patch = times(forward(kind.patches[part], polynomials.size()), values);
        for (Eigen::Index k = 1; k < 6; ++k) {
          std::vector<long double> expected(n, 0);
          long double terms = 0, error = 0;
          const double factor = k < 3 ? scale : scale * scale;
          for (std::size_t j = 0; j < n; ++j) {
            long double size = 0;
            for (std::size_t i = 0; i < polynomials.size(); ++i) {
              const long double term = static_cast<long double>(factor * polynomials[i][k]) * patch[i][j];
              expected[j] += term;
              size += std::abs(term);
            }
            terms = std::max(terms, size);
            error = std::max(error, std::abs(row.weights[j][k] - expected[j]));
          }
          // To the digits of their terms, which are differences of points from the vertex: first derivatives are as
          // large as these, in second ones they cancel more with each halving.
          EXPECT_LE(error, 1e-14L * terms) << depth << " " << k << " " << part;
        }
      }
    }
  }
}

TEST_P(BasisFunctions, AreLimitMasksAtIrregularVertices) {
  const PatchTable basis = table();
  Random random(5);
  std::vector<double> control(mesh().positions.size());
  for (double& x : control) x = random.uniform(-1, 1);
  const std::vector<double> base = basis.to_base<double>(control, {}), points = basis.to_points<double>(base, {});
  for (Index l = 0; l < basis.leaves().size(); ++l) {
    const PatchTable::Leaf& leaf = basis.leaves()[l];
    if (leaf.kind == 0) continue;
    const PatchTable::LeafPoint at{l, 0, 0, 1, 0, 0, 1};
    ASSERT_TRUE(basis.extraordinary(at));
    PatchRow<0> row;
    basis.point_weights(at, row);
    const double limit = apply_row<double>(basis.base_limit().row(basis.vertex_of(l)), base, &LimitWeight::position);
    EXPECT_NEAR(apply_row<double>(row.row(), points), limit, 1e-14);
    // The derivatives are those beside it.
    PatchRow<2> beside, all;
    basis.point_weights({l, PatchTable::leaf_offset, PatchTable::leaf_offset, 1, 0, 0, 1}, beside);
    basis.point_weights(at, all);
    for (std::size_t i = 0; i < all.weights.size(); ++i) {
      EXPECT_EQ(all.weights[i].tail<5>(), beside.weights[i].tail<5>());
      EXPECT_EQ(all.weights[i][0], row.weights[i]);
    }
  }
}

// The points of leaves as a reader of the arrays would use them.
TEST_P(BasisFunctions, CanBeReadAsFlatArrays) {
  const PatchTable basis = table();
  Random random(6);
  for (Index l = 0; l < basis.leaves().size(); ++l) {
    const PatchTable::Leaf& leaf = basis.leaves()[l];
    std::vector<Index> points(basis.points_of(leaf).begin(), basis.points_of(leaf).end());
    if (leaf.kind != 0) points.insert(points.end(), basis.ring_of(leaf).begin(), basis.ring_of(leaf).end());
    EXPECT_EQ(points.size(), leaf.kind != 0 ? basis.kinds()[leaf.kind].point_count() : basis.triangular() ? 12 : 16);
    for (const Index p : points) ASSERT_LT(p, basis.point_count());
    double s = random.uniform(0, 0.5), t = random.uniform(0, 0.5);
    PatchRow<0> row;
    basis.point_weights({l, s, t, 1, 0, 0, 1}, row);
    EXPECT_EQ(points, row.indices);
    if (leaf.kind != 0 || basis.triangular()) continue;
    // Cubic B-splines by repeated averaging (de Boor).
    const auto blend = [](double x) {
      std::array<double, 4> b{};
      for (std::size_t i = 0; i < 4; ++i) {
        std::array<double, 4> d{};
        d[i] = 1;
        for (int degree = 3; degree > 0; --degree)
          for (int j = 0; j < degree; ++j) {
            const double a = (x + degree - 1 - j) / degree;
            d[static_cast<std::size_t>(j)] =
                (1 - a) * d[static_cast<std::size_t>(j)] + a * d[static_cast<std::size_t>(j) + 1];
          }
        b[i] = d[0];
      }
      return b;
    };
    const std::array<double, 4> in_s = blend(s), in_t = blend(t);
    for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(row.weights[i], in_s[i % 4] * in_t[i / 4], 1e-15);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, BasisFunctions, testing::ValuesIn(shapes_and_valences()), name_of);

TEST(PatchTable, DoesNotDependOnThreads) {
  const Mesh mesh = with_holes(irregular_sphere(8), 11);
  const PatchTable table(mesh.faces, mesh.positions.size());
  std::vector<SurfaceParameter> parameters;
  Random random(3);
  for (int i = 0; i < 3000; ++i)
    parameters.push_back({static_cast<Index>(random.below(table.patch_count())), 0.5 * random.uniform(0, 1),
                          0.5 * random.uniform(0, 1)});
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  const JetTable a = table.weights(parameters, one), b = table.weights(parameters, four);
  EXPECT_EQ(a.indices, b.indices);
  EXPECT_EQ(a.offsets, b.offsets);
  EXPECT_EQ(a.masks, b.masks);
  for (std::size_t i = 0; i < a.weights.size(); ++i) ASSERT_EQ(parts(a.weights[i]), parts(b.weights[i]));
}

TEST(PatchTable, RefusesParametersOffTheSurfaceAndOtherFaces) {
  const Mesh mesh = octahedron();
  const PatchTable table(mesh.faces, mesh.positions.size());
  const SurfaceParameter outside{0, 0.6, 0.6}, beyond{8, 0, 0};
  EXPECT_THROW(table.weights({&outside, 1}), OptionError);
  EXPECT_THROW(table.weights({&beyond, 1}), OptionError);
  EXPECT_THROW(PatchTable(cube().faces, 8), InvariantError);
  EXPECT_EQ(table.weights({}).rows(), 0u);
}

// Integrals of products of basis functions and of their gradients: inside a grid those of cubic B-splines, whose inner
// products in one dimension are 151/315 and 397/1680 beside it, of their slopes 2/3 and -1/8.
TEST(PatchTable, AssemblesMassAndStiffness) {
  const Index n = 8;
  const Mesh mesh = quad_grid(n, n);
  const PatchTable table(mesh.faces, mesh.positions.size(), {.scheme = Scheme::catmull_clark});
  // Gauss and Legendre's four points are exact up to degree seven.
  const std::array<double, 4> x{-0.861136311594052575, -0.339981043584856265, 0.339981043584856265,
                                0.861136311594052575},
      w{0.347854845137453857, 0.652145154862546143, 0.652145154862546143, 0.347854845137453857};
  const Index a = (n / 2) * (n + 1) + n / 2, b = a + 1;
  std::array<double, 2> mass{}, stiffness{};
  std::vector<SurfaceParameter> parameters;
  std::vector<double> factors;
  for (Index f = 0; f < table.patch_count(); ++f)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j) {
        // Seams of leaves run through the middle of the patch, but the polynomials on both sides are the same.
        parameters.push_back({f, 0.5 + 0.5 * x[i], 0.5 + 0.5 * x[j]});
        factors.push_back(0.25 * w[i] * w[j]);
      }
  const JetTable weights = table.weights(parameters);
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const Row<JetWeight> row = weights.row(p);
    const auto of = [&](Index vertex) {
      const auto at = std::find(row.indices.begin(), row.indices.end(), vertex);
      return at == row.indices.end() ? JetWeight{} : row.weights[static_cast<std::size_t>(at - row.indices.begin())];
    };
    const JetWeight first = of(a);
    for (std::size_t k = 0; k < 2; ++k) {
      const JetWeight second = of(k == 0 ? a : b);
      mass[k] += factors[p] * first.value * second.value;
      stiffness[k] += factors[p] * (first.u * second.u + first.v * second.v);
    }
  }
  const std::array<double, 2> m{151.0 / 315, 397.0 / 1680}, s{2.0 / 3, -1.0 / 8};
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(mass[k], m[0] * m[k], 1e-13);
    EXPECT_NEAR(stiffness[k], m[0] * s[k] + s[0] * m[k], 1e-13);
  }
}

}  // namespace
}  // namespace gpsrecon
