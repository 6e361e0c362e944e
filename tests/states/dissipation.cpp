// What laws dissipate, as the host computes it: never negative, and with it energy balances.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

#include <springnet/host_laws.hpp>

#include <doctest/doctest.h>

#include "law_call.hpp"
#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

// Of the plugins of the build tree, those whose dissipation the host knows and that promise not to add power.
std::vector<std::shared_ptr<const Component>> dissipating_laws() {
  std::vector<std::shared_ptr<const Component>> laws;
  for (const auto& component : plugins()->components()) {
    const bool spring = component->kind() == ComponentKind::spring_function;
    if (!spring && component->kind() != ComponentKind::viscosity_function) continue;
    const std::uint64_t capabilities = component->description->capabilities;
    if ((capabilities & SPRINGNET_ADDS_POWER) != 0 || (spring && (capabilities & SPRINGNET_HAS_ENERGY) == 0)) continue;
    if (component->law().table_count > 0) continue;  // the shape of its curve is the scene's
    laws.push_back(component);
  }
  return laws;
}

// Some value that the parameter, or state, may have.
double any_value(const springnet_parameter& parameter, std::mt19937& random) {
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  if (parameter.type != SPRINGNET_NUMBER) return parameter.default_value;
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const double value = between(0, 1) < 0.5 ? between(-1.0, 1.0) : std::pow(10.0, between(-2.0, 2.0));
    if (check_value(parameter, value).empty()) return value;
  }
  FAIL("no value for " << parameter.name);
  return 0.0;
}

// D = (Q - dE/dq) q' - dE/dz z' of one element of the answer, and what of it may be rounding.
struct Dissipation {
  double value, rounding;
};
Dissipation dissipation_of(const springnet::test::LawAnswer& answer, std::size_t i, double rate) {
  Dissipation sum{answer.force[i] * rate, std::abs(answer.force[i] * rate)};
  const auto subtract = [&sum](double power) {
    sum.value -= power;
    sum.rounding += std::abs(power);
  };
  if (!answer.energy_by_q.empty()) subtract(answer.energy_by_q[i] * rate);
  for (std::size_t j = 0; j < answer.energy_by_states.size(); ++j)
    subtract(answer.energy_by_states[j][i] * answer.state_rates[j][i]);
  sum.rounding *= 1e-13;
  return sum;
}

const LawUse maxwell{"maxwell", {{"stiffness", 40.0}, {"relaxation_time", 0.2}}};
const LawUse solid{"standard_linear_solid", {{"stiffness", 20.0}, {"fast_stiffness", 40.0}, {"relaxation_time", 0.2}}};
const LawUse plastic{"plastic",
                     {{"stiffness", 40.0}, {"yield_tension", 1.0}, {"hardening", 10.0}, {"relaxation_time", 0.05}}};
const LawUse damaging{
    "damaging", {{"stiffness", 40.0}, {"threshold_strain", 0.05}, {"softening_strain", 2.0}, {"relaxation_time", 0.1}}};
const LawUse hooke{"linear", {{"stiffness", 40.0}}};
const LawUse damping{"linear", {{"damping", 0.8}}};
const LawUse relative{"relative", {{"damping", 0.3}}};

