// Writes the embedded example: gpsrecon_make_example FILE

#include <gpsrecon/io/io.h>
#include <cstdio>
#include <exception>

#include "datasets/example.h"

namespace {

/// Positions only, in single precision, as a scanner without further ado gives them.
gpsrecon::PointCloud make_example() {
  using namespace gpsrecon;
  RunContext context;
  context.seed = datasets::example_seed;
  PointCloud example;
  example.positions = datasets::scan(datasets::example_solid(), datasets::example_scan(), context).cloud.positions;
  for (Vec3& p : example.positions) p = p.cast<float>().cast<double>();
  return example;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FILE\n", argv[0]);
    return 2;
  }
  try {
    gpsrecon::write_points(make_example(), argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
  }
  return 0;
}
