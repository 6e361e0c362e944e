#include "wavefront.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "graph.hpp"

namespace {

using springnet::recurrent::Wavefront;
using springnet::testing::Graph;

std::vector<std::uint32_t> order_from(Graph& graph, Wavefront& wavefront, std::uint32_t start) {
  const auto order = wavefront.order(graph.network, start, graph.forces());
  return {order.begin(), order.end()};
}

using Order = std::vector<std::uint32_t>;

}  // namespace

TEST_CASE("a chain is visited outwards from the start, lower user's numbers first") {
  Graph chain({0, 1, 2, 3, 4}, {{0, 1}, {1, 2}, {2, 3}, {3, 4}});
  Wavefront wavefront;
  wavefront.attach(chain.network);
  CHECK(order_from(chain, wavefront, 0) == Order{0, 1, 2, 3, 4});
  CHECK(order_from(chain, wavefront, 2) == Order{2, 1, 3, 0, 4});
  CHECK(order_from(chain, wavefront, 2) == Order{2, 1, 3, 0, 4});
  CHECK(order_from(chain, wavefront, 4) == Order{4, 3, 2, 1, 0});
}

TEST_CASE("the order follows the user's numbers, not the engine's") {
  // The same chain, numbered backwards by its user.
  Graph chain({4, 3, 2, 1, 0}, {{0, 1}, {1, 2}, {2, 3}, {3, 4}});
  Wavefront wavefront;
  wavefront.attach(chain.network);
  CHECK(order_from(chain, wavefront, 2) == Order{2, 3, 1, 4, 0});
}

TEST_CASE("layers of a grid come by their distance from the start") {
  // 3 x 3 grid, start in a corner: distances 0; 1, 1; 2, 2, 2; 3, 3; 4.
  Graph grid({0, 1, 2, 3, 4, 5, 6, 7, 8},
             {{0, 1}, {1, 2}, {3, 4}, {4, 5}, {6, 7}, {7, 8}, {0, 3}, {1, 4}, {2, 5}, {3, 6}, {4, 7}, {5, 8}});
  Wavefront wavefront;
  wavefront.attach(grid.network);
  CHECK(order_from(grid, wavefront, 0) == Order{0, 1, 3, 2, 4, 6, 5, 7, 8});
}

TEST_CASE("the strongest node: greatest force, then the lowest user's number") {
  Graph chain({2, 1, 0}, {{0, 1}, {1, 2}});
  Wavefront wavefront;
  wavefront.attach(chain.network);
  chain.force[2] = {-3.0, 1.0, 2.0};
  CHECK(wavefront.strongest(chain.network, chain.forces()) == 0);
  chain.force[0] = {0.0, 0.0, 4.0};
  CHECK(wavefront.strongest(chain.network, chain.forces()) == 2);
  for (auto& component : chain.force) component.assign(3, 1.0);
  CHECK(wavefront.strongest(chain.network, chain.forces()) == 2);  // the user's node 0
}

TEST_CASE("a force on a fixed or held node starts no wave while a node is free") {
  Graph chain({0, 1, 2}, {{0, 1}, {1, 2}});
  Wavefront wavefront;
  wavefront.attach(chain.network);
  chain.force[0] = {9.0, 5.0, 1.0};
  chain.fixed[0] = 1;
  CHECK(wavefront.strongest(chain.network, chain.forces()) == 1);
  chain.held[1] = 1;
  CHECK(wavefront.strongest(chain.network, chain.forces()) == 2);
  chain.fixed[2] = 1;
  CHECK(wavefront.strongest(chain.network, chain.forces()) == 0);
}

TEST_CASE("parts that the wave does not reach follow by their greatest force") {
  // Parts {0, 1}, {2, 3, 4}, {5}, {6, 7}.
  Graph parts({0, 1, 2, 3, 4, 5, 6, 7}, {{0, 1}, {2, 3}, {3, 4}, {6, 7}});
  Wavefront wavefront;
  wavefront.attach(parts.network);
  parts.force[1] = {0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0};
  CHECK(order_from(parts, wavefront, 0) == Order{0, 1, 7, 6, 5, 4, 3, 2});
  // The start need not be the strongest node of its part.
  CHECK(order_from(parts, wavefront, 3) == Order{3, 2, 4, 7, 6, 5, 1, 0});
  // Other forces, same start: the other parts change places.
  parts.force[1] = {0.5, 1.0, 2.0, 3.0, 4.0, 9.0, 6.0, 0.0};
  CHECK(order_from(parts, wavefront, 3) == Order{3, 2, 4, 5, 6, 7, 1, 0});
  // Ties between parts: the lowest user's number.
  parts.force[1].assign(8, 1.0);
  CHECK(order_from(parts, wavefront, 6) == Order{6, 7, 0, 1, 2, 3, 4, 5});
}

TEST_CASE("every node is visited exactly once, whatever the forces are") {
  Graph parts({3, 1, 4, 0, 5, 2}, {{0, 1}, {1, 2}, {2, 0}, {3, 4}});
  Wavefront wavefront;
  wavefront.attach(parts.network);
  parts.force[0] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300, 0, -1, 2};
  for (std::uint32_t start = 0; start < 6; ++start) {
    const Order order = order_from(parts, wavefront, start);
    CHECK(order.front() == start);
    CHECK(std::set<std::uint32_t>(order.begin(), order.end()).size() == 6);
    CHECK(order.size() == 6);
  }
}