// Nothing acts from outside: nodes with springs and elements of several laws, two fixed.
Network closed_net(unsigned seed) {
  std::mt19937 random(seed);
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  Network net;
  for (int k = 0; k < 27; ++k) {
    Node node = point({k % 3 + between(-0.2, 0.2), k / 3 % 3 + between(-0.2, 0.2), k / 9 + between(-0.2, 0.2)},
                      between(0.5, 1.5), {between(-0.6, 0.6), between(-0.6, 0.6), between(-0.6, 0.6)});
    node.fixed = k == 0 || k == 26;
    if (node.fixed) node.velocity = Vector3::Zero();
    net.add_node(node);
  }
  std::vector<MaterialIndex> materials;
  for (const LawUse& law : {maxwell, solid, damaging, hooke})
    for (const auto& viscosity : {std::optional<LawUse>(), std::optional(damping), std::optional(relative)})
      materials.push_back(net.add_material({law, viscosity}));
  for (std::uint32_t a = 0; a < 27; ++a)
    for (std::uint32_t b = a + 1; b < 27; ++b)
      if ((net.nodes()[a].position - net.nodes()[b].position).norm() < 1.6)
        net.add_spring(a, b, materials[random() % materials.size()]);
  const MaterialIndex angles = net.add_material(
      {LawUse{"maxwell", {{"stiffness", 2.0}, {"relaxation_time", 0.3}}}, LawUse{"linear", {{"damping", 0.05}}}});
  const MaterialIndex areas = net.add_material(
      {LawUse{"standard_linear_solid", {{"stiffness", 5.0}, {"fast_stiffness", 9.0}, {"relaxation_time", 0.1}}},
       std::nullopt});
  const MaterialIndex volumes = net.add_material({LawUse{"linear", {{"stiffness", 30.0}}}, std::nullopt});
  for (std::uint32_t a = 0; a + 13 < 27; a += 4) {
    net.add_element(Invariant::angle, {a, a + 1, a + 4}, angles);
    net.add_element(Invariant::area, {a, a + 1, a + 3}, areas);
    net.add_element(Invariant::volume, {a, a + 1, a + 3, a + 9}, volumes);
  }
  return net;
}

SimulationOptions with_energy(const LawUse& integrator, double time_step) {
  SimulationOptions options;
  options.time_step = time_step;
  options.integrator = integrator;
  options.threads = 1;
  options.dissipated_energy = true;
  return options;
}

// Greatest change of kinetic + potential + dissipated energy, and what was dissipated.
struct Balance {
  double error, dissipated;
};
Balance balance(const Network& net, const LawUse& integrator, double time_step, double until) {
  Simulation simulation(net, plugins(), with_energy(integrator, time_step));
  const auto all = [&] {
    return simulation.kinetic_energy() + simulation.potential_energy() + simulation.dissipated_energy();
  };
  const double start = all();
  Balance found{0.0, 0.0};
  while (simulation.time() < until - 1e-9) {
    simulation.step();
    found.error = std::max(found.error, std::abs(all() - start));
  }
  found.dissipated = simulation.dissipated_energy();
  return found;
}

}  // namespace

TEST_CASE("no law that promises not to add power dissipates less than nothing, at any state") {
  std::mt19937 random(5);
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const auto laws = dissipating_laws();
  CHECK(laws.size() >= 11);
  constexpr std::uint32_t count = 64;
  for (const auto& component : laws) {
    CAPTURE(component->id());
    const springnet_component& law = *component->description;
    if (component->law().invariant == SPRINGNET_SEVERAL) continue;  // tests/continuum
    double greatest = 0.0;
    for (int sample = 0; sample < 300; ++sample) {
      springnet::test::LawInput input;
      input.count = count;
      for (std::uint32_t k = 0; k < law.parameter_count; ++k)
        input.parameters.push_back({any_value(*law.parameters[k], random)});
      input.states.resize(component->law().state_count);
      input.inputs.resize(component->law().input_count);
      const bool speed = component->law().invariant == SPRINGNET_RELATIVE_SPEED;
      for (std::uint32_t i = 0; i < count; ++i) {
        input.reference.push_back(between(0.2, 2.0));
        input.rate.push_back(between(-3.0, 3.0));
        input.q.push_back(speed ? between(0.0, 3.0) : between(0.05, 4.0));
        for (std::size_t j = 0; j < input.states.size(); ++j)
          input.states[j].push_back(any_value(*component->law().states[j], random));
        for (std::size_t j = 0; j < input.inputs.size(); ++j)
          input.inputs[j].push_back(any_value(*component->law().inputs[j], random));
      }
      const springnet::test::LawAnswer answer = springnet::test::evaluate(law, input);
      REQUIRE(answer.status == SPRINGNET_OK);
      for (std::uint32_t i = 0; i < count; ++i) {
        const Dissipation found = dissipation_of(answer, i, speed ? input.q[i] : input.rate[i]);
        if (!std::isfinite(found.value)) continue;  // an exponential far beyond its range
        REQUIRE(found.value >= -found.rounding);
        greatest = std::max(greatest, found.value - found.rounding);
      }
    }
    // Elastic laws nothing, all others something.
    const bool elastic = component->kind() == ComponentKind::spring_function && component->law().state_count == 0;
    CHECK((greatest > 0.0) == !elastic);
  }
}

