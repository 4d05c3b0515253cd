// Limit masks against brute-force refinement, eigenvectors of the subdivision matrix, and finite differences.

#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/loop.h>
#include <gpsrecon/gps/refined_connectivity.h>
#include <gtest/gtest.h>

#include "support/covmeshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

/// The faces around one vertex (0) with a value at every vertex. The values of the fan at the next level depend only on
/// those of this one, so it can be refined as often as one likes.
template <class T>
struct Fan {
  FaceList faces;
  std::vector<T> values;

  void refine(LoopWeights weights, CornerRule corners) {
    const Refinement step = loop_refine(faces, values.size(), weights, corners);
    std::vector<T> fine(step.stencils.rows());
    apply<T>(step.stencils, values, fine);
    // Every face of the fan begins with vertex 0 and keeps that place.
    std::vector<Index> label(fine.size(), no_index);
    label[0] = 0;
    values = {fine[0]};
    faces = {};
    for (std::size_t f = 0; f < step.faces.size(); ++f) {
      const auto face = step.faces[f];
      if (face[0] != 0) continue;
      for (const Index v : face)
        if (label[v] == no_index) {
          label[v] = static_cast<Index>(values.size());
          values.push_back(fine[v]);
        }
      faces.add(label[face[0]], label[face[1]], label[face[2]]);
    }
  }

  /// Affine maps commute with linear refinement: centring and scaling keeps all digits at any depth.
  void normalize() {
    double size = 0;
    for (std::size_t v = values.size(); v-- > 0;) {
      values[v] -= values[0];
      size = std::max(size, values[v].norm());
    }
    for (T& value : values) value /= size;
  }
};

Vec3 area_vector(const FaceList& faces, const std::vector<Vec3>& positions) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto face = faces[f];
    sum += (positions[face[1]] - positions[face[0]]).cross(positions[face[2]] - positions[face[0]]);
  }
  return sum;
}

struct Case {
  Index faces;
  bool closed;
  LoopWeights weights;
  CornerRule corners;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.faces << (c.closed ? " closed " : " open ") << (c.weights == LoopWeights::loop ? "loop " : "warren ")
       << (c.corners == CornerRule::smooth ? "smooth" : "sharp");
}

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const LoopWeights weights : {LoopWeights::loop, LoopWeights::warren})
    for (Index n = 3; n <= 12; ++n) cases.push_back({n, true, weights, CornerRule::smooth});
  for (Index k = 1; k <= 9; ++k) cases.push_back({k, false, LoopWeights::loop, CornerRule::smooth});
  cases.push_back({1, false, LoopWeights::loop, CornerRule::sharp});
  cases.push_back({2, false, LoopWeights::loop, CornerRule::sharp});
  return cases;
}

/// From six faces on a boundary vertex has no tangent plane: see loop.h.
bool has_tangent_plane(const Case& c) {
  return c.closed || c.faces <= 5;
}

class LimitMasks : public testing::TestWithParam<Case> {
 protected:
  static Mesh mesh() { return fan(GetParam().faces, GetParam().closed, 17 + GetParam().faces); }
  template <class T>
  static T limit(const FaceList& faces, const std::vector<T>& values, double LimitWeight::*part) {
    const Connectivity topology = triangle_connectivity(faces, values.size());
    return apply_row<T>(limit_table(topology, GetParam().weights, GetParam().corners).row(0), values, part);
  }
};

TEST_P(LimitMasks, GiveThePositionAfterManyRefinements) {
  Fan<Vec3> deep{mesh().faces, mesh().positions};
  const Vec3 expected = limit<Vec3>(deep.faces, deep.values, &LimitWeight::position);
  for (int level = 0; level < 60; ++level) deep.refine(GetParam().weights, GetParam().corners);
  EXPECT_LT((deep.values[0] - expected).norm(), 1e-14);
}

TEST_P(LimitMasks, AreEigenvectorsOfTheSubdivisionMatrix) {
  const Case c = GetParam();
  Fan<Vec3> fine{mesh().faces, mesh().positions};
  fine.refine(c.weights, c.corners);
  const auto ratio = [&](double LimitWeight::*part) {
    const Vec3 coarse_value = limit<Vec3>(mesh().faces, mesh().positions, part);
    const Vec3 fine_value = limit<Vec3>(fine.faces, fine.values, part);
    const double lambda = fine_value.dot(coarse_value) / coarse_value.squaredNorm();
    EXPECT_LT((fine_value - lambda * coarse_value).norm(), 1e-14 * coarse_value.norm());
    return lambda;
  };
  const double pi = std::numbers::pi;
  EXPECT_NEAR(ratio(&LimitWeight::position), 1, 1e-14);
  if (c.closed) {
    EXPECT_NEAR(ratio(&LimitWeight::u), 3.0 / 8 + std::cos(2 * pi / c.faces) / 4, 1e-14);
    EXPECT_NEAR(ratio(&LimitWeight::v), 3.0 / 8 + std::cos(2 * pi / c.faces) / 4, 1e-14);
  } else if (c.corners == CornerRule::sharp && c.faces == 1) {
    EXPECT_NEAR(ratio(&LimitWeight::u), 0.5, 1e-14);
    EXPECT_NEAR(ratio(&LimitWeight::v), 0.5, 1e-14);
  } else {
    EXPECT_NEAR(ratio(&LimitWeight::u), 0.5, 1e-14);
    EXPECT_NEAR(ratio(&LimitWeight::v), c.faces == 1 ? 0.25 : 3.0 / 8 + std::cos(pi / c.faces) / 4, 1e-14);
  }
}

