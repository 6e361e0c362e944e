// Impulses of an island: impact, end of slip, rocking, jamming.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "constraints/friction.hpp"
#include "constraints/island.hpp"
#include "constraints/island_directions.hpp"
#include "constraints/least_squares.hpp"

namespace springnet {
namespace {

// Coupled impulses have converged when they change velocities by at most this share of the fastest: with contacts that
// brace each other convergence is slow. The rest is below the speeds that events resolve.
constexpr double nearly = 1e-7;

double cube(double x) { return x * x * x; }

// A holding surface carries its nodes when its own velocity jumps.
bool is_carried_along(const ContactSide& side) {
  return side.active && side.friction.kind == Friction::Kind::held && !side.velocity.isZero(0.0) &&
         side.normal.dot(side.velocity) <= 0.0;
}

}  // namespace

void Island::apply_impulse(std::size_t node, const Vector3& impulse) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Vector3 change = block(i, node) * impulse;
    for (ContactSide& side : nodes_[i].sides) side.velocity += change;
  }
}

bool Island::apply_impact(double rebound, double negligible, int rounds, bool warm_start) {
  struct Impact {
    std::size_t node, side;
    double target;  // m/s, of the gap afterwards
  };
  std::vector<Impact> impacts;
  bool approaches = false;
  double scale = 0.0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    for (std::size_t s = 0; s < nodes_[i].sides.size(); ++s) {
      const ContactSide& side = nodes_[i].sides[s];
      const double rate = side.normal.dot(side.velocity);
      approaches = approaches || rate < -negligible || is_carried_along(side);
      scale = std::max(scale, side.velocity.norm());
      impacts.push_back({i, s, rate < -rebound ? -side.restitution * rate : 0.0});
      if (!warm_start) nodes_[i].impulse[s].setZero();
    }
  }
  if (!approaches) return false;
  const std::vector<ContactNode> start = nodes_;
  for (std::size_t i = 0; warm_start && i < nodes_.size(); ++i)
    for (const Vector3& impulse : nodes_[i].impulse) apply_impulse(i, impulse);
  bool converged = false;
  for (int round = 0; round < rounds; ++round) {
    double greatest = 0.0;
    for (const Impact& impact : impacts) {
      ContactSide& side = nodes_[impact.node].sides[impact.side];
      Vector3& impulse = nodes_[impact.node].impulse[impact.side];
      const Matrix3 mobility = block(impact.node, impact.node);
      // Without this impulse, and relative to the target gap rate.
      const Vector3 before = side.velocity - mobility * impulse - impact.target * side.normal;
      Vector3 now = Vector3::Zero();
      if (side.normal.dot(before) < -negligible || !impulse.isZero(0.0) || is_carried_along(side)) {
        const ContactResponse answer = solve_contact(mobility, before, side.normal, side.friction);
        if (answer.normal > 0.0 || (answer.normal == 0.0 && answer.sticks)) now = answer.impulse;
      }
      const Vector3 change = now - impulse;
      if (change.isZero(0.0)) continue;
      greatest = std::max(greatest, (mobility * change).norm());
      impulse = now;
      apply_impulse(impact.node, change);
    }
    converged = greatest <= nearly * scale;
    if (greatest <= 1e-15 * scale) break;
  }
  if (converged || rounds < max_rounds) return true;
  stop_all(start, nearly * scale);
  return true;
}

double Island::approach() const {
  double fastest = 0.0;
  for (const ContactNode& node : nodes_)
    for (const ContactSide& side : node.sides) fastest = std::max(fastest, -side.normal.dot(side.velocity));
  return fastest;
}

// Fallback if the iteration did not converge: impulses that stop all approach and all slip at once. They dissipate more
// energy than any others.
void Island::stop_all(const std::vector<ContactNode>& start, double negligible) {
  std::vector<std::uint8_t> included(nodes_.size(), 1);
  std::vector<ContactNode> before;
  for (bool again = true; again;) {
    again = false;
    std::vector<Row> rows;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      for (std::size_t s = 0; s < nodes_[i].sides.size() && included[i] != 0; ++s) {
        const ContactSide& side = start[i].sides[s];
        rows.push_back({i, s, side.normal});
        if (s > 0 || coefficient_of(side.friction) == 0.0) continue;
        for (const Vector3& e : free_directions(normals_of(start[i]))) rows.push_back({i, s, e});
      }
    }
    nodes_ = start;
    end_rates(rows);
    // Undo the last release if it lets a node penetrate.
    if (!before.empty() && approach() > negligible) {
      nodes_ = before;
      return;
    }
    before = nodes_;
    // Release nodes that their surfaces would have to pull.
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      double normal_impulse = 0.0, size = 0.0;
      for (std::size_t s = 0; s < nodes_[i].sides.size(); ++s) {
        normal_impulse += nodes_[i].sides[s].normal.dot(nodes_[i].impulse[s]);
        size += nodes_[i].impulse[s].norm();
      }
      if (included[i] == 0 || normal_impulse >= -1e-9 * size) continue;
      included[i] = 0;
      again = true;
    }
  }
}

