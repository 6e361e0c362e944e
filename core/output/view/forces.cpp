#include "output/view/forces.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace springnet::view {

namespace {

std::vector<std::uint32_t> shown_nodes(const Load& load, const Selection& selection) {
  std::vector<std::uint32_t> shown;
  for (const NodeIndex node : load.nodes) {
    if (selection.node_place[node] != not_shown) shown.push_back(selection.node_place[node]);
  }
  return shown;
}

// `count` of them, spread evenly.
template <class Item>
std::vector<Item> some_of(const std::vector<Item>& all, std::size_t count) {
  std::vector<Item> some;
  for (std::size_t k = 0; k < count; ++k) some.push_back(all[k * all.size() / count]);
  return some;
}

// What a load puts on each of its nodes at that time, N. Steps end where a load is switched up to rounding of the time.
Vector3 force_at(const Load& load, const Simulation& simulation) {
  const double time = simulation.time() + 1e-6 * simulation.time_step();
  return load.from <= time && time < load.until ? load.force : Vector3::Zero();
}

void write(const Vector3& force, std::span<float> row, std::size_t place) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    row[3 * place + axis] = static_cast<float>(force[static_cast<Eigen::Index>(axis)]);
  }
}

}  // namespace

Forces forces_of(const Network& network, const Selection& selection) {
  Forces forces;
  struct Candidate {
    std::size_t load;
    std::vector<std::uint32_t> nodes;
  };
  std::vector<Candidate> candidates;
  std::size_t shown = 0;
  for (std::size_t k = 0; k < network.loads().size(); ++k) {
    const Load& load = network.loads()[k];
    if (load.force.isZero(0.0)) continue;
    forces.all += load.nodes.size();
    Candidate candidate{k, shown_nodes(load, selection)};
    shown += candidate.nodes.size();
    if (!candidate.nodes.empty()) candidates.push_back(std::move(candidate));
  }
  const std::size_t loads = candidates.size();
  if (loads > most_arrows) {
    candidates = some_of(candidates, most_arrows);
    forces.notes.push_back(fmt::format("{} of {} loads are drawn as arrows", most_arrows, loads));
  }
  for (const Candidate& candidate : candidates) {
    // Each load keeps its share of the arrows, one at least.
    const std::size_t all = candidate.nodes.size();
    const std::size_t count = shown > most_arrows ? std::max<std::size_t>(all * most_arrows / shown, 1) : all;
    for (const std::uint32_t node : some_of(candidate.nodes, count))
      forces.arrows.push_back({forces.loads.size(), node});
    forces.loads.push_back({candidate.load, count});
  }
  if (forces.arrows.size() < forces.all) {
    forces.notes.push_back(fmt::format("arrows at nodes show {} of {} forces; resultants count all forces of a load",
                                       forces.arrows.size(), forces.all));
  }
  return forces;
}

void take_forces(const Forces& forces, const Network& network, const Simulation& simulation,
                 std::span<float> resultants, std::span<float> arrows) {
  std::size_t arrow = 0;
  for (std::size_t k = 0; k < forces.loads.size(); ++k) {
    const Load& load = network.loads()[forces.loads[k].load];
    const Vector3 force = force_at(load, simulation);
    write(static_cast<double>(load.nodes.size()) * force, resultants, k);
    for (std::size_t last = arrow + forces.loads[k].arrows; arrow < last; ++arrow) write(force, arrows, arrow);
  }
}

}  // namespace springnet::view
