// The law `table` in networks: against the laws that its points come from, its energy, and the same bits everywhere.
#include <cmath>
#include <functional>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "law_call.hpp"
#include "methods.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Points of a force over the elongation, m.
LawUse sampled(const std::function<double(double)>& force, double from, double until, int pieces) {
  std::vector<double> elongations, forces;
  for (int k = 0; k <= pieces; ++k) {
    elongations.push_back(from + (until - from) * k / pieces);
    forces.push_back(force(elongations.back()));
  }
  return {"table", {}, {{"elongations", elongations}, {"forces", forces}}};
}

Network swinging(const LawUse& spring) {
  Network net;
  const MaterialIndex material = net.add_material({spring, LawUse{"linear", {{"damping", 0.3}}}});
  net.add_lattice("net", {{3, 3, 2}, Vector3::Ones(), Vector3::Zero(), Diagonals::space}, Node{}, material);
  net.fix(0);
  net.set_gravity({0.1, 0.0, -0.4});
  return net;
}

Eigen::MatrixXd course(const Network& net, const LawUse& integrator, double until) {
  Simulation simulation = simulate(net, integrator, 0.02);
  simulation.advance_to(until);
  return simulation.positions();
}

// Springs side by side with fixed ends, rest length 1 m.
Network stretched(const LawUse& law, const std::vector<double>& elongations) {
  Network net;
  const MaterialIndex material = net.add_material({law, std::nullopt});
  for (const double x : elongations) {
    const double y = static_cast<double>(net.nodes().size());
    for (const double end : {0.0, 1.0 + x}) {
      Node node = point({end, y, 0});
      node.fixed = true;
      net.add_node(node);
    }
    const auto last = static_cast<NodeIndex>(net.nodes().size() - 1);
    net.add_spring(last - 1, last, material, 1.0);
  }
  net.add_node(point({0, -5, 0}));  // something that moves
  return net;
}

}  // namespace

TEST_CASE("points on a line are the linear law, in every integrator and update rule") {
  const LawUse linear{"linear", {{"stiffness", 20.0}}};
  const LawUse line = sampled([](double x) { return 20.0 * x; }, -0.31, 0.17, 7);  // the springs go beyond both ends
  std::vector<Method> methods = all_methods(1e-11);
  methods.push_back({"verlet", Order::reference, {"verlet", {}}});
  for (const char* rule : update_rules)
    methods.push_back({rule, Order::fixed_point, recurrent(update_named(rule), 1e-11)});
  for (const Method& method : methods) {
    CAPTURE(method.name);
    const double tolerance = method.integrator.id == "cvode" ? 1e-7 : 1e-10;
    const Eigen::MatrixXd reference = course(swinging(linear), method.integrator, 1.0);
    CHECK((course(swinging(line), method.integrator, 1.0) - reference).cwiseAbs().maxCoeff() < tolerance);
    CHECK((reference - course(swinging(linear), method.integrator, 0.0)).cwiseAbs().maxCoeff() > 0.1);  // it moved
  }
}

// Slopes are those of parabolas, off by O(h^2): see MonotoneCubic.
TEST_CASE("tensions converge to the exponential law with the third order, energies with the fourth") {
  const LawUse exponential{"exponential", {{"stiffness", 30.0}, {"exponent", 4.0}}};
  std::vector<double> elongations;
  for (int k = 0; k < 200; ++k) elongations.push_back(-0.3 + 0.0041 * k);
  std::vector<double> tensions, energies, exact_tensions, exact_energies;
  Simulation exact = simulate(stretched(exponential, elongations), single_sweep(), 0.01);
  exact.tensions(exact_tensions);
  exact.spring_energies(exact_energies);
  double tension_error[2], energy_error[2];
  for (const int k : {0, 1}) {
    const LawUse law = sampled([](double x) { return 30.0 / 4.0 * std::expm1(4.0 * x); }, -0.4, 0.6, k == 0 ? 50 : 100);
    Simulation simulation = simulate(stretched(law, elongations), single_sweep(), 0.01);
    simulation.tensions(tensions);
    simulation.spring_energies(energies);
    tension_error[k] = energy_error[k] = 0.0;
    for (std::size_t s = 0; s < elongations.size(); ++s) {
      tension_error[k] = std::max(tension_error[k], std::abs(tensions[s] - exact_tensions[s]));
      energy_error[k] = std::max(energy_error[k], std::abs(energies[s] - exact_energies[s]));
    }
  }
  CHECK(std::log2(tension_error[0] / tension_error[1]) == doctest::Approx(3.0).epsilon(0.1));
  CHECK(std::log2(energy_error[0] / energy_error[1]) == doctest::Approx(4.0).epsilon(0.1));
  CHECK(tension_error[1] < 1e-3);
}

