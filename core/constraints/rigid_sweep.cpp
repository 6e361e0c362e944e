// Rigid connections within the sweeps of a step. The update rule gives each node of a cluster its output without
// constraints. Impulses along the connections, in their directions at the end of the step, correct the velocities so
// that no length changes:
//
//   U = U_free + W (G(P)^T x + f),    G(P) U = 0,    P = p + h ((1 - theta) v + theta U) + (1/m) G(P)^T y,
//   lengths(P) = l,
//
// W is the inverse of the inertia of the update rule, f the impulses of surfaces. An island finds f for all contacts of
// the cluster at once: no approach at the end, no pull, friction in its cone (Moreau's time stepping). Fixed,
// prescribed and held nodes have W = 0.

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "constraints/island.hpp"
#include "constraints/rigid.hpp"
#include "constraints/vectors.hpp"
#include "plugin_host/message.hpp"

namespace springnet {
namespace {

constexpr int max_iterations = 60;  // of the coupled iteration for positions and velocities
// Iterations in which the active set may change, and between updates of the effective mobility.
constexpr int active_set_iterations = 20, iterations_per_mobility = 10;
constexpr std::size_t few_contacts = 6;  // up to this many the mobility is updated in each iteration
constexpr double accuracy = 1e-13;
constexpr double negligible_impulse = 1e-11;  // relative to the impulses without contact
constexpr double simultaneous = 1e-9;         // share of the step within which meetings are simultaneous

Touch touch_of(const ContactNode& node) {
  Touch touch;
  for (const ContactSide& side : node.sides)
    if (side.active) (touch.surface < 0 ? touch.surface : touch.second < 0 ? touch.second : touch.third) = side.surface;
  touch.slides = touch.surface >= 0 && !node.sticks;
  return touch;
}

}  // namespace

class RigidConnections::Step {
 public:
  struct Member {
    std::uint32_t node;
    bool fixed;
    Vector3 start, start_velocity;  // m, m/s, at the start of the step
    Vector3 free_position, free;    // m, m/s: outputs without constraints
    Matrix3 inertia, mobility;
    Vector3 place, place_velocity;       // m, of a fixed, prescribed or held node; m/s, of the first two
    Vector3 impulse = Vector3::Zero();   // N s, of surfaces
    Vector3 velocity = Vector3::Zero();  // results
    Vector3 position = Vector3::Zero();
    Touch touch{};
    bool moves = true;     // else it stays at `place`
    bool is_new = false;   // its contact began in this step
    double rebound = 0.0;  // m/s, off the surface that it met
  };

  Step(const RigidConnections& rigid, const Placement& end, const Cluster& cluster, const springnet_sweep& sweep);
  enum class Outcome { solved, lengths_failed, contacts_failed };
  [[nodiscard]] Outcome solve();
  [[nodiscard]] const std::vector<Member>& members() const noexcept { return members_; }
  [[nodiscard]] bool decides() const noexcept { return decides_; }
  [[nodiscard]] double weight() const noexcept { return h_ * theta_; }
  // Impulse of the rigid connections, by member, and the tangential part of the surfaces' impulse on one, N s.
  [[nodiscard]] std::vector<Vector3> tensions() const;
  [[nodiscard]] Vector3 friction_on(std::size_t member) const;

 private:
  void add_member(std::uint32_t node, const springnet_sweep& sweep);
  void touch(std::size_t member, std::int32_t surface, bool is_new, bool pinned);
  // Velocities with the present impulses of surfaces.
  void respond();
  [[nodiscard]] Eigen::MatrixXd effective_mobility() const;
  // Finds the impulses of surfaces; with `choose` also the active set. False: there are none.
  bool find_impulses(bool choose);
  void update_touches();
  // Positions at the end of the step; false if lengths cannot be kept.
  bool place(std::vector<Vector3>& next) const;
  bool hold_back(const std::vector<Vector3>& next, std::vector<Touch>& on) const;
  // Adds the surfaces that are met first in the step and are not in the island yet. True if there are any.
  bool meet();
  [[nodiscard]] std::vector<Vector3> positions() const;
  [[nodiscard]] ContactNode* contact_of(std::size_t member);

