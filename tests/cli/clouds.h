#pragma once

#include <gpsrecon/core/vec.h>
#include <string>
#include <vector>

namespace gpsrecon::test {

/// n points evenly on the unit sphere (Fibonacci lattice) with radial noise of the given standard deviation.
std::vector<Vec3> noisy_sphere(std::size_t n, double noise);
/// n points on a torus of radii 1 and 0.4, scattered, with noise along the normal.
std::vector<Vec3> noisy_torus(std::size_t n, double noise);
/// n x n points on the unit square, exactly in the plane z = 0, off the lattice by up to a third of its step.
std::vector<Vec3> flat_sheet(std::size_t n);

/// The points as a binary PLY file of doubles, independent of the library's own writer.
std::string ply_of(const std::vector<Vec3>& points);
/// The same as text, one point per line.
std::string xyz_of(const std::vector<Vec3>& points);

}  // namespace gpsrecon::test
