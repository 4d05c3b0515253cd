// What making, copying and editing a mesh costs with the editable mesh, CGAL's, and with OpenMesh's, on a torus.

#include <benchmark/benchmark.h>
#include <gpsrecon/core/editable_mesh.h>

#include <CGAL/boost/graph/Euler_operations.h>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <numeric>

#include "support/meshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

const Mesh& control() {
  static const Mesh mesh = torus(300, 300);  // 180,000 triangles
  return mesh;
}

/// Edges of the mesh in an order that jumps about.
std::vector<Index> scattered(std::size_t edges) {
  std::size_t stride = 7919;
  while (std::gcd(stride, edges) != 1) ++stride;
  std::vector<Index> order(edges);
  for (std::size_t k = 0; k < edges; ++k) order[k] = static_cast<Index>(k * stride % edges);
  return order;
}

struct OurMesh {
  EditableMesh mesh = editable_mesh(control().positions, control().faces);

  std::size_t edges() const { return mesh.number_of_edges(); }
  bool flip(Index edge) {
    const auto h = mesh.halfedge(EditableMesh::Edge_index(edge));
    const auto c = mesh.target(mesh.next(h)), d = mesh.target(mesh.next(mesh.opposite(h)));
    if (c == d || mesh.halfedge(c, d) != EditableMesh::null_halfedge()) return false;
    CGAL::Euler::flip_edge(h, mesh);
    return true;
  }
  bool collapse(Index edge) {
    const EditableMesh::Edge_index e(edge);
    if (mesh.is_removed(e) || !CGAL::Euler::does_satisfy_link_condition(e, mesh)) return false;
    CGAL::Euler::collapse_edge(e, mesh);
    return true;
  }
};

struct PeerTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  HalfedgeAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::PrevHalfedge);
  EdgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status);
};

struct PeerMesh {
  using Kernel = OpenMesh::TriMesh_ArrayKernelT<PeerTraits>;
  Kernel mesh;

  PeerMesh() {
    const std::vector<Vec3>& positions = control().positions;
    const FaceList& faces = control().faces;
    mesh.reserve(positions.size(), faces.corners.size() / 2 + positions.size(), faces.size());
    for (const Vec3& p : positions) mesh.add_vertex({p.x(), p.y(), p.z()});
    const auto at = [](Index v) { return Kernel::VertexHandle(static_cast<int>(v)); };
    for (std::size_t f = 0; f < faces.size(); ++f) mesh.add_face(at(faces[f][0]), at(faces[f][1]), at(faces[f][2]));
  }
  std::size_t edges() const { return mesh.n_edges(); }
  bool flip(Index edge) {
    const Kernel::EdgeHandle e(static_cast<int>(edge));
    if (!mesh.is_flip_ok(e)) return false;
    mesh.flip(e);
    return true;
  }
  bool collapse(Index edge) {
    const Kernel::EdgeHandle e(static_cast<int>(edge));
    if (mesh.status(e).deleted() || !mesh.is_collapse_ok(mesh.halfedge_handle(e, 0))) return false;
    mesh.collapse(mesh.halfedge_handle(e, 0));
    return true;
  }
};

template <class M>
void make(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(M());
}

template <class M>
void copy(benchmark::State& state) {
  const M mesh;
  for (auto _ : state) {
    M other = mesh;
    benchmark::DoNotOptimize(other);
  }
}

/// Every edge, where it can be, and back at once.
template <class M>
void flip(benchmark::State& state) {
  M mesh;
  const std::vector<Index> order = scattered(mesh.edges());
  std::size_t flips = 0;
  for (auto _ : state) {
    flips = 0;
    for (const Index e : order)
      if (mesh.flip(e)) flips += mesh.flip(e) ? 2 : 1;
  }
  state.counters["flips"] = static_cast<double>(flips);
}

/// Until half of the vertices are gone.
template <class M>
void collapse(benchmark::State& state) {
  const M start;
  const std::vector<Index> order = scattered(start.edges());
  const std::size_t wanted = control().positions.size() / 2;
  std::size_t collapses = 0;
  for (auto _ : state) {
    state.PauseTiming();
    M mesh = start;
    state.ResumeTiming();
    collapses = 0;
    for (auto e = order.begin(); e != order.end() && collapses < wanted; ++e) collapses += mesh.collapse(*e) ? 1 : 0;
  }
  state.counters["collapses"] = static_cast<double>(collapses);
}

BENCHMARK(make<OurMesh>)->Unit(benchmark::kMillisecond);
BENCHMARK(make<PeerMesh>)->Unit(benchmark::kMillisecond);
BENCHMARK(copy<OurMesh>)->Unit(benchmark::kMillisecond);
BENCHMARK(copy<PeerMesh>)->Unit(benchmark::kMillisecond);
BENCHMARK(flip<OurMesh>)->Unit(benchmark::kMillisecond);
BENCHMARK(flip<PeerMesh>)->Unit(benchmark::kMillisecond);
BENCHMARK(collapse<OurMesh>)->Unit(benchmark::kMillisecond);
BENCHMARK(collapse<PeerMesh>)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gpsrecon::test

BENCHMARK_MAIN();
