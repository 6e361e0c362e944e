// Contact within the sweeps of a step: constrains the outputs of a node, at the end of the step.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "constraints/cluster.hpp"
#include "constraints/contact.hpp"
#include "constraints/contact_within.hpp"
#include "constraints/vectors.hpp"

namespace springnet {
namespace {

// Changes of decision within a step after which a contact stays active.
constexpr std::uint8_t max_changes = 8;
// In units of the path length: a node that slides along a second surface may be this far behind it by rounding.
constexpr double beside = 1e-9;
// Depth to which a node that has chattered is left free, likewise.
constexpr double shallow = 1e-4;

void put_force(const springnet_sweep& sweep, std::uint32_t node, const Vector3& force) {
  if (sweep.constraint_force.x != nullptr) put_vector(sweep.constraint_force, node, force);
}

}  // namespace

bool Contact::has_chattered(std::uint32_t node) const noexcept {
  return !changes_.empty() && changes_[node] >= max_changes;
}

bool Contact::record_decision(std::uint32_t node, bool in_contact) {
  if (changes_[node] >= max_changes) return true;
  if ((was_in_contact_[node] != 0) != in_contact) ++changes_[node];
  was_in_contact_[node] = in_contact ? 1 : 0;
  return changes_[node] >= max_changes;
}

void Contact::decide(std::uint32_t node, const Touch& touch, const Vector3& impulse, bool bounces) {
  if (touch.surface >= 0) last_surface_[node] = touch.surface;
  sweep_impulse_[node] = impulse;
  lands_[node] = 0;
  bounces_[node] = bounces ? 1 : 0;
  if (now(node) == touch) return;
  now_[node] = touch;
  update_status(node);
}

Vector3 Contact::carried(const Placement& at, const Vector3& start, std::int32_t surface) const {
  const auto j = static_cast<std::size_t>(surface);
  if (!obstacles_[j].moves()) return start;
  const Pose &before = start_->poses[j], &after = at.poses[j];
  // Without rotation add the difference, so that a resting node does not drift by rounding.
  if (!after.turns) return start + (after.displacement - before.displacement);
  return after.from_start(before.to_start(start));
}

Vector3 Contact::rotated_with(const Placement& at, std::int32_t surface, const Vector3& start,
                              const Vector3& vector) const {
  if (!obstacles_[static_cast<std::size_t>(surface)].turns()) return vector;
  return carried(at, start + vector, surface) - carried(at, start, surface);
}

Contact::Meeting Contact::first_meeting(const Placement& at, const Vector3& start, const Vector3& end,
                                        std::int32_t except, std::int32_t and_except) const {
  Meeting first{-1, 2.0};
  for (std::size_t j = 0; j < obstacles_.size(); ++j) {
    if (const auto surface = static_cast<std::int32_t>(j); surface == except || surface == and_except) continue;
    const auto share = obstacles_[j].first_touch(start_->poses[j], start, at.poses[j], end);
    if (share && *share < first.share) first = {static_cast<std::int32_t>(j), *share};
  }
  return first;
}

Contact::Meeting Contact::next_meeting(const Placement& at, const Path& path, const Touch& on,
                                       const std::vector<std::int32_t>& known) const {
  Meeting next{-1, 2.0};
  double depth = 0.0;  // behind it at the end of the path, m
  for (std::size_t j = 0; j < obstacles_.size(); ++j) {
    const auto surface = static_cast<std::int32_t>(j);
    if (on.has(surface) || std::find(known.begin(), known.end(), surface) != known.end()) continue;
    const auto share = obstacles_[j].first_touch(start_->poses[j], path.start, at.poses[j], path.end);
    if (!share || *share > next.share + beside || is_separating(at, surface, path)) continue;
    const double gap_at_end = gap(at, j, path.end);
    // An edge that leads to a vertex meets all other surfaces there at once: not rounding decides which comes first.
    if (next.surface >= 0 && *share >= next.share - beside && -gap_at_end <= depth) continue;
    const bool behind = gap_at_end < -beside * (path.end - path.start).norm();
    if (!behind && (*share == 0.0 || is_flush(at, on, surface, path.end))) continue;
    next = {surface, *share};
    depth = -gap_at_end;
  }
  return next;
}

Vector3 Contact::carried_from(const Placement& at, const Vector3& start, const Vector3& end,
                              const Meeting& meeting) const {
  const auto j = static_cast<std::size_t>(meeting.surface);
  if (!obstacles_[j].moves()) return start + meeting.share * (end - start);
  const Pose& after = at.poses[j];
  const Vector3 a = start_->poses[j].to_start(start), b = after.to_start(end);
  return onto(at, j, after.from_start(a + meeting.share * (b - a)));
}

bool Contact::constrain_fixed(const Placement& end, std::uint32_t node, const springnet_sweep& sweep) const {
  if (fixed_[node] == 0) return false;
  if (prescribed_.moves(node)) {
    put_vector(sweep.next_position, node, prescribed_.position(end.motions, node));
    put_vector(sweep.next_velocity, node, prescribed_.velocity(end.motions, node));
  } else {
    put_vector(sweep.next_position, node, vector_at(sweep.start_position, node));
    put_vector(sweep.next_velocity, node, Vector3::Zero());
  }
  put_force(sweep, node, Vector3::Zero());
  return true;
}

// The gap changes by at most the length of the path. Called for each node in each sweep: no vectors in memory.
inline bool Contact::is_far(std::uint32_t node, const springnet_sweep& sweep) {
  constexpr double margin = 1.001, rounding = 1e-12;
  if (any_moves_) return false;
  StartGap& known = start_gap_[node];
  const springnet_const_vectors& from = sweep.start_position;
  const double x = from.x[node], y = from.y[node], z = from.z[node];
  if (known.start[0] != x || known.start[1] != y || known.start[2] != z) {
    const Vector3 start(x, y, z);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < obstacles_.size(); ++j) least = std::min(least, gap(*start_, j, start));
    const double reach = least - rounding * start.cwiseAbs().maxCoeff();
    known = {start, reach > 0.0 ? reach * reach : 0.0};
  }
  const springnet_vectors& to = sweep.next_position;
  const double dx = to.x[node] - x, dy = to.y[node] - y, dz = to.z[node] - z;
  return known.square_reach > margin * (dx * dx + dy * dy + dz * dz);
}

