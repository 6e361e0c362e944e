#include <algorithm>

#include <doctest/doctest.h>
#include <springnet/network.hpp>

#include "view/selection.hpp"

using namespace springnet;
using view::Selection;

namespace {

// 20 x 20 x 20 nodes, with the triangles of its surface or without.
Network box(bool faces) {
  Network lattice;
  const MaterialIndex material = lattice.add_material({LawUse{"linear", {}}, std::nullopt});
  lattice.add_lattice("box", {{20, 20, 20}, Vector3::Ones(), Vector3::Zero(), Diagonals::none}, {}, material);
  if (faces) return lattice;
  Network bare;
  bare.add_material(lattice.materials()[0]);
  for (const Node& node : lattice.nodes()) bare.add_node(node);
  for (const Spring& spring : lattice.springs()) bare.add_spring(spring.first, spring.second, material);
  return bare;
}

double bytes_of(const Selection& selection, double frames) {
  const view::Cost cost =
      view::cost_of(static_cast<double>(selection.nodes.size()), static_cast<double>(selection.springs.size()));
  return cost.once + frames * cost.frame;
}

void check_places(const Network& network, const Selection& selection) {
  for (std::uint32_t k = 0; k < selection.nodes.size(); ++k) CHECK(selection.node_place[selection.nodes[k]] == k);
  for (std::uint32_t k = 0; k < selection.springs.size(); ++k) {
    CHECK(selection.spring_place[selection.springs[k]] == k);
    // What is drawn has its ends.
    const Spring& spring = network.springs()[selection.springs[k]];
    CHECK(selection.node_place[spring.first] != view::not_shown);
    CHECK(selection.node_place[spring.second] != view::not_shown);
  }
}

}  // namespace

TEST_CASE("all of a network is drawn if it fits") {
  const Network network = box(true);
  const Selection selection = view::select(network, 60.0, 1e8);
  CHECK(selection.nodes.size() == network.nodes().size());
  CHECK(selection.springs.size() == network.springs().size());
  CHECK(selection.faces);
  CHECK(selection.notes.empty());
  check_places(network, selection);
}

TEST_CASE("a large network is thinned, spread over all of it, with a note") {
  const Network network = box(false);
  const double bytes = 0.4 * bytes_of(view::select(network, 60.0, 1e9), 60.0);
  const Selection selection = view::select(network, 60.0, bytes);
  REQUIRE(selection.notes.size() == 1);
  CHECK(selection.notes[0].find("of 22800 springs") != std::string::npos);
  CHECK(bytes_of(selection, 60.0) <= bytes);
  check_places(network, selection);
  // Axial springs of the three directions follow each other in turn: a share of each is there.
  std::array<double, 3> kinds{};
  for (const SpringIndex k : selection.springs) {
    const Spring& spring = network.springs()[k];
    const NodeIndex step = spring.second - spring.first;
    kinds[step == 1 ? 0 : step == 20 ? 1 : 2] += 1.0;
  }
  const double third = static_cast<double>(selection.springs.size()) / 3.0;
  for (const double kind : kinds) CHECK(kind == doctest::Approx(third).epsilon(0.2));
}

TEST_CASE("springs on surfaces are kept") {
  const Network network = box(true);
  const Selection selection = view::select(network, 60.0, 0.5 * bytes_of(view::select(network, 60.0, 1e9), 60.0));
  CHECK(selection.faces);
  // Of 6 x 19 x 19 squares two edges each; their diagonals are no springs of this lattice.
  CHECK(selection.springs.size() == 4332);
  CHECK(selection.nodes.size() == 20 * 20 * 20 - 18 * 18 * 18);
  REQUIRE(selection.notes.size() == 1);
  CHECK(selection.notes[0].find("4332 of 22800 springs") != std::string::npos);
  check_places(network, selection);
}

TEST_CASE("triangles that would take most of the page are left out, with a note") {
  const Network network = box(true);
  const Selection selection = view::select(network, 60.0, 20'000.0);
  CHECK_FALSE(selection.faces);
  REQUIRE_FALSE(selection.notes.empty());
  CHECK(selection.notes[0].find("4332 surface triangles") != std::string::npos);
}
