// The examples of the author's guide in the engine.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/inspection.hpp>
#include <springnet/simulation.hpp>

extern "C" {
extern const springnet_plugin springnet_plugin_entry_tendon;
extern const springnet_plugin springnet_plugin_entry_brittle;
extern const springnet_plugin springnet_plugin_entry_relaxing;
extern const springnet_plugin springnet_plugin_entry_motor;
extern const springnet_plugin springnet_plugin_entry_fibre;
extern const springnet_plugin springnet_plugin_entry_skin;
extern const springnet_plugin springnet_plugin_entry_swimmer;
extern const springnet_plugin springnet_plugin_entry_euler;
extern const springnet_plugin springnet_plugin_entry_spring_by_spring;
extern const springnet_plugin springnet_plugin_entry_solid;
}

std::shared_ptr<springnet::PluginHost> plugins_with_own_laws(const std::vector<double>& measured, double gain);

namespace {
using namespace springnet;

std::shared_ptr<const PluginHost> plugins() {
  auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  for (const springnet_plugin* plugin :
       {&springnet_plugin_entry_tendon, &springnet_plugin_entry_brittle, &springnet_plugin_entry_relaxing,
        &springnet_plugin_entry_motor, &springnet_plugin_entry_fibre, &springnet_plugin_entry_skin,
        &springnet_plugin_entry_swimmer, &springnet_plugin_entry_euler, &springnet_plugin_entry_spring_by_spring,
        &springnet_plugin_entry_solid}) {
    CAPTURE(std::string(plugin->id));
    CHECK(host->add(*plugin));
  }
  return host;
}

// A lattice that swings under gravity, held at a corner.
Network swinging(const LawUse& spring, const LawUse& neuron) {
  Network network;
  const MaterialIndex material = network.add_material({spring, LawUse{"linear", {{"damping", 0.3}}}});
  Node prototype;
  prototype.neuron = network.add_neuron(neuron);
  network.add_lattice("net", {{4, 4, 3}, Vector3::Ones(), Vector3::Zero(), Diagonals::space}, prototype, material);
  network.fix(0);
  network.set_gravity({0.1, 0.0, -0.2});
  return network;
}

}  // namespace

TEST_CASE("the engine takes the laws, the neuron and the integrator of the guide") {
  const auto host = plugins();
  SimulationOptions options;
  options.time_step = 0.02;
  options.integrator = {"euler", {{"parts", 2.0}}};
  Simulation simulation(swinging({"tendon", {{"stiffness", 20.0}}}, {"swimmer", {{"drag", 0.5}}}), host, options);
  simulation.advance_to(1.0);
  CHECK(simulation.time() == doctest::Approx(1.0));
  CHECK(simulation.position(47).z() < 2.0);  // it sank
  CHECK(simulation.sweeps() == 100);         // two parts of fifty steps
}

TEST_CASE("the engine takes the laws of a host of the guide") {
  const auto host = plugins_with_own_laws({10.0, 0.0, 5.0}, 3.0);
  const auto stretched = [](const LawUse& law) {
    Network net;
    Node first, second;
    first.fixed = true;
    second.position = {1.2, 0, 0};
    second.velocity = {0.5, 0, 0};
    second.neuron = net.add_neuron({"added_mass", {}});
    net.add_node(first);
    net.add_node(second);
    net.add_spring(0, 1, net.add_material({law, LawUse{"honey", {{"drag", 0.4}}}}), 1.0);
    return net;
  };
  const double damping = 0.4 * 0.5 * 1.25;  // N, of honey at 0.5 m/s
  const Simulation polynomial(stretched({"polynomial", {{"strength", 2.0}}}), host, {});
  CHECK(polynomial.tension(0) == doctest::Approx(2.0 * (10.0 * 0.2 + 5.0 * 0.008) + damping).epsilon(1e-12));
  const Simulation gained(stretched({"gained", {{"stiffness", 2.0}}}), host, {});
  CHECK(gained.tension(0) == doctest::Approx(3.0 * 2.0 * 0.2 + damping).epsilon(1e-12));
}

TEST_CASE("the guide's integrator is the single synchronous sweep of the recurrent network, bit for bit") {
  const auto host = plugins();
  const Network network = swinging({"linear", {{"stiffness", 20.0}}}, {"point_mass", {}});
  SimulationOptions options;
  options.time_step = 0.02;
  options.integrator = {"euler", {}};
  Simulation guide(network, host, options);
  options.integrator = {"recurrent", {{"update", 0.0}, {"sweeps", 1.0}}};
  Simulation recurrent(network, host, options);
  for (int step = 0; step < 50; ++step) {
    guide.step();
    recurrent.step();
  }
  CHECK((guide.positions().array() == recurrent.positions().array()).all());
  CHECK((guide.velocities().array() == recurrent.velocities().array()).all());
}

