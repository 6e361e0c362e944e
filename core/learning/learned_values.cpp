#include "learning/learned_values.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "simulation/law_setting.hpp"

namespace springnet::learning {

namespace {

using Kind = LearnedValues::Kind;

constexpr std::size_t axes = 3;

[[nodiscard]] bool is_of_nodes(Kind kind) { return member_name(kind, false) == "node"; }

[[nodiscard]] ComponentKind law_of(Kind kind) {
  return kind == Kind::viscosity_parameter ? ComponentKind::viscosity_function : ComponentKind::spring_function;
}

[[nodiscard]] std::uint32_t host_kind(Kind kind) {
  switch (kind) {
    case Kind::spring_parameter:
      return SPRINGNET_BY_SPRING_PARAMETER;
    case Kind::viscosity_parameter:
      return SPRINGNET_BY_VISCOSITY_PARAMETER;
    case Kind::rest_length:
      return SPRINGNET_BY_REFERENCE;
    case Kind::neuron_parameter:
      return SPRINGNET_BY_NEURON_PARAMETER;
    default:
      return SPRINGNET_BY_MASS;
  }
}

// What a change makes of a value of this kind: the factor of it; none: the change does not concern it.
[[nodiscard]] std::optional<double> factor_of(const Change& change, const LearnedValues& what) {
  const auto sets = [&](const ParameterValues& values) {
    return values.count(what.parameter) != 0 ? std::optional<double>(0.0) : std::nullopt;
  };
  switch (what.kind) {
    case Kind::spring_parameter:
      return sets(change.spring);
    case Kind::viscosity_parameter:
      return sets(change.viscosity);
    case Kind::rest_length:
      return change.reference ? std::optional<double>(0.0) : change.reference_scale;
    case Kind::mass:
      return change.mass ? std::optional<double>(0.0) : std::nullopt;
    case Kind::neuron_parameter:
      return sets(change.neuron);
    default:
      return std::nullopt;
  }
}
[[nodiscard]] const std::vector<std::uint32_t>& members_of(const Change& change, const LearnedValues& what) {
  return is_of_nodes(what.kind) ? change.nodes : what.of_elements ? change.elements : change.springs;
}

using Values = std::vector<double>;

struct OfSimulation {
  Simulation& simulation;
  void set_parameters(const LearnedValues& what, const Values& values) const {
    if (what.of_elements)
      simulation.set_element_parameter(what.members, law_of(what.kind), what.parameter, values);
    else
      simulation.set_parameter(what.members, law_of(what.kind), what.parameter, values);
  }
  void set_references(const LearnedValues& what, const Values& values) const {
    if (what.of_elements)
      simulation.set_references(what.members, values);
    else
      simulation.set_rest_lengths(what.members, values);
  }
  void set_masses(const LearnedValues& what, const Values& values) const {
    simulation.set_masses(what.members, values);
  }
  void set_neurons(const LearnedValues& what, const Values& values) const {
    simulation.set_neuron_parameter(what.members, what.parameter, values);
  }
  void set_loads(const LearnedValues& what, const Values& values) const {
    for (std::size_t i = 0; i < values.size(); ++i) simulation.set_load_factor(what.members[i], values[i]);
  }
  void set_gravity(const Vector3& acceleration) const { simulation.set_gravity(acceleration); }
};

struct OfEngine {
  Engine& engine;
  [[nodiscard]] Members members(const LearnedValues& what) const { return {engine.model().layout, what.of_elements}; }
  void set_parameters(const LearnedValues& what, const Values& values) const {
    set_values(engine, members(what), what.members, {law_of(what.kind), what.parameter, false}, values);
  }
  void set_references(const LearnedValues& what, const Values& values) const {
    springnet::set_references(engine, members(what), what.members, values);
  }
  void set_masses(const LearnedValues& what, const Values& values) const {
    springnet::set_masses(engine, what.members, values);
  }
  void set_neurons(const LearnedValues& what, const Values& values) const {
    springnet::set_neurons(engine, what.members, what.parameter, values);
  }
  void set_loads(const LearnedValues& what, const Values& values) const {
    for (std::size_t i = 0; i < values.size(); ++i) engine.model().loads.set_factor(what.members[i], values[i]);
    engine.model().changed();
  }
  void set_gravity(const Vector3& acceleration) const {
    engine.model().loads.set_gravity(acceleration);
    engine.model().changed();
  }
};

// Does this at its end, also after an error.
template <class Set>
class Back {
 public:
  explicit Back(Set set) : set_(std::move(set)) {}
  ~Back() { set_(); }
  Back(const Back&) = delete;
  Back& operator=(const Back&) = delete;

