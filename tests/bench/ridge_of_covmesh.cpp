// How far the surface of a covariance mesh is from the density ridge of its Gaussians:
//   ridge_of_covmesh COVMESH SAMPLES OUT
// Draws SAMPLES points uniformly by area on the surface at level 3, moves them to the ridge, writes both to OUT
// (points, one row per sample: the point it came to, as scalars surface_x ... its footpoint on the surface, and whether
// it arrived), and prints the distances as JSON, relative to the diagonal of the surface.

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/gps/subdivide.h>
#include <gpsrecon/io/io.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/measure/ridge.h>
#include <cstdio>
#include <cstdlib>
#include <exception>

namespace {

void measure(const char* in, std::size_t count, const char* out) {
  using namespace gpsrecon;
  using namespace gpsrecon::internal;
  const CovMesh covmesh = read_covmesh(in);
  SubdivideOptions options;
  options.levels = 3;
  const Mesh surface = subdivide(covmesh, options);
  const AreaSamples samples = sample_surface(surface, count, 0);
  const std::vector<RidgePoint> found = project_to_ridge(covmesh.vertices, samples.positions);
  const RidgeDistance result = ridge_distance(samples.positions, found);

  const double diagonal = bounding_box_diagonal(surface.positions);
  const Statistics d = scaled(result.distance, 1 / diagonal);
  std::printf(
      "{\"samples\": %zu, \"lost\": %zu, \"mean_rel\": %.9g, \"rms_rel\": %.9g, \"median_rel\": %.9g, "
      "\"p95_rel\": %.9g, \"max_rel\": %.9g, \"sigma0_rel\": %.9g}\n",
      count, result.lost, d.mean, d.rms, d.median, d.p95, d.max, covmesh.vertices.sigma0 / diagonal);

  PointCloud points;
  points.frame = surface.frame;
  points.scalars.resize(4);
  points.scalars[0].name = "surface_x";
  points.scalars[1].name = "surface_y";
  points.scalars[2].name = "surface_z";
  points.scalars[3].name = "arrived";
  for (std::size_t i = 0; i < count; ++i) {
    points.positions.push_back(found[i].position);
    const Vec3 on_surface = surface.frame.to_world(samples.positions[i]);
    for (int k = 0; k < 3; ++k) points.scalars[static_cast<std::size_t>(k)].values.push_back(on_surface[k]);
    points.scalars[3].values.push_back(found[i].on_ridge ? 1 : 0);
  }
  write_points(points, out, PlyEncoding::ascii);
}

}  // namespace

int main(int argc, char** argv) {
  const long count = argc == 4 ? std::atol(argv[2]) : 0;
  if (count < 1) {
    std::fprintf(stderr, "usage: %s COVMESH SAMPLES OUT\n", argv[0]);
    return 2;
  }
  try {
    measure(argv[1], static_cast<std::size_t>(count), argv[3]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
  }
  return 0;
}
