#include "simulation/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"
#include "plugin_host/message.hpp"

namespace springnet {
namespace {

// A node this close to a surface, in units of the length scale, lies on it.
constexpr double coincidence = 1e-10;
// Slip this slow, in units of the velocity scale, keeps the direction that friction acts against: the way that it goes
// until it ends is far below any error of integration.
constexpr double slow_slip = 1e-6;

std::vector<double> masses(const Network& network, const std::vector<std::uint32_t>& user) {
  std::vector<double> mass;
  mass.reserve(user.size());
  for (const std::uint32_t k : user) mass.push_back(network.nodes()[k].mass);
  return mass;
}

}  // namespace

Engine::Engine(const Network& network, const PluginHost& plugins, const SimulationOptions& options)
    : layout_(network, plugins, options.renumber),
      mass_(masses(network, layout_.ordering().user)),
      evaluator_(layout_, mass_, options.instruction_set, options.threads),
      loads_(network, layout_),
      constraints_(network, layout_.ordering().user, layout_.ordering().engine, mass_),
      contact_(constraints_.contact()),
      rigid_(constraints_.rigid()),
      linearisation_(layout_, evaluator_, contact_.constrained()),
      no_cluster_(layout_.node_count(), 0xffffffffu),
      state_(layout_.node_count()),
      time_step_(options.time_step) {
  const std::shared_ptr<const Placement> start = placement(0.0);
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    const Node& node = network.nodes()[layout_.ordering().user[k]];
    const bool moves = contact_.prescribed().moves(k);
    put_vector(state_.view.position, k, moves ? contact_.prescribed().position(start->motions, k) : node.position);
    put_vector(state_.view.velocity, k,
               moves        ? contact_.prescribed().velocity(start->motions, k)
               : node.fixed ? Vector3::Zero()
                            : node.velocity);
  }
  for (const Cut& cut : network.cuts()) {
    ScheduledCut scheduled{cut.time, cut.springs, std::nullopt};
    if (!cut.polygon.empty()) scheduled.polygon.emplace(cut.polygon);
    cuts_.push_back(std::move(scheduled));
  }
  static_cast<void>(loads_.set_interval(0.0, std::numeric_limits<double>::infinity()));
  perform_due_cuts();
  if (perform_due_ruptures() != SPRINGNET_OK) throw Error(ErrorKind::simulation, message_.text);
  set_scales();
  start_constraints(size_of(network));
}

double Engine::potential_energy() {
  if (potential_energy_) return *potential_energy_;  // the page and the check of a record ask for the same
  const layers::NodeArrays nodes = state_.nodes();
  double sum = layers::spring_energy(layout_, evaluator_.instruction_set(), time_, nodes) +
               layers::element_energy(layout_, evaluator_.instruction_set(), time_, nodes);
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k)
    sum -= mass_[k] * loads_.gravity().dot(vector_at(state_.view.position, k));
  potential_energy_ = sum;
  if (!std::isfinite(sum)) note_energy();
  return sum;
}

void Engine::note_energy() {
  if (energy_noted_) return;
  energy_noted_ = true;
  const std::string reason = layers::explain_failure(layout_, evaluator_.instruction_set(), time_, state_.nodes(),
                                                     layers::Asked::forces_and_energies);
  note(
      fmt::format("At {:g} s the energy is not a finite number{}{}. What follows is no solution where a law was driven "
                  "beyond its limit; use a smaller time_step.",
                  time_, reason.empty() ? "" : ": ", reason));
}

void Engine::changed() noexcept {
  ++revision_;
  reactions_known_ = false;
  potential_energy_.reset();
  forces_stale_ = true;
  unsettled_ = true;
}

const State& Engine::state() {
  if (forces_stale_) {
    if (evaluator_.evaluate(time_, state_.nodes(), external_at(time_), state_.forces(), {}, message_) != SPRINGNET_OK)
      throw Error(ErrorKind::simulation, message_.text);
    forces_stale_ = false;
  }
  return state_;
}

double Engine::contact_tolerance() const noexcept {
  // Rounding of positions far from the origin, beside the part of the length scale that does not matter.
  double size = 0.0;
  const springnet_vectors& p = state_.view.position;
  for (const double* component : {p.x, p.y, p.z})
    for (std::uint32_t k = 0; k < layout_.node_count(); ++k) size = std::max(size, std::abs(component[k]));
  return coincidence * info_.length_scale + 8.0 * std::numeric_limits<double>::epsilon() * size;
}

