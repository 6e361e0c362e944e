// A chain between two walls swings along itself in its normal modes: node j of N in mode r moves as
// sin(j r pi / (N + 1)) cos(omega_r t) with omega_r = 2 sqrt(k / m) sin(r pi / (2 (N + 1))).
#include <cmath>
#include <cstdint>
#include <numbers>

#include <doctest/doctest.h>

#include "methods.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

constexpr std::uint32_t free_nodes = 6;
constexpr double stiffness = 3.0, mass = 0.7, amplitude = 0.05;

double shape(std::uint32_t mode, std::uint32_t node) {
  return std::sin(node * mode * std::numbers::pi / (free_nodes + 1));
}

double frequency(std::uint32_t mode) {
  return 2.0 * std::sqrt(stiffness / mass) * std::sin(mode * std::numbers::pi / (2 * (free_nodes + 1)));
}

Network swinging_chain(std::uint32_t mode) {
  Network net = chain(free_nodes + 2, Vector3::Zero(), Vector3::UnitX(), damped(stiffness, 0.0), mass);
  net.fix(0);
  net.fix(free_nodes + 1);
  for (std::uint32_t k = 1; k <= free_nodes; ++k) {
    Node node = net.nodes()[k];
    node.position[0] += amplitude * shape(mode, k);
    net.set_node(k, node);
  }
  return net;
}

// cos(omega t) after n steps h of each method, exactly: the mode is an eigenvector of their iterations as well.
double swing(Order order, double omega, double h, std::uint64_t n) {
  const auto steps = static_cast<double>(n);
  if (order == Order::reference) return std::cos(omega * h * steps);
  if (order == Order::fixed_point) {
    // Backward Euler multiplies by 1 / (1 - i h omega).
    return std::pow(1.0 + h * h * omega * omega, -0.5 * steps) * std::cos(steps * std::atan(h * omega));
  }
  // Symplectic Euler: x[n+1] - 2 x[n] + x[n-1] = -h^2 omega^2 x[n], x[1] = (1 - h^2 omega^2) x[0].
  const double square = h * h * omega * omega;
  const double angle = std::acos(1.0 - square / 2.0);
  return std::cos(steps * angle) + (1.0 - square - std::cos(angle)) / std::sin(angle) * std::sin(steps * angle);
}

}  // namespace

TEST_CASE("normal modes of a chain between two walls") {
  constexpr double h = 0.02, force_tolerance = 1e-12;
  constexpr std::uint64_t steps = 250;  // 5 s, from 0.7 to 3 periods
  for (std::uint32_t mode = 1; mode <= free_nodes; ++mode) {
    for (const Method& method : all_methods(force_tolerance)) {
      CAPTURE(mode);
      CAPTURE(method.name);
      Simulation simulation = simulate(swinging_chain(mode), method.integrator, h);
      simulation.advance_to(h * static_cast<double>(steps));
      // Against the closed form of the method. Each step leaves its velocities off by h tolerance / m at most, and the
      // position off by that times the time: 1e-12 in all. Rounding adds 1e-16 a step.
      double bound = 5e-12;
      if (method.order == Order::reference) bound = reference_error(simulation);
      const double expected = amplitude * swing(method.order, frequency(mode), h, steps);
      for (std::uint32_t k = 1; k <= free_nodes; ++k) {
        CHECK(std::abs(simulation.position(k)[0] - k - expected * shape(mode, k)) < bound);
      }
    }
  }
}

TEST_CASE("normal modes: what the closed forms of the methods are to that of the chain") {
  // The forms above are those of the true motion to first order: the phase lags or leads by a part of h, the fixed
  // point loses exp(-h omega^2 t / 2) of its amplitude.
  for (std::uint32_t mode = 1; mode <= free_nodes; ++mode) {
    const double omega = frequency(mode), t = 5.0;
    for (const Order order : {Order::fixed_point, Order::single_sweep}) {
      for (const double h : {1e-3, 1e-4}) {
        const double off = swing(order, omega, h, static_cast<std::uint64_t>(std::round(t / h))) - std::cos(omega * t);
        // Backward Euler: h omega^2 t / 2; symplectic Euler: h omega / 2 and h^2 omega^3 t / 24.
        const double leading = order == Order::fixed_point ? h * omega * omega * t / 2 : h * omega / 2;
        CHECK(std::abs(off) < 1.05 * leading);
      }
    }
  }
}
