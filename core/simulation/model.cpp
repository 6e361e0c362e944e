#include "simulation/model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "layers/internal_queries.hpp"
#include "plugin_host/message.hpp"

namespace springnet {
namespace {

// In units of the length scale.
constexpr double coincidence = 1e-10;
// In units of the velocity scale.
constexpr double rounding_of_speed = 1e-13;

std::vector<double> masses(const Network& network, const std::vector<std::uint32_t>& user) {
  std::vector<double> mass;
  mass.reserve(user.size());
  for (const std::uint32_t k : user) mass.push_back(network.nodes()[k].mass);
  return mass;
}

}  // namespace

Model::Model(const Network& network, const PluginHost& plugins, const SimulationOptions& options, const Model* before)
    : layout(network, plugins, options.renumber, options.threads),
      mass(masses(network, layout.ordering().user)),
      evaluator(layout, mass, options.instruction_set, layout.laws().on_one_thread() ? 1 : options.threads),
      loads(network, layout),
      constraints(network, layout.ordering().user, layout.ordering().engine, mass),
      contact(constraints.contact()),
      rigid(constraints.rigid()),
      state(layout.node_count(), layout.internal().count()),
      time_step(options.time_step),
      step_length(0.0) {
  if (before != nullptr) {
    take_over(*before, network);
    return;
  }
  const std::shared_ptr<const Placement> start = placement(0.0);
  const Prescribed& prescribed = contact.prescribed();
  for (std::uint32_t k = 0; k < node_count(); ++k) {
    const Node& node = network.nodes()[user_number(k)];
    const bool moves = prescribed.moves(k);
    put_vector(state.view.position, k, moves ? prescribed.position(start->motions, k) : node.position);
    put_vector(state.view.velocity, k,
               moves        ? prescribed.velocity(start->motions, k)
               : node.fixed ? Vector3::Zero()
                            : node.velocity);
  }
  static_cast<void>(loads.set_interval(0.0, std::numeric_limits<double>::infinity()));
  start_internal();
}

Model::Model(const Model& other, const Network& network, const SimulationOptions& options)
    : layout(other.layout),
      mass(other.first_mass()),
      evaluator(layout, mass, options.instruction_set, layout.laws().on_one_thread() ? 1 : options.threads),
      loads(network, layout),
      constraints(network, layout.ordering().user, layout.ordering().engine, mass),
      contact(constraints.contact()),
      rigid(constraints.rigid()),
      scales(other.scales),
      state(layout.node_count(), layout.internal().count()),
      time_step(options.time_step),
      step_length(0.0) {
  contact.set_rest_speed(other.contact.rest_speed());
}

layers::InternalView Model::internal_for(const springnet_internal* request) {
  layers::InternalView view = state.internal;
  if (request == nullptr) return view;
  if (!(request->time_step >= 0.0 && std::isfinite(request->time_step)))
    throw Error(ErrorKind::plugin,
                fmt::format("internal: the time step is {} s, must be at least 0", request->time_step));
  if (request->time_step == 0.0) {
    if (request->values != nullptr) view.values = request->values;
    view.rates = request->rates;
    // At the end of a step without length they are those at its start.
    if (request->next != nullptr) std::copy_n(view.values, layout.internal().count(), request->next);
    return view;
  }
  if (request->order != 1 && request->order != 2)
    throw Error(ErrorKind::plugin, fmt::format("internal: the order is {}, must be 1 or 2", request->order));
  view.time_step = request->time_step;
  view.order = request->order;
  view.next = request->next;
  if (!layout.internal().reads_start(view.order)) return view;
  if (!start_known_) {
    start_q_.resize(layout.internal().count());
    start_rate_.resize(layout.internal().count());
    layers::invariants_of_states(layout, evaluator.instruction_set(), state.nodes(), start_q_.data(),
                                 start_rate_.data());
    start_known_ = true;
  }
  view.start_q = start_q_.data();
  view.start_rate = start_rate_.data();
  return view;
}

void Model::start_internal() {
  if (!layout.internal().any()) return;
  const springnet_status status = layers::start_states(layout, evaluator.instruction_set(), time, state.nodes(),
                                                       state.view.internal, journal.message);
  if (status == SPRINGNET_OK) return;
  throw Error(status == SPRINGNET_RECOVERABLE ? ErrorKind::simulation : ErrorKind::plugin, journal.message.text);
}

layers::ExternalForces Model::external_at(double at) {
  layout.signals().sample(at);
  loads.follow(interval.at(at).rate);
  return loads.external();
}

const State& Model::with_forces() {
  if (stale.forces) {
    if (evaluator.evaluate(time, state.nodes(), external_at(time), state.forces(), {}, journal.message) != SPRINGNET_OK)
      throw Error(ErrorKind::simulation, journal.message.text);
    stale.forces = false;
  }
  return state;
}

void Model::set_mass(std::uint32_t node, double value) {
  if (first_mass_.empty()) first_mass_ = mass;
  mass[node] = value;
}

void Model::archive_masses(Archive& archive) {
  bool other = !first_mass_.empty();
  archive.flag(other);
  if (other && first_mass_.empty()) first_mass_ = mass;
  if (other) {
    archive.numbers(mass, "masses");
    for (const double each : mass)
      if (!(each > 0.0 && std::isfinite(each))) Archive::refuse("a mass is not above 0");
  } else if (!first_mass_.empty()) {  // in place: others have the address
    std::copy(first_mass_.begin(), first_mass_.end(), mass.begin());
    first_mass_.clear();
  }
}

void Model::archive(Archive& archive) {
  archive_masses(archive);
  // Of a network that was extended they are those from before.
  for (double* each : {&scales.length, &scales.velocity, &scales.force}) {
    archive.number(*each);
    if (!(*each > 0.0 && std::isfinite(*each))) Archive::refuse("a scale is not above 0");
  }
  loads.archive(archive);
  layout.signals().archive(archive);
  contact.archive(archive);
  constraints.bodies().archive(archive);
  journal.archive(archive);
  for (const Event& each : journal.events()) {
    const bool of_spring = each.kind == Event::Kind::cut || each.kind == Event::Kind::ruptured;
    const std::size_t count = each.element ? layout.elements().count()
                              : of_spring  ? layout.spring_count()
                                           : node_count();
    if (each.index >= count || each.surface < -1 ||
        each.surface >= static_cast<std::int32_t>(contact.obstacles().size()))
      Archive::refuse("an event is of nothing that there is");
    for (std::size_t i = 0; i < each.pair_count; ++i)
      if (each.pair[i] >= node_count()) Archive::refuse("an event is of nothing that there is");
  }
  recent_touches.archive(archive);
  recent_slips.archive(archive);
  archive.same(node_count(), "nodes");
  for (const springnet_vectors& vectors : {state.view.position, state.view.velocity, state.view.force})
    for (double* component : {vectors.x, vectors.y, vectors.z}) archive.numbers(component, node_count());
  archive.same(state.internal_count, "internal states");
  archive.numbers(state.view.internal, state.internal_count);
  archive.number(state.view.force_is_current);
  for (double* each : {&time, &interval.from, &interval.until, &step_length, &time_before}) archive.number(*each);
  for (bool* each : {&stale.forces, &stale.contacts, &jumps_due}) archive.flag(*each);
  if (!archive.reads()) return;
  state.view.is_swept = 0;
  if (state.first_not_finite() < node_count() || !state.internal_finite() || !std::isfinite(time))
    Archive::refuse("a number is not finite");
  stale.reactions = stale.pair_forces = true;
  start_known_ = false;
  ++revision;
  ++load_revision;
}

void Model::changed() noexcept {
  ++revision;
  stale = {true, true, true, true};
}

double Model::contact_tolerance() const noexcept {
  // A negligible share of the length scale, and the rounding of positions far from the origin.
  double size = 0.0;
  const springnet_vectors& p = state.view.position;
  for (const double* component : {p.x, p.y, p.z})
    for (std::uint32_t k = 0; k < node_count(); ++k) size = std::max(size, std::abs(component[k]));
  return coincidence * scales.length + 8.0 * std::numeric_limits<double>::epsilon() * size;
}

double Model::no_speed() const noexcept { return rounding_of_speed * scales.velocity; }

void Model::record(Event::Kind kind, double at, std::uint32_t node, std::int32_t surface, const NodeAt& node_at,
                   const Placement& placed, const Vector3& impulse) {
  Event event{kind, at, user_number(node)};
  event.surface = surface;
  event.impulse = impulse;
  event.position = node_at.position;
  event.velocity = node_at.velocity;
  if (surface >= 0) event.normal = contact.normal(placed, static_cast<std::size_t>(surface), node_at.position);
  journal.record(event);
}

void Model::explain(double at, const layers::NodeArrays& nodes, layers::Requested requested) {
  if (journal.non_finite.empty())
    journal.non_finite = explain_failure(layout, evaluator.instruction_set(), at, nodes, requested);
}

springnet_status Model::failed(springnet_status status, double at, const layers::NodeArrays& nodes) {
  const std::string reason = explain_failure(layout, evaluator.instruction_set(), at, nodes);
  if (!reason.empty()) set_message(journal.message, reason);
  journal.non_finite = journal.message.text;
  return status;
}

}  // namespace springnet
