#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <gpsrecon/report/report.h>
#include <gtest/gtest.h>

#include <numeric>

#include "support/meshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

CompareOptions samples(std::size_t n) {
  CompareOptions options;
  options.samples = n;
  return options;
}

TEST(SampleSurface, IsUniformByArea) {
  const Mesh mesh = quad_box(1, 2, 5);
  constexpr std::size_t n = 20000;
  const AreaSamples s = sample_surface(mesh, n, 1);
  ASSERT_EQ(s.positions.size(), n);
  const double total = surface_area(mesh.positions, mesh.faces);
  std::vector<double> count(mesh.faces.size(), 0);
  std::vector<Vec3> mean(mesh.faces.size(), Vec3::Zero());
  const SurfaceDistance surface(mesh);
  for (std::size_t i = 0; i < n; ++i) {
    count[s.faces[i]] += 1;
    mean[s.faces[i]] += s.positions[i];
    EXPECT_LT(surface.closest(s.positions[i]).distance, 1e-14);
  }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    FaceList one;
    one.add(mesh.faces[f]);
    // One sample per strip of equal area: a face's share is off by at most the strips at its two ends.
    EXPECT_NEAR(count[f], n * surface_area(mesh.positions, one) / total, 2.0);
    Vec3 center = Vec3::Zero();
    for (const Index v : mesh.faces[f]) center += mesh.positions[v] / 4;
    EXPECT_LT((mean[f] / count[f] - center).norm(), 5 * 5 / std::sqrt(12 * count[f]));  // five standard deviations
  }
}

TEST(SampleSurface, IsUniformWithinATriangle) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces.add(0, 1, 2);
  constexpr std::size_t n = 40000;
  const AreaSamples s = sample_surface(mesh, n, 1);
  // ∫x² and ∫xy over the triangle, divided by its area: 1/6 and 1/12.
  double xx = 0, xy = 0;
  for (const Vec3& p : s.positions) xx += p.x() * p.x() / n, xy += p.x() * p.y() / n;
  EXPECT_NEAR(xx, 1.0 / 6, 0.005);
  EXPECT_NEAR(xy, 1.0 / 12, 0.003);
}

TEST(SampleSurface, IsSeededAndSkipsFacesWithoutArea) {
  Mesh mesh = sphere(2);
  for (int i = 0; i < 5; ++i) mesh.faces.add(0, 0, 1);
  RunContext context;
  const AreaSamples a = sample_surface(mesh, 1000, 1, context), b = sample_surface(mesh, 1000, 1, context);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_NE(a.positions, sample_surface(mesh, 1000, 2, context).positions);
  context.seed = 2;
  EXPECT_NE(a.positions, sample_surface(mesh, 1000, 1, context).positions);
  for (const Index f : a.faces) EXPECT_LT(f, mesh.faces.size() - 5);
  Mesh flat;
  flat.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  flat.faces.add(0, 1, 2);
  EXPECT_THROW(sample_surface(flat, 10, 1), InvariantError);
  EXPECT_THROW(sample_surface(Mesh{}, 10, 1), InvariantError);
}

TEST(CompareMeshes, ParallelPlanesAreTheirDistanceApart) {
  const double d = 0.1;
  const Comparison report = compare(square(d), square(0), samples(5000));
  ASSERT_TRUE(report.reference);
  EXPECT_FALSE(report.points_to_surface);
  EXPECT_DOUBLE_EQ(report.diagonal, std::sqrt(2.0));
  for (const DirectionMeasures& direction :
       {report.reference->mesh_to_reference, report.reference->reference_to_mesh}) {
    const Statistics& s = direction.distance.distance;
    EXPECT_EQ(s.count, 5000u);
    for (const double x : {s.mean, s.rms, s.median, s.p95, s.p99, s.max}) EXPECT_NEAR(x, d, 1e-15);
    EXPECT_EQ(direction.normals.count, 5000u);
    EXPECT_EQ(direction.normals.mean, 0);
    EXPECT_EQ(direction.normals.flipped, 0);
    ASSERT_TRUE(direction.distance.histogram);
    EXPECT_EQ(direction.distance.histogram->counts[15], 5000);  // 0.0707 lies between 0.05 and 0.1
  }
}

