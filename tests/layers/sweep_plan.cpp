// Plans of sweeps: their stages keep the order of all nodes that depend on each other, and have the springs and
// parameters of their nodes.
#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include "../elements/bodies.hpp"
#include "layers/springs/sweep_plan.hpp"
#include "random_net.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// A net whose node 0 has more springs than fit a call of a law.
Network hub() {
  Network net = random_network(700, 3, 5);
  const MaterialIndex material = net.add_material(damped(2.0, 0.3));
  for (NodeIndex k = 1; k < 700; ++k) net.add_spring(0, k, material, 0.01 * (k % 7));
  return net;
}

std::vector<std::uint32_t> shuffled(std::uint32_t count, unsigned seed) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::mt19937 random(seed);
  std::shuffle(order.begin(), order.end(), random);
  return order;
}

}  // namespace

TEST_CASE("stages keep the order of joined nodes, and of nodes by themselves and all others") {
  for (const Network& net : {random_network(700, 3, 8), all_kinds(3)}) {
    const layers::Layout layout(net, *plugins(), true);
    const std::uint32_t n = layout.node_count();
    const std::vector<std::uint32_t> order = shuffled(n, 4);
    const auto is_local = [](std::uint32_t k) { return k % 97 != 5; };
    const layers::SweepPlan::Sizes sizes(layout);
    layers::SweepPlan plan(sizes);
    plan.make(layout, shuffled(n, 5), is_local);  // leaves nothing behind
    plan.make(layout, order, is_local);
    CHECK(std::equal(order.begin(), order.end(), plan.order().begin(), plan.order().end()));
    std::vector<std::size_t> stage(n, 0), place(n);
    std::size_t count = 0;
    for (std::size_t s = 0; s < plan.stages().size(); ++s) {
      CHECK(plan.stages()[s].nodes.size() <= layers::together_limit);
      for (const std::uint32_t k : plan.stages()[s].nodes) {
        CHECK(stage[k] == 0);
        CHECK(plan.stages()[s].is_single == !is_local(k));
        stage[k] = s + 1;
        ++count;
      }
    }
    REQUIRE(count == n);
    for (std::uint32_t i = 0; i < n; ++i) place[order[i]] = i;
    for (std::uint32_t k = 0; k < n; ++k) {
      for (std::uint32_t at = layout.neighbour_start()[k]; at < layout.neighbour_start()[k + 1]; ++at) {
        const std::uint32_t other = layout.neighbours()[at];
        CHECK((place[k] < place[other]) == (stage[k] < stage[other]));
      }
      for (std::uint32_t other = 0; other < n && !is_local(k); ++other)
        if (other != k) CHECK((place[k] < place[other]) == (stage[k] < stage[other]));
    }
  }
}

TEST_CASE("a lattice in layers has as many stages as layers") {
  Network net;
  Lattice lattice;
  lattice.nodes = {6, 6, 6};
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(1.0, 0.1)));
  const layers::Layout layout(net, *plugins(), false);
  std::vector<std::uint32_t> order(layout.node_count());
  std::iota(order.begin(), order.end(), 0u);
  const layers::SweepPlan::Sizes sizes(layout);
  layers::SweepPlan plan(sizes);
  plan.make(layout, order, [](std::uint32_t) { return true; });
  CHECK(plan.stages().size() == 16);  // the sum of the three numbers of a node; none has more than 64 of them
}

TEST_CASE("forces by the springs of a plan are those by springs that are looked up, for every instruction set") {
  for (const Network& net : {random_network(700, 3, 8), random_network(300, 9, 2), hub(), all_kinds(3)}) {
    for (const InstructionSet set : {InstructionSet::generic, InstructionSet::best}) {
      EvaluatorFixture fixture(net, set);
      const std::vector<std::uint32_t> order = shuffled(fixture.layout.node_count(), 7);
      const layers::SweepPlan::Sizes sizes(fixture.layout);
      layers::SweepPlan plan(sizes);
      plan.make(fixture.layout, order, [](std::uint32_t) { return true; });
      bool mixed = false;
      for (const layers::SweepPlan::Stage& stage : plan.stages()) {
        std::vector<double> found[2];
        layers::ListedNodes own;
        fixture.evaluator->copy(stage.nodes, fixture.nodes(), own);
        for (const bool planned : {false, true}) {
          std::vector<double>& force = found[planned ? 1 : 0];
          const std::size_t count = stage.nodes.size();
          force.resize(3 * count);
          double* const components[3] = {force.data(), force.data() + count, force.data() + 2 * count};
          const layers::NodeList list{stage.nodes, planned ? stage.springs : std::span<const layers::NodeSprings>{}};
          springnet_message message{};
          REQUIRE(fixture.evaluator->evaluate_together(list, own, 0.0, fixture.nodes(), fixture.external, nullptr,
                                                       components, message) == SPRINGNET_OK);
        }
        CHECK(found[0] == found[1]);
        for (const layers::NodeSprings& springs : stage.springs) mixed = mixed || springs.rows.columns != nullptr;
      }
      CHECK(mixed);
    }
  }
}
