// What LearnedSets sets in a simulation or an engine, and reads there.

#include "learning/learned_values.hpp"

#include <utility>

#include "simulation/law_setting.hpp"

namespace springnet::learning {

namespace {

using Kind = LearnedValues::Kind;

[[nodiscard]] ComponentKind law_of(Kind kind) {
  return kind == Kind::viscosity_parameter ? ComponentKind::viscosity_function : ComponentKind::spring_function;
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
  void set_friction(const LearnedValues& what, const Values& values) const {
    for (std::size_t i = 0; i < values.size(); ++i) simulation.set_friction(what.members[i], values[i]);
  }
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
  void set_friction(const LearnedValues& what, const Values& values) const {
    Contact& contact = engine.model().contact;
    if (contact.obstacles().empty()) return;  // of the net without constraints
    for (std::size_t i = 0; i < values.size(); ++i) contact.set_friction(what.members[i], values[i]);
    engine.model().changed();
  }
};

}  // namespace

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
        case Kind::friction:
          result[next++] = frictions_[member];
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
      case Kind::friction:
        target.set_friction(what, own);
        break;
      case Kind::initial_velocity:
        break;
    }
  }
}

void LearnedSets::set_without_start(Simulation& simulation, const Eigen::VectorXd& values) const {
  set_laws_and_masses(OfSimulation{simulation}, values);
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

void LearnedSets::set(Engine& engine, const Eigen::VectorXd& values) const {
  set_laws_and_masses(OfEngine{engine}, values);  // states are given with each request
}

}  // namespace springnet::learning
