#include "view/forces.hpp"

#include <algorithm>
#include <map>
#include <unordered_map>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "network/load_course.hpp"
#include "view/pair.hpp"

namespace springnet::view {

namespace {

constexpr double rounding = 1e-12;  // of forces that cancel, relative to their sizes

using OnNodes = std::map<NodeIndex, Vector3>;

OnNodes summed(const std::vector<std::pair<NodeIndex, Vector3>>& forces) {
  OnNodes sums;
  for (const auto& [node, force] : forces) sums.try_emplace(node, Vector3::Zero()).first->second += force;
  return sums;
}

// `count` items, spread evenly.
template <class Item>
std::vector<Item> sample(const std::vector<Item>& all, std::size_t count) {
  std::vector<Item> items;
  for (std::size_t k = 0; k < count; ++k) items.push_back(all[k * all.size() / count]);
  return items;
}

void find_sides(const Network& network, std::vector<DrawnLoad>& loads) {
  std::unordered_multimap<std::uint64_t, SpringIndex> springs;
  if (std::any_of(loads.begin(), loads.end(),
                  [&](const DrawnLoad& each) { return !network.loads()[each.load].faces.empty(); })) {
    for (SpringIndex k = 0; k < network.springs().size(); ++k) {
      springs.emplace(pair_of(network.springs()[k].first, network.springs()[k].second), k);
    }
  }
  for (DrawnLoad& drawn : loads) {
    const std::vector<Face>& faces = network.loads()[drawn.load].faces;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [first, last] = springs.equal_range(pair_of(faces[f][k], faces[f][(k + 1) % 3]));
        for (auto spring = first; spring != last; ++spring) drawn.sides.push_back({f, spring->second});
      }
    }
  }
}

// The force of a load on each of its nodes now, N. The slack in time allows for rounding if a step ends where a load is
// switched on or off.
OnNodes forces_now(const Load& load, const DrawnLoad& drawn, const Simulation& simulation) {
  const double time = simulation.time() + 1e-6 * simulation.time_step();
  const double factor = load.from <= time && time < load.until ? LoadCourse(load).at(simulation.time()) : 0.0;
  std::vector<Vector3> areas = load.areas;
  for (std::size_t f = 0; load.follow && f < areas.size(); ++f) {
    const Vector3 a = simulation.position(load.faces[f][0]);
    areas[f] = 0.5 * (simulation.position(load.faces[f][1]) - a).cross(simulation.position(load.faces[f][2]) - a);
  }
  for (const DrawnLoad::Side& side : drawn.sides) {
    if (!simulation.alive(side.spring)) areas[side.face].setZero();
  }
  OnNodes sums = summed(springnet::forces_of(load, areas));
  for (auto& [node, force] : sums) force *= factor;
  return sums;
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
    std::size_t all;               // nodes that it acts on
    std::vector<NodeIndex> nodes;  // those that are shown
  };
  std::vector<Candidate> candidates;
  std::size_t shown = 0;
  for (std::size_t k = 0; k < network.loads().size(); ++k) {
    const Load& load = network.loads()[k];
    Candidate candidate{k, 0, {}};
    for (const auto& [node, force] : summed(springnet::forces_of(load))) {
      if (force.isZero(0.0)) continue;
      ++candidate.all;
      if (selection.node_place[node] != not_shown) candidate.nodes.push_back(node);
    }
    forces.all += candidate.all;
    shown += candidate.nodes.size();
    if (!candidate.nodes.empty()) candidates.push_back(std::move(candidate));
  }
  const std::size_t loads = candidates.size();
  if (loads > max_arrows) {
    candidates = sample(candidates, max_arrows);
    forces.notes.push_back(fmt::format("{} of {} loads are drawn as arrows", max_arrows, loads));
  }
  for (const Candidate& candidate : candidates) {
    // Each load keeps its share of the arrows, one at least.
    const std::size_t all = candidate.nodes.size();
    const std::size_t count = shown > max_arrows ? std::max<std::size_t>(all * max_arrows / shown, 1) : all;
    for (const NodeIndex node : sample(candidate.nodes, count))
      forces.arrows.push_back({forces.loads.size(), selection.node_place[node], node});
    forces.loads.push_back({candidate.load, candidate.all, count});
  }
  find_sides(network, forces.loads);
  if (forces.arrows.size() < forces.all) {
    forces.notes.push_back(fmt::format("arrows at nodes show {} of {} forces; resultants include all forces of a load",
                                       forces.arrows.size(), forces.all));
  }
  return forces;
}

void take_forces(const Forces& forces, const Network& network, const Simulation& simulation,
                 std::span<float> resultants, std::span<float> arrows) {
  std::size_t arrow = 0;
  for (std::size_t k = 0; k < forces.loads.size(); ++k) {
    const Load& load = network.loads()[forces.loads[k].load];
    const OnNodes on_nodes = forces_now(load, forces.loads[k], simulation);
    Vector3 sum = Vector3::Zero();
    double size = 0.0;
    for (const auto& [node, force] : on_nodes) {
      sum += force;
      size += force.norm();
    }
    write(sum.norm() > rounding * size ? sum : Vector3::Zero(), resultants, k);
    for (const std::size_t last = arrow + forces.loads[k].arrows; arrow < last; ++arrow)
      write(on_nodes.at(forces.arrows[arrow].user), arrows, arrow);
  }
}

}  // namespace springnet::view
