// Strains of triangles and tetrahedra from the lengths of their edges, for laws over these.
//
// With edges e_k from corner 0 to corner k + 1, G_ij = e_i . e_j follows from squared lengths,
//   G_ii = l_0i^2,  2 G_ij = l_0i^2 + l_0j^2 - l_ij^2,
// and so does that at rest, R. The Cauchy-Green tensor C in the material's orthonormal axes is similar to R^-1 G, so
// that
//   tr C = R^-1 : G,  tr C^2 = (R^-1 G) : (R^-1 G)^T,  det C = det G / det R;
// a unit vector a = sum_k a_k e_k of the material at rest has a . C a = a^T G a.
#pragma once

#include <array>
#include <cstddef>

#include <springnet/sdk/law/invariants.hpp>

namespace springnet::sdk {

// The lengths that Simplex<D> reads, first in a law's list: edges from corner 0, then between the others.
#define SPRINGNET_TRIANGLE_EDGES \
  ::springnet::sdk::length_of(0, 1), ::springnet::sdk::length_of(0, 2), ::springnet::sdk::length_of(1, 2)
#define SPRINGNET_TETRAHEDRON_EDGES                                                                        \
  ::springnet::sdk::length_of(0, 1), ::springnet::sdk::length_of(0, 2), ::springnet::sdk::length_of(0, 3), \
      ::springnet::sdk::length_of(1, 2), ::springnet::sdk::length_of(1, 3), ::springnet::sdk::length_of(2, 3)

// A symmetric matrix of D rows by its entries 11, 22, (33,) 12, (13, 23). Its arithmetic, as that of what
// follows, is written out: loops in a formula keep the loop over elements from being vectorised.
template <class Real, std::size_t D>
struct Symmetric {
  static constexpr std::size_t size = D * (D + 1) / 2;
  static constexpr std::size_t at(std::size_t i, std::size_t j) {
    if (i == j) return i;
    return D == 2 ? 2 : D + (i + j - 1);  // 12, 13, 23
  }
  std::array<Real, size> entries;
  [[nodiscard]] SPRINGNET_INLINE const Real& operator()(std::size_t i, std::size_t j) const {
    return entries[at(i, j)];
  }

  [[nodiscard]] SPRINGNET_INLINE Real determinant() const {
    const auto& m = *this;
    if constexpr (D == 2)
      return m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1);
    else
      return m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(1, 2)) - m(0, 1) * (m(0, 1) * m(2, 2) - m(1, 2) * m(0, 2)) +
             m(0, 2) * (m(0, 1) * m(1, 2) - m(1, 1) * m(0, 2));
  }
  friend SPRINGNET_INLINE Symmetric operator+(const Symmetric& a, const Symmetric& b) {
    Symmetric result;
    detail::unrolled<size>([&](auto k) { result.entries[k] = a.entries[k] + b.entries[k]; });
    return result;
  }
  friend SPRINGNET_INLINE Symmetric operator-(const Symmetric& a, const Symmetric& b) {
    Symmetric result;
    detail::unrolled<size>([&](auto k) { result.entries[k] = a.entries[k] - b.entries[k]; });
    return result;
  }
  friend SPRINGNET_INLINE Symmetric operator*(const Real& a, const Symmetric& b) {
    Symmetric result;
    detail::unrolled<size>([&](auto k) { result.entries[k] = a * b.entries[k]; });
    return result;
  }

  // Its inverse times the determinant.
  [[nodiscard]] SPRINGNET_INLINE Symmetric adjugate() const {
    const auto& m = *this;
    if constexpr (D == 2)
      return {{m(1, 1), m(0, 0), -m(0, 1)}};
    else
      return {{m(1, 1) * m(2, 2) - m(1, 2) * m(1, 2), m(0, 0) * m(2, 2) - m(0, 2) * m(0, 2),
               m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1), m(0, 2) * m(1, 2) - m(0, 1) * m(2, 2),
               m(0, 1) * m(1, 2) - m(0, 2) * m(1, 1), m(0, 2) * m(0, 1) - m(1, 2) * m(0, 0)}};
  }
};

// A : B
template <class Real, std::size_t D>
[[nodiscard]] SPRINGNET_INLINE Real contracted(const Symmetric<Real, D>& a, const Symmetric<Real, D>& b) {
  if constexpr (D == 2)
    return a(0, 0) * b(0, 0) + a(1, 1) * b(1, 1) + 2.0 * (a(0, 1) * b(0, 1));
  else
    return a(0, 0) * b(0, 0) + a(1, 1) * b(1, 1) + a(2, 2) * b(2, 2) +
           2.0 * (a(0, 1) * b(0, 1) + a(0, 2) * b(0, 2) + a(1, 2) * b(1, 2));
}

