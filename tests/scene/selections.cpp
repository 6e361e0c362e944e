// Selections and connections against a plain search.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "scenes.hpp"

using springnet::Network;
using springnet::Vector3;

namespace {

// Two lattices: "a" of 27 nodes, "b" of 8 beside it.
const std::string two_bodies = small + R"([[body]]
name = "b"
mesh = { lattice = [2, 2, 2], spacing = 1.0, origin = [3, 0, 0] }
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "linear", stiffness = 3.0 }
)";

// Numbers of the nodes that a [[fix]] with the selection fixes.
std::vector<unsigned> nodes_of(const std::string& selection) {
  const Network network = parse(two_bodies + "[[fix]]\nselect = " + selection + "\n").network;
  std::vector<unsigned> nodes;
  for (unsigned i = 0; i < network.nodes().size(); ++i) {
    if (network.nodes()[i].fixed) nodes.push_back(i);
  }
  return nodes;
}

std::vector<unsigned> springs_of(const std::string& selection) {
  return parse(two_bodies + "[[cut]]\ntime = 0\nselect = " + selection + "\n").network.cuts()[0].springs;
}

using Numbers = std::vector<unsigned>;

Numbers range(unsigned first, unsigned end) {
  Numbers numbers;
  for (unsigned i = first; i < end; ++i) numbers.push_back(i);
  return numbers;
}

std::set<std::pair<unsigned, unsigned>> connected(const std::string& connection) {
  const Network before = parse(two_bodies).network;
  const Network network =
      parse(two_bodies + "[[connect]]\nspring = { type = \"linear\", stiffness = 1 }\n" + connection + "\n").network;
  std::set<std::pair<unsigned, unsigned>> pairs;
  for (std::size_t i = before.springs().size(); i < network.springs().size(); ++i) {
    const springnet::Spring& spring = network.springs()[i];
    CHECK(pairs.emplace(std::minmax(spring.first, spring.second)).second);  // none twice
  }
  return pairs;
}

}  // namespace

TEST_CASE("nodes by body and number") {
  CHECK(nodes_of("{}") == range(0, 35));
  CHECK(nodes_of("{ body = \"b\" }") == range(27, 35));
  CHECK(nodes_of("{ body = [\"a\"] }") == range(0, 27));
  CHECK(nodes_of("{ body = [\"b\", \"a\"] }") == range(0, 35));
  CHECK(nodes_of("{ nodes = [30, 2, 30] }") == Numbers{2, 30});
  CHECK(nodes_of("{ body = \"b\", nodes = [3, 0] }") == Numbers{27, 30});
}

TEST_CASE("nodes by box: its sides belong to it and may be infinite") {
  CHECK(nodes_of("{ box = { min = [0, 0, 0], max = [1, 1, 0] } }") == Numbers{0, 1, 3, 4});
  CHECK(nodes_of("{ box = { max = [inf, 0, 0] } }") == Numbers{0, 1, 2, 27, 28});
  CHECK(nodes_of("{ box = { min = [3.5, -inf, 1] } }") == Numbers{32, 34});
  CHECK(nodes_of("{ body = \"a\", box = { max = [inf, 0, 0] } }") == Numbers{0, 1, 2});
  CHECK(nodes_of("{ nodes = [0, 1, 34], box = { max = [inf, 0, 0] } }") == Numbers{0, 1});
}

TEST_CASE("a box contains nodes whose coordinates are rounded beyond its sides") {
  // 3 * 0.1 is above 0.3 by a rounding.
  const std::string text = small + "[[fix]]\nselect = { box = { max = [0.3, inf, inf] } }\n";
  const Network network = parse(text, {{"body.0.mesh", "{ lattice = [5, 1, 1], spacing = 0.1 }"}}).network;
  REQUIRE(network.nodes()[3].position.x() > 0.3);
  CHECK(network.nodes()[3].fixed);
  CHECK_FALSE(network.nodes()[4].fixed);
}

