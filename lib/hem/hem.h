#pragma once

#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/core/point_cloud.h>
#include <gpsrecon/core/prepared_cloud.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/core/scale.h>
#include <array>
#include <functional>
#include <string_view>

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

/// As options spell them.
constexpr std::array<std::string_view, 2> option_names(InitialCovariance /*type*/) {
  return {"isotropic", "local"};
}

/// How build_mixture reduces points to Gaussians.
struct HemOptions {
  Length sigma0 = {};
  double detail = 1;
  Length spacing = {};
  double alpha = 2;
  double parent_probability = 1.0 / 3;
  double min_reduction = 0.025;
  int max_levels = 0;
  int flat_levels = 4;
  double flat_alpha = 2.5;
  std::size_t target_components = 0;
  InitialCovariance initial = InitialCovariance::local;
  int neighbors = 16;
  bool balance = false;
  bool normals = false;
  /// Called after every level, level 0 included, with the level's mixture. May be empty.
  std::function<void(int level, const Mixture& mixture)> on_level = nullptr;

  static OptionTable fields() {
    using O = HemOptions;
    return {
        field<&O::sigma0>(
            "sigma0", "> 0",
            "standard deviation of the kernel each point is given, the bandwidth of the density estimate: "
            "it decides compression and smoothness; auto = from sample spacing and noise"),
        field<&O::detail>(
            "detail", "(0, 100]",
            "divide the automatic kernel width by X: above 1 more detail, below 1 smoother; clamped, with "
            "a warning, where the surface would fall apart"),
        field<&O::spacing>("spacing", "> 0", "sample spacing, for --initial local; auto = estimated").only_in_library(),
        field<&O::alpha>("alpha", "(0, 10]",
                         "how unlike Gaussians may be that merge: Kullback-Leibler divergence at most X^2/2"),
        field<&O::parent_probability>("parent-probability", "(0, 1)",
                                      "share of the Gaussians of a level that become parents of the next")
            .only_in_library(),
        field<&O::min_reduction>("min-reduction", "[0, 1)",
                                 "stop when a level removes less than this share of the Gaussians")
            .only_in_library(),
        field<&O::max_levels>("hem-levels", ">= 0",
                              "largest number of reduction levels; 0 = until a level hardly reduces"),
        field<&O::flat_levels>("flat-levels", ">= 0",
                               "levels after those, at most, that merge only within flat regions, as far as a tenth of "
                               "the smallest variance of the parent: fewer vertices where nothing is lost by it"),
        field<&O::flat_alpha>("flat-alpha", "(0, 10]", "--alpha of those levels"),
        field<&O::target_components>("target", ">= 0",
                                     "wanted number of Gaussians, hit within 2 % where the levels can reach it; 0 = as "
                                     "the levels end"),
        field<&O::initial>("initial", "",
                           "Gaussian each point starts as: a ball, or the covariance of its neighbours scaled to the "
                           "sample spacing"),
        field<&O::neighbors>("neighbors", "[4, 1000]",
                             "points, itself included, for the covariance of a point and for normals of clouds without")
            .only_in_library(),
        field<&O::balance>(
            "balance", "",
            "weight points by the inverse of the local density (Preiner et al. 2014, Eq. 25-26), so that "
            "dense areas do not dominate; the sum stays"),
        field<&O::normals>(
            "normals", "",
            "give each Gaussian a mean normal and its variance (Preiner et al. 2014, Eq. 29-30), from the "
            "normals of the points or, without, from planes through their neighbours")};
  }
  /// Throws OptionError naming option, range and value, or two that contradict each other.
  void check() const;
};

/// The kernel that each point was given. Lengths in scene units.
struct KernelStatistics {
  double spacing = 0;  ///< A, side of the area per point
  double noise = 0;    ///< ν, standard deviation across the surface
  double sigma0 = 0;   ///< standard deviation of the kernel
  std::string choice;  ///< how sigma0 was chosen, in words
};

struct MixtureStatistics {
  std::vector<std::size_t> levels = {};  ///< components per level, level 0 first
  std::size_t components = 0;
  double weight = 0;  ///< sum of the weights: input points represented

  /// Calls count(name, value) for each, in the order of reports.
  void each(const auto& count) const {
    count("levels", levels);
    count("components", components);
    count("weight", weight);
  }
};

/// A mixture and how it came about.
struct MixtureResult {
  Mixture mixture;
  KernelStatistics kernel;
  MixtureStatistics statistics;
};

/// Regularised hierarchical expectation maximisation: reduces the points (one Gaussian each) level by level to a
/// mixture of anisotropic Gaussians. Preiner et al. 2014, sections 5 and 9.2, Algorithm 1; Preiner et al. 2019,
/// appendix A. The total weight is conserved to 1e-12, the mean and covariance of the whole too while the eigenvalue
/// floor (1e-6 λmax) is inactive. Colours and scalars of the points are carried: each component has the mean, or for
/// labels the majority, of the points that followed the largest responsibility into it, level by level. Independent of
/// the thread count to the last bit, and of units. Shares of the diagonal are of that of `cloud`. O(n log n). Throws
/// OptionError, NoSurfaceError for an empty cloud, Cancelled.
Mixture build_mixture(const PointCloud& cloud, const HemOptions& options = {}, const RunContext& context = {});

/// The same of a prepared cloud, with its scale and index; lengths in options refer to these. The mixture is
/// as_stored().
MixtureResult build_mixture(const PreparedCloud& cloud, const HemOptions& options = {}, const RunContext& context = {});

}  // namespace gpsrecon
