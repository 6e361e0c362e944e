#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <utility>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>
#include <springnet/profile.hpp>
#include <springnet/simulation.hpp>
#include <springnet/suggestion.hpp>

#include "layers/dissipation.hpp"
#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"
#include "network/checks.hpp"
#include "network/spacing.hpp"
#include "plugin_host/call.hpp"
#include "profile/stage.hpp"
#include "simulation/embedding_changes.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"
#include "simulation/local_force.hpp"
#include "simulation/max_threads.hpp"

namespace springnet {

std::string_view name_of(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::settled:
      return "settled";
    case Outcome::oscillating:
      return "oscillating";
    case Outcome::out_of_sweeps:
      return "out of sweeps";
    case Outcome::diverging:
      return "diverging";
    case Outcome::out_of_time:
      return "out of time";
  }
  return "unknown";
}

struct Simulation::Impl {
  Impl(const Network& network, std::shared_ptr<const PluginHost> plugin_host, const SimulationOptions& given)
      : plugins(std::move(plugin_host)),
        options(given),
        component(plugins->require(ComponentKind::integrator, given.integrator.id)),
        engine(network, *plugins, given),
        host(make_host_table(engine)) {
    create_integrator();
  }
  ~Impl() { destroy_integrator(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // How a call of the integrator ended. `broken`: it violated plugin.h.
  struct Ending {
    springnet_status status = SPRINGNET_FAILED;
    bool broken = false;
    std::string text;  // why, unless the status is OK
    // Only the text of an exception crosses the C ABI.
    [[nodiscard]] bool out_of_memory() const {
      return status != SPRINGNET_OK && (text == std::bad_alloc().what() || text == "out of memory");
    }
  };
  template <class Function>
  Ending call(const Function& function);
  [[nodiscard]] std::string broken_by(std::string_view what) const {
    return fmt::format("{}: {}", full_name_with_file(*component), what);
  }
  void create_integrator();
  void destroy_integrator() noexcept;
  void drop_history();
  void advance(double until);
  [[nodiscard]] std::uint32_t engine_node(NodeIndex node) const {
    if (node >= engine.model().layout.node_count())
      throw Error(ErrorKind::input, fmt::format("node {} does not exist: the network has nodes 0 to {}", node,
                                                std::int64_t{engine.model().layout.node_count()} - 1));
    return engine.model().layout.ordering().engine[node];
  }
  const layers::CompiledLaws::SignalInput& input(InputIndex number) const {
    const auto& inputs = engine.model().layout.laws().inputs;
    if (number >= inputs.size())
      throw Error(ErrorKind::input,
                  fmt::format("input signal {} does not exist: the network has {}", number, inputs.size()));
    return inputs[number];
  }
  void check_spring(SpringIndex spring) const {
    if (spring >= engine.model().layout.spring_count())
      throw Error(ErrorKind::input, fmt::format("spring {} does not exist: the network has springs 0 to {}", spring,
                                                static_cast<std::int64_t>(engine.model().layout.spring_count()) - 1));
  }
  // Of the element of a group at this place.
  [[nodiscard]] std::vector<double> internal_states(std::size_t group, std::uint32_t place) const {
    const layers::Layout& layout = engine.model().layout;
    const layers::InternalLayout::OfGroup& own = layout.internal().group(group);
    std::vector<double> states;
    for (std::size_t j = 0; j < layout.laws().groups[group].state_count(); ++j)
      states.push_back(engine.model().state.view.internal[own.first + j * own.count + place]);
    return states;
  }
  void check_element(ElementIndex element) const {
    if (element >= engine.model().layout.elements().count())
      throw Error(ErrorKind::input, fmt::format("element {} does not exist: the network has {} elements", element,
                                                engine.model().layout.elements().count()));
  }
  void check_surface_index(std::size_t surface) const {
    if (surface >= engine.model().contact.obstacles().size())
      throw Error(ErrorKind::input, fmt::format("surface {} does not exist: the network has {} planes and instruments",
                                                surface, engine.model().contact.obstacles().size()));
  }
  void check_arrival(const Vector3& position, double until) const {
    if (!position.allFinite() || !std::isfinite(until) || !(until > engine.model().time))
      throw Error(ErrorKind::input,
                  fmt::format("a motion to ({}, {}, {}) that ends at {}: the position must be finite, and the time "
                              "after {}, which is now",
                              position[0], position[1], position[2], checks::seconds(until),
                              checks::seconds(engine.model().time)));
  }
  // Of a local force model, s.
  [[nodiscard]] double local_time(double over) const {
    constexpr double longest = 1e100;  // s
    if (!(over >= 0.0 && over <= longest))
      throw Error(ErrorKind::input, fmt::format("local force model: over must be 0 (the time step) to 1e100 s, is {}",
                                                checks::seconds(over)));
    return over > 0.0 ? over : options.time_step;
  }
  [[nodiscard]] const Obstacle& surface(std::size_t index) const {
    check_surface_index(index);
    return engine.model().contact.obstacles()[index];
  }
  // At the present time.
  [[nodiscard]] Pose pose(std::size_t index) const { return surface(index).at(engine.model().now()); }
  template <class Visit>
  void for_each_touching(std::size_t index, Visit visit) const {
    check_surface_index(index);
    for (std::uint32_t k = 0; k < engine.model().layout.node_count(); ++k)
      if (engine.model().contact.committed(k).has(static_cast<std::int32_t>(index))) visit(k);
  }
  [[nodiscard]] ConstNodeMap map(const springnet_vectors& v) const {
    const std::uint32_t n = engine.model().layout.node_count();
    return {v.x, 3, static_cast<Eigen::Index>(n), Eigen::OuterStride<>(static_cast<Eigen::Index>(pitch_of(n)))};
  }

  std::shared_ptr<const PluginHost> plugins;
  SimulationOptions options;
  std::shared_ptr<const Component> component;
  mutable Engine engine;  // evaluates forces on demand
  springnet_host host;
  void* integrator = nullptr;
  StepReport last;
  std::uint64_t steps = 0, sweeps = 0;
  // The next step ends at grid_start + (grid_steps + 1) time_step, so that rounding does not add up.
  double grid_start = 0.0;
  std::uint64_t grid_steps = 0;
};

namespace {

void check_finite(const Vector3& value, std::string_view what) {
  if (!value.allFinite())
    throw Error(ErrorKind::input, fmt::format("{}: ({}, {}, {}) is not finite", what, value[0], value[1], value[2]));
}

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

template <class Function>
Simulation::Impl::Ending Simulation::Impl::call(const Function& function) {
  engine.model().journal.message.text[0] = '\0';
  Ending end;
  try {
    end.status = function();
    if (end.status == SPRINGNET_OK) return end;
    end.text = text_of(engine.model().journal.message);
    end.broken = end.text.empty() ||
                 (!engine.calls().misuse().empty() && end.text.find(engine.calls().misuse()) != std::string::npos);
    if (end.broken) end.text = broken_by(end.text.empty() ? "it failed without saying why" : end.text);
  } catch (const std::exception& error) {
    end.broken = true;
    end.text =
        broken_by(fmt::format("it threw an exception, which plugin.h forbids: {}", printable_message(error.what())));
  } catch (...) {
    end.broken = true;
    end.text = broken_by("it threw something that is not a std::exception");
  }
  return end;
}

void Simulation::Impl::create_integrator() {
  const std::vector<double> values = complete_parameters(*component->description, options.integrator.parameters,
                                                         fmt::format("integrator '{}'", options.integrator.id));
  if (engine.model().layout.internal().any() &&
      (component->description->capabilities & SPRINGNET_INTEGRATES_STATES) == 0)
    throw Error(ErrorKind::input,
                fmt::format("integrator '{}' does not integrate the internal state of laws, which laws of this network "
                            "have; use another one, such as recurrent, cvode or verlet",
                            options.integrator.id));
  springnet_integrator_creation creation{sizeof creation, static_cast<std::uint32_t>(values.size()), &host,
                                         values.data(), nullptr};
  const springnet_integrator& functions = component->integrator();
  const Ending end = call([&] { return functions.create(functions.context, &creation); });
  integrator = creation.integrator;
  if (end.status == SPRINGNET_OK) return;
  if (end.broken) throw Error(ErrorKind::plugin, end.text);
  if (end.out_of_memory()) throw std::bad_alloc();
  throw Error(ErrorKind::input, fmt::format("integrator '{}': {}", options.integrator.id, end.text));
}

void Simulation::Impl::destroy_integrator() noexcept {
  if (integrator == nullptr) return;
  try {
    static_cast<void>(component->integrator().destroy(integrator));
  } catch (...) {  // plugin.h forbids it, and a destructor cannot report it
  }
  integrator = nullptr;
}

void Simulation::Impl::drop_history() {
  engine.forget();
  engine.calls().begin_advance(engine.model().time);  // nothing later may be committed
  const springnet_integrator& functions = component->integrator();
  if (functions.forget != nullptr) {
    const Ending end = call([&] { return functions.forget(integrator); });
    if (end.status == SPRINGNET_OK) return;
    throw Error(ErrorKind::plugin, end.broken ? end.text : broken_by(end.text));
  }
  // One that may keep something all the same, as it is older than the call.
  void* before = std::exchange(integrator, nullptr);
  try {
    create_integrator();
  } catch (...) {
    integrator = before;
    throw;
  }
  std::swap(integrator, before);
  destroy_integrator();
  integrator = before;
}

void Simulation::Impl::advance(double until) {
  const Profiler::Scope step(options.profiler.get(), "step");
  const double from = engine.model().time;
  springnet_step_report report{};
  report.struct_size = sizeof report;
  report.start_node = 0xffffffffu;
  report.position_error = std::numeric_limits<double>::quiet_NaN();
  engine.calls().begin_advance(until);
  Ending end = call([&] {
    const profile::Stage stage(component->description->id, profile::Kind::integrator);
    const springnet_advance request{sizeof request, 0, until, &report};
    return component->integrator().advance(integrator, &request);
  });
  if (end.status == SPRINGNET_OK && !(std::abs(engine.model().time - until) <= engine.calls().end_tolerance())) {
    end.status = SPRINGNET_FAILED;
    end.broken = true;
    end.text = broken_by(fmt::format(
        "it committed {}",
        engine.model().time > from ? fmt::format("no later state than that at {} s", engine.model().time) : "nothing"));
    for (const std::string& reason : {engine.calls().misuse(), engine.model().journal.non_finite})
      if (!reason.empty()) end.text += "; " + reason;
  }
  const springnet_status status = end.status;
  const std::vector<std::uint32_t>& user = engine.model().layout.ordering().user;
  // A failed step is not settled, whatever the integrator reports; running out of memory says nothing about the motion.
  const bool known = report.outcome >= SPRINGNET_SETTLED && report.outcome <= SPRINGNET_OUT_OF_TIME;
  Outcome outcome = known ? static_cast<Outcome>(report.outcome) : Outcome::diverging;
  const bool fine = outcome == Outcome::settled || outcome == Outcome::out_of_time;
  if (status != SPRINGNET_OK && fine) outcome = Outcome::diverging;
  if (end.out_of_memory()) outcome = Outcome::settled;
  if (outcome != Outcome::settled) last.outcome = outcome;
  last.sweeps += report.sweeps;
  last.force_difference = report.force_difference;
  last.residual = report.residual;
  last.node = report.node < user.size() ? user[report.node] : 0;
  last.start_node = report.start_node < user.size() ? std::int64_t{user[report.start_node]} : -1;
  last.substeps += report.substeps;
  last.stages += report.stages;
  last.position_error = report.position_error;
  sweeps += report.sweeps;
  if (status == SPRINGNET_OK) {
    last.steps += report.steps;
    steps += report.steps;
    return;
  }
  std::string text =
      fmt::format("step from {} to {}: {}", checks::seconds(from), checks::seconds(until),
                  end.out_of_memory() ? "out of memory: simulate a smaller network, or on a larger machine" : end.text);
  if (!engine.model().journal.non_finite.empty() && text.find(engine.model().journal.non_finite) == std::string::npos)
    text += fmt::format("; {}", engine.model().journal.non_finite);
  throw Error(end.broken ? ErrorKind::plugin : ErrorKind::simulation, text);
}

Simulation::Simulation(const Network& network, std::shared_ptr<const PluginHost> plugins,
                       const SimulationOptions& options) {
  if (!plugins) throw Error(ErrorKind::input, "a simulation needs a plugin host");
  if (!(options.time_step > 0.0) || !std::isfinite(options.time_step))
    throw Error(ErrorKind::input,
                fmt::format("time step: must be a finite number above 0 s, is {}", checks::seconds(options.time_step)));
  if (options.threads > max_threads)
    throw Error(ErrorKind::input, fmt::format("threads: must be 0 to {}, is {}; 0 takes as many as are useful",
                                              max_threads, options.threads));
  if (network.nodes().empty())
    throw Error(ErrorKind::input, "the network has no nodes; add a body or single nodes before simulating it");
  check_spacing(network);
  impl_ = std::make_unique<Impl>(network, std::move(plugins), options);
}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

const StepReport& Simulation::step() {
  impl_->last = {};
  const double until = impl_->grid_start + static_cast<double>(impl_->grid_steps + 1) * impl_->options.time_step;
  impl_->advance(until);
  ++impl_->grid_steps;
  return impl_->last;
}

const StepReport& Simulation::step_within(double seconds) {
  if (!(seconds >= 0.0))
    throw Error(ErrorKind::input, fmt::format("time for a step: must be 0 s or more, is {}", checks::seconds(seconds)));
  struct Guard {
    Deadline& deadline;
    ~Guard() { deadline.clear(); }
  } const guard{impl_->engine.model().deadline};
  guard.deadline.set(seconds);
  return step();
}

const StepReport& Simulation::advance_to(double until) {
  Impl& impl = *impl_;
  if (!(until >= time()) || !std::isfinite(until))
    throw Error(ErrorKind::input,
                fmt::format("cannot advance from {} to {}", checks::seconds(time()), checks::seconds(until)));
  impl.last = {};
  const double step = impl.options.time_step;
  // A smaller remainder is rounding of times, not a step. Compared with `until` too, because the time step may be
  // longer than the whole simulation.
  const double slack = 1e-6 * std::min(step, until);
  while (true) {
    const double next = impl.grid_start + static_cast<double>(impl.grid_steps + 1) * step;
    if (until - next < -slack) break;
    const bool ends_here = std::abs(until - next) <= slack;
    impl.advance(ends_here ? until : next);
    ++impl.grid_steps;
    if (ends_here) return impl.last;
  }
  if (until - time() > slack) {
    impl.advance(until);
    impl.grid_start = until;
    impl.grid_steps = 0;
  }
  return impl.last;
}

void Simulation::drop_history() { impl_->drop_history(); }

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

void Simulation::set_force(NodeIndex node, const Vector3& force) {
  check_finite(force, fmt::format("force on node {}", node));
  impl_->engine.model().loads.set_host_force(impl_->engine_node(node), force);
  impl_->engine.model().changed();
}
void Simulation::set_gravity(const Vector3& acceleration) {
  check_finite(acceleration, "gravity");
  impl_->engine.model().loads.set_gravity(acceleration);
  impl_->engine.model().changed();
}
void Simulation::set_input(InputIndex input, double value) {
  Model& model = impl_->engine.model();
  layers::check_input_value(impl_->input(input).readers, value, fmt::format("value of input signal {}:", input));
  model.layout.signals().hold(input, value);
  model.changed();
}
void Simulation::set_input(std::string_view name, double value) {
  const auto& inputs = impl_->engine.model().layout.laws().inputs;
  for (InputIndex k = 0; k < inputs.size(); ++k)
    if (!name.empty() && inputs[k].name == name) return set_input(k, value);
  std::vector<std::string> known;
  for (const auto& input : inputs)
    if (!input.name.empty()) known.push_back(input.name);
  const std::string nearest = suggestion(name, known);
  throw Error(ErrorKind::input,
              fmt::format("there is no input signal '{}'; {}", printable(std::string(name)),
                          known.empty()     ? std::string("none has a name: give it one, or use its number")
                          : nearest.empty() ? fmt::format("{} have other names, as '{}'", known.size(), known.front())
                                            : nearest));
}
double Simulation::input_value(InputIndex input) const {
  static_cast<void>(impl_->input(input));
  return impl_->engine.model().layout.signals().at(input, time());
}
void Simulation::set_position(NodeIndex node, const Vector3& position) {
  check_finite(position, fmt::format("position of node {}", node));
  const std::uint32_t k = impl_->engine_node(node);
  const Contact& contact = impl_->engine.model().contact;
  for (std::size_t j = 0; j < contact.obstacles().size() && contact.fixed()[k] == 0; ++j) {
    const double distance = contact.obstacles()[j].gap(impl_->pose(j), position);
    if (distance < 0.0)
      throw Error(ErrorKind::input,
                  fmt::format("position of node {}: it is {:.3g} m {} {}; move it outside, or fix the node first", node,
                              -distance, contact.obstacles()[j].is_plane() ? "behind" : "inside", contact.name_of(j)));
  }
  springnet::set_node(impl_->engine.model(), k, position, std::nullopt);
}
void Simulation::set_velocity(NodeIndex node, const Vector3& velocity) {
  check_finite(velocity, fmt::format("velocity of node {}", node));
  const std::uint32_t k = impl_->engine_node(node);
  if (impl_->engine.model().contact.fixed()[k] != 0)
    throw Error(ErrorKind::input,
                fmt::format("node {} is fixed and has no velocity; set_fixed(node, false) first", node));
  springnet::set_node(impl_->engine.model(), k, std::nullopt, velocity);
}
void Simulation::set_fixed(NodeIndex node, bool fixed) {
  springnet::set_fixed(impl_->engine.model(), impl_->engine_node(node), fixed);
}
void Simulation::move_surface(std::size_t surface, const Vector3& position, double time) {
  impl_->check_surface_index(surface);
  impl_->check_arrival(position, time);
  springnet::move_surface(impl_->engine.model(), surface, position, time);
}
void Simulation::move_node(NodeIndex node, const Vector3& position, double time) {
  impl_->check_arrival(position, time);
  springnet::move_node(impl_->engine.model(), impl_->engine_node(node), position, time);
}
LocalForce Simulation::local_force(NodeIndex node, double over) {
  const std::uint32_t k = impl_->engine_node(node);
  if (impl_->engine.model().contact.fixed()[k] == 0)
    throw Error(ErrorKind::input, fmt::format("node {} is free: nothing holds it; set_fixed or move_node first", node));
  const double step = impl_->local_time(over);
  return {time(), position(node), -reaction(node), impl_->engine.local_force().stiffness_of_node(k, step)};
}
LocalForce Simulation::local_surface_force(std::size_t surface, double over) {
  impl_->check_surface_index(surface);
  const double step = impl_->local_time(over);
  return {time(), surface_position(surface), surface_force(surface),
          impl_->engine.local_force().stiffness_of_surface(surface, step)};
}
std::size_t Simulation::cut(const std::vector<SpringIndex>& springs) {
  for (const SpringIndex s : springs) impl_->check_spring(s);
  return impl_->engine.topology().cut(springs);
}
std::size_t Simulation::cut_polygon(const std::vector<Vector3>& corners) {
  return impl_->engine.topology().cut(CuttingPolygon(corners));
}

const std::vector<Event>& Simulation::events() const noexcept { return impl_->engine.model().journal.events(); }
const std::map<std::string, double>& Simulation::statistics() const noexcept {
  return impl_->engine.model().journal.numbers();
}
const std::vector<std::string>& Simulation::notes() const noexcept { return impl_->engine.model().journal.notes(); }

}  // namespace springnet