  const RigidConnections& rigid_;
  const Contact& contact_;
  const Placement& at_;  // the end of the step
  const Cluster& cluster_;
  double h_, theta_;
  bool decides_;  // may change which nodes touch, slide and stick
  double scale_ = 0.0;
  std::vector<Member> members_;
  ConstraintSystem rods_;
  Eigen::VectorXd multipliers_;  // N s
  std::optional<Island> island_;
  Eigen::MatrixXd mobility_;  // of the island, 1/kg
  bool mobility_stale_ = false;
};

RigidConnections::Step::Step(const RigidConnections& rigid, const Placement& end, const Cluster& cluster,
                             const springnet_sweep& sweep)
    : rigid_(rigid),
      contact_(rigid.contact_),
      at_(end),
      cluster_(cluster),
      h_(sweep.time_constant),
      theta_(sweep.theta > 0.0 ? sweep.theta : 1.0),
      decides_(sweep.contacts == 0) {
  for (const std::uint32_t r : cluster.rods) scale_ = std::max(scale_, rigid.rods_[r].length);
  members_.reserve(cluster.nodes.size());
  for (const std::uint32_t k : cluster.nodes) add_member(k, sweep);
}

void RigidConnections::Step::add_member(std::uint32_t node, const springnet_sweep& sweep) {
  Member m{};
  m.node = node;
  m.fixed = contact_.constrain_fixed(at_, node, sweep);
  m.moves = !m.fixed;
  m.start = vector_at(sweep.start_position, node);
  m.start_velocity = vector_at(sweep.start_velocity, node);
  m.free_position = m.place = m.position = vector_at(sweep.next_position, node);
  m.free = m.place_velocity = vector_at(sweep.next_velocity, node);
  m.inertia = sweep.inertia == nullptr ? Matrix3(rigid_.mass_[node] * Matrix3::Identity())
                                       : Matrix3(Eigen::Map<const Matrix3>(sweep.inertia + 9 * std::size_t{node}));
  m.mobility = m.fixed ? Matrix3(Matrix3::Zero()) : Matrix3(m.inertia.inverse());
  members_.push_back(m);
  if (contact_.obstacles().empty() || m.fixed) return;
  const std::size_t i = members_.size() - 1;
  const Touch committed = contact_.committed(node);
  const bool pinned = contact_.has_chattered(node);
  if (committed.surface >= 0) {
    members_[i].place = contact_.carried(at_, m.start, committed.surface);
    for (const std::int32_t surface : committed.surfaces())
      if (surface >= 0) touch(i, surface, false, pinned);
  } else if (decides_ && pinned && contact_.could_reach(at_, node, m.start, m.free_position)) {
    const std::int32_t last = contact_.last_surface(node);
    members_[i].place = contact_.onto(at_, static_cast<std::size_t>(last), m.free_position);
    touch(i, last, true, true);
  }
}

ContactNode* RigidConnections::Step::contact_of(std::size_t member) {
  if (!island_) return nullptr;
  for (ContactNode& node : island_->nodes())
    if (node.node == member) return &node;
  return nullptr;
}

// In the island nodes are numbered as in the cluster; its accelerations and forces are velocities and impulses here.
void RigidConnections::Step::touch(std::size_t member, std::int32_t surface, bool is_new, bool pinned) {
  Member& m = members_[member];
  const Obstacle& obstacle = contact_.obstacles()[static_cast<std::size_t>(surface)];
  ContactSide side;
  side.surface = surface;
  side.friction = obstacle.friction();
  side.pinned = pinned || !decides_;
  m.is_new = m.is_new || is_new;
  if (is_new) {
    // Where it was heading, as of a node without connections.
    const Vector3 ahead = contact_.onto(at_, static_cast<std::size_t>(surface), m.start + h_ * m.start_velocity);
    m.rebound = contact_.rebound(at_, surface, ahead, m.start_velocity, m.free);
  }
  std::vector<ContactNode> nodes;
  if (island_) nodes = std::move(island_->nodes());
  auto place = std::lower_bound(nodes.begin(), nodes.end(), member,
                                [](const ContactNode& node, std::size_t i) { return node.node < i; });
  const bool is_first = place == nodes.end() || place->node != member;
  if (is_first) place = nodes.insert(place, ContactNode{static_cast<std::uint32_t>(member), {}});
  place->sides.push_back(side);
  const bool has_friction = sliding_coefficient_of(side.friction) > 0.0;
  if (const Touch committed = contact_.committed(m.node); !is_new && committed.slides) {
    place->sticks = false;
    place->slip = contact_.slip(m.node);
  } else {
    place->sticks = is_first ? has_friction : place->sticks || has_friction;
  }
  island_.emplace(std::move(nodes), Eigen::MatrixXd());
  mobility_stale_ = true;
}

std::vector<Vector3> RigidConnections::Step::positions() const {
  std::vector<Vector3> result;
  result.reserve(members_.size());
  for (const Member& m : members_) result.push_back(m.position);
  return result;
}

void RigidConnections::Step::respond() {
  for (Member& m : members_) m.velocity = m.fixed ? m.place_velocity : Vector3(m.free + m.mobility * m.impulse);
  const auto of = [this](std::uint32_t node) -> const Vector3& { return members_[rigid_.member_of_[node]].velocity; };
  multipliers_ = rods_.solve(-rods_.rates(of));
  rods_.for_each_change(multipliers_, [&](std::uint32_t node, const Vector3& change) {
    members_[rigid_.member_of_[node]].velocity += change;
  });
}

Eigen::MatrixXd RigidConnections::Step::effective_mobility() const {
  std::vector<std::uint32_t> nodes;
  for (const ContactNode& node : island_->nodes()) nodes.push_back(members_[node.node].node);
  const Eigen::MatrixXd result = rods_.effective_mobility(
      nodes, [this](std::uint32_t node) { return members_[rigid_.member_of_[node]].mobility; });
  return 0.5 * (result + result.transpose());
}

bool RigidConnections::Step::find_impulses(bool choose) {
  if (mobility_stale_) {
    mobility_ = effective_mobility();
    std::vector<ContactNode> nodes = std::move(island_->nodes());
    island_.emplace(std::move(nodes), mobility_);
    mobility_stale_ = false;
  }
  std::vector<ContactNode>& nodes = island_->nodes();
  double scale = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    ContactNode& node = nodes[i];
    const Member& m = members_[node.node];
    // Velocity without the present impulses: an exact fixed point although the mobility may be of slightly older
    // positions.
    node.acceleration = m.velocity;
    for (std::size_t j = 0; j < nodes.size(); ++j)
      node.acceleration -= mobility_.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j)) *
                           members_[nodes[j].node].impulse;
    for (ContactSide& side : node.sides) {
      const auto j = static_cast<std::size_t>(side.surface);
      side.normal = contact_.normal(at_, j, m.position);
      side.surface_acceleration = Contact::velocity(at_, j, m.position);
      side.target_acceleration = side.normal.dot(side.surface_acceleration);
      if (m.is_new && !contact_.committed(m.node).has(side.surface)) side.target_acceleration += m.rebound;
    }
    scale = std::max(scale, m.inertia.norm() * (node.acceleration - node.sides[0].surface_acceleration).norm());
  }
  bool found = true;
  if (choose)
    found = island_->resolve_impulses(negligible_impulse * scale);
  else
    island_->solve(!decides_);
  for (const ContactNode& node : island_->nodes()) members_[node.node].impulse = node.force;
  return found;
}