TEST_CASE("a measured spring keeps its energy") {
  // Stiffens in tension, softens in compression, with a level piece.
  const LawUse law{
      "table",
      {},
      {{"elongations", {-0.6, -0.3, -0.1, 0.0, 0.1, 0.2, 0.5}}, {"forces", {-3, -2.5, -1, 0, 1.5, 1.5, 9}}}};
  for (const double step : {0.01, 0.005}) {
    Simulation simulation = simulate(oscillator({law, std::nullopt}, 0.5, 0.4), {"verlet", {}}, step);
    const double start = simulation.potential_energy();
    double largest = 0.0;
    for (int k = 0; k < 500; ++k) {
      simulation.step();
      largest = std::max(largest, std::abs(simulation.potential_energy() + simulation.kinetic_energy() - start));
    }
    CHECK(start > 0.5);
    CHECK(largest < 60.0 * step * step);  // second order: bounded, and shrinks with the square of the step
    CHECK(largest > 0.0);
  }
  Simulation reference = simulate(oscillator({law, std::nullopt}, 0.5, 0.4), cvode(1e-9), 0.01);
  const double start = reference.potential_energy();
  reference.advance_to(3.0);
  CHECK(reference.potential_energy() + reference.kinetic_energy() == doctest::Approx(start).epsilon(1e-6));
}

TEST_CASE("beyond the points the tension goes on, or stays") {
  LawUse law = sampled([](double x) { return 5.0 * x * std::abs(x); }, -0.2, 0.2, 10);
  const std::vector<double> elongations{-0.4, 0.2, 0.4, 0.5};
  const Simulation linear = simulate(stretched(law, elongations), single_sweep(), 0.01);
  law.parameters["beyond"] = 1;
  const Simulation constant = simulate(stretched(law, elongations), single_sweep(), 0.01);
  CHECK(linear.tension(3) - linear.tension(2) == doctest::Approx(0.5 * (linear.tension(2) - linear.tension(1))));
  CHECK(linear.tension(2) > 0.55);
  CHECK(constant.tension(0) == doctest::Approx(-0.2));
  CHECK(constant.tension(2) == doctest::Approx(0.2));
  CHECK(constant.tension(3) == constant.tension(2));
}

TEST_CASE("different tables in one network do not mix") {
  const LawUse soft = sampled([](double x) { return 10.0 * x; }, -0.5, 0.5, 3);
  const LawUse stiff = sampled([](double x) { return 40.0 * std::sinh(x); }, -0.5, 0.5, 40);
  LawUse level = stiff;
  level.parameters["beyond"] = 1;
  const auto chain_of = [](Network& net, const LawUse& law, double y) {
    const MaterialIndex material = net.add_material({law, LawUse{"linear", {{"damping", 0.2}}}});
    const auto first = static_cast<NodeIndex>(net.nodes().size());
    for (NodeIndex k = 0; k < 6; ++k) {
      net.add_node(point({1.0 * k, y, 0}, 1.0, {k == 5 ? 4.0 : 0.0, 0, 0}));
      if (k > 0) net.add_spring(first + k - 1, first + k, material);
    }
    net.fix(first);
  };
  const std::vector<LawUse> laws{soft, stiff, level, soft};
  Network together;
  for (std::size_t k = 0; k < laws.size(); ++k) chain_of(together, laws[k], static_cast<double>(k));
  for (const LawUse& integrator : {LawUse{"verlet", {}}, single_sweep()}) {
    const Eigen::MatrixXd all = course(together, integrator, 1.0);
    for (std::size_t k = 0; k < laws.size(); ++k) {
      Network own;
      chain_of(own, laws[k], static_cast<double>(k));
      CHECK(course(own, integrator, 1.0) == all.middleCols(static_cast<Eigen::Index>(6 * k), 6));
    }
    CHECK(all.row(0).segment(0, 6) == all.row(0).segment(18, 6));
    for (const int k : {1, 2}) CHECK(all.row(0).segment(0, 6) != all.row(0).segment(6 * k, 6));
    CHECK(all.row(0).segment(6, 6) != all.row(0).segment(12, 6));
  }
}

