// The naive nets of the table of steps compute what the engine computes: the same forces, and the same symplectic Euler
// steps. So its unit is neither too cheap nor too dear.
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "naive_net.hpp"
#include "nets.hpp"
#include "simulation/model.hpp"
#include "table_nets.hpp"

using namespace springnet;
using benchmark::PlainNet;

namespace {

struct Named {
  std::string name;
  std::function<benchmark::Case()> make;
};

// Small nets have every law of the table.
std::vector<Named> nets() {
  std::vector<Named> all{{"lattice", [] { return benchmark::hanging_lattice(8, 2e4); }},
                         {"several units", [] { return benchmark::hanging_lattice(21, 2e4); }},
                         {"sheet", [] { return benchmark::sheet(); }},
                         {"tissue", [] { return benchmark::tissue(benchmark::tissue_mesh(7)); }}};
  for (const char* const name : {"cube", "tube", "bladder"})
    all.push_back({name, [name] { return benchmark::example(name); }});
  return all;
}

// Away from rest, with motion in all directions, without the loads that differ from step to step.
Network in_motion(const Network& start) {
  Network net = start;
  const double size = start.springs()[0].rest_length;
  unsigned random = 1;
  const auto draw = [&random] {
    random = random * 1664525u + 1013904223u;
    return static_cast<double>(random) * 0x1p-32 - 0.5;
  };
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    for (int i = 0; i < 3; ++i) node.position[i] += 0.02 * size * draw();
    if (!node.fixed) {
      for (int i = 0; i < 3; ++i) node.velocity[i] = size * draw();
    }
    net.set_node(k, node);
  }
  return net;
}

// Of loads that act at the start.
Vector3 load_on(const Network& net, NodeIndex node) {
  Vector3 force = net.nodes()[node].mass * net.gravity();
  for (const Load& load : net.loads()) {
    const bool acts = load.from <= 0.0 && 0.0 < load.until;
    if (acts && std::find(load.nodes.begin(), load.nodes.end(), node) != load.nodes.end()) force += load.force;
  }
  return force;
}

}  // namespace

TEST_CASE("a naive net has the engine's forces") {
  for (const Named& named : nets()) {
    CAPTURE(named.name);
    const benchmark::Case one = named.make();
    const Network net = in_motion(one.network);
    const Simulation simulation(net, testing::plugins(), one.options);
    const Model model(net, *testing::plugins(), one.options);
    PlainNet naive(net, model.layout);
    naive.add_forces();
    double greatest = 0.0, difference = 0.0;
    for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
      const Vector3 expected = simulation.force(k) - load_on(net, k);
      const Vector3 force(naive.nodes()[simulation.columns()[k]].force);
      greatest = std::max(greatest, expected.norm());
      difference = std::max(difference, (force - expected).norm());
    }
    REQUIRE(greatest > 0.0);
    CHECK(difference / greatest < 2e-13);
  }
}

TEST_CASE("naive steps are the engine's symplectic Euler steps") {
  for (const Named& named : nets()) {
    if (named.name == "bladder" || named.name == "sheet") continue;  // loaded or moved from the start
    CAPTURE(named.name);
    benchmark::Case one = named.make();
    one.options.integrator = testing::single_sweep();
    one.options.time_step = 1e-4;  // stable in all of them
    const Network net = in_motion(one.network);
    Simulation simulation(net, testing::plugins(), one.options);
    const Model model(net, *testing::plugins(), one.options);
    PlainNet naive(net, model.layout);
    double way = 0.0, distance = 0.0;
    for (int step = 0; step < 10; ++step) {
      simulation.step();
      naive.step(one.options.time_step);
    }
    for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
      const Vector3 position(naive.nodes()[simulation.columns()[k]].position);
      way = std::max(way, (simulation.position(k) - net.nodes()[k].position).norm());
      distance = std::max(distance, (position - simulation.position(k)).norm());
    }
    REQUIRE(way > 0.0);
    CHECK(distance / way < 1e-11);
  }
}

TEST_CASE("a naive net refuses what it does not compute") {
  const Material material{LawUse{"exponential", {{"stiffness", 1.0}}}, std::nullopt};
  const Network net = testing::chain(2, Vector3::Zero(), Vector3::UnitX(), material);
  const Model model(net, *testing::plugins(), {});
  CHECK_THROWS_WITH_AS(PlainNet(net, model.layout), doctest::Contains("'linear'"), Error);
}
