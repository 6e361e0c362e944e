#include "constraints/island.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <set>

#include "constraints/friction.hpp"

namespace springnet {
namespace {

constexpr int most_rounds = 10'000;     // of impulses that depend on each other
constexpr int most_changes = 200;       // of mind, before all possibilities are tried
constexpr std::size_t most_coded = 64;  // bits of a code
constexpr int most_bits = 12;           // of possibilities that are worth trying
constexpr int most_directions = 200;    // of a slip that begins

// The directions in which a node with these normals can slide: two, one (along an edge) or none.
std::vector<Vector3> free_directions(const std::vector<Vector3>& normals) {
  if (normals.size() == 1) {
    const Vector3 e = normals[0].unitOrthogonal();
    return {e, normals[0].cross(e)};
  }
  if (normals.size() == 2) {
    const Vector3 e = normals[0].cross(normals[1]);
    if (e.norm() > 1e-12) return {e.normalized()};
  }
  return {};
}

std::vector<Vector3> active_normals(const ContactNode& node) {
  std::vector<Vector3> normals;
  for (const ContactSide& side : node.sides)
    if (side.touches) normals.push_back(side.normal);
  return normals;
}

// What of a vector lies in the directions in which a node can slide.
Vector3 along(const std::vector<Vector3>& directions, const Vector3& v) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& e : directions) sum += e * e.dot(v);
  return sum;
}

// A surface that holds what touches it takes it along when its own velocity jumps.
bool is_taken_along(const ContactSide& side) {
  return side.touches && side.friction.kind == Friction::Kind::held && !side.velocity.isZero(0.0) &&
         side.normal.dot(side.velocity) <= 0.0;
}

double slip_friction(const ContactNode& node) {
  double sum = 0.0;
  for (std::size_t s = 0; s < node.sides.size(); ++s)
    if (node.sides[s].touches) sum += sliding_coefficient_of(node.sides[s].friction);
  return sum;
}

}  // namespace

SplitReaction split_reaction(const std::vector<Vector3>& normals, const Vector3& reaction) {
  SplitReaction result;
  if (normals.size() == 1) {
    const double pressing = normals[0].dot(reaction);
    return {{pressing}, reaction - pressing * normals[0]};
  }
  Eigen::Matrix<double, 3, Eigen::Dynamic> n(3, static_cast<Eigen::Index>(normals.size()));
  for (std::size_t i = 0; i < normals.size(); ++i) n.col(static_cast<Eigen::Index>(i)) = normals[i];
  const Eigen::VectorXd shares = n.completeOrthogonalDecomposition().solve(reaction);
  result.normal.assign(shares.begin(), shares.end());
  result.along = reaction - n * shares;
  return result;
}

Island::Island(std::vector<ContactNode> nodes, Eigen::MatrixXd mobility)
    : nodes_(std::move(nodes)), mobility_(std::move(mobility)) {
  for (ContactNode& node : nodes_) {
    node.normal_force.assign(node.sides.size(), 0.0);
    node.impulse.assign(node.sides.size(), Vector3::Zero());
  }
}

void Island::push(std::size_t node, const Vector3& impulse) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Vector3 change = block(i, node) * impulse;
    for (ContactSide& side : nodes_[i].sides) side.velocity += change;
  }
}