void RigidConnections::Step::update_touches() {
  for (const ContactNode& node : island_->nodes()) {
    Member& m = members_[node.node];
    m.touch = touch_of(node);
    if (m.rebound > 0.0 && m.touch.surface >= 0) m.touch.slides = true;
    m.moves = m.touch.surface < 0 || m.touch.slides;
  }
}

bool RigidConnections::Step::place(std::vector<Vector3>& next) const {
  std::vector<Touch> on(members_.size());
  std::vector<std::uint8_t> movable(members_.size(), 0);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Member& m = members_[i];
    next[i] = !m.moves   ? m.place
              : h_ > 0.0 ? Vector3(m.start + h_ * ((1.0 - theta_) * m.start_velocity + theta_ * m.velocity))
                         : m.free_position;
    movable[i] = m.moves ? 1 : 0;
    on[i] = m.touch;
    // A node stopped in this step may still move along its surface to satisfy the lengths.
    if (m.is_new && m.touch.surface >= 0) {
      on[i].slides = true;
      movable[i] = 1;
    }
  }
  if (!rigid_.correct_positions(at_, cluster_, on, next, movable)) return false;
  while (island_ && hold_back(next, on))
    if (!rigid_.correct_positions(at_, cluster_, on, next, movable)) return false;
  return true;
}

