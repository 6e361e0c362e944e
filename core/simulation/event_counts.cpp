#include <springnet/events.hpp>

namespace springnet {

EventCounts count_events(const Simulation& simulation) {
  EventCounts counts;
  for (const Event& event : simulation.events()) {
    if (event.element) {
      ++counts.elements_removed;
      continue;
    }
    switch (event.kind) {
      case Event::Kind::cut:
        ++counts.cut;
        break;
      case Event::Kind::ruptured:
        ++counts.ruptured;
        break;
      case Event::Kind::touched:
        ++counts.touched;
        break;
      case Event::Kind::released:
        ++counts.released;
        break;
      case Event::Kind::slipped:
        ++counts.slipped;
        break;
      case Event::Kind::stuck:
        ++counts.stuck;
        break;
      case Event::Kind::jammed:
        ++counts.jammed;
        break;
      case Event::Kind::met:
        ++counts.met;
        break;
      case Event::Kind::parted:
        ++counts.parted;
        break;
    }
  }
  return counts;
}

}  // namespace springnet
