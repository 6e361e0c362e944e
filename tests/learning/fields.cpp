// Smooth fields of values: recovered from motion with few coefficients, with intervals and bounds.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "learning_nets.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

// A block that hangs by its upper side; its start velocities make it swing in all directions.
Network hanging(std::array<std::uint32_t, 3> nodes, double stiffness = 200.0, double damping = 2.0) {
  Network net;
  Lattice lattice;
  lattice.nodes = nodes;
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(stiffness, damping)));
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node own = net.nodes()[k];
    own.velocity = {0.5 * std::sin(own.position.y()), 0.3 * std::cos(own.position.x()), 0.2 * own.position.x()};
    net.set_node(k, own);
    if (own.position.y() > nodes[1] - 1.5) net.fix(k);
  }
  net.set_gravity({0, -5, 0});
  return net;
}

Vector3 middle(const Network& net, SpringIndex s) {
  return 0.5 * (net.nodes()[net.springs()[s].first].position + net.nodes()[net.springs()[s].second].position);
}

Learnable field(Kind kind, const char* parameter, std::size_t members, int degree) {
  Learnable result{{kind, false, parameter, from_to(0, members)}};
  result.field_degree = degree;
  return result;
}

// Positions of all nodes with the springs' own stiffness.
template <class Stiffness>
Experiment seen_with(const Network& net, const Stiffness& stiffness, int steps, double noise = 0.0) {
  std::vector<double> values;
  for (SpringIndex s = 0; s < net.springs().size(); ++s) values.push_back(stiffness(middle(net, s)));
  const SimulationOptions options = to_learn_with(0.5, 0.04);
  Simulation real(net, plugins(), options);
  real.set_parameter(from_to(0, values.size()), ComponentKind::spring_function, "stiffness", values);
  return experiment(net, options, observe(real, steps, from_to(0, net.nodes().size()), noise));
}

}  // namespace

TEST_CASE("a smooth field of stiffness is recovered from positions with its coefficients alone") {
  const Network net = hanging({5, 4, 2});
  const auto stiffness = [](const Vector3& at) {  // of second degree in x and y, first in z: within the basis
    return 200.0 * (1.0 + 0.15 * at.x() - 0.05 * at.x() * at.y() + 0.04 * at.y() * at.y() - 0.3 * at.z());
  };
  const std::size_t springs = net.springs().size();
  const LearnedNet learned =
      learn({seen_with(net, stiffness, 15)}, plugins(), {field(Kind::spring_parameter, "stiffness", springs, 2)});
  CAPTURE(learned.reason);
  CHECK(learned.variables == 27);
  CHECK(learned.undetermined == 0);
  REQUIRE(learned.parameters.size() == springs);
  for (const LearnedParameter& each : learned.parameters) {
    CHECK(each.value == doctest::Approx(stiffness(middle(net, each.member))).epsilon(1e-6));
    CHECK(each.variables == 27);
    CHECK(each.determined == doctest::Approx(1.0).epsilon(1e-6));
  }
}

TEST_CASE("a field that is not a polynomial is approximated, better with a higher degree, and noise is averaged") {
  const Network net = hanging({6, 4, 1});
  const auto stiffness = [](const Vector3& at) {
    return 200.0 * (1.0 + 0.6 * std::exp(-0.3 * (at - Vector3(2, 2, 0)).squaredNorm()));
  };
  const std::size_t springs = net.springs().size();
  double before = 1.0;
  for (const int degree : {1, 3}) {
    const LearnedNet learned = learn({seen_with(net, stiffness, 25, 1e-3)}, plugins(),
                                     {field(Kind::spring_parameter, "stiffness", springs, degree)});
    CHECK(learned.variables == static_cast<std::size_t>((degree + 1) * (degree + 1)));  // the sheet is flat
    double squares = 0.0;
    for (const LearnedParameter& each : learned.parameters)
      squares += std::pow(each.value / stiffness(middle(net, each.member)) - 1.0, 2);
    const double error = std::sqrt(squares / static_cast<double>(springs));
    CHECK(error < 0.5 * before);
    before = error;
  }
  CHECK(before < 0.05);
}

TEST_CASE("an interval of a field's value is that of the combination of coefficients that it is") {
  // Three springs in a row: a field of second degree has as many coefficients as there are values, so that it says the
  // same of each as if they were learned by themselves.
  Network net = chain(4, {0, 0, 0}, {1, 0, 0}, damped(40.0, 1.0));
  net.fix(0);
  net.set_gravity({0, 0, -2});
  const SimulationOptions options = to_learn_with(0.5, 0.02);
  Simulation real(net, plugins(), options);
  const Experiment seen = experiment(net, options, observe(real, 50, from_to(1, 4), 1e-3));
  const LearnedNet alone = learn({seen}, plugins(), {{{Kind::spring_parameter, false, "stiffness", from_to(0, 3)}}});
  const LearnedNet as_field = learn({seen}, plugins(), {field(Kind::spring_parameter, "stiffness", 3, 2)});
  CHECK(as_field.variables == 3);
  for (std::size_t k = 0; k < 3; ++k) {
    const LearnedParameter &one = alone.parameters[k], &other = as_field.parameters[k];
    CHECK(std::isfinite(one.upper));
    CHECK(other.value == doctest::Approx(one.value).epsilon(1e-6));
    CHECK(other.upper - other.lower == doctest::Approx(one.upper - one.lower).epsilon(1e-5));
    CHECK(other.by_time_step == doctest::Approx(one.by_time_step).epsilon(1e-4));
  }
}

