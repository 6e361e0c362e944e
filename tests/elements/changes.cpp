// Elements that rupture, are cut, or are removed with a spring; errors that name them; queries of a host.
#include <cmath>
#include <numbers>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Two triangles (0, 1, 2) and (1, 0, 3) in the plane z = 0 with springs on all sides, hinge, areas and an angle.
Network two_triangles() {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0.5, 1, 0), Vector3(0.5, -1, 0)})
    net.add_node(point(p));
  const MaterialIndex material = net.add_material(damped(1.0, 0.0));
  for (const auto& [a, b] : {std::pair{0u, 1u}, {1u, 2u}, {2u, 0u}, {0u, 3u}, {3u, 1u}}) net.add_spring(a, b, material);
  net.add_element(Invariant::dihedral, {0, 1, 2, 3}, material);
  net.add_element(Invariant::area, {0, 1, 2}, material);
  net.add_element(Invariant::area, {1, 0, 3}, material);
  net.add_element(Invariant::angle, {2, 0, 3}, material);
  return net;
}

std::vector<bool> alive(const Simulation& simulation) {
  std::vector<bool> found;
  for (ElementIndex e = 0; e < simulation.element_count(); ++e) found.push_back(simulation.element_alive(e));
  return found;
}

}  // namespace

TEST_CASE("an element that contains both ends of a removed spring is removed with it") {
  struct Case {
    SpringIndex spring;
    std::vector<bool> left;
  };
  for (const Case& c : {Case{0, {false, false, false, true}}, Case{1, {false, false, true, true}},
                        Case{3, {false, true, false, false}}}) {
    CAPTURE(c.spring);
    Simulation simulation = simulate(two_triangles(), recurrent(newton, 1e-9), 0.01);
    CHECK(simulation.cut({c.spring}) == 1);
    CHECK(alive(simulation) == c.left);
    std::size_t element_events = 0;
    for (const Event& event : simulation.events()) {
      CHECK(event.kind == Event::Kind::cut);
      if (event.element) CHECK_FALSE(simulation.element_alive(event.index));
      element_events += event.element ? 1 : 0;
    }
    CHECK(element_events == static_cast<std::size_t>(std::count(c.left.begin(), c.left.end(), false)));
    simulation.step();
    CHECK(simulation.element_force(0) == 0.0);
  }
}

TEST_CASE("a polygon cuts elements that it crosses, with springs or without") {
  Network net = two_triangles();
  const MaterialIndex material = net.add_material(damped(1.0, 0.0));
  for (const Vector3& p : {Vector3(5, 0, 0), Vector3(6, 0, 0), Vector3(5, 1, 0), Vector3(5, 0, 1)})
    net.add_node(point(p));
  net.add_element(Invariant::volume, {4, 5, 6, 7}, material);  // 4: without any spring
  Simulation simulation = simulate(net, recurrent(newton, 1e-9), 0.01);
  CHECK(simulation.cut_polygon({{5.5, -1, -1}, {5.5, 1, -1}, {5.5, 1, 1}, {5.5, -1, 1}}) == 0);
  CHECK(alive(simulation) == std::vector<bool>{true, true, true, true, false});
  CHECK(simulation.cut_polygon({{-1, 0.5, -1}, {2, 0.5, -1}, {2, 0.5, 1}, {-1, 0.5, 1}}) == 2);
  CHECK(alive(simulation) == std::vector<bool>{false, false, true, false, false});
}

TEST_CASE("a spring between the ends of an angle, or the tips of a hinge, is none of its sides") {
  Network net = two_triangles();
  const SpringIndex between = net.add_spring(2, 3, 0);  // the ends of the angle {2, 0, 3}, the tips of the hinge
  Simulation simulation = simulate(net, recurrent(newton, 1e-9), 0.01);
  CHECK(simulation.cut({between}) == 1);
  CHECK(alive(simulation) == std::vector<bool>(4, true));
  Network chain;
  for (const Vector3& p : {Vector3(-1, 1, 0), Vector3(0, 0, 0), Vector3(1, 1, 0)}) chain.add_node(point(p));
  const MaterialIndex material = chain.add_material(damped(1.0, 0.0));
  chain.add_spring(0, 1, material);
  chain.add_spring(1, 2, material);
  chain.add_element(Invariant::angle, {0, 1, 2}, material);
  Simulation other = simulate(chain, recurrent(newton, 1e-9), 0.01);
  CHECK(other.cut_polygon({{0, 0.5, -1}, {0, 2, -1}, {0, 2, 1}, {0, 0.5, 1}}) == 0);  // between the arms
  CHECK(other.element_alive(0));
  CHECK(other.cut_polygon({{0.5, 0, -1}, {0.5, 2, -1}, {0.5, 2, 1}, {0.5, 0, 1}}) == 1);  // across one of them
  CHECK_FALSE(other.element_alive(0));
}