inline bool Contact::keep_free(const Within& within, std::uint32_t node) {
  const springnet_sweep& sweep = within.sweep;
  // Most nodes are free, were free in the sweep before, and are far from everything: nothing changes.
  const bool is_free = sweep.contacts == 0 && committed(node).surface < 0 && now(node).surface < 0 &&
                       was_in_contact_[node] == 0 && bounces_[node] == 0 && changes_[node] < max_changes;
  if (!is_free || !is_far(node, sweep)) return false;
  sweep_impulse_[node].setZero();
  return true;
}

void Contact::constrain(const Placement& end, std::uint32_t first, std::uint32_t count, const springnet_sweep& sweep,
                        const std::uint32_t* cluster, const Vector3* read) {
  // Without surfaces only fixed nodes are constrained, and the others have no contact force to report.
  const bool free_stay_free = obstacles_.empty() && sweep.constraint_force.x == nullptr;
  if (free_stay_free && !any_fixed_) return;
  if (sweep.contacts == SPRINGNET_AS_BEFORE || sweep.contacts == SPRINGNET_MAY_TOUCH) {
    constrain_between_decisions(end, first, count, sweep, cluster, read);
    return;
  }
  for (std::uint32_t k = first; k < first + count; ++k) {
    if (free_stay_free && fixed_[k] == 0) continue;
    if (constrain_fixed(end, k, sweep)) continue;
    if (cluster != nullptr && cluster[k] != no_cluster) continue;
    put_force(sweep, k, Vector3::Zero());
    const Within within{sweep, end};
    if (!obstacles_.empty() && !keep_free(within, k)) constrain_node(within, k, read);
  }
}

// Nodes that bounce, are held, or are on more than one surface decide anew where others may touch, and stay as they are
// where none may.
void Contact::constrain_between_decisions(const Placement& end, std::uint32_t first, std::uint32_t count,
                                          const springnet_sweep& sweep, const std::uint32_t* cluster,
                                          const Vector3* read) {
  const bool may_touch = sweep.contacts == SPRINGNET_MAY_TOUCH;
  springnet_sweep deciding = sweep, keeping = sweep;
  deciding.contacts = 0;
  keeping.contacts = 1;
  const Within decided{deciding, end}, kept{keeping, end};
  for (std::uint32_t k = first; k < first + count; ++k) {
    if (constrain_fixed(end, k, sweep) || (cluster != nullptr && cluster[k] != no_cluster)) continue;
    const bool is_kept = now(k).surface >= 0 && is_simple(k, now(k));
    if (!is_kept && !may_touch) continue;
    put_force(sweep, k, Vector3::Zero());
    if (is_kept) {
      const Candidate candidate = candidate_of(kept, k, read);
      keep(kept, k, may_touch ? stopped_by_friction(end, k, candidate) : now(k), candidate);
    } else if (!keep_free(decided, k)) {
      constrain_node(decided, k, read);
    }
  }
}