TEST(CompareMeshes, TurnedFacesAreFlippedButNotTilted) {
  const Comparison report = compare(flipped(square(0.1)), square(0), samples(1000));
  EXPECT_EQ(report.reference->mesh_to_reference.normals.flipped, 1);
  EXPECT_EQ(report.reference->reference_to_mesh.normals.flipped, 1);
  EXPECT_NEAR(report.reference->mesh_to_reference.normals.mean, 0, 1e-12);
}

TEST(CompareMeshes, ATiltedPlaneHasItsAngle) {
  for (const double degrees : {0.001, 10.0, 60.0}) {
    const Mesh flat = square(0);
    Mesh tilted = flat;
    const Eigen::AngleAxisd turn(degrees * M_PI / 180, Vec3(1, 2, 0).normalized());
    for (Vec3& p : tilted.positions) p = turn * p;
    const Comparison report = compare(tilted, flat, samples(1000));
    for (const auto& normals :
         {report.reference->mesh_to_reference.normals, report.reference->reference_to_mesh.normals}) {
      EXPECT_NEAR(normals.mean, degrees, 1e-10);
      EXPECT_NEAR(normals.p95, degrees, 1e-10);
    }
  }
}

TEST(CompareMeshes, AMeshEqualsItself) {
  const Mesh mesh = sphere(4);
  const Comparison report = compare(mesh, mesh, samples(20000));
  EXPECT_LT(report.reference->mesh_to_reference.distance.distance.max, 1e-15);
  EXPECT_LT(report.reference->reference_to_mesh.distance.distance.max, 1e-15);
}

TEST(CompareMeshes, ExchangingTheTwoExchangesTheDirections) {
  Mesh a = sphere(4), b = quad_torus(60, 40, 0.8, 0.5);
  const Comparison ab = compare(a, b, samples(50000)), ba = compare(b, a, samples(50000));
  const auto expect_same = [](const DirectionMeasures& x, const DirectionMeasures& y) {
    EXPECT_NEAR(x.distance.distance.mean, y.distance.distance.mean, 4e-3 * x.distance.distance.mean);
    EXPECT_NEAR(x.distance.distance.rms, y.distance.distance.rms, 4e-3 * x.distance.distance.rms);
    EXPECT_NEAR(x.normals.mean, y.normals.mean, 0.2);
    EXPECT_NEAR(x.normals.flipped, y.normals.flipped, 5e-3);
  };
  expect_same(ab.reference->mesh_to_reference, ba.reference->reference_to_mesh);
  expect_same(ab.reference->reference_to_mesh, ba.reference->mesh_to_reference);
}

TEST(CompareMeshes, ConcentricSpheres) {
  const Mesh inner = sphere(6);
  Mesh outer = inner;
  for (Vec3& p : outer.positions) p *= 1.1;
  const Comparison report = compare(outer, inner, samples(50000));
  // Facets of edge h lie up to h²/8 r inside their sphere.
  const double sagitta = std::pow(M_PI / 2 / 64, 2) / 2;
  for (const auto& direction : {report.reference->mesh_to_reference, report.reference->reference_to_mesh}) {
    EXPECT_NEAR(direction.distance.distance.rms, 0.1, sagitta);
    EXPECT_EQ(direction.normals.flipped, 0);
    EXPECT_LT(direction.normals.p95, 3);
  }
  EXPECT_NEAR(report.diagonal, 2 * std::sqrt(3.0), 1e-12);
}

TEST(CompareMeshes, MissingSurfaceShowsOnlyFromTheReference) {
  const Mesh whole = sphere(5);
  Mesh half = whole;
  half.faces = {};
  for (std::size_t f = 0; f < whole.faces.size(); ++f) {
    const auto face = whole.faces[f];
    if (whole.positions[face[0]].z() + whole.positions[face[1]].z() + whole.positions[face[2]].z() > 0)
      half.faces.add(face);
  }
  constexpr std::size_t n = 20000;
  const double spacing = std::sqrt(4 * M_PI / n);  // no sample need be nearer to the south pole than about this
  const Comparison report = compare(half, whole, samples(n));
  EXPECT_LT(report.reference->mesh_to_reference.distance.distance.max, 1e-15);
  EXPECT_NEAR(report.reference->reference_to_mesh.distance.distance.max, std::sqrt(2.0), spacing);
  EXPECT_LT((report.reference->reference_to_mesh.distance.max_at - Vec3(0, 0, -1)).norm(), 2 * spacing);
  EXPECT_LT(report.reference->reference_to_mesh.distance.distance.median, 0.05);
}

