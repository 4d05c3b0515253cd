#pragma once

#include <gpsrecon/core/connectivity.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/prepared_cloud.h>
#include <gpsrecon/core/run_context.h>

namespace gpsrecon {

struct FitOptions {
  int steps = 4;
  int refinements = 2;
  std::size_t max_vertices = 0;
  int level = 2;

  static OptionTable fields() {
    using O = FitOptions;
    return {
        field<&O::steps>("fit-steps", "[0, 100]",
                         "Gauss-Newton steps that move the surface through the points, at most, per round; 0 = no fit"),
        field<&O::refinements>("refinements", "[0, 10]",
                               "rounds, at most, that split control edges where the points show detail that the "
                               "control mesh is too coarse for, and fit again"),
        field<&O::max_vertices>("max-vertices", ">= 0",
                                "vertices those rounds may lead to, at most; edges with the strongest evidence are "
                                "split first; 0 = no limit"),
        field<&O::level>("fit-level", "[1, 5]", "refinement level at which the surface is sampled").only_in_library()};
  }
  /// Throws OptionError naming option, range and value.
  void check() const { check_fields(*this); }
};

/// What a fit did. Lengths in scene units.
struct FitStatistics {
  int steps = 0;                       ///< taken, over all rounds
  int refinements = 0;                 ///< rounds of refinement that were kept
  std::size_t added_vertices = 0;      ///< by refinement
  std::size_t restrained_faces = 0;    ///< faces turned too far or cutting others by a step; their vertices moved less
  double mean_shift = 0;               ///< of the control vertices there were before
  double max_shift = 0;                ///< likewise
  std::size_t held_out_points = 0;     ///< that only judged; 0 if there were too few points
  double held_out_before = 0;          ///< median distance of those from the tangent plane closest to them, before the
  double held_out_after = 0;           ///< fit and after it
  std::size_t flipped_components = 0;  ///< open components turned over to where the points were seen from

  /// Calls count(name, value) or length(name, value) for each, in the order of reports, where components that were
  /// turned over are counted with those of the triangulation.
  void each(const auto& count, const auto& length) const {
    count("steps", steps);
    count("refinements", refinements);
    count("added_vertices", added_vertices);
    count("restrained_faces", restrained_faces);
    length("mean_shift", mean_shift);
    length("max_shift", max_shift);
    count("held_out_points", held_out_points);
    length("held_out_before", held_out_before);
    length("held_out_after", held_out_after);
  }
};

/// A fitted mesh and how it came about.
struct Fit : FitStatistics {
  CovMesh mesh = {};
  Connectivity connectivity = {};  ///< of the mesh
};

/// Moves the means of a triangular covariance mesh so that its limit surface S(u) = Σ_i W_i(u) μ_i, by the rules of the
/// mesh, runs through the points, and refines it where they show detail: robust least squares of the normal offsets of
/// the points from the samples of the surface closest to them (Tukey's biweight, scale from the points around each
/// control vertex), linear in moves of the means along the normals, by conjugate gradients. A mean's own position
/// counts as one point, its neighbours' moves as three, the less the more significant a move is. No mean leaves its
/// Gaussian by more than three standard deviations, no step turns a face by more than 60 degrees, and moves that make
/// the control mesh intersect itself are taken back. Steps end when the points come no closer. A sixteenth of them is
/// held out: a refinement is undone that takes the surface significantly away from those. It is guided by Loop's
/// surface in any case; with Scheme::catmull_clark the last steps, as many as a round has, move the other one. Vertices
/// on the rim of an open surface also move outward, to where the points end (if `mesh.vertices.spacing` is known). New
/// vertices have the Gaussians of a Loop step and a share of the weight of their edge's ends. A cloud in another frame
/// is carried over to that of the mesh; the vertices are as_stored(). O(n log m) for n points and m samples. Throws
/// OptionError, InvariantError, Cancelled.
Fit fit(ConnectedMesh mesh, const PointCloud& cloud, const FitOptions& options = {}, const RunContext& context = {});

/// The same, and before it open components are turned to where the points of the cloud were seen from, or to the side
/// of their normals, if they tell.
Fit fit(ConnectedMesh mesh, const PreparedCloud& cloud, const FitOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
