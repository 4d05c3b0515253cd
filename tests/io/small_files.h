#pragma once

#include <gpsrecon/io/io.h>

#include <bit>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "support/meshes.h"
#include "support/temporary_folder.h"

// Small objects and small files of every format, shared by the tests of this folder.

namespace gpsrecon::test {

inline Mixture random_mixture(std::size_t n, const Frame& frame, bool with_normals, std::uint64_t seed = 1) {
  Random random(seed);
  Mixture mixture;
  mixture.frame = frame;
  mixture.sigma0 = 0.0123 + 0.001 * random.uniform(-1, 1);
  for (std::size_t s = 0; s < n; ++s) {
    mixture.means.push_back(random.vector());
    Sym3 covariance = Sym3::identity(1e-4);
    for (int k = 0; k < 2; ++k) covariance += 0.01 * Sym3::outer(random.vector());
    mixture.covariances.push_back(covariance);
    mixture.weights.push_back(10 + random.uniform(-1, 1));
    if (!with_normals) continue;
    mixture.normals.push_back(random.vector().normalized());
    mixture.normal_variances.push_back(std::abs(random.uniform(-1, 1)));
  }
  return mixture;
}

inline CovMesh octahedron_covmesh(const Frame& frame, bool with_normals) {
  return {random_mixture(6, frame, with_normals, 7), octahedron().faces};
}

inline PointCloud small_cloud() {
  Random random(3);
  PointCloud cloud;
  cloud.scalars = {{"intensity", {}}, {"class", {}}};
  for (int i = 0; i < 5; ++i) {
    cloud.positions.push_back(random.vector());
    cloud.normals.push_back(random.vector().normalized());
    cloud.sensors.push_back(random.vector());
    cloud.colors.push_back({static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(255 - i), 9});
    cloud.scalars[0].values.push_back(random.uniform(-1, 1));
    cloud.scalars[1].values.push_back(i);
  }
  return cloud;
}

inline void append_bits(std::string& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xFF);
}

/// Three points with double coordinates that float cannot hold, in the three encodings of PCD.
inline const std::vector<Vec3>& pcd_positions() {
  static const std::vector<Vec3> positions{
      {637177.98, 849393.95, 411.19}, {637178.01, 849394.25, 0.1}, {1. / 3, -2. / 3, 1e-12}};
  return positions;
}
inline std::string pcd_file(const std::string& encoding, const std::string& viewpoint = "0 0 0 1 0 0 0") {
  std::string header =
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb label\nSIZE 8 8 8 4 2\nTYPE F F F U "
      "U\n"
      "COUNT 1 1 1 1 1\nWIDTH 3\nHEIGHT 1\nVIEWPOINT " +
      viewpoint + "\nPOINTS 3\nDATA " + encoding + "\n";
  if (encoding == "ascii") {
    for (std::size_t i = 0; i < 3; ++i) {
      char row[200];
      const Vec3& p = pcd_positions()[i];
      std::snprintf(row, sizeof(row), "%.17g %.17g %.17g %u %u\n", p.x(), p.y(), p.z(), 0x010203u * unsigned(i + 1),
                    unsigned(40000 + i));
      header += row;
    }
    return header;
  }
  std::string body;
  const auto coordinate = [](std::size_t i, int axis) {
    return std::bit_cast<std::uint64_t>(pcd_positions()[i][axis]);
  };
  if (encoding == "binary") {
    for (std::size_t i = 0; i < 3; ++i) {
      for (int axis = 0; axis < 3; ++axis) append_bits(body, coordinate(i, axis), 8);
      append_bits(body, 0x010203u * (i + 1), 4);
      append_bits(body, 40000 + i, 2);
    }
    return header + body;
  }
  // Compressed files hold column after column, packed with LZF; runs of at most 32 literal bytes are valid LZF.
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < 3; ++i) append_bits(body, coordinate(i, axis), 8);
  for (std::size_t i = 0; i < 3; ++i) append_bits(body, 0x010203u * (i + 1), 4);
  for (std::size_t i = 0; i < 3; ++i) append_bits(body, 40000 + i, 2);
  std::string packed;
  for (std::size_t begin = 0; begin < body.size(); begin += 32) {
    const std::string run = body.substr(begin, 32);
    packed += static_cast<char>(run.size() - 1);
    packed += run;
  }
  append_bits(header, packed.size(), 4);
  append_bits(header, body.size(), 4);
  return header + packed;
}

/// A name and the bytes of a small valid file, for every format that is read.
inline std::vector<std::pair<std::string, std::string>> small_files() {
  const TemporaryFolder folder;
  std::vector<std::pair<std::string, std::string>> files;
  const auto add = [&](const std::string& name, const auto& write) {
    write(folder / name);
    files.emplace_back(name, read_bytes(folder / name));
  };
  const Frame frame{Vec3(3, -2, 100), 4};
  for (const PlyEncoding encoding : {PlyEncoding::binary, PlyEncoding::ascii}) {
    const std::string suffix = encoding == PlyEncoding::binary ? "_binary.ply" : "_ascii.ply";
    add("points" + suffix, [&](const std::string& path) { write_points(small_cloud(), path, encoding); });
    add("mixture" + suffix,
        [&](const std::string& path) { write_mixture(random_mixture(3, frame, true), path, encoding); });
    add("mixture_colors" + suffix, [&](const std::string& path) {
      Mixture mixture = random_mixture(3, frame, false);
      mixture.colors.assign(3, {1, 2, 3});
      mixture.scalars = {{"zone", {1, 2, 3}, ScalarKind::label}, {"intensity", {0.5, 1, 2}}};
      write_mixture(mixture, path, encoding);
    });
    add("covmesh" + suffix,
        [&](const std::string& path) { write_covmesh(octahedron_covmesh(frame, false), path, encoding); });
    add("mesh" + suffix, [&](const std::string& path) { write_mesh(octahedron(), path, encoding); });
  }
  for (const char* const name : {"mesh.off", "mesh.obj", "mesh.stl"})
    add(name, [&](const std::string& path) { write_mesh(octahedron(), path); });
  files.emplace_back("text.stl",
                     "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
                     "endfacet\nendsolid\n");
  files.emplace_back("points.xyz", "# x y z i\n0 0 1 5\n1.5 2e-3 -4 6\n\n7 8 9 10\n");
  files.emplace_back("points.csv", "x;y;z;nx;ny;nz\n0;0;1;0;0;1\n1;2;3;0;1;0\n");
  for (const char* const encoding : {"ascii", "binary", "binary_compressed"})
    files.emplace_back(std::string(encoding) + ".pcd", pcd_file(encoding));
  return files;
}

}  // namespace gpsrecon::test
