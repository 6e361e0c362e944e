#include "constraints/island.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "constraints/cone_forces.hpp"
#include "constraints/friction.hpp"
#include "constraints/island_directions.hpp"
#include "constraints/least_squares.hpp"

namespace springnet {
namespace {

constexpr int max_pivots = 200;          // of the active set by pivoting
constexpr std::size_t max_stored = 64;   // bits of an active set that is stored
constexpr std::size_t max_pivoted = 24;  // bits of an active set of impulses that is pivoted first
constexpr int max_bits = 12;             // of an active set that is found by enumeration
constexpr int rounds_per_check = Island::max_rounds / 10;

// Holding surfaces only: Coulomb friction would need a normal force comparable to the tangential one.
bool can_brace(const ContactNode& node) {
  return node.sticks && node.sides.size() == 1 && coefficient_of(node.sides[0].friction) >= friction_of_held;
}

// Bodies between surfaces can wedge by friction, however small the coefficient.
bool can_wedge(const ContactNode& node) {
  return node.sticks && node.sides.size() == 1 && coefficient_of(node.sides[0].friction) > 0.0;
}

}  // namespace

Island::Island(std::vector<ContactNode> nodes, Eigen::MatrixXd mobility)
    : nodes_(std::move(nodes)), mobility_(std::move(mobility)) {
  for (ContactNode& node : nodes_) {
    node.normal_force.assign(node.sides.size(), 0.0);
    node.impulse.assign(node.sides.size(), Vector3::Zero());
    has_pairs_ = has_pairs_ || node.pair >= 0;
  }
}

std::vector<Island::Unknown> Island::unknowns(std::optional<std::size_t> without) const {
  std::vector<Unknown> result;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (i == without) continue;
    const ContactNode& node = nodes_[i];
    const std::vector<Vector3> directions = free_directions(active_normals(node));
    const ContactSide* first = nullptr;
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      const ContactSide& side = node.sides[s];
      if (!side.active) continue;
      if (first == nullptr) first = &side;
      Vector3 column = side.normal;
      if (!node.sticks) column -= sliding_coefficient_of(side.friction) * project_onto(directions, node.slip);
      result.push_back({i, side.normal, column, side.target_acceleration, s});
    }
    if (first == nullptr || !node.sticks) continue;
    for (const Vector3& e : directions)
      result.push_back({i, e, e, e.dot(first->surface_acceleration), Unknown::no_side});
  }
  return result;
}

Eigen::MatrixXd Island::response(const std::vector<Unknown>& unknowns) const {
  const auto count = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd matrix(count, count);
  for (Eigen::Index r = 0; r < count; ++r) {
    const Unknown& row = unknowns[static_cast<std::size_t>(r)];
    for (Eigen::Index c = 0; c < count; ++c) {
      const Unknown& column = unknowns[static_cast<std::size_t>(c)];
      matrix(r, c) = row.row.dot(block(row.node, column.node) * column.column);
    }
  }
  return matrix;
}

