// A time step, stage by stage.
//
// An integrator that takes the user's steps (recurrent, verlet):
//   begin_step       loads averaged over the step; if something changed from outside: due ruptures, contacts settled,
//                    constraints projected
//   run_sweep        forces, the integrator's update of nodes, constraints; again until the outputs are settled
//                    (verlet: sweep().evaluate, constrain for the drift, evaluate, constrain for the kick)
//   commit           room for the nodes; contacts that the sweeps decided, impulses (verlet: as below); jumps;
//                    ruptures; cuts
//
// One that chooses its own steps and finds events (cvode; with located events also recurrent):
//   begin_interval   loads follow the time; the rest as in begin_step
//   sweep().evaluate, linear()                 right-hand sides and linear systems, as often as it likes
//   contact_events().values, time_of_impact    detect events in this step
//   fire_events      carries them out: contacts settled, springs broken
//   commit           room for the nodes; constraints projected; penetration stopped; jumps; ruptures; cuts

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "profile/stage.hpp"
#include "simulation/body_impact_search.hpp"
#include "simulation/contact_changes.hpp"
#include "simulation/engine.hpp"
#include "simulation/impact_search.hpp"
#include "simulation/step_watch.hpp"
#include "simulation/verlet_contact.hpp"

namespace springnet {

// ---- begin ----------------------------------------------------------------------------------------------------------

springnet_status Engine::begin_step(double from, double until) {
  model_.step_length = until - from;
  if (model_.constraints.bodies().located()) {
    model_.constraints.bodies().set_located(false);
    ++model_.revision;  // without their events
  }
  model_.interval = until > from ? Interval{from, until} : Interval{};
  const Loads::Change loads = model_.loads.set_interval(from, until);
  if (loads != Loads::Change::none) {
    ++model_.load_revision;
    model_.stale.reactions = model_.stale.pair_forces = model_.stale.forces = true;
  }
  return begin(from, until, loads, swept_);
}

springnet_status Engine::begin_interval(double from, double until, bool locates_bodies) {
  model_.step_length = 0.0;
  model_.interval = until > from ? Interval{from, until} : Interval{};
  BodyContacts& bodies = model_.constraints.bodies();
  if (bodies.any() && locates_bodies && !bodies.located()) {
    bodies.set_located(true);
    model_.stale.contacts = true;
    ++model_.revision;
  }
  return begin(from, until, model_.loads.begin_following(from), false);
}

springnet_status Engine::begin(double from, double until, Loads::Change loads, bool sweeps_follow) {
  model_.begin_internal_steps();
  model_.journal.non_finite.clear();
  const bool signals_jump = model_.layout.signals().set_interval(from, until, model_.time_step);
  if (loads == Loads::Change::switched || signals_jump) model_.changed();
  springnet_status status = model_.stale.contacts ? settle() : SPRINGNET_OK;
  if (status == SPRINGNET_OK && std::exchange(model_.jumps_due, false)) {
    const Interval interval = model_.interval;
    status = commit_jumps(model_.time_before, sweeps_follow);
    model_.interval = interval;
    model_.stale.contacts = false;
  }
  model_.contact.begin_step(model_.placement_now());
  sweep_.forget();
  sweep_.pairs().begin_step();
  if (status == SPRINGNET_OK) status = ledger_.begin_step();
  if (dissipation_) dissipation_->begin_step(model_);
  return status;
}

// After a load was switched, a spring cut, or a state set by the embedding program: the same nodes touch and the same
// springs break for every integrator and length of step.
springnet_status Engine::settle() {
  const profile::Stage stage("settle");
  springnet_status status = topology_.perform_due_ruptures();
  if (status == SPRINGNET_OK) status = settle_contacts(model_);
  if (status == SPRINGNET_OK)
    status = model_.constraints.project(*model_.placement_now(), model_.state.view.position, model_.state.view.velocity,
                                        model_.journal.message);
  // A repeated step begins with the same contacts, even if no contacts were found that satisfy the constraints.
  model_.stale.contacts = false;
  return status;
}

// ---- within ---------------------------------------------------------------------------------------------------------

springnet_status Engine::run_sweep(const springnet_sweep& sweep) { return sweep_.run(sweep, network_info()); }

springnet_status Engine::constrain(const springnet_sweep& request) {
  const springnet_sweep sweep = complete(request);
  const bool of_verlet = sweep.contacts == 2 || sweep.contacts == 3;
  return of_verlet ? constrain_verlet(model_, sweep, verlet_) : sweep_.constrain(sweep);
}

springnet_status Engine::fire_events(double time, State& state, const std::int32_t* fired) {
  if (StepWatch* const watch = StepWatch::current()) watch->fires(*this, time, state, fired);
  return contact_events_.fire(time, state, fired);
}

springnet_status Engine::time_of_impact(springnet_impact_search& search) {
  struct Guard {
    bool& flag;
    explicit Guard(bool& of) : flag(of) { flag = true; }
    ~Guard() { flag = false; }
  } const guard(model_.in_callback);  // state_at must not change the model during the search
  model_.position_uncertainty = search.depth;
  const springnet_status status = ImpactSearch(model_, contact_events_.sources(), search).find(search.time);
  if (status != SPRINGNET_OK || !model_.constraints.bodies().located()) return status;
  const double thickness = model_.constraints.bodies().least_thickness(), tolerance = model_.contact_tolerance();
  if (!(thickness > 2.0 * tolerance))
    throw Error(ErrorKind::input,
                fmt::format("contact of bodies: radii and half thicknesses of {:g} m together are less than twice the "
                            "{:g} m to which contacts are located in a scene of this size; make bodies thicker",
                            thickness, tolerance));
  double meeting = 0.0;
  const springnet_status of_bodies = BodyImpactSearch(model_, contact_events_, search).find(meeting);
  search.time = std::fmin(search.time, meeting);  // nan: none
  return of_bodies;
}

springnet_status Engine::project_state(double time, const springnet_vectors& position,
                                       const springnet_vectors& velocity) {
  const std::shared_ptr<const Placement> now = model_.placement(time);
  model_.constraints.place(*now, read_only(model_.state.view.position), position, velocity);
  return model_.constraints.project(*now, position, velocity, model_.journal.message);
}

double Engine::next_discontinuity(double time) const noexcept {
  return std::min({model_.loads.next_switch(time), model_.layout.laws().signals->next_kink(time),
                   model_.contact.next_change(time), topology_.next_cut(time), changes_.next(time)});
}

void Engine::forget() noexcept {
  sweep_.forget();
  linear_.forget();
  verlet_.reset();
  swept_ = false;
}

// ---- commit ---------------------------------------------------------------------------------------------------------

springnet_status Engine::commit(double time, State& state) {
  const bool is_finite = state.view.is_swept != 0 && sweep_.left_finite(state.view.position, state.view.velocity);
  state.view.is_swept = 0;
  calls_.check_commit(time, state, is_finite);
  if (const springnet_status room = check_room(model_, time, state); room != SPRINGNET_OK) return room;
  if (sweep_.done().any)
    if (const springnet_status apart = sweep_.pairs().check(state.view.position); apart != SPRINGNET_OK) return apart;
  if (state.view.force_is_current != 0 && !state.forces_finite()) state.view.force_is_current = 0;
  model_.begin_internal_steps();
  model_.state.swap(state);
  topology_.keep_states_of_removed(state);
  const double from = model_.time;
  model_.time = time;
  contact_events_.committed();
  model_.stale.reactions = model_.stale.pair_forces = true;
  model_.stale.forces = model_.state.view.force_is_current == 0;
  model_.time_before = from;
  const double change = model_.contact.next_change(from);  // of prescribed velocities or accelerations
  const bool told = model_.contact.next_change_of_scene(from) > time && change >= just_before(time, time - from).rate;
  model_.jumps_due = change <= time && told && calls_.ends_at(time);
  const bool jumps = change <= time && !model_.jumps_due;
  swept_ = sweep_.done().any;
  const bool decided = swept_ && sweep_.done().decided;
  springnet_status status = swept_ ? commit_sweeps(state) : commit_solution(state, jumps);
  if (dissipation_) dissipation_->end_step(model_);
  if (status == SPRINGNET_OK && jumps) status = commit_jumps(from, false);
  if (status != SPRINGNET_OK) return status;
  committed_events_ = model_.journal.events().size();
  if (model_.constraints.bodies().located())
    if (status = note_body_forces(); status != SPRINGNET_OK) return status;
  const profile::Stage stage("topology");
  status = topology_.perform_due_ruptures();
  topology_.perform_due_cuts();
  changes_.perform_due();
  sweep_.pairs().begin_step();  // linear systems between steps are of the pairs that touch now
  if (StepWatch* const watch = StepWatch::current(); watch != nullptr && status == SPRINGNET_OK)
    watch->committed(*this, decided);
  return status;
}

springnet_status Engine::commit_sweeps(const State& before) {
  const profile::Stage stage("impulses");
  sweep_.forget();
  if (sweep_.done().decided && model_.contact.land(model_.state.view.velocity)) model_.stale.forces = true;
  const springnet_status status = ledger_.commit(sweep_.done(), before);
  return status == SPRINGNET_OK ? sweep_.pairs().commit(before) : status;
}

springnet_status Engine::commit_solution(const State& before, bool jumps) {
  const profile::Stage stage("constraints");
  const springnet_vectors &position = model_.state.view.position, &velocity = model_.state.view.velocity;
  const std::shared_ptr<const Placement> now = model_.placement(model_.time);
  // Remove what rounding in a solver left in unknowns that do not move.
  model_.constraints.correct(*now, read_only(before.view.position), position, velocity);
  if (!jumps) static_cast<void>(follow_prescribed(model_));
  springnet_status status = stop_penetration(model_);
  if (status == SPRINGNET_OK) status = model_.constraints.project(*now, position, velocity, model_.journal.message);
  if (status == SPRINGNET_OK) status = find_squeezed(model_);
  model_.contact.update_slip_directions(*now, read_only(position), read_only(velocity));
  // An interval has more than one step: sticking nodes are carried from where they are now.
  model_.contact.begin_step(now);
  return status;
}

springnet_status Engine::note_body_forces() {
  ReactionsAt reactions(model_, model_.time, read_only(model_.state.view.position),
                        read_only(model_.state.view.velocity));
  const BodyMotion* bodies = nullptr;
  const springnet_status status = reactions.bodies(bodies);
  if (bodies == nullptr) return status;
  std::vector<PairTouch>& touching = model_.constraints.bodies().touching();
  for (std::size_t i = 0; i < touching.size(); ++i) {
    PairTouch& touch = touching[i];
    const BodyMotion::OfPair& pair = bodies->pairs()[i];
    touch.force = touch.guess = pair.force;
    const Vector3 slip = pair.motion.slip();
    if (!touch.sticks && touch.phase == Contact::Slip::ongoing && slip.norm() > 2.0 * model_.contact.rest_speed())
      touch.slip = slip.normalized();
  }
  return status;
}

springnet_status Engine::commit_jumps(double from, bool sweeps_follow) {
  model_.interval = {};  // placements just before the jump are no longer valid
  model_.changed();
  const auto [status_of_jumps, pulled] = follow_jumps(model_, from, sweeps_follow);
  springnet_status status = status_of_jumps;
  if (status == SPRINGNET_OK && (pulled || !sweeps_follow))
    status = model_.constraints.project(*model_.placement(model_.time), model_.state.view.position,
                                        model_.state.view.velocity, model_.journal.message);
  if (status == SPRINGNET_OK) note_left_behind(model_, committed_events_, from, left_behind_);
  return status;
}

}  // namespace springnet
