#include <gmock/gmock.h>
#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/in_frame.h>
#include <gpsrecon/io/io.h>
#include <gpsrecon/pipeline/reconstruct.h>
#include <gtest/gtest.h>

#include <atomic>
#include <limits>

#include "support/meshes.h"
#include "support/shapes.h"
#include "support/temporary_folder.h"

namespace gpsrecon {

using namespace internal;
namespace {

using test::noisy_sphere;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double noise = 0.02;

std::vector<Vec3> world_positions(const Mesh& mesh) {
  std::vector<Vec3> positions;
  for (const Vec3& p : mesh.positions) positions.push_back(mesh.frame.to_world(p));
  return positions;
}

/// What does not depend on the machine and the moment.
std::string json(ErrorReport report) {
  report.run = {};
  return to_json(report);
}

/// The files of a reconstruction and its report.
std::string bytes(const Reconstruction& result) {
  const test::TemporaryFolder folder;
  write_covmesh(result.covmesh, folder / "covmesh.ply");
  write_mesh(result.mesh, folder / "mesh.ply");
  return test::read_bytes(folder / "covmesh.ply") + test::read_bytes(folder / "mesh.ply") + json(result.report);
}

/// All numbers of both meshes in local units; the frame apart.
void expect_same_local_bits(const Reconstruction& a, const Reconstruction& b) {
  EXPECT_EQ(a.covmesh.vertices.means, b.covmesh.vertices.means);
  EXPECT_EQ(a.covmesh.vertices.covariances, b.covmesh.vertices.covariances);
  EXPECT_EQ(a.covmesh.faces, b.covmesh.faces);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.normals, b.mesh.normals);
  EXPECT_EQ(a.mesh.sigma, b.mesh.sigma);
  EXPECT_EQ(a.mesh.faces, b.mesh.faces);
}

/// Mean edge, each side of a face counted once (so edges between two faces count twice).
double mean_edge(const std::vector<Vec3>& positions, const FaceList& faces) {
  double sum = 0;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k) sum += (positions[faces[f][k]] - positions[faces[f][(k + 1) % 3]]).norm();
  return sum / static_cast<double>(faces.corners.size());
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm();
}

/// To the plane if the foot lies inside, else to the nearest side.
double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a).normalized();
  const auto left_of = [&](const Vec3& from, const Vec3& to) { return normal.dot((to - from).cross(p - from)) >= 0; };
  if (left_of(a, b) && left_of(b, c) && left_of(c, a)) return std::abs(normal.dot(p - a));
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

TEST(Reconstruct, TurnsANoisySphereIntoASmoothClosedOne) {
  const Reconstruction result = reconstruct(noisy_sphere(5000, noise));
  const Topology t = topology(result.mesh.faces, result.mesh.positions.size());
  EXPECT_TRUE(t.manifold());
  EXPECT_EQ(t.euler, 2);
  EXPECT_EQ(t.components, 1u);
  EXPECT_EQ(t.boundary_loops, 0u);
  const std::vector<Vec3> positions = world_positions(result.mesh);
  EXPECT_GT(test::volume(result.mesh.faces, positions), 0);
  double sum = 0;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    sum += std::pow(positions[v].norm() - 1, 2);
    EXPECT_GT(result.mesh.normals[v].dot(positions[v].normalized()), 0.9) << v;
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(positions.size())), noise / 2);
}

