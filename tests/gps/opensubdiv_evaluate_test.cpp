// OpenSubdiv as a second implementation of exact evaluation: limit stencils of its isolated regular patches.

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/io/io.h>
#include <gtest/gtest.h>

#include <opensubdiv/far/stencilTableFactory.h>

#include <map>
#include <memory>

#include "opensubdiv.h"
#include "support/covmeshes.h"
#include "support/data_files.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

/// Irregular vertices are isolated to this depth; farther from them OpenSubdiv is exact.
constexpr int isolation = 10;

/// Largest differences of positions, first and second derivatives, relative to the largest of their kind.
void expect_agreement(const Mesh& mesh, const SurfaceRules& rules, std::size_t patches = 1000) {
  const SurfaceEvaluator ours(with_rules(with_equal_covariances(mesh, Sym3::identity()), rules));
  // No closer to a corner than 1/32.
  const std::vector<std::array<double, 2>> in_patch{{0.03125, 0.03125}, {0.25, 0.25},    {0.375, 0.0625},
                                                    {0.0625, 0.84375},  {0.5625, 0.375}, {0.90625, 0.03125}};
  std::vector<double> s, t;
  for (const auto& p : in_patch) {
    s.push_back(p[0]);
    t.push_back(p[1]);
  }
  using Factory = Far::LimitStencilTableFactoryReal<double>;
  Factory::LocationArrayVec locations;
  std::vector<SurfaceParameter> parameters;
  const std::size_t step = std::max<std::size_t>(1, ours.patch_count() / patches);
  for (std::size_t patch = 0; patch < ours.patch_count(); patch += step) {
    Factory::LocationArray at;
    at.ptexIdx = static_cast<int>(patch);
    at.numLocations = static_cast<int>(s.size());
    at.s = s.data();
    at.t = t.data();
    locations.push_back(at);
    for (std::size_t i = 0; i < s.size(); ++i) parameters.push_back({static_cast<Index>(patch), s[i], t[i]});
  }
  const std::unique_ptr<Far::TopologyRefiner> refiner = osd_refiner(mesh, rules);
  Far::TopologyRefiner::AdaptiveOptions adaptive(isolation);
  adaptive.useInfSharpPatch = true;
  refiner->RefineAdaptive(adaptive);
  Factory::Options stencils;
  stencils.generate1stDerivatives = stencils.generate2ndDerivatives = true;
  const std::unique_ptr<const Far::LimitStencilTableReal<double>> table(
      Factory::Create(*refiner, locations, nullptr, nullptr, stencils));
  ASSERT_EQ(static_cast<std::size_t>(table->GetNumStencils()), parameters.size());

  const std::vector<OsdPoint> control = osd_points(mesh);
  const std::size_t n = parameters.size();
  std::vector<OsdPoint> p(n), u(n), v(n), uu(n), uv(n), vv(n);
  table->UpdateValues(control, p);
  table->UpdateDerivs(control, u, v);
  table->Update2ndDerivs(control, uu, uv, vv);
  const std::vector<SurfacePoint> points = ours.evaluate(parameters);
  // On the patches of faces of other than four corners, OpenSubdiv derives by parameters of twice the size. On
  // triangles that are upside down in their patch the second derivatives of OpenSubdiv 3.5.0 have the sign of the
  // first, which contradicts these. (Central differences of first derivatives, in another test, decide for ours.)
  std::vector<double> factors(n, 1.0);
  if (rules.scheme == Scheme::catmull_clark) {
    for (std::size_t f = 0; f < mesh.faces.size(); ++f)
      if (mesh.faces[f].size() != 4)
        for (std::size_t i = 0; i < n; ++i)
          if (parameters[i].patch >= ours.first_patch(f) &&
              parameters[i].patch < ours.first_patch(f) + ours.patches_of(f))
            factors[i] = 0.25;  // of the second
  } else {
    for (std::size_t i = 0; i < n; ++i)
      if (points[i].uu.dot(uu[i].p) + points[i].uv.dot(uv[i].p) + points[i].vv.dot(vv[i].p) < 0) factors[i] = -1;
  }
  // The weights of both, vertex by vertex.
  const JetTable weights = ours.weights(parameters);
  std::array<double, 6> largest{}, errors{};
  for (std::size_t i = 0; i < n; ++i) {
    const auto theirs = table->GetLimitStencil(static_cast<Far::Index>(i));
    const double second = factors[i], first = std::sqrt(std::abs(second));
    std::map<Index, std::array<double, 6>> difference;
    for (int j = 0; j < theirs.GetSize(); ++j) {
      const std::array<double, 6> w{theirs.GetWeights()[j],
                                    first * theirs.GetDuWeights()[j],
                                    first * theirs.GetDvWeights()[j],
                                    second * theirs.GetDuuWeights()[j],
                                    second * theirs.GetDuvWeights()[j],
                                    second * theirs.GetDvvWeights()[j]};
      std::array<double, 6>& d = difference[static_cast<Index>(theirs.GetVertexIndices()[j])];
      for (std::size_t k = 0; k < 6; ++k) {
        d[k] += w[k];
        largest[k] = std::max(largest[k], std::abs(w[k]));
      }
    }
    const Row<JetWeight> row = weights.row(i);
    for (std::size_t j = 0; j < row.indices.size(); ++j) {
      const JetWeight& w = row.weights[j];
      const std::array<double, 6> own{w.value, w.u, w.v, w.uu, w.uv, w.vv};
      for (std::size_t k = 0; k < 6; ++k) difference[row.indices[j]][k] -= own[k];
    }
    for (const auto& [vertex, d] : difference)
      for (std::size_t k = 0; k < 6; ++k) errors[k] = std::max(errors[k], std::abs(d[k]));
  }
  for (std::size_t k = 0; k < 6; ++k) EXPECT_LT(errors[k], 1e-10 * largest[k]) << "weights of derivative " << k;
  for (std::size_t i = 0; i < n; ++i)
    for (OsdPoint* second : {&uu[i], &uv[i], &vv[i]}) second->p *= factors[i];
  for (std::size_t i = 0; i < n; ++i)
    for (OsdPoint* first : {&u[i], &v[i]}) first->p *= std::sqrt(std::abs(factors[i]));
  const auto compare = [&](const std::vector<OsdPoint>& theirs, Vec3 SurfacePoint::*part, const char* what) {
    double size = 0, worst = 0;
    for (std::size_t i = 0; i < n; ++i) {
      size = std::max(size, theirs[i].p.norm());
      worst = std::max(worst, (points[i].*part - theirs[i].p).norm());
    }
    EXPECT_LT(worst, 1e-10 * std::max(size, 1.0)) << what;
  };
  compare(p, &SurfacePoint::position, "position");
  compare(u, &SurfacePoint::u, "u");
  compare(v, &SurfacePoint::v, "v");
  compare(uu, &SurfacePoint::uu, "uu");
  compare(uv, &SurfacePoint::uv, "uv");
  compare(vv, &SurfacePoint::vv, "vv");
}

