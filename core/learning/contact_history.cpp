#include "learning/contact_history.hpp"

#include <algorithm>
#include <utility>

namespace springnet::learning {

namespace {

std::map<std::uint32_t, Touch> contacts_of(const Simulation& simulation) {
  std::map<std::uint32_t, Touch> result;
  if (simulation.surface_count() == 0) return result;
  const std::vector<std::uint32_t>& number = simulation.columns();
  for (std::uint32_t node = 0; node < number.size(); ++node) {
    if (!simulation.touching(node)) continue;
    Touch touch;
    std::int32_t* const places[] = {&touch.surface, &touch.second, &touch.third};
    const std::vector<std::size_t> surfaces = simulation.surfaces_of(node);
    for (std::size_t i = 0; i < surfaces.size() && i < 3; ++i) *places[i] = static_cast<std::int32_t>(surfaces[i]);
    touch.slides = !simulation.held(node);
    result[number[node]] = touch;
  }
  return result;
}

void add_surface(Touch& touch, std::int32_t surface) {
  if (touch.has(surface)) return;
  (touch.surface < 0 ? touch.surface : touch.second < 0 ? touch.second : touch.third) = surface;
}

}  // namespace

void ContactHistory::begin(const Simulation& simulation) {
  now_ = contacts_of(simulation);
  state_ = 0;
  changes_.clear();
  events_ = simulation.events().size();
}

// Where a step began contacts may have been decided anew; their events are of that time.
void ContactHistory::settle(const Simulation& simulation) {
  const std::vector<Event>& events = simulation.events();
  std::map<std::uint32_t, Touch> settled;
  for (; events_ < events.size() && events[events_].time < simulation.time(); ++events_) {
    const Event& event = events[events_];
    const bool is_of_contact = event.kind == Event::Kind::touched || event.kind == Event::Kind::released ||
                               event.kind == Event::Kind::slipped || event.kind == Event::Kind::stuck;
    if (!is_of_contact) continue;
    const std::uint32_t node = simulation.columns()[event.index];
    const auto now = now_.find(node);
    Touch& touch = settled.emplace(node, now == now_.end() ? Touch{} : now->second).first->second;
    const auto cause = event.kind == Event::Kind::touched    ? ContactCause::Kind::touch
                       : event.kind == Event::Kind::released ? ContactCause::Kind::release
                       : event.kind == Event::Kind::slipped  ? ContactCause::Kind::slip
                                                             : ContactCause::Kind::stick;
    touch = after(touch, {cause, event.surface});
  }
  for (const auto& [node, touch] : settled) {
    std::vector<Change>& changes = changes_[state_];
    const auto found = std::find_if(changes.begin(), changes.end(),
                                    [node = node](const Change& each) { return each.contact.node == node; });
    if (found != changes.end()) {
      found->after = touch;
    } else {
      const auto now = now_.find(node);
      const Touch before = now == now_.end() ? Touch{} : now->second;
      changes.push_back({{node, before, before, false}, touch});
    }
    set(node, touch);
  }
}

void ContactHistory::record(const Simulation& simulation, std::size_t step) {
  move_to(step - 1);
  settle(simulation);
  // A bounce touches and releases in one step: of what is committed it leaves nothing.
  std::map<std::uint32_t, std::vector<std::int32_t>> touched, bounced;
  for (; events_ < simulation.events().size(); ++events_) {
    const Event& event = simulation.events()[events_];
    const bool is_touch = event.kind == Event::Kind::touched;
    if (!is_touch && event.kind != Event::Kind::released) continue;
    const std::uint32_t node = simulation.columns()[event.index];
    if (is_touch) {
      touched[node].push_back(event.surface);
      continue;
    }
    for (const std::int32_t surface : touched[node])
      if (surface == event.surface) bounced[node].push_back(surface);
  }
  const std::map<std::uint32_t, Touch> after = contacts_of(simulation);
  std::vector<Change> changes;
  const auto add = [&](std::uint32_t node, const Touch& before, const Touch& committed) {
    Change change{{node, before, committed, false}, committed};
    if (const auto found = bounced.find(node); found != bounced.end()) {
      change.contact.bounces = true;
      for (const std::int32_t surface : found->second) add_surface(change.contact.touch, surface);
      change.contact.touch.slides = true;
    }
    if (change.contact.bounces || !(before == committed)) changes.push_back(change);
  };
  for (const auto& [node, before] : now_) {
    const auto found = after.find(node);
    add(node, before, found == after.end() ? Touch{} : found->second);
  }
  for (const auto& [node, touch] : after)
    if (now_.count(node) == 0) add(node, {}, touch);
  for (const auto& [node, surfaces] : bounced)
    if (now_.count(node) == 0 && after.count(node) == 0) add(node, {}, {});
  if (!changes.empty()) changes_[step] = std::move(changes);
  move_to(step);
}

void ContactHistory::set(std::uint32_t node, const Touch& touch) {
  if (touch.surface < 0)
    now_.erase(node);
  else
    now_[node] = touch;
}

void ContactHistory::move_to(std::size_t state) {
  while (state_ < state) {
    const auto found = changes_.find(++state_);
    if (found == changes_.end()) continue;
    for (const Change& each : found->second) set(each.contact.node, each.after);
  }
  while (state_ > state) {
    const auto found = changes_.find(state_--);
    if (found == changes_.end()) continue;
    for (const Change& each : found->second) set(each.contact.node, each.contact.before);
  }
}

const std::map<std::uint32_t, Touch>& ContactHistory::at(std::size_t state) {
  move_to(state);
  return now_;
}

std::vector<StepContact> ContactHistory::within(std::size_t step) {
  move_to(step - 1);
  std::map<std::uint32_t, StepContact> all;
  for (const auto& [node, touch] : now_) all[node] = {node, touch, touch, false};
  if (const auto found = changes_.find(step); found != changes_.end())
    for (const Change& each : found->second) all[each.contact.node] = each.contact;
  std::vector<StepContact> result;
  for (const auto& [node, contact] : all)
    if (contact.touch.surface >= 0) result.push_back(contact);
  return result;
}

}  // namespace springnet::learning