void Contact::constrain(const Placement& end, std::span<const std::uint32_t> nodes, const springnet_sweep& sweep,
                        const springnet_const_vectors& read) {
  const bool has_surfaces = !obstacles_.empty();
  const Within within{sweep, end};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::uint32_t k = nodes[i];
    if (constrain_fixed(end, k, sweep)) continue;
    put_force(sweep, k, Vector3::Zero());
    if (!has_surfaces || keep_free(within, k)) continue;
    const Vector3 old(read.x[i], read.y[i], read.z[i]);
    constrain_node(within, k, &old);
  }
}

void Contact::constrain_node(const Within& within, std::uint32_t node, const Vector3* read) {
  const auto& [sweep, at] = within;
  const Vector3 start = vector_at(sweep.start_position, node), end = vector_at(sweep.next_position, node);
  const bool decides = sweep.contacts == 0;
  // At the last permitted change of decision skip the shortcut: meet() then keeps the contact.
  const bool last_change = changes_[node] + (was_in_contact_[node] != 0 ? 1 : 0) >= max_changes;
  if (committed(node).surface < 0 && (!decides || (!last_change && first_meeting(at, start, end).surface < 0))) {
    // The common case: the node stays free.
    if (decides) static_cast<void>(record_decision(node, false));
    decide(node, {}, Vector3::Zero());
    return;
  }
  const Candidate candidate = candidate_of(within, node, read);
  if (!decides)
    keep(within, node, committed(node), candidate);
  else if (committed(node).surface < 0 || !try_to_keep(within, node, candidate))
    meet(within, node, candidate);
}

Contact::Candidate Contact::candidate_of(const Within& within, std::uint32_t node, const Vector3* read) const {
  const springnet_sweep& sweep = within.sweep;
  const Matrix3 inertia = sweep.inertia == nullptr
                              ? Matrix3(mass_[node] * Matrix3::Identity())
                              : Matrix3(Eigen::Map<const Matrix3>(sweep.inertia + 9 * std::size_t{node}));
  return {node,
          vector_at(sweep.start_position, node),
          vector_at(sweep.start_velocity, node),
          vector_at(sweep.next_position, node),
          vector_at(sweep.next_velocity, node),
          inertia,
          read != nullptr ? *read : vector_at(sweep.velocity, node)};
}

// A chattering node can be off its surface by at most its path within the step. One that is farther away comes from
// diverging sweeps; it stays free, so that the divergence is reported.
bool Contact::could_reach(const Placement& at, std::uint32_t node, const Vector3& start, const Vector3& end) const {
  const auto j = static_cast<std::size_t>(last_surface_[node]);
  const Vector3 surface_path = carried(at, start, last_surface_[node]) - start;
  return gap(at, j, end) <= (end - start - surface_path).norm();
}

// A surface moves exactly, a node with the error of the step; and the straight path of a step cuts through a curved
// surface that the node passes around. So a separating node may be behind such a surface for some steps, by O(h^2); its
// separating velocity shows that it does not meet the surface. A node that comes from outside does meet a curved
// surface, and so does one that would pass to its far side: with theta 1/2 the velocity at the end of a step that takes
// a node just to a surface may point away from it.
bool Contact::is_separating(const Placement& at, std::int32_t surface, const Path& path) const {
  const auto j = static_cast<std::size_t>(surface);
  const Obstacle& obstacle = obstacles_[j];
  if (!obstacle.moves() && obstacle.is_flat()) return false;
  const Vector3 n = normal(at, j, path.end);
  if (!(n.dot(path.velocity - Contact::velocity(at, j, path.end)) >= 0.0)) return false;
  if (obstacle.is_flat()) return true;
  const Vector3 before = normal(*start_, j, path.start);
  if (!(before.dot(n) > 0.0)) return false;
  if (committed(path.node).surface == surface) return true;
  return gap(*start_, j, path.start) <= beside * (path.end - path.start).norm() ||
         before.dot(path.start_velocity - Contact::velocity(*start_, j, path.start)) >= 0.0;
}

