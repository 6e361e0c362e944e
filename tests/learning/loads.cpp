// Loads that are learned, as factors of those of the network.

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "learning_nets.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

// A filled block on which a force, a traction and a pressure that follows its faces act, each with a course of its own.
Network loaded() {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 3, 3};
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(80.0, 1.0)));
  for (NodeIndex k = 0; k < 9; ++k) net.fix(k);
  Load force, traction, pressure;
  force.nodes = {26, 25};
  force.force = {4.0, 0, 0};
  force.from = 0.1;
  for (const Face& face : net.faces()) {
    const auto is_at = [&](int axis, double place) {
      return std::all_of(face.begin(), face.end(), [&](NodeIndex k) { return net.nodes()[k].position[axis] == place; });
    };
    if (is_at(2, 2.0)) traction.faces.push_back(face);
    if (is_at(0, 2.0)) pressure.faces.push_back(face);
  }
  traction.traction = {0, 0.5, 0};
  traction.course.frequency = 2.0;
  pressure.pressure = 0.8;
  pressure.follow = true;
  pressure.course.ramp = 0.2;
  pressure.from = 0.0;
  for (const Load& each : {force, traction, pressure}) net.add_load(each);
  return net;
}

Observations moving_with(const Network& net, const std::vector<double>& factors, const SimulationOptions& options) {
  Simulation real(net, plugins(), options);
  for (std::size_t k = 0; k < factors.size(); ++k) real.set_load_factor(k, factors[k]);
  return observe(real, 20, from_to(9, net.nodes().size()));
}

}  // namespace

TEST_CASE("loads are recovered from the motion that they make, and written with it") {
  const Network net = loaded();
  const SimulationOptions options = to_learn_with(0.5, 0.02);
  const std::vector<double> factors{1.7, -0.4, 2.5};
  const Experiment seen = experiment(net, options, moving_with(net, factors, options));
  const std::vector<Learnable> loads{select_learnable(net, *plugins(), "load")};
  const LearnedNet learned = learn({seen}, plugins(), loads);
  CAPTURE(learned.reason);
  CHECK(learned.undetermined == 0);
  REQUIRE(learned.parameters.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(learned.parameters[k].start == 1.0);
    CHECK(learned.parameters[k].value == doctest::Approx(factors[k]).epsilon(1e-7));
  }
  CHECK(to_json(learned).find("\"load\": 2") != std::string::npos);
  const Network written = with_values(seen.network, plugins(), loads, learned.values);
  REQUIRE(written.loads().size() == 3);
  CHECK(written.loads()[0].force[0] == doctest::Approx(1.7 * 4.0).epsilon(1e-7));
  CHECK(written.loads()[1].traction[1] == doctest::Approx(-0.4 * 0.5).epsilon(1e-7));
  CHECK(written.loads()[2].pressure == doctest::Approx(2.5 * 0.8).epsilon(1e-7));
  // With a force as it is known, masses have their scale.
  Learnable mass = select_learnable(net, *plugins(), "mass:together"),
            stiffness = select_learnable(net, *plugins(), "spring.stiffness:together"),
            damping = select_learnable(net, *plugins(), "viscosity.damping:together");
  CHECK(learn({seen}, plugins(), {mass, stiffness, damping, loads[0]}).undetermined == 1);
  CHECK(
      learn({seen}, plugins(), {mass, stiffness, damping, select_learnable(net, *plugins(), "load@1")}).undetermined ==
      0);
}

TEST_CASE("a load's factor is that of its forces, saved with the state") {
  Network net;
  net.add_node(point({0, 0, 0}, 2.0));
  Load load;
  load.nodes = {0};
  load.force = {0, 0, 4.0};
  net.add_load(load);
  Simulation simulation(net, plugins(), to_learn_with(0.5, 0.1));
  CHECK(simulation.load_factor(0) == 1.0);
  simulation.set_load_factor(0, 3.0);
  const std::string saved = simulation.save();
  simulation.advance_to(1.0);
  CHECK(simulation.position(0)[2] == doctest::Approx(0.5 * 3.0 * 4.0 / 2.0).epsilon(1e-12));
  simulation.set_load_factor(0, 0.0);
  simulation.restore(saved);
  CHECK(simulation.load_factor(0) == 3.0);
  simulation.advance_to(1.0);
  CHECK(simulation.position(0)[2] == doctest::Approx(3.0).epsilon(1e-12));
  CHECK_THROWS_AS(simulation.set_load_factor(1, 1.0), Error);
  CHECK_THROWS_AS(simulation.set_load_factor(0, std::nan("")), Error);
}

TEST_CASE("loads that are not there are refused") {
  const Network net = loaded();
  const auto refused = [&](const Network& of, const char* text) {
    return refusal_of([&] { static_cast<void>(select_learnable(of, *plugins(), text)); });
  };
  CHECK(refused(net, "load@3").find("0 to 2") != std::string::npos);
  CHECK(refused(net, "load@block").find("number of a load") != std::string::npos);
  CHECK(refused(oscillator(damped(1, 1), 1, 1), "load").find("no loads") != std::string::npos);
  Learnable field = select_learnable(net, *plugins(), "load");
  field.field_degree = 1;
  const SimulationOptions options = to_learn_with(0.5, 0.02);
  const std::string told = refusal_of(
      [&] { static_cast<void>(learn({experiment(net, options, moving_with(net, {}, options))}, plugins(), {field})); });
  CHECK(told.find("are at no place") != std::string::npos);
}