void Island::solve_once() {
  const std::vector<Unknown> unknowns = this->unknowns();
  constexpr std::size_t no_side = Unknown::no_side;
  const auto count = static_cast<Eigen::Index>(unknowns.size());
  const Eigen::MatrixXd matrix = response(unknowns);
  Eigen::VectorXd right(count);
  for (Eigen::Index r = 0; r < count; ++r) {
    const Unknown& row = unknowns[static_cast<std::size_t>(r)];
    right[r] = row.target - row.row.dot(nodes_[row.node].acceleration);
  }
  // Forces between nodes that brace each other, or of redundant pairs, are not unique; this is the least-squares
  // solution.
  const bool braced = std::any_of(nodes_.begin(), nodes_.end(), [](const auto& node) { return node.braced; });
  Eigen::VectorXd x;
  if (count > 0 && has_pairs_ && !braced) {
    std::vector<ForceCone> cones;
    for (Eigen::Index r = 0; r < count; ++r) {
      const Unknown& unknown = unknowns[static_cast<std::size_t>(r)];
      if (unknown.side == no_side) continue;
      const ContactNode& node = nodes_[unknown.node];
      const ContactSide& side = node.sides[unknown.side];
      if (side.pinned) continue;
      // On several surfaces only require that none pulls.
      const bool has_friction = node.sticks && active_normals(node).size() == 1;
      cones.push_back({r, has_friction, has_friction ? coefficient_of(side.friction) : 0.0});
    }
    Solution least = solve_least_squares(matrix, right, singular);
    x = std::move(least.x);
    if (least.kernel.cols() > 0 && margin_in_cones(x, cones) < 0.0)
      x = least_in_cones(x, least.row_space, least.kernel, cones);
  } else if (count > 0) {
    x = least_squares(matrix, right, singular);
  }
  if (braced && count > 0) {
    Eigen::FullPivLU<Eigen::MatrixXd> parts(matrix);
    const Eigen::MatrixXd kernel = parts.setThreshold(singular).kernel();
    std::vector<Cone> cones;
    Eigen::VectorXd base = Eigen::VectorXd::Zero(3 * count);
    Eigen::MatrixXd more = Eigen::MatrixXd::Zero(3 * count, kernel.cols());
    Eigen::Index rows = 0;
    for (Eigen::Index r = 0; r < count; ++r) {
      const Unknown& unknown = unknowns[static_cast<std::size_t>(r)];
      const ContactNode& node = nodes_[unknown.node];
      if (unknown.side == no_side || !node.sticks) continue;
      // On several surfaces only require that none pulls. On a holding one require the normal force that its friction
      // needs.
      const double mu = coefficient_of(node.sides[unknown.side].friction);
      cones.push_back({mu, mu >= friction_of_held ? 2.0 * x.norm() / friction_of_held : 0.0});
      const bool alone = active_normals(node).size() == 1;
      for (Eigen::Index k = 0; k < (alone ? 3 : 1); ++k) {
        base[rows + k] = x[r + k];
        more.row(rows + k) = kernel.row(r + k);
      }
      rows += 3;
    }
    if (const auto stress = min_norm_in_cones(base.head(rows), more.topRows(rows), cones)) x += kernel * *stress;
  }
  for (ContactNode& node : nodes_) {
    node.force.setZero();
    std::fill(node.normal_force.begin(), node.normal_force.end(), 0.0);
  }
  for (Eigen::Index r = 0; r < count; ++r) {
    const Unknown& unknown = unknowns[static_cast<std::size_t>(r)];
    ContactNode& node = nodes_[unknown.node];
    node.force += x[r] * unknown.column;
    if (unknown.side != no_side) node.normal_force[unknown.side] = x[r];
  }
}

Vector3 Island::acceleration(std::size_t node) const {
  Vector3 sum = nodes_[node].acceleration;
  for (std::size_t i = 0; i < nodes_.size(); ++i) sum += block(node, i) * nodes_[i].force;
  return sum;
}

bool Island::relax(double held_coefficient, int rounds, const std::vector<Vector3>& from) {
  std::vector<std::vector<Vector3>> forces;
  std::vector<Vector3> accelerations;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    forces.emplace_back(nodes_[i].sides.size(), Vector3::Zero());
    accelerations.push_back(nodes_[i].acceleration);
    if (from.empty()) continue;
    for (std::size_t k = 0; k < nodes_.size(); ++k) accelerations[i] += block(i, k) * from[k];
    std::vector<Vector3> normals;
    for (const ContactSide& side : nodes_[i].sides) normals.push_back(side.normal);
    forces[i] = share_reaction(normals, std::vector<double>(normals.size(), 0.0), from[i]);
  }
  double change = 0.0, size = 0.0;
  double change_before = std::numeric_limits<double>::infinity();  // at the last check
  for (int round = 0; round < rounds; ++round) {
    if (round % rounds_per_check == rounds_per_check - 1) {
      // At this rate it would not converge within all rounds.
      if (change > 0.5 * change_before) return false;
      change_before = change;
    }
    change = size = 0.0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      ContactNode& node = nodes_[i];
      for (std::size_t s = 0; s < node.sides.size(); ++s) {
        ContactSide& side = node.sides[s];
        if (side.separating) continue;
        const Vector3& n = side.normal;
        const Matrix3 mobility = block(i, i);
        // Relative to the surface, without this force.
        const Vector3 other = accelerations[i] - mobility * forces[i][s];
        Vector3 relative = other - side.surface_acceleration;
        relative += n * (n.dot(other) - side.target_acceleration - n.dot(relative));
        Vector3 now = Vector3::Zero();
        if (n.dot(relative) < 0.0 || side.pinned) {
          if (node.slipping) {
            const Vector3 direction = n - sliding_coefficient_of(side.friction) * node.slip;
            const double response = n.dot(mobility * direction);
            if (!(response > 0.0)) return false;
            now = -n.dot(relative) / response * direction;
          } else {
            const ContactResponse answer =
                solve_contact(mobility, relative, n, capped(side.friction, held_coefficient));
            if (answer.normal < 0.0 && !side.pinned) return false;
            now = answer.impulse;
            node.sticks = answer.sticks;
            const Vector3 sliding = answer.velocity - n * n.dot(answer.velocity);
            if (!answer.sticks && sliding.norm() > 0.0) node.slip = sliding.normalized();
          }
        }
        // Convergence is judged by accelerations: forces of nodes that brace each other may keep changing without
        // effect.
        const Vector3 more = now - forces[i][s];
        change = std::max(change, (mobility * more).norm());
        size = std::max(size, (mobility * now).norm());
        forces[i][s] = now;
        side.active = side.pinned || !now.isZero(0.0);
        for (std::size_t k = 0; k < nodes_.size(); ++k) accelerations[k] += block(k, i) * more;
      }
    }
    if (change <= 1e-13 * size) break;
  }
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].force.setZero();
    for (std::size_t s = 0; s < nodes_[i].sides.size(); ++s) {
      nodes_[i].force += forces[i][s];
      nodes_[i].normal_force[s] = nodes_[i].sides[s].normal.dot(forces[i][s]);
    }
  }
  return change <= 1e-9 * size;
}