// Lengths and velocities fit the rigid connections from the start; a node that starts on a surface with a force into it
// is held from the start.
void Engine::start_constraints(double size) {
  const std::shared_ptr<const Placement> start = placement(time_);
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    if (contact_.fixed()[k] != 0) continue;
    for (std::size_t j = 0; j < contact_.surfaces().size(); ++j) {
      const double depth =
          starting_depth(contact_.surfaces()[j], start->poses[j], vector_at(state_.view.position, k), size);
      if (depth == 0.0) continue;
      const bool plane = contact_.surfaces()[j].is_plane();
      throw Error(ErrorKind::input, misplaced(layout_.ordering().user[k], depth, plane, contact_.name_of(j)));
    }
  }
  if (rigid_.any()) {
    const double rate = rigid_.greatest_rate(read_only(state_.view.position), read_only(state_.view.velocity));
    if (rate > 1e-9 * info_.velocity_scale)
      note(
          fmt::format("the initial velocities change the length of rigid connections by up to {:.3g} m/s; the nearest "
                      "velocities that do not are taken",
                      rate));
  }
  const auto project = [&] {
    if (constraints_.project(*start, state_.view.position, state_.view.velocity, message_) != SPRINGNET_OK)
      throw Error(ErrorKind::input, message_.text);
  };
  project();
  if (settle_contacts(time_, state_) != SPRINGNET_OK) throw Error(ErrorKind::simulation, message_.text);
  project();  // what a surface stopped stops what hangs rigidly on it
}

// Typical length, velocity and force, from which tolerances are made: mean rest length, or where there is no
// spring the distance of two nodes of an element; the greatest initial speed or
// the speed that the greatest initial acceleration reaches over that length; the greatest weight, load, net force or
// force that holds the greatest initial speed on a circle of that length.
void Engine::set_scales() {
  double length = 0.0;
  std::size_t count = 0;
  for (std::uint32_t s = 0; s < layout_.spring_count(); ++s) {
    const double rest = layout_.group_of(s).columns[0][layout_.laws().row[s]];
    if (rest > 0.0) {
      length += rest;
      ++count;
    }
  }
  for (std::uint32_t e = 0; length == 0.0 && e < layout_.elements().count(); ++e) {
    const std::span<const std::uint32_t> nodes = layout_.elements().nodes(e);
    length = (vector_at(state_.view.position, nodes[1]) - vector_at(state_.view.position, nodes[0])).norm();
    count = length > 0.0 ? 1 : 0;
  }
  length = count > 0 ? length / static_cast<double>(count) : 1.0;
  double speed = 0.0, acceleration = 0.0, force = 0.0, mass = 0.0;
  const State& now = state();
  const double load = loads_.greatest();
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    const springnet_state& s = now.view;
    const double v = Vector3(s.velocity.x[k], s.velocity.y[k], s.velocity.z[k]).norm();
    const double f = std::max(load, Vector3(s.force.x[k], s.force.y[k], s.force.z[k]).norm());
    speed = std::max(speed, v);
    mass = std::max(mass, mass_[k]);
    acceleration = std::max(acceleration, f / mass_[k]);
    force = std::max({force, f, mass_[k] * loads_.gravity().norm(), mass_[k] * v * v / length});
  }
  const auto or_one = [](double value, double fallback) {
    return std::isfinite(value) && value > 0.0 ? value : fallback;
  };
  info_.length_scale = length;
  info_.velocity_scale = or_one(std::max(speed, std::sqrt(acceleration * length)), length);
  info_.force_scale = or_one(force, or_one(mass * length, 1.0));
  contact_.set_rest_speed(slow_slip * info_.velocity_scale);
}

const springnet_network& Engine::network_info() {
  if (info_revision_ != revision_) {
    info_.struct_size = sizeof info_;
    info_.node_count = layout_.node_count();
    info_.spring_count = layout_.live_count();
    info_.internal_count = 0;
    info_.revision = revision_;
    info_.unit_count = static_cast<std::uint32_t>(layout_.units().size());
    info_.event_count = static_cast<std::uint32_t>(event_sources().size());
    info_.surface_count = static_cast<std::uint32_t>(contact_.surfaces().size());
    info_.mass = mass_.data();
    info_.fixed = contact_.fixed().data();
    info_.held = contact_.held().data();
    info_.user_number = layout_.ordering().user.data();
    info_.neighbour_start = layout_.neighbour_start().data();
    info_.neighbours = layout_.neighbours().data();
    info_.touching = contact_.touching().data();
    info_.cluster = rigid_.any() ? rigid_.cluster_of() : no_cluster_.data();
    info_.rigid_count = rigid_.rods().size();
    info_.status = contact_.status().data();
    info_revision_ = revision_;
  }
  info_.load_revision = load_revision_;
  return info_;
}

