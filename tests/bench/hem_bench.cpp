#include <benchmark/benchmark.h>

#include <gpsrecon/core/clean.h>
#include <gpsrecon/core/scale.h>
#include <gpsrecon/hem/hem.h>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

/// A noisy scan of a torus, in random order and world coordinates.
PointCloud scan(std::size_t n) {
  test::SampledShape shape = test::torus(n, 1, 0.4);
  add_noise(shape, 0.5 * shape.spacing(), 1);
  PointCloud cloud = shape.cloud();
  test::Random(2).shuffle(cloud.positions);
  return cloud;
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgName("points")->Arg(100'000)->Arg(300'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond)->UseRealTime();
}

void count(benchmark::State& state, std::size_t points) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points));
}

void clean_cloud(benchmark::State& state) {
  const PointCloud cloud = scan(static_cast<std::size_t>(state.range(0)));
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(clean(cloud));
  count(state, cloud.size());
}
BENCHMARK(clean_cloud)->Apply(sizes);

void scale_of_cloud(benchmark::State& state) {
  const PointCloud cloud = clean(scan(static_cast<std::size_t>(state.range(0)))).cloud;
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(estimate_scale(cloud));
  count(state, cloud.size());
}
BENCHMARK(scale_of_cloud)->Apply(sizes);

void mixture_of_cloud(benchmark::State& state, InitialCovariance initial) {
  const PointCloud cloud = clean(scan(static_cast<std::size_t>(state.range(0)))).cloud;
  const Scale scale = estimate_scale(cloud);
  const HemOptions options{.sigma0 = Length::scene(scale.sigma0),
                           .spacing = Length::scene(scale.spacing),
                           .flat_levels = 0,
                           .initial = initial};
  std::size_t components = 0;
  for ([[maybe_unused]] auto _ : state) components = build_mixture(cloud, options).size();
  state.counters["components"] = static_cast<double>(components);
  count(state, cloud.size());
}
BENCHMARK_CAPTURE(mixture_of_cloud, isotropic, InitialCovariance::isotropic)->Apply(sizes);
BENCHMARK_CAPTURE(mixture_of_cloud, local, InitialCovariance::local)->Apply(sizes);

}  // namespace
}  // namespace gpsrecon

BENCHMARK_MAIN();