TEST_CASE("a box and a sphere far from the origin have the same nodes as beside it") {
  for (const char* far : {"0", "1e6", "1e8", "1e9"}) {
    CAPTURE(far);
    const auto fixed = [&](const std::string& selection) {
      const Network network =
          parse(small + "[[body]]\nname = \"far\"\nmesh = { lattice = [5, 5, 5], spacing = 0.015625, origin = [" + far +
                ", 0, 0] }\nneuron = { type = \"point_mass\", mass = 1.0 }\n" +
                "spring = { type = \"linear\", stiffness = 3.0 }\n[[fix]]\nselect = { body = \"far\", " + selection +
                " }\n")
              .network;
      return std::count_if(network.nodes().begin(), network.nodes().end(),
                           [](const springnet::Node& node) { return node.fixed; });
    };
    CHECK(fixed("box = { max = [" + std::string(far) + ", inf, inf] }") == 25);
    CHECK(fixed("sphere = { center = [" + std::string(far) + ", 0, 0], radius = 0.015625 }") == 4);
  }
}

TEST_CASE("nodes by sphere, alone and with a box") {
  CHECK(nodes_of("{ sphere = { center = [0, 0, 0], radius = 1 } }") == Numbers{0, 1, 3, 9});
  CHECK(nodes_of("{ sphere = { center = [2.5, 0, 0], radius = 0.5 } }") == Numbers{2, 27});
  CHECK(nodes_of("{ body = \"b\", sphere = { center = [2.5, 0, 0], radius = 0.5 } }") == Numbers{27});
  CHECK(nodes_of("{ sphere = { center = [0, 0, 0], radius = 1 }, box = { max = [9, 9, 0.5] } }") == Numbers{0, 1, 3});
}

TEST_CASE("springs by number, and by the nodes of both ends") {
  CHECK(springs_of("{}").size() == 54 + 12);
  CHECK(springs_of("{ springs = [7, 0, 7] }") == Numbers{0, 7});
  CHECK(springs_of("{ body = \"b\", springs = [0, 11] }") == Numbers{54, 65});
  CHECK(springs_of("{ body = \"b\" }") == range(54, 66));
  CHECK(springs_of("{ nodes = [0, 1, 2] }").size() == 2);
  CHECK(springs_of("{ box = { max = [2, 2, 0] } }").size() == 12);  // the lowest layer of "a"
  CHECK(springs_of("{ springs = [0, 1, 2, 3], nodes = [0, 1] }") == Numbers{0});
  CHECK(springs_of("{ sphere = { center = [0, 0, 0], radius = 1 } }").size() == 3);
}

TEST_CASE("within: every pair that is near enough, once, as in a plain search") {
  const Network network = parse(two_bodies).network;
  const auto search = [&](double distance, auto in_from, auto in_to) {
    std::set<std::pair<unsigned, unsigned>> pairs;
    for (unsigned a = 0; a < network.nodes().size(); ++a) {
      for (unsigned b = 0; b < network.nodes().size(); ++b) {
        const double d = (network.nodes()[a].position - network.nodes()[b].position).norm();
        // No two distances of these nodes differ by so little.
        if (a != b && in_from(a) && in_to(b) && d <= distance + 1e-6) pairs.emplace(std::minmax(a, b));
      }
    }
    return pairs;
  };
  const auto in_a = [](unsigned node) { return node < 27; };
  const auto in_b = [](unsigned node) { return node >= 27; };
  const auto all = [](unsigned) { return true; };
  CHECK(connected("from = { body = \"a\" }\nto = { body = \"b\" }\nwithin = 1.0") == search(1.0, in_a, in_b));
  CHECK(connected("from = { body = \"a\" }\nto = { body = \"b\" }\nwithin = 1.5") == search(1.5, in_a, in_b));
  CHECK(connected("from = {}\nto = {}\nwithin = 1.5") == search(1.5, all, all));
  CHECK(connected("from = {}\nto = { body = \"b\" }\nwithin = 1.5") == search(1.5, all, in_b));
  CHECK(connected("from = { body = \"b\" }\nto = {}\nwithin = 1.5") == search(1.5, in_b, all));
}

