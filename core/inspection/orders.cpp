#include "inspection/orders.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace springnet {

namespace {

constexpr std::uint32_t none = 0xffffffffu;

// Breadth first from `start`, appended to `order`.
void spread(const Joints& joints, NodeIndex start, std::vector<bool>& reached, std::vector<NodeIndex>& order) {
  std::size_t next = order.size();
  order.push_back(start);
  reached[start] = true;
  for (; next < order.size(); ++next) {
    for (const Joint& joint : joints.of(order[next])) {
      if (reached[joint.other]) continue;
      reached[joint.other] = true;
      order.push_back(joint.other);
    }
  }
}

}  // namespace

namespace {

// Pairs of nodes, both ways, that elements and following pressures join: of an enclosed volume the sides of its
// triangles.
std::vector<std::pair<NodeIndex, NodeIndex>> joined_by_elements(const Network& network) {
  std::vector<std::pair<NodeIndex, NodeIndex>> pairs;
  for (const Element& element : network.elements()) {
    const std::size_t corners = element.invariant == Invariant::enclosed_volume ? 3 : element.nodes.size();
    for (std::size_t begin = 0; begin < element.nodes.size(); begin += corners)
      for (std::size_t i = begin; i < begin + corners; ++i)
        for (std::size_t j = begin; j < begin + corners; ++j)
          if (i != j) pairs.emplace_back(element.nodes[i], element.nodes[j]);
  }
  for (const Load& load : network.loads()) {
    if (!load.follow || load.pressure == 0.0) continue;
    for (const Face& face : load.faces)
      for (const NodeIndex from : face)
        for (const NodeIndex to : face)
          if (from != to) pairs.emplace_back(from, to);
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace

Joints::Joints(const Network& network) : start_(network.nodes().size() + 1) {
  const std::vector<std::pair<NodeIndex, NodeIndex>> elements = joined_by_elements(network);
  for (const auto& [from, to] : elements) ++start_[from + 1];
  for (const Spring& spring : network.springs()) ++start_[spring.first + 1], ++start_[spring.second + 1];
  for (const Rigid& rigid : network.rigids()) ++start_[rigid.first + 1], ++start_[rigid.second + 1];
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  joints_.resize(start_.back());
  std::vector<std::size_t> at(start_.begin(), start_.end() - 1);
  for (SpringIndex s = 0; s < network.springs().size(); ++s) {
    const Spring& spring = network.springs()[s];
    joints_[at[spring.first]++] = {spring.second, s};
    joints_[at[spring.second]++] = {spring.first, s};
  }
  for (const Rigid& rigid : network.rigids()) {
    joints_[at[rigid.first]++] = {rigid.second, no_spring};
    joints_[at[rigid.second]++] = {rigid.first, no_spring};
  }
  for (const auto& [from, to] : elements) joints_[at[from]++] = {to, no_spring};
  for (std::size_t k = 0; k + 1 < start_.size(); ++k) {
    std::stable_sort(joints_.begin() + static_cast<std::ptrdiff_t>(start_[k]),
                     joints_.begin() + static_cast<std::ptrdiff_t>(start_[k + 1]),
                     [](const Joint& a, const Joint& b) { return a.other < b.other; });
  }
}

std::vector<std::uint32_t> rigid_clusters(const Network& network) {
  std::vector<std::uint32_t> cluster(network.nodes().size(), no_cluster);
  if (network.rigids().empty()) return cluster;
  std::vector<std::vector<NodeIndex>> neighbours(network.nodes().size());
  for (const Rigid& rigid : network.rigids()) {
    neighbours[rigid.first].push_back(rigid.second);
    neighbours[rigid.second].push_back(rigid.first);
  }
  std::uint32_t count = 0;
  std::vector<NodeIndex> front;
  for (NodeIndex node = 0; node < cluster.size(); ++node) {
    if (neighbours[node].empty() || cluster[node] != no_cluster) continue;
    cluster[node] = count;
    front.assign(1, node);
    while (!front.empty()) {
      const NodeIndex next = front.back();
      front.pop_back();
      for (const NodeIndex other : neighbours[next]) {
        if (cluster[other] != no_cluster) continue;
        cluster[other] = count;
        front.push_back(other);
      }
    }
    ++count;
  }
  return cluster;
}

std::vector<NodeIndex> wave_order(const Joints& joints, const std::vector<LinearNode>& nodes) {
  const auto count = static_cast<NodeIndex>(nodes.size());
  // The wave starts at the first of these that is not reached yet.
  std::vector<NodeIndex> strongest(count);
  std::iota(strongest.begin(), strongest.end(), 0u);
  std::stable_sort(strongest.begin(), strongest.end(), [&](NodeIndex a, NodeIndex b) {
    if (nodes[a].free != nodes[b].free) return nodes[a].free;
    return nodes[a].force.squaredNorm() > nodes[b].force.squaredNorm();
  });
  std::vector<bool> reached(count);
  std::vector<NodeIndex> order;
  order.reserve(count);
  for (const NodeIndex node : strongest) {
    if (!reached[node]) spread(joints, node, reached, order);
  }
  return order;
}

std::vector<NodeIndex> colour_order(const Joints& joints, const std::vector<std::uint32_t>& clusters) {
  const auto count = static_cast<NodeIndex>(joints.node_count());
  // What gets a colour: nodes by themselves, and clusters.
  std::vector<std::vector<NodeIndex>> members;
  for (NodeIndex node = 0; node < count; ++node) {
    if (clusters[node] == no_cluster) continue;
    if (clusters[node] >= members.size()) members.resize(clusters[node] + 1);
    members[clusters[node]].push_back(node);
  }
  std::vector<std::uint32_t> colour(count, none);
  std::vector<bool> taken;
  std::uint32_t colours = 0;
  for (NodeIndex node = 0; node < count; ++node) {
    if (colour[node] != none) continue;
    const NodeIndex alone[] = {node};
    const std::span<const NodeIndex> set = clusters[node] == no_cluster
                                               ? std::span<const NodeIndex>(alone)
                                               : std::span<const NodeIndex>(members[clusters[node]]);
    taken.assign(colours + 1, false);
    for (const NodeIndex member : set) {
      for (const Joint& joint : joints.of(member)) {
        if (colour[joint.other] != none) taken[colour[joint.other]] = true;
      }
    }
    const auto first = static_cast<std::uint32_t>(std::find(taken.begin(), taken.end(), false) - taken.begin());
    colours = std::max(colours, first + 1);
    for (const NodeIndex member : set) colour[member] = first;
  }
  std::vector<NodeIndex> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](NodeIndex a, NodeIndex b) { return colour[a] < colour[b]; });
  return order;
}

}  // namespace springnet