void Island::begin_slip(std::size_t node) {
  ContactNode& slips = nodes_[node];
  const Vector3 tangential = project_onto(free_directions(active_normals(slips)), slips.force);
  slips.sticks = false;
  if (tangential.norm() > 0.0) slips.slip = -tangential.normalized();
}

bool Island::release_held(std::size_t node) {
  ContactNode& held = nodes_[node];
  if (!can_brace(held) || !held.sides[0].active) return false;
  ContactSide& side = held.sides[0];
  const Vector3 free = acceleration(node) - block(node, node) * held.force;
  if (side.normal.dot(free) <= side.target_acceleration) return false;
  side.active = held.braced = false;
  return true;
}

struct Island::Violation {
  enum class Kind { none, pulling, closing, outside_cone, slip_reversed };
  Kind kind = Kind::none;
  std::size_t node = 0, side = 0;
};

Island::Violation Island::find_violation(double negligible) const {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const ContactNode& node = nodes_[i];
    const double mobility = block(i, i).norm();
    const Vector3 a = acceleration(i);
    double limit = 0.0;
    const ContactSide* first = nullptr;
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      const ContactSide& side = node.sides[s];
      if (side.active) {
        if (!side.pinned && node.normal_force[s] < -negligible) return {Violation::Kind::pulling, i, s};
        // Of pairs with nearly the same normal, such as a face and the one before it beside whose border a node is now,
        // least squares hold all a little: those that others move apart are none.
        if (node.pair >= 0 && side.normal.dot(a) - side.target_acceleration > 10.0 * negligible * mobility)
          return {Violation::Kind::pulling, i, s};
        limit += friction_limit(coefficient_of(side.friction), std::max(0.0, node.normal_force[s]));
        if (first == nullptr) first = &side;
      } else if (!side.separating && side.normal.dot(a) - side.target_acceleration < -negligible * mobility) {
        return {Violation::Kind::closing, i, s};
      }
    }
    if (first == nullptr || node.slipping) continue;
    const std::vector<Vector3> directions = free_directions(active_normals(node));
    if (directions.empty()) continue;
    if (node.sticks) {
      if (limit - project_onto(directions, node.force).norm() < -negligible)
        return {Violation::Kind::outside_cone, i, 0};
    } else if (limit > 0.0 && node.slip.dot(a - first->surface_acceleration) < -negligible * mobility) {
      return {Violation::Kind::slip_reversed, i, 0};
    }
  }
  return {};
}

// Bits of each node: whether its sides are active, then whether it sticks.
std::uint64_t Island::active_set() const {
  std::uint64_t result = 0;
  for (const ContactNode& node : nodes_) {
    for (const ContactSide& side : node.sides) result = 2 * result + (side.active ? 1 : 0);
    result = 2 * result + (node.sticks ? 1 : 0);
  }
  return result;
}

