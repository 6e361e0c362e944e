// Derivatives by parameters, rest shapes, inputs and the time, and of margins, where laws read several scalars of an
// element.

#include <doctest/doctest.h>

#include <string>

#include <springnet/sdk/law.hpp>

#include "host_at.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Reads everything that such a law can, and breaks.
struct Corner : sdk::SpringFunction {
  using has = sdk::Has<sdk::Margin>;
  enum { length, angle, area };
  static constexpr const char* id = "corner";
  static constexpr const char* summary = "a length, an angle and an area that pull on each other";
  static constexpr bool reads_rate = true;
  static constexpr bool reads_time = true;
  static constexpr bool adds_power = true;
  static constexpr bool not_zero_at_rest = true;
  static constexpr sdk::Shape shape = sdk::Shape::triangle;
  static constexpr sdk::Scalar invariants[] = {sdk::length_of(0, 1), sdk::angle_of(0, 1, 2), sdk::area_of(0, 1, 2)};
  static constexpr sdk::Parameter parameters[] = {sdk::number("stiffness", "N/m", "of all").preset(3)};
  static constexpr sdk::Parameter inputs[] = {sdk::number("drive", "1", "stiffens").preset(0)};

  static auto force(const auto& e, const auto& p) {
    const auto k = p[0] * (1.0 + 0.5 * e.input(0) + 0.2 * sin(3.0 * e.time));
    const auto x = e.q[length] / e.reference[length] - 1.0, y = e.q[angle] - e.reference[angle];
    const auto z = e.q[area] / e.reference[area] - 1.0;
    return std::array{k * (x + 0.3 * y * z) + 0.1 * e.rate[angle], k * (y + 0.2 * x * x) + 0.05 * e.rate[area],
                      k * (z - 0.4 * x * y) + 0.07 * e.rate[length] * x};
  }
  static auto margin(const auto& e, const auto& p) {
    return 8.0 - p[0] * e.q[length] * e.q[area] / e.reference[area] - 0.3 * e.rate[angle] * e.q[angle] -
           0.5 * e.input(0) + 0.1 * e.time;
  }
};
constexpr springnet_plugin own_law = sdk::PluginEntry<Corner>::make("test.corner", "1.0.0", "springnet", "MIT");

std::shared_ptr<const PluginHost> with_own_law() {
  static const auto host = [] {
    auto result = std::make_shared<PluginHost>(PluginHost::with_default_search());
    result->add(own_law);
    return std::shared_ptr<const PluginHost>(std::move(result));
  }();
  return host;
}

// What it returns for the second length, which it reads at rest alone, is no force.
template <int beyond>
struct Half : sdk::ViscosityFunction {
  static constexpr const char *id = beyond == 0 ? "half" : "half_and_more", *summary = "one of two lengths is damped";
  static constexpr sdk::Shape shape = sdk::Shape::triangle;
  static constexpr sdk::Scalar invariants[] = {sdk::length_of(0, 1), sdk::at_rest(sdk::length_of(0, 2))};
  static auto force(const auto& e, const auto&) {
    return std::array{0.5 * e.rate[0] * e.reference[1], 0.0 * e.rate[0] + double{beyond}};
  }
};
constexpr springnet_plugin halves =
    sdk::PluginEntry<Half<0>, Half<7>>::make("test.halves", "1.0.0", "springnet", "MIT");

struct Case {
  const char* name;
  Invariant shape;
  LawUse spring;
  std::optional<LawUse> viscosity;
};

std::vector<Case> cases() {
  const LawUse solid{"solid", {{"youngs_modulus", 3.0}, {"poisson_ratio", 0.3}}};
  const LawUse fibres{
      "fibre_solid",
      {{"youngs_modulus", 3.0}, {"poisson_ratio", 0.2}, {"fibre_modulus", 2.0}, {"fibre_stiffening", 1.5}}};
  const LawUse membrane{"membrane", {{"youngs_modulus", 3.0}, {"poisson_ratio", 0.3}, {"thickness", 0.4}}};
  LawUse kirchhoff = membrane;
  kirchhoff.parameters["model"] = 1.0;
  const LawUse shell{"shell", {{"youngs_modulus", 30.0}, {"poisson_ratio", 0.3}, {"thickness", 0.4}}};
  const LawUse oily{"viscous_solid", {{"shear_viscosity", 0.6}, {"bulk_viscosity", 0.3}}};
  const LawUse creamy{"viscous_membrane", {{"shear_viscosity", 0.6}, {"area_viscosity", 0.3}}};
  return {{"solid", Invariant::tetrahedron, solid, std::nullopt},
          {"solid and viscous solid", Invariant::tetrahedron, solid, oily},
          {"fibres", Invariant::tetrahedron, fibres, oily},
          {"membrane", Invariant::triangle, membrane, creamy},
          {"St. Venant-Kirchhoff", Invariant::triangle, kirchhoff, std::nullopt},
          {"shell", Invariant::hinge, shell, std::nullopt}};
}

