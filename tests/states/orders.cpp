// Orders of convergence of motions with internal state against an exact solution.
#include <cmath>

#include <doctest/doctest.h>

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

// m x'' = -k (x - z), z' = (x - z) / tau: the exponential of a matrix, by its series for a small time, then squared.
Eigen::Vector3d maxwell_oscillator(double mass, double k, double tau, double x, double time) {
  Eigen::Matrix3d A;
  A << 0, 1, 0, -k / mass, 0, k / mass, 1 / tau, 0, -1 / tau;
  constexpr int halvings = 10, terms = 12;  // of a matrix of norm 0.1: the rest is below 1e-20
  A *= std::ldexp(time, -halvings);
  Eigen::Matrix3d term = Eigen::Matrix3d::Identity(), power = term;
  for (int i = 1; i <= terms; ++i) power += term = Eigen::Matrix3d(term * A) / i;
  for (int i = 0; i < halvings; ++i) power = Eigen::Matrix3d(power * power);
  return x * power.col(0);
}

}  // namespace

TEST_CASE("an oscillator with a Maxwell element converges in the order of its method") {
  constexpr double mass = 2.0, k = 30.0, tau = 0.4, x = 0.2, end = 1.6;
  const Eigen::Vector3d exact = maxwell_oscillator(mass, k, tau, x, end);
  const Material material{LawUse{"maxwell", {{"stiffness", k}, {"relaxation_time", tau}}}, std::nullopt};
  const auto error = [&](const LawUse& integrator, double h) {
    Simulation simulation = simulate(oscillator(material, mass, x), integrator, h);
    simulation.advance_to(end);
    const double position = simulation.position(1)[0] - 1.0 - exact[0];
    const double velocity = simulation.velocity(1)[0] - exact[1];
    const double state = simulation.internal_states(0)[0] - exact[2];
    return std::sqrt(position * position + velocity * velocity + state * state);
  };
  for (const StateMethod& method : state_methods(1e-12)) {
    CAPTURE(method.name);
    if (method.order == 0) {
      CHECK(error(method.integrator, 0.1) < 3e-8);
      continue;
    }
    const double coarse = error(method.integrator, 0.01), fine = error(method.integrator, 0.005);
    CAPTURE(coarse);
    CAPTURE(fine);
    CHECK(std::log2(coarse / fine) == doctest::Approx(method.order).epsilon(0.05));
    CHECK(fine < (method.order == 1 ? 0.02 : 2e-4));
  }
}

// The states of laws on other invariants: the angle of a corner under a Maxwell law, whose ends cannot move.
TEST_CASE("elements have internal states, too") {
  Network net;
  for (const Vector3& at : {Vector3(1, 0, 0), Vector3(0, 0, 0), Vector3(0, 1, 0)}) {
    Node node = point(at);
    node.fixed = true;
    net.add_node(node);
  }
  net.add_node(point({0, 0, 3}));
  constexpr double k = 2.0, tau = 0.5, reference = 1.2;
  const MaterialIndex material =
      net.add_material({LawUse{"maxwell", {{"stiffness", k}, {"relaxation_time", tau}}}, std::nullopt});
  net.add_element(Invariant::angle, {0, 1, 2}, material, reference);
  const double bent = std::acos(-1.0) / 2 - reference;
  for (const StateMethod& method : state_methods(1e-11)) {
    CAPTURE(method.name);
    Simulation simulation = simulate(net, method.integrator, 0.01);
    simulation.advance_to(1.0);
    const double bound = method.order == 0 ? 1e-7 : method.order == 1 ? 2e-2 : 2e-4;
    CHECK(simulation.element_internal_states(0).at(0) ==
          doctest::Approx(bent * (1 - std::exp(-1.0 / tau))).epsilon(bound));
    CHECK(simulation.element_force(0) == doctest::Approx(k * bent * std::exp(-1.0 / tau)).epsilon(4.0 * bound));
  }
}
