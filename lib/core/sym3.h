#pragma once

#include <gpsrecon/core/vec.h>
#include <array>
#include <cmath>

namespace gpsrecon {

/// Symmetric 3x3 matrix, stored as its upper triangle row by row: (xx, xy, xz, yy, yz, zz). This is also the order of
/// the half-vectorisation vech (lower triangle, column by column) and of the columns in files. All 3x3 algebra of the
/// library is here.
struct Sym3 {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  static Sym3 identity(double s = 1) { return {s, 0, 0, s, 0, s}; }
  static Sym3 diagonal(double x, double y, double z) { return {x, 0, 0, y, 0, z}; }
  /// v vᵀ
  static Sym3 outer(const Vec3& v) {
    return {v.x() * v.x(), v.x() * v.y(), v.x() * v.z(), v.y() * v.y(), v.y() * v.z(), v.z() * v.z()};
  }
  /// The symmetric part of m.
  static Sym3 from_matrix(const Mat3& m) {
    return {m(0, 0), 0.5 * (m(0, 1) + m(1, 0)), 0.5 * (m(0, 2) + m(2, 0)), m(1, 1), 0.5 * (m(1, 2) + m(2, 1)), m(2, 2)};
  }
  Mat3 matrix() const {
    Mat3 m;
    m << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    return m;
  }

  Sym3& operator+=(const Sym3& b) {
    xx += b.xx, xy += b.xy, xz += b.xz, yy += b.yy, yz += b.yz, zz += b.zz;
    return *this;
  }
  Sym3& operator-=(const Sym3& b) {
    xx -= b.xx, xy -= b.xy, xz -= b.xz, yy -= b.yy, yz -= b.yz, zz -= b.zz;
    return *this;
  }
  Sym3& operator*=(double s) {
    xx *= s, xy *= s, xz *= s, yy *= s, yz *= s, zz *= s;
    return *this;
  }
  friend Sym3 operator+(Sym3 a, const Sym3& b) { return a += b; }
  friend Sym3 operator-(Sym3 a, const Sym3& b) { return a -= b; }
  friend Sym3 operator*(Sym3 a, double s) { return a *= s; }
  friend Sym3 operator*(double s, Sym3 a) { return a *= s; }
  friend bool operator==(const Sym3&, const Sym3&) = default;

  Vec3 operator*(const Vec3& v) const {
    return {xx * v.x() + xy * v.y() + xz * v.z(), xy * v.x() + yy * v.y() + yz * v.z(),
            xz * v.x() + yz * v.y() + zz * v.z()};
  }
  double trace() const { return xx + yy + zz; }
  double determinant() const { return xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz); }
  /// vᵀ A v
  double quadratic_form(const Vec3& v) const { return v.dot(*this * v); }
  bool all_finite() const { return std::isfinite(xx + xy + xz + yy + yz + zz); }
};

/// tr(A B)
inline double trace_of_product(const Sym3& a, const Sym3& b) {
  return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + 2 * (a.xy * b.xy + a.xz * b.xz + a.yz * b.yz);
}

/// M A Mᵀ
inline Sym3 congruence(const Mat3& m, const Sym3& a) {
  return Sym3::from_matrix(m * a.matrix() * m.transpose());
}

/// Lower-triangular factor of a positive definite matrix, A = L Lᵀ.
struct Cholesky3 {
  double l00, l10, l11, l20, l21, l22;

  /// Precondition: a is positive definite; otherwise the factor holds NaN, which `valid` tells.
  explicit Cholesky3(const Sym3& a);
  bool valid() const { return std::isfinite(l00 + l11 + l22) && l00 > 0 && l11 > 0 && l22 > 0; }
  /// ln det A
  double log_determinant() const { return 2 * std::log(l00 * l11 * l22); }
  /// L⁻¹ v; its squared norm is the squared Mahalanobis length of v.
  Vec3 solve_lower(const Vec3& v) const {
    const double x = v.x() / l00;
    const double y = (v.y() - l10 * x) / l11;
    return {x, y, (v.z() - l20 * x - l21 * y) / l22};
  }
  /// A⁻¹ v, backward stable: the way to apply the inverse of an ill-conditioned matrix.
  Vec3 solve(const Vec3& v) const {
    const Vec3 y = solve_lower(v);
    const double z = y.z() / l22;
    const double x1 = (y.y() - l21 * z) / l11;
    return {(y.x() - l10 * x1 - l20 * z) / l00, x1, z};
  }
  /// A⁻¹
  Sym3 inverse() const;
};

inline Cholesky3::Cholesky3(const Sym3& a) {
  l00 = std::sqrt(a.xx);
  l10 = a.xy / l00;
  l20 = a.xz / l00;
  l11 = std::sqrt(a.yy - l10 * l10);
  l21 = (a.yz - l20 * l10) / l11;
  l22 = std::sqrt(a.zz - l20 * l20 - l21 * l21);
}

inline Sym3 Cholesky3::inverse() const {
  const double i00 = 1 / l00, i11 = 1 / l11, i22 = 1 / l22;
  const double i10 = -l10 * i00 * i11;
  const double i21 = -l21 * i11 * i22;
  const double i20 = (l10 * l21 - l20 * l11) * i00 * i11 * i22;
  return {
      i00 * i00 + i10 * i10 + i20 * i20, i10 * i11 + i20 * i21, i20 * i22, i11 * i11 + i21 * i21, i21 * i22, i22 * i22};
}

/// Inverse of an invertible symmetric matrix by cofactors (need not be definite).
inline Sym3 inverse(const Sym3& a) {
  const double c00 = a.yy * a.zz - a.yz * a.yz, c01 = a.xz * a.yz - a.xy * a.zz, c02 = a.xy * a.yz - a.xz * a.yy;
  const double d = 1 / (a.xx * c00 + a.xy * c01 + a.xz * c02);
  return {c00 * d,
          c01 * d,
          c02 * d,
          (a.xx * a.zz - a.xz * a.xz) * d,
          (a.xy * a.xz - a.xx * a.yz) * d,
          (a.xx * a.yy - a.xy * a.xy) * d};
}

/// Eigenvalues in ascending order and the matching unit eigenvectors as columns of a rotation or reflection.
struct Eigen3 {
  Vec3 values;
  Mat3 vectors;
};

/// Eigen-decomposition by the iterative QR method (accurate for every condition number). Throws nothing; NaN in, NaN
/// out.
Eigen3 eigen_decomposition(const Sym3& a);

/// Largest eigenvalue in closed form, good to half of the digits (1e-7 relative) where it is double, as it is for
/// discs.
double largest_eigenvalue(const Sym3& a);

/// Raises eigenvalues below `relative_floor` times the largest to that value and keeps the eigenvectors. A matrix
/// that needs no change is returned bit for bit. Precondition: 0 < relative_floor <= 1, a finite.
Sym3 floor_eigenvalues(const Sym3& a, double relative_floor);

}  // namespace gpsrecon
