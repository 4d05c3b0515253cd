#include <gmock/gmock.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/hem/hem.h>
#include <gpsrecon/triangulate/triangulate.h>

#include "support/connectivity.h"
#include "support/meshes.h"
#include "support/shapes.h"

namespace gpsrecon {
namespace {

using test::canonical;
using test::part;
using test::Random;
using test::SampledShape;
using test::tangent_discs;
using testing::HasSubstr;
using testing::ThrowsMessage;

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

Topology topology(const CovMesh& mesh) {
  return topology(mesh.faces, mesh.vertices.size());
}

/// What holds for every triangulation of every mixture.
void expect_sound(const Mixture& mixture, const Triangulation& result) {
  const CovMesh& mesh = result.mesh;
  ASSERT_NO_THROW(validate(mesh));
  test::expect_connectivity(result.connectivity, mesh.faces, mesh.vertices.size());
  const Topology t = topology(mesh);
  EXPECT_EQ(t.unused_vertices, 0U);
  EXPECT_TRUE(topology(test::welded(mesh.faces, mesh.vertices.means), mesh.vertices.size()).manifold());

  const double total = sum(mixture.weights);
  double weight = result.light_weight + result.leftover_weight + result.dropped_component_weight;
  for (Index v = 0; v < mesh.vertices.size(); ++v)  // of what stands for points
    if (result.component_of_vertex[v] != no_index) weight += mesh.vertices.weights[v];
  EXPECT_NEAR(weight, total, 1e-12 * total);

  ASSERT_EQ(result.component_of_vertex.size(), mesh.vertices.size());
  std::map<Index, std::size_t> copies;
  for (Index v = 0; v < mesh.vertices.size(); ++v) {
    const Index s = result.component_of_vertex[v];
    if (s == no_index) continue;
    EXPECT_EQ(mesh.vertices.covariances[v], mixture.covariances[s]);
    ++copies[s];
  }
  std::size_t made = 0;  // to fill holes
  for (const Index s : result.component_of_vertex) made += s == no_index ? 1 : 0;
  EXPECT_GE(made, result.filled_vertices);
  EXPECT_EQ(result.loop_reasons.size(), t.boundary_loops);
  EXPECT_EQ(mesh.vertices.size() - made - copies.size(), result.split_vertices);
  const std::size_t unused = result.light_components + result.leftover_components;
  EXPECT_LE(copies.size() + unused, mixture.size());
  if (result.dropped_components == 0) {
    EXPECT_EQ(copies.size() + unused, mixture.size());
  }
  for (Index v = 0; v < mesh.vertices.size(); ++v)
    if (const Index s = result.component_of_vertex[v]; s != no_index) {
      EXPECT_EQ(mesh.vertices.weights[v], mixture.weights[s] / static_cast<double>(copies[s]));
    }
}

/// Closed, in one piece, of the given Euler number, with every Gaussian a vertex, outward.
void expect_closed(const Mixture& mixture, const Triangulation& result, long euler) {
  expect_sound(mixture, result);
  const Topology t = topology(result.mesh);
  EXPECT_EQ(t.vertices, mixture.size());
  EXPECT_EQ(t.faces, static_cast<std::size_t>(2 * (static_cast<long>(mixture.size()) - euler)));
  EXPECT_EQ(t.euler, euler);
  EXPECT_EQ(t.components, 1U);
  EXPECT_EQ(t.boundary_loops, 0U);
  EXPECT_EQ(result.leftover_components, 0U);
  EXPECT_EQ(result.split_vertices, 0U);
  EXPECT_GT(test::volume(result.mesh.faces, result.mesh.vertices.means), 0);
}

TEST(Triangulate, FibonacciSphere) {
  for (const std::size_t n : {100, 500, 2000})
    for (const double along : {0.45, 0.6, 0.8}) {
      SCOPED_TRACE(testing::Message() << n << " Gaussians, " << along << " spacings wide");
      const Mixture mixture = tangent_discs(test::fibonacci_sphere(n), along);
      const Triangulation result = triangulate(mixture);
      expect_closed(mixture, result, 2);
      for (std::size_t f = 0; f < result.mesh.faces.size(); ++f) {
        const Vec3 normal = test::area_vector(result.mesh.faces, f, mixture.means).normalized();
        // Within the angle that three neighbours see of each other.
        EXPECT_GT(normal.dot(mixture.means[result.mesh.faces[f][0]]), std::cos(3 * mixture.spacing));
      }
    }
}

TEST(Triangulate, VolumeOfTheSphereConverges) {
  // An inscribed polyhedron of triangles of one shape lacks a volume in proportion to 1/n; here shapes vary a little.
  std::vector<double> missing;
  for (const std::size_t n : {250, 1000, 4000}) {
    const CovMesh mesh = triangulate(tangent_discs(test::fibonacci_sphere(n))).mesh;
    missing.push_back(4 * std::numbers::pi / 3 - test::volume(mesh.faces, mesh.vertices.means));
  }
  EXPECT_NEAR(missing[0] / missing[1], 4, 0.4);
  EXPECT_NEAR(missing[1] / missing[2], 4, 0.4);
}

TEST(Triangulate, Torus) {
  for (const std::size_t n : {987, 2584}) {
    SCOPED_TRACE(n);
    const Mixture mixture = tangent_discs(test::torus(n, 1, 0.4));
    expect_closed(mixture, triangulate(mixture), 0);
  }
}

/// Preiner et al. 2019, Fig. 8b: flat Gaussians on the two large faces of a plate that is thinner than they are apart,
/// and a row of Gaussians around its rim.
struct ThinPlate {
  Mixture mixture;
  std::vector<int> side;  ///< per component: +1 upper, -1 lower face, 0 rim