// A node with a contact that is not active may still end behind the surface, because the lengths displace it or
// contacts of other nodes turn it around. Adds those surfaces to `on`; false if there are none.
bool RigidConnections::Step::hold_back(const std::vector<Vector3>& next, std::vector<Touch>& on) const {
  bool any = false;
  for (const ContactNode& node : island_->nodes()) {
    const Member& m = members_[node.node];
    Touch& touch = on[node.node];
    if (!m.moves) continue;
    for (const ContactSide& side : node.sides) {
      if (touch.has(side.surface) || touch.third >= 0) continue;
      if (contact_.gap(at_, static_cast<std::size_t>(side.surface), next[node.node]) >= -accuracy * scale_) continue;
      touch = after(touch, {ContactCause::Kind::touch, side.surface});
      any = true;
    }
  }
  return any;
}

bool RigidConnections::Step::meet() {
  struct Found {
    std::size_t member;
    Contact::Meeting meeting;
  };
  std::vector<Found> found;
  double first = 2.0;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    const Member& m = members_[i];
    if (m.fixed || !m.moves) continue;
    const ContactNode* known = contact_of(i);
    // A node that has chattered keeps its contacts, and meets no others; without any, rods may still draw it in.
    if (known != nullptr && (known->sides.size() == 3 || contact_.has_chattered(m.node))) continue;
    const Contact::Path path{m.node, m.start, m.start_velocity, m.position, m.velocity};
    Contact::Meeting meeting;
    if (m.touch.surface >= 0) {
      meeting = contact_.next_meeting(at_, path, m.touch);
    } else {
      meeting = contact_.first_meeting(at_, m.start, m.position);
      // A separating node does not meet the surface, unless it is behind it.
      if (meeting.surface >= 0 && contact_.is_separating(at_, meeting.surface, path) &&
          contact_.gap(at_, static_cast<std::size_t>(meeting.surface), m.position) >= -accuracy * scale_)
        meeting.surface = -1;
    }
    const auto is_known = [&](const ContactSide& side) { return side.surface == meeting.surface; };
    if (meeting.surface < 0) continue;
    if (known != nullptr && std::any_of(known->sides.begin(), known->sides.end(), is_known)) continue;
    found.push_back({i, meeting});
    first = std::min(first, meeting.share);
  }
  // Later meetings may disappear once these are active.
  for (const Found& each : found) {
    if (each.meeting.share > first + simultaneous) continue;
    Member& m = members_[each.member];
    m.place = contact_.where_it_touched(at_, h_, m.start, m.start_velocity, each.meeting.surface);
    touch(each.member, each.meeting.surface, true, false);
  }
  return !found.empty();
}