TEST_CASE("dissipation is never negative along a motion, also where springs are cut") {
  for (const LawUse& integrator : {recurrent(newton, 1e-9), recurrent(newton, 1e-9, {{"theta", 0.5}}),
                                   LawUse{"verlet", {}}, generalized_alpha(), single_sweep()}) {
    CAPTURE(integrator.id);
    Simulation simulation(closed_net(3), plugins(), with_energy(integrator, 0.005));
    std::vector<double> powers, energies;
    double greatest = 0.0;
    for (int step = 0; step < 200; ++step) {
      simulation.step();
      if (step % 40 == 20) simulation.cut({static_cast<SpringIndex>(step / 2), static_cast<SpringIndex>(step / 4)});
      simulation.dissipations(powers);
      double sum = 0.0;
      for (SpringIndex s = 0; s < powers.size(); ++s) {
        REQUIRE(powers[s] >= -1e-12);  // W, of springs of some N
        if (!simulation.alive(s)) REQUIRE(powers[s] == 0.0);
        sum += powers[s];
      }
      for (ElementIndex e = 0; e < simulation.element_count(); ++e) {
        const double power = simulation.element_dissipation(e);
        REQUIRE(power >= -1e-12);
        if (!simulation.element_alive(e)) REQUIRE(power == 0.0);
        sum += power;
      }
      CHECK(sum == doctest::Approx(simulation.dissipated_power()).epsilon(1e-12));
      greatest = std::max(greatest, sum);
    }
    CHECK(greatest > 0.1);
    CHECK(simulation.live_spring_count() < simulation.spring_count());
  }
}

TEST_CASE("the host's dissipation is that of the law's formula") {
  // Maxwell: k (x - z)^2 / tau; a standard linear solid the same of its fast arm; damping d v^2; relative d |v|^2.
  Network net;
  const std::vector<std::pair<Material, std::function<double(double, double)>>> cases{
      {{maxwell, std::nullopt}, [](double x, double) { return 40.0 * x * x / 0.2; }},
      {{solid, std::nullopt}, [](double x, double) { return 40.0 * x * x / 0.2; }},
      {{plastic, std::nullopt}, [](double x, double) { return 40.0 * x * (40.0 * x - 1.0) / (40.0 * 0.05); }},
      {{hooke, std::nullopt}, [](double, double) { return 0.0; }},
      {{hooke, damping}, [](double, double v) { return 0.8 * v * v; }},
      {{std::nullopt, damping}, [](double, double v) { return 0.8 * v * v; }},
      {{maxwell, relative}, [](double x, double v) { return 40.0 * x * x / 0.2 + 0.3 * (v * v + 0.25); }}};
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const double x = 0.1 + 0.05 * static_cast<double>(k), v = 0.7 - 0.3 * static_cast<double>(k);
    const double y = static_cast<double>(k);
    net.add_node(point({0, y, 0}));
    net.add_node(point({1.0 + x, y, 0}, 1.0, {v, 0.0, 0.5}));
    net.add_spring(static_cast<NodeIndex>(2 * k), static_cast<NodeIndex>(2 * k + 1), net.add_material(cases[k].first),
                   1.0);
  }
  const Simulation simulation = simulate(net, recurrent(newton, 1e-9), 0.01);
  std::vector<double> powers;
  simulation.dissipations(powers);
  for (std::size_t k = 0; k < cases.size(); ++k) {
    CAPTURE(k);
    const double x = 0.1 + 0.05 * static_cast<double>(k), v = 0.7 - 0.3 * static_cast<double>(k);
    CHECK(std::abs(powers[k] - cases[k].second(x, v)) <= 1e-12 * (1.0 + cases[k].second(x, v)));
  }
  CHECK(std::isnan(simulation.dissipated_energy()));  // not asked for
}

