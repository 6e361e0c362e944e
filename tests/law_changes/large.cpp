// Changes in nets of several units, with springs from one to others, in several threads and without a matrix; and of
// laws with internal states.

#include <doctest/doctest.h>

#include "generator.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr auto spring_function = ComponentKind::spring_function;

// A block of some ten thousand nodes, all springs alike, and springs across it.
struct Block {
  Network net;
  std::vector<double> stiffness, rest_length;

  Block() {
    Lattice lattice;
    lattice.nodes = {26, 22, 20};
    lattice.diagonals = Diagonals::space;
    net.add_lattice("block", lattice, Node{}, net.add_material(damped(200.0, 1.0)));
    Dice dice(3);
    const auto nodes = static_cast<std::uint32_t>(net.nodes().size());
    for (int i = 0; i < 300; ++i) {
      const NodeIndex a = dice.below(nodes), b = dice.below(nodes);
      if (a != b) net.add_spring(a, b, net.add_material(damped(200.0, 1.0)));
    }
    for (NodeIndex k = 0; k < nodes; ++k) {
      Node node = net.nodes()[k];
      node.velocity = dice.in_box(0.2);
      net.set_node(k, node);
    }
    stiffness.assign(net.springs().size(), 200.0);
    for (SpringIndex s = 0; s < net.springs().size(); ++s) rest_length.push_back(net.springs()[s].rest_length);
  }
  void change(Dice& dice, Simulation& simulation, std::size_t count) {
    std::vector<SpringIndex> springs;
    std::vector<double> values;
    for (std::size_t i = 0; i < count; ++i) {
      springs.push_back(dice.below(static_cast<std::uint32_t>(stiffness.size())));
      values.push_back(dice.between(150.0, 250.0));
      stiffness[springs.back()] = values.back();
    }
    simulation.set_parameter(springs, spring_function, "stiffness", values);
    for (std::size_t i = 0; i < count; ++i) values[i] = rest_length[springs[i]] = dice.between(0.95, 1.05);
    simulation.set_rest_lengths(springs, values);
  }
  [[nodiscard]] Network built(const Simulation& at) const {
    Network result;
    for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
      Node node = net.nodes()[k];
      node.position = at.position(k);
      node.velocity = at.velocity(k);
      result.add_node(node);
    }
    for (SpringIndex s = 0; s < net.springs().size(); ++s) {
      const Spring spring = net.springs()[s];
      if (at.alive(s))
        result.add_spring(spring.first, spring.second, result.add_material(damped(stiffness[s], 1.0)), rest_length[s]);
    }
    return result;
  }
};

double difference(const ConstNodeMap& a, const std::vector<std::uint32_t>& columns_a, const ConstNodeMap& b,
                  const std::vector<std::uint32_t>& columns_b) {
  return (a(Eigen::all, columns_a) - b(Eigen::all, columns_b)).cwiseAbs().maxCoeff();
}

Simulation start(const Network& net, const LawUse& integrator, double step, unsigned threads) {
  SimulationOptions options;
  options.time_step = step;
  options.integrator = integrator;
  options.threads = threads;
  return {net, plugins(), options};
}

}  // namespace

TEST_CASE("changes in several units and threads are those of a network that is built so") {
  for (const LawUse& integrator : {single_sweep(), recurrent(newton, 1e-9)}) {
    Block block;
    Simulation own = start(block.net, integrator, 0.001, 2);
    Dice dice(5);
    for (int round = 0; round < 2; ++round) {
      own.step();
      block.change(dice, own, 1500);
      std::vector<SpringIndex> cut;
      for (int i = 0; i < 200; ++i) cut.push_back(dice.below(static_cast<std::uint32_t>(own.spring_count())));
      own.cut(cut);
    }
    Simulation fresh = start(block.built(own), integrator, 0.001, 1);
    CHECK(difference(own.forces(), own.columns(), fresh.forces(), fresh.columns()) < 1e-11);
    for (int i = 0; i < 2; ++i) {
      own.step();
      fresh.step();
    }
    CHECK(difference(own.positions(), own.columns(), fresh.positions(), fresh.columns()) < 1e-10);

    Simulation one = start(block.net, integrator, 0.001, 1);
    const std::string saved = own.save();
    one.restore(saved);
    own.step();
    one.step();
    CHECK(difference(own.positions(), own.columns(), one.positions(), one.columns()) == 0.0);
    CHECK(difference(own.forces(), own.columns(), one.forces(), one.columns()) == 0.0);
  }
}

