#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/run_context.h>
#include <optional>
#include <string_view>

namespace gpsrecon {

/// Which boundary loops are filled with new triangles, beyond the pinholes that the mixture itself bridges.
enum class HolePolicy {
  automatic,  ///< gaps all of which lies within reach of a Gaussian, used or left over
  keep,       ///< none
  fill,       ///< those, and every loop up to a given length
  all,        ///< every loop, outer rims of open sheets included
};

/// Why a boundary loop is open.
enum class LoopReason {
  rim,              ///< the outer rim of an open sheet, not a gap in one
  no_points,        ///< no Gaussian reaches into it: a real boundary, or not scanned
  too_long,         ///< the same, and longer than HolePolicy::fill allows
  kept,             ///< HolePolicy::keep
  no_patch,         ///< it has no triangulation that keeps the surface manifold
  would_intersect,  ///< its patch would cut the surface
};
/// As reports write it: the name above.
std::string_view name_of(LoopReason reason);

struct TriangulateOptions {
  /// Smallest Bhattacharyya coefficient of two Gaussians that may share an edge. Range: (0, 1).
  double min_overlap = 0.01;
  /// Smallest dihedral angle between neighbouring triangles, in radians; π is flat. Range: [0, π).
  double min_dihedral = 0.5235987755982988;  // π/6
  /// Connected components with less than this share of the total weight are dropped. Range: [0, 1).
  double min_component_share = 0.001;
  /// Gaussians with less than this share of the median weight of those that overlap them are left out: outliers and
  /// spikes, which bend the surface where a triangle reaches for them. Range: [0, 1).
  double min_weight_share = 0.1;
  /// Boundary loops of at most this many edges that the mixture itself bridges are closed. Range: >= 0; 0 = none.
  int max_pinhole_edges = 24;
  /// Handles are removed that a loop of at most this many edges runs around or through, if what closes the surface
  /// instead lies within reach of the mixture. Three Gaussians that overlap in pairs are a triangle as well as a tube;
  /// a tube of four may be real. Range: >= 0; below 3 = none.
  int max_handle_edges = 3;
  /// Which boundary loops are filled.
  HolePolicy holes = HolePolicy::automatic;
  /// With HolePolicy::fill the length of the longest loop that is filled in any case, as a share of the diagonal of the
  /// box around the vertices. Range: >= 0, finite.
  double fill_length_rel = 0;
  /// The rules of the surface that the mesh stands for. The mesh itself does not depend on them.
  SurfaceRules rules = {};
  /// Where the sensor stood, in the units of the means: open components are turned towards it.
  std::optional<Vec3> sensor = std::nullopt;
  /// Called from time to time with the faces so far (indices into the input mixture). May be empty.
  std::function<void(std::size_t step, const FaceList& faces)> on_snapshot = nullptr;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// A covariance mesh and what was left out of it.
struct Triangulation {
  CovMesh mesh;
  std::vector<Index> component_of_vertex;  ///< per mesh vertex: the component of the input mixture it came from, or
                                           ///< no_index if it was made to fill a hole
  std::size_t light_components = 0;        ///< Gaussians below min_weight_share
  double light_weight = 0;                 ///< their weight, in points
  std::size_t leftover_components = 0;     ///< other Gaussians that no face uses
  double leftover_weight = 0;              ///< their weight, in points
  std::size_t dropped_specks = 0;          ///< connected components below min_component_share
  double dropped_speck_weight = 0;         ///< their weight, in points
  std::size_t split_vertices = 0;          ///< copies made to part fans that touch in a vertex
  std::size_t flipped_edges = 0;           ///< interior edges flipped for a better grade
  std::size_t closed_pinholes = 0;         ///< boundary loops closed because the mixture bridges them
  std::size_t untangled = 0;               ///< regions where the surface intersected itself that were replaced
  std::size_t removed_handles = 0;         ///< handles too small for the mixture to tell from none
  std::size_t filled_holes = 0;            ///< boundary loops closed as `holes` asks
  std::size_t filled_rims = 0;             ///< of these, outer rims of open sheets
  std::size_t filled_vertices = 0;         ///< vertices made for that
  std::vector<LoopReason> loop_reasons;    ///< of the loops that boundary_loops() finds in the mesh, in its order
  std::size_t turned_triangles = 0;        ///< of patches that had grown inside out
  std::size_t flipped_components = 0;      ///< connected components turned over to face outward or the sensor
};

/// Connects the components of a mixture to a manifold, oriented triangle mesh: a greedy front over the graph of pairs
/// with sufficient Bhattacharyya overlap, graded by overlap and flatness (Preiner et al. 2019, section 6.2, Eq. 18-22).
/// Closed components face outward, those inside an odd number of others inward. O(n k log n) for n components of k
/// overlapping neighbours. Throws OptionError, NoSurfaceError if no triangle can be made, Cancelled.
Triangulation triangulate(const Mixture& mixture, const TriangulateOptions& options = {},
                          const RunContext& context = {});

}  // namespace gpsrecon