// A strip of ten elements of a shape, whose nodes are near a tetrahedron, or a triangle with its neighbour, at rest.
constexpr std::size_t elements = 10;
std::vector<NodeIndex> nodes_of(Invariant shape, std::size_t e) {
  const auto first = static_cast<NodeIndex>(e);
  std::vector<NodeIndex> nodes{first, first + 1, first + 2};
  if (shape == Invariant::tetrahedron || shape == Invariant::hinge) nodes.push_back(first + 3);
  return nodes;
}
Vector3 rest_of(std::size_t node) {
  const double turn = 2.0 * static_cast<double>(node);
  return {std::cos(turn), std::sin(turn), 0.5 * static_cast<double>(node)};
}
Network strip_of(Invariant shape, const std::function<MaterialIndex(Network&, std::size_t element)>& material,
                 const Values& growth) {
  Network net;
  const Eigen::VectorXd x = random_vector(6 * (elements + 3), 3);
  for (std::size_t k = 0; k < elements + 3; ++k)
    net.add_node(point(rest_of(k) + 0.1 * x.segment<3>(static_cast<Eigen::Index>(6 * k)), 1.0,
                       x.segment<3>(static_cast<Eigen::Index>(6 * k + 3))));
  for (std::size_t e = 0; e < elements; ++e) {
    const std::vector<NodeIndex> nodes = nodes_of(shape, e);
    std::vector<Vector3> rest;
    for (const NodeIndex k : nodes) rest.push_back(growth[e] * rest_of(k));
    net.add_element(shape, nodes, material(net, e), rest, Vector3(0.3, -0.5, 1.0));
  }
  return net;
}

// Growth, then every parameter of both laws with a value of its own for each element, but for switches.
Parametrised parametrised(const Case& law) {
  Parametrised given;
  const auto add = [&](std::uint32_t kind, const char* parameter, double about) {
    Parametrised::Set& set = given.sets.emplace_back();
    set.set.kind = kind;
    set.set.of_elements = true;
    set.set.parameter = parameter;
    for (std::size_t e = 0; e < elements; ++e)
      set.values.push_back(kind == SPRINGNET_BY_REFERENCE ? about : about * (1.0 + 0.01 * static_cast<double>(e)));
  };
  add(SPRINGNET_BY_REFERENCE, nullptr, 1.0);
  for (const auto& [name, value] : law.spring.parameters)
    if (name != "model") add(SPRINGNET_BY_SPRING_PARAMETER, name.c_str(), value);
  if (law.viscosity)
    for (const auto& [name, value] : law.viscosity->parameters)
      add(SPRINGNET_BY_VISCOSITY_PARAMETER, name.c_str(), value);
  given.make = [law](const std::vector<Parametrised::Set>& sets) {
    return strip_of(
        law.shape,
        [&](Network& net, std::size_t e) {
          LawUse spring = law.spring;
          std::optional<LawUse> viscosity = law.viscosity;
          for (const Parametrised::Set& set : sets) {
            if (set.set.kind == SPRINGNET_BY_SPRING_PARAMETER) spring.parameters[set.set.parameter] = set.values[e];
            if (set.set.kind == SPRINGNET_BY_VISCOSITY_PARAMETER)
              viscosity->parameters[set.set.parameter] = set.values[e];
          }
          return net.add_material({spring, viscosity});
        },
        sets[0].values);
  };
  return given;
}

