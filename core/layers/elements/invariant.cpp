#include "layers/elements/invariant.hpp"

#include <springnet/sdk/dual.hpp>

#include <Eigen/Geometry>
#include <cmath>

#include "layers/elements/gradients.hpp"

namespace springnet::layers {
namespace {

// Below this sine an angle counts as straight: its Hessian has lost half of its digits.
constexpr double min_sine = 1e-7;
// Transverse motion of a straight angle below this fraction of its nodes' motion counts as none.
constexpr double rounding_of_speed = 1e-13;

template <class T>
void gradients_at(Invariant invariant, const Triple<T>* p, Triple<T>* g) {
  switch (value_invariant(invariant)) {
    case Invariant::angle:
      return angle_gradients(p[0], p[1], p[2], g[0], g[1], g[2]);
    case Invariant::dihedral:
      return dihedral_gradients(p[0], p[1], p[2], p[3], g[0], g[1], g[2], g[3]);
    case Invariant::area:
      return area_gradients(p[0], p[1], p[2], g[0], g[1], g[2]);
    case Invariant::volume:
      return volume_gradients(p[0], p[1], p[2], p[3], g[0], g[1], g[2], g[3]);
    default:
      return;
  }
}

double value(Invariant invariant, const Point* p) {
  switch (value_invariant(invariant)) {
    case Invariant::angle:
      return invariants::angle(p[0], p[1], p[2]);
    case Invariant::dihedral:
      return invariants::dihedral(p[0], p[1], p[2], p[3]);
    case Invariant::area:
      return invariants::area(p[0], p[1], p[2]);
    case Invariant::volume:
      return invariants::volume(p[0], p[1], p[2], p[3]);
    default:
      return 0.0;
  }
}

// Completes a Hessian whose columns of corners 1, 2, .. are known: those of corner 0 are minus their sum, because an
// invariant does not change under translation.
template <std::size_t Count>
void complete(const Corners& corners, SecondOrder& out) {
  for (std::size_t i = 0; i < Count; ++i) {
    out.hessian[i][0] = -(out.hessian[i][1] + out.hessian[i][2]);
    if constexpr (Count == 4) out.hessian[i][0] -= out.hessian[i][3];
    out.rate_gradient[i].setZero();
    for (std::size_t j = 1; j < Count; ++j)
      out.rate_gradient[i] += out.hessian[i][j] * (corners.velocity[j] - corners.velocity[0]);
  }
}

// Coordinate c of corner i > 0 as variable number 3 (i - 1) + c of a dual.
template <std::size_t Count>
void second_order_of(Invariant invariant, const Corners& corners, SecondOrder& out) {
  using Number = sdk::Dual<3 * (Count - 1)>;
  Triple<Number> p[max_corners]{}, g[max_corners]{};
  const Vector3& origin = corners.position[0];
  p[0] = {Number(origin[0]), Number(origin[1]), Number(origin[2])};
  for (std::size_t i = 1; i < Count; ++i) {
    const Vector3& at = corners.position[i];
    const std::size_t first = 3 * (i - 1);
    p[i] = {Number::variable(at[0], first), Number::variable(at[1], first + 1), Number::variable(at[2], first + 2)};
  }
  gradients_at(invariant, p, g);
  for (std::size_t i = 0; i < Count; ++i) {
    for (std::size_t j = 1; j < Count; ++j) {
      Block& block = out.hessian[i][j];
      for (std::size_t c = 0; c < 3; ++c) {
        const auto column = static_cast<Eigen::Index>(c);
        block(0, column) = g[i].x.derivatives[3 * (j - 1) + c];
        block(1, column) = g[i].y.derivatives[3 * (j - 1) + c];
        block(2, column) = g[i].z.derivatives[3 * (j - 1) + c];
      }
    }
  }
  complete<Count>(corners, out);
}

// scale (a b^T + b a^T)
Block both(double scale, const Vector3& a, const Vector3& b) {
  const Block outer = scale * a * b.transpose();
  return outer + outer.transpose();
}

// Derivatives of the formulas of dihedral(). With C = dq/dc = -|e| m / |m|^2, D = dq/dd = -|e| n / |n|^2 and
// {a, b} = a b^T + b a^T, with respect to the differences from a:
//   dC/dc = |e| / |m|^4 {m, m x e},   dC/de = -|e| / |m|^4 {m, m x c} - m e^T / (|m|^2 |e|),   dC/dd = 0
//   dD/dd = -|e| / |n|^4 {n, n x e},  dD/de = |e| / |n|^4 {n, n x d} - n e^T / (|n|^2 |e|)
//   dq/db = -(s C + t D), s = c . e / |e|^2, t = d . e / |e|^2, ds/de = (c - 2 s e) / |e|^2
void dihedral_second_order(const Corners& corners, SecondOrder& out) {
  const Vector3* const p = corners.position;
  const Vector3 e = p[1] - p[0], c = p[2] - p[0], d = p[3] - p[0];
  const Vector3 m = e.cross(c), n = d.cross(e);
  const double ee = e.squaredNorm(), mm = m.squaredNorm(), nn = n.squaredNorm();
  if (!(mm > 0.0) || !(nn > 0.0)) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (Block& block : out.hessian[i]) block.setZero();
      out.rate_gradient[i].setZero();
    }
    return;
  }
  const double length = std::sqrt(ee), s = c.dot(e) / ee, t = d.dot(e) / ee;
  const Vector3 by_c = (-length / mm) * m, by_d = (-length / nn) * n;
  const double at_c = length / mm / mm, at_d = length / nn / nn;
  Block(&h)[max_corners][max_corners] = out.hessian;
  h[2][2] = both(at_c, m, m.cross(e));
  h[3][3] = both(-at_d, n, n.cross(e));
  h[2][3].setZero();
  h[3][2].setZero();
  h[2][1] = both(-at_c, m, m.cross(c)) + (by_c / ee) * e.transpose();
  h[3][1] = both(at_d, n, n.cross(d)) + (by_d / ee) * e.transpose();
  h[1][2] = h[2][1].transpose();
  h[1][3] = h[3][1].transpose();
  const Vector3 lever_c = (c - 2.0 * s * e) / ee, lever_d = (d - 2.0 * t * e) / ee;
  h[1][1] = -(s * h[2][1] + t * h[3][1] + by_c * lever_c.transpose() + by_d * lever_d.transpose());
  for (std::size_t j = 1; j < 4; ++j) h[0][j] = -(h[1][j] + h[2][j] + h[3][j]);
  complete<4>(corners, out);
}

}  // namespace

