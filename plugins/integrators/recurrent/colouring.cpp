#include "colouring.hpp"

#include <algorithm>
#include <numeric>

namespace springnet::recurrent {
namespace {

constexpr std::uint32_t none = 0xffffffffu;

}  // namespace

void Colouring::attach(const springnet_network& network) {
  const std::uint32_t count = network.node_count;
  std::vector<std::uint32_t> by_user(count);
  for (std::uint32_t k = 0; k < count; ++k) by_user[network.user_number[k]] = k;
  // Units that get a colour: a cluster, or a single node. Members of a unit are consecutive.
  std::vector<std::uint32_t> unit_of(count, none), members, unit_start{0};
  members.reserve(count);
  std::vector<std::vector<std::uint32_t>> clusters;
  std::vector<std::uint32_t> cluster_number;  // by network.cluster
  for (const std::uint32_t k : by_user) {
    const std::uint32_t c = network.cluster[k];
    if (c == none) continue;
    if (c >= cluster_number.size()) cluster_number.resize(std::size_t{c} + 1, none);
    if (cluster_number[c] == none) {
      cluster_number[c] = static_cast<std::uint32_t>(clusters.size());
      clusters.emplace_back();
    }
    clusters[cluster_number[c]].push_back(k);
  }
  for (const std::uint32_t k : by_user) {
    if (unit_of[k] != none) continue;
    const auto unit = static_cast<std::uint32_t>(unit_start.size() - 1);
    const auto add = [&](std::uint32_t node) {
      unit_of[node] = unit;
      members.push_back(node);
    };
    if (network.cluster[k] == none) {
      add(k);
    } else {
      for (const std::uint32_t node : clusters[cluster_number[network.cluster[k]]]) add(node);
    }
    unit_start.push_back(static_cast<std::uint32_t>(members.size()));
  }

  const std::size_t units = unit_start.size() - 1;
  std::vector<std::uint32_t> colour(units, none);
  std::vector<std::uint32_t> taken;  // [colour] the unit that takes it
  for (std::uint32_t unit = 0; unit < units; ++unit) {
    for (std::uint32_t i = unit_start[unit]; i < unit_start[unit + 1]; ++i) {
      const std::uint32_t k = members[i];
      for (std::uint32_t j = network.neighbour_start[k]; j < network.neighbour_start[k + 1]; ++j) {
        const std::uint32_t other = colour[unit_of[network.neighbours[j]]];
        if (other != none) taken[other] = unit;
      }
    }
    std::uint32_t free = 0;
    while (free < taken.size() && taken[free] == unit) ++free;
    if (free == taken.size()) taken.push_back(none);
    colour[unit] = free;
  }

  set_start_.assign(taken.size() + 1, 0);
  for (std::uint32_t unit = 0; unit < units; ++unit)
    set_start_[colour[unit] + 1] += unit_start[unit + 1] - unit_start[unit];
  std::partial_sum(set_start_.begin(), set_start_.end(), set_start_.begin());
  order_.resize(count);
  std::vector<std::uint32_t> next(set_start_.begin(), set_start_.end() - 1);
  for (std::uint32_t unit = 0; unit < units; ++unit) {
    for (std::uint32_t i = unit_start[unit]; i < unit_start[unit + 1]; ++i) order_[next[colour[unit]]++] = members[i];
  }
  for (std::size_t c = 0; c < taken.size(); ++c)
    std::sort(order_.begin() + set_start_[c], order_.begin() + set_start_[c + 1]);
}

}  // namespace springnet::recurrent