TEST_CASE("the same bits for any number of threads and every instruction set") {
  Network net;
  Lattice lattice;
  lattice.nodes = {20, 20, 40};
  lattice.diagonals = Diagonals::space;
  const LawUse law = sampled([](double x) { return 50.0 * std::sinh(x); }, -0.2, 0.2, 37);
  net.add_lattice("block", lattice, Node{}, net.add_material({law, LawUse{"linear", {{"damping", 1.0}}}}));
  net.fix(0);
  net.set_gravity({0.3, 0.1, -1.0});
  const auto run = [&](const LawUse& integrator, unsigned threads, InstructionSet set) {
    SimulationOptions options;
    options.time_step = 0.02;
    options.integrator = integrator;
    options.threads = threads;
    options.instruction_set = set;
    Simulation simulation(net, plugins(), options);
    for (int i = 0; i < 5; ++i) simulation.step();
    return Eigen::MatrixXd(simulation.positions());
  };
  for (const LawUse& integrator : {single_sweep(), recurrent(synchronous, 1e-6)}) {
    const Eigen::MatrixXd one = run(integrator, 1, InstructionSet::best);
    for (const unsigned threads : {2u, 4u}) CHECK(run(integrator, threads, InstructionSet::best) == one);
    CHECK(run(integrator, 1, InstructionSet::generic) == one);
  }
}

TEST_CASE("force is the derivative of the energy, stiffness that of the force, in any tile and instruction set") {
  const springnet_component& component = *plugins()->require(ComponentKind::spring_function, "table")->description;
  const springnet_law& law = test::law_of(component);
  const std::vector<double> elongations{-0.5, -0.2, 0.1, 0.3, 0.35, 0.9}, forces{-4, -1, 0.5, 2, 2, 7};
  const double* const tables[] = {elongations.data(), forces.data()};
  const std::uint64_t lengths[] = {elongations.size(), forces.size()};
  const double beyond = 0.0;
  springnet_preparation preparation{};
  preparation.struct_size = sizeof preparation;
  preparation.table_count = 2;
  preparation.tables = tables;
  preparation.lengths = lengths;
  preparation.parameters = &beyond;
  REQUIRE(law.prepare(law.context, &preparation) == SPRINGNET_OK);
  test::LawInput input;
  input.table = preparation.prepared;
  input.parameters = {{0.0}};
  input.reference = {1.0};
  for (double q = 0.2; q < 2.3; q += 0.00317) input.q.push_back(q);
  input.count = static_cast<std::uint32_t>(input.q.size());
  const test::LawAnswer answer = test::evaluate(component, input);
  REQUIRE(answer.status == SPRINGNET_OK);
  CHECK(test::same_bits(answer.energy_by_q, answer.force));
  test::LawInput before = input, after = input;
  const double h = 1e-5;
  for (double& q : before.q) q -= h;
  for (double& q : after.q) q += h;
  const test::LawAnswer low = test::evaluate(component, before), high = test::evaluate(component, after);
  for (std::uint32_t i = 0; i < input.count; ++i) {
    CHECK((high.energy[i] - low.energy[i]) / (2 * h) == doctest::Approx(answer.force[i]).epsilon(1e-7).scale(1.0));
    // The curvature jumps at points: first order there.
    CHECK((high.force[i] - low.force[i]) / (2 * h) == doctest::Approx(answer.by_q[i]).epsilon(2e-3).scale(1.0));
  }
  test::LawInput rest = input;
  rest.q = {1.0};
  rest.count = 1;
  CHECK(test::evaluate(component, rest).energy[0] == 0.0);
  for (const std::uint32_t set : test::instruction_sets())
    for (const std::uint32_t tile : {0u, 1u, 7u, 300u})
      CHECK(same_bits(answer, test::evaluate(component, input, set, tile)));
  CHECK(law.release(law.context, &preparation) == SPRINGNET_OK);
  CHECK(preparation.prepared == nullptr);
}