void gather(const std::uint32_t* corners, std::size_t count, const NodeArrays& nodes, Corners& out) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t k = corners[i];
    out.position[i] = {nodes.px[k], nodes.py[k], nodes.pz[k]};
    out.velocity[i] = {nodes.vx[k], nodes.vy[k], nodes.vz[k]};
  }
}

// For a straight angle, q = pi - |x| or |x|, that is bending: the limit along the motion, where x has the direction of
// x'.
void straighten(const Corners& corners, FirstOrder& out) noexcept {
  BentDirections bent;
  if (!is_straight(Invariant::angle, corners, bent)) return;
  Eigen::Vector2d rate = Eigen::Vector2d::Zero();
  double size = 0.0;
  for (std::size_t i = 1; i < 3; ++i) {
    const Vector3 motion = corners.velocity[i] - corners.velocity[0];
    for (int r = 0; r < 2; ++r) rate[r] += bent.row[r][i].dot(motion);
    size += bent.row[0][i].norm() * motion.norm();
  }
  const double speed = rate.norm();
  if (!(speed > rounding_of_speed * size)) return;
  const double away = out.value > 1.0 ? -1.0 : 1.0;  // from pi, from 0
  for (std::size_t i = 0; i < 3; ++i)
    out.gradient[i] = away / speed * (rate[0] * bent.row[0][i] + rate[1] * bent.row[1][i]);
  out.rate = away * speed;
}

void first_order(Invariant invariant, const Corners& corners, FirstOrder& out) noexcept {
  const std::size_t count = corners_of(invariant);
  Point p[max_corners]{}, g[max_corners]{};
  for (std::size_t i = 0; i < count; ++i)
    p[i] = {corners.position[i][0], corners.position[i][1], corners.position[i][2]};
  gradients_at(invariant, p, g);
  out.value = value(invariant, p);
  out.rate = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    out.gradient[i] = {g[i].x, g[i].y, g[i].z};
    // Relative to the first corner, so that a common motion contributes exactly nothing.
    out.rate += out.gradient[i].dot(corners.velocity[i] - corners.velocity[0]);
  }
  if (invariant == Invariant::angle && out.gradient[0].isZero(0.0)) straighten(corners, out);
}

double nearest_turn(Invariant invariant, double value, double reference) noexcept {
  return invariant == Invariant::dihedral ? turned(value, reference) : value;
}

void second_order(Invariant invariant, const Corners& corners, SecondOrder& out) noexcept {
  if (invariant == Invariant::dihedral)
    dihedral_second_order(corners, out);
  else if (corners_of(invariant) == 3)
    second_order_of<3>(invariant, corners, out);
  else
    second_order_of<4>(invariant, corners, out);
}

OwnSecondOrder own_second_order(Invariant invariant, const Corners& corners, std::size_t corner) noexcept {
  using Number = sdk::Dual<4>;  // by the corner's coordinates, and along the motion of all
  const std::size_t count = corners_of(invariant);
  Triple<Number> p[max_corners]{}, g[max_corners]{};
  for (std::size_t i = 0; i < count; ++i) {
    Number* const to[3] = {&p[i].x, &p[i].y, &p[i].z};
    for (std::size_t c = 0; c < 3; ++c) {
      const auto k = static_cast<Eigen::Index>(c);
      to[c]->value = corners.position[i][k];
      to[c]->derivatives[3] = corners.velocity[i][k];
      if (i == corner) to[c]->derivatives[c] = 1.0;
    }
  }
  gradients_at(invariant, p, g);
  OwnSecondOrder out;
  const Number* const from[3] = {&g[corner].x, &g[corner].y, &g[corner].z};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c)
      out.hessian(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = from[r]->derivatives[c];
    out.rate_gradient[static_cast<Eigen::Index>(r)] = from[r]->derivatives[3];
  }
  return out;
}

bool is_straight(Invariant invariant, const Corners& corners, BentDirections& out) noexcept {
  if (invariant != Invariant::angle) return false;
  const Vector3 u = corners.position[0] - corners.position[1], w = corners.position[2] - corners.position[1];
  const double u_size = u.norm(), w_size = w.norm();
  if (!(u_size > 0.0) || !(w_size > 0.0) || u.cross(w).norm() > min_sine * u_size * w_size) return false;
  const Vector3 along = u / u_size;
  Eigen::Index axis = 0;
  along.cwiseAbs().minCoeff(&axis);
  const Vector3 across = along.cross(Vector3(Vector3::Unit(axis))).normalized();
  const double side = u.dot(w) < 0.0 ? 1.0 : -1.0;
  for (int r = 0; r < 2; ++r) {
    const Vector3 direction = r == 0 ? across : Vector3(along.cross(across));
    out.row[r][0] = direction / u_size;
    out.row[r][2] = side / w_size * direction;
    out.row[r][1] = -(out.row[r][0] + out.row[r][2]);
  }
  return true;
}

}  // namespace springnet::layers
