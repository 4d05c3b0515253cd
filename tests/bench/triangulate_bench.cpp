#include <benchmark/benchmark.h>

#include <gpsrecon/hem/hem.h>
#include <gpsrecon/triangulate/overlap_graph.h>
#include <gpsrecon/triangulate/triangulate.h>

#include "support/shapes.h"

namespace gpsrecon {

using namespace internal;
namespace {

/// The mixture of a noisy scan of a torus.
Mixture mixture_of_scan(std::size_t points) {
  test::SampledShape shape = test::torus(points, 1, 0.4);
  add_noise(shape, 0.5 * shape.spacing(), 1);
  return build_mixture(shape.cloud(), {.flat_levels = 0, .initial = InitialCovariance::isotropic});
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgName("points")->Arg(100'000)->Arg(300'000)->Arg(1'000'000)->Unit(benchmark::kMillisecond)->UseRealTime();
}

void overlaps(benchmark::State& state) {
  const Mixture mixture = mixture_of_scan(static_cast<std::size_t>(state.range(0)));
  std::size_t links = 0;
  for ([[maybe_unused]] auto _ : state)
    links = overlap_graph(mixture, TriangulateOptions{}.min_overlap, {}).links.size();
  state.counters["components"] = static_cast<double>(mixture.size());
  state.counters["links_each"] = static_cast<double>(links) / static_cast<double>(mixture.size());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mixture.size()));
}
BENCHMARK(overlaps)->Apply(sizes);

void triangulation(benchmark::State& state) {
  const Mixture mixture = mixture_of_scan(static_cast<std::size_t>(state.range(0)));
  std::size_t faces = 0;
  for ([[maybe_unused]] auto _ : state) faces = triangulate(mixture).mesh.faces.size();
  state.counters["components"] = static_cast<double>(mixture.size());
  state.counters["faces"] = static_cast<double>(faces);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mixture.size()));
}
BENCHMARK(triangulation)->Apply(sizes);

}  // namespace
}  // namespace gpsrecon

BENCHMARK_MAIN();
