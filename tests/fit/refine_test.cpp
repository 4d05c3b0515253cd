#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/fit/fit.h>
#include <gpsrecon/fit/refine.h>
#include <gpsrecon/gps/dual.h>
#include <gpsrecon/gps/loop.h>
#include <gpsrecon/gps/refined_connectivity.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/covmeshes.h"

namespace gpsrecon {

using namespace internal;
namespace {

Connectivity connectivity(const CovMesh& mesh) {
  return triangle_connectivity(mesh.faces, mesh.vertices.size());
}
std::vector<char> random_marks(const Connectivity& topology, double share, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<char> marked(topology.edge_count());
  for (char& mark : marked) mark = random.uniform() < share;
  return marked;
}
double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}
double smallest_angle(const CovMesh& mesh) {
  double smallest = std::numbers::pi;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& at = mesh.vertices.means[mesh.faces[f][k]];
      const Vec3 a = mesh.vertices.means[mesh.faces[f][(k + 1) % 3]] - at,
                 b = mesh.vertices.means[mesh.faces[f][(k + 2) % 3]] - at;
      smallest = std::min(smallest, std::atan2(a.cross(b).norm(), a.dot(b)));
    }
  return smallest;
}

/// Closed and open meshes of all valences, with weights of their own.
std::vector<CovMesh> meshes() {
  std::vector<CovMesh> all = {test::with_random_covariances(test::irregular_sphere(3), 1, 0.05, 0.5),
                              test::with_random_covariances(test::torus(9, 7), 2, 0.05, 0.5),
                              test::with_random_covariances(test::with_holes(test::irregular_sphere(4), 11), 3, 0.05),
                              test::with_random_covariances(test::grid(7, 5), 4, 0.05, 0.5),
                              test::with_random_covariances(test::tetrahedron(), 5, 0.05, 0.5),
                              test::with_random_covariances(test::fan(1, false, 1), 6, 0.05, 0.5)};
  test::Random random(6);
  for (CovMesh& mesh : all)
    for (double& weight : mesh.vertices.weights) weight = random.uniform(0.5, 50);
  return all;
}

TEST(SplitEdges, KeepsTheSurfaceWhatItIs) {
  std::uint64_t seed = 0;
  for (const CovMesh& mesh : meshes())
    for (const double share : {0.02, 0.1, 0.5, 0.9}) {
      SCOPED_TRACE(testing::Message() << mesh.vertices.size() << " vertices, share " << share);
      const Connectivity coarse = connectivity(mesh);
      std::vector<char> marked = random_marks(coarse, share, ++seed);
      marked[seed % marked.size()] = 1;
      const CovMesh fine = split_edges(mesh, coarse, marked);
      ASSERT_NO_THROW(validate(fine));
      const Topology before = topology(mesh.faces, mesh.vertices.size()),
                     after = topology(fine.faces, fine.vertices.size());
      EXPECT_TRUE(after.manifold());
      EXPECT_EQ(after.euler, before.euler);
      EXPECT_EQ(after.components, before.components);
      EXPECT_EQ(after.boundary_loops, before.boundary_loops);
      EXPECT_EQ(after.unused_vertices, 0U);
      EXPECT_NEAR(sum(fine.vertices.weights), sum(mesh.vertices.weights), 1e-12 * sum(mesh.vertices.weights));
      const auto marks = static_cast<std::size_t>(std::count(marked.begin(), marked.end(), 1));
      EXPECT_GE(fine.vertices.size(), mesh.vertices.size() + marks);

      // Every marked edge is gone, and every new face lies in an old one with the same side up: with the new vertices
      // in the middle of their edges the vector areas add up to those of before.
      const Connectivity edges = build_connectivity(fine.faces, fine.vertices.size());
      std::set<std::pair<Index, Index>> kept;
      for (const Index h : edges.edge_start) kept.insert(std::minmax(edges.source(h), edges.target(h)));
      for (Index e = 0; e < marked.size(); ++e) {
        const Index h = coarse.edge_start[e];
        if (marked[e]) {
          EXPECT_FALSE(kept.contains(std::minmax(coarse.source(h), coarse.target(h))));
        }
      }
    }
}