// One degree of freedom with laws that are linear in length and state: with theta 1/2 the balance is that of the
// discrete equations, up to what they are solved to.
TEST_CASE("energy balances to rounding where the trapezoidal rule meets linear laws") {
  for (const Material& material : {Material{maxwell, std::nullopt}, Material{solid, std::nullopt},
                                   Material{hooke, damping}, Material{solid, damping}}) {
    for (const double time_step : {0.003, 0.03}) {
      const Balance found =
          balance(oscillator(material, 1.0, 0.15, 0.5), recurrent(newton, 1e-12, {{"theta", 0.5}}), time_step, 3.0);
      CHECK(found.error < 1e-10);
      CHECK(found.dissipated > 0.2);
    }
  }
}

// Relaxation a million times as fast as the step, and damping that stops the node at once.
TEST_CASE("what stiff laws dissipate within a step is what they had") {
  const LawUse stiff{"maxwell", {{"stiffness", 40.0}, {"relaxation_time", 1e-7}}};
  for (const double theta : {0.5, 1.0}) {
    CAPTURE(theta);
    Network net = oscillator({stiff, LawUse{"linear", {{"damping", 1e5}}}}, 1.0, 0.15, 0.5);
    Simulation simulation(net, plugins(), with_energy(recurrent(newton, 1e-10, {{"theta", theta}}), 0.01));
    const double all = simulation.kinetic_energy() + simulation.potential_energy();
    for (int step = 0; step < 5; ++step) simulation.step();
    const double rest = simulation.kinetic_energy() + simulation.potential_energy();
    if (theta == 1.0) CHECK(rest < 1e-3 * all);
    CHECK(std::abs(simulation.dissipated_energy() + rest - all) < 0.01 * all);
  }
}

TEST_CASE("kinetic, potential and dissipated energy are constant to the order of the method") {
  struct Case {
    std::string name;
    Network net;
    double until;
    bool smooth;
  };
  const std::vector<Case> cases{{"maxwell", oscillator({maxwell, std::nullopt}, 1.0, 0.15, 0.5), 2.0, true},
                                {"solid", oscillator({solid, std::nullopt}, 1.0, 0.15, 0.5), 2.0, true},
                                {"plastic", oscillator({plastic, std::nullopt}, 1.0, 0.15, 0.5), 2.0, false},
                                {"damped", oscillator({hooke, damping}, 1.0, 0.15, 0.5), 2.0, true},
                                {"net", closed_net(4), 0.6, false}};
  struct Method {
    std::string name;
    LawUse integrator;
    double order;
  };
  const std::vector<Method> methods{{"theta 1", recurrent(newton, 1e-11), 1.0},
                                    {"theta 1/2", recurrent(newton, 1e-11, {{"theta", 0.5}}), 2.0},
                                    {"single sweep", single_sweep(), 1.0},
                                    {"verlet", {"verlet", {}}, 2.0},
                                    {"cvode", cvode(1e-10), 2.0}};
  for (const Case& each : cases) {
    for (const Method& method : methods) {
      CAPTURE(each.name);
      CAPTURE(method.name);
      const double time_step = method.order == 1.0 ? 0.004 : 0.02;
      const Balance coarse = balance(each.net, method.integrator, time_step, each.until);
      const Balance fine = balance(each.net, method.integrator, 0.25 * time_step, each.until);
      CAPTURE(coarse.error);
      CAPTURE(fine.error);
      CHECK(fine.dissipated > 0.05);
      CHECK(coarse.error < 0.25 * coarse.dissipated);
      // A quarter of the step: 4 or 16 times as accurate, but for the kinks of yield and damage.
      const double least = std::pow(4.0, method.order) * (each.smooth ? 0.75 : 0.5);
      CHECK(fine.error <= coarse.error / least + 1e-8);
    }
  }
}

