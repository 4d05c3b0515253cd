#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/hem/scale.h>
#include <functional>

namespace gpsrecon {

/// The Gaussian each point starts as.
enum class InitialCovariance {
  isotropic,  ///< σ0² I
  /// (A/√λmax)² · covariance of the neighbours + σ0² I; A is the spacing of the cloud, up to three times that where the
  /// neighbours are clearly sparser
  local,
};

/// The kernel width that suits the Gaussians points start as, of those an estimated scale has (scale.h).
double automatic_sigma0(const Scale& scale, InitialCovariance initial);

/// How build_mixture reduces points to Gaussians.
struct HemOptions {
  /// Standard deviation of the kernel each point is given, in the units of the positions. It is the bandwidth of the
  /// density estimate, so it decides compression and smoothness. Range: > 0; 0 = from spacing and noise (scale.h).
  double sigma0 = 0;
  /// Sample spacing A in the units of the positions, for `InitialCovariance::local`. Range: > 0; 0 = estimated.
  double spacing = 0;
  /// How unlike components may be that merge: Kullback-Leibler divergence at most alpha²/2. Range: (0, 10].
  double alpha = 2;
  /// Share of the components of a level that become parents of the next. Range: (0, 1).
  double parent_probability = 1.0 / 3;
  /// Stop when a level removes less than this share of the components. Range: [0, 1).
  double min_reduction = 0.025;
  /// Largest number of levels. Range: >= 0; 0 = until the stop rule.
  int max_levels = 0;
  /// Levels after those, at most, that merge only within flat regions: a child's mean lies off the plane of its parent,
  /// and its thickness exceeds the parent's, by at most a tenth of the parent's smallest eigenvalue (squared distance,
  /// variance). Thins out what is smooth and leaves detail alone, and pieces of three components or fewer, too. None if
  /// the wanted number is reached before. Range: >= 0.
  int flat_levels = 0;
  /// `alpha` of those levels. Range: (0, 10].
  double flat_alpha = 2.5;
  /// Wanted number of components, hit within 2 % where the levels can reach it. Range: >= 0; 0 = as the levels end.
  std::size_t target_components = 0;
  InitialCovariance initial = InitialCovariance::isotropic;
  /// Neighbours (the point included) for local covariances and for the normals of clouds without. Range: [4, 1000].
  int neighbors = 16;
  /// Weight points by the inverse of the local density, so that dense areas do not dominate (WLOP balance,
  /// Preiner et al. 2014, Eq. 25-26). The weights are renormalised to the number of points.
  bool balance = false;
  /// Carry a wrapped normal per component (Preiner et al. 2014, Eq. 29-30), from the cloud's normals or, where it has
  /// none of finite positive length, from principal component analysis.
  bool normals = false;
  /// Called after every level, level 0 included, with the level's mixture. May be empty.
  std::function<void(int level, const Mixture& mixture)> on_level = nullptr;

  /// Throws OptionError naming the field and the value.
  void check() const;
};

/// Regularised hierarchical expectation maximisation: reduces the points (one Gaussian each) level by level to a
/// mixture of anisotropic Gaussians. Preiner et al. 2014, sections 5 and 9.2, Algorithm 1; Preiner et al. 2019,
/// appendix A. The total weight is conserved to 1e-12, the mean and covariance of the whole too while the eigenvalue
/// floor (1e-6 λmax) is inactive. Colours and scalars of the points are carried: each component has the mean, or for
/// labels the majority, of the points that followed the largest responsibility into it, level by level. Independent of
/// the thread count to the last bit, and of units. O(n log n). Throws OptionError, NoSurfaceError for an empty cloud,
/// Cancelled.
Mixture build_mixture(const PointCloud& cloud, const HemOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
