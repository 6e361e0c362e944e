#include "output/view/forces.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace springnet::view {

namespace {

std::vector<Force> forces_on_shown(const Network& network, const Selection& selection) {
  std::vector<Force> forces;
  for (const Load& load : network.loads()) {
    if (load.force.isZero(0.0)) continue;
    for (const NodeIndex node : load.nodes) {
      const std::uint32_t place = selection.node_place[node];
      if (place != not_shown) forces.push_back({place, load.force, load.from, load.until});
    }
  }
  return forces;
}

}  // namespace

Forces forces_of(const Network& network, const Selection& selection) {
  Forces forces;
  for (const Load& load : network.loads()) {
    if (!load.force.isZero(0.0)) forces.all += load.nodes.size();
  }
  forces.drawn = forces_on_shown(network, selection);
  const std::size_t shown = forces.drawn.size();
  if (shown > most_arrows) {
    std::vector<Force> some;
    for (std::size_t k = 0; k < most_arrows; ++k) some.push_back(forces.drawn[k * shown / most_arrows]);
    forces.drawn = std::move(some);
  }
  if (forces.drawn.size() < forces.all) {
    forces.notes.push_back(fmt::format("{} of {} forces are drawn as arrows", forces.drawn.size(), forces.all));
  }
  return forces;
}

}  // namespace springnet::view