TEST(Reconstruct, ReportsWhatItReturns) {
  PointCloud cloud = test::scaled(noisy_sphere(700, noise), 3);
  cloud.positions[5] *= 9;
  cloud.positions.push_back(cloud.positions[8]);
  cloud.positions.emplace_back(nan, 0, 0);
  const Reconstruction result = reconstruct(cloud);
  const ErrorReport& report = result.report;
  const PreparedCloud prepared = prepare(cloud);
  EXPECT_EQ(report.command, "reconstruct");

  EXPECT_EQ(report.input->points, cloud.size());
  ASSERT_EQ(report.dropped.size(), 3u);
  for (const DroppedPoints& dropped : report.dropped) EXPECT_EQ(dropped.points, 1u) << dropped.reason;
  std::vector<Vec3> kept;
  for (const Index i : prepared.source) kept.push_back(cloud.positions[i]);
  EXPECT_EQ(kept.size(), 699u);
  EXPECT_NEAR(report.diagonal, bounding_box_diagonal(kept), 1e-12);

  EXPECT_EQ(report.mixture->levels.front(), kept.size());
  EXPECT_EQ(report.mixture->levels.back(), report.mixture->components);
  EXPECT_NEAR(report.mixture->weight, 700, 1e-9);
  EXPECT_EQ(report.covmesh->vertices, result.covmesh.vertices.size());
  EXPECT_EQ(report.covmesh->faces, result.covmesh.faces.size());
  EXPECT_EQ(report.covmesh->boundary_loops.size(),
            topology(result.covmesh.faces, result.covmesh.vertices.size()).boundary_loops);
  EXPECT_EQ(report.covmesh->vertices + report.covmesh->light_components + report.covmesh->leftover_components,
            report.mixture->components + report.covmesh->split_vertices + report.fit->added_vertices);
  EXPECT_GT(report.fit->max_shift, report.fit->mean_shift);

  const Topology t = topology(result.mesh.faces, result.mesh.positions.size());
  EXPECT_EQ(report.mesh->vertices, result.mesh.positions.size());
  EXPECT_EQ(report.mesh->faces, result.mesh.faces.size());
  EXPECT_EQ(report.mesh->faces, result.covmesh.faces.size() << (2 * *report.mesh->level));
  EXPECT_EQ(report.mesh->topology.euler, t.euler);
  EXPECT_EQ(report.mesh->topology.edges, t.edges);
  const std::vector<Vec3> positions = world_positions(result.mesh);
  ASSERT_TRUE(report.mesh->volume.has_value());
  EXPECT_NEAR(*report.mesh->volume, test::volume(result.mesh.faces, positions), 1e-9);

  double sum = 0, farthest = 0, weights = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < result.mesh.faces.size(); ++f) {
      const auto face = result.mesh.faces[f];
      nearest =
          std::min(nearest, distance_to_triangle(kept[i], positions[face[0]], positions[face[1]], positions[face[2]]));
    }
    const double weight = prepared.cloud.weight(i);
    sum += weight * nearest * nearest;
    weights += weight;
    farthest = std::max(farthest, nearest);
  }
  const Statistics& distance = report.points_to_surface->distance;
  EXPECT_EQ(distance.weight, weights);
  EXPECT_NEAR(distance.rms, std::sqrt(sum / weights), 1e-12);
  EXPECT_NEAR(distance.max, farthest, 1e-12);

  EXPECT_EQ(report.compression->numbers_read, 3 * cloud.size());
  EXPECT_EQ(report.compression->numbers_stored, 10 * result.covmesh.vertices.size() + 3 * result.covmesh.faces.size());
}

TEST(Reconstruct, MakesAFlatSheetOfCoplanarPoints) {
  const Vec3 x = Vec3(2, 1, -1).normalized(), y = x.cross(Vec3(0, 1, 3)).normalized(), normal = x.cross(y);
  PointCloud cloud;
  for (const Vec3& p : test::rectangle(2500, 3, 2, 6).points)
    cloud.positions.push_back(p.x() * x + p.y() * y + 4 * normal);
  const Reconstruction result = reconstruct(cloud);
  for (const Vec3& p : world_positions(result.mesh)) EXPECT_NEAR(normal.dot(p), 4, 1e-9 * result.report.diagonal);
  const Topology& t = result.report.mesh->topology;
  EXPECT_TRUE(t.manifold());
  EXPECT_EQ(t.components, 1u);
  EXPECT_EQ(t.boundary_loops, 1u);
  EXPECT_EQ(t.euler, 1);
}

