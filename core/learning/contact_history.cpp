#include "learning/contact_history.hpp"

#include <algorithm>
#include <utility>

namespace springnet::learning {

namespace {

Touches contacts_of(const Simulation& simulation) {
  Touches result;
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

Touch touch_of(const Touches& touches, std::uint32_t node) {
  const auto found = touches.find(node);
  return found == touches.end() ? Touch{} : found->second;
}

std::optional<std::uint32_t> differing_node(const Touches& one, const Touches& other) {
  std::optional<std::uint32_t> first;
  for (const auto& [these, those] : {std::pair(&one, &other), std::pair(&other, &one)})
    for (const auto& [node, touch] : *these)
      if (!(touch_of(*those, node) == touch) && (!first || node < *first)) first = node;
  return first;
}

Touches contacts_of(const Contact& contact, std::uint32_t nodes) {
  Touches result;
  for (std::uint32_t k = 0; k < nodes; ++k)
    if (contact.fixed()[k] == 0 && contact.committed(k).surface >= 0) result[k] = contact.committed(k);
  return result;
}

void ContactHistory::begin(const Simulation& simulation) {
  now_ = contacts_of(simulation);
  state_ = 0;
  changes_.clear();
  slips_.clear();
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
  const Touches after = contacts_of(simulation);
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

// Contacts may have been settled where the step began, as after a cut.
void ContactHistory::keep(const Simulation& simulation, std::size_t step, const Touches& within) {
  events_ = simulation.events().size();
  move_to(step - 1);
  Touches all = now_;
  all.insert(within.begin(), within.end());
  for (const auto& [node, unused] : all) {
    const Touch before = touch_of(now_, node), touch = touch_of(within, node);
    if (before == touch) continue;
    if (step > 1) {
      std::vector<Change>& known = changes_[step - 1];
      const auto own =
          std::find_if(known.begin(), known.end(), [k = node](const Change& each) { return each.contact.node == k; });
      if (own != known.end())
        own->after = touch;
      else
        known.push_back({{node, before, before, false}, touch});
    }
    set(node, touch);
  }
  move_to(step);
}

void ContactHistory::change(std::size_t step, std::uint32_t node, const Touch& after) {
  move_to(step);
  const Touch before = touch_of(now_, node);
  if (before == after) return;
  changes_[step].push_back({{node, before, before, false}, after});
  set(node, after);
}

void ContactHistory::set_slips(std::size_t state, std::vector<Slipping> slips) {
  if (!slips.empty()) slips_[state] = std::move(slips);
}

const std::vector<Slipping>& ContactHistory::slips_at(std::size_t state) const {
  static const std::vector<Slipping> none;
  const auto found = slips_.find(state);
  return found == slips_.end() ? none : found->second;
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

const Touches& ContactHistory::at(std::size_t state) {
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
