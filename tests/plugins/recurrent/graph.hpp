// A network as the host shows it to an integrator, without a host.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <springnet/sdk/plugin.h>

namespace springnet::testing {

// Nodes in the engine's numbers, neighbours sorted by the user's.
struct Graph {
  std::vector<double> mass, force[3];
  std::vector<std::uint8_t> fixed, held;
  std::vector<std::uint32_t> cluster;
  std::vector<std::uint32_t> user_number, neighbour_start, neighbours;
  springnet_network network{};

  // users[k]: the user's number of node k; edges in the engine's numbers.
  Graph(std::vector<std::uint32_t> users, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges)
      : mass(users.size(), 1.0),
        fixed(users.size(), 0),
        held(users.size(), 0),
        cluster(users.size(), 0xffffffffu),
        user_number(std::move(users)) {
    const auto count = static_cast<std::uint32_t>(user_number.size());
    for (auto& component : force) component.assign(count, 0.0);
    neighbour_start.push_back(0);
    for (std::uint32_t k = 0; k < count; ++k) {
      for (const auto& [a, b] : edges) {
        if (a == k) neighbours.push_back(b);
        if (b == k) neighbours.push_back(a);
      }
      std::sort(neighbours.begin() + neighbour_start.back(), neighbours.end(),
                [&](std::uint32_t a, std::uint32_t b) { return user_number[a] < user_number[b]; });
      neighbour_start.push_back(static_cast<std::uint32_t>(neighbours.size()));
    }
    network.struct_size = sizeof network;
    network.node_count = count;
    network.mass = mass.data();
    network.fixed = fixed.data();
    network.held = held.data();
    network.cluster = cluster.data();
    network.user_number = user_number.data();
    network.neighbour_start = neighbour_start.data();
    network.neighbours = neighbours.data();
    // Each has other connections than the ones before.
    static std::uint64_t graphs = 0;
    network.connection_revision = ++graphs;
  }
  [[nodiscard]] springnet_const_vectors forces() const { return {force[0].data(), force[1].data(), force[2].data()}; }
};

}  // namespace springnet::testing