bool Island::strike(double rebound, double negligible) {
  struct Blow {
    std::size_t node, side;
    double wanted;  // m/s, of the gap afterwards
  };
  std::vector<Blow> blows;
  bool approaches = false;
  double scale = 0.0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    for (std::size_t s = 0; s < nodes_[i].sides.size(); ++s) {
      const ContactSide& side = nodes_[i].sides[s];
      const double rate = side.normal.dot(side.velocity);
      approaches = approaches || rate < -negligible || is_taken_along(side);
      scale = std::max(scale, side.velocity.norm());
      blows.push_back({i, s, rate < -rebound ? -side.restitution * rate : 0.0});
      nodes_[i].impulse[s].setZero();
    }
  }
  if (!approaches) return false;
  for (int round = 0; round < most_rounds; ++round) {
    double greatest = 0.0;
    for (const Blow& blow : blows) {
      ContactSide& side = nodes_[blow.node].sides[blow.side];
      Vector3& impulse = nodes_[blow.node].impulse[blow.side];
      const Matrix3 mobility = block(blow.node, blow.node);
      // As if this one had not struck yet, seen from a surface that comes along as fast as it should leave.
      const Vector3 before = side.velocity - mobility * impulse - blow.wanted * side.normal;
      Vector3 now = Vector3::Zero();
      if (side.normal.dot(before) < -negligible || !impulse.isZero(0.0) || is_taken_along(side)) {
        const ContactAnswer answer = answer_contact(mobility, before, side.normal, side.friction);
        if (answer.normal > 0.0 || (answer.normal == 0.0 && answer.sticks)) now = answer.impulse;
      }
      const Vector3 change = now - impulse;
      if (change.isZero(0.0)) continue;
      greatest = std::max(greatest, (mobility * change).norm());
      impulse = now;
      push(blow.node, change);
    }
    if (greatest <= 1e-15 * scale) break;
  }
  return true;
}

void Island::calm(double slow) {
  for (int round = 0; round < most_rounds; ++round) {
    double greatest = 0.0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      for (std::size_t s = 0; s < nodes_[i].sides.size(); ++s) {
        const ContactSide& side = nodes_[i].sides[s];
        const double rate = side.normal.dot(side.velocity), answers = side.normal.dot(block(i, i) * side.normal);
        if (rate == 0.0 || std::abs(rate) > slow || !(answers > 0.0)) continue;
        const Vector3 impulse = -rate / answers * side.normal;
        nodes_[i].impulse[s] += impulse;
        push(i, impulse);
        greatest = std::max(greatest, std::abs(rate));
      }
    }
    if (greatest <= 1e-12 * slow) break;
  }
  for (ContactNode& node : nodes_)
    for (ContactSide& side : node.sides)
      if (const double rate = side.normal.dot(side.velocity); std::abs(rate) <= 1e-9 * slow)
        side.velocity -= rate * side.normal;
}

bool Island::jam(double negligible) {
  bool any = false;
  for (const std::size_t i : jammed_) {
    ContactNode& node = nodes_[i];
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      ContactSide& side = node.sides[s];
      if (side.friction.kind == Friction::Kind::none || side.velocity.norm() <= negligible) continue;
      const Matrix3 mobility = block(i, i);
      const Vector3 impulse = -mobility.completeOrthogonalDecomposition().solve(side.velocity);
      if (!(side.normal.dot(impulse) >= 0.0) || impulse.isZero(0.0)) continue;
      node.impulse[s] += impulse;
      push(i, impulse);
      side.velocity.setZero();
      node.moves = false;
      node.sticks = true;
      any = true;
      break;
    }
  }
  return any;
}

void Island::solve_once() {
  struct Unknown {
    std::size_t node;
    Vector3 row, column;
    double wanted;
    std::size_t side;  // of a normal force
  };
  constexpr std::size_t no_side = 3;
  std::vector<Unknown> unknowns;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const ContactNode& node = nodes_[i];
    const std::vector<Vector3> directions = free_directions(active_normals(node));
    const ContactSide* first = nullptr;
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      const ContactSide& side = node.sides[s];
      if (!side.touches) continue;
      if (first == nullptr) first = &side;
      Vector3 column = side.normal;
      if (!node.sticks) column -= sliding_coefficient_of(side.friction) * along(directions, node.slip);
      unknowns.push_back({i, side.normal, column, side.needed, s});
    }
    if (first == nullptr || !node.sticks) continue;
    for (const Vector3& e : directions) unknowns.push_back({i, e, e, e.dot(first->surface_acceleration), no_side});
  }
  const auto count = static_cast<Eigen::Index>(unknowns.size());
  Eigen::MatrixXd matrix(count, count);
  Eigen::VectorXd right(count);
  for (Eigen::Index r = 0; r < count; ++r) {
    const Unknown& row = unknowns[static_cast<std::size_t>(r)];
    right[r] = row.wanted - row.row.dot(nodes_[row.node].acceleration);
    for (Eigen::Index c = 0; c < count; ++c) {
      const Unknown& column = unknowns[static_cast<std::size_t>(c)];
      matrix(r, c) = row.row.dot(block(row.node, column.node) * column.column);
    }
  }
  const Eigen::VectorXd x =
      count > 0 ? Eigen::VectorXd(matrix.completeOrthogonalDecomposition().solve(right)) : Eigen::VectorXd();
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

