// The first half of a step: positions.

#include "simulation/verlet_contact.hpp"

#include <algorithm>
#include <cmath>

#include "constraints/cluster.hpp"
#include "constraints/path_minimum.hpp"
#include "constraints/vectors.hpp"

namespace springnet {
namespace {

constexpr int max_drift_turns = 40;       // rounds of contacts and positions that depend on each other
constexpr int max_failures = 3;           // to find forces, within a step
constexpr int max_bounces = 1000;         // of a node, within a step
constexpr int max_rounds = 4;             // of positions that bring more obstacles with them
constexpr double drift_accuracy = 1e-14;  // of positions, in units of their coordinates and the path

}  // namespace

// Whether a node is in contact, or meets an obstacle on its path. The path of a node with rigid connections is not
// known yet: it counts as near if the obstacle is no farther than the node moves in the step.
bool VerletContact::is_near(const springnet_sweep& step, std::uint32_t node, bool alone) const {
  if (contact_.fixed()[node] != 0) return false;
  if (contact_.committed(node).surface >= 0) return true;
  const Vector3 start = vector_at(step.start_position, node), end = vector_at(step.next_position, node);
  if (alone) return contact_.first_meeting(*at_, start, end).surface >= 0;
  for (std::size_t j = 0; j < contact_.obstacles().size(); ++j) {
    const Vector3 from = contact_.carried(*at_, start, static_cast<std::int32_t>(j));
    if (!(contact_.gap(*at_, j, end) > (end - from).norm())) return true;
  }
  return false;
}

springnet_status VerletContact::drift(const springnet_sweep& step, const Pushes& pushes) {
  const std::uint32_t* clusters = model_.rigid.cluster_of();
  const auto add = [&](const std::vector<std::uint32_t>& nodes,
                       std::optional<std::size_t> cluster) -> springnet_status {
    Body body = body_of(step, nodes);
    body.cluster = cluster;
    springnet_status status = evaluate_forces(body, step, model_.time, step.start_position, step.start_velocity);
    const bool is_in_contact =
        std::any_of(nodes.begin(), nodes.end(), [this](std::uint32_t k) { return contact_.committed(k).surface >= 0; });
    for (Member& m : body.members) {
      const auto push = pushes.find(m.node);
      if (push == pushes.end() || m.fixed) continue;
      m.half += push->second.velocity;
      body.is_pushed = true;
      // The straight path that ends where it does.
      if (!is_in_contact) m.start += push->second.shift;
    }
    if (status == SPRINGNET_OK) status = drift(body);
    if (status != SPRINGNET_OK || body.touchers.empty()) return status;
    for (const Member& m : body.members) {
      put_vector(step.next_position, m.node, m.position);
      // Bodies push on from where it gets to, also if it lands.
      put_vector(step.next_velocity, m.node, body.is_pushed ? Vector3(m.velocity + m.fitted) : m.velocity);
    }
    bodies_.push_back(std::move(body));
    return SPRINGNET_OK;
  };
  for (std::uint32_t k = 0; k < model_.layout.node_count(); ++k) {
    if ((clusters != nullptr && clusters[k] != no_cluster) || !is_near(step, k, true)) continue;
    if (const springnet_status status = add({k}, std::nullopt); status != SPRINGNET_OK) return status;
  }
  for (std::size_t c = 0; c < model_.rigid.cluster_count(); ++c) {
    const std::vector<std::uint32_t>& nodes = model_.rigid.nodes_of(c);
    if (std::none_of(nodes.begin(), nodes.end(), [&](std::uint32_t k) { return is_near(step, k, false); })) continue;
    if (const springnet_status status = add(nodes, c); status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

bool VerletContact::go(Body& body, const std::optional<Rods>& rods, const std::vector<Vector3>& impulses) const {
  for (Member& m : body.members) m.velocity = m.start_velocity + m.half;
  push(body, rods, impulses);
  std::vector<Vector3> u, p;
  for (Member& m : body.members) {
    if (m.fixed) m.velocity = (m.place - m.start) / h_;
    u.push_back(m.velocity);
    p.push_back(m.fixed ? m.place : Vector3(m.start + h_ * m.velocity));
  }
  const bool kept = !rods || rods->keep_lengths(h_, u, p);
  for (std::size_t i = 0; i < u.size(); ++i) {
    body.members[i].velocity = u[i];
    body.members[i].position = p[i];
  }
  return kept;
}

Island VerletContact::island_at_start(const Body& body, const std::optional<Rods>& rods) const {
  std::vector<ContactNode> nodes;
  for (const Toucher& toucher : body.touchers) {
    const Member& m = body.members[toucher.member];
    ContactNode node;
    node.node = m.node;
    for (const Side& of : toucher.sides) {
      ContactSide side = side_of(body, toucher, of);
      const auto j = static_cast<std::size_t>(of.surface);
      side.normal = contact_.normal(*from_at_, j, m.start);
      side.velocity = m.start_velocity - Contact::velocity(*from_at_, j, m.start);
      node.sides.push_back(side);
    }
    if (has_friction(node)) {
      const Vector3 slip = along_surfaces(node, node.sides.front().velocity);
      node.slipping = slip.norm() > model_.no_speed();
      node.sticks = !node.slipping;
      if (node.slipping) node.slip = slip.normalized();
    }
    nodes.push_back(std::move(node));
  }
  return {std::move(nodes), mobility(body, rods)};
}

double VerletContact::gap_of(const Body& body, const Member& m, const ContactSide& side) const {
  const auto surface = static_cast<std::size_t>(side.surface);
  const double gap = contact_.gap(*at_, surface, m.position);
  if (!body.is_pushed || !(gap > 0.0)) return gap;
  const double way = side.normal.dot(m.position - contact_.carried(*at_, m.start, side.surface));
  // Not where it passes around an edge.
  const bool is_beyond = side.normal.dot(contact_.normal(*at_, surface, m.position)) < -0.9;
  return way < 0.0 && is_beyond ? way : gap;
}

// The drift is motion under a constant acceleration, 2 (u - v) / h. Gaps at the end of the step are therefore
// conditions on accelerations, and the contacts are solved as for accelerations.
springnet_status VerletContact::hold(Body& body, const std::optional<Rods>& rods) {
  Island island = island_at_start(body, rods);
  std::vector<Vector3> impulses(body.touchers.size(), Vector3::Zero());
  std::vector<std::uint8_t> turned(body.touchers.size(), 0);
  const double per_distance = 2.0 / (h_ * h_), per_speed = 2.0 / h_;
  // Size of the body, m, for the rounding of gaps and of positions of sticking nodes.
  double size = 0.0;
  int failures = 0;
  for (const Member& m : body.members)
    size = std::max(size, m.start.cwiseAbs().maxCoeff() + (m.position - m.start).norm());
  for (int turn = 0; turn < max_drift_turns; ++turn) {
    double off = 0.0;
    bool again = turn == 0;
    for (std::size_t i = 0; i < body.touchers.size(); ++i) {
      const Member& m = body.members[body.touchers[i].member];
      ContactNode& node = island.nodes()[i];
      const Vector3 now = per_speed * (m.velocity - m.start_velocity);
      node.acceleration = now - (island.acceleration(i) - node.acceleration);
      for (ContactSide& side : node.sides) {
        const double gap = gap_of(body, m, side);
        const Vector3 slipped = m.position - contact_.carried(*at_, m.start, side.surface);
        side.target_acceleration = side.normal.dot(now) - per_distance * gap;
        side.surface_acceleration = now - per_distance * slipped;
        off = std::max(off, side.active ? std::abs(gap) : -gap);
        if (side.active && node.sticks) off = std::max(off, along_surfaces(node, slipped).norm());
      }
      // Friction that would turn a slip round stops it.
      const ContactSide* acts = first_acting(node);
      if (turn == 0 || acts == nullptr || !node.slipping || turned[i] != 0) continue;
      if (node.slip.dot(m.position - contact_.carried(*at_, m.start, acts->surface)) > 0.0) continue;
      turned[i] = 1;
      node.slipping = false;
      node.sticks = true;
      again = true;
    }
    if (!again && off <= drift_accuracy * size) break;
    if (!island.resolve(negligible(body), false)) {
      // No finite force fits, or none was found: take an impulse over the step.
      if (++failures > max_failures) break;
      for (std::size_t i = 0; i < body.touchers.size(); ++i) {
        ContactNode& node = island.nodes()[i];
        for (ContactSide& side : node.sides) {
          side.velocity = (node.acceleration - side.surface_acceleration) / per_speed;
          side.velocity += side.normal * ((side.normal.dot(node.acceleration) - side.target_acceleration) / per_speed -
                                          side.normal.dot(side.velocity));
        }
      }
      apply_impulses(island, body);
      for (ContactNode& node : island.nodes()) {
        node.force = per_speed * sum_of(node.impulse);
        for (std::size_t s = 0; s < node.sides.size(); ++s) node.sides[s].active = !node.impulse[s].isZero(0.0);
      }
    }
    for (std::size_t i = 0; i < impulses.size(); ++i) impulses[i] = island.nodes()[i].force / per_speed;
    if (!go(body, rods, impulses)) return fail_lengths(body);
  }
  remember(island, failures > 0, body);
  for (std::size_t i = 0; i < body.touchers.size(); ++i) {
    const ContactNode& node = island.nodes()[i];
    Toucher& toucher = body.touchers[i];
    toucher.sticks = node.sticks;
    toucher.slip = node.slip;
    for (std::size_t s = 0; s < node.sides.size(); ++s) toucher.sides[s].active = node.sides[s].active;
  }
  return SPRINGNET_OK;
}

// Whether a node gets behind an obstacle on its curved path: a node that separates from a curved surface may pass
// around what the straight line cuts through.
bool VerletContact::reaches(const Member& m, std::size_t surface) const {
  const Pose &before = from_at_->poses[surface], &after = at_->poses[surface];
  const Vector3 from = after.from_start(before.to_start(m.start));  // in the frame of the obstacle
  const auto gap = [&](double share) {
    const Vector3 bend = h_ * share * (1.0 - share) * (m.velocity - m.start_velocity);
    return contact_.gap(*at_, surface, from + share * (m.position - from) - bend);
  };
  if (contact_.gap(*at_, surface, m.position) < 0.0) return true;
  const Obstacle& obstacle = contact_.obstacles()[surface];
  if (obstacle.is_flat()) return true;
  const double rounding = drift_accuracy * (m.start.cwiseAbs().maxCoeff() + (m.position - m.start).norm());
  return minimum_on_path(gap, -rounding, 40).value < -rounding;
}

bool VerletContact::meet(Body& body) {
  bool any = false;
  for (std::size_t i = 0; i < body.members.size(); ++i) {
    const Member& m = body.members[i];
    if (m.fixed) continue;
    const auto known = std::find_if(body.touchers.begin(), body.touchers.end(),
                                    [i](const Toucher& toucher) { return toucher.member == i; });
    const auto has = [&](std::int32_t surface) {
      return known != body.touchers.end() &&
             std::any_of(known->sides.begin(), known->sides.end(), [&](const Side& s) { return s.surface == surface; });
    };
    // A surface that is flush with one in contact already adds nothing.
    const auto is_flush = [&](std::size_t surface) {
      constexpr double flush = 1e-12;
      const double rounding = drift_accuracy * (m.start.cwiseAbs().maxCoeff() + (m.position - m.start).norm());
      if (known == body.touchers.end() || contact_.gap(*at_, surface, m.position) < -rounding) return false;
      const Vector3 n = contact_.normal(*at_, surface, m.position);
      return std::any_of(known->sides.begin(), known->sides.end(), [&](const Side& side) {
        return side.active &&
               contact_.normal(*at_, static_cast<std::size_t>(side.surface), m.position).dot(n) >= 1.0 - flush;
      });
    };
    Contact::Meeting first{-1, 2.0};
    for (std::int32_t j = 0; j < static_cast<std::int32_t>(contact_.obstacles().size()); ++j) {
      if (has(j)) continue;
      const auto surface = static_cast<std::size_t>(j);
      const auto share =
          contact_.obstacles()[surface].first_touch(from_at_->poses[surface], m.start, at_->poses[surface], m.position);
      if (share && *share < first.share && reaches(m, surface) && !is_flush(surface)) first = {j, *share};
    }
    if (first.surface < 0) continue;
    if (known != body.touchers.end() &&
        std::count_if(known->sides.begin(), known->sides.end(), [](const Side& side) { return side.active; }) == 3)
      continue;
    any = true;
    if (!body.cluster && known == body.touchers.end()) {
      arrive(body, first);
      return true;
    }
    const auto j = static_cast<std::size_t>(first.surface);
    const Vector3 velocity = m.start_velocity + 2.0 * first.share * (m.velocity - m.start_velocity);
    const Vector3 n = contact_.normal(*at_, j, contact_.carried_from(*at_, m.start, m.position, first));
    Side side{first.surface, true, true};
    side.came = -n.dot(velocity - Contact::velocity(*at_, j, m.position));
    if (known != body.touchers.end()) {
      known->sides.push_back(side);
    } else {
      Toucher toucher{};
      toucher.member = i;
      toucher.sides.push_back(side);
      body.touchers.push_back(toucher);
    }
  }
  return any;
}

void VerletContact::arrive(Body& body, const Contact::Meeting& first) {
  Member& m = body.members[0];
  const Vector3 gained = 2.0 * (m.velocity - m.start_velocity);
  Toucher toucher{};
  // Next impact: position, in the frame of the obstacle at the end of the step; velocity; share of the step.
  Vector3 place = contact_.carried_from(*at_, m.start, m.position, first),
          before = m.start_velocity + first.share * gained;
  std::int32_t surface = first.surface;
  double share = first.share;
  for (int bounces = 1;; ++bounces) {
    const auto j = static_cast<std::size_t>(surface);
    const Obstacle& obstacle = contact_.obstacles()[j];
    const Vector3 w = Contact::velocity(*at_, j, place);
    ContactNode node;
    node.node = m.node;
    ContactSide side;
    side.surface = surface;
    side.normal = contact_.normal(*at_, j, place);
    side.friction = obstacle.friction();
    side.velocity = before - w;
    side.restitution = obstacle.restitution();
    node.sides.push_back(side);
    Island island({std::move(node)}, Eigen::MatrixXd::Identity(3, 3) / model_.mass[m.node]);
    // A rebound slower than the fall within the step ends in contact.
    const double falls = std::max(0.0, -side.normal.dot(gained - h_ * Contact::acceleration(*at_, j, place)));
    const double least = side.restitution > 0.0 ? falls / side.restitution : std::numeric_limits<double>::infinity();
    static_cast<void>(island.apply_impact(least));
    const ContactSide& struck = island.nodes()[0].sides[0];
    const Vector3 arrival = island.nodes()[0].impulse[0];
    const Vector3 after = before + arrival / model_.mass[m.node];
    toucher.bounced = side.restitution > 0.0 && side.normal.dot(side.velocity) < -least;
    const double rest = 1.0 - share;
    const Vector3 slip = struck.velocity - side.normal * side.normal.dot(struck.velocity);
    toucher.sticks = !toucher.bounced && is_rough(side) && slip.norm() <= model_.no_speed();
    toucher.slip = slip.norm() > 0.0 ? Vector3(slip.normalized()) : Vector3(Vector3::Zero());
    m.position = place;
    if (!toucher.sticks) m.position += rest * h_ * (after - w + 0.5 * rest * gained);
    if (!toucher.bounced || contact_.gap(*at_, j, m.position) < 0.0) m.position = contact_.onto(*at_, j, m.position);
    // So that the kick, half a step of force, leads to the velocity that the force gives it after the impact.
    m.velocity = after + (0.5 - share) * gained;
    const auto same =
        std::find_if(toucher.sides.begin(), toucher.sides.end(), [&](const Side& of) { return of.surface == surface; });
    if (same == toucher.sides.end()) {
      toucher.sides.push_back({surface, true, !toucher.bounced, 0.0, Vector3::Zero(), arrival});
    } else {
      same->arrival += arrival;
      same->active = !toucher.bounced;
    }
    if (!toucher.bounced || bounces == max_bounces) break;
    // It may meet another obstacle on the rest of its path.
    const Vector3 from = place - rest * h_ * w;
    const std::shared_ptr<const Placement> now = contact_.at(just_after(from_ + share * h_));
    Contact::Meeting next{-1, 2.0};
    for (std::size_t k = 0; k < contact_.obstacles().size(); ++k) {
      if (k == j) continue;
      const auto met = contact_.obstacles()[k].first_touch(now->poses[k], from, at_->poses[k], m.position);
      if (met && *met < next.share && contact_.gap(*at_, k, m.position) < 0.0)
        next = {static_cast<std::int32_t>(k), *met};
    }
    if (next.surface < 0) break;
    const auto k = static_cast<std::size_t>(next.surface);
    const Vector3 start = now->poses[k].to_start(from), end = at_->poses[k].to_start(m.position);
    place = contact_.onto(*at_, k, at_->poses[k].from_start(start + next.share * (end - start)));
    before = after + next.share * rest * gained;
    share += next.share * rest;
    surface = next.surface;
  }
  body.touchers.push_back(toucher);
}

// Puts nodes that arrived on their surfaces, together with rigid connections and contacts that exist already.
springnet_status VerletContact::fit(Body& body) {
  decide(body);
  const std::size_t n = model_.layout.node_count();
  std::vector<double> values(6 * n);  // of which those of the members are used
  const springnet_vectors position{values.data(), values.data() + n, values.data() + 2 * n};
  const springnet_vectors velocity{values.data() + 3 * n, values.data() + 4 * n, values.data() + 5 * n};
  for (const Member& m : body.members) put_vector(position, m.node, m.position);
  springnet_status status = SPRINGNET_OK;
  if (body.cluster)
    status = model_.rigid.project(*at_, *body.cluster, position, velocity, model_.journal.message);
  else
    contact_.project_sliding(*at_, body.nodes.front(), position, velocity);
  for (Member& m : body.members) {
    m.fitted += (vector_at(position, m.node) - m.position) / h_;
    m.position = vector_at(position, m.node);
  }
  return status;
}

springnet_status VerletContact::drift(Body& body) {
  for (std::size_t i = 0; i < body.members.size(); ++i) {
    const Touch touch = contact_.committed(body.nodes[i]);
    if (body.members[i].fixed || touch.surface < 0) continue;
    Toucher toucher{};
    toucher.member = i;
    for (const std::int32_t surface : touch.surfaces())
      if (surface >= 0) toucher.sides.push_back({surface});
    for (Side& side : toucher.sides)
      if (const auto last = last_.find({body.nodes[i], side.surface}); last != last_.end())
        side.impulse = last->second * (h_ / last_h_);
    body.touchers.push_back(toucher);
  }
  std::optional<Rods> rods;
  if (body.cluster) {
    const State& start = model_.state;
    rods.emplace(model_.rigid, *body.cluster, read_only(start.view.position));
  }
  if (!go(body, rods, std::vector<Vector3>(body.touchers.size(), Vector3::Zero()))) {
    return fail_lengths(body);
  }
  if (!body.touchers.empty())
    if (const springnet_status status = hold(body, rods); status != SPRINGNET_OK) return status;
  for (int round = 0; round < max_rounds && meet(body); ++round) {
    if (body.touchers[0].bounced || (!body.cluster && body.touchers[0].sides.size() == 1)) continue;
    if (const springnet_status status = fit(body); status != SPRINGNET_OK) return status;
  }
  decide(body);
  return SPRINGNET_OK;
}

}  // namespace springnet
