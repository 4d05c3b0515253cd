// Stam 1999, "Evaluation of Loop Subdivision Surfaces", appendix: the twelve functions are three up to symmetry.

#include <gpsrecon/gps/patch_basis.h>

namespace gpsrecon::internal {
namespace {

constexpr int degree = 4;
constexpr std::size_t monomials = 15;

/// A polynomial of total degree 4 in (s, t): coefficient of s^i t^j at [i][j].
struct Polynomial {
  std::array<std::array<double, degree + 1>, degree + 1> c{};
};

constexpr Polynomial operator+(Polynomial a, const Polynomial& b) {
  for (std::size_t i = 0; i <= degree; ++i)
    for (std::size_t j = 0; j <= degree; ++j) a.c[i][j] += b.c[i][j];
  return a;
}

constexpr Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  Polynomial p;
  for (std::size_t i = 0; i <= degree; ++i)
    for (std::size_t j = 0; i + j <= degree; ++j)
      for (std::size_t k = 0; i + j + k <= degree; ++k)
        for (std::size_t l = 0; i + j + k + l <= degree; ++l) p.c[i + k][j + l] += a.c[i][j] * b.c[k][l];
  return p;
}

/// x u^i v^j w^k with i + j + k = 4.
constexpr Polynomial term(double x, const Polynomial& u, int i, const Polynomial& v, int j, const Polynomial& w,
                          int k) {
  Polynomial p;
  p.c[0][0] = x / 12;
  for (; i > 0; --i) p = p * u;
  for (; j > 0; --j) p = p * v;
  for (; k > 0; --k) p = p * w;
  return p;
}

/// Of the vertex where u = 1.
constexpr Polynomial corner(const Polynomial& u, const Polynomial& v, const Polynomial& w) {
  return term(6, u, 4, v, 0, w, 0) + term(24, u, 3, v, 1, w, 0) + term(24, u, 3, v, 0, w, 1) +
         term(24, u, 2, v, 2, w, 0) + term(24, u, 2, v, 0, w, 2) + term(60, u, 2, v, 1, w, 1) +
         term(8, u, 1, v, 3, w, 0) + term(8, u, 1, v, 0, w, 3) + term(36, u, 1, v, 2, w, 1) +
         term(36, u, 1, v, 1, w, 2) + term(1, u, 0, v, 4, w, 0) + term(1, u, 0, v, 0, w, 4) +
         term(6, u, 0, v, 3, w, 1) + term(6, u, 0, v, 1, w, 3) + term(12, u, 0, v, 2, w, 2);
}

/// Of the vertex across the edge w = 0.
constexpr Polynomial across(const Polynomial& u, const Polynomial& v, const Polynomial& w) {
  return term(1, u, 4, v, 0, w, 0) + term(2, u, 3, v, 0, w, 1) + term(6, u, 3, v, 1, w, 0) + term(6, u, 2, v, 1, w, 1) +
         term(12, u, 2, v, 2, w, 0) + term(6, u, 1, v, 2, w, 1) + term(6, u, 1, v, 3, w, 0) +
         term(2, u, 0, v, 3, w, 1) + term(1, u, 0, v, 4, w, 0);
}

/// Of the two vertices that only the corner u = 1 is a neighbour of: the one nearer to v = 1.
constexpr Polynomial beyond(const Polynomial& u, const Polynomial& v, const Polynomial& w) {
  return term(1, u, 4, v, 0, w, 0) + term(2, u, 3, v, 1, w, 0);
}

constexpr std::array<std::array<double, 12>, monomials> coefficients() {
  Polynomial p, q, r;  // barycentric coordinates of (0,0), (1,0), (0,1)
  p.c[0][0] = 1, p.c[1][0] = -1, p.c[0][1] = -1;
  q.c[1][0] = 1;
  r.c[0][1] = 1;
  const std::array<Polynomial, 12> functions{corner(p, q, r), corner(q, r, p), corner(r, p, q), across(p, q, r),
                                             across(q, r, p), across(r, p, q), beyond(p, q, r), beyond(p, r, q),
                                             beyond(q, p, r), beyond(q, r, p), beyond(r, q, p), beyond(r, p, q)};
  std::array<std::array<double, 12>, monomials> table{};
  std::size_t row = 0;
  for (std::size_t i = 0; i <= degree; ++i)
    for (std::size_t j = 0; i + j <= degree; ++j, ++row)
      for (std::size_t f = 0; f < 12; ++f) table[row][f] = functions[f].c[i][j];
  return table;
}

constexpr std::array<std::array<double, 12>, monomials> box_spline = coefficients();

/// x^i and its first two derivatives.
struct Powers {
  std::array<std::array<double, degree + 1>, 3> d{};
  explicit Powers(double x) {
    d[0] = {1, x, x * x, x * x * x, x * x * x * x};
    d[1] = {0, 1, 2 * x, 3 * x * x, 4 * x * x * x};
    d[2] = {0, 0, 2, 6 * x, 12 * x * x};
  }
};

struct Cubic {
  std::array<std::array<double, 4>, 3> d;
  explicit Cubic(double x) {
    const double y = 1 - x;
    d[0] = {y * y * y / 6, (4 - 6 * x * x + 3 * x * x * x) / 6, (4 - 6 * y * y + 3 * y * y * y) / 6, x * x * x / 6};
    d[1] = {-y * y / 2, (3 * x - 4) * x / 2, (4 - 3 * y) * y / 2, x * x / 2};
    d[2] = {y, 3 * x - 2, 3 * y - 2, x};
  }
};

/// f_i(s) g_j(t) and its derivatives.
template <int Order, class Functions>
BasisWeight<Order> product(const Functions& f, std::size_t i, const Functions& g, std::size_t j) {
  if constexpr (Order == 0) {
    return f.d[0][i] * g.d[0][j];
  } else {
    return {f.d[0][i] * g.d[0][j], f.d[1][i] * g.d[0][j], f.d[0][i] * g.d[1][j],
            f.d[2][i] * g.d[0][j], f.d[1][i] * g.d[1][j], f.d[0][i] * g.d[2][j]};
  }
}

}  // namespace

template <int Order>
std::array<BasisWeight<Order>, 12> box_spline_basis(double s, double t) {
  const Powers in_s(s), in_t(t);
  std::array<BasisWeight<Order>, monomials> terms;
  std::size_t row = 0;
  for (std::size_t i = 0; i <= degree; ++i)
    for (std::size_t j = 0; i + j <= degree; ++j) terms[row++] = product<Order>(in_s, i, in_t, j);
  std::array<BasisWeight<Order>, 12> basis;
  for (std::size_t f = 0; f < 12; ++f) {
    BasisWeight<Order> sum = box_spline[0][f] * terms[0];
    for (std::size_t m = 1; m < monomials; ++m) sum += box_spline[m][f] * terms[m];
    basis[f] = sum;
  }
  return basis;
}

template <int Order>
std::array<BasisWeight<Order>, 16> bicubic_basis(double s, double t) {
  const Cubic in_s(s), in_t(t);
  std::array<BasisWeight<Order>, 16> basis;
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < 4; ++x) basis[4 * y + x] = product<Order>(in_s, x, in_t, y);
  return basis;
}

template std::array<BasisWeight<0>, 12> box_spline_basis<0>(double, double);
template std::array<BasisWeight<2>, 12> box_spline_basis<2>(double, double);
template std::array<BasisWeight<0>, 16> bicubic_basis<0>(double, double);
template std::array<BasisWeight<2>, 16> bicubic_basis<2>(double, double);

}  // namespace gpsrecon::internal