// Of the law above: growth, stiffness, the signal of some elements, and the time.
Parametrised corners() {
  Parametrised given;
  given.laws = with_own_law();
  given.sets.resize(4);
  for (std::size_t e = 0; e < elements; ++e) {
    given.sets[0].values.push_back(1.0);
    given.sets[1].values.push_back(3.0 - 0.1 * static_cast<double>(e));
  }
  given.sets[2].values = {0.4};
  given.sets[3].values = {0.05};
  given.sets[0].set.kind = SPRINGNET_BY_REFERENCE;
  given.sets[1].set.kind = SPRINGNET_BY_SPRING_PARAMETER;
  given.sets[1].set.parameter = "stiffness";
  given.sets[2].set.kind = SPRINGNET_BY_INPUT;
  given.sets[3].set.kind = SPRINGNET_BY_TIME;
  for (std::size_t i = 0; i < 2; ++i) given.sets[i].set.of_elements = true;
  given.time_moves = true;
  given.make = [](const std::vector<Parametrised::Set>& sets) {
    Network net = strip_of(
        Invariant::triangle,
        [&](Network& to, std::size_t e) {
          return to.add_material({LawUse{"corner", {{"stiffness", sets[1].values[e]}}}, std::nullopt});
        },
        sets[0].values);
    Input input;
    input.input = "drive";
    input.elements = {1, 2, 7};
    input.signal.mean = sets[2].values[0];
    net.add_input(input);
    return net;
  };
  return given;
}

}  // namespace

TEST_CASE("by rest shapes and every parameter of laws over several scalars, each element by itself") {
  for (const Case& law : cases()) {
    CAPTURE(law.name);
    check_parameters(parametrised(law));
  }
}

TEST_CASE("a law over several scalars by its input and the time") {
  check_parameters(corners(), [](HostAt& at) { at.time = 0.05; });
}

TEST_CASE("elements of all laws, springs among them: one number for all, the same bits for every number of threads") {
  const auto make = [] {
    Network net = strip_of(
        Invariant::tetrahedron,
        [](Network& to, std::size_t e) {
          return to.add_material({cases()[e % 3].spring, e % 2 == 0 ? cases()[1].viscosity : std::nullopt});
        },
        Values(elements, 1.0));
    const MaterialIndex linear = net.add_material({LawUse{"linear", {{"stiffness", 2.0}}}, std::nullopt});
    for (NodeIndex k = 0; k < 5; ++k) net.add_spring(k, k + 1, linear, 0.9);
    net.add_element(Invariant::area, {0, 2, 4}, linear, 0.3);
    return net;
  };
  std::vector<Values> answers;
  for (const unsigned threads : {1u, 2u, 3u}) {
    HostAt at(make(), plugins(), threads);
    sdk::Host::ParameterSet set;
    set.kind = SPRINGNET_BY_SPRING_PARAMETER;
    set.of_elements = true;
    set.parameter = "youngs_modulus";
    Values direction(elements + 1, 0.7), gradient(elements + 1, 0.0);
    set.values = direction;
    HostAt::Answer tangent = at.zero();
    at.host.parameter_tangent(at.evaluation(), {&set, 1}, at.arrays(tangent));
    set.values = gradient;
    HostAt::Answer weights{random_vector(static_cast<std::size_t>(tangent.force.size()), 1),
                           random_vector(static_cast<std::size_t>(tangent.force.size()), 2), Eigen::VectorXd()};
    at.host.parameter_cotangent(at.evaluation(), {&set, 1}, at.arrays(weights));
    Values& all = answers.emplace_back(gradient);
    all.insert(all.end(), tangent.force.begin(), tangent.force.end());
    all.insert(all.end(), tangent.acceleration.begin(), tangent.acceleration.end());
    CHECK(gradient.back() == 0.0);  // a spring function of one scalar has no such parameter
    CHECK(tangent.force.norm() > 0.01);
  }
  CHECK(answers[1] == answers[0]);
  CHECK(answers[2] == answers[0]);
}

