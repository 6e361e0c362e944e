// Directions of slips in an island.

#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "constraints/friction.hpp"
#include "constraints/island.hpp"
#include "constraints/island_directions.hpp"

namespace springnet {
namespace {

constexpr int max_directions = 200;  // iterations for directions of beginning slip
constexpr int max_guesses = 20;      // of them, fixed-point iterations along the acceleration
constexpr double reversed = 0.1;     // length of the sum of two unit vectors: they are opposite

// Whether a node can move in all directions; one whose rod hangs from what is held cannot.
bool is_regular(const Matrix3& mobility) {
  const double size = mobility.norm();
  return mobility.determinant() > 1e-9 * size * size * size;
}

}  // namespace

std::optional<Island::Alone> Island::alone(std::size_t i) const {
  const ContactNode& node = nodes_[i];
  const ContactSide* touched = nullptr;
  for (const ContactSide& side : node.sides) {
    if (!side.active) continue;
    if (touched != nullptr) return std::nullopt;
    touched = &side;
  }
  if (touched == nullptr) return std::nullopt;
  const Vector3& n = touched->normal;
  const Matrix3 mobility = block(i, i);
  const Vector3 other = acceleration(i) - mobility * node.force;
  Vector3 relative = other - touched->surface_acceleration;
  relative += n * (n.dot(other) - touched->target_acceleration - n.dot(relative));
  return Alone{*touched, mobility, relative};
}

// Of a node on a single surface that friction would hold, with the forces of all other nodes kept: the direction d in
// which it slips backwards, at -s, as the smooth function of the forces that a slip at s along d is. With the relative
// acceleration r of the node without its own force f,
//
//   r + M f = s d,    f = N (n - mu d),    |d| = 1,    d.n = 0,
//
// by Newton's method in s and d, from where s = 0. Its end would be jumped over otherwise by methods that locate it.
std::optional<Vector3> Island::reversed_slip(std::size_t i) const {
  constexpr int most = 40;
  constexpr double accuracy = 1e-14;
  const std::optional<Alone> own = alone(i);
  if (!own) return std::nullopt;
  const Vector3& n = own->side.normal;
  const double mu = sliding_coefficient_of(own->side.friction);
  if (!is_regular(own->mobility)) return std::nullopt;
  const Matrix3 inertia = own->mobility.inverse();
  const auto tangential = [&n](const Vector3& v) { return Vector3(v - n * n.dot(v)); };
  const Vector3 held = -tangential(inertia * own->relative);
  if (held.isZero(0.0)) return std::nullopt;
  const Vector3 first = -held.normalized();
  Vector3 d = first;
  double s = 0.0;
  for (int k = 0; k < most; ++k) {
    const Vector3 across = n.cross(d), f = inertia * (s * d - own->relative);
    const Vector3 by_s = inertia * d, by_turn = s * (inertia * across);
    const Vector3 missing = tangential(f) + mu * n.dot(f) * d;
    const Vector3 along_s = tangential(by_s) + mu * n.dot(by_s) * d;
    const Vector3 along_turn = tangential(by_turn) + mu * n.dot(by_turn) * d + mu * n.dot(f) * across;
    Eigen::Matrix2d matrix;
    matrix << along_s.dot(d), along_turn.dot(d), along_s.dot(across), along_turn.dot(across);
    const Eigen::Vector2d step = matrix.fullPivLu().solve(Eigen::Vector2d(-missing.dot(d), -missing.dot(across)));
    if (!step.allFinite()) return first;
    s += step[0];
    const Vector3 next = (d + step[1] * across).normalized();
    const double turned = (next - d).norm();
    d = next;
    if (turned <= accuracy && missing.norm() <= 1e-12 * f.norm()) return s <= 0.0 && d.dot(first) > 0.0 ? d : first;
  }
  return first;
}

// The direction in which a node on a single surface begins to slip, with the forces of all other nodes kept; empty if
// it does not slip.
std::optional<Vector3> Island::slip_of(std::size_t i) const {
  const std::optional<Alone> own = alone(i);
  if (!own) return std::nullopt;
  const Vector3& n = own->side.normal;
  const ContactResponse answer =
      solve_contact(own->mobility, own->relative, n, capped(own->side.friction, friction_of_held));
  const Vector3 sliding = answer.velocity - n * n.dot(answer.velocity);
  if (answer.sticks || !(answer.normal > 0.0) || sliding.isZero(0.0)) return std::nullopt;
  return sliding.normalized();
}

// Beginning slip is parallel to the sliding acceleration. Friction opposes it, and with an anisotropic effective mass
// turns the acceleration, so that the direction is found by iteration.
void Island::solve(bool keeps_slips) {
  std::vector<Vector3> kept;
  if (keeps_slips)
    for (const ContactNode& node : nodes_) kept.push_back(node.slip);
  double turned = 0.0, turned_before = std::numeric_limits<double>::infinity();  // at the last check
  for (int iteration = 0; iteration < max_directions; ++iteration) {
    if (iteration > max_guesses && iteration % max_guesses == 0) {
      if (turned > 0.5 * turned_before) break;  // it cycles
      turned_before = turned;
    }
    solve_once();
    turned = 0.0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      ContactNode& node = nodes_[i];
      const double friction = slip_friction(node);
      if (node.sticks || friction == 0.0) continue;
      if (node.slipping && (!node.slip_starting || friction >= friction_of_held)) continue;
      const auto first = std::find_if(node.sides.begin(), node.sides.end(), [](const auto& s) { return s.active; });
      if (first == node.sides.end()) continue;
      const Vector3 sliding =
          project_onto(free_directions(active_normals(node)), acceleration(i) - first->surface_acceleration);
      const bool against = sliding.dot(node.slip) < 0.0;
      // At the boundary of the cone the acceleration is too small to have a direction.
      const double scale = (acceleration(i) - nodes_[i].acceleration).norm();
      const bool is_small = sliding.norm() <= 1e-6 * scale;
      const bool is_smooth = keeps_slips && is_regular(block(i, i));
      if (is_small && !against && !is_smooth) continue;
      // Great friction overshoots or reverses the slip through the mobility's coupling of normal and tangential
      // directions. Then search all directions.
      std::optional<Vector3> slip;
      const bool pulls = node.normal_force[static_cast<std::size_t>(first - node.sides.begin())] < 0.0;
      if (against || is_small || pulls || iteration >= max_guesses) slip = slip_of(i);
      if (!slip && (against || is_small)) {  // it would stick
        if (const std::optional<Vector3> held = is_smooth ? reversed_slip(i) : std::nullopt;
            held && held->dot(kept[i]) > 0.0) {
          turned = std::max(turned, (*held - node.slip).norm());
          node.slip = *held;
          continue;
        }
        // Forces of bodies that push each other along follow the slips: with those of a wrong direction it would stick.
        const Vector3 between = sliding.normalized() + node.slip;
        if (!has_pairs_ || is_small || between.norm() < reversed) continue;
        slip = between.normalized();
      }
      if (!slip)
        slip =
            iteration < max_guesses ? sliding.normalized() : Vector3((sliding.normalized() + node.slip).normalized());
      turned = std::max(turned, (*slip - node.slip).norm());
      node.slip = *slip;
    }
    directions_fit_ = turned <= 1e-12;
    if (turned <= 1e-14) return;
  }
}

}  // namespace springnet
