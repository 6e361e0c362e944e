// Steps of a simulation, and the calls of its integrator.
#include <springnet/simulation.hpp>

#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>
#include <springnet/profile.hpp>

#include "network/checks.hpp"
#include "network/spacing.hpp"
#include "plugin_host/call.hpp"
#include "profile/stage.hpp"
#include "simulation/implementation.hpp"
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

void Simulation::Impl::require_abilities() const {
  const std::uint64_t abilities = component->description->capabilities;
  const auto refuse = [&](const char* what) {
    throw Error(ErrorKind::input, fmt::format("integrator '{}' does not handle {}, which this network has; use another "
                                              "one, such as recurrent, verlet or generalized_alpha",
                                              options.integrator.id, what));
  };
  if ((abilities & SPRINGNET_WITHOUT_CONTACT) != 0 && !engine.model().contact.obstacles().empty())
    refuse("contact with planes and instruments");
  if ((abilities & SPRINGNET_KEEPS_BODIES_APART) == 0 && engine.model().constraints.bodies().any())
    throw Error(
        ErrorKind::input,
        fmt::format("integrator '{}' does not handle contact of bodies with each other, which this network has; "
                    "use recurrent, verlet or cvode, or leave out [[contact]]",
                    options.integrator.id));
  if ((abilities & SPRINGNET_KEEPS_RIGID_BODIES_APART) == 0 && engine.model().constraints.bodies().any_rigid())
    throw Error(
        ErrorKind::input,
        fmt::format(
            "integrator '{}' does not handle contact of bodies whose nodes have rigid connections, which "
            "this network has; use recurrent, verlet or cvode, leave such nodes out of [[contact]], or make stiff "
            "springs of the connections",
            options.integrator.id));
  if ((abilities & SPRINGNET_WITHOUT_RIGID) != 0 && engine.model().rigid.any()) refuse("rigid connections");
}

