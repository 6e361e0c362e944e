#include "learning/scene_changes.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "simulation/law_setting.hpp"

namespace springnet::learning {

SceneChanges::SceneChanges(const Network& network, Engine& engine, LearnedSets& learned)
    : changes_(network.changes()), learned_(learned) {
  const auto refuse = [this](std::size_t change, const char* what) {
    throw Error(
        ErrorKind::input,
        fmt::format("learning: change {} at {:g} s {}, which is not differentiated; leave it out, or learn from "
                    "the time before alone",
                    change, changes_[change].time, what));
  };
  for (const std::size_t i : engine.changes().in_order()) {
    const Change& change = changes_[i];
    if (change.integrator) refuse(i, "is to another integrator");
    if (engine.changes().is_done(i)) continue;
    if (change.remove && !change.nodes.empty()) refuse(i, "removes nodes");
    if (!change.spring_inputs.empty() || !change.viscosity_inputs.empty()) refuse(i, "sets inputs of laws");
    order_.push_back(i);
  }
  follow(engine);
}

SceneChanges::PutBack SceneChanges::values_before(const Change& change) const {
  const Model& model = engines_.front()->model();
  PutBack result;
  const auto keep = [&](const Members& members, const std::vector<std::uint32_t>& all, const LawValue& what) {
    std::vector<std::uint32_t> list;
    std::vector<double> values;
    for (const std::uint32_t member : all) {
      if (!has_value(members, member, what)) continue;
      list.push_back(member);
      values.push_back(value_of(members, member, what));
    }
    if (list.empty()) return;
    // The name is that of the network's change.
    result.emplace_back([are_elements = members.are_elements, list = std::move(list), what,
                         values = std::move(values)](Engine& engine) {
      set_values(engine, {engine.model().layout, are_elements}, list, what, values);
    });
  };
  for (const bool are_elements : {false, true}) {
    const std::vector<std::uint32_t>& all = are_elements ? change.elements : change.springs;
    if (all.empty()) continue;
    const Members members{model.layout, are_elements};
    for (const auto& [name, value] : change.spring) keep(members, all, {ComponentKind::spring_function, name, false});
    for (const auto& [name, value] : change.viscosity)
      keep(members, all, {ComponentKind::viscosity_function, name, false});
    if (!change.reference && !change.reference_scale) continue;
    std::vector<double> values;
    for (const std::uint32_t member : all) values.push_back(reference_of(members, member));
    result.emplace_back([are_elements, &all, values = std::move(values)](Engine& engine) {
      set_references(engine, {engine.model().layout, are_elements}, all, values);
    });
  }
  for (const auto& [name, value] : change.neuron) {
    std::vector<double> values;
    for (const NodeIndex node : change.nodes) values.push_back(neuron_value(model.layout, node, name));
    result.emplace_back([&change, &name = name, values = std::move(values)](Engine& engine) {
      set_neurons(engine, change.nodes, name, values);
    });
  }
  if (!change.mass) return result;
  std::vector<double> values;
  for (const NodeIndex node : change.nodes) values.push_back(model.mass[model.layout.ordering().engine[node]]);
  result.emplace_back(
      [&change, values = std::move(values)](Engine& engine) { set_masses(engine, change.nodes, values); });
  return result;
}

std::size_t SceneChanges::bytes() const {
  std::size_t values = 0;
  for (const std::size_t i : order_) {
    const Change& change = changes_[i];
    const std::size_t of_springs =
        change.spring.size() + change.viscosity.size() + (change.reference || change.reference_scale ? 1 : 0);
    values += of_springs * (change.springs.size() + change.elements.size()) +
              (change.neuron.size() + (change.mass ? 1 : 0)) * change.nodes.size();
  }
  return values * (sizeof(double) + sizeof(std::uint32_t));
}

void SceneChanges::make_next() {
  const std::size_t number = order_[made_.size()];
  made_.push_back(values_before(changes_[number]));
  for (Engine* const each : engines_) each->changes().set_values_of(number);
  learned_.follow_change(changes_[number]);
}

void SceneChanges::undo_last() {
  for (const auto& put_back : made_.back())
    for (Engine* const each : engines_) put_back(*each);
  made_.pop_back();
  learned_.undo_change();
}

void SceneChanges::begin() {
  states_.clear();
  while (!made_.empty()) undo_last();
}

void SceneChanges::take(std::size_t state, double time) {
  const double time_step = engines_.front()->model().time_step;
  while (states_.size() < order_.size() &&
         ScheduledChanges::is_due(changes_[order_[states_.size()]].time, time, time_step))
    states_.push_back(state);
}

void SceneChanges::begin_at_last() { std::fill(states_.begin(), states_.end(), std::size_t{0}); }

bool SceneChanges::any_at(std::size_t state) const { return std::binary_search(states_.begin(), states_.end(), state); }

void SceneChanges::set_for_step(std::size_t until) {
  const auto count =
      static_cast<std::size_t>(std::lower_bound(states_.begin(), states_.end(), until) - states_.begin());
  while (made_.size() > count) undo_last();
  while (made_.size() < count) make_next();
}

}  // namespace springnet::learning
