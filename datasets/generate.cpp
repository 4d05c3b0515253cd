// Writes the embedded example: gpsrecon_make_example FILE

#include <gpsrecon/core/error.h>
#include <bit>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

#include "datasets/example.h"

namespace {

using namespace gpsrecon;

/// Positions only, as a scanner without further ado gives them, in `float`.
void write_ply(const std::vector<Vec3>& positions, const std::string& path) {
  static_assert(std::endian::native == std::endian::little);
  std::vector<float> coordinates;
  coordinates.reserve(3 * positions.size());
  for (const Vec3& p : positions)
    for (int k = 0; k < 3; ++k) coordinates.push_back(static_cast<float>(p[k]));

  const std::string temporary = path + ".part";
  std::ofstream file(temporary, std::ios::binary);
  file << "ply\nformat binary_little_endian 1.0\n"
       << "comment virtual scan, see datasets/README.md; seed " << datasets::example_seed << "\n"
       << "element vertex " << positions.size()
       << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  file.write(reinterpret_cast<const char*>(coordinates.data()),
             static_cast<std::streamsize>(coordinates.size() * sizeof(float)));
  file.close();
  if (!file) throw OutputError(temporary + ": cannot be written");
  std::filesystem::rename(temporary, path);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FILE\n", argv[0]);
    return 2;
  }
  try {
    RunContext context;
    context.seed = datasets::example_seed;
    write_ply(datasets::scan(datasets::example_solid(), datasets::example_scan(), context).cloud.positions, argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
  }
  return 0;
}