template <class Function>
Simulation::Impl::Ending Simulation::Impl::call(const Function& function) {
  engine.model().journal.message.text[0] = '\0';
  Ending end;
  struct Guard {
    bool& in_step;
    ~Guard() { in_step = false; }
  } const guard{in_step};
  in_step = true;
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
  require_abilities();
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

void Simulation::Impl::exchange(const LawUse& next) {
  const std::shared_ptr<const Component> other = plugins->require(ComponentKind::integrator, next.id);
  engine.forget();
  engine.calls().begin_advance(engine.model().time);
  const std::shared_ptr<const Component> old_component = std::exchange(component, other);
  const LawUse old_use = std::exchange(options.integrator, next);
  void* const old_integrator = std::exchange(integrator, nullptr);
  const auto swap_back = [&] {
    component = old_component;
    options.integrator = old_use;
    integrator = old_integrator;
  };
  try {
    create_integrator();
  } catch (...) {
    destroy_integrator();
    swap_back();
    throw;
  }
  void* const new_integrator = integrator;
  swap_back();
  destroy_integrator();
  component = other;
  options.integrator = next;
  integrator = new_integrator;
  Model& model = engine.model();
  model.step_length = 0.0;
  state_is_of_step = false;
  model.changed();
}

void Simulation::Impl::exchange_due() {
  const Model& model = engine.model();
  const double slack = 1e-9 * std::min(model.time_step, model.time);
  while (engine.changes().next_exchange() <= model.time + slack) {
    const LawUse next = engine.changes().take_exchange();
    exchange(next);
    engine.model().journal.note(fmt::format("From {:g} s on the integrator is '{}'.", model.time, next.id));
  }
}

// The integrator is exchanged between two calls of it.
void Simulation::Impl::advance(double until) {
  const double slack = 1e-9 * std::min(options.time_step, until);
  for (double next = engine.changes().next_exchange(); next < until - slack; next = engine.changes().next_exchange()) {
    advance_part(next);
    exchange_due();
  }
  advance_part(until);
  exchange_due();
}

void Simulation::Impl::advance_part(double until) {
  const Profiler::Scope step(options.profiler.get(), "step");
  const double from = engine.model().time;
  springnet_step_report report{};
  report.struct_size = sizeof report;
  report.start_node = 0xffffffffu;
  report.position_error = std::numeric_limits<double>::quiet_NaN();
  engine.calls().begin_advance(until);
  state_is_of_step = true;
  const struct Asked {
    Deadline& deadline;
    ~Asked() { deadline.forget_asking(); }
  } asked{engine.model().deadline};
  Ending end = call([&] {
    const profile::Stage stage(component->description->id, profile::Kind::integrator);
    const springnet_advance request{sizeof request, 0, until, &report};
    const Calling calling(*component);
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

namespace {

// Begins the bytes: whose memory they are.
std::string heading_of(const Component& component) {
  return fmt::format("{}@{} {}\n", component.description->id, component.plugin->id, component.plugin->version);
}

}  // namespace

std::string Simulation::Impl::integrator_memory() {
  const springnet_integrator& functions = component->integrator();
  if (!SPRINGNET_HAS_FIELD(springnet_integrator, &functions, save) || functions.save == nullptr) return {};
  std::string memory = heading_of(*component);
  springnet_byte_sink sink{sizeof sink, 0, &memory, [](void* context, const void* bytes, std::uint64_t count) {
                             try {
                               static_cast<std::string*>(context)->append(static_cast<const char*>(bytes), count);
                               return springnet_status{SPRINGNET_OK};
                             } catch (const std::exception&) {
                               return springnet_status{SPRINGNET_FAILED};
                             }
                           }};
  const Ending end = call([&] { return functions.save(integrator, &sink); });
  if (end.status != SPRINGNET_OK) throw Error(ErrorKind::plugin, end.broken ? end.text : broken_by(end.text));
  return memory;
}

void Simulation::Impl::set_integrator_memory(std::string_view memory) {
  drop_history();
  const springnet_integrator& functions = component->integrator();
  const std::string heading = heading_of(*component);
  if (!SPRINGNET_HAS_FIELD(springnet_integrator, &functions, restore) || functions.restore == nullptr)
    throw Error(ErrorKind::input, fmt::format("integrator '{}' takes up no memory", options.integrator.id));
  if (!memory.starts_with(heading))
    throw Error(ErrorKind::input,
                fmt::format("the memory is not of integrator {}", heading.substr(0, heading.size() - 1)));
  memory.remove_prefix(heading.size());
  const springnet_bytes bytes{sizeof bytes, 0, memory.data(), memory.size()};
  const Ending end = call([&] { return functions.restore(integrator, &bytes); });
  if (end.status == SPRINGNET_OK) return;
  drop_history();
  if (end.broken) throw Error(ErrorKind::plugin, end.text);
  throw Error(ErrorKind::input, fmt::format("integrator '{}': {}", options.integrator.id, end.text));
}

std::optional<Simulation::Between> Simulation::Impl::between(double time) {
  const springnet_integrator& functions = component->integrator();
  if (!SPRINGNET_HAS_FIELD(springnet_integrator, &functions, interpolate) || functions.interpolate == nullptr)
    return {};
  const auto n = static_cast<Eigen::Index>(engine.model().node_count());
  Eigen::Matrix<double, Eigen::Dynamic, 3> p(n, 3), v(n, 3);
  springnet_dense_output output{};
  output.struct_size = sizeof output;
  output.time = time;
  output.position = {p.col(0).data(), p.col(1).data(), p.col(2).data()};
  output.velocity = {v.col(0).data(), v.col(1).data(), v.col(2).data()};
  const Ending end = call([&] { return functions.interpolate(integrator, &output); });
  if (end.broken) throw Error(ErrorKind::plugin, end.text);
  if (end.status != SPRINGNET_OK) return {};
  // The present state has the host's changes since, and velocities as they are from now on.
  const springnet_state& now = engine.model().state.view;
  if (time == engine.model().time) return Between{map(now.position), map(now.velocity)};
  if (!state_is_of_step) return {};
  return Between{p.transpose(), v.transpose()};
}

Simulation::Simulation(const Network& network, std::shared_ptr<const PluginHost> plugins,
                       const SimulationOptions& options)
    : Simulation(std::make_shared<const Network>(network), std::move(plugins), options) {}

Simulation::Simulation(std::shared_ptr<const Network> network, std::shared_ptr<const PluginHost> plugins,
                       const SimulationOptions& options) {
  if (!network) throw Error(ErrorKind::input, "a simulation needs a network");
  if (!plugins) throw Error(ErrorKind::input, "a simulation needs a plugin host");
  if (!(options.time_step > 0.0) || !std::isfinite(options.time_step))
    throw Error(ErrorKind::input,
                fmt::format("time step: must be a finite number above 0 s, is {}", checks::seconds(options.time_step)));
  if (options.threads > max_threads)
    throw Error(ErrorKind::input, fmt::format("threads: must be 0 to {}, is {}; 0 takes as many as are useful",
                                              max_threads, options.threads));
  if (network->nodes().empty())
    throw Error(ErrorKind::input, "the network has no nodes; add a body or single nodes before simulating it");
  check_spacing(*network);
  impl_ = std::make_unique<Impl>(std::move(network), std::move(plugins), options);
  others_ = std::make_unique<const OtherThreads>(*impl_);
}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

const StepReport& Simulation::step() {
  impl_->between_steps().last = {};
  const double until = impl_->grid_start + static_cast<double>(impl_->grid_steps + 1) * impl_->options.time_step;
  impl_->make_step(until, [this] { ++impl_->grid_steps; });
  return impl_->last;
}

const StepReport& Simulation::step_within(double seconds) {
  if (!(seconds >= 0.0))
    throw Error(ErrorKind::input, fmt::format("time for a step: must be 0 s or more, is {}", checks::seconds(seconds)));
  struct Guard {
    Deadline& deadline;
    ~Guard() { deadline.clear(); }
  } const guard{impl_->between_steps().engine.model().deadline};
  guard.deadline.set(seconds);
  return step();
}

void Simulation::Impl::advance_to(double until, const std::function<bool()>* go_on) {
  between_steps();
  const double from = engine.model().time;
  if (!(until >= from) || !std::isfinite(until))
    throw Error(ErrorKind::input,
                fmt::format("cannot advance from {} to {}", checks::seconds(from), checks::seconds(until)));
  last = {};
  const double step = options.time_step;
  // A smaller remainder is rounding of times, not a step. Compared with `until` too, because the time step may be
  // longer than the whole simulation.
  const double slack = 1e-6 * std::min(step, until);
  while (true) {
    const double next = grid_start + static_cast<double>(grid_steps + 1) * step;
    if (until - next < -slack) break;
    const bool ends_here = std::abs(until - next) <= slack;
    make_step(ends_here ? until : next, [this] { ++grid_steps; });
    const bool goes_on = go_on == nullptr || (*go_on)();
    if (ends_here || !goes_on) return;
  }
  if (!(until - engine.model().time > slack)) return;
  make_step(until, [&] {
    grid_start = until;
    grid_steps = 0;
  });
  if (go_on != nullptr) static_cast<void>((*go_on)());
}

const StepReport& Simulation::advance_to(double until) {
  impl_->advance_to(until, nullptr);
  return impl_->last;
}

const StepReport& Simulation::advance_to(double until, const std::function<bool()>& go_on) {
  if (!go_on) throw Error(ErrorKind::input, "advance_to: a function go_on is needed; without one, give the time alone");
  impl_->advance_to(until, &go_on);
  return impl_->last;
}

void Simulation::drop_history() { impl_->between_steps().drop_history(); }
std::string Simulation::integrator_memory() { return impl_->between_steps().integrator_memory(); }
void Simulation::set_integrator_memory(std::string_view memory) {
  impl_->between_steps().set_integrator_memory(memory);
}
std::optional<Simulation::Between> Simulation::between(double time) { return impl_->outside_of_steps().between(time); }
void Simulation::ask_to_stop() noexcept { Deadline::ask(*others_->asked); }

}  // namespace springnet