std::size_t Island::bit_count() const {
  std::size_t bits = 0;
  for (const ContactNode& node : nodes_) bits += node.sides.size() + 1;
  return bits;
}

std::uint64_t Island::braced_set() const {
  std::uint64_t result = 0;
  for (const ContactNode& node : nodes_) result = 2 * result + (node.braced ? 1 : 0);
  return result;
}

void Island::set_active_set(std::uint64_t bits) {
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    const bool sticks = (bits & 1) != 0;
    bits >>= 1;
    for (auto side = node->sides.rbegin(); side != node->sides.rend(); ++side) {
      side->active = ((bits & 1) != 0 || side->pinned) && !side->separating;
      bits >>= 1;
    }
    node->sticks = sticks && !node->slipping && slip_friction(*node) > 0.0;
  }
}

bool Island::pivot(double negligible, std::set<std::size_t>& changed) {
  std::set<std::pair<std::uint64_t, std::uint64_t>> seen;
  std::vector<std::uint8_t> closed_before(nodes_.size(), 0);
  const bool is_stored = bit_count() <= max_stored;
  const auto is_new = [&] { return !is_stored || seen.emplace(active_set(), braced_set()).second; };
  for (int change = 0; change < max_pivots && is_new(); ++change) {
    solve();
    const Violation violation = find_violation(negligible);
    ContactNode& node = nodes_[violation.node];
    changed.insert(violation.node);
    switch (violation.kind) {
      case Violation::Kind::none:
        return true;
      case Violation::Kind::pulling:
        if (node.sticks) {
          begin_slip(violation.node);
          // A node that penetrated when released and is still pulled when braced: it slides.
          const bool slides = node.braced && !node.slip.isZero(0.0);
          node.sticks = !slides;
          node.braced = false;
          if (slides) break;
        }
        node.sides[violation.side].active = false;
        break;
      case Violation::Kind::closing: {
        ContactSide& side = node.sides[violation.side];
        side.active = true;
        // A side that cannot separate is held by bracing forces; if it closes a second time, it slides.
        node.sticks = !node.slipping && coefficient_of(side.friction) > 0.0 && closed_before[violation.node] == 0;
        node.braced = can_brace(node);
        closed_before[violation.node] = 1;
        break;
      }
      case Violation::Kind::outside_cone:
        begin_slip(violation.node);
        break;
      case Violation::Kind::slip_reversed:
        node.sticks = true;
        break;
    }
  }
  return false;
}

bool Island::enumerate(double negligible) {
  for (const bool braced : {false, true}) {
    for (std::uint64_t tried = 0; tried < (std::uint64_t{1} << bit_count()); ++tried) {
      set_active_set(tried);
      if (active_set() != tried) continue;
      for (ContactNode& node : nodes_) node.braced = braced && can_wedge(node);
      solve();
      if (find_violation(negligible).kind == Violation::Kind::none) return true;
    }
  }
  for (ContactNode& node : nodes_) node.braced = false;
  return false;
}

bool Island::resolve_impulses(double negligible) {
  for (ContactNode& node : nodes_) node.braced = false;
  std::set<std::size_t> changed;
  const std::uint64_t start = active_set();
  std::vector<Vector3> before;  // the present forces may be close
  for (const ContactNode& node : nodes_) before.push_back(node.force);
  // With many contacts one pivot costs as much as several rounds of the iteration.
  const bool is_large = bit_count() > max_pivoted;
  if (!is_large && pivot(negligible, changed) && directions_fit_) return true;
  // A holding contact whose normal force vanishes can neither hold nor open; the friction coefficient that replaces it
  // hardly matters.
  bool relaxed = false;
  for (const double held_coefficient : {friction_of_held, 1.0}) {
    if (bit_count() <= max_stored) set_active_set(start);
    if ((relaxed = relax(held_coefficient, is_large ? Island::max_rounds : Island::max_rounds / 10, before))) break;
  }
  if (!relaxed && is_large && bit_count() <= max_stored) set_active_set(start);
  if (!relaxed && is_large && pivot(negligible, changed) && directions_fit_) return true;
  if (!relaxed) {
    const std::vector<ContactNode> nearly = nodes_;
    if (bit_count() <= max_bits && enumerate(negligible)) return true;
    nodes_ = nearly;
    const bool holds = std::any_of(nodes_.begin(), nodes_.end(), [](const ContactNode& node) {
      return std::any_of(node.sides.begin(), node.sides.end(),
                         [](const ContactSide& side) { return side.friction.kind == Friction::Kind::held; });
    });
    if (!holds || bit_count() > max_stored) return false;
    // The rule of holding surfaces has no solution: keep all contacts for this step, as for a node without connections.
    set_active_set(start);
    solve();
    return true;
  }
  if (is_large) return true;
  // From this active set the forces may have an exact solution.
  const std::vector<ContactNode> found = nodes_;
  solve();
  if (!directions_fit_ || find_violation(negligible).kind != Violation::Kind::none) nodes_ = found;
  return true;
}