TEST_CASE("the guide's method of one spring after another settles at the step of implicit Euler") {
  const auto host = plugins();
  Network network = swinging({"exponential", {{"stiffness", 20.0}, {"exponent", 3.0}}}, {"point_mass", {}});
  network.add_load({{47}, {0.0, 0.3, 0.0}});
  Move move;
  move.nodes = {0};
  move.motion.amplitude = {0.0, 0.05, 0.0};
  move.motion.frequency = 2.0;
  network.add_move(move);
  SimulationOptions options;
  options.time_step = 0.02;
  options.integrator = {"spring_by_spring", {{"force_tolerance", 1e-12}}};
  Simulation guide(network, host, options);
  options.integrator = {"recurrent", {{"update", 4.0}, {"force_tolerance", 1e-12}}};
  Simulation recurrent(network, host, options);
  for (int step = 0; step < 20; ++step) {
    guide.step();
    recurrent.step();
  }
  // What both leave of each step's forces, 1e-12 N, and rounding.
  CHECK((guide.positions() - recurrent.positions()).cwiseAbs().maxCoeff() <= 1e-10);
  CHECK((guide.positions() - Simulation(network, host, options).positions()).cwiseAbs().maxCoeff() > 0.01);
}

TEST_CASE("the engine breaks the guide's brittle spring, and its motor pulls") {
  const auto host = plugins();
  Network network;
  network.add_node({});
  network.add_node({.position = {1.0, 0.0, 0.0}, .velocity = {3.0, 0.0, 0.0}});
  network.fix(0);
  network.add_spring(0, 1, network.add_material({LawUse{"brittle", {{"stiffness", 4.0}, {"strength", 2.0}}}, {}}));
  SimulationOptions options;
  options.integrator = {"euler", {}};
  Simulation simulation(network, host, options);
  simulation.advance_to(1.0);
  CHECK(simulation.live_spring_count() == 0);

  // A stiffness of 20 N/m on a drive of 3 mm.
  Network driven = swinging({"motor", {{"stiffness", 20.0}}}, {"point_mass", {}});
  Input drive;
  drive.input = "drive";
  drive.springs = {0};
  drive.signal.mean = 0.003;
  driven.add_input(drive);
  const Simulation motor(driven, host, options);
  CHECK(motor.tension(0) == doctest::Approx(0.06).epsilon(1e-12));
  CHECK(motor.tension(1) == 0.0);
}

TEST_CASE("the guide's law with memory relaxes, and its integrator, which knows of no states, refuses it") {
  const auto host = plugins();
  Network network;
  network.add_node({});
  network.add_node({.position = {1.5, 0.0, 0.0}});
  network.fix(0);
  network.fix(1);
  const LawUse law{"relaxing", {{"stiffness", 4.0}, {"relaxation_time", 0.5}}};
  network.add_spring(0, 1, network.add_material({law, {}}), 1.0);
  SimulationOptions options;
  options.time_step = 0.001;
  Simulation simulation(network, host, options);
  CHECK(simulation.internal_states(0) == std::vector<double>{0.5});  // it begins without tension
  simulation.move_node(1, {2.0, 0.0, 0.0}, 0.001);
  simulation.advance_to(1.001);
  CHECK(simulation.tension(0) == doctest::Approx(4.0 * 0.5 * std::exp(-1.0 / 0.5)).epsilon(5e-3));
  options.integrator = {"euler", {}};
  CHECK_THROWS_WITH_AS(Simulation(network, host, options), doctest::Contains("does not integrate the internal state"),
                       Error);
}

TEST_CASE(
    "the guide's law in C moves a net as the shipped standard linear solid, which the SDK differentiates and steps") {
  const auto host = plugins();
  const ParameterValues values{{"stiffness", 20.0}, {"fast_stiffness", 15.0}, {"relaxation_time", 0.4}};
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    SimulationOptions options;
    options.time_step = 0.02;
    options.integrator = {"recurrent", {{"theta", theta}, {"update", 4.0}, {"force_tolerance", 1e-11}}};
    Simulation in_c(swinging({"solid_in_c", values}, {"point_mass", {}}), host, options);
    Simulation shipped(swinging({"standard_linear_solid", values}, {"point_mass", {}}), host, options);
    in_c.advance_to(1.0);
    shipped.advance_to(1.0);
    // At theta 1/2 the SDK's law, whose rates are smooth, makes another step of the states, of the same order.
    const double tolerance = theta == 1.0 ? 1e-9 : 1e-4;
    CHECK((in_c.positions() - shipped.positions()).cwiseAbs().maxCoeff() <= tolerance);
    CHECK(in_c.internal_states(0)[0] != 0.0);
  }
}