TEST(CompareMeshes, DoesNotDependOnTheFrames) {
  const Mesh truth = sphere(4), surface = quad_torus(60, 40, 0.8, 0.5);
  const Comparison expected = compare(surface, truth, samples(5000));
  const auto with_frame = [](Mesh mesh, const Frame& frame) {
    for (Vec3& p : mesh.positions) p = frame.to_local(p);
    mesh.frame = frame;
    return mesh;
  };
  const Frame a{{0.5, -2, 8}, 3}, b{{-1, 0.25, 0}, -2};
  for (const auto& [first, second] : {std::pair{a, a}, {a, b}, {Frame{}, b}, {a, Frame{}}}) {
    const Comparison report = compare(with_frame(surface, first), with_frame(truth, second), samples(5000));
    const auto expect_near = [](double x, double y) { EXPECT_NEAR(x, y, 1e-13 * std::abs(y)); };
    expect_near(report.diagonal, expected.diagonal);
    expect_near(report.mesh->area, expected.mesh->area);
    expect_near(*report.mesh->volume, *expected.mesh->volume);
    const DirectionMeasures &x = report.reference->reference_to_mesh, &y = expected.reference->reference_to_mesh;
    expect_near(x.distance.distance.rms, y.distance.distance.rms);
    expect_near(x.distance.distance.max, y.distance.distance.max);
    EXPECT_LT((x.distance.max_at - y.distance.max_at).norm(), 1e-13);
  }
}

TEST(Compare, SameBytesForAnyNumberOfThreads) {
  const Mesh mesh = quad_torus(60, 40, 0.8, 0.5), truth = sphere(4);
  PointCloud cloud;
  Random random(51);
  for (int i = 0; i < 20000; ++i) cloud.positions.push_back(random.vector());
  std::vector<std::string> reports;
  for (const int threads : {1, 2, 4}) {
    RunContext context;
    context.threads = threads;
    reports.push_back(to_json(report_of(compare(mesh, truth, samples(20000), context))) +
                      to_json(report_of(compare(mesh, cloud, {}, context))));
  }
  EXPECT_EQ(reports[0], reports[1]);
  EXPECT_EQ(reports[0], reports[2]);
}

TEST(CompareCloud, MeasuresEachPoint) {
  PointCloud cloud;
  cloud.positions = {{0.5, 0.5, 0.1}, {0.2, 0.7, -0.2}, {0.5, 2, 0}, {0.3, 0.3, 0}};
  const Comparison report = compare(square(0), cloud);
  ASSERT_TRUE(report.points_to_surface);
  EXPECT_FALSE(report.reference);
  const Statistics& s = report.points_to_surface->distance;
  EXPECT_EQ(s.count, 4u);
  EXPECT_NEAR(s.mean, 1.3 / 4, 1e-15);
  EXPECT_NEAR(s.rms, std::sqrt((0.01 + 0.04 + 1) / 4), 1e-15);
  EXPECT_NEAR(s.max, 1, 1e-15);
  EXPECT_EQ(s.index_of_max, 2u);
  EXPECT_EQ(report.points_to_surface->max_at, Vec3(0.5, 2, 0));
  EXPECT_DOUBLE_EQ(report.diagonal, Vec3(0.3, 1.7, 0.3).norm());
  EXPECT_EQ(report.points, 4u);
}

