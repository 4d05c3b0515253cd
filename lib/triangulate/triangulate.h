#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/core/run_context.h>
#include <optional>
#include <string>
#include <string_view>

namespace gpsrecon {

/// Which boundary loops are filled with new triangles, beyond the pinholes that the mixture itself bridges.
enum class HolePolicy {
  automatic,  ///< gaps all of which lies within reach of a Gaussian, used or left over
  keep,       ///< none
  fill,       ///< those, and every loop up to a given length
  all,        ///< every loop, outer rims of open sheets included
};

/// A policy, and with HolePolicy::fill the length of the longest loop that is filled in any case.
struct HoleRule {
  HolePolicy policy = HolePolicy::automatic;
  Length longest = {};

  HoleRule() = default;
  /// Any but HolePolicy::fill, which needs a length.
  HoleRule(HolePolicy any) : policy(any) {}
  static HoleRule fill(const Length& longest);

  static constexpr const char* placeholder = "auto|keep|fill:LENGTH|all";
  static HoleRule parse(const std::string& text);
  std::string text() const;
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
  double min_overlap = 0.01;
  double min_dihedral = 30;
  double min_component_share = 0.001;
  double min_weight_share = 0.1;
  int max_pinhole_edges = 24;
  int max_handle_edges = 3;
  HoleRule holes = {};
  /// The rules of the surface that the mesh stands for. The mesh itself does not depend on them.
  SurfaceRules rules = {};
  std::optional<Vec3> sensor = std::nullopt;
  /// Called from time to time with the faces so far (indices into the input mixture). May be empty.
  std::function<void(std::size_t step, const FaceList& faces)> on_snapshot = nullptr;

  static OptionTable fields() {
    using O = TriangulateOptions;
    return {
        field<&O::min_overlap>("min-overlap", "(0, 1)",
                               "smallest Bhattacharyya coefficient of two Gaussians that may share an edge"),
        field<&O::min_dihedral>("min-dihedral", "[0, 180)",
                                "smallest dihedral angle between neighbouring triangles; 180 is flat")
            .in("degrees"),
        field<&O::min_component_share>("min-component", "[0, 1)",
                                       "drop connected components with less than this share of the total weight"),
        field<&O::min_weight_share>(
            "min-weight", "[0, 1)",
            "leave out Gaussians with less than this share of the median weight of those that "
            "overlap them: outliers and spikes, which bend the surface where a triangle reaches "
            "for them"),
        field<&O::max_pinhole_edges>(
            "max-pinhole", ">= 0", "close boundary loops of at most N edges that the mixture itself bridges; 0 = none"),
        field<&O::max_handle_edges>(
            "max-handle", ">= 0",
            "remove handles that a loop of at most N edges runs around or through, where the "
            "mixture reaches across; three Gaussians that overlap in pairs are a triangle as well "
            "as a tube, a tube of four may be real; below 3 = none"),
        field<&O::holes>(
            "holes", "",
            "boundary loops to fill with new vertices: those that Gaussians reach across (auto), none, also "
            "those no longer than LENGTH (a percentage is of the diagonal of the vertices), or all"),
        field<&O::sensor>("sensor", "",
                          "where the sensor stood, in the coordinates of the input: open surfaces face it; takes "
                          "precedence over sensors and normals of the points")
            .or_else("unknown")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const;
};

/// What was left out of a covariance mesh, and what was done to it.
struct TriangulationStatistics {
  std::size_t light_components = 0;     ///< Gaussians below min_weight_share
  double light_weight = 0;              ///< their weight, in points
  std::size_t leftover_components = 0;  ///< other Gaussians that no face uses
  double leftover_weight = 0;           ///< their weight, in points
  std::size_t dropped_components = 0;   ///< connected components of faces below min_component_share
  double dropped_component_weight = 0;  ///< their weight, in points
  std::size_t split_vertices = 0;       ///< copies in the mesh, made to part fans that touch in a vertex
  std::size_t flipped_edges = 0;        ///< interior edges flipped for a better grade
  std::size_t closed_pinholes = 0;      ///< boundary loops closed because the mixture bridges them
  std::size_t removed_handles = 0;      ///< handles too small for the mixture to tell from none
  std::size_t untangled = 0;            ///< regions where the surface intersected itself that were replaced
  std::size_t filled_holes = 0;         ///< boundary loops closed as `holes` asks
  std::size_t filled_rims = 0;          ///< of these, outer rims of open sheets
  std::size_t filled_vertices = 0;      ///< vertices in the mesh, made for that
  std::size_t flipped_components = 0;   ///< connected components turned over to face outward or the sensor

  /// Calls count(name, value) for each, in the order of reports.
  void each(const auto& count) const {
    count("light_components", light_components);
    count("light_weight", light_weight);
    count("leftover_components", leftover_components);
    count("leftover_weight", leftover_weight);
    count("dropped_components", dropped_components);
    count("dropped_component_weight", dropped_component_weight);
    count("split_vertices", split_vertices);
    count("flipped_edges", flipped_edges);
    count("closed_pinholes", closed_pinholes);
    count("removed_handles", removed_handles);
    count("untangled", untangled);
    count("filled_holes", filled_holes);
    count("filled_rims", filled_rims);
    count("filled_vertices", filled_vertices);
    count("flipped_components", flipped_components);
  }
};

/// A covariance mesh and how it came about.
struct Triangulation : TriangulationStatistics {
  CovMesh mesh = {};
  Connectivity connectivity = {};               ///< of the mesh
  std::vector<Index> component_of_vertex = {};  ///< per mesh vertex: the component of the input mixture it came from,
                                                ///< or no_index if it was made to fill a hole
  std::vector<LoopReason> loop_reasons = {};    ///< of the loops that boundary_loops() finds in the mesh, in its order
  std::size_t turned_triangles = 0;             ///< of patches that had grown inside out
};

/// Connects the components of a mixture to a manifold, oriented triangle mesh: a greedy front over the graph of pairs
/// with sufficient Bhattacharyya overlap, graded by overlap and flatness (Preiner et al. 2019, section 6.2, Eq. 18-22).
/// Closed components face outward, those inside an odd number of others inward. The vertices are as_stored(). O(n k log
/// n) for n components of k overlapping neighbours. Throws OptionError, NoSurfaceError if no triangle can be made,
/// Cancelled.
Triangulation triangulate(const Mixture& mixture, const TriangulateOptions& options = {},
                          const RunContext& context = {});

}  // namespace gpsrecon
