#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/infer.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <map>
#include <numbers>
#include <set>

#include "support/meshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

double distance(const Sym3& a, const Sym3& b) {
  return (a.matrix() - b.matrix()).norm();
}

/// Population covariance of some points, computed the long way.
Mat3 covariance_of(const std::vector<Vec3>& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Mat3 sum = Mat3::Zero();
  for (const Vec3& p : points) sum += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  return sum;
}

Mat3 biased(const Mat3& m, double bias) {
  return m + bias * Eigen::SelfAdjointEigenSolver<Mat3>(m).eigenvalues()[2] * Mat3::Identity();
}

TEST(Infer, FaceMethodIsTheProductOfFaceGaussians) {
  const Mesh mesh = with_holes(irregular_sphere(3), 8);
  const Inference inferred = infer_covariances(mesh, {.bias = 0.1});
  EXPECT_EQ(inferred.degenerate_faces, 0u);
  EXPECT_EQ(inferred.vertices_without_neighborhood, 0u);
  EXPECT_EQ(inferred.mesh.faces, mesh.faces);
  EXPECT_EQ(inferred.mesh.vertices.means, mesh.positions);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    Mat3 precision = Mat3::Zero();
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto face = mesh.faces[f];
      if (std::find(face.begin(), face.end(), v) == face.end()) continue;
      precision +=
          biased(covariance_of({mesh.positions[face[0]], mesh.positions[face[1]], mesh.positions[face[2]]}), 0.1)
              .inverse();
    }
    const Mat3 expected = precision.inverse();
    EXPECT_LT((inferred.mesh.vertices.covariances[v].matrix() - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST(Infer, VertexMethodIsTheCovarianceOfTheUmbrella) {
  const Mesh mesh = with_holes(irregular_sphere(4), 8);
  const Inference inferred = infer_covariances(mesh, {.method = InferMethod::vertex});
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    std::set<Index> umbrella;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto face = mesh.faces[f];
      if (std::find(face.begin(), face.end(), v) != face.end()) umbrella.insert(face.begin(), face.end());
    }
    std::vector<Vec3> points;
    for (const Index i : umbrella) points.push_back(mesh.positions[i]);
    const Mat3 expected = biased(covariance_of(points), 0.05);
    EXPECT_LT((inferred.mesh.vertices.covariances[v].matrix() - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST(Infer, CommutesWithSimilarities) {
  const Mesh mesh = irregular_sphere(5);
  const Mat3 rotation = Random(2).rotation();
  const double scale = 37.5;
  Mesh moved = mesh;
  for (Vec3& p : moved.positions) p = scale * (rotation * p) + Vec3(3, -1, 2);
  for (const InferMethod method : {InferMethod::face, InferMethod::vertex}) {
    const Inference a = infer_covariances(mesh, {.method = method}), b = infer_covariances(moved, {.method = method});
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const Sym3 expected = scale * scale * congruence(rotation, a.mesh.vertices.covariances[v]);
      EXPECT_LT(distance(b.mesh.vertices.covariances[v], expected), 1e-10 * expected.trace());
    }
  }
}

TEST(Infer, TakesPolygons) {
  Mesh box;
  for (int k = 0; k < 8; ++k) box.positions.emplace_back(k & 1, (k >> 1) & 1, (k >> 2) & 1);
  for (const std::array<Index, 4>& face :
       {std::array<Index, 4>{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}})
    box.faces.add(face);
  // Each face of the unit cube has covariance 1/4 in its plane; three of them meet at right angles.
  const double in_plane = 0.25 + 0.05 * 0.25, across = 0.05 * 0.25;
  const double expected = 1 / (2 / in_plane + 1 / across);
  const Inference inferred = infer_covariances(box);
  for (const Sym3& covariance : inferred.mesh.vertices.covariances)
    EXPECT_LT(distance(covariance, Sym3::identity(expected)), 1e-15);
}

/// The quads of a cube with a grid of n × n on each side, welded; and the same with every quad split into triangles.
Mesh cube_grid(int n) {
  std::map<std::array<int, 3>, Index> index;
  Mesh mesh;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [entry, added] = index.try_emplace(at, static_cast<Index>(mesh.positions.size()));
    if (added) mesh.positions.emplace_back(at[0], at[1], at[2]);
    return entry->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int side : {0, n})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto at = [&](int u, int v) {
            std::array<int, 3> p{};
            p[axis] = side, p[(axis + 1) % 3] = u, p[(axis + 2) % 3] = v;
            return vertex(p);
          };
          std::array<Index, 4> quad{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
          if (side == 0) std::reverse(quad.begin(), quad.end());
          mesh.faces.add(quad);
        }
  return mesh;
}

TEST(Infer, PolygonsOfAnySizeAreTheirCorners) {
  // A prism over a regular n-gon, turned: three face Gaussians meet at each vertex.
  for (const Index n : {3u, 5u, 8u, 40u}) {
    const Mat3 rotation = Random(n).rotation();
    Mesh prism;
    for (const double z : {0.0, 1.0})
      for (Index k = 0; k < n; ++k) {
        const double angle = 2 * std::numbers::pi * k / n;
        prism.positions.push_back(rotation * Vec3(std::cos(angle), std::sin(angle), z));
      }
    std::vector<Index> bottom, top;
    for (Index k = 0; k < n; ++k) {
      bottom.push_back(n - 1 - k);
      top.push_back(n + k);
      prism.faces.add(std::array<Index, 4>{k, (k + 1) % n, n + (k + 1) % n, n + k});
    }
    prism.faces.add(bottom);
    prism.faces.add(top);
    const Inference inferred = infer_covariances(prism);
    EXPECT_EQ(inferred.degenerate_faces, 0u);
    for (Index v = 0; v < prism.positions.size(); ++v) {
      Mat3 precision = Mat3::Zero();
      for (std::size_t f = 0; f < prism.faces.size(); ++f) {
        const auto face = prism.faces[f];
        if (std::find(face.begin(), face.end(), v) == face.end()) continue;
        std::vector<Vec3> corners;
        for (const Index c : face) corners.push_back(prism.positions[c]);
        precision += biased(covariance_of(corners), 0.05).inverse();
      }
      const Mat3 expected = precision.inverse();
      EXPECT_LT((inferred.mesh.vertices.covariances[v].matrix() - expected).norm(), 1e-12 * expected.norm());
    }
  }
}

TEST(Infer, QuadsAndTheirTrianglesAgreeOnAxes) {
  // On a gridded cube a diagonal turns the covariance within a side, but across sides it must stay what symmetry says:
  // amid a side one axis is the normal of the side, with the least variance, for quads and triangles alike.
  const Mesh quads = cube_grid(4);
  Mesh triangles;
  triangles.positions = quads.positions;
  for (std::size_t f = 0; f < quads.faces.size(); ++f) {
    const auto face = quads.faces[f];
    triangles.faces.add(face[0], face[1], face[2]);
    triangles.faces.add(face[0], face[2], face[3]);
  }
  for (const InferMethod method : {InferMethod::face, InferMethod::vertex}) {
    const Inference a = infer_covariances(quads, {.method = method}),
                    b = infer_covariances(triangles, {.method = method});
    std::size_t flat = 0;
    for (std::size_t v = 0; v < quads.positions.size(); ++v) {
      const Vec3& p = quads.positions[v];
      int side = -1, sides = 0;
      for (int axis = 0; axis < 3; ++axis)
        if (p[axis] == 0 || p[axis] == 4) side = axis, ++sides;
      if (sides != 1) continue;
      ++flat;
      for (const Inference* inferred : {&a, &b}) {
        const Eigen3 e = eigen_decomposition(inferred->mesh.vertices.covariances[v]);
        EXPECT_NEAR(std::abs(e.vectors(side, 0)), 1, 1e-12);
        // Against the least in-plane variance, of a triangle a third of its largest: both have the bias on top.
        EXPECT_LT(e.values[0], 0.05 / (1.0 / 3 + 0.05) * (1 + 1e-9) * e.values[1]);
      }
    }
    EXPECT_EQ(flat, 6u * 9);
  }
}

TEST(Infer, AbsoluteBiasIsAddedAsItIs) {
  const Mesh mesh = irregular_sphere(6);
  const double sigma0 = 0.03;
  const Inference inferred = infer_covariances(mesh, {.sigma0 = Length::scene(sigma0)});
  const Mat3 added = sigma0 * sigma0 * Mat3::Identity();
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    Mat3 precision = Mat3::Zero();
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto face = mesh.faces[f];
      if (std::find(face.begin(), face.end(), v) == face.end()) continue;
      const Mat3 c = covariance_of({mesh.positions[face[0]], mesh.positions[face[1]], mesh.positions[face[2]]});
      precision += (c + added).inverse();
    }
    const Mat3 expected = precision.inverse();
    EXPECT_LT((inferred.mesh.vertices.covariances[v].matrix() - expected).norm(), 1e-12 * expected.norm());
  }
  // A length in world units: the same in a frame of another scale.
  Mesh framed = mesh;
  framed.frame.exponent = 3;
  const Inference local = infer_covariances(framed, {.sigma0 = Length::scene(8 * sigma0)});
  EXPECT_EQ(local.mesh.vertices.covariances, inferred.mesh.vertices.covariances);
  // None so small that a flat face has no inverse.
  const Inference flat = infer_covariances(grid(3, 3), {.sigma0 = Length::scene(1e-100)});
  const Inference smallest = infer_covariances(grid(3, 3), {.bias = 1e-9});
  EXPECT_EQ(flat.mesh.vertices.covariances, smallest.mesh.vertices.covariances);
}

