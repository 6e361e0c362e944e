// The loops over batches of elements: the bits of single elements, on every instruction set; nets at rest.
#include <bit>
#include <random>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "../layers/random_net.hpp"
#include "bodies.hpp"
#include "layers/elements/queries.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Elements of one invariant between nodes at random, among them shapes without a gradient: coincident nodes, nodes on a
// line at rest and bending.
Network many(Invariant invariant, unsigned seed) {
  Network net;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto some = [&] { return Vector3(unit(random), unit(random), unit(random)); };
  const auto material = net.add_material(
      {.spring = LawUse{"linear", {{"stiffness", 1.0}}}, .viscosity = LawUse{"linear", {{"damping", 0.5}}}});
  for (int e = 0; e < 301; ++e) {
    std::vector<NodeIndex> nodes;
    const Vector3 along = some();
    for (std::size_t i = 0; i < corners_of(invariant); ++i) {
      const Vector3 place = e % 17 == 3    ? Vector3(1, 2, 3)
                            : e % 17 == 5  ? Vector3(static_cast<double>(i) * Vector3::UnitX())
                            : e % 17 == 11 ? Vector3(static_cast<double>(i) * along)
                                           : some();
      nodes.push_back(net.add_node(point(place, 1.0, e % 2 == 0 ? some() : Vector3(Vector3::Zero()))));
    }
    net.add_element(invariant, nodes, material, 4.0 * unit(random));
  }
  return net;
}

}  // namespace

TEST_CASE("batches, single nodes and queries agree on elements, on every instruction set") {
  for (const Invariant invariant : {Invariant::angle, Invariant::dihedral, Invariant::area, Invariant::volume}) {
    CAPTURE(name_of(invariant));
    const Network net = many(invariant, 7);
    for (const InstructionSet set : {InstructionSet::generic, InstructionSet::avx2, InstructionSet::avx512}) {
      try {
        static_cast<void>(layers::choose_instruction_set(set));
      } catch (const Error& error) {
        MESSAGE("skipped: " << error.what());
        continue;
      }
      EvaluatorFixture fixture(net, set);
      fixture.evaluate();
      for (std::uint32_t e = 0; e < net.elements().size(); ++e) {
        const std::span<const std::uint32_t> nodes = fixture.layout.elements().nodes(e);
        layers::Corners corners;
        layers::FirstOrder geometry;
        layers::gather(nodes.data(), nodes.size(), fixture.nodes(), corners);
        layers::first_order(invariant, corners, geometry);
        const double force = layers::element_force(fixture.layout, set, 0.0, fixture.nodes(), e);
        // Each node belongs to one element: no sums, so the same bits.
        for (std::size_t i = 0; i < nodes.size(); ++i) {
          Vector3 single;
          springnet_message message{};
          REQUIRE(fixture.evaluator->evaluate_node(nodes[i], 0.0, fixture.nodes(), fixture.external, nullptr, single,
                                                   message) == SPRINGNET_OK);
          const Vector3 expected = Vector3::Zero() - force * geometry.gradient[i];
          for (Eigen::Index c = 0; c < 3; ++c) {
            CHECK(fixture.f[c][nodes[i]] == expected[c]);
            CHECK(single[c] == expected[c]);
          }
        }
      }
    }
  }
}

TEST_CASE("elements at rest exert exactly nothing: references and laws read the same bits") {
  for (const Invariant invariant : {Invariant::angle, Invariant::dihedral, Invariant::area, Invariant::volume}) {
    CAPTURE(name_of(invariant));
    Network net;
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const auto material = net.add_material({LawUse{"linear", {{"stiffness", 1e6}}}, std::nullopt});
    for (int e = 0; e < 500; ++e) {
      std::vector<NodeIndex> nodes;
      for (std::size_t i = 0; i < corners_of(invariant); ++i)
        nodes.push_back(net.add_node(point({unit(random), unit(random), unit(random)})));
      net.add_element(invariant, nodes, material);
    }
    EvaluatorFixture fixture(net);
    fixture.evaluate();
    for (const std::vector<double>& component : fixture.f)
      for (const double force : component) CHECK(force == 0.0);
  }
}
