#include <gpsrecon/core/error.h>
#include <gpsrecon/gps/infer.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <set>

#include "meshes.h"

namespace gpsrecon::test {
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

TEST(Infer, SkipsAndCountsDegenerateFaces) {
  // A square of two triangles, a needle without area on one side of it, and a vertex without any face.
  Mesh mesh = make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0, 0}, {9, 9, 9}},
                        {{0, 1, 2}, {0, 2, 3}, {1, 0, 4}});
  const Inference with_needle = infer_covariances(mesh);
  EXPECT_EQ(with_needle.degenerate_faces, 1u);
  EXPECT_EQ(with_needle.vertices_without_neighborhood, 2u);
  Mesh plain = make_mesh({mesh.positions.begin(), mesh.positions.begin() + 4}, {{0, 1, 2}, {0, 2, 3}});
  const Inference without = infer_covariances(plain);
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_EQ(with_needle.mesh.vertices.covariances[v], without.mesh.vertices.covariances[v]);
  for (const std::size_t v : {4, 5}) {
    const Sym3& filled = with_needle.mesh.vertices.covariances[v];
    EXPECT_EQ(filled, Sym3::identity(filled.xx));
    EXPECT_GT(filled.xx, 0);
  }
}

TEST(Infer, RefusesWhatHasNoArea) {
  EXPECT_THROW(infer_covariances(make_mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}})), NoSurfaceError);
  EXPECT_THROW(infer_covariances(make_mesh({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}})), NoSurfaceError);
  EXPECT_THROW(infer_covariances(Mesh{}), NoSurfaceError);
  EXPECT_THROW(infer_covariances(tetrahedron(), {.bias = 0}), OptionError);
  EXPECT_THROW(infer_covariances(tetrahedron(), {.bias = std::nan("")}), OptionError);
  Mesh bow_tie = make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}});
  EXPECT_THROW(infer_covariances(bow_tie), InvariantError);
}

}  // namespace
}  // namespace gpsrecon::test