TEST(Infer, ScalesByPowersOfTwoBitForBit) {
  const Mesh mesh = with_holes(irregular_sphere(7), 8);
  for (const int exponent : {-40, 11}) {
    Mesh scaled = mesh;
    for (Vec3& p : scaled.positions) p *= std::ldexp(1.0, exponent);
    for (const InferMethod method : {InferMethod::face, InferMethod::vertex}) {
      const Inference a = infer_covariances(mesh, {.method = method}),
                      b = infer_covariances(scaled, {.method = method});
      for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        EXPECT_EQ(b.mesh.vertices.covariances[v], a.mesh.vertices.covariances[v] * std::ldexp(1.0, 2 * exponent));
    }
  }
}

TEST(Infer, VertexMethodCommutesWithAffineMapsButForTheBias) {
  const Mesh mesh = irregular_sphere(8);
  Random random(9);
  const Mat3 map = random.rotation() * Vec3(1, 2, 0.5).asDiagonal() * random.rotation();
  Mesh moved = mesh;
  for (Vec3& p : moved.positions) p = map * p + Vec3(0.3, 5, -2);
  double last = 0;
  for (const double bias : {1e-4, 1e-6, 1e-8}) {
    const InferOptions options{.method = InferMethod::vertex, .bias = bias};
    const Inference a = infer_covariances(mesh, options), b = infer_covariances(moved, options);
    double worst = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const Sym3 expected = congruence(map, a.mesh.vertices.covariances[v]);
      worst = std::max(worst, distance(b.mesh.vertices.covariances[v], expected) / expected.trace());
    }
    // What differs is the bias in one space and the other: a few times itself, and so linear in it.
    EXPECT_LT(worst, 10 * bias);
    if (last > 0) {
      EXPECT_NEAR(last / worst, 100, 1);
    }
    last = worst;
  }
}

