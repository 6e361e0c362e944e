// Derivatives of forces and accelerations by every parameter of every law and neuron, rest lengths and references,
// masses, input signals and the time.

#include <doctest/doctest.h>

#include <span>
#include <string>

#include <springnet/sdk/law.hpp>
#include <springnet/sdk/neuron.hpp>

#include "../elements/bodies.hpp"
#include "host_at.hpp"
#include "laws.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Reads the time.
struct Clocked : sdk::SpringFunction {
  static constexpr const char* id = "clocked";
  static constexpr const char* summary = "a stiffness that swings";
  static constexpr bool reads_time = true;
  static constexpr bool fits_elements = true;
  static constexpr bool adds_power = true;
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", "mean")};
  static auto force(const auto& e, const auto& p) { return p[0] * (1.0 + 0.5 * sin(3.0 * e.time)) * e.elongation(); }
};
// Reads everything that a neuron can.
struct Windy : sdk::Neuron {
  static constexpr const char* id = "windy";
  static constexpr const char* summary = "a medium that moves";
  static constexpr sdk::Parameter parameters[] = {sdk::number("drag", "kg/s", ""), sdk::number("wind", "m/s", ""),
                                                  sdk::number("spring", "N/m", "")};
  template <class Real>
  static sdk::Vector<Real> acceleration(const sdk::Node<Real>& n, const sdk::Parameters<Real>& p) {
    const sdk::Vector<Real> wind{p[1] * sin(2.0 * n.time), p[1], 0.3 * p[1]};
    return (n.force - p[0] * (n.velocity - wind) - p[2] * n.position) / (n.mass + 0.1 * p[0]);
  }
};
constexpr springnet_plugin own_laws =
    sdk::PluginEntry<Clocked, Windy>::make("test.derivatives", "1.0.0", "springnet", "MIT");

std::shared_ptr<const PluginHost> with_own_laws() {
  static const auto host = [] {
    auto result = std::make_shared<PluginHost>(PluginHost::with_default_search());
    result->add(own_laws);
    return std::shared_ptr<const PluginHost>(std::move(result));
  }();
  return host;
}

Parametrised::Set set_of(std::uint32_t kind, Values values, const char* parameter = nullptr,
                         const char* component = nullptr) {
  Parametrised::Set set;
  set.set.kind = kind;
  set.set.parameter = parameter;
  set.set.component = component;
  set.values = std::move(values);
  return set;
}

}  // namespace

TEST_CASE("by rest lengths and every parameter of every law of springs, each spring by itself") {
  for (const LawCase& law : spring_laws()) {
    CAPTURE(law.id);
    const Parametrised given = springs_with(law);
    check_parameters(given);
    check_parameters(given, [](HostAt& at) { at.internal = stirred(at.internal); });
  }
}

TEST_CASE("by references and parameters of elements of every invariant") {
  Parametrised given;
  const Network plain = all_kinds(3);
  const std::size_t count = plain.elements().size();
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0.5, 1.5);
  Values references, stiffness, cubic, damping;
  for (std::size_t e = 0; e < count; ++e) {
    references.push_back(plain.elements()[e].reference);
    stiffness.push_back(unit(random));
    cubic.push_back(unit(random));
    damping.push_back(unit(random));
  }
  given.sets = {set_of(SPRINGNET_BY_REFERENCE, references),
                set_of(SPRINGNET_BY_SPRING_PARAMETER, stiffness, "stiffness", "nonlinear"),
                set_of(SPRINGNET_BY_SPRING_PARAMETER, cubic, "cubic"),
                set_of(SPRINGNET_BY_VISCOSITY_PARAMETER, damping, "damping")};
  for (Parametrised::Set& set : given.sets) set.set.of_elements = true;
  given.make = [plain, count](const std::vector<Parametrised::Set>& sets) {
    Network net;
    for (const Node& node : plain.nodes()) net.add_node(node);
    for (std::size_t e = 0; e < count; ++e) {
      const Element& element = plain.elements()[e];
      const MaterialIndex material =
          net.add_material({LawUse{"nonlinear", {{"stiffness", sets[1].values[e]}, {"cubic", sets[2].values[e]}}},
                            LawUse{"linear", {{"damping", sets[3].values[e]}}}});
      net.add_element(element.invariant, element.nodes, material, sets[0].values[e]);
    }
    return net;
  };
  check_parameters(given);
}