  ThinPlate(int count, double thickness, double jitter, std::uint64_t seed) {
    Random random(seed, test::sampling);
    const auto add = [&](const Vec3& mean, const Sym3& covariance, int s) {
      mixture.means.push_back(mean);
      mixture.covariances.push_back(covariance);
      mixture.weights.push_back(1);
      side.push_back(s);
    };
    const double flat = 0.1 * thickness, half = 0.5 * count;
    for (const int s : {1, -1})
      for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) {
          const double x = i + 0.5 - half + random.uniform(-jitter, jitter);
          const double y = j + 0.5 - half + random.uniform(-jitter, jitter);
          add({x, y, 0.5 * s * thickness}, Sym3::diagonal(0.3, 0.3, flat * flat), s);
        }
    // The rim is as far out as the plate is thick: an angle of 53 degrees there.
    const double across = 0.35 * thickness, rim = half - 0.5 + thickness;
    for (int j = 0; j < count; ++j)
      for (const double s : {-1.0, 1.0}) {
        const double t = j + 0.5 - half;
        add({s * rim, t, 0}, Sym3::diagonal(0.02, 0.3, across * across), 0);
        add({t, s * rim, 0}, Sym3::diagonal(0.3, 0.02, across * across), 0);
      }
  }
};

TEST(Triangulate, ThinPlateDoesNotBridgeItsFaces) {
  for (const double thickness : {0.25, 0.4, 0.7})
    for (const double jitter : {0.0, 0.1}) {
      SCOPED_TRACE(testing::Message() << "thickness " << thickness << ", jitter " << jitter);
      const ThinPlate plate(12, thickness, jitter, 51);
      const Triangulation result = triangulate(plate.mixture);
      expect_closed(plate.mixture, result, 2);
      const FaceList& faces = result.mesh.faces;
      for (std::size_t f = 0; f < faces.size(); ++f)
        for (std::size_t k = 0; k < 3; ++k) {
          const Index a = result.component_of_vertex[faces[f][k]];
          const Index b = result.component_of_vertex[faces[f][(k + 1) % 3]];
          EXPECT_NE(plate.side[a] * plate.side[b], -1);
        }
    }
}

void expect_disc(const Mixture& mixture, const Triangulation& result) {
  expect_sound(mixture, result);
  const Topology t = topology(result.mesh);
  EXPECT_EQ(t.euler, 1);
  EXPECT_EQ(t.components, 1U);
  EXPECT_EQ(t.boundary_loops, 1U);
}

TEST(Triangulate, CapsKeepTheirBoundary) {
  const SampledShape sphere = test::fibonacci_sphere(1000);
  for (const double height : {-0.9, -0.5, 0.0, 0.5, 0.9}) {
    SCOPED_TRACE(height);
    const SampledShape cap = part(sphere, [=](const Vec3& p) { return p.z() > height; });
    const Mixture mixture = tangent_discs(cap, 0.5);
    const Triangulation result = triangulate(mixture);
    if (height < -0.8) {
      // The opening is about as wide as the overlap reaches: closed or not, it is one piece without other holes.
      expect_sound(mixture, result);
      EXPECT_LE(topology(result.mesh).boundary_loops, 1U);
      continue;
    }
    expect_disc(mixture, result);
    for (const std::size_t f : {std::size_t{0}, result.mesh.faces.size() / 2})
      EXPECT_GT(test::area_vector(result.mesh.faces, f, mixture.means).dot(mixture.means[result.mesh.faces[f][0]]), 0);
  }
}

TEST(Triangulate, SmallFlatPatchesKeepTheirBoundary) {
  // Hexagonal patches of 7, 19, 37 and 61 Gaussians have boundaries of 6 to 24 edges, as short as a pinhole's.
  for (int rings = 1; rings <= 4; ++rings) {
    SampledShape patch;
    for (int i = -rings; i <= rings; ++i)
      for (int j = -rings; j <= rings; ++j)
        if (std::abs(i + j) <= rings) patch.points.emplace_back(i + 0.5 * j, std::sqrt(0.75) * j, 0);
    patch.normals.assign(patch.points.size(), Vec3::UnitZ());
    patch.area = std::sqrt(0.75) * static_cast<double>(patch.points.size());
    const Mixture mixture = tangent_discs(patch, 0.5);
    const Triangulation result = triangulate(mixture);
    expect_disc(mixture, result);
    EXPECT_EQ(topology(result.mesh).boundary_edges, static_cast<std::size_t>(6 * rings));
    EXPECT_EQ(result.mesh.faces.size(), static_cast<std::size_t>(6 * rings * rings));
  }
}

TEST(Triangulate, AHoleWithoutEvidenceStaysOpen) {
  // Discs of 0.4 spacings reach 4.2 spacings at the overlap of BCmin³ that pinholes may have. Whatever closes a round
  // hole of radius 3 has a side of at least 3√3 = 5.2.
  const SampledShape sphere = test::fibonacci_sphere(2000);
  const double radius = 3 * sphere.spacing();
  const SampledShape holed = part(sphere, [&](const Vec3& p) { return (p - sphere.points[900]).norm() > radius; });
  const Mixture mixture = tangent_discs(holed, 0.4);
  TriangulateOptions options;
  options.max_pinhole_edges = 60;
  expect_disc(mixture, triangulate(mixture, options));
}

TEST(Triangulate, SeparateAndNestedSpheres) {
  for (const double distance : {3.0, 0.0}) {
    SCOPED_TRACE(distance > 0 ? "side by side" : "nested");
    const Mixture mixture = test::joined(tangent_discs(test::fibonacci_sphere(2000)),
                                         tangent_discs(test::fibonacci_sphere(500, 0.5, Vec3(distance, 0, 0))));
    const Triangulation result = triangulate(mixture);
    expect_sound(mixture, result);
    const Topology t = topology(result.mesh);
    EXPECT_EQ(t.components, 2U);
    EXPECT_EQ(t.euler, 4);
    EXPECT_EQ(t.boundary_loops, 0U);
    EXPECT_EQ(t.vertices, 2500U);
    // Both face away from the solid: the inner one of two bounds a cavity.
    for (std::size_t f = 0; f < result.mesh.faces.size(); ++f) {
      const Index v = result.component_of_vertex[result.mesh.faces[f][0]];
      const Vec3 center = v < 2000 ? Vec3::Zero() : Vec3(distance, 0, 0);
      const double out = v >= 2000 && distance == 0 ? -1 : 1;
      EXPECT_GT(out * test::area_vector(result.mesh.faces, f, mixture.means).dot(mixture.means[v] - center), 0);
    }
  }
}

TEST(Triangulate, SmallComponentsAndFarGaussiansAreCounted) {
  const Mixture sphere = tangent_discs(test::fibonacci_sphere(2000));
  const Mixture small = tangent_discs(test::fibonacci_sphere(12, 0.1, Vec3(3, 0, 0)));
  Mixture lone;
  lone.means = {Vec3(0, 9, 0), Vec3(0, -9, 0)};
  lone.covariances.assign(2, Sym3::identity(1e-3));
  lone.weights = {0.25, 0.5};
  const Mixture mixture = test::joined(test::joined(sphere, small), lone);
  const Triangulation result = triangulate(mixture, {.min_component_share = 0.007});  // 14 of 2012.75
  expect_sound(mixture, result);
  EXPECT_EQ(topology(result.mesh).components, 1U);
  EXPECT_EQ(result.mesh.vertices.size(), 2000U);
  EXPECT_EQ(result.dropped_components, 1U);
  EXPECT_EQ(result.dropped_component_weight, 12.0);
  EXPECT_EQ(result.leftover_components, 2U);
  EXPECT_EQ(result.leftover_weight, 0.75);
  const Triangulation all = triangulate(mixture, {.min_component_share = 0});
  expect_sound(mixture, all);
  EXPECT_EQ(all.dropped_components, 0U);
  EXPECT_EQ(topology(all.mesh).components, 2U);
}

TEST(Triangulate, OpenSheetsFaceTheSensor) {
  SampledShape sheet = test::rectangle(0, 1, 1, 0);
  Random random(52, test::sampling);
  for (int i = 0; i < 15; ++i)
    for (int j = 0; j < 15; ++j)
      sheet.points.emplace_back(i + random.uniform(-0.2, 0.2), j + random.uniform(-0.2, 0.2),
                                random.uniform(-0.1, 0.1));
  sheet.normals.assign(sheet.points.size(), Vec3::UnitZ());
  sheet.area = 225;
  const Mixture mixture = tangent_discs(sheet, 0.6, 0.15);
  for (const double side : {1.0, -1.0}) {
    const Triangulation result = triangulate(mixture, {.sensor = Vec3(7, 7, 20 * side)});
    expect_disc(mixture, result);
    for (std::size_t f = 0; f < result.mesh.faces.size(); ++f)
      EXPECT_GT(test::area_vector(result.mesh.faces, f, result.mesh.vertices.means).z() * side, 0);
  }
}

TEST(Triangulate, MixturesOfNoisyScansAreSound) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    for (const double noise : {0.0, 0.5, 2.0}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", noise " << noise);
      SampledShape shape = seed % 2 == 1 ? test::random_sphere(4000, seed)
                                         : test::box(4000, Vec3(0.6, 0.4, 0.02 * static_cast<double>(seed)), seed);
      add_noise(shape, noise * shape.spacing(), seed + 100);
      const Mixture mixture = build_mixture(shape.cloud(), {.flat_levels = 0, .initial = InitialCovariance::isotropic});
      expect_sound(mixture, triangulate(mixture));
    }
}