TEST_CASE("the guide's law with tables pulls by what it prepared") {
  const auto host = plugins();
  Network network;
  network.add_node({});
  network.add_node({.position = {1.5, 0.0, 0.0}});
  network.fix(0);
  // A share that grows linearly: the tension is quadratic.
  LawUse law{"fibre", {{"stiffness", 4.0}}, {{"strains", {0.0, 0.5, 1.0}}, {"shares", {0.0, 0.5, 1.0}}}};
  network.add_spring(0, 1, network.add_material({law, {}}), 1.0);
  const Simulation simulation(network, host, {});
  CHECK(simulation.tension(0) == doctest::Approx(4.0 * 0.5 * 0.5 / 2.0));
  law.tables["strains"][0] = 0.1;
  network.set_spring_material(0, network.add_material({law, {}}));
  CHECK_THROWS_WITH_AS(Simulation(network, host, {}), doctest::Contains("the first strain must be 0"), Error);
}

TEST_CASE("inspect reports the actual limit of the guide's integrator") {
  const auto host = plugins();
  Network network;
  network.add_node({});
  network.add_node({.position = {1.0, 0.0, 0.0}, .velocity = {1e-3, 0.0, 0.0}, .mass = 0.5});
  network.fix(0);
  network.add_spring(
      0, 1, network.add_material({LawUse{"linear", {{"stiffness", 8.0}}}, LawUse{"linear", {{"damping", 1.5}}}}));
  InspectionOptions asked;
  asked.integrator = {"euler", {{"parts", 3.0}}};
  const TimeConstantLimit limit = inspect(network, *host, asked).limits.front();
  CHECK(limit.name() == "euler");
  REQUIRE(limit.kind == TimeConstantLimit::Kind::known);
  // h^2 4 + h 1.5 = 1, three parts a step.
  CHECK(limit.time_constant == doctest::Approx(3.0 * (std::sqrt(1.5 * 1.5 + 16.0) - 1.5) / 8.0).epsilon(2e-3));
  REQUIRE(limit.set_by);
  CHECK(limit.set_by->node == 1);
  CHECK(limit.set_by->spring == 0u);
  for (const double share : {0.97, 1.03}) {
    SimulationOptions options;
    options.time_step = share * limit.time_constant;
    options.integrator = asked.integrator;
    Simulation simulation(network, host, options);
    for (int step = 0; step < 200; ++step) simulation.step();
    CHECK((simulation.velocity(1).norm() < 1e-3) == (share < 1.0));
  }
}

TEST_CASE("the law of the guide over several invariants, which gives its energy alone") {
  const auto host = plugins();
  Network network;
  const MaterialIndex skin =
      network.add_material({LawUse{"skin", {{"stiffness", 5.0}, {"stiffening", 2.0}}}, std::nullopt});
  const std::vector<Vector3> rest{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.2, 0.9, 0.0}};
  std::vector<Vector3> now{{0.1, 0.0, 0.2}, {1.3, 0.1, 0.0}, {0.1, 1.2, 0.3}};
  for (const Vector3& position : now) {
    Node node;
    node.position = position;
    network.add_node(node);
  }
  network.add_element(Invariant::triangle, {0, 1, 2}, skin, rest);
  // Its formula once more, by the positions.
  const auto energy = [&](const std::vector<Vector3>& p) {
    double sides = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      sides += std::pow((p[next] - p[k]).norm() - (rest[next] - rest[k]).norm(), 2.0);
    }
    const auto area = [](const std::vector<Vector3>& q) { return 0.5 * (q[1] - q[0]).cross(q[2] - q[0]).norm(); };
    return 0.5 * 5.0 * sides * (1.0 + 2.0 * std::pow(area(p) / area(rest) - 1.0, 2.0));
  };
  SimulationOptions options;
  options.time_step = 1e-3;
  options.renumber = false;
  const Simulation simulation(network, host, options);
  CHECK(simulation.potential_energy() == doctest::Approx(energy(now)).epsilon(1e-13));
  // Central differences of sixth order: what is left is rounding of the energy over the step.
  for (std::size_t k = 0; k < 3; ++k) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      const auto at = [&](double x) {
        std::vector<Vector3> moved = now;
        moved[k][c] += x;
        return energy(moved);
      };
      constexpr double h = 1e-2;
      const double slope = (45 * (at(h) - at(-h)) - 9 * (at(2 * h) - at(-2 * h)) + (at(3 * h) - at(-3 * h))) / (60 * h);
      CHECK(simulation.forces()(c, static_cast<Eigen::Index>(k)) == doctest::Approx(-slope).epsilon(1e-8));
    }
  }
}
