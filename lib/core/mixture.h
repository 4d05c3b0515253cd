#pragma once

#include <gpsrecon/core/frame.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/sym3.h>
#include <vector>

namespace gpsrecon {

/// A 3-D normal distribution.
struct Gaussian {
  Vec3 mean = Vec3::Zero();
  Sym3 covariance = Sym3::identity();
};

/// A Gaussian mixture in which each component s stands for `weights[s]` input points. Optional per-component
/// distributions of the surface normal are wrapped normals (Preiner et al. 2014, section 9.2): a unit axis and the
/// total angular variance in rad² around it.
struct Mixture {
  std::vector<Vec3> means;
  std::vector<Sym3> covariances;
  std::vector<double> weights;
  std::vector<Vec3> normals;             ///< empty, or unit mean normal axes (sign arbitrary)
  std::vector<double> normal_variances;  ///< empty, or as long as `normals`; >= 0
  std::vector<double> kernels;           ///< empty if all points had the kernel sigma0, or its root mean square
  std::vector<Vec3> outward;             ///< empty, or the mean of unit vectors to where its points were seen from
  std::vector<Color> colors;             ///< empty, or the mean colour of the points each component stands for
  std::vector<ScalarColumn> scalars;     ///< likewise for scalars: their mean, or the label most of the weight has
  double sigma0 = 0;   ///< standard deviation of the kernel points were given, usually; 0 if unknown; in local units
  double spacing = 0;  ///< side A of the area per point of the cloud, in local units; 0 if unknown
  Frame frame;         ///< the frame of means, covariances, sigma0 and spacing

  std::size_t size() const { return means.size(); }
  bool empty() const { return means.empty(); }
  /// Standard deviation of the kernel in component s; 0 if unknown.
  double kernel(std::size_t s) const { return kernels.empty() ? sigma0 : kernels[s]; }
  Gaussian component(std::size_t s) const { return {means[s], covariances[s]}; }
};

/// Smallest allowed ratio of smallest to largest eigenvalue of a covariance.
inline constexpr double min_eigenvalue_ratio = 1e-12;

/// Throws InvariantError, naming the component, unless all attributes have the same length, all numbers are finite,
/// weights are positive and every covariance has λmin >= 1e-12 λmax > 0. O(n).
void validate(const Mixture& mixture);

/// The mixture as a file of it would give it back (io/io.h): means rounded as world coordinates are, columns with names
/// that a file can hold. Stages return their results so, and compute the same bits whether they are handed over in
/// memory or through files.
Mixture as_stored(const Mixture& mixture);

/// The components `keep` in the given order, with all their attributes.
Mixture select(const Mixture& mixture, const std::vector<Index>& keep);

/// Appends a copy of component s with all its attributes; returns its index.
Index append_copy(Mixture& mixture, Index s);

}  // namespace gpsrecon