TEST_CASE("within: distances that are greater by a rounding") {
  const std::string lid = R"([[body]]
name = "lid"
mesh = { lattice = [3, 3, 1], spacing = 1.0, origin = [0, 0, 4.081] }
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "linear", stiffness = 3.0 }
[[connect]]
from = { body = "a" }
to = { body = "lid" }
within = 1.0
spring = { type = "linear", stiffness = 3.0 }
)";
  const Network network =
      parse(small + lid, {{"body.0.mesh.origin", "[0, 0, 0.081]"}, {"body.0.mesh.lattice.2", "4"}}).network;
  REQUIRE(network.nodes()[36].position.z() - network.nodes()[27].position.z() > 1.0);
  CHECK(network.springs().size() == 4 * 12 + 3 * 9 + 12 + 9);
}

TEST_CASE("nearest: each node of `from` with its nearest, the lowest number of several") {
  using Pairs = std::set<std::pair<unsigned, unsigned>>;
  // The side x = 3 of "b" faces the side x = 2 of "a".
  CHECK(connected("from = { body = \"b\", nodes = [0, 2, 4, 6] }\nto = { body = \"a\" }\nnearest = true") ==
        Pairs{{2, 27}, {5, 29}, {11, 31}, {14, 33}});
  // Equally near to four nodes of "a".
  const std::string middle =
      "[[body]]\nname = \"m\"\nnodes = [[0.5, 0.5, 0]]\nneuron = { type = \"point_mass\", mass = 1 }\n";
  const Network network = parse(two_bodies + middle + "[[connect]]\nspring = { type = \"linear\", stiffness = 1 }\n" +
                                "from = { body = \"m\" }\nto = { body = \"a\" }\nnearest = true\n")
                              .network;
  CHECK(network.springs().back().first == 35);
  CHECK(network.springs().back().second == 0);
  // Overlapping selections: two that are each other's nearest are joined once.
  CHECK(connected("from = { nodes = [0, 1] }\nto = { nodes = [0, 1] }\nnearest = true") == Pairs{{0, 1}});
}

TEST_CASE("pairs: numbers of a body, or of the whole network") {
  using Pairs = std::set<std::pair<unsigned, unsigned>>;
  CHECK(
      connected("pairs = [[{ body = \"a\", node = 3 }, { body = \"b\", node = 0 }], [{ node = 30 }, { node = 1 }]]") ==
      Pairs{{3, 27}, {1, 30}});
}

TEST_CASE("an override of springs keeps the keys that it does not name") {
  const Network network = parse(two_bodies + R"([[spring]]
select = { body = "b" }
viscosity = { type = "linear", damping = 1.0 }
[[spring]]
select = {}
rest_length_scale = 2.0
)")
                              .network;
  const auto& soft = network.materials()[network.springs()[0].material];
  const auto& damped = network.materials()[network.springs()[54].material];
  CHECK_FALSE(soft.viscosity.has_value());
  CHECK(damped.viscosity->id == "linear");
  CHECK(damped.spring == soft.spring);
  for (const springnet::Spring& spring : network.springs()) CHECK(spring.rest_length == 2);
}

TEST_CASE("a later [[node]] keeps what an earlier one has set") {
  const Network network = parse(small + R"([[node]]
select = { nodes = [1, 2] }
mass = 5
[[node]]
select = { nodes = [2, 3] }
velocity = [1, 0, 0]
)")
                              .network;
  CHECK(network.nodes()[1].mass == 5);
  CHECK(network.nodes()[2].mass == 5);
  CHECK(network.nodes()[2].velocity == Vector3(1, 0, 0));
  CHECK(network.nodes()[3].mass == 1);
}
