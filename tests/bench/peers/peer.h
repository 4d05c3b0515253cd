#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/io/io.h>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

// What the programs that scripts/benchmark.py compares with have in common: each reads points, does one thing with
// another library's defaults, and writes the result as PLY.

namespace gpsrecon::peer {

/// IN OUT [NUMBER], as main() got them.
struct Arguments {
  std::string in, out;
  int number = 0;
};

/// The points whose coordinates, and normals if there are any, are finite. Throws InputError.
inline PointCloud read_finite_points(const std::string& path) {
  const PointCloud cloud = read_points(path);
  PointCloud finite;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.positions[i].allFinite() || (!cloud.normals.empty() && !cloud.normals[i].allFinite())) continue;
    finite.positions.push_back(cloud.positions[i]);
    if (!cloud.normals.empty()) finite.normals.push_back(cloud.normals[i]);
  }
  return finite;
}

/// As above; throws std::runtime_error if there are no normals.
inline PointCloud read_points_with_normals(const std::string& path) {
  PointCloud cloud = read_finite_points(path);
  if (cloud.normals.empty()) throw std::runtime_error(path + ": expected columns nx ny nz");
  return cloud;
}

/// Runs `work(arguments)`; exit code 2 for wrong usage, 1 for whatever it throws. `number` names the third argument,
/// a positive whole number; nullptr if there is none.
template <class Work>
int run(int argc, char** argv, const char* number, Work work) {
  const int expected = number != nullptr ? 4 : 3;
  Arguments arguments;
  if (argc == expected) {
    arguments.in = argv[1];
    arguments.out = argv[2];
    if (number != nullptr) arguments.number = std::atoi(argv[3]);
  }
  if (argc != expected || (number != nullptr && arguments.number < 1)) {
    std::fprintf(stderr, "usage: %s IN OUT%s%s\n", argv[0], number != nullptr ? " " : "",
                 number != nullptr ? number : "");
    return 2;
  }
  try {
    work(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
  }
  return 0;
}

}  // namespace gpsrecon::peer
