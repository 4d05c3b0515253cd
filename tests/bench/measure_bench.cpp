#include <benchmark/benchmark.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/measure/distance.h>
#include <gpsrecon/measure/statistics.h>

#include "support/meshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

/// Points around the unit sphere with noise of 0.1 % of its diagonal.
PointCloud noisy_sphere(std::size_t n) {
  Random random(71);
  PointCloud cloud;
  for (std::size_t i = 0; i < n; ++i)
    cloud.positions.push_back((1 + random.uniform(-0.005, 0.005)) * random.vector().normalized());
  return cloud;
}

/// Level 7 has 131,072 faces, level 8 has 524,288.
void build_distance_tree(benchmark::State& state) {
  const Mesh mesh = sphere(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(SurfaceDistance(mesh).triangle_count());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.faces.size()));
}
BENCHMARK(build_distance_tree)->Arg(7)->Arg(8)->Unit(benchmark::kMillisecond)->UseRealTime();

void query_distances(benchmark::State& state) {
  const SurfaceDistance surface(sphere(static_cast<int>(state.range(0))));
  const PointCloud cloud = noisy_sphere(300000);
  for (auto _ : state) benchmark::DoNotOptimize(surface.distances(cloud.positions).data());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(cloud.size()));
}
BENCHMARK(query_distances)->Arg(7)->Arg(8)->Unit(benchmark::kMillisecond)->UseRealTime();

void summarise_distances(benchmark::State& state) {
  Random random(72);
  std::vector<double> values(300000);
  for (double& v : values) v = random.uniform();
  for (auto _ : state) benchmark::DoNotOptimize(statistics(values).rms);
}
BENCHMARK(summarise_distances)->Unit(benchmark::kMillisecond)->UseRealTime();

void compare_with_points(benchmark::State& state) {
  const Mesh mesh = sphere(8);
  const PointCloud cloud = noisy_sphere(300000);
  for (auto _ : state) benchmark::DoNotOptimize(compare(mesh, cloud).diagonal);
}
BENCHMARK(compare_with_points)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace gpsrecon::test

BENCHMARK_MAIN();