TEST(Reconstruct, OnlyCountsRowsThatAreNotFinite) {
  const PointCloud cloud = noisy_sphere(1500, noise);
  PointCloud dirty = cloud;
  for (const std::size_t at : {std::size_t{0}, std::size_t{700}, dirty.size()})
    dirty.positions.insert(dirty.positions.begin() + static_cast<std::ptrdiff_t>(at), Vec3(0, nan, 0));
  const Reconstruction a = reconstruct(cloud), b = reconstruct(dirty);
  expect_same_local_bits(a, b);
  EXPECT_EQ(a.covmesh.vertices.weights, b.covmesh.vertices.weights);
  EXPECT_EQ(b.report.dropped[0].points, 3u);
  EXPECT_EQ(a.report.points_to_surface->distance.rms, b.report.points_to_surface->distance.rms);
}

// A weight tells mixture reduction how sure a Gaussian is, so the surface may differ, but not its quality.
TEST(Reconstruct, TakesACloudGivenTwice) {
  const PointCloud cloud = noisy_sphere(1500, noise);
  PointCloud twice = cloud;
  twice.positions.insert(twice.positions.end(), cloud.positions.begin(), cloud.positions.end());
  const Reconstruction result = reconstruct(twice);
  EXPECT_EQ(result.report.dropped[1].points, 1500u);
  EXPECT_NEAR(result.report.mixture->weight, 3000, 1e-9);
  EXPECT_EQ(result.report.points_to_surface->distance.count, 1500u);
  EXPECT_EQ(result.report.points_to_surface->distance.weight, 3000);
  EXPECT_EQ(result.report.mesh->topology.euler, 2);
  EXPECT_LT(result.report.points_to_surface->distance.rms, 1.2 * noise);
}

TEST(Reconstruct, FollowsPowersOfTwoToTheBit) {
  const PointCloud cloud = noisy_sphere(1500, noise);
  const Reconstruction one = reconstruct(cloud);
  const test::TemporaryFolder folder;
  write_covmesh(one.covmesh, folder / "one.ply");
  write_mesh(one.mesh, folder / "one_mesh.ply");
  const CovMesh one_read = read_covmesh(folder / "one.ply");
  const Mesh one_mesh = read_mesh(folder / "one_mesh.ply");
  for (const int k : {-12, 9}) {
    const double factor = std::ldexp(1.0, k);
    const Reconstruction other = reconstruct(test::scaled(cloud, factor));
    expect_same_local_bits(one, other);
    EXPECT_EQ(other.covmesh.vertices.frame.exponent, one.covmesh.vertices.frame.exponent + k);
    EXPECT_EQ(other.report.points_to_surface->distance.rms, factor * one.report.points_to_surface->distance.rms);

    write_covmesh(other.covmesh, folder / "other.ply");
    write_mesh(other.mesh, folder / "other_mesh.ply");
    const CovMesh read = read_covmesh(folder / "other.ply");
    EXPECT_EQ(read.vertices.means, one_read.vertices.means);
    EXPECT_EQ(read.vertices.covariances, one_read.vertices.covariances);
    EXPECT_EQ(read.faces, one_read.faces);
    Mesh mesh = read_mesh(folder / "other_mesh.ply");
    for (Vec3& p : mesh.positions) p /= factor;
    EXPECT_EQ(mesh.positions, one_mesh.positions);
  }
}

/// The same surface up to rounding: `map` takes the vertices of one to those of the other, faces included, whatever
/// their order.
template <class Map>
void expect_mapped(const Reconstruction& a, const Reconstruction& b, const Map& map, double tolerance) {
  EXPECT_EQ(a.report.mixture->levels, b.report.mixture->levels);
  const std::vector<Vec3> p = world_positions(a.mesh), q = world_positions(b.mesh);
  ASSERT_EQ(p.size(), q.size());
  double farthest = 0;
  std::vector<Index> same(p.size());
  for (std::size_t v = 0; v < p.size(); ++v) {
    const Vec3 image = map(p[v]);
    const auto nearest = std::min_element(q.begin(), q.end(), [&](const Vec3& x, const Vec3& y) {
      return (x - image).squaredNorm() < (y - image).squaredNorm();
    });
    same[v] = static_cast<Index>(nearest - q.begin());
    farthest = std::max(farthest, (*nearest - image).norm());
  }
  EXPECT_LT(farthest, tolerance);
  EXPECT_EQ(test::canonical(a.mesh.faces, [&](Index v) { return same[v]; }), test::canonical(b.mesh.faces));
}