TEST(Triangulate, KernelsTooSmallForASheetAreSound) {
  // Far too small a kernel leaves a thick cloud of Gaussians: everything overlaps everything around it.
  std::size_t dropped = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    SampledShape shape = test::random_sphere(3000, seed);
    add_noise(shape, 2 * shape.spacing(), seed + 200);
    const Mixture mixture = build_mixture(
        shape.cloud(),
        {.sigma0 = Length::scene(0.6 * shape.spacing()), .flat_levels = 0, .initial = InitialCovariance::isotropic});
    const Triangulation result = triangulate(mixture);
    expect_sound(mixture, result);
    dropped += result.dropped_components;
  }
  EXPECT_GT(dropped, 0U);
}

TEST(Triangulate, RandomGaussiansAreSound) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(1000 + seed, test::sampling);
    Mixture mixture;
    const std::size_t n = 4 + random.below(60);
    for (std::size_t i = 0; i < n; ++i) {
      mixture.means.push_back(random.vector(0, 1));
      mixture.covariances.push_back(
          test::disc_covariance(random.direction(), random.uniform(0.1, 0.4), random.uniform(0.02, 0.3)));
      mixture.weights.push_back(random.uniform(0.1, 5));
    }
    const TriangulateOptions options{.min_overlap = random.uniform() < 0.5 ? 0.01 : 1e-4,
                                     .min_dihedral = random.uniform() < 0.5 ? 0 : 28.6,
                                     .min_component_share = random.uniform(0, 0.2)};
    try {
      expect_sound(mixture, triangulate(mixture, options));
    } catch (const NoSurfaceError&) {
    }
    if (HasFailure()) return;
  }
}