TEST(Infer, NeedleFacesChangeNothingElse) {
  // A square of two triangles, a needle without area on one side of it, and a vertex without any face.
  Mesh mesh =
      mesh_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0, 0}, {9, 9, 9}}, {{0, 1, 2}, {0, 2, 3}, {1, 0, 4}});
  for (const InferMethod method : {InferMethod::face, InferMethod::vertex}) {
    const Inference with_needle = infer_covariances(mesh, {.method = method});
    EXPECT_EQ(with_needle.degenerate_faces, 1u);
    EXPECT_EQ(with_needle.vertices_without_neighborhood, 2u);
    // The tip of the needle has two neighbours, whose mean precision it is given.
    const auto& covariances = with_needle.mesh.vertices.covariances;
    const Mat3 expected = (0.5 * (covariances[0].matrix().inverse() + covariances[1].matrix().inverse())).inverse();
    EXPECT_LT((covariances[4].matrix() - expected).norm(), 1e-12 * expected.norm());
    EXPECT_EQ(covariances[5], Sym3::identity(covariances[5].xx));
    EXPECT_GT(covariances[5].xx, 0);
  }
  const Inference with_needle = infer_covariances(mesh);
  const Mesh plain = mesh_of({mesh.positions.begin(), mesh.positions.begin() + 4}, {{0, 1, 2}, {0, 2, 3}});
  const Inference without = infer_covariances(plain);
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_EQ(with_needle.mesh.vertices.covariances[v], without.mesh.vertices.covariances[v]);
}

