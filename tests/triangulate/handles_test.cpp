#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/triangulate/handles.h>
#include <gpsrecon/triangulate/holes.h>
#include <algorithm>
#include <numeric>
#include <set>

#include "support/covmeshes.h"

namespace gpsrecon {

using namespace internal;
namespace {

using testing::Each;
using testing::Ge;
using testing::IsEmpty;
using testing::SizeIs;

/// Number of pieces the faces fall into when the edges of a loop do not join them: flooded, face by face.
std::size_t pieces_after_cutting(const FaceList& faces, const std::vector<Index>& loop) {
  std::set<std::set<Index>> cut;
  for (std::size_t k = 0; k < loop.size(); ++k) cut.insert({loop[k], loop[(k + 1) % loop.size()]});
  std::vector<std::size_t> piece(faces.size());
  std::iota(piece.begin(), piece.end(), std::size_t{0});
  const auto shares_edge = [&](std::size_t f, std::size_t g) {
    std::set<Index> shared;
    for (const Index v : faces[f])
      if (std::find(faces[g].begin(), faces[g].end(), v) != faces[g].end()) shared.insert(v);
    return shared.size() == 2 && !cut.contains(shared);
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (std::size_t g = 0; g < f; ++g)
        if (piece[f] != piece[g] && shares_edge(f, g)) {
          piece[f] = piece[g] = std::min(piece[f], piece[g]);
          changed = true;
        }
  }
  return std::set<std::size_t>(piece.begin(), piece.end()).size();
}

/// Two flat n by n sheets, a distance of 1 apart, joined around their rims: a closed pillow. Vertex (i, j) of the lower
/// sheet is i * n + j, the one above it n² more.
class Pillow {
 public:
  explicit Pillow(Index n) : n_(n) {
    for (const double z : {0.0, 1.0})
      for (Index i = 0; i < n; ++i)
        for (Index j = 0; j < n; ++j) mesh_.positions.emplace_back(i, j + 0.5 * (i % 2), z);
    for (Index i = 0; i + 1 < n; ++i)
      for (Index j = 0; j + 1 < n; ++j) {
        add_quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), true);
        add_quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), false);
      }
    for (Index i = 0; i + 1 < n; ++i) {
      add_wall(at(i, 0), at(i + 1, 0));
      add_wall(at(n - 1, i), at(n - 1, i + 1));
      add_wall(at(i + 1, n - 1), at(i, n - 1));
      add_wall(at(0, i + 1), at(0, i));
    }
  }

  Index at(Index i, Index j) const { return i * n_ + j; }
  Index above(Index v) const { return v + n_ * n_; }

  /// A tunnel from sheet to sheet with the cross-section of a face, and of its neighbour as well if it is to have four
  /// sides: those faces go, walls come.
  void dig(Index i, Index j, bool four_sides) {
    const Index a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
    const std::vector<Index> rim = four_sides ? std::vector<Index>{a, b, c, d} : std::vector<Index>{a, b, c};
    FaceList kept;
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
      const auto face = mesh_.faces[f];
      const bool inside = std::all_of(face.begin(), face.end(), [&](Index v) {
        const Index below = v % (n_ * n_);
        return std::find(rim.begin(), rim.end(), below) != rim.end() && v / (n_ * n_) == face[0] / (n_ * n_);
      });
      if (!inside) kept.add(face);
    }
    mesh_.faces = kept;
    for (std::size_t k = 0; k < rim.size(); ++k) add_wall(rim[(k + 1) % rim.size()], rim[k]);
  }

  const Mesh& mesh() const { return mesh_; }

  /// Gaussians of deviation `reach` in every direction.
  CovMesh with_gaussians(double reach) const {
    return test::with_equal_covariances(mesh_, Sym3::identity(reach * reach));
  }

 private:
  void add_quad(Index a, Index b, Index c, Index d, bool top) {
    if (top) {
      mesh_.faces.add(above(a), above(b), above(c));
      mesh_.faces.add(above(a), above(c), above(d));
    } else {
      mesh_.faces.add(a, c, b);
      mesh_.faces.add(a, d, c);
    }
  }
  /// Faces between the sheets, seen from the right of from -> to.
  void add_wall(Index from, Index to) {
    mesh_.faces.add(from, to, above(to));
    mesh_.faces.add(from, above(to), above(from));
  }

  Index n_;
  Mesh mesh_;
};