// A slip that begins goes where its acceleration goes, which friction against it turns where the effective mass has
// directions of its own.
void Island::solve() {
  for (int turn = 0; turn < most_directions; ++turn) {
    solve_once();
    double turned = 0.0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      ContactNode& node = nodes_[i];
      if (node.sticks || node.moves || slip_friction(node) == 0.0) continue;
      const auto first = std::find_if(node.sides.begin(), node.sides.end(), [](const auto& s) { return s.touches; });
      if (first == node.sides.end()) continue;
      const Vector3 goes = along(free_directions(active_normals(node)), acceleration(i) - first->surface_acceleration);
      // Too little to have a direction of its own, at the edge of the cone, or against what was assumed: it would
      // stick.
      const double scale = (acceleration(i) - nodes_[i].acceleration).norm();
      if (goes.norm() <= 1e-6 * scale || goes.dot(node.slip) < 0.0) continue;
      const Vector3 slip = goes.normalized();
      turned = std::max(turned, (slip - node.slip).norm());
      // Half the way, because great friction would overshoot.
      node.slip = turn < 20 ? slip : Vector3((slip + node.slip).normalized());
    }
    if (turned <= 1e-14) return;
  }
}

bool Island::relax() {
  std::vector<Vector3> forces(nodes_.size(), Vector3::Zero());
  std::vector<Vector3> accelerations;
  for (const ContactNode& node : nodes_) accelerations.push_back(node.acceleration);
  double change = 0.0, size = 0.0;
  for (int round = 0; round < most_rounds; ++round) {
    change = size = 0.0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      ContactNode& node = nodes_[i];
      if (node.sides.size() != 1 || node.sides[0].leaves) continue;
      const ContactSide& side = node.sides[0];
      const Vector3& n = side.normal;
      const Matrix3 mobility = block(i, i);
      // Of the node against its surface, as if its own force did not act.
      const Vector3 other = accelerations[i] - mobility * forces[i];
      Vector3 relative = other - side.surface_acceleration;
      relative += n * (n.dot(other) - side.needed - n.dot(relative));
      Vector3 now = Vector3::Zero();
      if (n.dot(relative) < 0.0) {
        if (node.moves) {
          const Vector3 direction = n - sliding_coefficient_of(side.friction) * node.slip;
          const double answers = n.dot(mobility * direction);
          if (!(answers > 0.0)) return false;
          now = -n.dot(relative) / answers * direction;
        } else {
          const ContactAnswer answer = answer_contact(mobility, relative, n, side.friction);
          if (answer.normal < 0.0) return false;
          now = answer.impulse;
          node.sticks = answer.sticks;
          const Vector3 goes = answer.velocity - n * n.dot(answer.velocity);
          if (!answer.sticks && goes.norm() > 0.0) node.slip = goes.normalized();
        }
      }
      change = std::max(change, (now - forces[i]).norm());
      size = std::max(size, now.norm());
      const Vector3 more = now - forces[i];
      forces[i] = now;
      node.sides[0].touches = !now.isZero(0.0);
      for (std::size_t k = 0; k < nodes_.size(); ++k) accelerations[k] += block(k, i) * more;
    }
    if (change <= 1e-13 * size) return true;
  }
  return change <= 1e-9 * size;
}

void Island::begin_slip(std::size_t node) {
  ContactNode& slips = nodes_[node];
  const Vector3 grip = along(free_directions(active_normals(slips)), slips.force);
  slips.sticks = false;
  if (grip.norm() > 0.0) slips.slip = -grip.normalized();
}

struct Island::Violation {
  enum class Kind { none, pulls, shrinks, slips, rests };
  Kind kind = Kind::none;
  std::size_t node = 0, side = 0;
};