TEST(Infer, FansWithoutAreaTakeWhatSurroundsThem) {
  // A flat grid in which all vertices of a block coincide: faces without area around faces without area.
  const Index n = 8;
  Mesh mesh = grid(n, n);
  for (Index y = 2; y <= 6; ++y)
    for (Index x = 2; x <= 6; ++x) mesh.positions[y * (n + 1) + x] = Vec3(4, 4, 0);
  for (const InferMethod method : {InferMethod::face, InferMethod::vertex}) {
    const Inference inferred = infer_covariances(mesh, {.method = method});
    std::size_t collapsed = 0;
    std::set<Index> proper;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto face = mesh.faces[f];
      const Vec3 &p = mesh.positions[face[0]], &q = mesh.positions[face[1]], &r = mesh.positions[face[2]];
      if (p == q || q == r || r == p) {
        ++collapsed;
      } else {
        proper.insert(face.begin(), face.end());
      }
    }
    EXPECT_EQ(inferred.degenerate_faces, collapsed);
    EXPECT_EQ(inferred.vertices_without_neighborhood, mesh.positions.size() - proper.size());
    EXPECT_GT(inferred.vertices_without_neighborhood, 9u);  // more than one ring
    for (const Sym3& covariance : inferred.mesh.vertices.covariances) {
      // Everything lies in a plane, and so do all Gaussians, those that were filled too.
      EXPECT_LT(std::abs(covariance.xz) + std::abs(covariance.yz), 1e-12 * covariance.trace());
      EXPECT_LT(covariance.zz, 0.2 * covariance.trace());
    }
  }
}

TEST(Infer, RefusesWhatHasNoArea) {
  EXPECT_THROW(infer_covariances(mesh_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}})), NoSurfaceError);
  EXPECT_THROW(infer_covariances(mesh_of({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}})), NoSurfaceError);
  EXPECT_THROW(infer_covariances(Mesh{}), NoSurfaceError);
  EXPECT_THROW(infer_covariances(tetrahedron(), {.bias = 0}), OptionError);
  EXPECT_THROW(infer_covariances(tetrahedron(), {.bias = std::nan("")}), OptionError);
  EXPECT_THROW(infer_covariances(tetrahedron(), {.sigma0 = Length::scene(-1)}), OptionError);
  EXPECT_THROW(infer_covariances(tetrahedron(), {.sigma0 = Length::scene(1e-200)}), OptionError);
  EXPECT_THROW(infer_covariances(tetrahedron(), {.sigma0 = Length::scene(std::nan(""))}), OptionError);
  Mesh bow_tie = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}});
  EXPECT_THROW(infer_covariances(bow_tie), InvariantError);
}

}  // namespace
}  // namespace gpsrecon::test
