#include "learning/scene_changes.hpp"

#include <algorithm>
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

void SceneChanges::follow(Engine& engine) {
  Before& before = engines_.emplace_back(Before{engine, {}});
  for (const std::size_t i : order_) remember(changes_[i], before);
}

void SceneChanges::remember(const Change& change, Before& before) const {
  Engine& engine = before.engine;
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
    before.put_back.emplace_back(
        [&engine, are_elements = members.are_elements, list = std::move(list), what, values = std::move(values)] {
          set_values(engine, {engine.model().layout, are_elements}, list, what, values);
        });
  };
  for (const bool are_elements : {false, true}) {
    const std::vector<std::uint32_t>& all = are_elements ? change.elements : change.springs;
    if (all.empty()) continue;
    const Members members{engine.model().layout, are_elements};
    for (const auto& [name, value] : change.spring) keep(members, all, {ComponentKind::spring_function, name, false});
    for (const auto& [name, value] : change.viscosity)
      keep(members, all, {ComponentKind::viscosity_function, name, false});
    if (!change.reference && !change.reference_scale) continue;
    std::vector<double> values;
    for (const std::uint32_t member : all) values.push_back(reference_of(members, member));
    before.put_back.emplace_back([&engine, are_elements, &all, values = std::move(values)] {
      set_references(engine, {engine.model().layout, are_elements}, all, values);
    });
  }
  for (const auto& [name, value] : change.neuron) {
    std::vector<double> values;
    for (const NodeIndex node : change.nodes) values.push_back(neuron_value(engine.model().layout, node, name));
    before.put_back.emplace_back([&engine, &change, &name = name, values = std::move(values)] {
      set_neurons(engine, change.nodes, name, values);
    });
  }
  if (!change.mass) return;
  std::vector<double> values;
  for (const NodeIndex node : change.nodes)
    values.push_back(engine.model().mass[engine.model().layout.ordering().engine[node]]);
  before.put_back.emplace_back(
      [&engine, &change, values = std::move(values)] { set_masses(engine, change.nodes, values); });
}

void SceneChanges::tell() {
  learned_.follow_changes(changes_, {order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(applied_)});
}

void SceneChanges::put_back() {
  for (const Before& each : engines_)
    for (const auto& own : each.put_back) own();
  applied_ = 0;
  tell();
}

void SceneChanges::begin() {
  states_.clear();
  if (applied_ > 0) put_back();
}

void SceneChanges::take(std::size_t state, double time) {
  const double time_step = engines_.front().engine.model().time_step;
  while (states_.size() < order_.size() &&
         ScheduledChanges::is_due(changes_[order_[states_.size()]].time, time, time_step))
    states_.push_back(state);
}

void SceneChanges::begin_at_last() { std::fill(states_.begin(), states_.end(), std::size_t{0}); }

bool SceneChanges::any_at(std::size_t state) const { return std::binary_search(states_.begin(), states_.end(), state); }

void SceneChanges::set_for_step(std::size_t until, const Set& set_learned) {
  const auto count =
      static_cast<std::size_t>(std::lower_bound(states_.begin(), states_.end(), until) - states_.begin());
  if (count == applied_) return;
  if (count < applied_) {
    put_back();
    for (const Before& each : engines_) set_learned(each.engine);
  }
  for (const Before& each : engines_)
    for (std::size_t i = applied_; i < count; ++i) each.engine.changes().set_values_of(order_[i]);
  applied_ = count;
  tell();
}

}  // namespace springnet::learning
