// Lattices against counts from combinatorics, and against a slow construction by distances.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/network.hpp>

using springnet::Diagonals;
using springnet::Lattice;
using springnet::Network;
using springnet::Vector3;

namespace {

springnet::MaterialIndex add_linear(Network& network) {
  return network.add_material({springnet::LawUse{"linear", {{"stiffness", 3.0}}}, std::nullopt});
}

Network lattice_of(std::array<std::uint32_t, 3> nodes, Diagonals diagonals, const Vector3& spacing = Vector3::Ones(),
                   const Vector3& origin = Vector3::Zero()) {
  Network network;
  network.add_lattice("lattice", {nodes, spacing, origin, diagonals}, {}, add_linear(network));
  return network;
}

std::string error_of(const Lattice& lattice) {
  Network network;
  const auto material = add_linear(network);
  try {
    network.add_lattice("big", lattice, {}, material);
  } catch (const springnet::Error& error) {
    CHECK(error.kind() == springnet::ErrorKind::input);
    CHECK(network.nodes().empty());
    CHECK(network.bodies().empty());
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("the paper's cube has 64 nodes and 252 springs: 144 axial and 108 through the cells") {
  const Network cube = lattice_of({4, 4, 4}, Diagonals::space);
  CHECK(cube.nodes().size() == 64);
  REQUIRE(cube.springs().size() == 252);
  const auto axial = std::count_if(cube.springs().begin(), cube.springs().end(),
                                   [](const springnet::Spring& spring) { return spring.rest_length == 1.0; });
  CHECK(axial == 144);
}

TEST_CASE("springs join exactly the nodes whose distance is that of the kind of diagonal") {
  // With spacing 1 the squared distance tells the kind: 1 axial, 2 face, 3 space.
  const std::array<std::uint32_t, 3> nodes{3, 4, 2};
  const std::pair<Diagonals, std::set<int>> kinds[] = {
      {Diagonals::none, {1}}, {Diagonals::face, {1, 2}}, {Diagonals::space, {1, 3}}, {Diagonals::all, {1, 2, 3}}};
  for (const auto& kind : kinds) {
    const std::set<int>& squares = kind.second;
    CAPTURE(static_cast<int>(kind.first));
    const Network network = lattice_of(nodes, kind.first);
    std::set<std::pair<unsigned, unsigned>> expected, found;
    for (unsigned a = 0; a < network.nodes().size(); ++a) {
      for (unsigned b = a + 1; b < network.nodes().size(); ++b) {
        const Vector3 d = network.nodes()[a].position - network.nodes()[b].position;
        const bool in_one_cell = d.cwiseAbs().maxCoeff() <= 1;
        if (in_one_cell && squares.count(static_cast<int>(d.squaredNorm())) == 1) expected.emplace(a, b);
      }
    }
    for (const springnet::Spring& spring : network.springs()) found.emplace(spring.first, spring.second);
    CHECK(found.size() == network.springs().size());  // none twice
    CHECK(found == expected);
  }
}

TEST_CASE("nodes are numbered x first, then y, then z") {
  const Network network = lattice_of({2, 3, 4}, Diagonals::none, {0.5, 2.0, 10.0}, {1.0, -1.0, 7.0});
  REQUIRE(network.nodes().size() == 24);
  CHECK(network.nodes()[1].position == Vector3(1.5, -1, 7));
  CHECK(network.nodes()[2].position == Vector3(1, 1, 7));
  CHECK(network.nodes()[6].position == Vector3(1, -1, 17));
  CHECK(network.nodes()[23].position == Vector3(1.5, 3, 37));
}

TEST_CASE("equal springs have bitwise equal rest lengths, those of the spacing") {
  // A spacing and an origin whose sums all round.
  const Vector3 spacing(0.1, 0.2, 0.3);
  const Network network = lattice_of({6, 5, 4}, Diagonals::all, spacing, {0.7, 1.3, 0.081});
  std::set<double> lengths;
  for (const springnet::Spring& spring : network.springs()) lengths.insert(spring.rest_length);
  // 3 axial, 3 across faces, 1 through cells
  CHECK(lengths.size() == 7);
  for (const double side : spacing) CHECK(lengths.count(side) == 1);
  for (const springnet::Spring& spring : network.springs()) {
    const Vector3 d = network.nodes()[spring.first].position - network.nodes()[spring.second].position;
    // Positions of magnitude 2 m are rounded to 2e-16 m, six of them enter a length of 0.1 m or more.
    CHECK(std::abs(spring.rest_length / d.norm() - 1) < 1e-14);
  }
}

TEST_CASE("faces are the boundary, outward and closed") {
  const Vector3 spacing(0.5, 2.0, 1.0);
  const Network solid = lattice_of({3, 4, 5}, Diagonals::none, spacing, {7.0, -3.0, 1.0});
  CHECK(solid.faces().size() == 4 * (2 * 3 + 3 * 4 + 4 * 2));
  double volume = 0.0;
  Vector3 closed = Vector3::Zero();
  for (const springnet::Face& face : solid.faces()) {
    const Vector3 area = solid.area_of(face);
    closed += area;
    volume += area.dot(solid.nodes()[face[0]].position) / 3.0;
    // Each by itself, seen from the middle.
    CHECK(area.dot(solid.nodes()[face[0]].position - Vector3(7.5, 0.0, 3.0)) > 0.0);
  }
  CHECK(closed.norm() <= 1e-14);
  CHECK(std::abs(volume - 1.0 * 6.0 * 4.0) <= 1e-13);
  // A sheet has one side, a row none.
  CHECK(lattice_of({3, 4, 1}, Diagonals::none).faces().size() == 2 * 2 * 3);
  CHECK(lattice_of({3, 1, 1}, Diagonals::none).faces().empty());
}

TEST_CASE("one node in a direction: a plane, a row, a point") {
  CHECK(lattice_of({4, 4, 1}, Diagonals::all).springs().size() == 24 + 18);
  CHECK(lattice_of({4, 1, 4}, Diagonals::space).springs().size() == 24);
  CHECK(lattice_of({1, 1, 9}, Diagonals::all).springs().size() == 8);
  CHECK(lattice_of({1, 1, 1}, Diagonals::all).nodes().size() == 1);
  CHECK(lattice_of({1, 1, 1}, Diagonals::all).springs().empty());
}

TEST_CASE("mass, velocity and neuron are those of the prototype, the body has its ranges") {
  Network network;
  const auto material = add_linear(network);
  const auto neuron = network.add_neuron({"dragged", {{"drag", 2.0}}});
  springnet::Node prototype;
  prototype.mass = 3;
  prototype.velocity = {1, 2, 3};
  prototype.neuron = neuron;
  network.add_lattice("a", {{2, 1, 1}, Vector3::Ones(), Vector3::Zero(), Diagonals::none}, prototype, material);
  network.add_lattice("b", {{2, 2, 1}, Vector3::Ones(), Vector3::UnitZ(), Diagonals::none}, prototype, material);
  for (const springnet::Node& node : network.nodes()) {
    CHECK(node.mass == 3);
    CHECK(node.velocity == Vector3(1, 2, 3));
    CHECK(node.neuron == neuron);
  }
  REQUIRE(network.bodies().size() == 2);
  CHECK(network.bodies()[1].name == "b");
  CHECK(network.bodies()[1].first_node == 2);
  CHECK(network.bodies()[1].node_count == 4);
  CHECK(network.bodies()[1].first_spring == 1);
  CHECK(network.bodies()[1].spring_count == 4);
  for (std::size_t i = 1; i < 5; ++i) CHECK(network.springs()[i].first >= 2);
}

TEST_CASE("a million nodes: counts of the closed form") {
  const Network network = lattice_of({100, 100, 100}, Diagonals::space);
  CHECK(network.nodes().size() == 1'000'000);
  CHECK(network.springs().size() == 3 * 99 * 100 * 100 + 4 * 99 * 99 * 99);
}

TEST_CASE("lattices that are refused: the message says what is wrong, the network stays as it was") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Vector3 one = Vector3::Ones(), zero = Vector3::Zero();
  CHECK(error_of({{4, 0, 4}, one, zero, Diagonals::none}).find("along y") != std::string::npos);
  CHECK(error_of({{4, 4, 4}, {1, 1, 0}, zero, Diagonals::none}).find("along z") != std::string::npos);
  CHECK(error_of({{4, 4, 4}, {1, -1, 1}, zero, Diagonals::none}).find("is -1") != std::string::npos);
  CHECK(error_of({{4, 4, 4}, {nan, 1, 1}, zero, Diagonals::none}).find("is nan") != std::string::npos);
  CHECK(error_of({{4, 4, 4}, one, {0, nan, 0}, Diagonals::none}).find("along y is nan") != std::string::npos);
  CHECK(error_of({{4, 4, 4}, {1e308, 1, 1}, zero, Diagonals::none}).find("along x is inf") != std::string::npos);
  CHECK(error_of({{2, 2, 2}, {1.7e308, 1.7e308, 1}, zero, Diagonals::face}).find("diagonals") != std::string::npos);
}

TEST_CASE("more nodes or springs than 32-bit numbers are refused before any memory is taken") {
  const Vector3 one = Vector3::Ones(), zero = Vector3::Zero();
  constexpr std::uint32_t max = std::numeric_limits<std::uint32_t>::max();
  CHECK(error_of({{2000, 2000, 2000}, one, zero, Diagonals::none}).find("8e+09 nodes") != std::string::npos);
  CHECK(error_of({{max, max, max}, one, zero, Diagonals::none}).find("use fewer nodes") != std::string::npos);
  // 1e9 nodes have numbers, their 13e9 springs have not.
  CHECK(error_of({{1000, 1000, 1000}, one, zero, Diagonals::all}).find("springs") != std::string::npos);
}

TEST_CASE("a name in use leaves the network as it was") {
  Network network;
  const auto material = add_linear(network);
  const Lattice lattice{{2, 2, 2}, Vector3::Ones(), Vector3::Zero(), Diagonals::none};
  network.add_lattice("a", lattice, {}, material);
  CHECK_THROWS_WITH_AS(network.add_lattice("a", lattice, {}, material), doctest::Contains("bodies 'a'"),
                       springnet::Error);
  CHECK(network.nodes().size() == 8);
  CHECK_THROWS_AS(network.add_lattice("b", lattice, {}, material + 1), springnet::Error);
  network.add_lattice("b", lattice, {}, material);
  CHECK(network.nodes().size() == 16);
}
