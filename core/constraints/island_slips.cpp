// Directions of slips in an island.

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <utility>

#include <springnet/sdk/math.hpp>

#include "constraints/friction.hpp"
#include "constraints/island.hpp"
#include "constraints/island_directions.hpp"
#include "constraints/least_squares.hpp"

namespace springnet {
namespace {

constexpr int max_directions = 200;          // iterations for directions of beginning slip
constexpr std::size_t max_iterated = 24;     // bits of the active set of bodies for which they are iterated
constexpr std::size_t max_differences = 12;  // of directions: each takes a solution
constexpr int max_guesses = 20;              // of them, fixed-point iterations along the acceleration
constexpr double reversed = 0.1;             // length of the sum of two unit vectors: they are opposite
constexpr double held_share = 1e-6;          // of a mobility, below which others hold what it belongs to
constexpr double reversing = 1e-6;  // acceleration against a slip, in units of what forces give, that is its end

// Its direction follows the acceleration.
bool begins_slip(const ContactNode& node) {
  const double friction = slip_friction(node);
  if (node.sticks || friction == 0.0) return false;
  return !node.slipping || (node.slip_starting && friction < friction_of_held);
}

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
  Matrix3 mobility = block(i, i);
  Vector3 other = acceleration(i) - mobility * node.force;
  // With what the others do for this one's force, unless they hold it.
  const std::vector<Unknown> others = has_pairs_ ? unknowns(i) : std::vector<Unknown>{};
  if (!others.empty()) {
    const auto count = static_cast<Eigen::Index>(others.size());
    Eigen::MatrixXd missing(count, 4);
    Eigen::Matrix3Xd back(3, count);
    for (Eigen::Index r = 0; r < count; ++r) {
      const Unknown& unknown = others[static_cast<std::size_t>(r)];
      missing(r, 3) = unknown.target - unknown.row.dot(nodes_[unknown.node].acceleration);
      missing.row(r).head<3>() = -unknown.row.transpose() * block(unknown.node, i);
      back.col(r) = block(i, unknown.node) * unknown.column;
    }
    const Eigen::Matrix<double, 3, 4> answer = back * least_squares_of_all(response(others), missing, singular);
    const Matrix3 answered = mobility + answer.leftCols<3>(), along = Matrix3::Identity() - n * n.transpose();
    const double own = n.dot(mobility * n);
    if (n.dot(answered * n) > held_share * own) {
      mobility = answered;
      other = node.acceleration + answer.col(3);
    } else if ((along * answered * along).norm() > held_share * own) {
      // The others determine the gap, so that its normal force is one of many: it stays.
      mobility = along * answered * along + own * n * n.transpose();
      other =
          along * (node.acceleration + answer.col(3)) + n * (touched->target_acceleration - own * n.dot(node.force));
    }
  }
  Vector3 relative = other - touched->surface_acceleration;
  relative += n * (n.dot(other) - touched->target_acceleration - n.dot(relative));
  return Alone{*touched, mobility, relative};
}

// Of a node on a single surface that friction would hold, with the active set of all others: the direction d in
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

// The direction in which a node on a single surface begins to slip, with the active set of all others; empty if it does
// not slip.
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

// How the accelerations of nodes across their slips change as these turn, each about the normal of its only side: the
// forces keep all others on their surfaces. Exact where the pairs determine the forces.
Eigen::MatrixXd Island::by_turns(const std::vector<std::size_t>& turning) const {
  const std::vector<Unknown> all = unknowns();
  const auto rows = static_cast<Eigen::Index>(all.size()), count = static_cast<Eigen::Index>(turning.size());
  std::vector<Vector3> across, more;  // unit; N, the change of the own force
  for (const std::size_t i : turning) {
    const ContactNode& node = nodes_[i];
    const auto side = std::find_if(node.sides.begin(), node.sides.end(), [](const auto& s) { return s.active; });
    across.push_back(side->normal.cross(node.slip));
    const double pressing = node.normal_force[static_cast<std::size_t>(side - node.sides.begin())];
    more.push_back(-sliding_coefficient_of(side->friction) * pressing * across.back());
  }
  Eigen::MatrixXd missing(rows, count), result(count, count), back(count, rows);
  for (Eigen::Index j = 0; j < count; ++j) {
    const auto to = static_cast<std::size_t>(j);
    for (Eigen::Index r = 0; r < rows; ++r) {
      const Unknown& unknown = all[static_cast<std::size_t>(r)];
      missing(r, j) = -unknown.row.dot(block(unknown.node, turning[to]) * more[to]);
      back(j, r) = across[to].dot(block(turning[to], unknown.node) * unknown.column);
    }
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto from = static_cast<std::size_t>(k);
      result(j, k) = across[to].dot(block(turning[to], turning[from]) * more[from]);
    }
    // The direction turns, too.
    result(j, j) -= nodes_[turning[to]].slip.dot(slides(turning[to]));
  }
  return result + back * least_squares_of_all(response(all), missing, singular);
}

// m/s^2, relative to its first active side.
Vector3 Island::slides(std::size_t i) const {
  const ContactNode& node = nodes_[i];
  const auto side = std::find_if(node.sides.begin(), node.sides.end(), [](const auto& s) { return s.active; });
  return acceleration(i) - side->surface_acceleration;
}