TEST_CASE("a scalar that one law reads at rest alone gets no force from it, though the other law reads it") {
  auto plugins_with = std::make_shared<PluginHost>(PluginHost::with_default_search());
  plugins_with->add(halves);
  const std::shared_ptr<const PluginHost> laws = plugins_with;
  const auto forces = [&](const char* viscosity, std::uint32_t& seen) {
    const Network net = strip_of(
        Invariant::triangle,
        [&](Network& to, std::size_t) {
          return to.add_material({cases()[3].spring, LawUse{viscosity, {}}});
        },
        Values(elements, 1.0));
    HostAt at(net, laws);
    const springnet_scalar_view view = at.host.view_scalars(at.evaluation(), 2);
    for (std::size_t s = 0; s < view.scalar_count; ++s) {
      CHECK(view.force[0][s] != 0.0);
      seen += view.force[1][s] != 0.0 ? 1u : 0u;
    }
    HostAt::Answer product = at.zero();
    sdk::Host::ParameterSet set;
    set.kind = SPRINGNET_BY_REFERENCE;
    set.of_elements = true;
    Values growth(elements, 1.0);
    set.values = growth;
    at.host.parameter_tangent(at.evaluation(), {&set, 1}, at.arrays(product));
    Eigen::VectorXd all(2 * product.force.size());
    all << at.evaluate().force, product.force;
    return all;
  };
  std::uint32_t seen = 0;
  CHECK(forces("half_and_more", seen) == forces("half", seen));
  CHECK(seen == 2);  // of each net the first length
}

TEST_CASE("sets of parameters have as many numbers as there are springs, elements or nodes") {
  const Parametrised given = corners();
  HostAt at(given.net(), given.laws);
  HostAt::Answer tangent = at.zero();
  Values few(elements - 1, 0.0);
  sdk::Host::ParameterSet set = given.sets[0].set;
  set.values = few;
  CHECK_THROWS_WITH_AS(at.host.parameter_tangent(at.evaluation(), {&set, 1}, at.arrays(tangent)),
                       doctest::Contains("parameter set 0 has 9 numbers, must have 10"), sdk::Failure);
  set.kind = SPRINGNET_BY_TIME;
  CHECK_THROWS_WITH_AS(at.host.parameter_cotangent(at.evaluation(), {&set, 1}, at.arrays(tangent)),
                       doctest::Contains("must have 1"), sdk::Failure);
}

TEST_CASE("margins of elements over several scalars, by the state, the time and sets of parameters") {
  const Parametrised given = corners();
  HostAt at(given.net(), given.laws);
  at.time = 0.05;
  const std::size_t n = at.node_count();
  const auto margins = [](HostAt& host) {
    Values values(host.host.network().event_count);
    host.host.event_values(host.evaluation(), values.data(), nullptr);
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  REQUIRE(at.host.network().event_count == elements);
  const Eigen::VectorXd dp = random_vector(3 * n, 1), dv = random_vector(3 * n, 2), p = at.position, v = at.velocity;
  const Eigen::VectorXd along_state = difference([&](double h) {
    at.position = p + h * dp;
    at.velocity = v + h * dv;
    at.time = 0.05 + h;
    return margins(at);
  });
  at.position = p;
  at.velocity = v;
  at.time = 0.05;
  for (std::uint32_t e = 0; e < elements; ++e) {
    CAPTURE(e);
    Eigen::VectorXd by_position(3 * n), by_velocity(3 * n);
    std::vector<Values> by;
    std::vector<sdk::Host::ParameterSet> sets;
    by.reserve(3);
    for (std::size_t i = 0; i < 3; ++i) {
      sets.push_back(given.sets[i].set);
      sets.back().values = by.emplace_back(given.sets[i].values.size(), 0.0);
    }
    const double by_time = at.host.event_derivative(at.evaluation(), e, by_position.data(), by_velocity.data(), sets);
    const double rate = by_position.dot(dp) + by_velocity.dot(dv) + by_time;
    CHECK(std::abs(rate - along_state[e]) <= of_differences * (1.0 + std::abs(rate)));
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < by[i].size(); ++j) {
        if (i < 2 && j != e) {
          CHECK(by[i][j] == 0.0);
          continue;
        }
        const Eigen::VectorXd expected = difference([&](double h) {
          std::vector<Parametrised::Set> moved = given.sets;
          moved[i].values[j] += h;
          HostAt other(given.make(moved), given.laws);
          other.take_state(at);
          return margins(other);
        });
        CHECK(std::abs(by[i][j] - expected[e]) <= of_differences);
      }
  }
}