TEST_CASE("values of a field stay within their bounds everywhere, and those searched by logarithms above 0") {
  const Network net = hanging({5, 4, 1});
  const auto stiffness = [](const Vector3& at) { return 100.0 + 60.0 * at.x(); };
  Learnable bounded = field(Kind::spring_parameter, "stiffness", net.springs().size(), 1);
  bounded.upper = 260.0;
  const LearnedNet learned = learn({seen_with(net, stiffness, 15)}, plugins(), {bounded});
  double greatest = 0.0;
  for (const LearnedParameter& each : learned.parameters) greatest = std::max(greatest, each.value);
  CHECK(greatest == doctest::Approx(260.0).epsilon(1e-9));
  CHECK(greatest <= 260.0);
  CHECK(std::any_of(learned.parameters.begin(), learned.parameters.end(),
                    [](const LearnedParameter& each) { return each.at_bound; }));

  // Masses fall to a hundredth along the sheet: a straight line from the guess would leave 0 behind.
  Network heavy = net;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node own = net.nodes()[k];
    own.mass = std::exp(-1.15 * own.position.x());
    heavy.set_node(k, own);
  }
  Simulation real(heavy, plugins(), to_learn_with(0.5, 0.04));
  Experiment seen = experiment(net, to_learn_with(0.5, 0.04), observe(real, 15, from_to(0, net.nodes().size())));
  Learnable masses = select_learnable(net, *plugins(), "mass:field=1");
  CHECK(masses.field_degree == 1);
  const LearnedNet weighed = learn({seen}, plugins(), {masses});
  CAPTURE(weighed.reason);
  CHECK(weighed.variables == 4);
  for (const LearnedParameter& each : weighed.parameters)
    CHECK(each.value == doctest::Approx(heavy.nodes()[each.member].mass).epsilon(1e-6));
}

TEST_CASE("start velocities of a rigid motion are a field of first degree; a field of degree 0 is one value") {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 3, 3};
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(50.0, 1.0)));
  Network moving = net;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node own = net.nodes()[k];
    own.velocity = Vector3(0.1, 0.2, 0.3) + Vector3(0.3, -0.2, 0.5).cross(own.position);
    moving.set_node(k, own);
  }
  const SimulationOptions options = to_learn_with(0.5, 0.05);
  Simulation real(moving, plugins(), options);
  const Experiment seen = experiment(net, options, observe(real, 5, from_to(0, net.nodes().size())));
  const LearnedNet learned = learn({seen}, plugins(), {select_learnable(net, *plugins(), "velocity:field=1")});
  CHECK(learned.variables == 24);
  for (const LearnedParameter& each : learned.parameters)
    CHECK(each.value == doctest::Approx(moving.nodes()[each.member].velocity[each.axis]).epsilon(1e-8));

  const Experiment stiff = seen_with(
      hanging({3, 3, 1}), [](const Vector3&) { return 250.0; }, 10);
  const Network& sheet = *stiff.network;
  const LearnedNet one = learn({stiff}, plugins(), {select_learnable(sheet, *plugins(), "spring.stiffness:together")});
  const LearnedNet zeroth =
      learn({stiff}, plugins(), {select_learnable(sheet, *plugins(), "spring.stiffness:field=0")});
  CHECK(zeroth.variables == 1);
  CHECK(zeroth.values == one.values);
}

TEST_CASE("fields that do not fit are refused") {
  const Network net = hanging({3, 2, 1});
  const Experiment seen = seen_with(
      net, [](const Vector3&) { return 250.0; }, 3);
  const auto refused = [&](const Learnable& learnable) {
    return refusal_of([&] { static_cast<void>(learn({seen}, plugins(), {learnable})); });
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  CHECK(has(refused(field(Kind::spring_parameter, "stiffness", 3, 2)), "coefficients for 3 values"));
  CHECK(has(refused(field(Kind::spring_parameter, "stiffness", 3, 100)), "must be at most 20"));
  Learnable both = field(Kind::spring_parameter, "stiffness", 3, 0);
  both.together = true;
  CHECK(has(refused(both), "not both"));
  for (const char* wrong : {"mass:field", "mass:field=", "mass:field=x", "mass:field=-1", "mass:field=2:together"})
    CHECK(has(refusal_of([&] { static_cast<void>(select_learnable(net, *plugins(), wrong)); }), "field"));
}