bool Island::end_slip(double negligible) {
  std::vector<Row> rows;
  double fastest = 0.0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const ContactNode& node = nodes_[i];
    // No contact may open or close.
    for (std::size_t s = 0; s < node.sides.size(); ++s)
      if (std::abs(node.sides[s].normal.dot(node.sides[s].velocity)) <= negligible)
        rows.push_back({i, s, node.sides[s].normal});
    if (node.sides.empty()) continue;
    const std::vector<Vector3> directions = free_directions(normals_of(node));
    const double speed = project_onto(directions, node.sides.front().velocity).norm();
    // Nor may bodies that stick begin to slip: their slip would end with the impulse that makes others slip.
    const ContactSide& front = node.sides.front();
    const bool stays = has_pairs_ && speed <= negligible && coefficient_of(front.friction) > 0.0 &&
                       std::abs(front.normal.dot(front.velocity)) <= negligible;
    if (!node.slip_ended && !stays) continue;
    for (const Vector3& e : directions) rows.push_back({i, 0, e});
    if (node.slip_ended) fastest = std::max(fastest, speed);
  }
  if (fastest > 0.0) end_rates(rows);
  return fastest > 0.0;
}

// Applies the smallest impulses along these directions that end the velocities along them.
void Island::end_rates(const std::vector<Row>& rows) {
  const auto count = static_cast<Eigen::Index>(rows.size());
  if (count == 0) return;
  Eigen::MatrixXd matrix(count, count);
  Eigen::VectorXd rates(count);
  for (Eigen::Index r = 0; r < count; ++r) {
    const Row& row = rows[static_cast<std::size_t>(r)];
    rates[r] = row.direction.dot(nodes_[row.node].sides[row.side].velocity);
    for (Eigen::Index c = 0; c < count; ++c) {
      const Row& column = rows[static_cast<std::size_t>(c)];
      matrix(r, c) = row.direction.dot(block(row.node, column.node) * column.direction);
    }
  }
  // Of contacts that brace each other only rounding is left below the threshold; of bodies on each other, whose pairs
  // are redundant but for the shape of faces, errors of integration.
  const Eigen::VectorXd impulses = least_squares(matrix, -rates, has_pairs_ ? 1e-7 : 1e-11);
  for (Eigen::Index r = 0; r < count; ++r) {
    const Row& row = rows[static_cast<std::size_t>(r)];
    nodes_[row.node].impulse[row.side] += impulses[r] * row.direction;
    apply_impulse(row.node, impulses[r] * row.direction);
  }
}

void Island::end_rocking(double slow, bool pulls) {
  for (int round = 0; round < max_rounds; ++round) {
    double greatest = 0.0;
    const auto apply = [&](std::size_t i, std::size_t s, const Vector3& impulse, double speed) {
      nodes_[i].impulse[s] += impulse;
      apply_impulse(i, impulse);
      greatest = std::max(greatest, speed);
    };
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      for (std::size_t s = 0; s < nodes_[i].sides.size(); ++s) {
        const ContactSide& side = nodes_[i].sides[s];
        const double rate = side.normal.dot(side.velocity), response = side.normal.dot(block(i, i) * side.normal);
        if (rate == 0.0 || std::abs(rate) > slow || !(response > 0.0)) continue;
        if (pulls) {
          apply(i, s, -rate / response * side.normal, std::abs(rate));
          continue;
        }
        // Pairs of several faces at one place would otherwise push each other apart. What pulls already stays.
        const double pushed = std::max(0.0, side.normal.dot(nodes_[i].impulse[s]));  // N s
        const double impulse = std::max(-rate / response, -pushed);
        if (impulse != 0.0) apply(i, s, impulse * side.normal, std::abs(impulse) * response);
      }
      if (nodes_[i].sides.empty() || (nodes_[i].pair >= 0 && !pulls)) continue;
      // Friction also ends slip below this speed.
      const ContactSide& first = nodes_[i].sides.front();
      const double speed = first.velocity.norm();
      if (coefficient_of(first.friction) == 0.0 || speed == 0.0 || speed > slow) continue;
      apply(i, 0, -least_squares(block(i, i), first.velocity), speed);
    }
    if (greatest <= 1e-12 * slow) break;
  }
  for (ContactNode& node : nodes_) {
    for (ContactSide& side : node.sides) {
      if (const double rate = side.normal.dot(side.velocity); std::abs(rate) <= 1e-9 * slow)
        side.velocity -= rate * side.normal;
      if (coefficient_of(side.friction) > 0.0 && side.velocity.norm() <= 1e-9 * slow) side.velocity.setZero();
    }
  }
}