TEST_CASE("summing up what is dissipated changes no bit of the motion, and has the same bits for all threads") {
  const Network net = closed_net(6);
  std::vector<double> first;
  double energy = 0.0;
  for (const bool asked : {false, true}) {
    for (const unsigned threads : {1u, 3u}) {
      SimulationOptions options = with_energy(recurrent(wavefront, 1e-8), 0.01);
      options.dissipated_energy = asked;
      options.threads = threads;
      Simulation simulation(net, plugins(), options);
      std::vector<double> motion, powers;
      for (int step = 0; step < 30; ++step) {
        simulation.step();
        if (asked) simulation.dissipations(powers);
        for (NodeIndex k = 0; k < simulation.node_count(); ++k)
          for (const double x : simulation.position(k)) motion.push_back(x);
      }
      if (first.empty()) first = motion;
      CHECK(motion == first);
      if (!asked) continue;
      if (threads == 1) energy = simulation.dissipated_energy();
      CHECK(simulation.dissipated_energy() == energy);
    }
  }
}

// The states at the ends of a step are those before and after what happens between steps.
TEST_CASE("changes from outside and cuts between steps dissipate nothing") {
  Simulation simulation(oscillator({hooke, damping}, 1.0, 0.15, 0.5), plugins(),
                        with_energy(recurrent(newton, 1e-12, {{"theta", 0.5}}), 0.01));
  simulation.advance_to(0.1);
  const double before = simulation.dissipated_energy();
  simulation.set_position(1, {1.4, 0, 0});
  simulation.set_velocity(1, {-1.5, 0, 0});
  CHECK(simulation.dissipated_energy() == before);
  const double start = simulation.kinetic_energy() + simulation.potential_energy();
  simulation.advance_to(0.3);
  CHECK(simulation.kinetic_energy() + simulation.potential_energy() + simulation.dissipated_energy() - before ==
        doctest::Approx(start).epsilon(1e-10));
  const double until_cut = simulation.dissipated_energy();
  simulation.cut({0});
  simulation.advance_to(0.5);
  CHECK(simulation.dissipated_energy() == until_cut);
  CHECK(simulation.dissipated_power() == 0.0);
}

namespace {

// Laws in C may leave out derivatives, and then have an energy all the same.
springnet_status evaluate_without_derivatives(void*, const springnet_law_batch* batch) {
  for (std::uint32_t i = 0; i < batch->count; ++i) {
    const double x = batch->q[i] - batch->reference[batch->reference_stride * i];
    if (batch->force != nullptr) batch->force[i] = 3.0 * x;
    if (batch->energy != nullptr) batch->energy[i] = 1.5 * x * x;
  }
  return SPRINGNET_OK;
}

}  // namespace

TEST_CASE("what a law with an energy but without derivatives dissipates is not known") {
  springnet_law law{};
  law.struct_size = sizeof law;
  law.invariant = SPRINGNET_LENGTH;
  law.update_order = 1;
  law.largest_stretch = 10;
  law.evaluate = evaluate_without_derivatives;
  springnet_component component{};
  component.struct_size = sizeof component;
  component.id = "plain";
  component.summary = component.reference = "";
  component.capabilities = SPRINGNET_HAS_ENERGY | SPRINGNET_ACTS_IN_COMPRESSION;
  component.implementation = &law;
  const auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  for (const std::uint32_t kind : {SPRINGNET_SPRING_FUNCTION, SPRINGNET_VISCOSITY_FUNCTION}) {
    component.kind = kind;
    host->add(HostComponent(component, nullptr));
  }
  for (const bool viscosity : {false, true}) {
    Network net;
    net.add_node(point({0, 0, 0}, 1.0, {0.5, 0, 0}));
    net.add_node(point({1, 0, 0}));
    const LawUse plain{"plain", {}};
    net.add_spring(0, 1, net.add_material(viscosity ? Material{hooke, plain} : Material{plain, std::nullopt}), 1.2);
    Simulation simulation(net, host, with_energy(single_sweep(), 0.01));
    simulation.advance_to(0.1);
    CHECK(simulation.dissipated_energy() == 0.0);  // it counts as one without an energy
    CHECK(simulation.dissipated_power() == 0.0);
    std::vector<double> powers;
    simulation.dissipations(powers);
    CHECK(std::isnan(powers[0]));
  }
}