// Painlevé: friction may press a sliding node down faster than its reaction lifts it. Then neither state fits: free, it
// penetrates a plane; in contact, the plane would have to pull. What is free then stays so where it is shallow.
bool Contact::is_left_free(const Within& within, const Candidate& candidate, std::int32_t surface) const {
  const std::uint32_t node = candidate.node;
  if (surface < 0 || now(node).surface >= 0 || !arrives(node, surface)) return false;
  const auto j = static_cast<std::size_t>(surface);
  const double path = (candidate.position - candidate.start).norm();
  return obstacles_[j].is_flat() && obstacles_[j].friction().kind == Friction::Kind::coulomb &&
         gap(within.at, j, candidate.position) >= -shallow * path &&
         first_meeting(within.at, candidate.start, candidate.position, surface).surface < 0;
}

// A node that is free at the start of the step, or was released within it.
void Contact::meet(const Within& within, std::uint32_t node, const Candidate& candidate) {
  const auto& [sweep, at] = within;
  const Touch before = committed(node);
  Meeting meeting = first_meeting(at, candidate.start, candidate.position);
  const Path path{node, candidate.start, candidate.start_velocity, candidate.position, candidate.velocity};
  if (meeting.surface >= 0 && is_separating(at, meeting.surface, path)) meeting.surface = -1;
  if (meeting.surface >= 0) last_surface_[node] = meeting.surface;
  const bool stays_active = record_decision(node, meeting.surface >= 0);
  if (stays_active && is_left_free(within, candidate, meeting.surface)) meeting.surface = -1;
  // Where nodes arrive, whether one meets the surface does not hang on how it is stopped there.
  const bool chatter_holds = stays_active && (holds(last_surface_[node]) || !arrives(node, last_surface_[node]));
  if (meeting.surface < 0 && !chatter_holds) {
    decide(node, {}, Vector3::Zero());
    return;
  }
  const bool met = meeting.surface >= 0;
  if (!met) meeting.surface = last_surface_[node];
  const auto j = static_cast<std::size_t>(meeting.surface);
  // Where the node was heading: the same for every rule. The normal of a curved surface depends on it.
  const Vector3 ahead = candidate.start + sweep.time_constant * candidate.start_velocity;
  const double rebounds = met && !before.has(meeting.surface) ? rebound(at, meeting.surface, onto(at, j, ahead),
                                                                        candidate.start_velocity, candidate.velocity)
                                                              : 0.0;
  if (obstacles_[j].friction().kind != Friction::Kind::held || rebounds > 0.0) {
    Slide on = slide_along(within, meeting.surface, candidate, nullptr, rebounds);
    // The path crosses a curved surface and ends on its far side, where the node would separate: use the normal where
    // it met the surface.
    if (met && on.normal < 0.0) {
      const Vector3 place = carried_from(at, candidate.start, candidate.position, meeting);
      on = slide_along(within, meeting.surface, candidate, &place, rebounds);
    }
    // If this alternates without end, the step does not settle and is reported.
    if (on.normal < 0.0)
      decide(node, {}, Vector3::Zero());
    else
      slide(within, node, on, candidate);
    return;
  }
  const Vector3 place =
      where_it_touched(at, sweep.time_constant, candidate.start, candidate.start_velocity, meeting.surface);
  stop(within, node, {meeting.surface, false}, place, candidate);
}

// The same for every sweep, rule and decision. The path under a sweep's forces would not do: in a stiff net they grow
// with the stiffness and would displace the node. The force changes the path by O(h^2) only.
Vector3 Contact::where_it_touched(const Placement& at, double length, const Vector3& start,
                                  const Vector3& start_velocity, std::int32_t surface) const {
  const auto j = static_cast<std::size_t>(surface);
  const Vector3 ahead = start + length * start_velocity;
  const double share = obstacles_[j].first_touch(start_->poses[j], start, at.poses[j], ahead).value_or(2.0);
  if (share > 1.0) return onto(at, j, ahead);
  return share > 0.0 ? carried_from(at, start, ahead, {surface, share}) : onto(at, j, carried(at, start, surface));
}

