#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <array>
#include <span>
#include <string_view>
#include <vector>

// Normal axes of a surface of which there are points, or a mixture: by principal component analysis (Hoppe et al.
// 1992), as spherical medians of the axes of the points around (Preiner et al. 2014, section 9.1), and the same on a
// mixture (section 9.3). All results are unit vectors whose sign means nothing; orientation.h gives it a meaning. All
// are equivariant to rigid motions and scaling, independent of the signs of the axes that come in, and of the thread
// count to the last bit. Searches go faster when consecutive queries are close in space.

namespace gpsrecon {

/// Which of the functions below.
enum class NormalMethod {
  pca,        ///< of the nearest points
  weiszfeld,  ///< spherical median of their normals
  csw,        ///< continuous spherical Weiszfeld, on a mixture
};

constexpr std::array<std::string_view, 3> option_names(NormalMethod /*type*/) {
  return {"pca", "weiszfeld", "csw"};
}

struct NormalOptions {
  int neighbors = 0;
  /// Support radius h of the kernel θ(r) = exp(-r²/(h/4)²) in which medians are sought, in the units of the positions.
  /// Range: (0, 1e100]; 0 = automatic.
  double h = 0;
  int iterations = 30;
  double convergence = 1e-4;

  static OptionTable fields() {
    using O = NormalOptions;
    return {field<&O::neighbors>("neighbors", "[3, 1000] or 0",
                                 "points a plane is put through; 0 = automatic: 12, more where noise asks for it"),
            field<&O::iterations>("iterations", "[0, 1000]",
                                  "Weiszfeld iterations, steps towards the median, at most; without any, the result is "
                                  "the axis of least summed squared sines"),
            field<&O::convergence>("convergence", ">= 0", "stop when a normal turns by less than X").in("radians")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const;
};

/// What automatic options become for these points: 12 neighbours, or as many as let noise turn the plane through them
/// by 0.04 rad, up to 100; and the h whose kernel is as wide as they are spread where their density is the median.
/// Lengths in the units of the points. O(n log n). Throws NoSurfaceError for fewer than three points.
NormalOptions resolve(NormalOptions options, std::span<const Vec3> points, const RunContext& context = {});

/// The direction in which the nearest points vary least. Where they lie in a line (their second deviation below a tenth
/// of the first) twice as many are taken, up to eight times; what still is a line has some normal across it. With fewer
/// points than neighbours all count. O((n + m) log n + m k) for n points, m queries and k neighbours.
/// Throws OptionError; NoSurfaceError for fewer than three points, or if all of them lie on a line; InvariantError for
/// a query that is not finite; Cancelled.
std::vector<Vec3> pca_normals(std::span<const Vec3> queries, std::span<const Vec3> points,
                              const NormalOptions& options = {}, const RunContext& context = {});

/// Spherical median of the normal axes m_j of the points around each query, which minimises Σ_j w_j θ(|p_j - q|) d(m_j,
/// n) over the angles d between axes, by Weiszfeld iterations in the tangent plane of n (Eq. 27 averages the m_j
/// themselves instead, and comes to rest where Σ_j w_j θ_j sin(d_j)/d_j u_j vanishes, u_j the directions towards them,
/// which is beside the median). Starts from the axis of least summed squared sines. `cloud` must have normals; those of
/// length zero do not count. Automatic h is that of resolve(), but narrower where points are denser. A query with no
/// points within h has the normal of the nearest point. O((n + m) log n + m b i) for b points within h and i
/// iterations. Throws OptionError; InputError if the cloud has no points or normals; NoSurfaceError for fewer than
/// three points without h; InvariantError for a query that is not finite; Cancelled.
std::vector<Vec3> weiszfeld_normals(std::span<const Vec3> queries, const PointCloud& cloud,
                                    const NormalOptions& options = {}, const RunContext& context = {});

/// The same on a mixture with normals: continuous spherical Weiszfeld (CSW), Eq. 31-34 with d = 2, h = π and three
/// Gaussians for the kernel 1/d, on wrapped normals of half the total variance (Eq. 30) per axis, each weighted by
/// g(μ_s | q, Σ_s + h²/32) (Eq. 24), which the print leaves out. Automatic h: from the extent of the Gaussians. Those
/// count whose ellipsoid of Σ_s + h²/32 reaches the query at a weight of exp(-16), where θ(h) is. A query out of the
/// reach of all has the normal of the nearest. O((n + m) log n + m b i) for n Gaussians, b of them in reach.
/// Throws OptionError; InputError if the mixture has no components or normals; InvariantError for a query that is not
/// finite; Cancelled.
std::vector<Vec3> csw_normals(std::span<const Vec3> queries, const Mixture& mixture, const NormalOptions& options = {},
                              const RunContext& context = {});

}  // namespace gpsrecon
