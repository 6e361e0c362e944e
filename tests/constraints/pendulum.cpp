// A rigid pendulum at great angles: its period is 4 sqrt(L/g) K(sin(angle / 2)), K the complete elliptic integral of
// the first kind, and the force in its rod m (v^2 / L + g cos(angle)).

#include <doctest/doctest.h>

#include "schemes.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double gravity = 9.81, length = 1.3, start = 2.0, mass = 0.7;  // m/s^2, m, rad, kg

Network pendulum() {
  Network net;
  Node pivot = point(Vector3::Zero());
  pivot.fixed = true;
  net.add_node(pivot);
  net.add_node(point({length * std::sin(start), 0, -length * std::cos(start)}, mass));
  net.add_rigid(0, 1);
  net.set_gravity({0, 0, -gravity});
  return net;
}

double period() { return 4.0 * std::sqrt(length / gravity) * std::comp_ellint_1(std::sin(start / 2.0)); }

// How far from its start the pendulum is after one period, rad.
double angle_after_a_period(const LawUse& integrator, double time_step) {
  const Network net = pendulum();
  Simulation simulation = simulate(net, integrator, time_step);
  simulation.advance_to(period());
  CHECK(worst_length(net, simulation) <= 1e-8);  // what rigid connections promise
  const Vector3 p = simulation.position(1);
  return std::atan2(p[0], -p[2]) - start;
}

}  // namespace

TEST_CASE("a rigid pendulum has the period of the elliptic integral") {
  SUBCASE("in the reference") {
    for (const Scheme& scheme : reference_schemes()) {
      INFO(scheme.name);
      // Some 1,000 internal steps with errors of at most 1e-9 of the length and velocity scales each.
      CHECK(std::abs(angle_after_a_period(scheme.integrator, 0.1)) < 1e-6);
    }
  }
  SUBCASE("in steps, with the error of their order") {
    for (const Scheme& scheme : stepping_schemes(1e-9)) {
      INFO(scheme.name);
      const double coarse = std::abs(angle_after_a_period(scheme.integrator, 0.004));
      const double fine = std::abs(angle_after_a_period(scheme.integrator, 0.002));
      CHECK(fine < 0.55 * coarse);
      // 1500 steps a period. Theta 1 loses energy at first order, and the swing gets smaller by that.
      CHECK(fine < (scheme.order == 1.0 ? 0.12 : 2e-4));
    }
  }
}

TEST_CASE("the reference projects onto the constraints between outputs: a pendulum after one long time step") {
  // Ten periods in one time step: some 1,600 internal steps with an error of at most 1e-6 each. Without projection
  // between them the length of the rod drifts, and the angle is off by twenty times as much.
  const Network net = pendulum();
  Simulation simulation = simulate(net, cvode(1e-6), 10.0 * period());
  simulation.advance_to(10.0 * period());
  const Vector3 p = simulation.position(1);
  CHECK(std::abs(std::atan2(p[0], -p[2]) - start) < 1.6e-3);
}

TEST_CASE("the forces in a pendulum's rod and on its pivot") {
  for (const Scheme& scheme : all_schemes(1e-9)) {
    INFO(scheme.name);
    const Network net = pendulum();
    Simulation simulation = simulate(net, scheme.integrator, 0.002);
    // At the start, at rest: the weight's part along the rod.
    CHECK(simulation.rigid_force(0) == doctest::Approx(mass * gravity * std::cos(start)).epsilon(1e-12));
    simulation.advance_to(period() / 3.0);
    const Vector3 p = simulation.position(1), v = simulation.velocity(1);
    const double angle = std::atan2(p[0], -p[2]);
    // From the state that was reached, whatever its error: an identity of the state, so to rounding.
    const double tension = mass * (v.squaredNorm() / length + gravity * std::cos(angle));
    CHECK(simulation.rigid_force(0) == doctest::Approx(tension).epsilon(1e-9));
    // The rod pulls the pivot towards the bob; the pivot's own weight (1 kg) hangs on it too.
    const Vector3 borne = -tension * p / length + Vector3(0, 0, gravity);
    CHECK((simulation.reaction(0) - borne).norm() <= 1e-9 * borne.norm());
    CHECK(simulation.reaction(1).norm() == 0.0);
  }
}
