// Changes of the network while it runs: contacts made and released, ruptures, cuts, and the commit of a step.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "constraints/vectors.hpp"
#include "layers/element_questions.hpp"
#include "layers/elements.hpp"
#include "layers/message.hpp"
#include "plugin_host/call.hpp"
#include "simulation/engine.hpp"

namespace springnet {
namespace {

// A prescribed velocity that changes by less, in units of the velocity scale, is another sample of a smooth motion.
constexpr double no_jump = 1e-9;

}  // namespace

const Engine::Rupturing& Engine::rupturing() {
  if (!rupturing_known_) {
    rupturing_ = {layers::rupturing_springs(layout_), layers::rupturing_elements(layout_)};
    rupturing_known_ = true;
  }
  return rupturing_;
}

springnet_status Engine::rupture_margins(double time, const layers::NodeArrays& nodes, double* margins) {
  const Rupturing& some = rupturing();
  const InstructionSet set = evaluator_.instruction_set();
  springnet_status status = layers::rupture_margins(layout_, set, time, nodes, some.springs, margins, message_);
  if (status == SPRINGNET_OK)
    status = layers::element_margins(layout_, set, time, nodes, some.elements, margins + some.springs.size(), message_);
  if (status != SPRINGNET_OK) return status;
  // A margin that is no number says neither that the element holds nor that it breaks.
  const double* const bad = std::find_if(margins, margins + some.count(), [](double m) { return std::isnan(m); });
  if (bad == margins + some.count()) return SPRINGNET_OK;
  const auto i = static_cast<std::size_t>(bad - margins);
  const bool element = i >= some.springs.size();
  const std::uint32_t number = element ? some.elements[i - some.springs.size()] : some.springs[i];
  const layers::Group& group =
      layout_.laws().groups[element ? layout_.elements().group(number) : layout_.laws().group[number]];
  const layers::Law& law = group.spring.can(SPRINGNET_HAS_RUPTURE) ? group.spring : group.viscosity;
  const std::string reason = explain_failure(layout_, set, time, nodes);
  set_message(message_, !reason.empty()
                            ? reason
                            : fmt::format("{} answered a rupture margin that is not a number for {} {}",
                                          full_name(*law.component), element ? "element" : "spring", number));
  return SPRINGNET_RECOVERABLE;
}

std::size_t Engine::remove(const std::vector<std::uint32_t>& springs, const std::vector<std::uint32_t>& elements,
                           const std::vector<std::size_t>& faces, Event::Kind kind, double time) {
  const std::vector<std::uint32_t> removed = layout_.remove(springs);
  for (const std::uint32_t s : removed) note(kind, time, s);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;
  for (const std::uint32_t s : removed) ends.emplace_back(layout_.first(s), layout_.second(s));
  std::vector<std::uint32_t> broken;
  if (layout_.elements().live_count() > 0) {
    broken = layout_.elements().broken_by(ends);
    broken.insert(broken.end(), elements.begin(), elements.end());
    std::sort(broken.begin(), broken.end());
    broken = layout_.remove_elements(broken);
    for (const std::uint32_t e : broken) events_.push_back({kind, time, e, true});
  }
  bool faces_went = false;
  if (layout_.loaded_faces().count() > 0) {
    std::vector<std::size_t> lost = layout_.loaded_faces().broken_by(ends);
    lost.insert(lost.end(), faces.begin(), faces.end());
    faces_went = remove_faces(lost, time);
  }
  if (!removed.empty() || !broken.empty() || faces_went) {
    rupturing_known_ = false;
    linearisation_.topology_changed();
    changed();
  }
  return removed.size();
}

bool Engine::remove_faces(const std::vector<std::size_t>& faces, double time) {
  const std::vector<std::size_t> removed = layout_.remove_faces(faces);
  if (removed.empty()) return false;
  loads_.faces_changed();
  torn_faces_ += removed.size();
  std::set<std::uint32_t> loads;
  for (const std::size_t f : removed) loads.insert(layout_.loaded_faces().load_of(f));
  for (const std::uint32_t load : loads) {
    if (!torn_loads_.insert(load).second) continue;
    note(fmt::format(
        "Force {} ended on faces that were torn, first at {:g} s: a face goes with a spring along its side.", load,
        time));
  }
  return true;
}

std::size_t Engine::cut(const std::vector<std::uint32_t>& springs) {
  return remove(springs, {}, {}, Event::Kind::cut, time_);
}

std::size_t Engine::cut(const CuttingPolygon& polygon) {
  const auto crosses = [&](std::uint32_t a, std::uint32_t b) {
    return polygon.crosses(vector_at(state_.view.position, a), vector_at(state_.view.position, b));
  };
  std::vector<std::uint32_t> crossed;
  for (std::uint32_t s = 0; s < layout_.spring_count(); ++s)
    if (layout_.alive(s) && crosses(layout_.first(s), layout_.second(s))) crossed.push_back(s);
  return remove(crossed, layout_.elements().crossed_by(crosses), layout_.loaded_faces().crossed_by(crosses),
                Event::Kind::cut, time_);
}

void Engine::perform_due_cuts() {
  // Rounding of times: a cut this close to a committed one is due at it.
  const double slack = 1e-9 * std::min(time_step_, time_);
  for (std::size_t k = 0; k < cuts_.size(); ++k) {
    ScheduledCut& scheduled = cuts_[k];
    if (scheduled.done || scheduled.time > time_ + slack) continue;
    scheduled.done = true;
    const auto met = [this] { return events_.size() + torn_faces_; };
    const std::size_t before = met();
    cut(scheduled.springs);
    if (scheduled.polygon) cut(*scheduled.polygon);
    if (met() == before)
      notes_.push_back(fmt::format("Cut {} at {:g} s met nothing that was left to cut.", k, scheduled.time));
  }
}

springnet_status Engine::perform_due_ruptures() {
  const Rupturing& some = rupturing();
  if (some.count() == 0) return SPRINGNET_OK;
  std::vector<double> margins(some.count());
  const springnet_status status = rupture_margins(time_, state_.nodes(), margins.data());
  if (status != SPRINGNET_OK) return status;
  std::vector<std::uint32_t> springs, elements;
  for (std::size_t i = 0; i < margins.size(); ++i) {
    if (margins[i] > 0.0) continue;
    if (i < some.springs.size())
      springs.push_back(some.springs[i]);
    else
      elements.push_back(some.elements[i - some.springs.size()]);
  }
  remove(springs, elements, {}, Event::Kind::ruptured, time_);
  return SPRINGNET_OK;
}

double Engine::next_discontinuity(double time) const noexcept {
  double next = std::min(loads_.next_switch(time), contact_.next_change(time));
  for (const ScheduledCut& cut : cuts_)
    if (!cut.done && cut.time > time) next = std::min(next, cut.time);
  return next;
}

std::set<std::uint32_t> Engine::follow_prescribed() {
  std::set<std::uint32_t> pulled;
  const Prescribed& prescribed = contact_.prescribed();
  if (!prescribed.any()) return pulled;
  const std::shared_ptr<const Placement> now = contact_.at(just_after(time_));
  const std::uint32_t* const clusters = rigid_.cluster_of();
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    if (!prescribed.moves(k)) continue;
    const Vector3 jump = prescribed.velocity(now->motions, k) - vector_at(state_.view.velocity, k);
    put_vector(state_.view.position, k, prescribed.position(now->motions, k));
    put_vector(state_.view.velocity, k, prescribed.velocity(now->motions, k));
    if (jump.norm() <= no_jump * info_.velocity_scale) continue;
    contact_.add_impulse(k, mass_[k] * jump);
    if (clusters != nullptr && clusters[k] != ConstraintRow::no_node) pulled.insert(clusters[k]);
  }
  for (const std::uint32_t cluster : pulled) {
    const RigidConnections::WithoutContact rods(rigid_, cluster, read_only(state_.view.position));
    rods.pull_along(state_.view.velocity,
                    [this](std::uint32_t fixed, const Vector3& impulse) { contact_.add_impulse(fixed, -impulse); });
  }
  return pulled;
}

