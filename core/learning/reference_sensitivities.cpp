#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/sensitivities.hpp>

#include "learning/learned_values.hpp"
#include "learning/result.hpp"
#include "learning/variables.hpp"
#include "plugin_host/call.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"

namespace springnet {
namespace {

using Eigen::Matrix3Xd;
using Eigen::VectorXd;

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorKind::input, "sensitivities: " + what); }

std::shared_ptr<const Component> integrator_of(const PluginHost& plugins, const LawUse& use) {
  std::shared_ptr<const Component> found = plugins.require(ComponentKind::integrator, use.id);
  const springnet_integrator& functions = found->integrator();
  if (!SPRINGNET_HAS_FIELD(springnet_integrator, &functions, sensitivity) || functions.begin_sensitivities == nullptr ||
      functions.sensitivity == nullptr)
    refuse(fmt::format("integrator '{}' has none; use cvode", use.id));
  return found;
}

void check(const Network& network) {
  if (!network.contacts().empty()) refuse("contact of bodies with each other ([[contact]]) is not differentiated");
  if (!network.cuts().empty()) refuse("a net with cuts is not differentiated");
  if (!network.changes().empty()) refuse("a net that changes while it runs ([[change]]) is not differentiated");
}

}  // namespace

struct ReferenceSensitivities::Impl {
  // A column as the integrator is given it; what it points to stays while the integrator exists.
  struct Direction {
    std::vector<std::vector<double>> values;
    std::vector<springnet_parameter_set> sets;
    std::vector<const springnet_parameter_set*> pointers;
    VectorXd velocity;  // the engine's order, x of all nodes first
    springnet_sensitivity request{};
  };

