// Contact within the sweeps of a step: where the outputs of a node may be, at the end of the step.

#include <Eigen/LU>
#include <algorithm>

#include "simulation/contact.hpp"
#include "simulation/vectors.hpp"

namespace springnet {
namespace {

// Of mind, within a step, after which a node stays in contact.
constexpr std::uint8_t most_changes = 8;
// Of its way within the step: a node that slides along a second surface may be this far behind it by rounding.
constexpr double beside = 1e-9;
constexpr std::uint32_t no_cluster = 0xffffffffu;

double theta_of(const springnet_sweep& sweep) { return sweep.theta > 0.0 ? sweep.theta : 1.0; }

void put_force(const springnet_sweep& sweep, std::uint32_t node, const Vector3& force) {
  if (sweep.constraint_force.x != nullptr) put_vector(sweep.constraint_force, node, force);
}

}  // namespace

// What an update made of a node, as if there were no surface.
struct Contact::Candidate {
  Vector3 start, start_velocity;  // m, m/s, at the beginning of the step
  Vector3 position, velocity;     // m, m/s
  Matrix3 inertia, mobility;      // kg, 1/kg
};

bool Contact::is_undecided(std::uint32_t node) const noexcept {
  return !changes_.empty() && changes_[node] >= most_changes;
}

bool Contact::undecided(std::uint32_t node, bool stays) {
  if (changes_[node] >= most_changes) return true;
  if ((stayed_[node] != 0) != stays) ++changes_[node];
  stayed_[node] = stays ? 1 : 0;
  return changes_[node] >= most_changes;
}

void Contact::decide(std::uint32_t node, const Touch& touch, const Vector3& impulse) {
  if (touch.surface >= 0) last_surface_[node] = touch.surface;
  sweep_impulse_[node] = impulse;
  if (now_[node] == touch) return;
  now_[node] = touch;
  constrained_[node] = fixed_[node] | static_cast<std::uint8_t>(touch.surface >= 0 && !touch.slides ? 1 : 0);
}

Vector3 Contact::carried(const Vector3& start, std::int32_t surface) const {
  const auto j = static_cast<std::size_t>(surface);
  if (!surfaces_[j].trajectory().moves()) return start;
  return start + (placement_[j].displacement - start_placement_[j].displacement);
}

Contact::Meeting Contact::first_meeting(const Vector3& start, const Vector3& end, std::int32_t except) const {
  Meeting first{-1, 2.0};
  for (std::size_t j = 0; j < surfaces_.size(); ++j) {
    if (static_cast<std::int32_t>(j) == except) continue;
    const auto share =
        surfaces_[j].first_touch(start - start_placement_[j].displacement, end - placement_[j].displacement);
    if (share && *share < first.share) first = {static_cast<std::int32_t>(j), *share};
  }
  return first;
}

Contact::Meeting Contact::second_meeting(const Vector3& start, const Vector3& end, const Vector3& velocity,
                                         std::int32_t surface) const {
  const Meeting second = first_meeting(start, end, surface);
  if (second.surface < 0 || leaves(second.surface, velocity, end)) return {};
  const bool behind = distance(static_cast<std::size_t>(second.surface), end) < -beside * (end - start).norm();
  return behind || second.share > 0.0 ? second : Meeting{};
}

Vector3 Contact::taken_along(const Vector3& start, const Vector3& end, const Meeting& meeting) const {
  const auto j = static_cast<std::size_t>(meeting.surface);
  if (!surfaces_[j].trajectory().moves()) return start + meeting.share * (end - start);
  const Vector3 a = start - start_placement_[j].displacement, b = end - placement_[j].displacement;
  return onto(j, a + meeting.share * (b - a) + placement_[j].displacement);
}

bool Contact::constrain_fixed(std::uint32_t node, const springnet_sweep& sweep) const {
  if (fixed_[node] == 0) return false;
  if (prescribed_.moves(node)) {
    put_vector(sweep.next_position, node, prescribed_.position(node));
    put_vector(sweep.next_velocity, node, prescribed_.velocity(node));
  } else {
    put_vector(sweep.next_position, node, vector_at(sweep.start_position, node));
    put_vector(sweep.next_velocity, node, Vector3::Zero());
  }
  put_force(sweep, node, Vector3::Zero());
  return true;
}

void Contact::constrain(std::uint32_t first, std::uint32_t count, const double* const acceleration[3],
                        const springnet_sweep& sweep, const std::uint32_t* cluster) {
  // Without surfaces there is nothing to do but for fixed nodes, and nothing to tell of the others.
  const bool free_stay_free = surfaces_.empty() && sweep.constraint_force.x == nullptr;
  for (std::uint32_t k = first; k < first + count; ++k) {
    if (free_stay_free && fixed_[k] == 0) continue;
    if (constrain_fixed(k, sweep)) continue;
    if (cluster != nullptr && cluster[k] != no_cluster) continue;
    put_force(sweep, k, Vector3::Zero());
    if (surfaces_.empty()) continue;
    const std::uint32_t i = k - first;
    constrain_node(k, {acceleration[0][i], acceleration[1][i], acceleration[2][i]}, sweep);
  }
}

ContactAnswer Contact::answer(std::int32_t surface, const Candidate& candidate, const Vector3& position) const {
  const auto j = static_cast<std::size_t>(surface);
  return answer_contact(candidate.mobility, candidate.velocity - placement_[j].velocity, normal(j, position),
                        surfaces_[j].friction());
}

void Contact::constrain_node(std::uint32_t node, const Vector3& acceleration, const springnet_sweep& sweep) {
  const Vector3 start = vector_at(sweep.start_position, node), end = vector_at(sweep.next_position, node);
  const Touch before = committed_[node];
  // A last change of mind is meet()'s business, which remembers the place.
  const bool last_change = changes_[node] + (stayed_[node] != 0 ? 1 : 0) >= most_changes;
  if (before.surface < 0 && !last_change && first_meeting(start, end).surface < 0) {
    // What most nodes do.
    static_cast<void>(undecided(node, false));
    decide(node, {}, Vector3::Zero());
    return;
  }
  Candidate candidate{start, vector_at(sweep.start_velocity, node), end, vector_at(sweep.next_velocity, node), {}, {}};
  candidate.inertia = sweep.inertia == nullptr
                          ? Matrix3(mass_[node] * Matrix3::Identity())
                          : Matrix3(Eigen::Map<const Matrix3>(sweep.inertia + 9 * std::size_t{node}));
  candidate.mobility = candidate.inertia.inverse();
  if (before.surface >= 0) {
    const auto j = static_cast<std::size_t>(before.surface);
    if (surfaces_[j].friction().kind == Friction::Kind::held) {
      // What its neuron would do, beside the surface: in a viscous medium that is not the net force alone.
      const Vector3 apart = acceleration - placement_[j].acceleration;
      const bool stays = normal(j, carried(start, before.surface)).dot(apart) <= 0.0;
      if (is_undecided(node) || stays) {
        static_cast<void>(undecided(node, true));
        decide(node, before, Vector3::Zero());
        put_vector(sweep.next_position, node, carried(start, before.surface));
        put_vector(sweep.next_velocity, node, placement_[j].velocity);
        return;
      }
    } else {
      // Undecided or not, what lets nodes slide does not pull at them.
      const ContactAnswer reaction = answer(before.surface, candidate, onto(j, end));
      if (reaction.normal >= 0.0) {
        static_cast<void>(undecided(node, true));
        slide(node, before.surface, reaction, candidate, sweep, false);
        return;
      }
    }
  }
  meet(node, candidate, sweep);
}

// What a node that cannot make up its mind may be off by is the way that it goes in the step. One that is farther from
// the surface was thrown about by sweeps that diverge, and may go on so, for all to see.
bool Contact::could_reach(std::uint32_t node, const Vector3& start, const Vector3& end) const {
  const auto j = static_cast<std::size_t>(last_surface_[node]);
  const Vector3 came = placement_[j].displacement - start_placement_[j].displacement;  // the surface itself
  return distance(j, end) <= (end - start - came).norm();
}

// A surface that moves is where its motion says, a node where the step takes it, which is of lower order: a node that
// leaves such a surface may for a moment be behind it, by no more than h^2 / 2 times the surface's acceleration. What
// tells is whether it leaves.
bool Contact::leaves(std::int32_t surface, const Vector3& velocity, const Vector3& position) const {
  const auto j = static_cast<std::size_t>(surface);
  return surfaces_[j].trajectory().moves() && normal(j, position).dot(velocity - placement_[j].velocity) >= 0.0;
}

// A node that is free at the beginning of the step, or was released in it.
void Contact::meet(std::uint32_t node, const Candidate& candidate, const springnet_sweep& sweep) {
  const Touch before = committed_[node];
  Meeting meeting = first_meeting(candidate.start, candidate.position);
  if (meeting.surface >= 0 && leaves(meeting.surface, candidate.velocity, candidate.position)) meeting.surface = -1;
  if (meeting.surface >= 0) last_surface_[node] = meeting.surface;
  const bool stays = undecided(node, meeting.surface >= 0);
  if (meeting.surface < 0 && !stays) {
    decide(node, {}, Vector3::Zero());
    return;
  }
  const bool met = meeting.surface >= 0;
  if (!met) meeting.surface = last_surface_[node];
  const auto j = static_cast<std::size_t>(meeting.surface);
  if (surfaces_[j].friction().kind != Friction::Kind::held) {
    const ContactAnswer reaction = answer(meeting.surface, candidate, onto(j, candidate.position));
    // A step in which that goes to and fro without an end does not settle, for all to see.
    if (!met && reaction.normal < 0.0)
      decide(node, {}, Vector3::Zero());
    else
      slide(node, meeting.surface, reaction, candidate, sweep, before.surface != meeting.surface);
    return;
  }
  // Where it touched: on the way of its velocity at the beginning, and where that ends short of the surface, below its
  // end. The same for every sweep, rule and change of mind; forces of a sweep would not do: those that press a node
  // of a stiff net against the surface grow with its stiffness, and would throw it about. What the force adds to the
  // way is of second order in h.
  const Vector3 end = candidate.start + sweep.time_constant * candidate.start_velocity;
  const Meeting touched{meeting.surface, surfaces_[j]
                                             .first_touch(candidate.start - start_placement_[j].displacement,
                                                          end - placement_[j].displacement)
                                             .value_or(2.0)};
  const Vector3 place = touched.share <= 1.0 ? taken_along(candidate.start, end, touched) : onto(j, end);
  // The touch is new unless the node lies on the surface already and its release failed.
  const Vector3 stopped = mass_[node] * (placement_[j].velocity - candidate.velocity);
  decide(node, {meeting.surface, false}, before.surface != meeting.surface ? stopped : Vector3::Zero());
  put_vector(sweep.next_position, node, place);
  put_vector(sweep.next_velocity, node, placement_[j].velocity);
}

// Along a surface, with or without friction: the velocity fits the surface where the position ends.
void Contact::slide(std::uint32_t node, std::int32_t surface, const ContactAnswer& first, const Candidate& candidate,
                    const springnet_sweep& sweep, bool is_new) {
  const auto j = static_cast<std::size_t>(surface);
  const double h = sweep.time_constant, theta = theta_of(sweep);
  ContactAnswer reaction = first;
  Vector3 velocity, position = onto(j, candidate.position);
  // Where the surface takes the node, and its motion along: continuous where slip ends and it sticks. Without friction
  // the motion of a surface along itself is none of the node's.
  const bool taken = surfaces_[j].friction().kind != Friction::Kind::none;
  const Vector3 from = taken ? carried(candidate.start, surface) : candidate.start;
  const Vector3 before = taken ? start_placement_[j].velocity : Vector3(Vector3::Zero());
  constexpr int most_turns = 30;
  for (int i = 0; i < most_turns; ++i) {
    velocity = placement_[j].velocity + reaction.velocity;
    const Vector3 last = position;
    const Vector3 goes = taken ? reaction.velocity : velocity;
    if (h > 0.0) position = onto(j, from + h * ((1.0 - theta) * (candidate.start_velocity - before) + theta * goes));
    if (surfaces_[j].is_plane() || (position - last).norm() <= 1e-14 * position.norm()) break;
    reaction = answer(surface, candidate, position);
  }
  const Meeting second = second_meeting(candidate.start, position, velocity, surface);
  if (second.surface >= 0) {
    stop_between(node, surface, second, position, candidate, sweep);
    return;
  }
  if (!reaction.sticks) slip_[node] = reaction.velocity;
  decide(node, {surface, !reaction.sticks}, is_new ? reaction.impulse : Vector3::Zero());
  put_vector(sweep.next_position, node, position);
  put_vector(sweep.next_velocity, node, velocity);
  if (!reaction.sticks && h > 0.0) put_force(sweep, node, reaction.impulse / (h * theta));
}

// Where it met the second surface, and with it from there on.
void Contact::stop_between(std::uint32_t node, std::int32_t surface, const Meeting& second, const Vector3& end,
                           const Candidate& candidate, const springnet_sweep& sweep) {
  // One that is held between them already stays with the surface that held it first.
  const Touch before = committed_[node];
  const bool held = before.surface >= 0 && !before.slides;
  const std::int32_t by = held && before.surface == surface ? surface : second.surface;
  const Vector3 velocity = placement_[static_cast<std::size_t>(by)].velocity;
  const bool is_new = before.surface != by;
  decide(node, {by, false}, is_new ? Vector3(mass_[node] * (velocity - candidate.velocity)) : Vector3::Zero());
  put_vector(sweep.next_position, node,
             is_new ? taken_along(candidate.start, end, second) : carried(candidate.start, by));
  put_vector(sweep.next_velocity, node, velocity);
}

}  // namespace springnet