Topology topology_of(const FaceList& faces) {
  const Index last = *std::max_element(faces.corners.begin(), faces.corners.end());
  return topology(faces, last + std::size_t{1});
}

struct Mended {
  CovMesh mesh;
  Mending mending;
};
Mended mend_handles(const CovMesh& mesh, int max_edges) {
  Mended result{mesh, {}};
  std::vector<Index> component(mesh.vertices.size());
  std::iota(component.begin(), component.end(), Index{0});
  TriangulateOptions options;
  options.max_handle_edges = max_edges;
  result.mending = mend(result.mesh, build_connectivity(result.mesh.faces, result.mesh.vertices.size()), component,
                        mesh.vertices, options);
  return result;
}

TEST(Handles, GenusCountsHandlesOfEveryComponentAndNotBoundaries) {
  const Mesh torus = test::torus(12, 9), ball = test::sphere(1), sheet = test::grid(4, 5);
  EXPECT_EQ(genus(build_connectivity(ball.faces, ball.positions.size())), 0U);
  EXPECT_EQ(genus(build_connectivity(sheet.faces, sheet.positions.size())), 0U);
  EXPECT_EQ(genus(build_connectivity(torus.faces, torus.positions.size())), 1U);
  FaceList torn;
  for (std::size_t f = 1; f < torus.faces.size(); ++f) torn.add(torus.faces[f]);
  EXPECT_EQ(genus(build_connectivity(torn, torus.positions.size())), 1U);
  FaceList two = torus.faces;
  for (std::size_t f = 0; f < torus.faces.size(); ++f) {
    std::vector<Index> shifted(torus.faces[f].begin(), torus.faces[f].end());
    for (Index& v : shifted) v += static_cast<Index>(torus.positions.size());
    two.add(shifted);
  }
  EXPECT_EQ(genus(build_connectivity(two, 2 * torus.positions.size())), 2U);
}

TEST(Handles, LoopsOfATorusAreAsLongAsItsTubeAndDoNotSeparateIt) {
  const Mesh torus = test::torus(14, 7);
  EXPECT_THAT(handle_loops(torus.positions, torus.faces, 6), IsEmpty());
  const auto loops = handle_loops(torus.positions, torus.faces, 7);
  EXPECT_THAT(loops, SizeIs(Ge(14U)));  // around the tube, at every place of it
  EXPECT_THAT(loops, Each(SizeIs(7)));
  for (const auto& loop : loops) EXPECT_EQ(pieces_after_cutting(torus.faces, loop), 1U);
}

TEST(Handles, LoopsThatSeparateAreNone) {
  // A sphere has none; nor has a torus away from its handle: the neck to a sphere glued on is cut by three edges.
  const Mesh ball = test::sphere(2);
  EXPECT_THAT(handle_loops(ball.positions, ball.faces, 12), IsEmpty());
  const Mesh torus = test::torus(14, 11);
  const Mesh bud = test::sphere(1);
  Mesh joined = torus;
  joined.positions.insert(joined.positions.end(), bud.positions.begin(), bud.positions.end());
  const auto shift = static_cast<Index>(torus.positions.size());
  FaceList faces;
  for (std::size_t f = 1; f < torus.faces.size(); ++f) faces.add(torus.faces[f]);
  for (std::size_t f = 1; f < bud.faces.size(); ++f)
    faces.add(bud.faces[f][0] + shift, bud.faces[f][1] + shift, bud.faces[f][2] + shift);
  const auto rim = torus.faces[0], mouth = bud.faces[0];
  for (std::size_t k = 0; k < 3; ++k) {
    // The mouth runs the other way around.
    const Index a = rim[k], b = rim[(k + 1) % 3];
    const Index c = mouth[(3 - k) % 3] + shift, d = mouth[(5 - k) % 3] + shift;
    faces.add(a, b, d);
    faces.add(a, d, c);
  }
  ASSERT_TRUE(topology(faces, joined.positions.size()).manifold());
  ASSERT_EQ(genus(build_connectivity(faces, joined.positions.size())), 1U);
  EXPECT_THAT(handle_loops(joined.positions, faces, 10), IsEmpty());
}

