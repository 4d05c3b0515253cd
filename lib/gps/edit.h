#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>
#include <variant>

namespace gpsrecon {

// Which vertices an operation applies to. Positions are world coordinates of the means; what lies on the border counts.

struct SelectAll {};

struct SelectIndices {
  struct Range {
    Index first, last;  ///< both included; first <= last < number of vertices
  };
  std::vector<Range> ranges;  ///< not empty; in any order, and they may overlap
};

struct SelectBox {
  Vec3 low, high;  ///< opposite corners; low <= high in every axis
};

/// The side of a plane to which its normal points.
struct SelectHalfSpace {
  Vec3 point, normal;  ///< normal: any length but 0
};

struct SelectNearest {
  Vec3 point;
  std::size_t count = 1;  ///< that many vertices, nearest first, of equally near ones the lower index; range: [1,
                          ///< number of vertices]
};

using VertexSelection = std::variant<SelectAll, SelectIndices, SelectBox, SelectHalfSpace, SelectNearest>;

// What happens to the covariance Σ of a selected vertex. Lengths are in world units, variances in their squares.

/// Σ ← factor Σ. Smaller Gaussians draw the surface to their mean, larger ones let it go.
struct ScaleCovariance {
  double factor = 1;  ///< range: [1e-12, 1e12]
};

enum class Axis { smallest, middle, largest, given };

/// Multiplies the variance along an axis a: Σ ← M Σ M with M = I + (sqrt(factor) - 1) a aᵀ, so that aᵀΣa ← factor aᵀΣa.
/// If a is an eigenvector, its eigenvalue alone changes. Below one this flattens, which sharpens the surface across a.
struct FlattenCovariance {
  Axis axis = Axis::smallest;      ///< an eigenvector, by its eigenvalue, or `direction`
  Vec3 direction = Vec3::UnitZ();  ///< of Axis::given; any length but 0
  double factor = 0.01;            ///< of the variance; range: [1e-12, 1e12]
};

/// Convolution with a Gaussian: Σ ← Σ + kernel. Smooths.
struct SmoothCovariance {
  Sym3 kernel;  ///< finite, positive semidefinite
};

/// The opposite: Σ ← Σ - kernel, with eigenvalues raised to at least floor times the largest eigenvalue of the Σ
/// before.
struct SharpenCovariance {
  Sym3 kernel;          ///< finite, positive semidefinite
  double floor = 1e-6;  ///< range: [1e-12, 1]
};

/// Σ ← covariance.
struct SetCovariance {
  Sym3 covariance = Sym3::identity();  ///< finite, λmin >= 1e-12 λmax > 0
};

using CovarianceOperation =
    std::variant<ScaleCovariance, FlattenCovariance, SmoothCovariance, SharpenCovariance, SetCovariance>;

struct EditStep {
  VertexSelection selection = SelectAll{};
  CovarianceOperation operation;

  /// Throws OptionError naming operation or selection, field and value. What depends on the mesh is checked by edit().
  void check() const;
};

/// What one step did.
struct EditCounts {
  std::size_t selected = 0;        ///< vertices it applied to, at least one
  std::size_t floored = 0;         ///< of these, covariances whose eigenvalues had to be raised to a floor
  std::size_t ambiguous_axes = 0;  ///< of these, covariances whose chosen axis is one of several: two eigenvalues agree
                                   ///< to 1e-9
};

struct Edit {
  CovMesh mesh;
  std::vector<EditCounts> steps;  ///< one per step
};

/// Modelling with covariances (Preiner et al. 2019, sections 5 and 7.1): applies the steps to the covariances, one
/// after the other. Everything else stays, and the result is a valid covariance mesh: eigenvalues are raised to 1e-12
/// times the largest of their matrix. Throws OptionError, naming the step by its number from one, for steps that fail
/// their check(), select no vertex or one that is not there, or lead out of the range of numbers; InvariantError if the
/// mesh is not a valid covariance mesh. O(number of steps times vertices).
Edit edit(CovMesh mesh, const std::vector<EditStep>& steps, const RunContext& context = {});

/// The indices of the vertices selected, in ascending order (SelectNearest too), each once. Throws OptionError as
/// edit() does.
std::vector<Index> selected_vertices(const Mixture& vertices, const VertexSelection& selection);

}  // namespace gpsrecon
