#include "simulation/scheduled_changes.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "simulation/engine.hpp"
#include "simulation/law_setting.hpp"

namespace springnet {
namespace {

// Calls what(members, those of the change) for springs and for elements.
template <class What>
void for_members(const layers::Layout& layout, const Change& change, const What& what) {
  if (!change.springs.empty()) what(Members{layout, false}, change.springs);
  if (!change.elements.empty()) what(Members{layout, true}, change.elements);
}

// Calls what(members, those that have it, the parameter or input, its value) for what a change says of laws.
template <class What>
void for_values(const layers::Layout& layout, const Change& change, const What& what) {
  const auto each = [&](const ParameterValues& values, ComponentKind law, bool are_inputs) {
    for (const auto& [name, value] : values) {
      const LawValue named{law, name, are_inputs};
      bool any = false;
      for_members(layout, change, [&](const Members& members, const std::vector<std::uint32_t>& all) {
        std::vector<std::uint32_t> list;
        for (const std::uint32_t member : all)
          if (has_value(members, member, named)) list.push_back(member);
        any = any || !list.empty();
        if (!list.empty()) what(members, list, named, value);
      });
      if (any) continue;
      for_members(layout, change, [&](const Members& members, const std::vector<std::uint32_t>& all) {
        check_values(members, {all.front()}, named, {value});  // names what is there in its place
      });
    }
  };
  each(change.spring, ComponentKind::spring_function, false);
  each(change.viscosity, ComponentKind::viscosity_function, false);
  each(change.spring_inputs, ComponentKind::spring_function, true);
  each(change.viscosity_inputs, ComponentKind::viscosity_function, true);
}

std::vector<double> scaled(const Members& members, const std::vector<std::uint32_t>& list, double factor) {
  std::vector<double> values;
  for (const std::uint32_t member : list) values.push_back(factor * reference_of(members, member));
  return values;
}

}  // namespace

ScheduledChanges::ScheduledChanges(Engine& engine, const std::vector<Change>& changes) : engine_(engine) {
  for (std::size_t i = 0; i < changes.size(); ++i) {
    try {
      check(changes[i]);
    } catch (const Error& error) {
      throw Error(error.kind(), fmt::format("change {} at {:g} s: {}", i, changes[i].time, error.what()));
    }
    changes_.push_back({changes[i]});
  }
  // Several may be due at once.
  for (std::size_t i = 0; i < changes_.size(); ++i) by_time_.push_back(i);
  std::stable_sort(by_time_.begin(), by_time_.end(),
                   [this](std::size_t a, std::size_t b) { return changes_[a].change.time < changes_[b].change.time; });
}

void ScheduledChanges::check(const Change& change) const {
  const layers::Layout& layout = engine_.model().layout;
  for_values(layout, change, [](const Members& members, const auto& list, const LawValue& what, double value) {
    check_values(members, list, what, {value});
  });
  for_members(layout, change, [&](const Members& members, const auto& list) {
    if (change.reference) check_references(members, list, {*change.reference});
    if (change.reference_scale) check_references(members, list, scaled(members, list, *change.reference_scale));
  });
  for (const auto& [name, value] : change.neuron) check_neurons(layout, change.nodes, name, {value});
  if (change.mass) check_masses(change.nodes, {*change.mass});
  if (change.remove) check_removal(engine_, change.nodes);
}

void ScheduledChanges::set_values_of(const Change& change) {
  const layers::Layout& layout = engine_.model().layout;
  for_values(layout, change, [&](const Members& members, const auto& list, const LawValue& what, double value) {
    set_values(engine_, members, list, what, {value});
  });
  for_members(layout, change, [&](const Members& members, const auto& list) {
    if (change.reference) set_references(engine_, members, list, {*change.reference});
    if (change.reference_scale) set_references(engine_, members, list, scaled(members, list, *change.reference_scale));
  });
  for (const auto& [name, value] : change.neuron) set_neurons(engine_, change.nodes, name, {value});
  if (change.mass) set_masses(engine_, change.nodes, {*change.mass});
}

void ScheduledChanges::perform(const Change& change) {
  set_values_of(change);
  if (!change.remove) return;
  if (!change.springs.empty()) engine_.topology().cut(change.springs);
  if (!change.elements.empty()) engine_.topology().remove_elements(change.elements);
  if (!change.nodes.empty()) remove_nodes(engine_, change.nodes);
}

// As for cuts.
bool ScheduledChanges::is_due(double time, double now, double time_step) noexcept {
  return time <= now + 1e-9 * std::min(time_step, now);
}

void ScheduledChanges::perform_due() {
  const Model& model = engine_.model();
  for (const std::size_t i : by_time_) {
    Scheduled& scheduled = changes_[i];
    if (scheduled.done || !is_due(scheduled.change.time, model.time, model.time_step)) continue;
    scheduled.done = true;
    perform(scheduled.change);
  }
}

double ScheduledChanges::next(double time) const noexcept {
  double next = std::numeric_limits<double>::infinity();
  for (const Scheduled& each : changes_)
    if (!each.done && each.change.time > time) next = std::min(next, each.change.time);
  return next;
}

std::vector<ScheduledChanges::Scheduled>::iterator ScheduledChanges::first_exchange() noexcept {
  auto first = changes_.end();
  for (auto each = changes_.begin(); each != changes_.end(); ++each) {
    if (!each->change.integrator || each->exchanged) continue;
    if (first == changes_.end() || each->change.time < first->change.time) first = each;
  }
  return first;
}

double ScheduledChanges::next_exchange() const noexcept {
  double next = std::numeric_limits<double>::infinity();
  for (const Scheduled& each : changes_)
    if (each.change.integrator && !each.exchanged) next = std::min(next, each.change.time);
  return next;
}

LawUse ScheduledChanges::take_exchange() {
  Scheduled& first = *first_exchange();
  first.exchanged = true;
  return *first.change.integrator;
}

void ScheduledChanges::archive(Archive& archive) {
  archive.same(changes_.size(), "changes");
  for (Scheduled& each : changes_) {
    archive.flag(each.done);
    archive.flag(each.exchanged);
  }
}

void ScheduledChanges::take_over(const ScheduledChanges& before) {
  for (std::size_t i = 0; i < before.changes_.size(); ++i) {
    changes_[i].done = before.changes_[i].done;
    changes_[i].exchanged = before.changes_[i].exchanged;
  }
}

}  // namespace springnet