double Contact::rebound(const Placement& at, std::int32_t surface, const Vector3& position,
                        const Vector3& start_velocity, const Vector3& free) const {
  const auto j = static_cast<std::size_t>(surface);
  if (!(obstacles_[j].restitution() > 0.0)) return 0.0;
  const Vector3 n = normal(at, j, position);
  const double approach_speed = -n.dot(start_velocity - Contact::velocity(at, j, position));
  return approach_speed > std::abs(n.dot(free - start_velocity)) ? obstacles_[j].restitution() * approach_speed : 0.0;
}

void Contact::set_outputs(const Within& within, std::uint32_t node, const Slide& on) {
  const springnet_sweep& sweep = within.sweep;
  const double weight = sweep.time_constant * theta_of(sweep);
  if (on.touch.slides && sweep.contacts == 0) slip_[node] = on.slip;
  decide(node, on.touch, on.impulse + on.landing_impulse, on.bounces);
  lands_[node] = on.lands ? 1 : 0;
  landing_[node] = on.landing;
  put_vector(sweep.next_position, node, on.position);
  put_vector(sweep.next_velocity, node, on.velocity);
  if (on.touch.slides && weight > 0.0) put_force(sweep, node, on.impulse / weight);
}

// Chooses the active set among all surfaces that the node meets: one to three of them, such that none pulls and the
// node approaches no other. A node has three degrees of freedom, so at most three are active; the motion selects them,
// not the order in which they were met. Velocities decide, as in Moreau's time stepping; the position is then projected
// so that it is behind none.
std::optional<Contact::Slide> Contact::choose_active_set(const Within& within, const Slide& on,
                                                         std::vector<std::int32_t>& met,
                                                         const Candidate& candidate) const {
  const Placement& at = within.at;
  std::vector<std::int32_t> pending = std::move(met);
  met.clear();
  for (const std::int32_t surface : on.touch.surfaces())
    if (surface >= 0) met.push_back(surface);
  const auto approaches = [&](const Slide& of, std::int32_t j) {
    const auto surface = static_cast<std::size_t>(j);
    const Vector3 relative = of.velocity - velocity(at, surface, of.position);
    return normal(at, surface, of.position).dot(relative) < -beside * relative.norm();
  };
  std::optional<Slide> found = on;
  while (true) {
    std::int32_t added = -1;
    if (!pending.empty()) {
      added = pending.back();
      pending.pop_back();
      if (std::find(met.begin(), met.end(), added) != met.end()) continue;
    } else {
      const Path path{candidate.node, candidate.start, candidate.start_velocity, found->position, found->velocity};
      added = next_meeting(at, path, found->touch, met).surface;
      if (added < 0) return found;
    }
    if (approaches(*found, added)) {
      found.reset();
      const auto consider = [&](const Slide& of) {
        const bool fits = of.normal >= 0.0 && std::none_of(met.begin(), met.end(), [&](std::int32_t j) {
                            return !of.touch.has(j) && approaches(of, j);
                          });
        if (!found && fits) found = of;
      };
      consider(slide_along(within, added, candidate));
      for (std::size_t a = 0; a < met.size() && !found; ++a)
        consider(slide_along_edge(within, met[a], added, candidate));
      for (std::size_t a = 0; a < met.size() && !found; ++a)
        for (std::size_t b = a + 1; b < met.size() && !found; ++b)
          consider(at_vertex(within, {met[a], true, met[b], added}, candidate));
      if (!found) return std::nullopt;
    }
    met.push_back(added);
    const double rounding = beside * (found->position - candidate.start).norm();
    for (const std::int32_t j : met) {
      const Touch& touch = found->touch;
      if (touch.has(j) || touch.third >= 0) continue;
      if (gap(at, static_cast<std::size_t>(j), found->position) >= -rounding) continue;
      found->position = touch.second < 0
                            ? onto_both(at, touch.surface, j, found->position)
                            : at_vertex(within, {touch.surface, true, touch.second, j}, candidate).position;
    }
  }
}

// A surface flush with one that the node slides on adds no constraint: the two have no edge.
bool Contact::is_flush(const Placement& at, const Touch& on, std::int32_t surface, const Vector3& position) const {
  constexpr double flush = 1e-12;
  const Vector3 n = normal(at, static_cast<std::size_t>(surface), position);
  const auto surfaces = on.surfaces();
  return std::any_of(surfaces.begin(), surfaces.end(), [&](std::int32_t j) {
    return j >= 0 && normal(at, static_cast<std::size_t>(j), position).dot(n) >= 1.0 - flush;
  });
}