TEST_CASE("laws with internal states go on with theirs") {
  constexpr NodeIndex pairs = 60;
  const auto material = [](double stiffness, double time) {
    return Material{LawUse{"maxwell", {{"stiffness", stiffness}, {"relaxation_time", time}}},
                    LawUse{"linear", {{"damping", 0.1}}}};
  };
  for (const LawUse& integrator :
       {recurrent(newton, 1e-11), recurrent(coloured, 1e-12), cvode(1e-10), LawUse{"verlet", {{"substeps", 10}}}}) {
    CAPTURE(integrator.id);
    Network net, built;
    for (Network* const each : {&net, &built})
      for (NodeIndex k = 0; k < pairs; ++k) {
        each->add_node(point({0, double(k), 0}));
        each->add_node(point({1.3, double(k), 0}, 1.0, {0.2, 0, 0}));
      }
    std::vector<SpringIndex> changed;
    for (SpringIndex s = 0; s < pairs; ++s) {
      net.add_spring(2 * s, 2 * s + 1, net.add_material(material(30.0, 0.2)), 1.0);
      const bool is_other = s % 3 == 1;
      if (is_other) changed.push_back(s);
      built.add_spring(2 * s, 2 * s + 1, built.add_material(is_other ? material(80.0, 0.05) : material(30.0, 0.2)),
                       1.0);
    }
    Simulation own = simulate(net, integrator, 0.005), fresh = simulate(built, integrator, 0.005);
    own.set_parameter(changed, spring_function, "stiffness", {80.0});
    own.set_parameter(changed, spring_function, "relaxation_time", {0.05});
    own.cut({4, 5});
    fresh.cut({4, 5});
    for (int i = 0; i < 20; ++i) {
      own.step();
      fresh.step();
    }
    for (SpringIndex s = 0; s < pairs; ++s) {
      CHECK(own.tension(s) == doctest::Approx(fresh.tension(s)).epsilon(1e-7));
      CHECK(own.internal_states(s).at(0) == doctest::Approx(fresh.internal_states(s).at(0)).epsilon(1e-7));
    }
  }
}

// Their systems have no matrix, and nothing is linearised between a change and the step after it.
TEST_CASE("large blocks that slide go on after their springs have changed and some were cut") {
  const auto slid = [](double update) {
    Network net;
    Lattice lattice;
    lattice.nodes = {8, 7, 6};
    lattice.diagonals = Diagonals::space;
    lattice.spacing = {0.1, 0.1, 0.1};
    net.add_lattice("block", lattice, Node{}, net.add_material(damped(200.0, 1.0)));
    for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
      Node node = net.nodes()[k];
      node.velocity = {0.5, 0.1, 0.0};
      net.set_node(k, node);
    }
    net.set_gravity({0, 0, -9.81});
    Plane table;
    table.name = "table";
    table.friction = {Friction::Kind::coulomb, 0.2};
    net.add_plane(table);
    SimulationOptions options;
    options.time_step = 0.01;
    options.integrator = recurrent(update, 1e-9);
    Simulation simulation(std::make_shared<const Network>(net), plugins(), options);
    std::vector<SpringIndex> some;
    for (SpringIndex k = 0; k < net.springs().size(); k += 5) some.push_back(k);
    for (int step = 0; step < 8; ++step) {
      simulation.step();
      simulation.set_parameter(some, spring_function, "stiffness",
                               std::vector<double>(some.size(), 180.0 - 5.0 * step));
      if (step % 2 == 1) simulation.cut({static_cast<SpringIndex>(3 + 10 * step)});
    }
    std::vector<Vector3> places;
    for (NodeIndex k = 0; k < net.nodes().size(); ++k) places.push_back(simulation.position(k));
    return places;
  };
  const std::vector<Vector3> by_newton = slid(newton), by_sweeps = slid(wavefront);
  double greatest = 0.0;
  for (std::size_t k = 0; k < by_newton.size(); ++k)
    greatest = std::max(greatest, (by_newton[k] - by_sweeps[k]).norm());
  // Both settle to 1e-9 N, of nodes of 1 kg, in 8 steps.
  CHECK(greatest <= 1e-9);
}