 private:
  Set set_;
};

}  // namespace

LearnedSets::LearnedSets(const Network& network, std::vector<LearnedValues> learned) : gravity_(network.gravity()) {
  const auto is_empty = [](const LearnedValues& each) { return each.members.empty(); };
  if (std::all_of(learned.begin(), learned.end(), is_empty))
    throw Error(ErrorKind::input, "learning: there is nothing to be learned");
  std::map<std::tuple<Kind, bool, std::string>, std::vector<std::uint8_t>> all_listed;
  for (LearnedValues& each : learned) {
    const std::size_t most = each.kind == Kind::load      ? network.loads().size()
                             : each.kind == Kind::gravity ? axes
                             : is_of_nodes(each.kind)     ? network.nodes().size()
                             : each.of_elements           ? network.elements().size()
                                                          : network.springs().size();
    std::vector<std::uint8_t>& listed = all_listed[{each.kind, each.of_elements, each.parameter}];
    listed.resize(most);
    for (const std::uint32_t member : each.members) {
      if (member >= most)
        throw Error(ErrorKind::input, fmt::format("learning: {} {} does not exist: the network has {}",
                                                  member_name(each.kind, each.of_elements), member, most));
      if (std::exchange(listed[member], std::uint8_t{1}) != 0)
        throw Error(ErrorKind::input,
                    fmt::format("learning: {} {} is listed twice{}{}", member_name(each.kind, each.of_elements), member,
                                each.parameter.empty() ? "" : ", for its parameter ", each.parameter));
      if (each.kind == Kind::initial_velocity && network.nodes()[member].fixed)
        throw Error(ErrorKind::input, fmt::format("learning: node {} is fixed and has no velocity to learn", member));
    }
    Set set;
    set.what = std::move(each);
    set.first = count_;
    count_ += set.size();
    sets_.push_back(std::move(set));
  }
}

void LearnedSets::attach(Engine& engine) {
  const layers::Layout& layout = engine.model().layout;
  for (Set& set : sets_) {
    const LearnedValues& what = set.what;
    set.places = what.members;
    if (is_of_nodes(what.kind)) {
      for (std::uint32_t& each : set.places) each = layout.ordering().engine[each];
      set.values.assign(set.is_velocity() ? 0 : layout.node_count(), 0.0);
    } else if (set.is_load()) {
      set.values.assign(what.kind == Kind::gravity ? axes : engine.model().loads.count(), 0.0);
    } else {
      set.values.assign(what.of_elements ? layout.elements().count() : layout.spring_count(), 0.0);
    }
  }
  static_cast<void>(values_of(engine));  // throws for a law without the parameter
}

Eigen::VectorXd LearnedSets::values_of(const Engine& engine) const {
  Eigen::VectorXd result(static_cast<Eigen::Index>(count_));
  const Model& model = engine.model();
  for (const Set& set : sets_) {
    const LearnedValues& what = set.what;
    auto next = static_cast<Eigen::Index>(set.first);
    for (std::size_t i = 0; i < what.members.size(); ++i) {
      const std::uint32_t member = what.members[i];
      switch (what.kind) {
        case Kind::spring_parameter:
        case Kind::viscosity_parameter:
          result[next++] =
              value_of({model.layout, what.of_elements}, member, {law_of(what.kind), what.parameter, false});
          break;
        case Kind::rest_length:
          result[next++] = what.of_elements ? model.layout.elements().reference(member)
                                            : Members{model.layout, false}.value(member, 0);
          break;
        case Kind::mass:
          result[next++] = model.mass[set.places[i]];
          break;
        case Kind::neuron_parameter:
          result[next++] = neuron_value(model.layout, member, what.parameter);
          break;
        case Kind::load:
          result[next++] = model.loads.factor(member);
          break;
        case Kind::gravity:
          result[next++] = model.loads.gravity()[member];
          break;
        case Kind::initial_velocity:
          for (const double* component :
               {model.state.view.velocity.x, model.state.view.velocity.y, model.state.view.velocity.z})
            result[next++] = component[set.places[i]];
      }
    }
  }
  return result;
}

void LearnedSets::check(const Eigen::VectorXd& values) const {
  if (static_cast<std::size_t>(values.size()) != count_)
    throw Error(ErrorKind::input, fmt::format("learning: {} values, must be {}", values.size(), count_));
  for (const Set& set : sets_)
    for (std::size_t i = 0; i < set.size(); ++i)
      if (const double value = values[static_cast<Eigen::Index>(set.first + i)]; !std::isfinite(value))
        throw Error(ErrorKind::input,
                    fmt::format("learning: a value of {} {} is {}", member_name(set.what.kind, set.what.of_elements),
                                set.what.members[set.is_velocity() ? i / 3 : i], value));
}

std::vector<double> LearnedSets::values_of(const Set& set, const Eigen::VectorXd& values) const {
  const double* const first = values.data() + set.first;
  return {first, first + set.size()};
}

std::pair<LearnedValues, std::vector<double>> LearnedSets::present(const Set& set,
                                                                   const Eigen::VectorXd& values) const {
  std::pair<LearnedValues, std::vector<double>> result{set.what, values_of(set, values)};
  if (set.factors.empty()) return result;
  auto& [what, own] = result;
  std::size_t next = 0;
  for (std::size_t i = 0; i < set.factors.size(); ++i) {
    if (set.factors[i] == 0.0) continue;
    what.members[next] = what.members[i];
    own[next++] = set.factors[i] * own[i];
  }
  what.members.resize(next);
  own.resize(next);
  return result;
}

void LearnedSets::set(Simulation& simulation, const Eigen::VectorXd& values) const {
  set_without_start(simulation, values);
  for (const Set& set : sets_) {
    if (!set.is_velocity()) continue;
    const std::vector<double> own = values_of(set, values);
    for (std::size_t i = 0; i < set.what.members.size(); ++i)
      simulation.set_velocity(set.what.members[i], {own[3 * i], own[3 * i + 1], own[3 * i + 2]});
  }
}

// Target: OfSimulation or OfEngine.
template <class Target>
void LearnedSets::set_laws_and_masses(const Target& target, const Eigen::VectorXd& values) const {
  Vector3 gravity = gravity_;  // components that are not learned stay
  for (const Set& set : sets_) {
    const auto [what, own] = present(set, values);
    if (what.members.empty()) continue;
    switch (what.kind) {
      case Kind::spring_parameter:
      case Kind::viscosity_parameter:
        target.set_parameters(what, own);
        break;
      case Kind::rest_length:
        target.set_references(what, own);
        break;
      case Kind::mass:
        target.set_masses(what, own);
        break;
      case Kind::neuron_parameter:
        target.set_neurons(what, own);
        break;
      case Kind::load:
        target.set_loads(what, own);
        break;
      case Kind::gravity:
        for (std::size_t i = 0; i < own.size(); ++i) gravity[what.members[i]] = own[i];
        target.set_gravity(gravity);
        break;
      case Kind::initial_velocity:
        break;
    }
  }
}

void LearnedSets::set_without_start(Simulation& simulation, const Eigen::VectorXd& values) const {
  set_laws_and_masses(OfSimulation{simulation}, values);
}

void LearnedSets::follow_changes(const std::vector<Change>& changes, const std::vector<std::size_t>& made) {
  for (Set& set : sets_) {
    if (set.is_velocity() || set.is_load() || (made.empty() && set.factors.empty())) continue;
    // What has been summed so far was by other factors.
    set.sums.resize(set.places.size(), 0.0);
    for (std::size_t i = 0; i < set.places.size(); ++i)
      set.sums[i] += set.factor(i) * std::exchange(set.values[set.places[i]], 0.0);
    std::map<std::uint32_t, double> factors;  // of members that change
    for (const std::size_t number : made) {
      const std::optional<double> factor = factor_of(changes[number], set.what);
      if (!factor) continue;
      for (const std::uint32_t member : members_of(changes[number], set.what))
        factors.emplace(member, 1.0).first->second *= *factor;
    }
    set.factors.assign(set.places.size(), 1.0);
    for (std::size_t i = 0; i < set.places.size(); ++i)
      if (const auto found = factors.find(set.what.members[i]); found != factors.end()) set.factors[i] = found->second;
    if (factors.empty()) set.factors.clear();
  }
}

void LearnedSets::set(Engine& engine, const Eigen::VectorXd& values) const {
  set_laws_and_masses(OfEngine{engine}, values);  // states are given with each request
}

std::vector<sdk::Host::ParameterSet> LearnedSets::host_sets() {
  std::vector<sdk::Host::ParameterSet> result;
  for (Set& set : sets_) {
    if (set.is_velocity() || set.is_load()) continue;
    sdk::Host::ParameterSet each{host_kind(set.what.kind), set.values};
    if (!set.what.parameter.empty()) each.parameter = set.what.parameter.c_str();
    each.of_elements = set.what.of_elements;
    result.push_back(each);
  }
  return result;
}

std::vector<springnet_parameter_set> LearnedSets::sets_along(const Eigen::VectorXd& change,
                                                             std::vector<std::vector<double>>& values) const {
  std::vector<springnet_parameter_set> result;
  values.clear();
  for (const Set& set : sets_) {
    if (set.is_velocity() || set.is_load()) continue;
    std::vector<double>& own = values.emplace_back(set.values.size(), 0.0);
    bool changes = false;
    for (std::size_t i = 0; i < set.places.size(); ++i) {
      own[set.places[i]] = change[static_cast<Eigen::Index>(set.first + i)];
      changes = changes || own[set.places[i]] != 0.0;
    }
    if (!changes) continue;
    auto each = sdk::sized<springnet_parameter_set>();
    each.kind = host_kind(set.what.kind);
    each.of_elements = set.what.of_elements ? 1 : 0;
    if (!set.what.parameter.empty()) each.parameter = set.what.parameter.c_str();
    each.values = own.data();  // stays, as the numbers of a vector that is moved do
    result.push_back(each);
  }
  return result;
}

// Loads are linear in their factors, and accelerations in forces; in contact with friction only until nodes begin to
// slide or to stick, so that differences are small there, at the cost of four digits.
Eigen::VectorXd LearnedSets::by_load(Engine& engine, const sdk::Host& host, const springnet_evaluation& at,
                                     const Set& set, std::uint32_t place) {
  Loads& loads = engine.model().loads;
  const double part = engine.model().contact.obstacles().empty() ? 0.5 : 0x1p-14;
  const auto n = static_cast<Eigen::Index>(host.network().node_count);
  const auto accelerations = [&] {
    Eigen::VectorXd result(3 * n);
    springnet_evaluation wanted = at;
    wanted.acceleration = {result.data(), result.data() + n, result.data() + 2 * n};
    host.evaluate(wanted);
    return result;
  };
  if (set.what.kind == Kind::gravity) {
    const Vector3 before = loads.gravity();
    const Back back([&] { loads.set_gravity(before); });
    const double size = std::max(1.0, before.norm());  // differences of its own size lose no digits
    loads.set_gravity(before + part * size * Vector3::Unit(place));
    const Eigen::VectorXd more = accelerations();
    loads.set_gravity(before - part * size * Vector3::Unit(place));
    return (more - accelerations()) / (2.0 * part * size);
  }
  const double factor = loads.factor(place);
  const Back back([&] { loads.set_factor(place, factor); });
  loads.set_factor(place, factor + part);
  const Eigen::VectorXd more = accelerations();
  loads.set_factor(place, factor - part);
  return (more - accelerations()) / (2.0 * part);
}

void LearnedSets::tangent(Engine& engine, const sdk::Host& host, const springnet_evaluation& at,
                          const Eigen::VectorXd& change, double* accelerations, double* internal) {
  for (Set& set : sets_) {
    if (set.is_velocity()) continue;
    std::fill(set.values.begin(), set.values.end(), 0.0);
    for (std::size_t i = 0; i < set.places.size(); ++i)
      set.values[set.places[i]] = set.factor(i) * change[static_cast<Eigen::Index>(set.first + i)];
  }
  const std::vector<sdk::Host::ParameterSet> sets = host_sets();
  if (!sets.empty()) {
    host.parameter_tangent(at, sets, {nullptr, accelerations, internal});
  } else {
    std::fill_n(accelerations, 3 * host.network().node_count, 0.0);
    if (internal != nullptr) std::fill_n(internal, host.network().internal_count, 0.0);
  }
  for (const Set& set : sets_)
    for (std::size_t i = 0; set.is_load() && i < set.places.size(); ++i)
      if (const double by = change[static_cast<Eigen::Index>(set.first + i)]; by != 0.0)
        Eigen::Map<Eigen::VectorXd>(accelerations, 3 * static_cast<Eigen::Index>(host.network().node_count)) +=
            by * by_load(engine, host, at, set, set.places[i]);
}

void LearnedSets::begin_cotangent() {
  for (Set& set : sets_) {
    std::fill(set.values.begin(), set.values.end(), 0.0);
    set.sums.clear();
  }
}

void LearnedSets::add_cotangent(Engine& engine, const sdk::Host& host, const springnet_evaluation& at, double* weights,
                                double* internal_weights) {
  const std::vector<sdk::Host::ParameterSet> sets = host_sets();
  // Of values that accelerations depend on by forces alone these are enough, with the derivatives at hand.
  const bool by_forces = engine.model().contact.obstacles().empty() && !engine.model().rigid.any() &&
                         std::none_of(sets_.begin(), sets_.end(), [](const Set& set) {
                           return set.what.kind == Kind::mass || set.what.kind == Kind::neuron_parameter;
                         });
  if (by_forces && !sets.empty()) {
    force_weights_.resize(3 * std::size_t{host.network().node_count});
    engine.linear().matrices().force_weights(weights, force_weights_.data());
    host.parameter_cotangent(at, sets, {force_weights_.data(), nullptr, internal_weights});
  } else if (!sets.empty()) {
    host.parameter_cotangent(at, sets, {nullptr, weights, internal_weights});
  }
  for (Set& set : sets_)
    for (std::size_t i = 0; set.is_load() && i < set.places.size(); ++i)
      set.values[set.places[i]] +=
          Eigen::Map<const Eigen::VectorXd>(weights, 3 * static_cast<Eigen::Index>(host.network().node_count))
              .dot(by_load(engine, host, at, set, set.places[i]));
}

Eigen::VectorXd LearnedSets::event_gradient(const sdk::Host& host, const springnet_evaluation& at, std::uint32_t event,
                                            double* by_position, double* by_velocity, double& by_time) {
  std::vector<std::pair<std::vector<double>, std::vector<double>>> before;
  for (Set& set : sets_) {
    before.emplace_back(set.values, std::exchange(set.sums, {}));
    std::fill(set.values.begin(), set.values.end(), 0.0);
  }
  by_time = host.event_derivative(at, event, by_position, by_velocity, host_sets());
  const Eigen::VectorXd result =
      cotangent(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(host.network().node_count)));
  for (std::size_t i = 0; i < before.size(); ++i) std::tie(sets_[i].values, sets_[i].sums) = std::move(before[i]);
  return result;
}

