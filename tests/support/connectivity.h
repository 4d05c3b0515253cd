#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gtest/gtest.h>

namespace gpsrecon::test {

/// The connectivity handed on is the one the faces have.
inline void expect_connectivity(const Connectivity& connectivity, const FaceList& faces, std::size_t vertices) {
  const Connectivity built = build_connectivity(faces, vertices);
  EXPECT_EQ(connectivity.vertex_count, built.vertex_count);
  EXPECT_EQ(connectivity.corners_per_face, built.corners_per_face);
  EXPECT_EQ(connectivity.corners, built.corners);
  EXPECT_EQ(connectivity.opposite, built.opposite);
  EXPECT_EQ(connectivity.edge, built.edge);
  EXPECT_EQ(connectivity.edge_start, built.edge_start);
  EXPECT_EQ(connectivity.vertex_start, built.vertex_start);
  EXPECT_EQ(connectivity.face_count, built.face_count);
}

}  // namespace gpsrecon::test