namespace detail {

// Entry i, j of the product of two symmetric matrices.
template <std::size_t i, std::size_t j, class Real, std::size_t D>
[[nodiscard]] SPRINGNET_INLINE Real product_entry(const Symmetric<Real, D>& a, const Symmetric<Real, D>& b) {
  Real sum = a(i, 0) * b(0, j) + a(i, 1) * b(1, j);
  if constexpr (D == 3) sum += a(i, 2) * b(2, j);
  return sum;
}

}  // namespace detail

// A B A
template <class Real, std::size_t D>
[[nodiscard]] SPRINGNET_INLINE Symmetric<Real, D> sandwich(const Symmetric<Real, D>& a, const Symmetric<Real, D>& b) {
  using detail::product_entry;
  const Real p00 = product_entry<0, 0>(a, b), p01 = product_entry<0, 1>(a, b);
  const Real p10 = product_entry<1, 0>(a, b), p11 = product_entry<1, 1>(a, b);
  if constexpr (D == 2) {
    return {{p00 * a(0, 0) + p01 * a(1, 0), p10 * a(0, 1) + p11 * a(1, 1), p00 * a(0, 1) + p01 * a(1, 1)}};
  } else {
    const Real p02 = product_entry<0, 2>(a, b), p12 = product_entry<1, 2>(a, b);
    const Real p20 = product_entry<2, 0>(a, b), p21 = product_entry<2, 1>(a, b), p22 = product_entry<2, 2>(a, b);
    return {{p00 * a(0, 0) + p01 * a(1, 0) + p02 * a(2, 0), p10 * a(0, 1) + p11 * a(1, 1) + p12 * a(2, 1),
             p20 * a(0, 2) + p21 * a(1, 2) + p22 * a(2, 2), p00 * a(0, 1) + p01 * a(1, 1) + p02 * a(2, 1),
             p00 * a(0, 2) + p01 * a(1, 2) + p02 * a(2, 2), p10 * a(0, 2) + p11 * a(1, 2) + p12 * a(2, 2)}};
  }
}

// The Gram matrix G of an element's edges from the lengths in `l`, as in the lists above; of their products with
// themselves if l = m. l, m: lengths, or lengths and rates, whose products are half of the rates of G.
template <std::size_t D, class Lengths, class Others>
[[nodiscard]] SPRINGNET_INLINE auto gram(const Lengths& l, const Others& m) {
  using Real = std::remove_cvref_t<decltype(l[0] * m[0])>;
  const Real a = l[0] * m[0], b = l[1] * m[1];
  if constexpr (D == 2) {
    return Symmetric<Real, D>{{a, b, 0.5 * (a + b - l[2] * m[2])}};
  } else {
    const Real c = l[2] * m[2];
    return Symmetric<Real, D>{
        {a, b, c, 0.5 * (a + b - l[3] * m[3]), 0.5 * (a + c - l[4] * m[4]), 0.5 * (b + c - l[5] * m[5])}};
  }
}

// Of lengths: dW/dl_k from S = dW/dG, where W depends on G_ij and G_ji together (the derivative by each half of both).
template <std::size_t D, class Real, class Lengths>
SPRINGNET_INLINE void add_edge_forces(const Symmetric<Real, D>& s, const Lengths& l, Real* forces) {
  if constexpr (D == 2) {
    forces[0] += 2.0 * (s(0, 0) + s(0, 1)) * l[0];
    forces[1] += 2.0 * (s(1, 1) + s(0, 1)) * l[1];
    forces[2] -= 2.0 * s(0, 1) * l[2];
  } else {
    forces[0] += 2.0 * (s(0, 0) + s(0, 1) + s(0, 2)) * l[0];
    forces[1] += 2.0 * (s(1, 1) + s(0, 1) + s(1, 2)) * l[1];
    forces[2] += 2.0 * (s(2, 2) + s(0, 2) + s(1, 2)) * l[2];
    forces[3] -= 2.0 * s(0, 1) * l[3];
    forces[4] -= 2.0 * s(0, 2) * l[4];
    forces[5] -= 2.0 * s(1, 2) * l[5];
  }
}

}  // namespace springnet::sdk
