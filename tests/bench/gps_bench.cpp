#include <benchmark/benchmark.h>
#include <gpsrecon/gps/evaluate.h>
#include <gpsrecon/gps/infer.h>
#include <gpsrecon/gps/limit_surface.h>
#include <gpsrecon/gps/subdivide.h>

#include "support/meshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

/// 18,000 control vertices.
const CovMesh& control_mesh() {
  static const CovMesh mesh = infer_covariances(torus(150, 120)).mesh;
  return mesh;
}

RunContext with_threads(int threads) {
  RunContext context;
  context.threads = threads;
  return context;
}

void set_rate(benchmark::State& state, std::size_t vertices) {
  state.counters["vertices"] = static_cast<double>(vertices);
  state.counters["per_second"] =
      benchmark::Counter(static_cast<double>(vertices), benchmark::Counter::kIsIterationInvariantRate);
}

void subdivide_torus(benchmark::State& state) {
  const CovMesh& control = control_mesh();
  const SubdivideOptions options{.levels = static_cast<int>(state.range(0))};
  const RunContext context = with_threads(static_cast<int>(state.range(1)));
  std::size_t vertices = 0;
  for (auto _ : state) vertices = subdivide(control, options, context).positions.size();
  set_rate(state, vertices);
}
BENCHMARK(subdivide_torus)
    ->ArgNames({"levels", "threads"})
    ->ArgsProduct({{0, 1, 2, 3}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void build_limit_surface(benchmark::State& state) {
  const CovMesh& control = control_mesh();
  const RunContext context = with_threads(2);
  std::size_t samples = 0;
  for (auto _ : state) samples = LimitSurface(control.faces, control.vertices.size(), 2, {}, context).sample_count();
  set_rate(state, samples);
}
BENCHMARK(build_limit_surface)->Unit(benchmark::kMillisecond)->UseRealTime();

void evaluate_limit_surface(benchmark::State& state) {
  const CovMesh& control = control_mesh();
  const RunContext context = with_threads(2);
  const LimitSurface surface(control.faces, control.vertices.size(), 2);
  for (auto _ : state) benchmark::DoNotOptimize(surface.evaluate(control.vertices, true, context).positions.data());
  set_rate(state, surface.sample_count());
}
BENCHMARK(evaluate_limit_surface)->Unit(benchmark::kMillisecond)->UseRealTime();

void pull_samples_back(benchmark::State& state) {
  const CovMesh& control = control_mesh();
  const LimitSurface surface(control.faces, control.vertices.size(), 2);
  const std::vector<double> ones(surface.sample_count(), 1);
  for (auto _ : state) benchmark::DoNotOptimize(surface.to_control<double>(ones).data());
  set_rate(state, surface.sample_count());
}
BENCHMARK(pull_samples_back)->Unit(benchmark::kMillisecond);

/// Positions, all derivatives and normals at ten parameters of every face, of which most are irregular on this mesh.
void evaluate_anywhere(benchmark::State& state) {
  static const CovMesh control = infer_covariances(irregular_sphere(1, 5000)).mesh;
  const RunContext context = with_threads(static_cast<int>(state.range(0)));
  const SurfaceEvaluator surface(control);
  Random random(1);
  std::vector<SurfaceParameter> parameters;
  for (Index patch = 0; patch < surface.patch_count(); ++patch)
    for (int i = 0; i < 10; ++i) {
      const double u = random.uniform();
      parameters.push_back({patch, u, (1 - u) * random.uniform()});
    }
  for (auto _ : state) benchmark::DoNotOptimize(surface.evaluate(parameters, context).data());
  set_rate(state, parameters.size());
}
BENCHMARK(evaluate_anywhere)->ArgName("threads")->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace gpsrecon::test

BENCHMARK_MAIN();