springnet_status Engine::begin_step(double from, double until) {
  step_length_ = until - from;
  const Loads::Change loads = loads_.set_interval(from, until);
  if (loads != Loads::Change::none) {
    ++load_revision_;
    reactions_known_ = false;
    forces_stale_ = true;
  }
  return begin(from, until, loads);
}

springnet_status Engine::begin_interval(double from, double until) {
  step_length_ = 0.0;
  return begin(from, until, loads_.begin_following(from));
}

springnet_status Engine::begin(double from, double until, Loads::Change loads) {
  non_finite_.clear();
  interval_ = until > from ? Interval{from, until} : Interval{};
  const std::shared_ptr<const Placement> now = contact_.at(just_after(time_));
  if (loads == Loads::Change::switched) changed();
  springnet_status status = SPRINGNET_OK;
  if (unsettled_) {
    // A load that was switched, a cut, a change by the embedding program: the same nodes are held, and the same springs
    // broken, whatever the integrator and the length of its steps.
    unsettled_ = false;
    status = perform_due_ruptures();
    if (status == SPRINGNET_OK) status = settle_contacts(time_, state_);
    if (status == SPRINGNET_OK)
      status = constraints_.project(*now, state_.view.position, state_.view.velocity, message_);
    // Steps that begin here once more begin with the same contacts, also where none were found that fit.
    unsettled_ = false;
  }
  // What was let go since the last step has nothing left to be told of.
  for (std::uint32_t k = 0; k < withheld_.size(); ++k)
    if (contact_.touching()[k] == 0) withheld_[k].setZero();
  contact_.begin_step(now);
  swept_ = false;
  if (status == SPRINGNET_OK) status = note_anchored();
  return status;
}

void Engine::let_go(std::uint32_t node) {
  for (const std::int32_t surface : contact_.committed(node).surfaces()) {
    if (surface < 0) continue;
    Event event{Event::Kind::released, time_, layout_.ordering().user[node]};
    event.surface = surface;
    events_.push_back(event);
  }
  contact_.release(node);
  changed();
}

void Engine::set_node(std::uint32_t node, const std::optional<Vector3>& position,
                      const std::optional<Vector3>& velocity) {
  const std::shared_ptr<const Placement> now = contact_.at(just_after(time_));
  if (position) {
    put_vector(state_.view.position, node, *position);
    contact_.release(node);
  }
  if (velocity) {
    put_vector(state_.view.velocity, node, *velocity);
    const Touch touch = contact_.committed(node);
    if (touch.surface >= 0) {
      // What lifts it releases it; along the surface and into it the surface holds it, or lets it slide.
      const auto j = static_cast<std::size_t>(touch.surface);
      const Vector3 p = vector_at(state_.view.position, node);
      const Vector3 n = contact_.normal(*now, j, p), w = Contact::velocity(*now, j, p);
      const double lifting = n.dot(*velocity - w);
      if (touch.second >= 0) {
        // Between two: they are met anew where it still runs into them.
        let_go(node);
      } else if (lifting > 0.0) {
        let_go(node);
      } else if (contact_.surfaces()[j].friction().kind == Friction::Kind::held) {
        put_vector(state_.view.velocity, node, w);
      } else {
        put_vector(state_.view.velocity, node, *velocity - n * lifting);
        contact_.touch(node, after(touch, {ContactCause::Kind::slip}), Vector3::Zero());
        contact_.set_slip(node, Vector3::Zero());  // it has a new one
      }
    }
  }
  changed();
}

void Engine::set_fixed(std::uint32_t node, bool fixed) {
  contact_.stop_motion(node);
  contact_.set_fixed(node, fixed);
  set_node(node, std::nullopt, fixed ? std::optional<Vector3>(Vector3::Zero()) : std::nullopt);
}

}  // namespace springnet