TEST_CASE("a filling leaks when a spring of its skin is cut, not when another is") {
  const TriangleMesh mesh = icosphere(1, 1.0);
  Network net = filled(mesh, 1.0, 5.0, 10.0, 0.1);
  net.set_reference(0, 1.5 * net.elements()[0].reference);
  const SpringIndex inner = net.add_spring(0, 3, 0);  // through the inside
  for (const double rule : {block, coloured, newton}) {
    Simulation simulation = simulate(net, recurrent(rule, 1e-9), 0.01);
    const double volume = simulation.element_value(0);
    for (int i = 0; i < 5; ++i) simulation.step();
    CHECK(simulation.element_value(0) > volume);
    CHECK(simulation.element_force(0) < 0.0);  // it presses outwards
    simulation.cut({inner});
    CHECK(simulation.element_alive(0));
    simulation.step();
    simulation.cut({7});
    CHECK_FALSE(simulation.element_alive(0));
    REQUIRE(simulation.events().size() == 3);
    CHECK(simulation.events().back().element);
    CHECK(simulation.step().outcome == Outcome::settled);
    CHECK(simulation.element_force(0) == 0.0);
  }
}

TEST_CASE("an element ruptures by its own law, at the same time in the network and in CVODE") {
  // A tip moves away from a base of 1.6 m with 1 m/s, nearly without resistance: the area 0.8 z reaches what the law
  // bears where z is 1.5 + t.
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1.6, 0, 0)}) net.fix(net.add_node(point(p)));
  net.add_node(point({0.4, 0, 1.5}, 1.0, {0, 0, 1}));
  const LawUse law{"rupturing", {{"stiffness", 1e-9}, {"strength", 1e-9}, {"breaks_in_compression", 0.0}}};
  // Breaks where the force is the strength: stretched by 1 m^2 to 2.2 m^2, at z = 2.75.
  net.add_element(Invariant::area, {0, 1, 2}, net.add_material({law, std::nullopt}), 1.2);
  for (const LawUse& integrator : {cvode(1e-9), recurrent(newton, 1e-9)}) {
    Simulation simulation = simulate(net, integrator, 0.01);
    simulation.advance_to(1.2);
    CHECK(simulation.element_alive(0));
    simulation.advance_to(1.3);
    CHECK_FALSE(simulation.element_alive(0));
    REQUIRE(simulation.events().size() == 1);
    const Event& event = simulation.events()[0];
    CHECK(event.kind == Event::Kind::ruptured);
    CHECK(event.element);
    CHECK(event.index == 0);
    // CVODE to the accuracy of its root; the network at the end of the step, here or the next one.
    CHECK(std::abs(event.time - 1.25) <= (integrator.id == "cvode" ? 1e-6 : 0.01 + 1e-9));
  }
}

TEST_CASE("a failure names the element") {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)})
    net.add_node(point(p));
  // The exponential of a volume over its reference is infinite.
  net.add_element(Invariant::volume, {0, 1, 2, 3},
                  net.add_material({LawUse{"exponential", {{"stiffness", 1.0}, {"exponent", 1.0}}}, std::nullopt}),
                  1e-200);
  const auto run = [&] { simulate(net, recurrent(newton, 1e-9), 0.01).step(); };
  CHECK_THROWS_WITH_AS(run(), doctest::Contains("element 0 (nodes 0, 1, 2 and 3; volume 0.16"), Error);
}

TEST_CASE("a host reads values and forces of elements") {
  const Network net = all_kinds(5);
  const Simulation simulation = simulate(net, recurrent(newton, 1e-9), 0.01);
  for (ElementIndex e = 0; e < simulation.element_count(); ++e) {
    const Element& element = net.elements()[e];
    std::vector<Vector3> corners;
    for (const NodeIndex k : element.nodes) corners.push_back(net.nodes()[k].position);
    CHECK(simulation.element_value(e) == doctest::Approx(net.value_of(element)).epsilon(1e-12));
    const LawUse& law = *net.materials()[element.material].spring;
    const double x = net.value_of(element) - element.reference;
    // At rest a linear viscosity adds d q'.
    if (!net.materials()[element.material].viscosity)
      CHECK(simulation.element_force(e) ==
            doctest::Approx(law.parameters.at("stiffness") * x + law.parameters.at("cubic") * x * x * x));
  }
  CHECK_THROWS_AS(static_cast<void>(simulation.element_value(1000)), Error);
}