TEST_P(LimitMasks, TangentWeightsSumToZeroAndPositionWeightsToOne) {
  const Connectivity topology = triangle_connectivity(mesh().faces, mesh().positions.size());
  const LimitTable table = limit_table(topology, GetParam().weights, GetParam().corners);
  for (std::size_t r = 0; r < table.rows(); ++r) {
    LimitWeight sum{0, 0, 0};
    for (const LimitWeight& w : table.row(r).weights) {
      EXPECT_GE(w.position, 0);
      sum.position += w.position;
      sum.u += w.u;
      sum.v += w.v;
    }
    EXPECT_NEAR(sum.position, 1, 1e-15);
    EXPECT_NEAR(sum.u, 0, 1e-14);
    EXPECT_NEAR(sum.v, 0, 1e-14);
  }
}

/// The smaller of the eigenvalues of the two tangents, and how many levels bring the fan down to a given size.
int levels_to_size(const Case& c, double size) {
  const double pi = std::numbers::pi;
  const double lambda = c.closed ? 3.0 / 8 + std::cos(2 * pi / c.faces) / 4
                                 : std::min(0.5, 3.0 / 8 + std::cos(pi / std::max<Index>(2, c.faces)) / 4);
  return static_cast<int>(std::log(size) / std::log(lambda));
}

TEST_P(LimitMasks, GiveTheNormalOfDeepRefinement) {
  if (!has_tangent_plane(GetParam())) GTEST_SKIP() << "the scheme has no tangent plane here";
  Fan<Vec3> deep{mesh().faces, mesh().positions};
  const Vec3 u = limit<Vec3>(deep.faces, deep.values, &LimitWeight::u);
  const Vec3 v = limit<Vec3>(deep.faces, deep.values, &LimitWeight::v);
  const Vec3 normal = u.cross(v).normalized();
  // A single face keeps its plane, and becomes a needle in it: no need to go deep, nor would there be digits left. Of
  // the others the slowest mode that disturbs the normal shrinks by 0.904 per step (five faces on the boundary).
  const int levels = !GetParam().closed && GetParam().faces == 1 ? 10 : 120;
  for (int level = 0; level < levels; ++level) {
    deep.refine(GetParam().weights, GetParam().corners);
    deep.normalize();
  }
  EXPECT_LT((area_vector(deep.faces, deep.values).normalized() - normal).norm(), 2e-5);
}

TEST_P(LimitMasks, GiveTheNormalOfDeepGaussianProductRefinement) {
  const Case c = GetParam();
  if (!has_tangent_plane(c)) GTEST_SKIP() << "the scheme has no tangent plane here";
  // The triangle at a smooth corner is as long as h and as wide as h²: the curvature of the map turns it at any depth.
  if (c.faces == 1 && c.corners == CornerRule::smooth) GTEST_SKIP() << "face normals do not converge here";
  Random random(c.faces);
  std::vector<DualPoint> dual;
  for (const Vec3& p : mesh().positions) dual.push_back(to_dual({p, random.covariance(0.02, 1)}));
  const DualMap map(limit<DualPoint>(mesh().faces, dual, &LimitWeight::position));
  const Vec3 u = map.tangent(limit<DualPoint>(mesh().faces, dual, &LimitWeight::u));
  const Vec3 v = map.tangent(limit<DualPoint>(mesh().faces, dual, &LimitWeight::v));
  const Vec3 normal = u.cross(v).normalized();

  const auto error_at_size = [&](double size) {
    Fan<DualPoint> deep{mesh().faces, dual};
    for (int level = levels_to_size(c, size); level > 0; --level) deep.refine(c.weights, c.corners);
    std::vector<Vec3> positions;
    for (const DualPoint& q : deep.values) positions.push_back(from_dual(q).mean);
    return (area_vector(deep.faces, positions).normalized() - normal).norm();
  };
  // The error falls like a power of the ratio of two eigenvalues; on the boundary of five faces that of the second
  // inner mode and the boundary curve is near one.
  const double second = c.closed ? 0 : 3.0 / 8 + std::cos(2 * std::numbers::pi / c.faces) / 4;
  const double bound = std::max(0.01, 2 * std::pow(second / 0.5, levels_to_size(c, 1e-6)));
  const double coarse = error_at_size(1e-3), fine = error_at_size(1e-6);
  EXPECT_LT(fine, bound);
  EXPECT_LT(fine, 0.6 * coarse);
}

TEST_P(LimitMasks, GiveContinuousNormals) {
  const Case c = GetParam();
  if (!has_tangent_plane(c)) GTEST_SKIP() << "the scheme has no tangent plane here";
  const CovMesh control = with_random_covariances(mesh(), 31 + c.faces, 0.1, 1);
  // Largest difference between the normal of vertex 0 and those of its neighbours.
  const auto jump = [&](int levels) {
    const Mesh surface =
        subdivide(with_rules(control, {.weights = c.weights, .corners = c.corners}), {.levels = levels});
    double largest = 0;
    for (std::size_t f = 0; f < surface.faces.size(); ++f) {
      const auto face = surface.faces[f];
      if (std::find(face.begin(), face.end(), 0) == face.end()) continue;
      for (const Index v : face) largest = std::max(largest, (surface.normals[v] - surface.normals[0]).norm());
    }
    return largest;
  };
  EXPECT_LT(jump(7), 0.8 * jump(4));
}

INSTANTIATE_TEST_SUITE_P(Fans, LimitMasks, testing::ValuesIn(all_cases()), [](const auto& parameter) {
  const Case& c = parameter.param;
  return (c.closed ? "closed_" : "open_") + std::to_string(c.faces) +
         (c.weights == LoopWeights::loop ? "_loop" : "_warren") +
         (c.corners == CornerRule::smooth ? "_smooth" : "_sharp");
});

}  // namespace
}  // namespace gpsrecon::test