TEST(Handles, LoopsDoNotDependOnThreads) {
  const Mesh torus = test::torus(450, 10);
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  const auto loops = handle_loops(torus.positions, torus.faces, 10, one);
  EXPECT_FALSE(loops.empty());
  EXPECT_EQ(loops, handle_loops(torus.positions, torus.faces, 10, four));
}

TEST(Handles, ATunnelBetweenThreeGaussiansIsFilled) {
  Pillow pillow(9);
  pillow.dig(4, 4, false);
  const CovMesh mesh = pillow.with_gaussians(0.6);
  ASSERT_NO_THROW(validate(mesh));
  ASSERT_EQ(topology_of(mesh.faces).euler, 0);
  const Mended mended = mend_handles(mesh, 3);
  EXPECT_EQ(mended.mending.handles, 1U);
  EXPECT_NO_THROW(validate(mended.mesh));
  const Topology after = topology_of(mended.mesh.faces);
  EXPECT_EQ(after.euler, 2);
  EXPECT_EQ(after.components, 1U);
  EXPECT_EQ(after.boundary_loops, 0U);
  // The sheets are flat where the tunnel was.
  for (const Index v : mended.mesh.faces.corners)
    EXPECT_LT(std::min(std::abs(mended.mesh.vertices.means[v].z()), std::abs(mended.mesh.vertices.means[v].z() - 1)),
              0.05);
}

TEST(Handles, EveryTunnelIsFilled) {
  Pillow pillow(21);
  for (const Index i : {4U, 10U, 16U})
    for (const Index j : {4U, 10U, 16U}) pillow.dig(i, j, false);
  ASSERT_EQ(topology_of(pillow.mesh().faces).euler, 2 - 2 * 9);
  const Mended mended = mend_handles(pillow.with_gaussians(0.6), 3);
  EXPECT_EQ(mended.mending.handles, 9U);
  EXPECT_EQ(topology_of(mended.mesh.faces).euler, 2);
}

TEST(Handles, AHandleThatTheMixtureDoesNotReachAcrossStays) {
  Pillow pillow(9);
  pillow.dig(4, 4, false);
  const Mended mended = mend_handles(pillow.with_gaussians(0.1), 3);
  EXPECT_EQ(mended.mending.handles, 0U);
  EXPECT_EQ(mended.mesh.faces, pillow.mesh().faces);
}

TEST(Handles, FourSidesAreKeptUnlessAskedFor) {
  Pillow pillow(9);
  pillow.dig(4, 4, true);
  const CovMesh mesh = pillow.with_gaussians(0.6);
  ASSERT_EQ(topology_of(mesh.faces).euler, 0);
  EXPECT_EQ(mend_handles(mesh, 3).mending.handles, 0U);
  EXPECT_EQ(mend_handles(mesh, 0).mending.handles, 0U);
  const Mended mended = mend_handles(mesh, 4);
  EXPECT_EQ(mended.mending.handles, 1U);
  EXPECT_EQ(topology_of(mended.mesh.faces).euler, 2);
}

TEST(Handles, ARealHoleOfManySidesStays) {
  const Mesh torus = test::torus(24, 8);
  const CovMesh mesh = test::with_equal_covariances(torus, Sym3::identity(0.05));
  const Mended mended = mend_handles(mesh, 3);
  EXPECT_EQ(mended.mending.handles, 0U);
  EXPECT_EQ(genus(build_connectivity(mended.mesh.faces, mended.mesh.vertices.size())), 1U);
}

}  // namespace
}  // namespace gpsrecon