TEST(CompareCloud, WeightsCountDuplicates) {
  PointCloud merged, all;
  Random random(52);
  for (int i = 0; i < 2000; ++i) {
    merged.positions.push_back(random.vector());
    merged.weights.push_back(1 + i % 3);
    for (int k = 0; k <= i % 3; ++k) all.positions.push_back(merged.positions.back());
  }
  const Mesh mesh = sphere(3);
  const DistanceMeasures a = *compare(mesh, merged).points_to_surface, b = *compare(mesh, all).points_to_surface;
  EXPECT_EQ(a.distance.weight, b.distance.weight);
  EXPECT_NEAR(a.distance.mean, b.distance.mean, 1e-14);
  EXPECT_NEAR(a.distance.rms, b.distance.rms, 1e-14);
  EXPECT_EQ(a.distance.median, b.distance.median);
  EXPECT_EQ(a.distance.p99, b.distance.p99);
  EXPECT_EQ(a.max_at, b.max_at);
  EXPECT_EQ(a.histogram->counts, b.histogram->counts);
}

TEST(CompareCloud, OfOnePointHasNoDiagonal) {
  PointCloud cloud;
  cloud.positions = {{0.5, 0.5, 2}};
  const Comparison report = compare(square(0), cloud);
  EXPECT_EQ(report.diagonal, 0);
  EXPECT_DOUBLE_EQ(report.points_to_surface->distance.rms, 2);
  EXPECT_FALSE(report.points_to_surface->histogram);
  EXPECT_FALSE(to_json(report_of(report)).empty());
  EXPECT_EQ(summary(report_of(report)).find("nan"), std::string::npos);
}

TEST(Compare, RefusesWhatCannotBeCompared) {
  const Mesh mesh = sphere(1);
  PointCloud cloud;
  EXPECT_THROW(compare(mesh, cloud), InvariantError);
  cloud.positions = {{0, 0, std::nan("")}};
  EXPECT_THROW(compare(mesh, cloud), InvariantError);
  cloud.positions = {{0, 0, 1}};
  EXPECT_THROW(compare(Mesh{}, cloud), InvariantError);
  EXPECT_THROW(compare(Mesh{}, mesh), InvariantError);
  EXPECT_THROW(compare(mesh, Mesh{}), InvariantError);
  EXPECT_THROW(compare(mesh, mesh, samples(0)), OptionError);
  Mesh broken = mesh;
  broken.faces.add(0, 1, 1000);
  EXPECT_THROW(compare(broken, mesh), InvariantError);
  EXPECT_THROW(compare(mesh, broken), InvariantError);
  EXPECT_THROW(compare(broken, cloud), InvariantError);
}

TEST(Compare, ToleratesFacesWithoutArea) {
  Mesh mesh = sphere(2);
  mesh.faces.add(0, 1, 1);
  const Comparison report = compare(mesh, sphere(2), samples(1000));
  EXPECT_LT(report.reference->mesh_to_reference.distance.distance.max, 1e-15);
  Mesh line;  // no area at all, but still at a distance
  line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.faces.add(0, 1, 2);
  PointCloud cloud;
  cloud.positions = {{1, 3, 0}, {5, 4, 0}};
  EXPECT_DOUBLE_EQ(compare(line, cloud).points_to_surface->distance.mean, 4);
  EXPECT_THROW(compare(line, sphere(1), samples(10)), InvariantError);
}

TEST(MeasureMesh, VolumeAreaAndGenus) {
  const MeshMeasures b = measure_mesh(quad_box(1, 2, 5));
  EXPECT_DOUBLE_EQ(b.area, 2 * (2 + 5 + 10));
  ASSERT_TRUE(b.volume);
  EXPECT_DOUBLE_EQ(*b.volume, 10);
  EXPECT_EQ(genus(b.topology), 0);
  EXPECT_DOUBLE_EQ(*measure_mesh(flipped(quad_box(1, 2, 5))).volume, -10);

  const MeshMeasures t = measure_mesh(quad_torus(200, 100, 2, 0.5));
  EXPECT_NEAR(*t.volume, 2 * M_PI * M_PI * 2 * 0.25, 0.01 * *t.volume);
  EXPECT_NEAR(t.area, 4 * M_PI * M_PI * 2 * 0.5, 0.01 * t.area);
  EXPECT_EQ(genus(t.topology), 1);

  Mesh two = quad_box(1, 1, 1);
  const Mesh other = quad_torus(20, 10, 2, 0.5);
  for (const Vec3& p : other.positions) two.positions.push_back(p + Vec3(10, 0, 0));
  for (std::size_t f = 0; f < other.faces.size(); ++f) {
    std::vector<Index> face(other.faces[f].begin(), other.faces[f].end());
    for (Index& v : face) v += 8;
    two.faces.add(face);
  }
  EXPECT_EQ(measure_mesh(two).topology.components, 2u);
  EXPECT_EQ(genus(measure_mesh(two).topology), 1);
}

