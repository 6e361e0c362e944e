#include "layers/ordering.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/cuthill_mckee_ordering.hpp>
#include <numeric>

namespace springnet::layers {
namespace {

using Nodes = std::vector<std::uint32_t>;

// Halves [begin, end) of `nodes` along the longest side of their bounding box until the parts have at most max_unit.
// Ties are broken by the user's number, so that the result depends on the network alone.
void bisect(const Network& network, Nodes& nodes, std::size_t begin, std::size_t end,
            std::vector<std::uint32_t>& starts) {
  if (end - begin <= max_unit) {
    starts.push_back(static_cast<std::uint32_t>(begin));
    return;
  }
  const NodeList& all = network.nodes();
  Eigen::AlignedBox3d box;
  for (std::size_t i = begin; i < end; ++i) box.extend(all[nodes[i]].position);
  // Of equal sides the last: lattices number their nodes along x first, and long rows along x make long runs.
  const Vector3 sides = box.sizes();
  Eigen::Index axis = 2;
  for (const Eigen::Index other : {1, 0})
    if (sides[other] > sides[axis] * (1.0 + 1e-9)) axis = other;
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::size_t i) { return nodes.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
    const double pa = all[a].position[axis], pb = all[b].position[axis];
    return pa < pb || (pa == pb && a < b);
  });
  bisect(network, nodes, begin, middle, starts);
  bisect(network, nodes, middle, end, starts);
}

// Pairs of nodes joined within a unit, numbered from its start.
std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_of_unit(const Network& network,
                                                                   const std::vector<std::uint32_t>& springs,
                                                                   const Nodes& place, std::uint32_t begin) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(springs.size());
  for (const std::uint32_t s : springs) {
    const Spring& spring = network.springs()[s];
    edges.emplace_back(place[spring.first] - begin, place[spring.second] - begin);
  }
  return edges;
}

void improve_unit(std::vector<std::uint32_t>::iterator begin, std::size_t count,
                  const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges) {
  const auto distance = [](std::uint32_t a, std::uint32_t b) { return a < b ? b - a : a - b; };
  using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS,
                                      boost::property<boost::vertex_color_t, boost::default_color_type>>;
  Graph graph(edges.begin(), edges.end(), count);
  std::vector<std::size_t> order(count);
  boost::cuthill_mckee_ordering(graph, order.rbegin(), boost::get(boost::vertex_color, graph),
                                boost::make_degree_map(graph));
  std::vector<std::uint32_t> place(count);
  for (std::size_t i = 0; i < count; ++i) place[order[i]] = static_cast<std::uint32_t>(i);
  std::uint64_t spread = 0, new_spread = 0;
  for (const auto& [a, b] : edges) {
    spread += distance(a, b);
    new_spread += distance(place[a], place[b]);
  }
  if (2 * new_spread > spread) return;
  const std::vector<std::uint32_t> old(begin, begin + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 0; i < count; ++i) *(begin + static_cast<std::ptrdiff_t>(i)) = old[order[i]];
}

}  // namespace

Ordering order_nodes(const Network& network, bool renumber) {
  const std::size_t count = network.nodes().size();
  Ordering ordering;
  ordering.user.resize(count);
  ordering.engine.resize(count);
  std::iota(ordering.user.begin(), ordering.user.end(), 0u);
  if (!renumber) {
    for (std::size_t begin = 0; begin < count; begin += max_unit)
      ordering.unit_start.push_back(static_cast<std::uint32_t>(begin));
  } else {
    bisect(network, ordering.user, 0, count, ordering.unit_start);
  }
  ordering.unit_start.push_back(static_cast<std::uint32_t>(count));

  const auto number = [&] {
    for (std::size_t k = 0; k < count; ++k) ordering.engine[ordering.user[k]] = static_cast<std::uint32_t>(k);
  };
  if (renumber) {
    const std::size_t units = ordering.unit_start.size() - 1;
    std::vector<std::uint32_t> unit_of(count);
    for (std::size_t u = 0; u < units; ++u) {
      const auto begin = ordering.user.begin() + ordering.unit_start[u];
      const auto end = ordering.user.begin() + ordering.unit_start[u + 1];
      std::sort(begin, end);
      for (auto i = begin; i != end; ++i) unit_of[*i] = static_cast<std::uint32_t>(u);
    }
    number();
    std::vector<std::vector<std::uint32_t>> springs_of(units);
    for (std::size_t s = 0; s < network.springs().size(); ++s) {
      const Spring& spring = network.springs()[s];
      if (unit_of[spring.first] == unit_of[spring.second])
        springs_of[unit_of[spring.first]].push_back(static_cast<std::uint32_t>(s));
    }
    for (std::size_t u = 0; u < units; ++u) {
      const std::uint32_t begin = ordering.unit_start[u];
      improve_unit(ordering.user.begin() + begin, ordering.unit_start[u + 1] - begin,
                   edges_of_unit(network, springs_of[u], ordering.engine, begin));
    }
  }
  number();
  return ordering;
}

}  // namespace springnet::layers
