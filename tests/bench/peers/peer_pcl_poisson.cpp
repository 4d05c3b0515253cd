// Screened Poisson reconstruction of points with normals by PCL, which holds the code of Kazhdan and Hoppe (2013), with
// PCL's defaults.

#include <pcl/point_types.h>
#include <pcl/surface/poisson.h>

#include <algorithm>
#include <thread>

#include "peer.h"

namespace {

void reconstruct(const gpsrecon::peer::Arguments& arguments) {
  const auto points = pcl::make_shared<pcl::PointCloud<pcl::PointNormal>>();
  // PCL computes in single precision: far from the origin the points would lose their digits.
  gpsrecon::Vec3 center = gpsrecon::Vec3::Zero();
  {
    const gpsrecon::PointCloud cloud = gpsrecon::peer::read_points_with_normals(arguments.in);
    for (const gpsrecon::Vec3& p : cloud.positions) center += p / static_cast<double>(cloud.size());
    points->reserve(cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      pcl::PointNormal p;
      p.getVector3fMap() = (cloud.positions[i] - center).cast<float>();
      p.getNormalVector3fMap() = cloud.normals[i].cast<float>();
      points->push_back(p);
    }
  }
  pcl::Poisson<pcl::PointNormal> poisson;
  poisson.setDepth(arguments.number);
  poisson.setThreads(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  poisson.setInputCloud(points);
  pcl::PointCloud<pcl::PointNormal> vertices;
  std::vector<pcl::Vertices> polygons;
  poisson.reconstruct(vertices, polygons);

  gpsrecon::Mesh mesh;
  for (const pcl::PointNormal& p : vertices) mesh.positions.push_back(p.getVector3fMap().cast<double>() + center);
  std::vector<gpsrecon::Index> face;
  for (const pcl::Vertices& polygon : polygons) {
    face.assign(polygon.vertices.begin(), polygon.vertices.end());
    mesh.faces.add(face);
  }
  gpsrecon::write_mesh(mesh, arguments.out);
}

}  // namespace

int main(int argc, char** argv) {
  return gpsrecon::peer::run(argc, argv, "DEPTH", reconstruct);
}