// Faces on faces have more pairs than forces are determined by: where no forces of the active set fit all cones, those
// of relax() may still be inside and give the same motion.
bool Island::solves_as_relaxed() {
  constexpr double same = 1e-6;
  std::vector<Vector3> relaxed;
  double scale = 0.0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    relaxed.push_back(acceleration(i));
    scale = std::max(scale, (relaxed.back() - nodes_[i].acceleration).norm());
  }
  solve();
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if ((acceleration(i) - relaxed[i]).norm() > same * scale) return false;
  return true;
}

// Sides that were active and that the iteration has no need of, but does not open either, stay: which of redundant ones
// it takes is chance.
void Island::keep_touching(const std::vector<ContactNode>& before, double negligible) {
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    for (std::size_t s = 0; s < nodes_[i].sides.size(); ++s) {
      ContactSide& side = nodes_[i].sides[s];
      if (side.active || side.separating || !before[i].sides[s].active) continue;
      const double opens = side.normal.dot(acceleration(i)) - side.target_acceleration;
      side.active = opens <= 10.0 * negligible * block(i, i).norm();
    }
}

bool Island::resolve(double negligible, bool thoroughly) {
  std::set<std::size_t> changed;
  const std::uint64_t start = active_set();
  const std::size_t bits = bit_count();
  // Faces on faces have more pairs than determine forces: pivots run in circles.
  if (thoroughly && has_pairs_ && bits > max_pivoted) {
    const std::vector<ContactNode> before = nodes_;
    // Redundant forces, and with them friction, may be shared in another way than the iteration has them: from its
    // active set a few pivots lead to one that fits.
    if (relax(friction_of_held, Island::max_rounds, {})) {
      keep_touching(before, negligible);
      if (solves_as_relaxed() || pivot(negligible, changed)) return true;
    }
    nodes_ = before;
  }
  if (pivot(negligible, changed)) return true;
  if (thoroughly && bits <= max_bits && enumerate(negligible)) return true;
  if (bits <= max_stored) set_active_set(start);
  if (thoroughly && relax(friction_of_held, Island::max_rounds, {})) {
    if (has_pairs_ && solves_as_relaxed()) return true;
    if (!has_pairs_) solve();
    if (find_violation(1e3 * negligible).kind == Violation::Kind::none) return true;
  }
  jammed_.clear();
  for (const std::size_t i : changed)
    if (nodes_[i].slipping) jammed_.push_back(i);
  if (jammed_.empty()) jammed_.assign(changed.begin(), changed.end());
  if (bits <= max_stored) set_active_set(start);
  return false;
}

void Island::hold(double negligible) {
  std::set<std::pair<std::size_t, std::size_t>> kept;
  while (true) {
    solve();
    double most = -negligible;
    std::size_t node = nodes_.size(), side = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      for (std::size_t s = 0; s < nodes_[i].sides.size(); ++s) {
        if (!nodes_[i].sides[s].active || nodes_[i].normal_force[s] >= most || kept.contains({i, s})) continue;
        most = nodes_[i].normal_force[s];
        node = i;
        side = s;
      }
    }
    if (node == nodes_.size()) return;
    // Release a pulling side if its gap then opens; each is tried once.
    kept.emplace(node, side);
    ContactSide& pulls = nodes_[node].sides[side];
    pulls.active = false;
    solve();
    if (pulls.normal.dot(acceleration(node)) - pulls.target_acceleration < 0.0) pulls.active = true;
  }
}

}  // namespace springnet