TEST(Triangulate, TinyIntegerGridsAreSound) {
  // Means on a tiny grid and few kinds of covariances: coplanar, collinear and cospherical points, equal grades and
  // flat triangles are the rule here.
  std::size_t surfaces = 0, split = 0, dropped = 0, closed = 0;
  for (std::uint64_t seed = 1; seed <= 1500; ++seed) {
    SCOPED_TRACE(seed);
    Random random(5000 + seed, test::sampling);
    const std::array<std::size_t, 3> cells{2 + random.below(4), 2 + random.below(4), 1 + random.below(4)};
    const double fill = random.uniform(0.3, 1);
    const std::size_t kinds = 1 + random.below(4);
    Mixture mixture;
    for (std::size_t x = 0; x < cells[0]; ++x)
      for (std::size_t y = 0; y < cells[1]; ++y)
        for (std::size_t z = 0; z < cells[2]; ++z) {
          if (random.uniform() > fill) continue;
          mixture.means.emplace_back(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
          const std::size_t kind = random.below(kinds);
          mixture.covariances.push_back(kind == 0   ? Sym3::diagonal(0.25, 0.25, 0.01)
                                        : kind == 1 ? Sym3::diagonal(0.25, 0.25, 0.25)
                                        : kind == 2 ? Sym3::diagonal(0.01, 0.25, 0.25)
                                                    : Sym3::diagonal(0.01, 1, 0.01));
          mixture.weights.push_back(static_cast<double>(1 + random.below(9)));
        }
    const TriangulateOptions options{.min_dihedral = seed % 3 == 0 ? 0 : 28.6,
                                     .min_component_share = seed % 2 == 0 ? 0 : 0.2};
    try {
      const Triangulation result = triangulate(mixture, options);
      ++surfaces;
      expect_sound(mixture, result);
      split += result.split_vertices, dropped += result.dropped_components, closed += result.closed_pinholes;
    } catch (const NoSurfaceError&) {
    }
    if (HasFailure()) return;
  }
  // Otherwise this would not test what it is for.
  EXPECT_GT(surfaces, 1000U);
  EXPECT_GT(split, 20U);
  EXPECT_GT(dropped, 20U);
  EXPECT_GT(closed, 20U);
}

/// Gaussians on a sphere in general position.
Mixture irregular_sphere(std::size_t n, std::uint64_t seed) {
  SampledShape shape = test::fibonacci_sphere(n);
  Random random(seed, test::sampling);
  for (std::size_t i = 0; i < n; ++i) {
    shape.normals[i] = (shape.normals[i] + 0.2 * shape.spacing() * random.normal3()).normalized();
    shape.points[i] = shape.normals[i];
  }
  return tangent_discs(shape);
}

TEST(Triangulate, UnitsDoNotMatter) {
  const Mixture mixture = irregular_sphere(1000, 53);
  const auto reference = canonical(triangulate(mixture).mesh.faces);
  for (const double factor : {std::ldexp(1.0, -20), 1000.0, 3e-7}) {
    Mixture scaled = mixture;
    for (Vec3& mean : scaled.means) mean *= factor;
    for (Sym3& covariance : scaled.covariances) covariance *= factor * factor;
    EXPECT_EQ(canonical(triangulate(scaled).mesh.faces), reference) << factor;
  }
}

TEST(Triangulate, PositionAndDirectionDoNotMatter) {
  const Mixture mixture = irregular_sphere(1000, 54);
  const auto reference = canonical(triangulate(mixture).mesh.faces);
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(2, -1, 3).normalized()).toRotationMatrix();
  Mixture moved = mixture;
  for (Vec3& mean : moved.means) mean = turn * mean + Vec3(1, 2, -3);
  for (Sym3& covariance : moved.covariances) covariance = congruence(turn, covariance);
  EXPECT_EQ(canonical(triangulate(moved).mesh.faces), reference);
}

