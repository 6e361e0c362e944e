// One mass on one damped spring: x'' = -omega^2 x - 2 zeta omega x', undamped, under-, critically and over-damped.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/Dense>
#include <unsupported/Eigen/MatrixFunctions>

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

struct Oscillator {
  double omega, zeta, x0, v0;

  // Closed forms of the three regimes.
  [[nodiscard]] double at(double t) const {
    const double decay = zeta * omega;
    if (zeta < 1.0) {
      const double turning = omega * std::sqrt(1.0 - zeta * zeta);
      return std::exp(-decay * t) * (x0 * std::cos(turning * t) + (v0 + decay * x0) / turning * std::sin(turning * t));
    }
    if (zeta == 1.0) return std::exp(-omega * t) * (x0 + (v0 + omega * x0) * t);
    const double root = omega * std::sqrt(zeta * zeta - 1.0);
    return std::exp(-decay * t) * (x0 * std::cosh(root * t) + (v0 + decay * x0) / root * std::sinh(root * t));
  }

  // The error of a one-step method y' = (I + h A + h^2 N + …) y after time t is h E(t) + O(h^2), with
  // E(t) = integral_0^t exp((t - s) A) B exp(s A) y0 ds and B = N - A^2/2: the upper right block of exp(t [A B; 0 A]).
  // Backward Euler has N = A^2. The single sweep reads p, v and adds h^2 a to the position: N = [a; 0].
  [[nodiscard]] double first_order_error(Order order, double t) const {
    Eigen::Matrix2d a, n;
    a << 0, 1, -omega * omega, -2 * zeta * omega;
    if (order == Order::fixed_point) {
      n = a * a;
    } else {
      n << -omega * omega, -2 * zeta * omega, 0, 0;
    }
    Eigen::Matrix4d block = Eigen::Matrix4d::Zero();
    block.topLeftCorner<2, 2>() = block.bottomRightCorner<2, 2>() = t * a;
    block.topRightCorner<2, 2>() = t * (n - a * a / 2.0);
    const Eigen::Matrix4d exponential = block.exp();
    return (exponential.topRightCorner<2, 2>() * Eigen::Vector2d(x0, v0))[0];
  }
};

}  // namespace

TEST_CASE("oscillator: undamped, under-, critically and over-damped") {
  constexpr double mass = 0.5, omega = 2.0, end = 3.0;
  for (const double zeta : {0.0, 0.2, 1.0, 2.5}) {
    const Oscillator exact{omega, zeta, 0.3, -0.4};
    const Material material = damped(mass * omega * omega, 2.0 * zeta * omega * mass);
    const double fastest = omega * (zeta > 1.0 ? zeta + std::sqrt(zeta * zeta - 1.0) : 1.0);  // 1/s
    for (const Method& method : all_methods(1e-11)) {
      CAPTURE(zeta);
      CAPTURE(method.name);
      constexpr double h = 1e-3;
      Simulation simulation = simulate(oscillator(material, mass, exact.x0, exact.v0), method.integrator, h);
      double greatest = 0.0;  // first-order error of all times
      for (int i = 1; method.order != Order::reference && i <= 6; ++i)
        greatest = std::max(greatest, std::abs(h * exact.first_order_error(method.order, end * i / 6.0)));
      for (int i = 1; i <= 6; ++i) {
        const double t = end * i / 6.0;
        CAPTURE(t);
        simulation.advance_to(t);
        const double error = simulation.position(1)[0] - 1.0 - exact.at(t);
        if (method.order == Order::reference) {
          // Scales: rest length 1 m, and the same number of m/s or less.
          CHECK(std::abs(error) < reference_error(simulation));
          continue;
        }
        const double predicted = h * exact.first_order_error(method.order, t);
        // The second-order term relative to the first is at most h lambda (1 + t lambda), lambda the fastest rate.
        CHECK(std::abs(error - predicted) < h * fastest * (1.0 + t * fastest) * greatest);
      }
      CHECK(simulation.velocity(1).tail<2>() == Eigen::Vector2d::Zero());
    }
  }
}

TEST_CASE("oscillator in a viscous medium: the drag of the neuron damps like a dashpot to the wall") {
  constexpr double mass = 0.5, omega = 2.0, zeta = 0.2, end = 3.0, h = 1e-3;
  const Oscillator exact{omega, zeta, 0.3, 0.0};
  for (const Method& method : all_methods(1e-11)) {
    CAPTURE(method.name);
    Network net = oscillator(damped(mass * omega * omega, 0.0), mass, exact.x0);
    Node ball = net.nodes()[1];
    ball.neuron = net.add_neuron({"dragged", {{"drag", 2.0 * zeta * omega * mass}}});
    net.set_node(1, ball);
    Simulation simulation = simulate(net, method.integrator, h);
    simulation.advance_to(end);
    const double error = simulation.position(1)[0] - 1.0 - exact.at(end);
    const double predicted = method.order == Order::reference ? 0.0 : h * exact.first_order_error(method.order, end);
    // As above: 0.2 % … of the first-order error, whose size is that of the amplitude times h omega t.
    const double bound = method.order == Order::reference
                             ? reference_error(simulation)
                             : h * h * omega * omega * end * (1.0 + omega * end) * exact.x0;
    CHECK(std::abs(error - predicted) < bound);
  }
}

TEST_CASE("relative damping equals axial damping along the line of the spring") {
  // The whole relative velocity is along the spring here. Same path of numbers up to rounding, so for every method.
  constexpr double mass = 0.5, stiffness = 2.0, damping = 0.3, end = 2.0;
  const Material axial = damped(stiffness, damping);
  const Material relative{axial.spring, LawUse{"relative", {{"damping", damping}}}};
  for (const Method& method : all_methods(1e-11)) {
    CAPTURE(method.name);
    Simulation a = simulate(oscillator(axial, mass, 0.2), method.integrator, 0.01);
    Simulation b = simulate(oscillator(relative, mass, 0.2), method.integrator, 0.01);
    a.advance_to(end);
    b.advance_to(end);
    // Settling tolerance 1e-11 N a step, 200 steps; the reference's Jacobian differs, so its steps may.
    const double bound = method.order == Order::reference ? 2 * reference_error(a) : 1e-10;
    CHECK(std::abs(a.position(1)[0] - b.position(1)[0]) < bound);
  }
}