// In a lattice of valence six with equal Gaussians a Loop step puts new vertices in the middle of their edges and moves
// no other: what is left are the triangles that bisection makes.
TEST(SplitEdges, HalvesNoAngleMoreThanOnce) {
  test::Random random(9);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    CovMesh mesh = test::flat_lattice(8);
    const Mat3 shear = random.matrix() + 1.5 * Mat3::Identity();
    for (Vec3& mean : mesh.vertices.means) mean = shear * mean;
    const Connectivity coarse = connectivity(mesh);
    const std::vector<char> marked = random_marks(coarse, random.uniform(), seed);
    const CovMesh fine = split_edges(mesh, coarse, marked);
    EXPECT_GE(smallest_angle(fine), 0.5 * smallest_angle(mesh) * (1 - 1e-9)) << seed;
    // The same plane patch, no face upside down.
    const Vec3 up = shear.col(0).cross(shear.col(1)).normalized();
    double before = 0, after = 0;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
      before += test::area_vector(mesh.faces, f, mesh.vertices.means).dot(up);
    for (std::size_t f = 0; f < fine.faces.size(); ++f) {
      EXPECT_GT(test::area_vector(fine.faces, f, fine.vertices.means).dot(up), 0);
      after += test::area_vector(fine.faces, f, fine.vertices.means).dot(up);
    }
    EXPECT_NEAR(after, before, 1e-12 * before);
  }
}

TEST(SplitEdges, AllEdgesMakeALoopStep) {
  for (const CovMesh& mesh : meshes()) {
    SCOPED_TRACE(mesh.vertices.size());
    const Connectivity coarse = connectivity(mesh);
    const CovMesh fine = split_edges(mesh, coarse, std::vector<char>(coarse.edge_count(), 1));
    const Refinement loop = loop_refine(mesh.faces, mesh.vertices.size());
    EXPECT_EQ(test::canonical(fine.faces), test::canonical(loop.faces));
    std::vector<DualPoint> dual;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) dual.push_back(to_dual(mesh.vertices.component(v)));
    ASSERT_EQ(fine.vertices.size(), loop.stencils.rows());
    for (Index v = 0; v < fine.vertices.size(); ++v) {
      const bool kept = v < coarse.vertex_count && coarse.on_boundary(v);
      const Gaussian expected =
          kept ? mesh.vertices.component(v) : from_dual(apply_row<DualPoint>(loop.stencils.row(v), dual));
      EXPECT_LT((fine.vertices.means[v] - expected.mean).norm(), 1e-12) << v;
      EXPECT_LT((fine.vertices.covariances[v] + expected.covariance * -1.0).matrix().norm(), 1e-12) << v;
    }
  }
}

TEST(SplitEdges, NoMarkNoChange) {
  for (const CovMesh& mesh : meshes()) {
    const Connectivity topology = connectivity(mesh);
    const CovMesh same = split_edges(mesh, topology, std::vector<char>(topology.edge_count(), 0));
    EXPECT_EQ(test::canonical(same.faces), test::canonical(mesh.faces));
    EXPECT_EQ(same.vertices.means, mesh.vertices.means);
    EXPECT_EQ(same.vertices.covariances, mesh.vertices.covariances);
    EXPECT_EQ(same.vertices.weights, mesh.vertices.weights);
  }
}

TEST(SplitEdges, CarriesWhatVerticesCarry) {
  CovMesh mesh = meshes()[0];
  mesh.vertices.sigma0 = 0.01;
  mesh.vertices.spacing = 0.02;
  mesh.vertices.frame = {Vec3(1, 2, 3), 4};
  for (const Vec3& mean : mesh.vertices.means) mesh.vertices.normals.push_back(mean.normalized());
  mesh.vertices.normal_variances.assign(mesh.vertices.size(), 0.1);
  const Connectivity coarse = connectivity(mesh);
  const CovMesh fine = split_edges(mesh, coarse, random_marks(coarse, 0.1, 1));
  EXPECT_GT(fine.vertices.size(), mesh.vertices.size());
  EXPECT_NO_THROW(validate(fine));
  EXPECT_EQ(fine.vertices.normals.size(), fine.vertices.size());
  EXPECT_EQ(fine.vertices.sigma0, 0.01);
  EXPECT_EQ(fine.vertices.spacing, 0.02);
  EXPECT_EQ(fine.vertices.frame, mesh.vertices.frame);
}

/// The edges with detail of a mesh without vertices added, after its fit.
struct Detail {
  CovMesh mesh;
  Connectivity topology;
  std::vector<double> marked;  // evidence

  Detail(const CovMesh& start, const PointCloud& cloud)
      : mesh(fit(start, cloud, {.refinements = 0}).mesh), topology(connectivity(mesh)) {
    const LimitSurface surface(mesh.faces, mesh.vertices.size(), 2);
    const Assignment assignment = assign_points(surface.evaluate(mesh.vertices), cloud, {});
    const Residuals residuals =
        robust_residuals(surface, assignment, cloud, std::vector<char>(cloud.size(), 0), median_offset(assignment));
    marked = edges_with_detail(surface, topology, residuals);
  }
  double share() const {
    return 1 - static_cast<double>(std::count(marked.begin(), marked.end(), 0.0)) / static_cast<double>(marked.size());
  }
};