TEST(Triangulate, OrderOfTheComponentsDoesNotMatter) {
  const Mixture mixture = irregular_sphere(1000, 55);
  const auto reference = canonical(triangulate(mixture).mesh.faces);
  std::vector<Index> order(mixture.size());
  std::iota(order.begin(), order.end(), Index{0});
  Random(56, test::sampling).shuffle(order);
  const Triangulation shuffled = triangulate(select(mixture, order));
  EXPECT_EQ(canonical(shuffled.mesh.faces, [&](Index v) { return order[v]; }), reference);
}

TEST(Triangulate, SameForAnyNumberOfThreads) {
  SampledShape shape = test::random_sphere(10000, 57);
  add_noise(shape, shape.spacing(), 58);
  const Mixture mixture = build_mixture(shape.cloud(), {.flat_levels = 0, .initial = InitialCovariance::isotropic});
  RunContext context;
  context.threads = 1;
  const Triangulation reference = triangulate(mixture, {}, context);
  for (const int threads : {2, 4}) {
    context.threads = threads;
    const Triangulation result = triangulate(mixture, {}, context);
    EXPECT_EQ(result.mesh.faces, reference.mesh.faces);
    EXPECT_EQ(result.mesh.vertices.means, reference.mesh.vertices.means);
    EXPECT_EQ(result.mesh.vertices.weights, reference.mesh.vertices.weights);
  }
}

