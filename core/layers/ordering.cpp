#include "layers/ordering.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/graph/cuthill_mckee_ordering.hpp>
#include <numeric>

#include <springnet/sdk/math.hpp>

namespace springnet::layers {
namespace {

using Nodes = std::vector<std::uint32_t>;

std::uint32_t distance(std::uint32_t a, std::uint32_t b) noexcept { return a < b ? b - a : a - b; }

// Sum over springs of the distance between their ends' numbers; null: the user's.
std::uint64_t spread(const Network& network, const Nodes* number) {
  std::uint64_t sum = 0;
  for (const Spring& s : network.springs())
    sum += number == nullptr ? distance(s.first, s.second) : distance((*number)[s.first], (*number)[s.second]);
  return sum;
}

// Whether joined nodes are as close as in a compact body numbered layer by layer, where they are a layer apart.
// Boundary layers are up to twice as large in bodies that are not cubes.
bool is_compact(const Network& network) {
  const double side = sdk::cbrt(static_cast<double>(network.nodes().size()));
  return static_cast<double>(spread(network, nullptr)) <=
         2.0 * side * side * static_cast<double>(network.springs().size());
}

// The user's nodes by reverse Cuthill-McKee.
Nodes cuthill_mckee(const Network& network) {
  // Each spring from both ends, by the first one: a graph in a few arrays.
  using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                                   boost::no_property, std::uint32_t, std::uint64_t>;
  const std::size_t nodes = network.nodes().size();
  std::vector<std::uint64_t> next(nodes + 1, 0);
  for (const Spring& spring : network.springs()) {
    ++next[spring.first + std::size_t{1}];
    ++next[spring.second + std::size_t{1}];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges(next.back());
  for (const Spring& spring : network.springs()) {
    edges[next[spring.first]++] = {spring.first, spring.second};
    edges[next[spring.second]++] = {spring.second, spring.first};
  }
  const Graph graph(boost::edges_are_sorted, edges.begin(), edges.end(), static_cast<std::uint32_t>(nodes));
  edges = {};
  Nodes order(nodes);
  std::vector<boost::default_color_type> colour(nodes);
  boost::cuthill_mckee_ordering(
      graph, order.rbegin(), boost::make_iterator_property_map(colour.begin(), boost::get(boost::vertex_index, graph)),
      boost::make_out_degree_map(graph));
  return order;
}

Nodes inverse(const Nodes& order) {
  Nodes place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<std::uint32_t>(k);
  return place;
}

// A distance that 99 % of the springs do not exceed, to an eighth.
std::uint32_t common_distance(const Network& network, const Nodes& number) {
  std::array<std::uint64_t, 33 * 8> count{};
  const auto bucket = [](std::uint32_t d) {
    const auto width = static_cast<std::uint32_t>(std::bit_width(d));
    return width <= 3 ? d : 8 * width + ((d >> (width - 4)) & 7u);
  };
  for (const Spring& s : network.springs()) ++count[bucket(distance(number[s.first], number[s.second]))];
  std::uint64_t within = 0;
  for (std::uint32_t i = 0; i < count.size(); ++i) {
    within += count[i];
    if (within < network.springs().size() - network.springs().size() / 100) continue;
    if (i < 8) return i;
    const std::uint32_t width = i / 8;
    return static_cast<std::uint32_t>(((std::uint64_t{8} + i % 8 + 1) << (width - 4)) - 1);
  }
  return 0;
}

std::uint32_t unit_nodes(const Network& network, const Nodes& number) {
  // Springs across a boundary cost a little more, so their layer is at most half of a unit; but not so few units that
  // threads find no work.
  constexpr std::uint32_t fewest_units = 8;
  const auto count = static_cast<std::uint32_t>(network.nodes().size());
  const std::uint64_t wanted = 2 * std::uint64_t{common_distance(network, number)};
  const std::uint64_t most = std::max(least_unit, count / fewest_units);
  const std::uint64_t size = std::clamp<std::uint64_t>(wanted, least_unit, most);
  return static_cast<std::uint32_t>((size + tile_nodes - 1) / tile_nodes * tile_nodes);
}

}  // namespace

Ordering order_nodes(const Network& network, bool renumber) {
  const std::size_t count = network.nodes().size();
  Ordering ordering;
  ordering.user.resize(count);
  std::iota(ordering.user.begin(), ordering.user.end(), 0u);
  ordering.engine = ordering.user;
  if (renumber && !is_compact(network)) {
    Nodes order = cuthill_mckee(network), place = inverse(order);
    if (2 * spread(network, &place) <= spread(network, nullptr)) {
      ordering.user = std::move(order);
      ordering.engine = std::move(place);
    }
  }
  const std::uint32_t size = unit_nodes(network, ordering.engine);
  for (std::size_t begin = 0; begin < count; begin += size)
    ordering.unit_start.push_back(static_cast<std::uint32_t>(begin));
  if (ordering.unit_start.empty()) ordering.unit_start.push_back(0);
  ordering.unit_start.push_back(static_cast<std::uint32_t>(count));
  return ordering;
}

}  // namespace springnet::layers
