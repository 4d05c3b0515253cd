#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <array>
#include <functional>
#include <span>
#include <string_view>

namespace gpsrecon {

/// Gaussians whose sum stands for α(r) = θ(r)/r in the attraction.
enum class KernelCoefficients {
  published,  ///< Preiner et al. 2014, Figure 5: exact near the particle, its tail too light (-44 % at 0.3)
  tail,       ///< within 5 % of α from 0.08 to 0.4 (-9 to +18 % from 0.015 on), -28 % at 0.01
};
constexpr std::array<std::string_view, 2> option_names(KernelCoefficients /*type*/) {
  return {"published", "tail"};
}

/// What a projection did in one iteration.
struct ProjectionProgress {
  int iteration;                    ///< 1 for the first
  std::span<const Vec3> positions;  ///< of the particles after it
  std::span<const Vec3> repulsion;  ///< F2 of every particle as it was used; zeros in the first iteration
  double largest_move;              ///< of a particle in it, units of the positions
};

/// How particles are projected.
struct ProjectOptions {
  /// Support radius h of the kernels in units of the positions: θ falls to e^-16 there. Detail much smaller than h/4 is
  /// smoothed, noise much larger is not removed. Must be given; automatic_support_radius() is one.
  double support_radius = 0;
  int iterations = 15;
  double repulsion = 0.4;
  double repulsion_cutoff = 0.5;
  int repulsion_interval = 2;
  double convergence = 1e-3;
  KernelCoefficients kernel = KernelCoefficients::published;
  /// Of points: divide their weights by the density around them (WLOP), so that dense areas do not dominate; without,
  /// it is LOP. For mixtures that is a property of the mixture (HemOptions::balance).
  bool balance = true;
  /// Called after every iteration. May be empty.
  std::function<void(const ProjectionProgress&)> on_iteration = nullptr;

  static OptionTable fields() {
    using O = ProjectOptions;
    return {field<&O::iterations>("iterations", "[1, 1000]",
                                  "iterations, at most; the first goes to the local mean, all others towards the local "
                                  "median"),
            field<&O::convergence>("convergence", ">= 0",
                                   "stop when no particle moves farther than X support radii; 0 = never"),
            field<&O::repulsion>("repulsion", "[0, 0.5)", "strength of the repulsion among particles"),
            field<&O::repulsion_cutoff>("repulsion-cutoff", "(0, 1]",
                                        "particles farther apart than X support radii do not repel each other"),
            field<&O::repulsion_interval>("repulsion-interval", ">= 1",
                                          "recompute the repulsion in every N-th iteration, and in the last"),
            field<&O::kernel>("kernel", "",
                              "Gaussians that stand for the kernel when particles are drawn to a mixture: close to it "
                              "near the particle, or farther out")};
  }
  /// Throws OptionError naming option, range and value.
  void check() const { check_fields(*this); }
};

/// Support radius for points of this spacing and noise (core/scale.h): wide enough to hold the points that tell where
/// the surface is, and to bridge its noise.
double automatic_support_radius(double spacing, double noise);

/// Continuous locally optimal projection, CLOP: draws particles to local L1 medians of the density of a mixture, in
/// closed form, while they repel each other. Preiner et al. 2014, sections 6-8, Eq. 3, 5, 18-24; α̂ (kernel.h) defines
/// the operator. Particles and mixture must be in one frame. Attributes of the particles stay with them. Particles that
/// coincide are first moved apart by h/100 in random directions; one that no component reaches stays where it is. There
/// may be more particles than points. Independent of the thread count to the last bit, and of units.
/// O(n (log m + k)) per iteration for n particles within reach of k of m components.
/// Throws OptionError, InvariantError if the frames differ or a position is not finite, Cancelled.
PointCloud project(const PointCloud& particles, const Mixture& mixture, const ProjectOptions& options,
                   const RunContext& context = {});

/// The same towards the medians of points: WLOP (Huang et al. 2009), or without `balance` LOP (Lipman et al. 2007).
/// Preiner et al. 2014, Eq. 2-6, 25. Weights of the points count.
PointCloud project(const PointCloud& particles, const PointCloud& points, const ProjectOptions& options,
                   const RunContext& context = {});

}  // namespace gpsrecon