void Contact::slide(const Within& within, std::uint32_t node, const Slide& on, const Candidate& candidate) {
  const Placement& at = within.at;
  const Touch& before = committed(node);
  const Path path{node, candidate.start, candidate.start_velocity, on.position, on.velocity};
  const Meeting next = next_meeting(at, path, on.touch);
  // After too many changes of its surfaces the node counts as meeting all that it met so far.
  const bool settles = slide_changes_[node] >= max_changes && !met_[node].empty();
  if (next.surface < 0 && !settles) {
    if (now(node) != on.touch) ++slide_changes_[node];
    set_outputs(within, node, on);
    return;
  }
  const auto friction_of = [&](std::int32_t j) { return obstacles_[static_cast<std::size_t>(j)].friction().kind; };
  const auto any_is = [&](const Touch& touch, Friction::Kind kind) {
    const auto surfaces = touch.surfaces();
    return std::any_of(surfaces.begin(), surfaces.end(),
                       [&](std::int32_t j) { return j >= 0 && friction_of(j) == kind; });
  };
  const double rebounds = next.surface < 0 || before.has(next.surface)
                              ? 0.0
                              : rebound(at, next.surface, on.position, candidate.start_velocity, candidate.velocity);
  const bool holds = any_is(on.touch, Friction::Kind::held);
  if (rebounds > 0.0 && on.touch.second < 0 && !holds) {
    const Slide both = slide_along_edge(within, on.touch.surface, next.surface, candidate, rebounds);
    if (both.normal >= 0.0) {
      set_outputs(within, node, both);
      return;
    }
  }
  if (!holds && (next.surface < 0 || friction_of(next.surface) != Friction::Kind::held)) {
    std::vector<std::int32_t> met;
    const double length = (on.position - candidate.start).norm();
    for (const std::int32_t j : met_[node])
      if (settles && gap(at, static_cast<std::size_t>(j), on.position) <= length) met.push_back(j);
    if (next.surface >= 0) met.push_back(next.surface);
    const std::optional<Slide> found = choose_active_set(within, on, met, candidate);
    if (found && now(node) != found->touch && slide_changes_[node] < 2 * max_changes) ++slide_changes_[node];
    for (const std::int32_t j : met)
      if (std::find(met_[node].begin(), met_[node].end(), j) == met_[node].end()) met_[node].push_back(j);
    if (found && found->touch.third >= 0 && any_is(found->touch, Friction::Kind::coulomb)) {
      // Friction at a vertex of three surfaces stops it.
      const std::int32_t by = before.surface >= 0 && !before.slides ? before.surface : found->touch.surface;
      const Vector3 place = before.surface == by ? carried(at, candidate.start, by) : found->position;
      stop(within, node, {by, false}, place, candidate);
      return;
    }
    if (found && slide_changes_[node] >= 2 * max_changes && any_is(found->touch, Friction::Kind::coulomb)) {
      // Among more surfaces friction takes and leaves each in turn: it stops the node, too.
      stop(within, node, {found->touch.surface, false}, found->position, candidate);
      return;
    }
    if (found) {
      set_outputs(within, node, *found);
      return;
    }
  }
  if (next.surface < 0)
    set_outputs(within, node, on);
  else
    stop_between(within, node, on, next, candidate);
}

void Contact::stop(const Within& within, std::uint32_t node, const Touch& touch, const Vector3& place,
                   const Candidate& candidate) {
  const auto& [sweep, at] = within;
  const Vector3 with = velocity(at, static_cast<std::size_t>(touch.surface), place);
  decide(node, touch, candidate.inertia * (with - candidate.velocity));
  // Newton's method may keep a node as it arrived, which has not been stopped.
  lands_[node] = 1;
  landing_[node] = with;
  put_vector(sweep.next_position, node, place);
  put_vector(sweep.next_velocity, node, with);
}

// Stops the node where it met one more surface, which carries it from there on.
void Contact::stop_between(const Within& within, std::uint32_t node, const Slide& on, const Meeting& next,
                           const Candidate& candidate) {
  const Placement& at = within.at;
  // A node already held between them stays with the surface that held it first.
  const Touch& before = committed(node);
  const bool held = before.surface >= 0 && !before.slides;
  const std::int32_t by = held && before.surface == on.touch.surface ? on.touch.surface : next.surface;
  const Vector3 place =
      before.surface != by ? carried_from(at, candidate.start, on.position, next) : carried(at, candidate.start, by);
  stop(within, node, {by, false}, place, candidate);
}

}  // namespace springnet
