#pragma once

#include <gpsrecon/core/mesh.h>
#include <vector>

namespace gpsrecon {

/// Faces made manifold and consistently oriented, and what that took.
struct TopologyRepair {
  FaceList faces;
  std::vector<Index> origin;      ///< per vertex the one it is a copy of; the old ones, themselves, come first
  std::size_t dropped_faces = 0;  ///< with fewer than three different corners, again over the same corners, or in the
                                  ///< way to the end
  std::size_t cut_edges = 0;      ///< of more than two faces: all parted
  std::size_t torn_edges = 0;     ///< cut because the surface around has one side only, like a Möbius strip
  std::size_t turned_faces = 0;   ///< to agree with most of those they hang together with
  bool changed() const { return dropped_faces + cut_edges + torn_edges + turned_faces > 0 || copies > 0; }
  std::size_t copies = 0;  ///< new vertices, for fans that only touched in a vertex or hung on a cut edge
};

/// Parts what meets in an edge of more than two faces, and fans that touch in a vertex, by giving each a copy of the
/// vertices; turns faces so that neighbours agree, the fewer within each connected piece. Nothing moves: copies lie
/// where their origin does. A mesh that is manifold and consistently oriented stays as it is. Deterministic; in the
/// order of the faces. O(c log c) in the corners. Throws InvariantError if a corner is out of range.
TopologyRepair repair_topology(const FaceList& faces, std::size_t vertex_count);

}  // namespace gpsrecon
