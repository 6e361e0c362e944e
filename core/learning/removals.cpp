#include "learning/removals.hpp"

#include <algorithm>
#include <utility>

namespace springnet::learning {

Removals::Removals(Engine& engine) : engine_(engine) {
  const layers::Layout& layout = engine.model().layout;
  for (std::uint32_t s = 0; s < layout.spring_count(); ++s)
    if (!layout.alive(s)) at_start_.springs.push_back(s);
  for (std::uint32_t e = 0; e < layout.elements().count(); ++e)
    if (!layout.elements().alive(e)) at_start_.elements.push_back(e);
  for (std::size_t f = 0; f < layout.loaded_faces().count(); ++f)
    if (!layout.loaded_faces().alive(f)) at_start_.faces.push_back(f);
}

void Removals::begin(std::size_t events) {
  set_for_step(0);
  events_.clear();
  states_.clear();
  taken_ = events;
}

// Where a step begins what has no margin left breaks before the step, as after a change of parameters: at the state
// before.
const Event* Removals::take(const std::vector<Event>& events, std::size_t state, double time,
                            const std::function<std::size_t(const Event&)>& of) {
  const Event* jammed = nullptr;
  std::vector<std::pair<std::size_t, Event>> taken;
  for (; taken_ < events.size(); ++taken_) {
    const Event& each = events[taken_];
    if (each.kind != Event::Kind::cut && each.kind != Event::Kind::ruptured) {
      if (jammed == nullptr && each.kind == Event::Kind::jammed) jammed = &each;
      continue;
    }
    taken.emplace_back(each.time < time ? state - 1 : of ? of(each) : state, each);
  }
  std::stable_sort(taken.begin(), taken.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [at, event] : taken) {
    events_.push_back(event);
    states_.push_back(at);
  }
  return jammed;
}

void Removals::begin_at_last() { std::fill(states_.begin(), states_.end(), std::size_t{0}); }

bool Removals::any_at(std::size_t state) const { return std::binary_search(states_.begin(), states_.end(), state); }

void Removals::set_for_step(std::size_t until) {
  const auto count =
      static_cast<std::size_t>(std::lower_bound(states_.begin(), states_.end(), until) - states_.begin());
  if (count == applied_) return;
  Topology::Removal removed = at_start_;
  for (std::size_t i = 0; i < count; ++i)
    (events_[i].element ? removed.elements : removed.springs).push_back(events_[i].index);
  engine_.topology().put_back_all_but(removed);
  for (Engine* const each : followers_) each->topology().put_back_all_but(removed);
  applied_ = count;
}

}  // namespace springnet::learning