/// Points on the lattice of so many cells, uniform, at z = height(x, y) + noise.
template <class Height>
PointCloud lattice_cloud(Index cells, std::size_t n, double noise, std::uint64_t seed, const Height& height) {
  test::Random random(seed, test::sampling);
  PointCloud cloud;
  for (std::size_t k = 0; k < n; ++k) {
    const double i = random.uniform(0, cells), j = random.uniform(0, cells);
    const double x = i + 0.5 * j - 0.75 * cells, y = std::sqrt(0.75) * (j - 0.5 * cells);
    cloud.positions.emplace_back(x, y, height(x, y) + noise * random.normal());
  }
  return cloud;
}

// One edge in thirty with 30 points per vertex, next to none with six.
TEST(EdgesWithDetail, NoiseShowsFew) {
  std::vector<double> shares;
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    for (const std::size_t per_vertex : {6, 30}) {
      const CovMesh plane = test::flat_lattice(20);
      const auto level = [](double, double) { return 0.0; };
      shares.push_back(Detail(plane, lattice_cloud(20, per_vertex * 441, 0.1, seed, level)).share());
      test::SampledShape sphere = test::random_sphere(per_vertex * 1026, seed);
      test::add_noise(sphere, 0.02, seed + 50);
      shares.push_back(Detail(test::sphere_mesh(4, 0.99), sphere.cloud()).share());
    }
  for (const double share : shares) EXPECT_LT(share, 0.04);
}

double bump(double x, double y) {
  return 0.2 * std::exp(-0.5 * (x * x + y * y) / (0.4 * 0.4));
}

TEST(EdgesWithDetail, ABumpNarrowerThanTheEdgesIsFoundAndFollowed) {
  const CovMesh start = test::flat_lattice(12);
  const PointCloud cloud = lattice_cloud(12, 12000, 0.02, 3, bump);
  const Detail detail(start, cloud);
  std::size_t near = 0, near_marked = 0, far = 0, far_marked = 0;
  for (Index e = 0; e < detail.marked.size(); ++e) {
    const Index h = detail.topology.edge_start[e];
    const double distance = 0.5 * (detail.mesh.vertices.means[detail.topology.source(h)] +
                                   detail.mesh.vertices.means[detail.topology.target(h)])
                                      .head<2>()
                                      .norm();
    if (distance < 1.2) ++near, near_marked += detail.marked[e] > 0 ? 1 : 0;
    if (distance > 3) ++far, far_marked += detail.marked[e] > 0 ? 1 : 0;
  }
  EXPECT_GT(near, 4U);
  EXPECT_GT(near_marked, 0U);
  EXPECT_LT(20 * far_marked, far);  // chance marks some, as in NoiseShowsFew

  const auto error = [](const Vec3& p) { return p.head<2>().norm() < 1.5 ? p.z() - bump(p.x(), p.y()) : 0; };
  const Fit without = fit(start, cloud, {.refinements = 0}), with = fit(start, cloud);
  EXPECT_GT(with.refinements, 0);
  EXPECT_EQ(with.added_vertices, with.mesh.vertices.size() - start.vertices.size());
  EXPECT_LT(with.added_vertices, start.vertices.size());
  EXPECT_EQ(without.added_vertices, 0U);
  // rms_of_surface averages over samples, of which refinement puts more where the bump is: the finer one is at no
  // advantage.
  const double coarse = test::rms_of_surface(without.mesh, error), fine = test::rms_of_surface(with.mesh, error);
  EXPECT_LT(fine, 0.8 * coarse) << coarse << " " << fine;
}

TEST(EdgesWithDetail, BoundaryEdgesAndEdgesWithFewPointsAreLeftAlone) {
  const CovMesh mesh = test::flat_lattice(6);
  const LimitSurface surface(mesh.faces, mesh.vertices.size(), 2);
  const Connectivity topology = connectivity(mesh);
  const std::size_t m = surface.sample_count();
  const auto marks = [&](double weight) {
    // All offsets are one: nothing of that is noise.
    const std::vector<double> sums(m, weight);
    return edges_with_detail(surface, topology, {sums, sums, sums});
  };
  const std::vector<double> many = marks(10), few = marks(0.1);
  EXPECT_EQ(static_cast<std::size_t>(std::count(few.begin(), few.end(), 0.0)), few.size());
  for (Index e = 0; e < many.size(); ++e)
    EXPECT_EQ(many[e] != 0, topology.opposite[topology.edge_start[e]] != no_index) << e;
}

}  // namespace
}  // namespace gpsrecon