Island::Violation Island::find_violation(double negligible) const {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const ContactNode& node = nodes_[i];
    const double mobility = block(i, i).norm();
    const Vector3 a = acceleration(i);
    double bears = 0.0;
    const ContactSide* first = nullptr;
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      const ContactSide& side = node.sides[s];
      if (side.touches) {
        if (node.normal_force[s] < -negligible) return {Violation::Kind::pulls, i, s};
        bears += coefficient_of(side.friction) * std::max(0.0, node.normal_force[s]);
        if (std::isinf(coefficient_of(side.friction))) bears = coefficient_of(side.friction);
        if (first == nullptr) first = &side;
      } else if (!side.leaves && side.normal.dot(a) - side.needed < -negligible * mobility) {
        return {Violation::Kind::shrinks, i, s};
      }
    }
    if (first == nullptr || node.moves) continue;
    const std::vector<Vector3> directions = free_directions(active_normals(node));
    if (directions.empty()) continue;
    if (node.sticks) {
      if (along(directions, node.force).norm() > bears + negligible) return {Violation::Kind::slips, i, 0};
    } else if (bears > 0.0 && node.slip.dot(a - first->surface_acceleration) < -negligible * mobility) {
      return {Violation::Kind::rests, i, 0};
    }
  }
  return {};
}

// What is set, in bits: a node's sides, then whether it sticks.
std::uint64_t Island::code() const {
  std::uint64_t result = 0;
  for (const ContactNode& node : nodes_) {
    for (const ContactSide& side : node.sides) result = 2 * result + (side.touches ? 1 : 0);
    result = 2 * result + (node.sticks ? 1 : 0);
  }
  return result;
}

void Island::set_code(std::uint64_t code) {
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    node->sticks = (code & 1) != 0 && !node->moves && slip_friction(*node) > 0.0;
    code >>= 1;
    for (auto side = node->sides.rbegin(); side != node->sides.rend(); ++side) {
      side->touches = (code & 1) != 0 && !side->leaves;
      code >>= 1;
    }
  }
}

bool Island::resolve(double negligible) {
  std::set<std::uint64_t> seen;
  std::set<std::size_t> changed;
  const std::uint64_t start = code();
  std::vector<std::uint8_t> came_back(nodes_.size(), 0);
  std::size_t bits = 0;
  for (const ContactNode& node : nodes_) bits += node.sides.size() + 1;
  for (int change = 0; change < most_changes && (bits > most_coded || seen.insert(code()).second); ++change) {
    solve();
    const Violation violation = find_violation(negligible);
    ContactNode& node = nodes_[violation.node];
    changed.insert(violation.node);
    switch (violation.kind) {
      case Violation::Kind::none:
        return true;
      case Violation::Kind::pulls:
        if (node.sticks) {
          begin_slip(violation.node);
          node.sticks = true;
        }
        node.sides[violation.side].touches = false;
        break;
      case Violation::Kind::shrinks: {
        ContactSide& side = node.sides[violation.side];
        side.touches = true;
        // What could neither hold nor let go slides.
        node.sticks = !node.moves && coefficient_of(side.friction) > 0.0 && came_back[violation.node] == 0;
        came_back[violation.node] = 1;
        break;
      }
      case Violation::Kind::slips:
        begin_slip(violation.node);
        break;
      case Violation::Kind::rests:
        node.sticks = true;
        break;
    }
  }
  if (bits <= most_bits) {
    for (std::uint64_t tried = 0; tried < (std::uint64_t{1} << bits); ++tried) {
      set_code(tried);
      if (code() != tried) continue;
      solve();
      if (find_violation(negligible).kind == Violation::Kind::none) return true;
    }
  }
  if (bits <= most_coded) set_code(start);
  if (relax()) {
    solve();
    if (find_violation(1e3 * negligible).kind == Violation::Kind::none) return true;
  }
  jammed_.clear();
  for (const std::size_t i : changed)
    if (nodes_[i].moves) jammed_.push_back(i);
  if (jammed_.empty()) jammed_.assign(changed.begin(), changed.end());
  if (bits <= most_coded) set_code(start);
  return false;
}

}  // namespace springnet
