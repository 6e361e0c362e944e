#include "layers/linear/spring_order.hpp"

#include <numeric>

namespace springnet::layers {

bool SpringOrder::follow() {
  if (laid_out_ == layout_.revision()) return false;
  laid_out_.reset();  // memory may run out below
  const std::vector<Unit>& units = layout_.units();
  units_.clear();
  units_.resize(units.size());
  // what(unit, part of it, its node, the other node, slot of the unit that has the spring; that unit)
  const auto for_each_end = [&](const auto& what) {
    for (std::size_t u = 0; u < units.size(); ++u) {
      for (const Segment& segment : units[u].segments) {
        for (std::uint32_t slot = segment.begin; slot < segment.begin + segment.count; ++slot) {
          const std::uint32_t s = units[u].spring[slot];
          if (s == no_spring) continue;
          const auto [own, other] = ends_in(u, segment, s);
          const bool is_within = other >= units[u].first_node && other < units[u].end_node();
          what(u, is_within ? units_[u].within : units_[u].leaving, own, other, slot, u);
          if (!is_within && segment.access != Access::far)  // far ones are in the other unit by themselves
            what(u + 1, units_[u + 1].leaving, other, own, slot, u);
        }
      }
    }
  };
  using Part = SpringsOfUnit::Part;
  for (std::size_t u = 0; u < units.size(); ++u)
    for (Part* part : {&units_[u].within, &units_[u].leaving})
      part->start.assign(units[u].node_count + std::size_t{1}, 0);
  for_each_end([&](std::size_t u, Part& part, std::uint32_t own, std::uint32_t, std::uint32_t, std::size_t) {
    ++part.start[own - units[u].first_node + 1];
  });
  std::vector<std::vector<std::uint32_t>> next(2 * units.size());
  for (std::size_t u = 0; u < units.size(); ++u) {
    units_[u].place.assign(units[u].spring.size(), 0);
    for (Part* part : {&units_[u].within, &units_[u].leaving}) {
      std::partial_sum(part->start.begin(), part->start.end(), part->start.begin());
      part->second.resize(part->start.back());
      next[2 * u + (part == &units_[u].leaving ? 1 : 0)] = part->start;
    }
  }
  for_each_end(
      [&](std::size_t u, Part& part, std::uint32_t own, std::uint32_t other, std::uint32_t slot, std::size_t of) {
        std::uint32_t& place = next[2 * u + (&part == &units_[u].leaving ? 1 : 0)][own - units[u].first_node];
        part.second[place] = other;
        const auto within = static_cast<std::uint32_t>(units_[of].within.second.size());
        if (of == u)
          units_[u].place[slot] = place + (&part == &units_[u].leaving ? within : 0);
        else
          units_[u].incoming.push_back({place, units_[of].place[slot] - within});
        ++place;
      });
  laid_out_ = layout_.revision();
  return true;
}

std::pair<std::uint32_t, std::uint32_t> SpringOrder::ends_in(std::size_t unit, const Segment& segment,
                                                             std::uint32_t spring) const {
  const std::uint32_t a = layout_.first(spring), b = layout_.second(spring);
  const bool is_first = segment.access == Access::far ? layout_.unit_of(a) == unit : a < b;
  return is_first ? std::pair(a, b) : std::pair(b, a);
}

}  // namespace springnet::layers
