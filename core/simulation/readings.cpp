// What a simulation tells of its state.
#include <springnet/simulation.hpp>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "layers/dissipation.hpp"
#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"
#include "simulation/implementation.hpp"

namespace springnet {
namespace {

Vector3 column(const springnet_vectors& v, std::uint32_t k) { return {v.x[k], v.y[k], v.z[k]}; }

std::vector<InternalState> names_of_states(const layers::Group& group) {
  std::vector<InternalState> names;
  for (const layers::Law* const law : group.laws()) {
    for (std::size_t j = 0; j < law->state_count; ++j) {
      const springnet_parameter& state = *law->component->law().states[j];
      names.push_back({state.name, state.unit, law == &group.viscosity});
    }
  }
  return names;
}

}  // namespace

double Simulation::time() const noexcept { return impl_->engine.model().time; }
double Simulation::time_step() const noexcept { return impl_->options.time_step; }
std::uint64_t Simulation::steps() const noexcept { return impl_->steps; }
std::uint64_t Simulation::sweeps() const noexcept { return impl_->sweeps; }
std::size_t Simulation::node_count() const noexcept { return impl_->engine.model().layout.node_count(); }
std::size_t Simulation::spring_count() const noexcept { return impl_->engine.model().layout.spring_count(); }
std::size_t Simulation::live_spring_count() const noexcept { return impl_->engine.model().layout.live_count(); }
std::size_t Simulation::element_count() const noexcept { return impl_->engine.model().layout.elements().count(); }
unsigned Simulation::threads() const noexcept { return impl_->engine.model().evaluator.threads(); }
InstructionSet Simulation::instruction_set() const noexcept {
  return impl_->engine.model().evaluator.instruction_set();
}
const StepReport& Simulation::last_report() const noexcept { return impl_->last; }

ConstNodeMap Simulation::positions() const noexcept { return impl_->map(impl_->engine.model().state.view.position); }
ConstNodeMap Simulation::velocities() const noexcept { return impl_->map(impl_->engine.model().state.view.velocity); }
ConstNodeMap Simulation::forces() const { return impl_->map(impl_->engine.model().with_forces().view.force); }
const std::vector<std::uint32_t>& Simulation::columns() const noexcept {
  return impl_->engine.model().layout.ordering().engine;
}

Vector3 Simulation::position(NodeIndex node) const {
  return column(impl_->engine.model().state.view.position, impl_->engine_node(node));
}
Vector3 Simulation::velocity(NodeIndex node) const {
  return column(impl_->engine.model().state.view.velocity, impl_->engine_node(node));
}
Vector3 Simulation::force(NodeIndex node) const {
  return column(impl_->engine.model().with_forces().view.force, impl_->engine_node(node));
}
Vector3 Simulation::reaction(NodeIndex node) const { return impl_->engine.reactions().node[impl_->engine_node(node)]; }
double Simulation::rigid_force(RigidIndex rigid) const {
  if (rigid >= impl_->engine.model().rigid.rods().size())
    throw Error(ErrorKind::input, fmt::format("rigid connection {} does not exist: the network has {}", rigid,
                                              impl_->engine.model().rigid.rods().size()));
  return impl_->engine.reactions().rigid[rigid];
}

std::size_t Simulation::surface_count() const noexcept { return impl_->engine.model().contact.obstacles().size(); }
const std::string& Simulation::surface_name(std::size_t surface) const {
  impl_->check_surface_index(surface);
  return impl_->engine.model().contact.obstacles()[surface].name();
}
Vector3 Simulation::surface_position(std::size_t surface) const {
  return impl_->pose(surface).from_start(impl_->surface(surface).origin());
}
Vector3 Simulation::surface_velocity(std::size_t surface) const {
  return impl_->pose(surface).velocity_at(surface_position(surface));
}
Eigen::Matrix3d Simulation::surface_rotation(std::size_t surface) const { return impl_->pose(surface).rotation; }
Vector3 Simulation::surface_spin(std::size_t surface) const { return impl_->pose(surface).spin; }
Vector3 Simulation::surface_force(std::size_t surface) const {
  Vector3 sum = Vector3::Zero();
  impl_->for_each_touching(surface, [&](std::uint32_t k) { sum -= impl_->engine.reaction_of(k, surface); });
  return sum;
}
Vector3 Simulation::surface_torque(std::size_t surface) const {
  const Vector3 about = surface_position(surface);
  Vector3 sum = Vector3::Zero();
  impl_->for_each_touching(surface, [&](std::uint32_t k) {
    const Vector3 arm = column(impl_->engine.model().state.view.position, k) - about;
    sum -= arm.cross(impl_->engine.reaction_of(k, surface));
  });
  return sum;
}
std::size_t Simulation::nodes_touching(std::size_t surface) const {
  std::size_t count = 0;
  impl_->for_each_touching(surface, [&](std::uint32_t) { ++count; });
  return count;
}
Vector3 Simulation::contact_impulse(NodeIndex node) const {
  return impl_->engine.model().contact.impulse(impl_->engine_node(node));
}
Vector3 Simulation::surface_impulse(std::size_t surface) const {
  impl_->check_surface_index(surface);
  return impl_->engine.model().contact.surface_impulse(surface);
}
std::vector<std::size_t> Simulation::surfaces_of(NodeIndex node) const {
  const Touch& touch = impl_->engine.model().contact.committed(impl_->engine_node(node));
  std::vector<std::size_t> surfaces;
  for (const std::int32_t surface : touch.surfaces())
    if (surface >= 0) surfaces.push_back(static_cast<std::size_t>(surface));
  return surfaces;
}
bool Simulation::held(NodeIndex node) const {
  return impl_->engine.model().contact.held()[impl_->engine_node(node)] != 0;
}
bool Simulation::touching(NodeIndex node) const {
  return impl_->engine.model().contact.touching()[impl_->engine_node(node)] != 0;
}

double Simulation::tension(SpringIndex spring) const {
  impl_->check_spring(spring);
  const Engine& engine = impl_->engine;
  return engine.model().layout.alive(spring)
             ? layers::spring_tension(engine.model().layout, engine.model().evaluator.instruction_set(),
                                      engine.model().time, engine.model().state.nodes(), spring)
             : 0.0;
}
std::vector<double> Simulation::internal_states(SpringIndex spring) const {
  impl_->check_spring(spring);
  const layers::Layout& layout = impl_->engine.model().layout;
  const std::uint32_t group = layout.laws().group[spring];
  return layout.internal().has(group) ? impl_->internal_states(group, layout.internal().of_spring(spring))
                                      : std::vector<double>{};
}
std::vector<double> Simulation::element_internal_states(ElementIndex element) const {
  impl_->check_element(element);
  const layers::Layout& layout = impl_->engine.model().layout;
  const std::uint32_t group = layout.elements().group(element);
  return layout.internal().has(group) ? impl_->internal_states(group, layout.internal().of_element(element))
                                      : std::vector<double>{};
}
void Simulation::tensions(std::vector<double>& out) const {
  const Engine& engine = impl_->engine;
  out.resize(spring_count());
  layers::spring_tensions(engine.model().layout, engine.model().evaluator.instruction_set(), engine.model().time,
                          engine.model().state.nodes(), out.data());
}
void Simulation::spring_energies(std::vector<double>& out) const {
  const Engine& engine = impl_->engine;
  out.resize(spring_count());
  layers::spring_energies(engine.model().layout, engine.model().evaluator.instruction_set(), engine.model().time,
                          engine.model().state.nodes(), out.data());
}
std::vector<InternalState> Simulation::internal_state_names(SpringIndex spring) const {
  impl_->check_spring(spring);
  const layers::CompiledLaws& laws = impl_->engine.model().layout.laws();
  return names_of_states(laws.groups[laws.group[spring]]);
}
std::vector<InternalState> Simulation::element_internal_state_names(ElementIndex element) const {
  impl_->check_element(element);
  const layers::Layout& layout = impl_->engine.model().layout;
  return names_of_states(layout.laws().groups[layout.elements().group(element)]);
}
void Simulation::dissipations(std::vector<double>& out) const {
  const Model& model = impl_->engine.model();
  layers::Losses losses;
  layers::evaluate_losses(model.layout, model.evaluator.instruction_set(), model.time, model.state.nodes(), losses);
  out.assign(spring_count(), 0.0);
  layers::add_spring_dissipations(model.layout, losses, out.data());
}
double Simulation::element_dissipation(ElementIndex element) const {
  if (!element_alive(element)) return 0.0;
  const Model& model = impl_->engine.model();
  return layers::element_dissipation(model.layout, model.evaluator.instruction_set(), model.time, model.state.nodes(),
                                     element);
}
bool Simulation::alive(SpringIndex spring) const {
  impl_->check_spring(spring);
  return impl_->engine.model().layout.alive(spring);
}

double Simulation::element_value(ElementIndex element) const {
  impl_->check_element(element);
  return layers::element_state(impl_->engine.model().layout, impl_->engine.model().state.nodes(), element).value;
}
double Simulation::element_force(ElementIndex element) const {
  if (!element_alive(element)) return 0.0;
  const Engine& engine = impl_->engine;
  return layers::element_force(engine.model().layout, engine.model().evaluator.instruction_set(), engine.model().time,
                               engine.model().state.nodes(), element);
}
bool Simulation::element_alive(ElementIndex element) const {
  impl_->check_element(element);
  return impl_->engine.model().layout.elements().alive(element);
}

double Simulation::kinetic_energy() const {
  const springnet_vectors& v = impl_->engine.model().state.view.velocity;
  double sum = 0.0;
  for (std::uint32_t k = 0; k < node_count(); ++k)
    sum += 0.5 * impl_->engine.model().mass[k] * column(v, k).squaredNorm();
  return sum;
}
double Simulation::potential_energy() const { return impl_->engine.potential_energy(); }
double Simulation::dissipated_power() const {
  const Model& model = impl_->engine.model();
  layers::Losses losses;
  layers::evaluate_losses(model.layout, model.evaluator.instruction_set(), model.time, model.state.nodes(), losses);
  return layers::known_dissipation(model.layout, losses);
}
double Simulation::dissipated_energy() const noexcept { return impl_->engine.dissipated_energy(); }
Vector3 Simulation::momentum() const {
  Vector3 sum = Vector3::Zero();
  for (std::uint32_t k = 0; k < node_count(); ++k)
    sum += impl_->engine.model().mass[k] * column(impl_->engine.model().state.view.velocity, k);
  return sum;
}
Vector3 Simulation::angular_momentum() const {
  const springnet_state& state = impl_->engine.model().state.view;
  Vector3 sum = Vector3::Zero();
  for (std::uint32_t k = 0; k < node_count(); ++k)
    sum += impl_->engine.model().mass[k] * column(state.position, k).cross(column(state.velocity, k));
  return sum;
}

const std::vector<Event>& Simulation::events() const noexcept { return impl_->engine.model().journal.events(); }
const std::map<std::string, double>& Simulation::statistics() const noexcept {
  return impl_->engine.model().journal.numbers();
}
const std::vector<std::string>& Simulation::notes() const noexcept { return impl_->engine.model().journal.notes(); }

std::vector<BodyTouch> Simulation::body_touches() const {
  const std::vector<Vector3>& forces = impl_->engine.pair_forces();
  const Model& model = impl_->engine.model();
  const BodyContacts& bodies = model.constraints.bodies();
  std::vector<BodyTouch> result;
  const proximity::Positions x = positions_of(read_only(model.state.view.position), model.node_count());
  for (std::size_t t = 0; t < forces.size(); ++t) {
    const PairTouch& touch = bodies.touching()[t];
    const proximity::Separation now = bodies.separation_of(touch, x);
    const std::array<NodeIndex, 4> nodes = bodies.primitives().nodes_of(touch.kind, touch.pair);
    BodyTouch& each = result.emplace_back();
    each.first = static_cast<std::uint8_t>(proximity::first_nodes(touch.kind));
    each.count = static_cast<std::uint8_t>(each.first + proximity::second_nodes(touch.kind));
    each.weights = now.weights;
    each.normal = now.direction;
    each.force = forces[t];
    for (std::size_t i = 0; i < each.count; ++i) {
      each.nodes[i] = model.user_number(nodes[i]);
      each.position += 0.5 * std::abs(now.weights[i]) * x[nodes[i]];
    }
  }
  return result;
}

}  // namespace springnet