void LearnedSets::add_gradient(const Eigen::VectorXd& by_values) {
  for (Set& set : sets_) {
    if (set.is_velocity()) continue;
    set.sums.resize(set.places.size(), 0.0);
    for (std::size_t i = 0; i < set.places.size(); ++i)
      set.sums[i] += by_values[static_cast<Eigen::Index>(set.first + i)];
  }
}

Eigen::VectorXd LearnedSets::cotangent(const Eigen::VectorXd& by_velocity) const {
  Eigen::VectorXd result(static_cast<Eigen::Index>(count_));
  const Eigen::Index nodes = by_velocity.size() / 3;
  for (const Set& set : sets_) {
    auto next = static_cast<Eigen::Index>(set.first);
    for (std::size_t i = 0; i < set.places.size(); ++i) {
      const std::uint32_t place = set.places[i];
      if (set.is_velocity())
        for (Eigen::Index axis = 0; axis < 3; ++axis) result[next++] = by_velocity[axis * nodes + place];
      else
        result[next++] = set.sum(i);
    }
  }
  return result;
}

std::vector<std::uint32_t> LearnedSets::with_start_velocities() const {
  std::vector<std::uint32_t> result;
  for (const Set& set : sets_)
    if (set.is_velocity()) result.insert(result.end(), set.what.members.begin(), set.what.members.end());
  return result;
}

Eigen::VectorXd LearnedSets::mass_changes(const Eigen::VectorXd& change, std::size_t nodes) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(nodes));
  for (const Set& set : sets_)
    for (std::size_t i = 0; set.what.kind == Kind::mass && i < set.places.size(); ++i)
      result[set.places[i]] += set.factor(i) * change[static_cast<Eigen::Index>(set.first + i)];
  return result;
}

void LearnedSets::add_to_masses(const Eigen::VectorXd& by_mass) {
  for (Set& set : sets_)
    for (std::size_t i = 0; set.what.kind == Kind::mass && i < set.places.size(); ++i)
      set.values[set.places[i]] += by_mass[set.places[i]];
}

void LearnedSets::start_velocity(const Eigen::VectorXd& change, Eigen::VectorXd& velocities) const {
  const Eigen::Index nodes = velocities.size() / 3;
  for (const Set& set : sets_) {
    if (!set.is_velocity()) continue;
    auto next = static_cast<Eigen::Index>(set.first);
    for (const std::uint32_t place : set.places)
      for (Eigen::Index axis = 0; axis < 3; ++axis) velocities[axis * nodes + place] += change[next++];
  }
}

}  // namespace springnet::learning
