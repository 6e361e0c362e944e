// Nodes that are evaluated together: each has the forces that it has by itself, and those of the tiles.
#include <algorithm>
#include <numeric>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "../elements/bodies.hpp"
#include "random_net.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Forces on all nodes of a fixture, `together` at a time, [component][node].
std::vector<double> forces(const EvaluatorFixture& fixture, std::size_t together) {
  const std::size_t n = fixture.layout.node_count();
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::reverse(order.begin(), order.end());
  std::vector<double> found(3 * n), answer(3 * together);
  for (std::size_t begin = 0; begin < n; begin += together) {
    const std::size_t count = std::min(together, n - begin);
    double* const components[3] = {answer.data(), answer.data() + together, answer.data() + 2 * together};
    springnet_message message{};
    const std::span<const std::uint32_t> list(order.data() + begin, count);
    layers::ListedNodes own;
    fixture.evaluator->copy(list, fixture.nodes(), own);
    REQUIRE(fixture.evaluator->evaluate_together({list}, own, 0.0, fixture.nodes(), fixture.external, nullptr,
                                                 components, message) == SPRINGNET_OK);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < 3; ++c) found[c * n + order[begin + i]] = components[c][i];
  }
  return found;
}

// A net whose node 0 has more springs than fit a call of a law.
Network hub(bool relative) {
  Network net = random_network(700, 3, 5);
  Material made = damped(2.0, 0.3);
  if (relative) made.viscosity = LawUse{"relative", {{"damping", 0.3}}};
  const MaterialIndex material = net.add_material(made);
  for (NodeIndex k = 1; k < 700; ++k) net.add_spring(0, k, material, 0.01 * (k % 7));
  return net;
}

}  // namespace

TEST_CASE("forces of nodes do not depend on what is evaluated with them, nor on the instruction set") {
  for (const Network& net : {random_network(1500, 5, 3), hub(false), hub(true), all_kinds(4)}) {
    EvaluatorFixture reference(net, InstructionSet::generic);
    const std::vector<double> single = forces(reference, 1);
    for (const InstructionSet set : {InstructionSet::generic, InstructionSet::avx2, InstructionSet::avx512}) {
      try {
        static_cast<void>(layers::choose_instruction_set(set));
      } catch (const Error& error) {
        MESSAGE("skipped: " << error.what());
        continue;
      }
      EvaluatorFixture fixture(net, set);
      for (const std::size_t together : {std::size_t{1}, std::size_t{7}, layers::together_limit})
        CHECK(forces(fixture, together) == single);
    }
    // With derivatives, too.
    const std::size_t n = reference.layout.node_count();
    for (std::uint32_t k = 0; k < n; ++k) {
      Vector3 force, acceleration;
      layers::NodeDerivatives derivatives;
      springnet_message message{};
      REQUIRE(reference.evaluator->evaluate_node(k, 0.0, reference.nodes(), reference.external, nullptr, force,
                                                 acceleration, &derivatives, nullptr, message) == SPRINGNET_OK);
      for (std::size_t c = 0; c < 3; ++c) CHECK(force[static_cast<Eigen::Index>(c)] == single[c * n + k]);
    }
    reference.evaluate();
    double greatest = 0.0;
    for (const double force : single) greatest = std::max(greatest, std::abs(force));
    // The tiles sum in another order: some hundred ulps, with 700 springs at a node.
    for (std::size_t i = 0; i < 3 * n; ++i) CHECK(std::abs(reference.f[i / n][i % n] - single[i]) <= 1e-12 * greatest);
  }
}

TEST_CASE("accelerations of a list of nodes are those of a range") {
  EvaluatorFixture fixture(random_network(200, 3, 9));
  fixture.evaluate();
  std::vector<std::uint32_t> list;
  for (std::uint32_t k = 0; k < 60; ++k) list.push_back((k * 37) % 200);
  std::vector<double> a[3], force[3], expected[3];
  for (std::size_t c = 0; c < 3; ++c) {
    a[c].resize(list.size());
    expected[c].resize(200);
    for (const std::uint32_t k : list) force[c].push_back(fixture.f[c][k]);
  }
  springnet_message message{};
  const double* const of_list[3] = {force[0].data(), force[1].data(), force[2].data()};
  double* const answers[3] = {a[0].data(), a[1].data(), a[2].data()};
  layers::ListedNodes own;
  fixture.evaluator->copy(list, fixture.nodes(), own);
  REQUIRE(fixture.evaluator->accelerations(list, own, 0.0, of_list, answers, message) == SPRINGNET_OK);
  const double* const of_all[3] = {fixture.f[0].data(), fixture.f[1].data(), fixture.f[2].data()};
  double* const all[3] = {expected[0].data(), expected[1].data(), expected[2].data()};
  REQUIRE(fixture.evaluator->accelerations(0, 200, 0.0, fixture.nodes(), of_all, all, nullptr, nullptr, nullptr,
                                           message) == SPRINGNET_OK);
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) CHECK(a[c][i] == expected[c][list[i]]);
}
