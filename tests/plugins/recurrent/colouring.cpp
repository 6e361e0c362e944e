#include "colouring.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "graph.hpp"

namespace {

using springnet::recurrent::Colouring;
using springnet::testing::Graph;

// Each node once, rising within a colour, and no two of a colour joined unless they are of one cluster; clusters whole.
void check(const Graph& graph, const Colouring& colouring) {
  const springnet_network& network = graph.network;
  const std::vector<std::uint32_t>&order = colouring.order(), &start = colouring.set_start();
  std::vector<std::uint32_t> sorted = order, all(network.node_count);
  std::sort(sorted.begin(), sorted.end());
  std::iota(all.begin(), all.end(), 0u);
  CHECK(sorted == all);
  REQUIRE(start.front() == 0);
  REQUIRE(start.back() == network.node_count);
  std::vector<std::size_t> colour(network.node_count);
  for (std::size_t c = 0; c + 1 < start.size(); ++c) {
    CHECK(start[c] < start[c + 1]);
    CHECK(std::is_sorted(order.begin() + start[c], order.begin() + start[c + 1]));
    for (std::uint32_t i = start[c]; i < start[c + 1]; ++i) colour[order[i]] = c;
  }
  for (std::uint32_t a = 0; a < network.node_count; ++a) {
    for (std::uint32_t b = 0; b < network.node_count; ++b) {
      const bool together = network.cluster[a] != 0xffffffffu && network.cluster[a] == network.cluster[b];
      if (together) CHECK(colour[a] == colour[b]);
      const auto* begin = network.neighbours + network.neighbour_start[a];
      const auto* end = network.neighbours + network.neighbour_start[a + 1];
      if (!together && std::find(begin, end, b) != end) CHECK(colour[a] != colour[b]);
    }
  }
}

}  // namespace

TEST_CASE("a chain has two colours, whatever the engine's numbers") {
  Graph chain({0, 1, 2, 3, 4}, {{0, 1}, {1, 2}, {2, 3}, {3, 4}});
  Colouring colouring;
  colouring.attach(chain.network);
  CHECK(colouring.order() == std::vector<std::uint32_t>{0, 2, 4, 1, 3});
  CHECK(colouring.set_start() == std::vector<std::uint32_t>{0, 3, 5});
  // The same chain with the engine's node 4 - k as the user's node k.
  Graph reversed({4, 3, 2, 1, 0}, {{0, 1}, {1, 2}, {2, 3}, {3, 4}});
  colouring.attach(reversed.network);
  CHECK(colouring.order() == std::vector<std::uint32_t>{0, 2, 4, 1, 3});
}

TEST_CASE("nodes without neighbours share one colour, a network without nodes has none") {
  Graph loose({0, 1, 2}, {});
  Colouring colouring;
  colouring.attach(loose.network);
  CHECK(colouring.set_start() == std::vector<std::uint32_t>{0, 3});
  Graph empty({}, {});
  colouring.attach(empty.network);
  CHECK(colouring.order().empty());
  CHECK(colouring.set_start() == std::vector<std::uint32_t>{0});
}

TEST_CASE("random graphs with clusters") {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto count = static_cast<std::uint32_t>(5 + random() % 40);
    std::vector<std::uint32_t> users(count);
    std::iota(users.begin(), users.end(), 0u);
    for (std::uint32_t k = count; k > 1; --k) std::swap(users[k - 1], users[random() % k]);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (std::uint32_t a = 0; a < count; ++a)
      for (std::uint32_t b = a + 1; b < count; ++b)
        if (random() % 6 == 0) edges.emplace_back(a, b);
    Graph graph(users, edges);
    for (std::uint32_t k = 0; k < count; ++k)
      if (random() % 3 == 0) graph.cluster[k] = random() % 4;
    Colouring colouring;
    colouring.attach(graph.network);
    check(graph, colouring);
  }
}