TEST(MeasureMesh, VolumeIsKeptByMotionsAndFarAway) {
  const Mesh mesh = quad_torus(50, 30, 2, 0.5);
  const double volume = *measure_mesh(mesh).volume;
  Eigen::Isometry3d motion = some_motion();
  EXPECT_NEAR(*measure_mesh(moved(mesh, motion)).volume, volume, 1e-13 * volume);
  motion.translation() = Vec3(6e5, 5e6, 0);
  EXPECT_NEAR(*measure_mesh(moved(mesh, motion)).volume, volume, 1e-8 * volume);
}

TEST(MeasureMesh, OpenAndEmptyMeshesHaveNoVolume) {
  const MeshMeasures open = measure_mesh(square(0));
  EXPECT_DOUBLE_EQ(open.area, 1);
  EXPECT_FALSE(open.volume);
  EXPECT_FALSE(genus(open.topology));
  const MeshMeasures empty = measure_mesh(Mesh{});
  EXPECT_EQ(empty.area, 0);
  EXPECT_FALSE(empty.volume);
}

TEST(MeasureBoundaryLoops, LongestFirstInSceneUnits) {
  Mesh mesh = quad_box(1, 2, 5);
  FaceList open;  // without its bottom, and without half of its lid
  for (std::size_t f = 1; f < 5; ++f) open.add(mesh.faces[f]);
  open.add(4, 5, 6);
  mesh.faces = open;
  const Frame frame{{100, 0, 0}, 1};
  const auto loops =
      measure_boundary_loops(mesh.positions, build_connectivity(mesh.faces, mesh.positions.size()), frame);
  ASSERT_EQ(loops.size(), 2u);
  EXPECT_EQ(loops[0].edges, 4u);
  EXPECT_DOUBLE_EQ(loops[0].length, 2 * 6);
  EXPECT_LT((loops[0].center - frame.to_world(Vec3(0.5, 1, 0))).norm(), 1e-13);
  EXPECT_EQ(loops[1].edges, 3u);
  EXPECT_DOUBLE_EQ(loops[1].length, 2 * (3 + std::sqrt(5.0)));
  EXPECT_EQ(loops[0].reason, "unknown");
  // The first half-edge of the list is one of the bottom.
  const auto explained = measure_boundary_loops(mesh.positions, build_connectivity(mesh.faces, mesh.positions.size()),
                                                frame, {"of the bottom", "of the lid"});
  EXPECT_EQ(explained[0].reason, "of the bottom");
  EXPECT_EQ(explained[1].reason, "of the lid");
  EXPECT_LT(explained[0].vertex, 4u);
  EXPECT_GE(explained[1].vertex, 4u);
  EXPECT_TRUE(
      measure_boundary_loops(sphere(1).positions, build_connectivity(sphere(1).faces, sphere(1).positions.size()), {})
          .empty());
}

TEST(Compression, CountsTenNumbersPerVertexAndOnePerCorner) {
  CovMesh mesh;
  const Mesh plain = octahedron();
  mesh.faces = plain.faces;
  mesh.vertices.means = plain.positions;
  const Compression report = compression(mesh, 1000);
  EXPECT_EQ(report.numbers_stored, 6u * 10 + 8 * 3);
  EXPECT_EQ(report.numbers_read, 3000u);
  EXPECT_DOUBLE_EQ(report.ratio, 84.0 / 3000);
  EXPECT_EQ(compression(mesh, 0).ratio, 0);
}

}  // namespace
}  // namespace gpsrecon::test