RigidConnections::Step::Outcome RigidConnections::Step::solve() {
  const std::size_t count = members_.size();
  const auto mobility = [&](std::uint32_t node) { return members_[rigid_.member_of_[node]].mobility; };
  double last = std::numeric_limits<double>::infinity();
  bool found = true;
  int iteration = 0;
  while (true) {
    rods_.set(rigid_.rods_of(cluster_, positions()), mobility);
    respond();
    if (island_) {
      // With sticking nodes that brace each other, a mobility of older positions would be inconsistent with the
      // velocities.
      const bool is_small = island_->nodes().size() <= few_contacts;
      if (is_small || iteration % iterations_per_mobility == iterations_per_mobility - 1) mobility_stale_ = true;
      found = find_impulses(decides_ && iteration < active_set_iterations);
      update_touches();
      respond();
    }
    std::vector<Vector3> next(count);
    if (!place(next)) return Outcome::lengths_failed;
    double moved = 0.0;
    for (std::size_t i = 0; i < count; ++i) moved = std::max(moved, (next[i] - members_[i].position).norm());
    // Converged to the accuracy, or to rounding.
    const bool done = moved <= accuracy * scale_ || (moved <= 1e-10 * scale_ && moved >= 0.5 * last);
    // Directions that turn far within the step overshoot: damp the iteration by one half.
    const bool overshoots = !done && moved > 0.7 * last;
    for (std::size_t i = 0; i < count; ++i)
      members_[i].position = overshoots ? Vector3(0.5 * (members_[i].position + next[i])) : next[i];
    last = moved;
    ++iteration;
    // Positions that have not converged by then still show which surfaces they are behind.
    if (!done && iteration < max_iterations) continue;
    if (!decides_ || contact_.obstacles().empty() || !meet()) break;
    iteration = 0;
    last = std::numeric_limits<double>::infinity();
  }
  // If sweeps diverge, the forces at the end do not explain these velocities: the residual shows it, and the step does
  // not settle.
  for (Member& m : members_)
    if (m.fixed)
      m.velocity = m.place_velocity;
    else if (!m.moves)
      m.velocity = Contact::velocity(at_, static_cast<std::size_t>(m.touch.surface), m.position);
  return found ? Outcome::solved : Outcome::contacts_failed;
}

std::vector<Vector3> RigidConnections::Step::tensions() const {
  std::vector<Vector3> sums(members_.size(), Vector3::Zero());
  const std::vector<ConstraintRow> rows = rigid_.rods_of(cluster_, positions());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Vector3 impulse = multipliers_[static_cast<Eigen::Index>(r)] * rows[r].direction;
    sums[rigid_.member_of_[rows[r].first]] += impulse;
    sums[rigid_.member_of_[rows[r].second]] -= impulse;
  }
  return sums;
}

Vector3 RigidConnections::Step::friction_on(std::size_t member) const {
  const Member& m = members_[member];
  std::vector<Vector3> normals;
  for (const std::int32_t surface : m.touch.surfaces())
    if (surface >= 0) normals.push_back(contact_.normal(at_, static_cast<std::size_t>(surface), m.position));
  return normals.empty() ? Vector3(Vector3::Zero()) : split_reaction(normals, m.impulse).tangential;
}

springnet_status RigidConnections::constrain(const Placement& end, std::size_t index, const springnet_sweep& sweep,
                                             springnet_message& message) const {
  const Cluster& cluster = clusters_[index];
  Step step(*this, end, cluster, sweep);
  switch (step.solve()) {
    case Step::Outcome::solved:
      break;
    case Step::Outcome::lengths_failed:
      return fail_lengths(cluster, message);
    case Step::Outcome::contacts_failed:
      set_message(message, fmt::format("contacts and friction of the {} nodes in the rigid cluster of node {} do not "
                                       "converge; use a smaller time step, or less friction there",
                                       cluster.nodes.size(), user_number_[cluster.nodes.front()]));
      return SPRINGNET_RECOVERABLE;
  }
  const std::vector<Vector3> tensions = step.tensions();
  for (std::size_t i = 0; i < step.members().size(); ++i) {
    const Step::Member& m = step.members()[i];
    if (m.fixed) continue;
    put_vector(sweep.next_position, m.node, m.position);
    put_vector(sweep.next_velocity, m.node, m.velocity);
    const Vector3 impulse = m.moves ? Vector3(tensions[i] + m.impulse) : Vector3(Vector3::Zero());
    if (sweep.constraint_force.x != nullptr && step.weight() > 0.0)
      put_vector(sweep.constraint_force, m.node, impulse / step.weight());
    if (contact_.obstacles().empty()) continue;
    const bool in_contact = m.touch.surface >= 0;
    if (step.decides()) {
      static_cast<void>(contact_.record_decision(m.node, in_contact));
      if (const Vector3 friction = step.friction_on(i); m.touch.slides && friction.norm() > 0.0)
        contact_.set_slip(m.node, -friction);
    }
    contact_.decide(m.node, m.touch, in_contact ? m.impulse : Vector3(Vector3::Zero()), m.rebound > 0.0 && in_contact);
  }
  return SPRINGNET_OK;
}

}  // namespace springnet