TEST_CASE("by masses and parameters of neurons, under gravity") {
  Parametrised given;
  given.laws = with_own_laws();
  const std::size_t n = 12;
  Values mass, drag, wind, spring;
  for (std::size_t k = 0; k < n; ++k) {
    const double x = static_cast<double>(k);
    mass.push_back(1.0 + 0.1 * x);
    drag.push_back(0.2 + 0.02 * x);
    wind.push_back(0.5 - 0.03 * x);
    spring.push_back(0.3 + 0.01 * x);
  }
  given.sets = {set_of(SPRINGNET_BY_MASS, mass), set_of(SPRINGNET_BY_NEURON_PARAMETER, drag, "drag", "windy"),
                set_of(SPRINGNET_BY_NEURON_PARAMETER, wind, "wind"),
                set_of(SPRINGNET_BY_NEURON_PARAMETER, spring, "spring")};
  for (Parametrised::Set& set : given.sets) set.of_nodes = true;
  given.make = [n](const std::vector<Parametrised::Set>& sets) {
    Network net;
    net.set_gravity({0.3, -0.2, -9.81});
    const Eigen::VectorXd x = random_vector(6 * n, 9);
    for (std::size_t k = 0; k < n; ++k) {
      Node node = point(x.segment<3>(static_cast<Eigen::Index>(6 * k)), sets[0].values[k],
                        x.segment<3>(static_cast<Eigen::Index>(6 * k + 3)));
      node.neuron = net.add_neuron(
          {"windy", {{"drag", sets[1].values[k]}, {"wind", sets[2].values[k]}, {"spring", sets[3].values[k]}}});
      net.add_node(node);
    }
    const MaterialIndex material = net.add_material(damped(3.0, 0.4));
    for (NodeIndex k = 0; k + 1 < n; ++k) net.add_spring(k, k + 1, material, 1.1);
    return net;
  };
  check_parameters(given, [](HostAt& at) { at.time = 0.1; });
  // The shipped ones.
  given.sets = {set_of(SPRINGNET_BY_MASS, mass), set_of(SPRINGNET_BY_NEURON_PARAMETER, drag, "drag")};
  for (Parametrised::Set& set : given.sets) set.of_nodes = true;
  given.make = [n](const std::vector<Parametrised::Set>& sets) {
    Network net;
    net.set_gravity({0.3, -0.2, -9.81});
    const Eigen::VectorXd x = random_vector(6 * n, 9);
    for (std::size_t k = 0; k < n; ++k) {
      Node node = point(x.segment<3>(static_cast<Eigen::Index>(6 * k)), sets[0].values[k],
                        x.segment<3>(static_cast<Eigen::Index>(6 * k + 3)));
      node.neuron = net.add_neuron({"dragged", {{"drag", sets[1].values[k]}}});
      net.add_node(node);
    }
    const MaterialIndex material = net.add_material(damped(3.0, 0.4));
    for (NodeIndex k = 0; k + 1 < n; ++k) net.add_spring(k, k + 1, material, 1.1);
    return net;
  };
  check_parameters(given);
}