TEST(OpenSubdivEvaluation, AgreesOnLoopSurfaces) {
  expect_agreement(tetrahedron(), {});
  expect_agreement(octahedron(), {});
  expect_agreement(torus(7, 5), {});
  for (const std::uint64_t seed : {1, 2}) expect_agreement(irregular_sphere(seed), {});
}

TEST(OpenSubdivEvaluation, AgreesAtBoundaries) {
  Mesh patch = grid(5, 4);
  Random random(6);
  for (Vec3& p : patch.positions) p += 0.3 * random.vector();
  for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp})
    expect_agreement(patch, {.corners = corners});
  expect_agreement(with_holes(irregular_sphere(3), 11), {});
}

/// A mesh of the data as one around the origin, of size one.
Mesh data_mesh(const std::filesystem::path& file) {
  Mesh mesh = read_mesh(file.string());
  const Box3 box = bounding_box(mesh.positions);
  for (Vec3& p : mesh.positions) p = (p - box.center()) / diagonal_length(box);
  return mesh;
}

class DataMesh : public testing::TestWithParam<std::pair<const char*, Scheme>> {};

TEST_P(DataMesh, AgreesWithOpenSubdiv) {
  GPSRECON_DATA_FILE(file, GetParam().first);
  for (const CornerRule corners : {CornerRule::smooth, CornerRule::sharp})
    expect_agreement(data_mesh(file), {.scheme = GetParam().second, .corners = corners});
}

INSTANTIATE_TEST_SUITE_P(Shapes, DataMesh,
                         testing::Values(std::pair{"quads/catmark_cube.obj", Scheme::catmull_clark},
                                         std::pair{"quads/catmark_torus.obj", Scheme::catmull_clark},
                                         std::pair{"quads/catmark_nonquads.obj", Scheme::catmull_clark},
                                         std::pair{"quads/catmark_pawn.obj", Scheme::catmull_clark},
                                         std::pair{"quads/catmark_bishop.obj", Scheme::catmull_clark},
                                         std::pair{"quads/catmark_pole8.obj", Scheme::catmull_clark},
                                         std::pair{"quads/catmark_tent.obj", Scheme::catmull_clark},
                                         std::pair{"quads/catmark_xord_interior.obj", Scheme::catmull_clark},
                                         std::pair{"quads/bob_ajcg.obj", Scheme::catmull_clark},
                                         std::pair{"quads/fish_control_mesh.obj", Scheme::catmull_clark},
                                         std::pair{"quads/penguin_control_mesh.obj", Scheme::catmull_clark},
                                         std::pair{"quads/spot_control_mesh.obj", Scheme::catmull_clark},
                                         std::pair{"quads/loop_icosahedron.obj", Scheme::loop},
                                         std::pair{"quads/loop_toroidal_tet.obj", Scheme::loop},
                                         std::pair{"quads/loop_xord_interior.obj", Scheme::loop},
                                         std::pair{"meshes/tweety.off", Scheme::loop},
                                         std::pair{"meshes/spot.obj", Scheme::loop}),
                         [](const auto& parameter) {
                           std::string name = std::filesystem::path(parameter.param.first).stem().string();
                           return name;
                         });

}  // namespace
}  // namespace gpsrecon::test
