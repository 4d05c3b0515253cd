#pragma once

#include <gpsrecon/clop/kernel.h>
#include <gpsrecon/core/mixture.h>
#include <gpsrecon/core/neighbors.h>
#include <gpsrecon/core/run_context.h>
#include <optional>
#include <span>
#include <vector>

// Internal to lib/clop: what draws the particles.

namespace gpsrecon::internal {

/// The first iteration of a projection goes to the local mean, the others towards the local median.
enum class ProjectionStep { mean, median };

/// The attraction F1 of Preiner et al. 2014.
class Attraction {
 public:
  virtual ~Attraction() = default;
  /// pulls[i] = F1(q_i) - q_i; nothing if nothing is in reach of q_i. Of as many particles, preferably close to each
  /// other. `near` is scratch space.
  virtual void pull(std::span<const Vec3> particles, ProjectionStep step, std::vector<Neighbor>& near,
                    std::span<std::optional<Vec3>> pulls) const = 0;
};

/// Of points, LOP and WLOP: Eq. 2 and 4, or with weights 1/v_j Eq. 25. Distances in α count as at least 0.0072 h, where
/// the kernel of the mixtures levels off too: a particle on a point is not caught by it.
class PointAttraction final : public Attraction {
 public:
  /// `balance` divides the weight of every point by the density v_j of the points around it.
  PointAttraction(const PointCloud& points, double support_radius, bool balance, const RunContext& context);
  void pull(std::span<const Vec3> particles, ProjectionStep step, std::vector<Neighbor>& near,
            std::span<std::optional<Vec3>> pulls) const override;

 private:
  const std::vector<Vec3>& points_;
  double h_;
  Neighbors index_;
  std::vector<double> weights_;
};

/// Of a mixture, CLOP: Eq. 19-24. A component counts where its ellipsoid reaches the ball of radius h around the
/// particle, and farther out where it still has more than e^-10 of its largest weight.
class MixtureAttraction final : public Attraction {
 public:
  MixtureAttraction(const Mixture& mixture, double support_radius, const KernelFit& kernel, const RunContext& context);
  void pull(std::span<const Vec3> particles, ProjectionStep step, std::vector<Neighbor>& near,
            std::span<std::optional<Vec3>> pulls) const override;

 private:
  /// The product of one Gaussian of the kernel with one of the mixture, which depends on the particle by its position
  /// only.
  struct Product {
    Sym3 gain;      ///< σ_k² h² Λ_sk⁻¹: times μ_s - q it is the step to the mean of the product, Eq. 21
    double weight;  ///< ω_sk at q = μ_s, up to a common factor, Eq. 19
  };
  template <std::size_t K>
  using Products = std::array<Product, K>;
  struct Center {
    Vec3 mean;
    double squared_reach;
  };
  /// Components of similar extent, and so of similar reach.
  struct Group {
    double reach;  ///< the largest
    std::vector<Center> centers;
    std::vector<Products<3>> median;
    std::vector<Products<1>> mean;
    Neighbors index;
  };
  template <std::size_t K>
  struct Pull;
  template <std::size_t K>
  void pull(std::span<const Vec3> particles, const std::array<double, K>& half_precision,
            std::vector<Products<K>> Group::*products, std::vector<Neighbor>& near,
            std::span<std::optional<Vec3>> pulls) const;

  double h_;
  std::array<double, 3> half_precision_;       ///< 1/(2 σ_k² h²) of the kernel α̂
  std::array<double, 1> mean_half_precision_;  ///< of θ
  std::vector<Group> groups_;
};

}  // namespace gpsrecon::internal
