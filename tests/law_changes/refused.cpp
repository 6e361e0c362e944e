// Changes that are refused, and leave the simulation as it was.

#include <string>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "facts.hpp"
#include "mixed_net.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {}  // namespace

TEST_CASE("errors name the spring, the law, the parameter and the nearest names; nothing is changed") {
  const MixedNet net(true, 3);
  Simulation simulation = simulate(net.base(), recurrent(synchronous, 1e-9), 0.001);
  Simulation other = simulate(net.base(), recurrent(synchronous, 1e-9), 0.001);
  const auto spring = ComponentKind::spring_function, viscosity = ComponentKind::viscosity_function;
  const auto last = static_cast<SpringIndex>(simulation.spring_count() - 1);

  std::string text = refusal_of([&] { simulation.set_parameter({1, 2}, spring, "stifness", {3.0}); });
  CHECK_MESSAGE((has(text, "spring 1") && has(text, "'linear'") && has(text, "stiffness")), text);
  text = refusal_of([&] { simulation.set_parameter({1, 2}, spring, "stiffness", {3.0, -1.0}); });
  CHECK_MESSAGE((has(text, "spring 2") && has(text, "'stiffness'") && has(text, "-1")), text);
  text = refusal_of([&] { simulation.set_parameter({1, 2}, spring, "stiffness", {3.0, 1.0, 2.0}); });
  CHECK_MESSAGE((has(text, "3 values") && has(text, "2 springs")), text);
  text = refusal_of([&] { simulation.set_parameter({1, 20000}, spring, "stiffness", {3.0}); });
  CHECK_MESSAGE(has(text, "spring 20000 does not exist"), text);
  text = refusal_of([&] { simulation.set_parameter({1}, ComponentKind::neuron, "drag", {3.0}); });
  CHECK_MESSAGE(has(text, "neuron"), text);
  text = refusal_of([&] { simulation.set_element_parameter({0}, viscosity, "damping", {3.0}); });
  CHECK_MESSAGE(has(text, "element 0 has no viscosity function"), text);
  text = refusal_of([&] { simulation.set_law_input({last, 1}, spring, "activation", {0.5}); });
  CHECK_MESSAGE((has(text, "spring 1") && has(text, "no input 'activation'")), text);
  text = refusal_of([&] { simulation.set_law_input({last}, spring, "activation", {1.5}); });
  CHECK_MESSAGE((has(text, "activation") && has(text, "1.5")), text);
  text = refusal_of([&] { simulation.set_rest_lengths({1, last}, {1.0, 0.0}); });
  CHECK_MESSAGE((has(text, "muscle") && has(text, "rest length")), text);
  text = refusal_of([&] { simulation.set_rest_lengths({1}, {-1.0}); });
  CHECK_MESSAGE(has(text, "0 m or more"), text);
  text = refusal_of([&] { simulation.set_references({0, 1}, {1.0, std::nan("")}); });
  CHECK_MESSAGE(has(text, "element 1"), text);
  text = refusal_of([&] { simulation.set_neuron_parameter({0, 1}, "drg", {1.0}); });
  CHECK_MESSAGE((has(text, "node 0") && has(text, "dragged") && has(text, "drag")), text);
  text = refusal_of([&] { simulation.set_neuron_parameter({0, 1}, "drag", {1.0, -1.0}); });
  CHECK_MESSAGE(has(text, "node 1"), text);
  text = refusal_of([&] { simulation.set_masses({0, 1}, {1.0, 0.0}); });
  CHECK_MESSAGE((has(text, "node 1") && has(text, "above 0 kg")), text);
  text = refusal_of([&] { simulation.set_masses({0, 1}, {}); });
  CHECK_MESSAGE(has(text, "0 values"), text);
  text = refusal_of([&] { simulation.remove_elements({0, 900}); });
  CHECK_MESSAGE(has(text, "element 900 does not exist"), text);
  text = refusal_of([&] { simulation.remove_nodes({0, 9000}); });
  CHECK_MESSAGE(has(text, "node 9000 does not exist"), text);
  CHECK(has(refusal_of([&] { static_cast<void>(simulation.parameter(0, spring, "damping")); }), "its parameters"));

  for (int i = 0; i < 5; ++i) {
    simulation.step();
    other.step();
  }
  CHECK(distance(simulation, other) == 0.0);
}

TEST_CASE("a law's own check refuses a value before anything is changed") {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_node(point({1, 0, 0}));
  net.add_node(point({2, 0, 0}));
  net.add_rigid(1, 2);
  net.add_spring(0, 1, net.add_material(damped(1.0, 0.0)));
  Simulation simulation = simulate(net, single_sweep(), 0.001);
  const std::string text = refusal_of([&] { simulation.remove_nodes({0, 2}); });
  CHECK_MESSAGE((has(text, "node 2") && has(text, "rigid")), text);
  CHECK(simulation.alive(0));
}
