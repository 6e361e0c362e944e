// A node that keeps its contact in a sweep: unless a surface would have to pull, or whatever the forces.

#include <Eigen/LU>

#include "constraints/contact.hpp"
#include "constraints/contact_within.hpp"
#include "constraints/vectors.hpp"

namespace springnet {

// The reaction over the step decides on release. A surface on which nodes slide never pulls, even after chatter.
bool Contact::try_to_keep(const Within& within, std::uint32_t node, const Candidate& candidate) {
  const Placement& at = within.at;
  const Touch& before = committed(node);
  std::int32_t surface = before.surface;
  if (before.third >= 0 && before.slides) {
    Slide on = at_vertex(within, before, candidate);
    if (on.normal < 0.0) on = leave_vertex(within, on, candidate);
    if (on.normal >= 0.0) {
      static_cast<void>(record_decision(node, true));
      slide(within, node, on, candidate);
      return true;
    }
    surface = on.weakest == on.touch.surface ? on.touch.second : on.touch.surface;
  } else if (before.second >= 0) {
    const Slide on = slide_along_edge(within, before.surface, before.second, candidate);
    if (on.normal >= 0.0) {
      static_cast<void>(record_decision(node, true));
      slide(within, node, on, candidate);
      return true;
    }
    surface = on.weakest == before.surface ? before.second : before.surface;
  }
  const auto j = static_cast<std::size_t>(surface);
  if (obstacles_[j].friction().kind == Friction::Kind::held) {
    const Vector3 place = carried(at, candidate.start, surface);
    const Vector3 missing = velocity(at, j, place) - candidate.velocity;
    if (!has_chattered(node) && normal(at, j, place).dot(candidate.inertia * missing) < 0.0) return false;
    static_cast<void>(record_decision(node, true));
    stop(within, node, {surface, false}, place, candidate);
    return true;
  }
  const Slide on = slide_along(within, surface, candidate);
  if (on.normal < 0.0) return false;
  static_cast<void>(record_decision(node, true));
  slide(within, node, on, candidate);
  return true;
}

// Between decisions a slip that has turned round is over: friction would drive it.
Touch Contact::stopped_by_friction(const Placement& at, std::uint32_t node, const Candidate& candidate) {
  Touch touch = now(node);
  const auto surface = static_cast<std::size_t>(touch.surface);
  if (!touch.slides || touch.count() > 1 || obstacles_[surface].friction().kind == Friction::Kind::none) return touch;
  const Vector3 slip = slip_vector(at, node, surface, candidate.position, candidate.velocity);
  if (slip.dot(slip_[node]) < 0.0)
    touch.slides = false;
  else
    slip_[node] = slip;
  return touch;
}

void Contact::keep(const Within& within, std::uint32_t node, const Touch& touch, const Candidate& candidate) {
  if (touch.slides && touch.third >= 0) {
    set_outputs(within, node, at_vertex(within, touch, candidate));
    return;
  }
  if (!touch.slides) {
    const Vector3 place = where_it_sticks(within, node, touch.surface, candidate);
    const auto& rough = obstacles_[static_cast<std::size_t>(touch.surface)].friction();
    if (arrives(node, touch.surface) && touch.count() == 1 && rough.kind == Friction::Kind::coulomb)
      set_outputs(within, node, arrived_at(within, touch.surface, place, candidate));
    else
      stop(within, node, touch, place, candidate);
    return;
  }
  Slide on = touch.second >= 0 ? slide_along_edge(within, touch.surface, touch.second, candidate)
                               : slide_along(within, touch.surface, candidate);
  on.touch = touch;
  set_outputs(within, node, on);
}

Contact::Slide Contact::arrived_at(const Within& within, std::int32_t surface, const Vector3& place,
                                   const Candidate& candidate) const {
  const auto& [sweep, at] = within;
  const double h = sweep.time_constant, theta = theta_of(sweep);
  Slide result;
  result.touch = {surface, false};
  result.weakest = surface;
  result.position = place;
  result.velocity =
      h > 0.0 ? Vector3((place - candidate.start - (1.0 - theta) * h * candidate.start_velocity) / (theta * h))
              : velocity(at, static_cast<std::size_t>(surface), place);
  result.impulse = candidate.inertia * (result.velocity - candidate.velocity);
  result.normal = normal(at, static_cast<std::size_t>(surface), place).dot(result.impulse);
  result.lands = true;
  result.landing = velocity(at, static_cast<std::size_t>(surface), place);
  result.landing_impulse = mass_[candidate.node] * (result.landing - result.velocity);
  result.slip.setZero();
  return result;
}

// Where slide_along() and meet() put a node that sticks.
Vector3 Contact::where_it_sticks(const Within& within, std::uint32_t node, std::int32_t surface,
                                 const Candidate& candidate) const {
  const auto& [sweep, at] = within;
  const Touch& before = committed(node);
  if (before.surface == surface && !before.slides) return carried(at, candidate.start, surface);
  const auto j = static_cast<std::size_t>(surface);
  if (obstacles_[j].friction().kind == Friction::Kind::held)
    return where_it_touched(at, sweep.time_constant, candidate.start, candidate.start_velocity, surface);
  const Vector3 slipped =
      rotated_with(at, surface, candidate.start, candidate.start_velocity - velocity(*start_, j, candidate.start));
  return onto(at, j, carried(at, candidate.start, surface) + sweep.time_constant * (1.0 - theta_of(sweep)) * slipped);
}

}  // namespace springnet