// The directions of all beginning slips at once, by Newton's method on their angles: of each, the acceleration across
// it vanishes. Where a slip ends, the acceleration along it passes through zero as a smooth function. False, with the
// directions as they were: it does not converge, or leads elsewhere. may_reverse: accelerations against the slips fit,
// too. by_difference: with derivatives that hold also where redundant forces change with the slips.
bool Island::follow_slips(bool may_reverse, bool by_difference) {
  constexpr int most = 12, most_halvings = 6;
  constexpr double probe = 1e-6, longest = 0.5, accuracy = 1e-13, converged = 1e-10;
  std::vector<std::size_t> begin;
  std::vector<Vector3> start;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const ContactNode& node = nodes_[i];
    if (!begins_slip(node) || active_normals(node).empty()) continue;
    if (active_normals(node).size() > 1 || slip_friction(node) >= friction_of_held || node.slip.isZero(0.0))
      return false;
    begin.push_back(i);
    start.push_back(node.slip);
  }
  if (by_difference && begin.size() > max_differences) return directions_fit_ = false;
  const auto count = static_cast<Eigen::Index>(begin.size());
  Eigen::VectorXd across(count), along(count);
  double scale = 0.0;
  const auto evaluate = [&] {
    solve_once();
    scale = 0.0;
    for (std::size_t j = 0; j < begin.size(); ++j) {
      const ContactNode& node = nodes_[begin[j]];
      const Vector3 by = slides(begin[j]);
      across[static_cast<Eigen::Index>(j)] = active_normals(node).front().dot(node.slip.cross(by));
      along[static_cast<Eigen::Index>(j)] = node.slip.dot(by);
      scale = std::max(scale, (acceleration(begin[j]) - node.acceleration).norm());
    }
  };
  const auto turn = [&](std::size_t j, double angle) {
    ContactNode& node = nodes_[begin[j]];
    const Vector3 n = active_normals(node).front();
    const Vector3 d = (node.slip - n * n.dot(node.slip)).normalized();
    node.slip = (sdk::cos(angle) * d + sdk::sin(angle) * n.cross(d)).normalized();
  };
  const auto put = [&](const std::vector<Vector3>& slips) {
    for (std::size_t j = 0; j < begin.size(); ++j) nodes_[begin[j]].slip = slips[j];
  };
  const auto derivatives = [&]() -> Eigen::MatrixXd {
    if (!by_difference) return by_turns(begin);
    const Eigen::VectorXd first = across;
    Eigen::MatrixXd result(count, count);
    for (std::size_t j = 0; j < begin.size(); ++j) {
      const Vector3 before = nodes_[begin[j]].slip;
      turn(j, probe);
      evaluate();
      result.col(static_cast<Eigen::Index>(j)) = (across - first) / probe;
      nodes_[begin[j]].slip = before;
    }
    across = first;
    return result;
  };
  evaluate();
  double missing = count > 0 ? across.lpNorm<Eigen::Infinity>() : 0.0;
  for (int k = 0; k < most && missing > accuracy * scale; ++k) {
    std::vector<Vector3> before;
    for (const std::size_t i : begin) before.push_back(nodes_[i].slip);
    Eigen::VectorXd angles = -least_squares(derivatives(), across, singular);
    if (!angles.allFinite()) {
      evaluate();
      break;
    }
    angles *= std::min(1.0, longest / std::max(longest, angles.lpNorm<Eigen::Infinity>()));
    double last = missing;
    for (int halvings = 0; halvings < most_halvings; ++halvings, angles *= 0.5) {
      put(before);
      for (std::size_t j = 0; j < begin.size(); ++j) turn(j, angles[static_cast<Eigen::Index>(j)]);
      evaluate();
      if ((last = across.lpNorm<Eigen::Infinity>()) < missing) break;
    }
    if (!(last < missing)) {  // to rounding, perhaps
      put(before);
      evaluate();
      break;
    }
    missing = last;
  }
  bool fits = missing <= converged * scale;
  for (std::size_t j = 0; j < begin.size(); ++j)
    fits = fits && start[j].dot(nodes_[begin[j]].slip) > 0.0 &&
           (may_reverse || along[static_cast<Eigen::Index>(j)] >= -reversing * scale);
  directions_fit_ = fits;
  if (!fits) put(start);
  return fits;
}

// Beginning slip is parallel to the sliding acceleration. Friction opposes it, and with an anisotropic effective mass
// turns the acceleration, so that the direction is found by iteration.
void Island::solve(bool keeps_slips) {
  std::vector<Vector3> kept;
  if (keeps_slips)
    for (const ContactNode& node : nodes_) kept.push_back(node.slip);
  std::vector<Vector3> given;
  for (const ContactNode& node : nodes_) given.push_back(node.slip);
  // Pairs turn each other's slips, most often by little since the last time.
  if (has_pairs_ && follow_slips(keeps_slips, false)) return;
  if (has_pairs_ && bit_count() > max_iterated) {
    // An iteration that searches all directions of each takes as long as hundreds of solutions, and seldom finds what
    // Newton's method does not. Then friction keeps the directions that it was given.
    if (!follow_slips(keeps_slips, true)) solve_once();
    return;
  }
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
      if (!begins_slip(node)) continue;
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
  if (directions_fit_ || !has_pairs_) return;
  std::vector<Vector3> last;
  for (ContactNode& node : nodes_) last.push_back(std::exchange(node.slip, given[last.size()]));
  if (follow_slips(keeps_slips, true)) return;
  for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].slip = last[i];
  solve_once();
}

}  // namespace springnet
