// Rigid connections within the sweeps of a step. A cluster's nodes have outputs that each would like alone; their
// velocities get impulses along the connections, at the positions where they end, so that no length changes,
//
//   U = U_free + W G(P)^T x,    G(P) U = 0,    P = p + h ((1 - theta) v + theta U) + (1/m) G(P)^T y,    lengths(P) = l,
//
// W the inverse of the inertia with which the outputs were made. Surfaces that the nodes slide on are rows of G as
// well; nodes that are fixed, moved or held by a surface do not move for any impulse.

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "constraints/rigid.hpp"
#include "constraints/vectors.hpp"
#include "layers/message.hpp"

namespace springnet {
namespace {

constexpr int most_turns = 60;    // of positions and velocities that depend on each other
constexpr int most_changes = 6;   // of mind on one node's contact, within a sweep
constexpr int most_rounds = 100;  // of contacts and their friction
constexpr double accuracy = 1e-13;

}  // namespace

struct RigidConnections::Step {
  struct Member {
    std::uint32_t node;
    bool fixed;
    Vector3 start, start_velocity;  // m, m/s, at the beginning of the step
    Vector3 free_position, free;    // m, m/s: outputs as if there were no constraint
    Eigen::Matrix3d inertia, mobility;
    Vector3 place, place_velocity;       // of a node that is fixed, moved or held
    Vector3 friction = Vector3::Zero();  // N s
    Vector3 velocity = Vector3::Zero();  // results
    int changes = 0;
    bool is_new = false;   // its contact
    double rebound = 0.0;  // m/s, off the surface that it met
  };
  const Placement& at;  // the end of the step
  const Cluster& cluster;
  double h, theta;
  bool decides;  // which nodes touch, slide and stick
  std::vector<Member> members;
  std::vector<Touch> touches;       // [member]
  std::vector<Vector3> positions;   // [member] m
  std::vector<std::uint8_t> moves;  // [member] 0: it stays at its place
  ConstraintSystem system{};
  Eigen::VectorXd multipliers{};  // N s
};

// Velocities and positions for the present contacts. False if the lengths cannot be kept.
bool RigidConnections::solve(Step& step) const {
  const std::size_t count = step.members.size();
  double scale = 0.0;
  for (const std::uint32_t r : step.cluster.rods) scale = std::max(scale, rods_[r].length);
  for (std::size_t i = 0; i < count; ++i) {
    const Step::Member& m = step.members[i];
    step.moves[i] = m.fixed || (step.touches[i].surface >= 0 && !step.touches[i].slides) ? 0 : 1;
    if (step.moves[i] == 0) step.positions[i] = m.place;
  }
  // A node that is stopped in this step comes to rest where the lengths want it on its surface.
  std::vector<Touch> sliding = step.touches;
  std::vector<std::uint8_t> placed = step.moves;
  for (std::size_t i = 0; i < count; ++i)
    if (!step.members[i].fixed && step.members[i].is_new && step.touches[i].surface >= 0) {
      sliding[i].slides = true;
      placed[i] = 1;
    }
  const auto mobility = [&](std::uint32_t node) -> Eigen::Matrix3d {
    const std::size_t i = member_of_[node];
    return step.moves[i] == 0 ? Eigen::Matrix3d(Eigen::Matrix3d::Zero()) : step.members[i].mobility;
  };
  double last = std::numeric_limits<double>::infinity();
  for (int turn = 0; turn < most_turns; ++turn) {
    step.system.set(rows_of(step.at, step.cluster, step.touches, step.positions), mobility);
    const std::vector<ConstraintRow>& rows = step.system.rows();
    for (std::size_t i = 0; i < count; ++i) {
      Step::Member& m = step.members[i];
      m.velocity = step.moves[i] == 0 ? m.place_velocity : Vector3(m.free + m.mobility * m.friction);
    }
    Eigen::VectorXd rate(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const std::size_t i = member_of_[rows[r].first];
      const Vector3 other =
          rows[r].second != ConstraintRow::no_node
              ? step.members[member_of_[rows[r].second]].velocity
              : Vector3(Contact::velocity(step.at, static_cast<std::size_t>(rows[r].surface), step.positions[i]) +
                        step.members[i].rebound * rows[r].direction);
      rate[static_cast<Eigen::Index>(r)] = rows[r].direction.dot(step.members[i].velocity - other);
    }
    step.multipliers = step.system.solve(-rate);
    step.system.for_each_change(step.multipliers, [&](std::uint32_t node, const Vector3& change) {
      step.members[member_of_[node]].velocity += change;
    });
    std::vector<Vector3> next(count);
    for (std::size_t i = 0; i < count; ++i) {
      const Step::Member& m = step.members[i];
      next[i] = step.moves[i] == 0 ? m.place
                : step.h > 0.0
                    ? Vector3(m.start + step.h * ((1.0 - step.theta) * m.start_velocity + step.theta * m.velocity))
                    : m.free_position;
    }
    if (!correct_positions(step.at, step.cluster, sliding, next, placed)) return false;
    double moved = 0.0;
    for (std::size_t i = 0; i < count; ++i) moved = std::max(moved, (next[i] - step.positions[i]).norm());
    // As far as it goes, or as far as rounding lets it.
    if (moved <= accuracy * scale || (moved <= 1e-10 * scale && moved >= 0.5 * last)) {
      step.positions.swap(next);
      return true;
    }
    // Directions that turn by much within the step overshoot: half the way then, as soon as that shows.
    const bool overshoots = moved > 0.7 * last;
    for (std::size_t i = 0; i < count; ++i)
      step.positions[i] = overshoots ? Vector3(0.5 * (step.positions[i] + next[i])) : next[i];
    last = moved;
  }
  // Outputs that sweeps threw far off: the forces along the directions at the end, below, do not explain these
  // velocities, so that the step cannot count as settled before they do.
  return true;
}

// The impulse of all rigid connections on a node, N s.
Vector3 RigidConnections::tension_at(const Step& step, std::size_t member) const {
  const std::uint32_t node = step.members[member].node;
  Vector3 sum = Vector3::Zero();
  for (std::size_t r = 0; r < step.cluster.rods.size(); ++r) {
    const ConstraintRow& row = step.system.rows()[r];
    const double x = step.multipliers[static_cast<Eigen::Index>(r)];
    if (row.first == node) sum += x * row.direction;
    if (row.second == node) sum -= x * row.direction;
  }
  return sum;
}

// True if the contact of a node has to be another one than the solution was made for.
bool RigidConnections::revise_contact(Step& step, std::size_t member) const {
  Step::Member& m = step.members[member];
  Touch& touch = step.touches[member];
  const bool forced = contact_.is_undecided(m.node) || m.changes >= most_changes;
  const Contact::Way way{m.node, m.start, m.start_velocity, step.positions[member], m.velocity};
  if (!step.decides) return touch.slides && revise_friction(step, member);
  if (touch.surface < 0) {
    const Contact::Meeting meeting = contact_.first_meeting(step.at, m.start, step.positions[member]);
    if (meeting.surface < 0 || contact_.leaves(step.at, meeting.surface, way)) return false;
    const auto j = static_cast<std::size_t>(meeting.surface);
    touch = {meeting.surface, contact_.surfaces()[j].friction().kind != Friction::Kind::held};
    m.is_new = !contact_.committed(m.node).has(meeting.surface);
    if (m.is_new)
      m.rebound = contact_.rebound(step.at, meeting.surface, step.positions[member], m.start_velocity, m.free);
    touch.slides = touch.slides || m.rebound > 0.0;
    m.place = contact_.onto(step.at, j, contact_.taken_along(step.at, m.start, step.positions[member], meeting));
    m.place_velocity = Contact::velocity(step.at, j, m.place);
    ++m.changes;
    return true;
  }
  const auto j = static_cast<std::size_t>(touch.surface);
  const Friction& law = contact_.surfaces()[j].friction();
  const Vector3 n = contact_.normal(step.at, j, step.positions[member]);
  const auto leave = [&] {
    if (m.is_new || forced) return false;
    touch = {};
    m.friction.setZero();
    ++m.changes;
    return true;
  };
  const auto is_smooth = [&](std::int32_t surface) {
    return contact_.surfaces()[static_cast<std::size_t>(surface)].friction().kind == Friction::Kind::none;
  };
  if (touch.slides && !forced) {
    const Contact::Meeting second = contact_.second_meeting(step.at, way, touch.surface, touch.second);
    if (second.surface >= 0 && touch.second < 0 && is_smooth(touch.surface) && is_smooth(second.surface)) {
      touch.second = second.surface;
      ++m.changes;
      return true;
    }
    if (second.surface >= 0) {
      const auto other = static_cast<std::size_t>(second.surface);
      m.is_new = contact_.committed(m.node).surface != second.surface;
      m.place = contact_.onto(step.at, other, contact_.taken_along(step.at, m.start, step.positions[member], second));
      m.place_velocity = Contact::velocity(step.at, other, m.place);
      m.friction.setZero();
      touch = {second.surface, false};
      ++m.changes;
      return true;
    }
  }
  if (!touch.slides) {
    const Vector3 impulse = m.inertia * (m.place_velocity - m.free) - tension_at(step, member);
    const double pressing = n.dot(impulse);
    if (pressing < 0.0) return leave();
    if (law.kind != Friction::Kind::coulomb || m.changes >= most_changes) return false;
    const Vector3 along = impulse - pressing * n;
    if (grip(law.coefficient, pressing, along.norm()) >= 0.0) return false;
    touch.slides = true;
    m.friction = law.coefficient * pressing * along.normalized();
    ++m.changes;
    return true;
  }
  for (std::size_t r = step.cluster.rods.size(); r < step.system.rows().size(); ++r) {
    const ConstraintRow& row = step.system.rows()[r];
    if (row.first != m.node || step.multipliers[static_cast<Eigen::Index>(r)] >= 0.0) continue;
    if (touch.second < 0) {
      if (leave()) return true;
    } else if (!forced) {
      touch = {row.surface == touch.surface ? touch.second : touch.surface, true};
      ++m.changes;
      return true;
    }
  }
  return revise_friction(step, member);
}

// The friction of a node that slides, for the present normal forces; where nothing is to be decided it is against the
// slip that it had, until it slips that way itself. True if it has to change.
bool RigidConnections::revise_friction(Step& step, std::size_t member) const {
  Step::Member& m = step.members[member];
  Touch& touch = step.touches[member];
  const auto j = static_cast<std::size_t>(touch.surface);
  const Friction& law = contact_.surfaces()[j].friction();
  if (law.kind != Friction::Kind::coulomb) return false;
  double pressing = 0.0;
  for (std::size_t r = step.cluster.rods.size(); r < step.system.rows().size(); ++r)
    if (step.system.rows()[r].first == m.node)
      pressing += std::max(0.0, step.multipliers[static_cast<Eigen::Index>(r)]);
  const Vector3 n = contact_.normal(step.at, j, step.positions[member]);
  const Vector3 relative = m.velocity - Contact::velocity(step.at, j, step.positions[member]);
  Vector3 slip = relative - n * n.dot(relative);
  const double most = law.coefficient * pressing;
  if (!step.decides) {
    const Vector3& kept = contact_.slip(m.node);
    if (!(slip.dot(kept) > 0.0)) slip = kept - n * n.dot(kept);
  } else if ((m.friction.dot(slip) > 0.0 || !(slip.norm() > 0.0)) && m.changes < most_changes) {
    // Friction that turned the slip round is more than stops it.
    touch.slides = false;
    m.place = m.is_new ? contact_.onto(step.at, j, step.positions[member])
                       : contact_.carried(step.at, m.start, touch.surface);
    m.place_velocity = Contact::velocity(step.at, j, m.place);
    m.friction.setZero();
    ++m.changes;
    return true;
  }
  if (!(slip.norm() > 0.0)) return false;
  const Vector3 friction = -most * slip.normalized();
  const double change = (friction - m.friction).norm();
  m.friction = friction;
  return change > 1e-12 * most;
}

bool RigidConnections::revise_contacts(Step& step) const {
  bool changed = false;
  for (std::size_t i = 0; i < step.members.size(); ++i)
    if (!step.members[i].fixed && revise_contact(step, i)) changed = true;
  return changed;
}

springnet_status RigidConnections::constrain(const Placement& end, std::size_t index, const springnet_sweep& sweep,
                                             springnet_message& message) const {
  const Cluster& cluster = clusters_[index];
  const std::size_t count = cluster.nodes.size();
  Step step{end, cluster, sweep.time_constant, sweep.theta > 0.0 ? sweep.theta : 1.0, sweep.contacts == 0, {}, {},
            {},  {}};
  step.members.reserve(count);
  step.touches.resize(count);
  step.positions.resize(count);
  step.moves.resize(count);
  const bool surfaces = !contact_.surfaces().empty();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t k = cluster.nodes[i];
    Step::Member m{};
    m.node = k;
    m.fixed = contact_.constrain_fixed(end, k, sweep);
    m.start = vector_at(sweep.start_position, k);
    m.start_velocity = vector_at(sweep.start_velocity, k);
    m.free_position = m.place = step.positions[i] = vector_at(sweep.next_position, k);
    m.free = m.place_velocity = vector_at(sweep.next_velocity, k);
    m.inertia = sweep.inertia == nullptr
                    ? Eigen::Matrix3d(mass_[k] * Eigen::Matrix3d::Identity())
                    : Eigen::Matrix3d(Eigen::Map<const Eigen::Matrix3d>(sweep.inertia + 9 * std::size_t{k}));
    m.mobility = m.inertia.inverse();
    if (surfaces && !m.fixed) {
      Touch touch = contact_.committed(k);
      if (step.decides && touch.surface < 0 && contact_.is_undecided(k) &&
          contact_.could_reach(end, k, m.start, m.free_position)) {
        const std::int32_t last = contact_.last_surface(k);
        const auto j = static_cast<std::size_t>(last);
        touch = {last, contact_.surfaces()[j].friction().kind != Friction::Kind::held};
        m.place = contact_.onto(end, j, m.free_position);
        m.is_new = true;
      } else if (touch.surface >= 0) {
        m.place = contact_.carried(end, m.start, touch.surface);
      }
      if (touch.surface >= 0)
        m.place_velocity = Contact::velocity(end, static_cast<std::size_t>(touch.surface), m.place);
      step.touches[i] = touch;
    }
    step.members.push_back(m);
  }
  bool revised = true;
  for (int round = 0; round < most_rounds && revised; ++round) {
    if (!solve(step)) return cannot_keep(cluster, message);
    revised = surfaces && revise_contacts(step);
  }
  if (revised) {
    set_message(message,
                fmt::format("contacts and friction of the {} nodes that hang rigidly together with node {} depend "
                            "on each other without an end; use a smaller time step, or less friction there",
                            count, user_number_[cluster.nodes.front()]));
    return SPRINGNET_RECOVERABLE;
  }
  std::vector<Vector3> impulses(count, Vector3::Zero());
  const std::vector<ConstraintRow> rows = rows_of(end, cluster, step.touches, step.positions);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Vector3 impulse = step.multipliers[static_cast<Eigen::Index>(r)] * rows[r].direction;
    impulses[member_of_[rows[r].first]] += impulse;
    if (rows[r].second != ConstraintRow::no_node) impulses[member_of_[rows[r].second]] -= impulse;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Step::Member& m = step.members[i];
    if (m.fixed) continue;
    put_vector(sweep.next_position, m.node, step.positions[i]);
    put_vector(sweep.next_velocity, m.node, m.velocity);
    Vector3 impulse = Vector3::Zero();
    if (step.moves[i] != 0) impulse = impulses[i] + m.friction;
    if (sweep.constraint_force.x != nullptr && step.h > 0.0)
      put_vector(sweep.constraint_force, m.node, impulse / (step.h * step.theta));
    if (!surfaces) continue;
    if (step.decides) static_cast<void>(contact_.undecided(m.node, step.touches[i].surface >= 0));
    if (step.decides && step.touches[i].slides && m.friction.norm() > 0.0) contact_.set_slip(m.node, -m.friction);
    contact_.decide(m.node, step.touches[i],
                    step.touches[i].surface >= 0 ? Vector3(m.inertia * (m.velocity - m.free) - tension_at(step, i))
                                                 : Vector3(Vector3::Zero()),
                    m.rebound > 0.0 && step.touches[i].surface >= 0);
  }
  return SPRINGNET_OK;
}

}  // namespace springnet