// Of contacts that touch and press, or that forces would close, and of nodes that stick.
std::vector<Island::Row> Island::kept_rows() const {
  std::vector<Row> rows;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const ContactNode& node = nodes_[i];
    const Vector3 a = acceleration(i);
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      const ContactSide& side = node.sides[s];
      if (!side.separating && (side.active || side.target_acceleration > side.normal.dot(a)))
        rows.push_back({i, s, side.normal});
    }
    if (node.sticks) add_across(i, rows);
  }
  return rows;
}

void Island::add_across(std::size_t i, std::vector<Row>& rows) const {
  const ContactNode& node = nodes_[i];
  const auto first = std::find_if(node.sides.begin(), node.sides.end(), [](const auto& side) { return side.active; });
  if (first == node.sides.end()) return;
  const auto place = static_cast<std::size_t>(first - node.sides.begin());
  for (const Vector3& e : free_directions(active_normals(node))) rows.push_back({i, place, e});
}

bool Island::end_returns(double depth) {
  if (!has_pairs_) return false;
  std::vector<Row> rows = kept_rows(), returning;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Vector3 a = acceleration(i);
    for (std::size_t s = 0; s < nodes_[i].sides.size(); ++s) {
      const ContactSide& side = nodes_[i].sides[s];
      const double rate = side.normal.dot(side.velocity);
      const double closes = side.target_acceleration - side.normal.dot(a);
      if (side.separating && closes > 0.0 && rate * rate <= 2.0 * closes * depth)
        returning.push_back({i, s, side.normal});
    }
  }
  if (returning.empty()) return false;
  const auto fastest = [&] {
    double result = 0.0;
    for (const Row& row : returning)
      result = std::max(result, row.direction.dot(nodes_[row.node].sides[row.side].velocity));
    return result;
  };
  const double before = fastest();
  for (const Row& row : returning) nodes_[row.node].sides[row.side].active = true;
  rows.insert(rows.end(), returning.begin(), returning.end());
  end_rates(rows);
  // Of masses that differ too much the impulses are lost in rounding.
  return fastest() <= 0.5 * before;
}

bool Island::end_short_slips(double distance, bool began, double slow, double negligible) {
  if (!has_pairs_) return false;
  const auto slip_of = [this](std::size_t i) -> Vector3 {
    const ContactNode& node = nodes_[i];
    const auto side = std::find_if(node.sides.begin(), node.sides.end(), [](const auto& s) { return s.active; });
    return project_onto(free_directions(active_normals(node)), side->velocity);
  };
  std::vector<Row> rows = kept_rows();
  std::vector<std::size_t> ending;
  double fastest = 0.0, left = 0.0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const ContactNode& node = nodes_[i];
    if (!node.slipping || node.slip_starting || slip_friction(node) == 0.0) continue;
    const Vector3 slip = slip_of(i);
    const double speed = slip.norm(), slows = -slip.dot(slides(i));  // m/s, m^2/s^3
    if (began && node.slid && speed > slow) continue;
    if (speed <= negligible || !(slows > 0.0) || cube(speed) > 2.0 * slows * distance) continue;
    ending.push_back(i);
    add_across(i, rows);
    fastest = std::max(fastest, speed);
  }
  if (ending.empty()) return false;
  const std::vector<ContactNode> before = nodes_;
  end_rates(rows);
  for (const std::size_t i : ending) left = std::max(left, slip_of(i).norm());
  // No contact may close, and impulses may be lost in rounding, as those of masses that differ too much.
  if (left > 0.5 * fastest || approach() > negligible) {
    nodes_ = before;
    return false;
  }
  for (const std::size_t i : ending) nodes_[i].slip_ended = true;
  return true;
}

bool Island::jam(double negligible) {
  bool any = false;
  for (const std::size_t i : jammed_) {
    ContactNode& node = nodes_[i];
    for (std::size_t s = 0; s < node.sides.size(); ++s) {
      ContactSide& side = node.sides[s];
      if (side.friction.kind == Friction::Kind::none || side.velocity.norm() <= negligible) continue;
      const Matrix3 mobility = block(i, i);
      const Vector3 impulse = -least_squares(mobility, side.velocity);
      if (!(side.normal.dot(impulse) >= 0.0) || impulse.isZero(0.0)) continue;
      node.impulse[s] += impulse;
      apply_impulse(i, impulse);
      side.velocity.setZero();
      node.slipping = false;
      node.sticks = true;
      any = true;
      break;
    }
  }
  return any;
}

}  // namespace springnet
