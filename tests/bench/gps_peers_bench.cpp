// What refinement costs beside OpenMesh's, which moves three numbers per vertex and gives no limit and no normals
// unless asked, beside OpenSubdiv's where it is there, which does give limits, and beside plain copying of memory.

#include <benchmark/benchmark.h>
#include <gpsrecon/gps/infer.h>
#include <gpsrecon/gps/subdivide.h>
#include <cstring>

#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/CatmullClarkT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/LoopT.hh>

#include "support/meshes.h"
#ifdef GPSRECON_HAVE_OPENSUBDIV
#include <opensubdiv/far/primvarRefiner.h>
#include "gps/opensubdiv.h"
#endif

namespace gpsrecon::test {

using namespace internal;
namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using TriangleMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;
using PolygonMesh = OpenMesh::PolyMesh_ArrayKernelT<DoubleTraits>;

constexpr int levels = 3;

const Mesh& control() {
  static const Mesh mesh = torus(150, 120);  // 18,000 vertices
  return mesh;
}

void set_rate(benchmark::State& state, std::size_t vertices) {
  state.counters["vertices"] = static_cast<double>(vertices);
  state.counters["per_second"] =
      benchmark::Counter(static_cast<double>(vertices), benchmark::Counter::kIsIterationInvariantRate);
}

void refine_gaussians(benchmark::State& state, Scheme scheme) {
  CovMesh mesh = infer_covariances(control()).mesh;
  mesh.rules.scheme = scheme;
  RunContext context;
  context.threads = static_cast<int>(state.range(0));
  std::size_t vertices = 0;
  for (auto _ : state) vertices = subdivide(mesh, {.levels = levels}, context).positions.size();
  set_rate(state, vertices);
}
void gpsrecon_loop(benchmark::State& state) {
  refine_gaussians(state, Scheme::loop);
}
void gpsrecon_catmull_clark(benchmark::State& state) {
  refine_gaussians(state, Scheme::catmull_clark);
}
BENCHMARK(gpsrecon_loop)->ArgName("threads")->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(gpsrecon_catmull_clark)->ArgName("threads")->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

template <class Peer>
Peer peer_mesh() {
  Peer mesh;
  std::vector<typename Peer::VertexHandle> handles;
  for (const Vec3& p : control().positions) handles.push_back(mesh.add_vertex({p.x(), p.y(), p.z()}));
  for (std::size_t f = 0; f < control().faces.size(); ++f) {
    const auto face = control().faces[f];
    mesh.add_face(handles[face[0]], handles[face[1]], handles[face[2]]);
  }
  return mesh;
}

template <class Peer, class Subdivider>
void refine_peer(benchmark::State& state) {
  const Peer mesh = peer_mesh<Peer>();
  std::size_t vertices = 0;
  for (auto _ : state) {
    state.PauseTiming();
    Peer fine = mesh;
    state.ResumeTiming();
    Subdivider subdivider;
    subdivider.attach(fine);
    subdivider(levels);
    subdivider.detach();
    fine.request_face_normals();
    fine.request_vertex_normals();
    fine.update_normals();
    vertices = fine.n_vertices();
  }
  set_rate(state, vertices);
}
void openmesh_loop(benchmark::State& state) {
  refine_peer<TriangleMesh, OpenMesh::Subdivider::Uniform::LoopT<TriangleMesh, double>>(state);
}
void openmesh_catmull_clark(benchmark::State& state) {
  refine_peer<PolygonMesh, OpenMesh::Subdivider::Uniform::CatmullClarkT<PolygonMesh, double>>(state);
}
BENCHMARK(openmesh_loop)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(openmesh_catmull_clark)->Unit(benchmark::kMillisecond)->UseRealTime();

#ifdef GPSRECON_HAVE_OPENSUBDIV
/// Its refined positions, limits and normals, three numbers per vertex, by one thread.
void refine_by_opensubdiv(benchmark::State& state, Scheme scheme) {
  std::size_t vertices = 0;
  for (auto _ : state) {
    const std::unique_ptr<Far::TopologyRefiner> refiner = osd_refiner(control(), {.scheme = scheme});
    Far::TopologyRefiner::UniformOptions uniform(levels);
    uniform.fullTopologyInLastLevel = true;
    refiner->RefineUniform(uniform);
    const Far::PrimvarRefinerReal<double> values(*refiner);
    std::vector<OsdPoint> points = osd_points(control());
    for (int level = 1; level <= levels; ++level) {
      std::vector<OsdPoint> fine(static_cast<std::size_t>(refiner->GetLevel(level).GetNumVertices()));
      values.Interpolate(level, points, fine);
      points.swap(fine);
    }
    vertices = points.size();
    std::vector<OsdPoint> limit(vertices), u(vertices), v(vertices);
    values.Limit(points, limit, u, v);
    std::vector<Vec3> normals(vertices);
    for (std::size_t i = 0; i < vertices; ++i) normals[i] = u[i].p.cross(v[i].p).normalized();
    benchmark::DoNotOptimize(normals.data());
  }
  set_rate(state, vertices);
}
void opensubdiv_loop(benchmark::State& state) {
  refine_by_opensubdiv(state, Scheme::loop);
}
void opensubdiv_catmull_clark(benchmark::State& state) {
  refine_by_opensubdiv(state, Scheme::catmull_clark);
}
BENCHMARK(opensubdiv_loop)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(opensubdiv_catmull_clark)->Unit(benchmark::kMillisecond)->UseRealTime();
#endif

/// Bytes read and written per second.
void copy_memory(benchmark::State& state) {
  std::vector<char> from(std::size_t{1} << 28, 1), to(from.size());
  for (auto _ : state) {
    std::memcpy(to.data(), from.data(), from.size());
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(2 * static_cast<std::int64_t>(state.iterations() * from.size()));
}
BENCHMARK(copy_memory)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace gpsrecon::test

BENCHMARK_MAIN();