  Impl(const std::shared_ptr<const Network>& net, const std::shared_ptr<const PluginHost>& host,
       const SimulationOptions& options, const std::vector<Learnable>& of)
      : component(integrator_of(*host, options.integrator)),
        learned(*net, learning::values_of(of)),
        engine(*net, *host, options),
        table(make_host_table(engine)) {
    check(*net);
    for (const Learnable& each : of) {
      if (each.values.kind == LearnedValues::Kind::load || each.values.kind == LearnedValues::Kind::gravity ||
          each.values.kind == LearnedValues::Kind::friction)
        refuse("a motion is not differentiated by its loads, gravity and friction");
      if (each.field_degree >= 0) refuse("a field has no column; take its values each by itself, or together");
    }
    learned.attach(engine);
    make_columns(*net, *host, of);
    make_integrator(options.integrator);
  }
  ~Impl() {
    if (integrator == nullptr) return;
    try {
      static_cast<void>(component->integrator().destroy(integrator));
    } catch (...) {  // plugin.h forbids it, and a destructor cannot report it
    }
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  [[nodiscard]] std::size_t nodes() const { return engine.model().node_count(); }
  void make_columns(const Network& net, const PluginHost& plugins, const std::vector<Learnable>& of);
  void make_integrator(const LawUse& use);
  template <class Function>
  void call(ErrorKind kind, const Function& function) const;
  void advance_to(double until);
  void check_events() const;
  [[nodiscard]] Matrix3Xd in_user_order(const springnet_const_vectors& values) const;
  [[nodiscard]] Matrix3Xd change(std::size_t column, bool of_velocities) const;

  std::shared_ptr<const Component> component;
  learning::LearnedSets learned;
  mutable Engine engine;
  springnet_host table;
  std::vector<SensitivityColumn> columns;
  std::vector<Direction> directions;
  void* integrator = nullptr;
};

// Calls the integrator; a failure is an error of this kind, with the reason that it gave.
template <class Function>
void ReferenceSensitivities::Impl::call(ErrorKind kind, const Function& function) const {
  springnet_message& reason = engine.model().journal.message;
  reason.text[0] = '\0';
  springnet_message message{};
  const springnet_status status = call_component(*component, message, [&](springnet_message& own) {
    const springnet_status result = function(component->integrator());
    if (result != SPRINGNET_OK) own = reason;
    return result;
  });
  if (status != SPRINGNET_OK) throw Error(kind, "sensitivities: " + text_of(message));
}

void ReferenceSensitivities::Impl::make_columns(const Network& net, const PluginHost& plugins,
                                                const std::vector<Learnable>& of) {
  const VectorXd values = learned.values_of(engine);
  const learning::Variables variables(net, plugins, of, values);
  const std::vector<LearnedParameter> names = learning::list_parameters(of);
  const VectorXd& start = variables.start();
  const auto count = static_cast<std::size_t>(variables.count());
  columns.resize(count);
  directions.resize(count);
  std::vector<std::size_t> first(count, names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::size_t j = variables.variable_of(i);
    if (first[j] < names.size()) {
      ++columns[j].values;
      continue;
    }
    first[j] = i;
    columns[j] = {name_of(names[i]), names[i].member, 1, values[static_cast<Eigen::Index>(i)]};
  }
  for (std::size_t j = 0; j < count; ++j) {
    // By the first value itself, whatever a search would drive it by.
    const VectorXd unit = VectorXd::Unit(variables.count(), static_cast<Eigen::Index>(j));
    const VectorXd change = variables.times(start, unit) / variables.slope(first[j], start);
    Direction& own = directions[j];
    own.sets = learned.sets_along(change, own.values);
    for (const springnet_parameter_set& set : own.sets) own.pointers.push_back(&set);
    own.velocity.setZero(static_cast<Eigen::Index>(3 * nodes()));
    learned.start_velocity(change, own.velocity);
    own.request = {sizeof own.request,  static_cast<std::uint32_t>(own.pointers.size()),
                   own.pointers.data(), nullptr,
                   own.velocity.data(), columns[j].value != 0.0 ? std::abs(columns[j].value) : 1.0};
  }
}

void ReferenceSensitivities::Impl::make_integrator(const LawUse& use) {
  const std::vector<double> options =
      complete_parameters(*component->description, use.parameters, fmt::format("integrator '{}'", use.id));
  springnet_integrator_creation creation{sizeof creation, static_cast<std::uint32_t>(options.size()), &table,
                                         options.data(), nullptr};
  std::vector<const springnet_sensitivity*> pointers;
  for (const Direction& each : directions) pointers.push_back(&each.request);
  const springnet_sensitivities request{sizeof request, static_cast<std::uint32_t>(pointers.size()), pointers.data()};
  engine.calls().begin_advance(engine.model().time);  // nothing later may be committed
  try {
    call(ErrorKind::input, [&](const springnet_integrator& functions) {
      const springnet_status status = functions.create(functions.context, &creation);
      integrator = creation.integrator;
      return status == SPRINGNET_OK ? functions.begin_sensitivities(integrator, &request) : status;
    });
  } catch (...) {
    if (integrator != nullptr) static_cast<void>(component->integrator().destroy(std::exchange(integrator, nullptr)));
    throw;
  }
}

// Derivatives do not go through them.
void ReferenceSensitivities::Impl::check_events() const {
  if (engine.model().journal.events().empty()) return;
  const Event& event = engine.model().journal.events().front();
  const bool is_rupture = event.kind == Event::Kind::ruptured || event.kind == Event::Kind::cut;
  throw Error(ErrorKind::simulation, fmt::format("sensitivities: {} at {:g} s is not differentiated",
                                                 is_rupture ? "a rupture" : "contact", event.time));
}

void ReferenceSensitivities::Impl::advance_to(double until) {
  if (!(until > engine.model().time) || !std::isfinite(until))
    refuse(fmt::format("{} s is not later than {} s, where the motion is", until, engine.model().time));
  check_events();
  springnet_step_report report{};
  report.struct_size = sizeof report;
  engine.calls().begin_advance(until);
  call(ErrorKind::simulation, [&](const springnet_integrator& functions) {
    const springnet_advance request{sizeof request, 0, until, &report};
    return functions.advance(integrator, &request);
  });
  if (!engine.calls().ends_at(engine.model().time))
    throw Error(ErrorKind::plugin, fmt::format("{}: it committed no state at {} s", full_name(*component), until));
  check_events();
}

Matrix3Xd ReferenceSensitivities::Impl::in_user_order(const springnet_const_vectors& values) const {
  Matrix3Xd result(3, static_cast<Eigen::Index>(nodes()));
  const std::vector<std::uint32_t>& number = engine.model().layout.ordering().engine;
  for (std::size_t k = 0; k < nodes(); ++k)
    result.col(static_cast<Eigen::Index>(k)) << values.x[number[k]], values.y[number[k]], values.z[number[k]];
  return result;
}

Matrix3Xd ReferenceSensitivities::Impl::change(std::size_t column, bool of_velocities) const {
  if (column >= columns.size()) refuse(fmt::format("column {} does not exist: there are {}", column, columns.size()));
  std::vector<double> position(3 * nodes()), velocity(3 * nodes());
  const springnet_sensitivity_values request{sizeof request, static_cast<std::uint32_t>(column), position.data(),
                                             velocity.data()};
  call(ErrorKind::simulation,
       [&](const springnet_integrator& functions) { return functions.sensitivity(integrator, &request); });
  const double* const from = of_velocities ? velocity.data() : position.data();
  return in_user_order({from, from + nodes(), from + 2 * nodes()});
}

ReferenceSensitivities::ReferenceSensitivities(const std::shared_ptr<const Network>& network,
                                               const std::shared_ptr<const PluginHost>& plugins,
                                               const SimulationOptions& options, const std::vector<Learnable>& of) {
  static_cast<void>(Simulation(network, plugins, options));  // its checks of all of these
  impl_ = std::make_unique<Impl>(network, plugins, options, of);
}
ReferenceSensitivities::~ReferenceSensitivities() = default;
ReferenceSensitivities::ReferenceSensitivities(ReferenceSensitivities&&) noexcept = default;
ReferenceSensitivities& ReferenceSensitivities::operator=(ReferenceSensitivities&&) noexcept = default;

const std::vector<SensitivityColumn>& ReferenceSensitivities::columns() const noexcept { return impl_->columns; }
void ReferenceSensitivities::advance_to(double time) { impl_->advance_to(time); }
double ReferenceSensitivities::time() const noexcept { return impl_->engine.model().time; }
Matrix3Xd ReferenceSensitivities::positions() const {
  const springnet_vectors& p = impl_->engine.model().state.view.position;
  return impl_->in_user_order({p.x, p.y, p.z});
}
Matrix3Xd ReferenceSensitivities::velocities() const {
  const springnet_vectors& v = impl_->engine.model().state.view.velocity;
  return impl_->in_user_order({v.x, v.y, v.z});
}
Matrix3Xd ReferenceSensitivities::position_changes(std::size_t column) const { return impl_->change(column, false); }
Matrix3Xd ReferenceSensitivities::velocity_changes(std::size_t column) const { return impl_->change(column, true); }

}  // namespace springnet