TEST_CASE("by input signals, which some springs and elements read, and by the time") {
  Parametrised given;
  given.laws = with_own_laws();
  given.sets = {set_of(SPRINGNET_BY_INPUT, {0.4}), set_of(SPRINGNET_BY_INPUT, {0.7}),
                set_of(SPRINGNET_BY_TIME, {0.05})};
  given.sets[1].set.input = 1;
  given.time_moves = true;
  given.make = [](const std::vector<Parametrised::Set>& sets) {
    Network net;
    const Eigen::VectorXd x = random_vector(36, 9);
    const std::uint32_t windy = net.add_neuron({"windy", {{"drag", 0.2}, {"wind", 0.5}, {"spring", 0.1}}});
    for (Eigen::Index k = 0; k < 6; ++k) {
      Node node = point(x.segment<3>(6 * k), 1.0, x.segment<3>(6 * k + 3));
      node.neuron = k % 2 == 0 ? windy : 0;
      net.add_node(node);
    }
    const MaterialIndex muscle =
        net.add_material({LawUse{"muscle", {{"strength", 5.0}, {"maximum_speed", 4.0}}}, std::nullopt});
    const MaterialIndex clocked = net.add_material({LawUse{"clocked", {{"stiffness", 2.0}}}, std::nullopt});
    for (NodeIndex k = 0; k < 5; ++k) net.add_spring(k, k + 1, k == 2 ? clocked : muscle, 0.9);
    net.add_element(Invariant::area, {0, 2, 4}, clocked, 0.3);
    for (std::size_t i = 0; i < 2; ++i) {
      Input input;
      input.input = "activation";
      input.springs = i == 0 ? std::vector<SpringIndex>{0, 3} : std::vector<SpringIndex>{1};
      input.signal.mean = sets[i].values[0];
      net.add_input(input);
    }
    return net;
  };
  check_parameters(given, [](HostAt& at) { at.time = 0.05; });
}

TEST_CASE("the same bits for every number of threads") {
  const Network net = [] {
    Network result;
    Lattice lattice;
    lattice.nodes = {30, 20, 20};
    lattice.diagonals = Diagonals::space;
    result.add_lattice("block", lattice, Node{}, result.add_material(damped(3.0, 0.5)));
    return result;
  }();
  std::vector<Values> answers;
  for (const unsigned threads : {1u, 2u, 5u}) {
    HostAt at(net, plugins(), threads);
    at.position += 0.05 * random_vector(static_cast<std::size_t>(at.position.size()), 1);
    at.velocity = random_vector(static_cast<std::size_t>(at.position.size()), 2);
    Values stiffness(net.springs().size(), 0.0), mass(at.node_count(), 0.0);
    const sdk::Host::ParameterSet sets[] = {{SPRINGNET_BY_SPRING_PARAMETER, stiffness, "stiffness"},
                                            {SPRINGNET_BY_MASS, mass}};
    HostAt::Answer weights = at.zero();
    weights.acceleration = random_vector(static_cast<std::size_t>(at.position.size()), 3);
    at.host.parameter_cotangent(at.evaluation(), sets, at.arrays(weights));
    HostAt::Answer tangent = at.zero();
    at.host.parameter_tangent(at.evaluation(), sets, at.arrays(tangent));
    Values all = stiffness;
    all.insert(all.end(), mass.begin(), mass.end());
    all.insert(all.end(), tangent.acceleration.begin(), tangent.acceleration.end());
    answers.push_back(all);
  }
  CHECK(answers[0] == answers[1]);
  CHECK(answers[0] == answers[2]);
}

TEST_CASE("what is not there is refused by name") {
  HostAt at(springs_with(spring_laws().front()).net());
  Values values(at.host.network().spring_number_count);
  HostAt::Answer out = at.zero();
  const auto refused = [&](const sdk::Host::ParameterSet& set) -> std::string {
    try {
      at.host.parameter_tangent(at.evaluation(), {&set, 1}, at.arrays(out));
    } catch (const sdk::Failure& failure) {
      return failure.what();
    }
    return "";
  };
  CHECK(refused({SPRINGNET_BY_SPRING_PARAMETER, values, "stifness"}) ==
        "springnet_host::parameter_tangent: no spring has a parameter 'stifness'; the network has linear.stiffness");
  CHECK(refused({SPRINGNET_BY_SPRING_PARAMETER, values, "stiffness", "nonlinear"}) ==
        "springnet_host::parameter_tangent: no spring has a parameter 'stiffness' of 'nonlinear'; the network has "
        "linear.stiffness");
  CHECK(refused({SPRINGNET_BY_INPUT, std::span(values).first(1)}) ==
        "springnet_host::parameter_tangent: input 0 of a parameter set does not exist: the network has 0");
  CHECK(refused({99, values}) ==
        "springnet_host::parameter_tangent: the kind of parameter set 0 is 99, must be 1 to 7");
}