springnet_status Engine::commit(double time, State& state) {
  check_commit(time, state);
  if (const springnet_status room = check_room(time, state); room != SPRINGNET_OK) return room;
  if (state.view.force_is_current != 0 && !state.forces_finite()) state.view.force_is_current = 0;
  state_.swap(state);
  const double from = time_;
  time_ = time;
  reactions_known_ = false;
  forces_stale_ = state_.view.force_is_current == 0;
  springnet_status status = SPRINGNET_OK;
  const bool jumps = contact_.next_change(from) <= time;  // what moves, in its velocity or acceleration
  if (swept_) {
    swept_ = false;
    status = commit_sweeps(time);
  } else {
    // What a solver left of rounding in unknowns that do not move.
    const std::shared_ptr<const Placement> now = placement(time);
    constraints_.correct(*now, read_only(state.view.position), state_.view.position, state_.view.velocity);
    if (!jumps) static_cast<void>(follow_prescribed());
    status = stop_penetration(time, state_);
    if (status == SPRINGNET_OK)
      status = constraints_.project(*placement(time), state_.view.position, state_.view.velocity, message_);
    if (status == SPRINGNET_OK) status = find_squeezed(time, state_);
    contact_.note_slips(*placement(time), read_only(state_.view.position), read_only(state_.view.velocity));
  }
  if (status == SPRINGNET_OK && jumps) {
    // What was said of just before no longer holds.
    interval_ = {};
    changed();
    status = follow_jumps(from);
    if (status == SPRINGNET_OK)
      status = constraints_.project(*placement(time), state_.view.position, state_.view.velocity, message_);
  }
  if (status != SPRINGNET_OK) return status;
  if (jumps) note_shed(from);
  committed_events_ = events_.size();
  status = perform_due_ruptures();
  perform_due_cuts();
  return status;
}

void Engine::move_surface(std::size_t surface, const Vector3& position, double time) {
  const Vector3 now = contact_.at(just_after(time_))->poses[surface].displacement;
  Motion motion;
  motion.interpolation = Motion::Interpolation::linear;
  motion.times = {time_, time};
  motion.displacements = {now, contact_.surfaces()[surface].displacement_to(position, time)};
  contact_.set_trajectory(surface, Trajectory(motion));
  interval_ = {};
  changed();  // nodes that touch it follow, or are left, when the next step begins
}

void Engine::move_node(std::uint32_t node, const Vector3& position, double time) {
  const Vector3 now = vector_at(state_.view.position, node);
  Motion motion;
  motion.interpolation = Motion::Interpolation::linear;
  motion.times = {time_, time};
  motion.displacements = {Vector3::Zero(), position - now};
  contact_.set_fixed(node, true);
  contact_.set_motion(node, now, Trajectory(motion));
  static_cast<void>(follow_prescribed());
  changed();
}

}  // namespace springnet