TEST(Reconstruct, FollowsOtherUnits) {
  const PointCloud cloud = noisy_sphere(1500, noise);
  expect_mapped(
      reconstruct(cloud), reconstruct(test::scaled(cloud, 1000)), [](const Vec3& p) { return Vec3(1000 * p); },
      1e-9 * 1000);
}

// The local input is the same to the bit; coordinates of files are rounded to 2^-30 at 5.4e6.
TEST(Reconstruct, FollowsAFarOrigin) {
  const PointCloud cloud = test::on_grid(noisy_sphere(1500, noise));
  const Vec3 utm(500'000, 5'400'000, 300);
  expect_mapped(
      reconstruct(cloud), reconstruct(test::shifted(cloud, utm)), [&](const Vec3& p) { return Vec3(p + utm); },
      16 * 0x1p-30);
}

TEST(Reconstruct, DoesNotDependOnTheOrderOfThePoints) {
  PointCloud cloud = noisy_sphere(1500, noise);
  for (int i = 0; i < 50; ++i) cloud.positions.push_back(cloud.positions[i]);
  // All but the number of a row.
  const auto bytes_of = [](const PointCloud& points) {
    Reconstruction result = reconstruct(points);
    result.report.points_to_surface->distance.index_of_max = 0;
    return bytes(result);
  };
  const std::string expected = bytes_of(cloud);
  test::Random random(9);
  random.shuffle(cloud.positions);
  EXPECT_TRUE(bytes_of(cloud) == expected);
}

TEST(Reconstruct, DoesNotDependOnThreads) {
  const PointCloud cloud = noisy_sphere(10000, noise);
  RunContext context;
  context.threads = 1;
  const std::string expected = bytes(reconstruct(cloud, {}, context));
  for (const int threads : {2, 4}) {
    context.threads = threads;
    EXPECT_TRUE(bytes(reconstruct(cloud, {}, context)) == expected) << threads;
  }
}

TEST(Reconstruct, IsItsStagesInTurn) {
  const PointCloud cloud = noisy_sphere(1500, noise);
  const ReconstructOptions options;
  const RunContext context;
  const Reconstruction chain = reconstruct(cloud, options, context);

  const test::TemporaryFolder folder;
  const PreparedCloud prepared = prepare(cloud, options.scale, context);
  const Mixture mixture = build_mixture(prepared, options.hem, context).mixture;
  write_mixture(mixture, folder / "mixture.ply");
  CovMesh mesh = triangulate(read_mixture(folder / "mixture.ply"), options.triangulate, context).mesh;
  write_covmesh(mesh, folder / "mesh.ply");
  mesh = fit(read_covmesh(folder / "mesh.ply"), prepared, options.fit, context).mesh;
  write_covmesh(mesh, folder / "fitted.ply");
  Reconstruction steps;
  steps.covmesh = read_covmesh(folder / "fitted.ply");
  steps.mesh = subdivide(steps.covmesh, options.subdivide, context);
  expect_same_local_bits(chain, steps);
  EXPECT_EQ(chain.covmesh.vertices.frame, steps.covmesh.vertices.frame);
  EXPECT_EQ(chain.covmesh.vertices.weights, steps.covmesh.vertices.weights);
  EXPECT_EQ(measure_mesh(steps.mesh).area, chain.report.mesh->area);

  expect_same_local_bits(chain, reconstruct(steps.covmesh));
  ReconstructOptions without_fit;
  without_fit.fit.steps = 0;
  const Reconstruction from_mixture = reconstruct(mixture, options, context);
  expect_same_local_bits(reconstruct(cloud, without_fit, context), from_mixture);
  EXPECT_FALSE(from_mixture.report.fit.has_value());
  EXPECT_FALSE(from_mixture.report.points_to_surface.has_value());
}

// What the program does for --scheme is no more than this.
TEST(Reconstruct, FitsAndRefinesTheSurfaceOfItsRules) {
  const PointCloud cloud = noisy_sphere(3000, 0);
  ReconstructOptions options;
  options.hem.target_components = 60;
  options.fit.refinements = 0;
  const Reconstruction triangles = reconstruct(cloud, options);
  options.triangulate.rules = {.scheme = Scheme::catmull_clark, .corners = CornerRule::sharp};
  const Reconstruction quads = reconstruct(cloud, options);
  EXPECT_EQ(quads.covmesh.rules, options.triangulate.rules);
  EXPECT_TRUE(quads.mesh.faces.all_of_size(4));
  // Fitted as Loop's, its surface of Catmull and Clark would be farther from the points.
  CovMesh reinterpreted = triangles.covmesh;
  reinterpreted.rules = quads.covmesh.rules;
  const auto rms = [&](const CovMesh& mesh) {
    double sum = 0;
    const Mesh surface = subdivide(mesh, {.levels = 2});
    const std::vector<Vec3> positions = world_positions(surface);
    for (const Vec3& p : positions) sum += (p.norm() - 1) * (p.norm() - 1);
    return std::sqrt(sum / static_cast<double>(positions.size()));
  };
  EXPECT_LT(rms(quads.covmesh), 0.9 * rms(reinterpreted));
}

// Both ways to give the points carry them over to the frame of the mesh.
TEST(FitStage, TakesPointsOfAnotherFrame) {
  const PointCloud cloud = noisy_sphere(1500, noise);
  const PreparedCloud prepared = prepare(cloud);
  const CovMesh mesh = triangulate(build_mixture(prepared).mixture).mesh;
  PreparedCloud other = prepared;
  other.cloud = in_frame(prepared.cloud, {Vec3(0.25, -0.5, 1), 3});
  const CovMesh expected = fit(mesh, prepared).mesh;
  for (const CovMesh& moved : {fit(mesh, other).mesh, fit(mesh, other.cloud).mesh})
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      EXPECT_LT((moved.vertices.means[v] - expected.vertices.means[v]).norm(), 1e-12);
}

double kernel_width(const PreparedCloud& cloud, const HemOptions& options, std::size_t expected_warnings) {
  RunRecord record;
  RunContext context;
  context.record = &record;
  const MixtureResult result = build_mixture(cloud, options, context);
  EXPECT_EQ(record.warnings.size(), expected_warnings);
  EXPECT_EQ(result.mixture.sigma0 * result.mixture.frame.scale(), result.kernel.sigma0);
  return result.kernel.sigma0;
}

TEST(MixtureStage, DividesTheWidthByDetailAndClampsIt) {
  const PreparedCloud cloud = prepare(test::scaled(noisy_sphere(1000, noise), 5));
  const double unit = cloud.cloud.frame.scale();
  const auto width = [&](double detail, std::size_t warnings) {
    return kernel_width(cloud, {.detail = detail}, warnings);
  };
  const double automatic = width(1, 0);
  EXPECT_EQ(automatic, cloud.scale.sigma0_local * unit);
  EXPECT_DOUBLE_EQ(width(0.5, 0), 2 * automatic);
  EXPECT_DOUBLE_EQ(width(1.2, 0), automatic / 1.2);
  EXPECT_DOUBLE_EQ(width(2, 1), 0.8 * automatic);
  EXPECT_DOUBLE_EQ(width(100, 1), 0.8 * automatic);
  EXPECT_EQ(kernel_width(cloud, {.initial = InitialCovariance::isotropic}, 0), cloud.scale.sigma0 * unit);
}

TEST(MixtureStage, TakesWidthAndSpacingInAnyUnit) {
  const PreparedCloud cloud = prepare(test::scaled(noisy_sphere(1000, noise), 5));
  const double unit = cloud.cloud.frame.scale();
  const auto width = [&](const Length& sigma0) { return kernel_width(cloud, {.sigma0 = sigma0}, 0); };
  EXPECT_DOUBLE_EQ(width(Length::of_diagonal(0.01)), 0.01 * cloud.diagonal * unit);
  EXPECT_DOUBLE_EQ(width(Length::spacings(1.5)), 1.5 * cloud.scale.spacing * unit);
  EXPECT_DOUBLE_EQ(width(Length::scene(0.3)), 0.3);
  EXPECT_DOUBLE_EQ(build_mixture(cloud, {.spacing = Length::scene(0.25)}).mixture.spacing * unit, 0.25);
}

TEST(Reconstruct, RefinesAsSubdivideOptionsSay) {
  const PointCloud cloud = test::scaled(noisy_sphere(1000, noise), 5);
  ReconstructOptions options;
  options.subdivide.levels = 0;
  const Reconstruction coarse = reconstruct(cloud, options);
  EXPECT_EQ(coarse.mesh.faces.size(), coarse.covmesh.faces.size());
  EXPECT_EQ(coarse.report.mesh->level, 0);
  // A share of the diagonal and the same in scene units.
  options.subdivide.levels.reset();
  options.subdivide.tolerance = Length::of_diagonal(0.001);
  const Reconstruction relative = reconstruct(cloud, options);
  options.subdivide.tolerance = Length::scene(0.001 * relative.report.diagonal);
  EXPECT_EQ(bytes(relative), bytes(reconstruct(cloud, options)));
  options.subdivide.tolerance = Length::scene(0.002 * relative.report.diagonal);
  EXPECT_LT(reconstruct(cloud, options).mesh.faces.size(), relative.mesh.faces.size());
}

// Library callers get what the program gets.
TEST(Reconstruct, CollectsWarningsAndTimes) {
  ReconstructOptions options;
  options.hem.detail = 3;
  const PointCloud cloud = noisy_sphere(1000, noise);
  const Reconstruction result = reconstruct(cloud, options);
  ASSERT_EQ(result.report.warnings.size(), 1U);
  EXPECT_THAT(result.report.warnings[0], testing::HasSubstr("detail"));
  std::vector<std::string> stages;
  for (const StageTime& stage : result.report.run.stages) stages.push_back(stage.name);
  EXPECT_THAT(stages, testing::ElementsAre("prepare", "scale", "mixture", "triangulate", "fit", "subdivide", "report"));
  EXPECT_GT(result.report.run.wall_s, 0);
  EXPECT_FALSE(result.report.versions.empty());
  RunRecord record;
  RunContext context;
  context.record = &record;
  reconstruct(cloud, options, context);
  EXPECT_EQ(record.warnings, result.report.warnings);
  EXPECT_EQ(record.times.stages().size(), stages.size());
}

TEST(Reconstruct, IndicesAreRowsOfTheInput) {
  PointCloud cloud = noisy_sphere(2000, 0.001);
  cloud.positions.insert(cloud.positions.begin() + 70, Vec3(nan, 0, 0));
  cloud.positions[333] *= 1.03;
  const DistanceMeasures distances = *reconstruct(cloud).report.points_to_surface;
  EXPECT_EQ(distances.distance.index_of_max, 333U);
  EXPECT_LT((distances.max_at - cloud.positions[333]).norm(), 1e-12);
}

TEST(Reconstruct, RefusesAWidthBesideDetail) {
  ReconstructOptions options;
  options.hem.sigma0 = Length::spacings(2);
  options.hem.detail = 1.5;
  EXPECT_THROW(reconstruct(noisy_sphere(100, noise), options), OptionError);
}

TEST(SubdivideStage, RefinesUntilEdgesAreAboutASpacing) {
  const PointCloud cloud = noisy_sphere(6000, noise);
  std::vector<int> levels;
  for (const double detail : {1.0, 0.4, 0.15}) {
    ReconstructOptions options;
    options.hem.detail = detail;
    const Reconstruction result = reconstruct(cloud, options);
    const int level = *result.report.mesh->level;
    levels.push_back(level);
    const double target = 1.5 * result.covmesh.vertices.spacing;
    const double edge = mean_edge(result.covmesh.vertices.means, result.covmesh.faces);
    if (level < 3) {
      EXPECT_LE(mean_edge(result.mesh.positions, result.mesh.faces), 1.02 * target) << detail;
    }
    if (level > 0) {
      EXPECT_GT(std::ldexp(edge, 1 - level), 0.98 * target) << detail;
    }
    EXPECT_LE(level, 3);
  }
  EXPECT_LT(levels.front(), levels.back());
  ReconstructOptions options;
  options.subdivide.levels = 1;
  EXPECT_EQ(reconstruct(cloud, options).report.mesh->level, 1);
}

TEST(Reconstruct, KeepsTwoSpheresApart) {
  test::SampledShape a = test::random_sphere(2500, 1, 1, {-1.5, 0, 0}),
                     b = test::random_sphere(2500, 2, 1, {1.5, 0, 0});
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  const Reconstruction result = reconstruct(a.cloud());
  const Topology& t = result.report.mesh->topology;
  EXPECT_EQ(t.components, 2u);
  EXPECT_EQ(t.euler, 4);
  EXPECT_EQ(t.boundary_edges, 0u);
  // Both outward: the volumes add up.
  EXPECT_NEAR(*result.report.mesh->volume, 2 * 4 * std::numbers::pi / 3, 0.2);
}

TEST(Reconstruct, TurnsAnOpenSheetToTheSensor) {
  // Far from the origin and in large units, so that the sensor must be taken from world coordinates.
  const PointCloud cloud =
      test::shifted(test::scaled(test::rectangle(2000, 2, 2, 4).cloud(), 100), Vec3(3000, -2000, 500));
  for (const double side : {-1.0, 1.0}) {
    ReconstructOptions options;
    options.triangulate.sensor = Vec3(3000, -2000, 500 + side * 80);
    const Reconstruction result = reconstruct(cloud, options);
    for (const Vec3& normal : result.mesh.normals) EXPECT_GT(side * normal.z(), 0.999);
  }
}

TEST(Reconstruct, TurnsAnOpenSheetToWherePointsWereSeenFromOrTheirNormalsPoint) {
  const Vec3 shift(3000, -2000, 500);
  const PointCloud sheet = test::shifted(test::scaled(test::rectangle(2000, 2, 2, 4).cloud(), 100), shift);
  const auto side_of = [](const PointCloud& cloud, const ReconstructOptions& options) {
    const Reconstruction result = reconstruct(cloud, options);
    EXPECT_EQ(result.report.covmesh->boundary_loops.size(), 1u);
    EXPECT_EQ(result.report.covmesh->boundary_loops[0].reason, "rim");
    return result.mesh.normals.front().z();
  };
  for (const int fit_steps : {0, 2})
    for (const double side : {-1.0, 1.0}) {
      ReconstructOptions options;
      options.fit.steps = fit_steps;
      PointCloud cloud = sheet;
      cloud.normals.assign(cloud.size(), Vec3(0.1, 0, -side));
      for (std::size_t i = 0; i < cloud.size(); i += 3) cloud.normals[i].z() *= -1;  // a third of them is wrong
      EXPECT_GT(-side * side_of(cloud, options), 0.999);
      cloud.sensors.assign(cloud.size(), shift + Vec3(50, 0, 80 * side));  // has precedence over normals
      EXPECT_GT(side * side_of(cloud, options), 0.999);
      options.triangulate.sensor = shift - Vec3(0, 0, 80 * side);  // and this over both
      EXPECT_GT(-side * side_of(cloud, options), 0.999);
    }
}

TEST(Reconstruct, NormalsDoNotTurnAClosedSurface) {
  PointCloud cloud = noisy_sphere(3000, 0);
  for (const Vec3& p : cloud.positions) cloud.normals.push_back(-p);
  EXPECT_GT(*reconstruct(cloud).report.mesh->volume, 0);
}

TEST(Reconstruct, CountsSelfIntersectionsOnRequest) {
  ReconstructOptions options;
  const PointCloud cloud = noisy_sphere(3000, noise);
  const Reconstruction plain = reconstruct(cloud, options);
  EXPECT_FALSE(plain.report.covmesh->self_intersecting_faces);
  EXPECT_FALSE(plain.report.mesh->self_intersecting_faces);
  options.self_intersections = true;
  const Reconstruction counted = reconstruct(cloud, options);
  EXPECT_EQ(counted.report.covmesh->self_intersecting_faces, 0u);
  EXPECT_EQ(counted.report.mesh->self_intersecting_faces, 0u);
  EXPECT_EQ(counted.mesh.positions, plain.mesh.positions);
}

TEST(Reconstruct, LoopsKeepTheirReasonsThroughTheFit) {
  // A hemisphere with a hole at its pole: a rim and a gap, which the fit moves differently.
  PointCloud cloud = noisy_sphere(8000, 0.005);
  std::erase_if(cloud.positions, [](const Vec3& p) { return p.z() < 0.3 || p.z() > 0.9; });
  for (const int fit_steps : {0, 5}) {
    ReconstructOptions options;
    options.fit.steps = fit_steps;
    const auto loops = reconstruct(cloud, options).report.covmesh->boundary_loops;
    ASSERT_EQ(loops.size(), 2u);
    EXPECT_EQ(loops[0].reason, "rim");
    EXPECT_NEAR(loops[0].center.z(), 0.3, 0.1);
    EXPECT_EQ(loops[1].reason, "no_points");
    EXPECT_NEAR(loops[1].center.z(), 0.9, 0.1);
  }
}

TEST(Reconstruct, RefusesOptionsOutOfRange) {
  const auto message = [](const auto& set) -> std::string {
    ReconstructOptions options;
    set(options);
    try {
      reconstruct(noisy_sphere(10, 0), options);
    } catch (const OptionError& error) {
      return error.what();
    }
    return "";
  };
  using testing::HasSubstr;
  using O = ReconstructOptions;
  for (const double detail : {0.0, -1.0, 101.0, nan})
    EXPECT_THAT(message([&](O& o) { o.hem.detail = detail; }), HasSubstr("detail")) << detail;
  for (const double width : {-0.1, std::numeric_limits<double>::infinity(), nan})
    EXPECT_THAT(message([&](O& o) { o.hem.sigma0 = Length::of_diagonal(width); }), HasSubstr("sigma0")) << width;
  for (const int levels : {-2, 9})
    EXPECT_THAT(message([&](O& o) { o.subdivide.levels = levels; }), HasSubstr("levels")) << levels;
  EXPECT_THAT(message([](O& o) { o.triangulate.sensor = Vec3(0, nan, 0); }), HasSubstr("sensor"));
  EXPECT_THAT(message([](O& o) { o.fit.steps = -1; }), HasSubstr("steps"));
  EXPECT_THAT(message([](O& o) { o.scale.isolation = 0.5; }), HasSubstr("isolation"));
  EXPECT_THAT(message([](O& o) { o.hem.alpha = 0; }), HasSubstr("alpha"));
  EXPECT_THAT(message([](O& o) { o.triangulate.min_overlap = 2; }), HasSubstr("min-overlap"));
}

TEST(Reconstruct, StopsWhenCancelled) {
  const std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  EXPECT_THROW(reconstruct(noisy_sphere(500, noise), {}, context), Cancelled);
}

}  // namespace
}  // namespace gpsrecon