TEST(Triangulate, NothingOverlaps) {
  const auto refuses = [](const Mixture& mixture) {
    EXPECT_THAT([&] { triangulate(mixture); }, ThrowsMessage<NoSurfaceError>(HasSubstr("overlap")));
  };
  refuses({});
  Mixture far = tangent_discs(test::fibonacci_sphere(100), 0.05);
  refuses(far);
  Mixture few;
  for (int i = 0; i < 2; ++i) {
    few.means.emplace_back(0.1 * i, 0, 0);
    few.covariances.push_back(Sym3::identity());
    few.weights.push_back(1);
    refuses(few);
  }
  for (int i = 2; i < 20; ++i) {  // on a line all triangles are flat
    few.means.emplace_back(0.125 * i, 0, 0);
    few.covariances.push_back(Sym3::identity());
    few.weights.push_back(1);
  }
  few.means[1].x() = 0.125;
  refuses(few);
}

TEST(Triangulate, OneTriangle) {
  Mixture three;
  three.means = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  three.covariances.assign(3, Sym3::diagonal(0.3, 0.3, 0.01));
  three.weights = {1, 2, 3};
  const Triangulation result = triangulate(three);
  expect_sound(three, result);
  EXPECT_EQ(result.mesh.faces.size(), 1U);
}

TEST(Triangulate, SnapshotsShowTheGrowingSurface) {
  const Mixture mixture = tangent_discs(test::fibonacci_sphere(5000));
  std::vector<FaceList> shots;
  std::vector<std::size_t> steps;
  TriangulateOptions options;
  options.on_snapshot = [&](std::size_t step, const FaceList& faces) {
    steps.push_back(step);
    shots.push_back(faces);
  };
  const auto reference = canonical(triangulate(mixture, options).mesh.faces);
  ASSERT_GE(shots.size(), 2U);
  EXPECT_TRUE(std::is_sorted(steps.begin(), steps.end()));
  for (const FaceList& shot : shots) {
    const Topology t = topology(shot, mixture.size());
    EXPECT_EQ(t.nonmanifold_edges + t.inconsistent_edges, 0U);
    EXPECT_LT(shot.size(), reference.size());
  }
  EXPECT_LT(shots.front().size(), shots.back().size());
}

TEST(Triangulate, ProgressAndCancel) {
  const Mixture mixture = tangent_discs(test::fibonacci_sphere(1000));
  RunContext context;
  std::vector<double> shares;
  context.on_progress = [&](std::string_view, double share) { shares.push_back(share); };
  triangulate(mixture, {}, context);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares.back(), 1.0);
  // Asked in the middle of the front, it stops there.
  std::atomic<bool> cancel{false};
  context.cancel = &cancel;
  context.on_progress = [&](std::string_view, double share) { cancel = cancel || share > 0.3; };
  EXPECT_THROW(triangulate(mixture, {}, context), Cancelled);
}

TEST(Triangulate, OptionsOutOfRangeNameTheField) {
  const Mixture mixture = tangent_discs(test::fibonacci_sphere(20));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect = [&](const TriangulateOptions& options, const char* field) {
    EXPECT_THAT([&] { triangulate(mixture, options); }, ThrowsMessage<OptionError>(HasSubstr(field))) << field;
  };
  for (const double bad : {-0.1, 500.0, nan}) {
    expect({.min_overlap = bad}, "min-overlap");
    expect({.min_dihedral = bad}, "min-dihedral");
    expect({.min_component_share = bad}, "min-component");
    expect({.min_weight_share = bad}, "min-weight");
  }
  expect({.min_overlap = 0}, "min-overlap");
  expect({.max_pinhole_edges = -1}, "max-pinhole");
  expect({.holes = HoleRule::fill(Length::of_diagonal(-0.1))}, "holes");
  expect({.holes = HoleRule::fill({})}, "holes");
  expect({.sensor = Vec3(0, nan, 0)}, "sensor");
}

}  // namespace
}  // namespace gpsrecon
