// The integrator generalized_alpha against closed forms: its order, its amplification, and what it conserves.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Dense>
#include <springnet/error.hpp>

#include "chung_hulbert.hpp"
#include "eigenvalues.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double radii[] = {0.0, 0.3, 0.8, 1.0};

double elongation_after(const Network& net, const LawUse& integrator, double time_step, double until) {
  Simulation simulation = simulate(net, integrator, time_step);
  simulation.advance_to(until);
  return simulation.position(1)[0] - 1.0;
}

}  // namespace

TEST_CASE("an oscillator, free and damped, is followed with second order at every spectral radius") {
  const double stiffness = 40.0, mass = 0.5, start = 0.1, until = 1.3;  // N/m, kg, m, s
  const double omega = std::sqrt(stiffness / mass);
  for (const double rho : radii) {
    for (const double damping : {0.0, 0.6}) {
      CAPTURE(rho);
      CAPTURE(damping);
      const double decay = damping / (2.0 * mass), damped_omega = std::sqrt(omega * omega - decay * decay);
      const double exact = start * std::exp(-decay * until) *
                           (std::cos(damped_omega * until) + decay / damped_omega * std::sin(damped_omega * until));
      const Network net = oscillator(damped(stiffness, damping), mass, start);
      const auto error = [&](double h) {
        return std::abs(elongation_after(net, generalized_alpha(rho), h, until) - exact);
      };
      const double coarse = error(0.005), fine = error(0.0025);
      CHECK(std::log2(coarse / fine) == doctest::Approx(2.0).epsilon(0.05));
      // rho = 0 has a phase error of 11/12 (omega h)^2 / 2 a radian, the greatest.
      CHECK(fine < start * omega * until * std::pow(omega * 0.0025, 2));
    }
  }
}

TEST_CASE("steps of an oscillator are those of the amplification matrix of Chung and Hulbert") {
  // Mild, of a step's length, and far beyond it; with critical and overcritical damping.
  for (const double rho : radii) {
    for (const double omega_h : {0.2, 3.0, 1e3}) {
      for (const double ratio : {0.0, 0.5, 3.0}) {
        CAPTURE(rho);
        CAPTURE(omega_h);
        CAPTURE(ratio);
        const double h = 0.01, omega = omega_h / h, decay = ratio * omega, mass = 2.0;
        Simulation s = simulate(oscillator(damped(mass * omega * omega, 2.0 * mass * decay), mass, 1e-3, 0.02),
                                generalized_alpha(rho), h);
        s.step();
        // The first step has a = A, an acceleration that it shares with the second one.
        Eigen::Vector3d x(s.position(1)[0] - 1.0, h * s.velocity(1)[0], h * (s.velocity(1)[0] - 0.02));
        const double scale = x.cwiseAbs().maxCoeff();
        const Eigen::Matrix3d map = amplification(rho, omega, decay, h);
        double greatest = scale;
        for (int i = 0; i < 8; ++i) {
          s.step();
          x = map * x;
          greatest = std::max(greatest, x.cwiseAbs().maxCoeff());
          // Roundings of a length of 1 m are forces, and so accelerations, of 1e-16 (omega h)^2 of the displacement.
          CHECK(std::abs(s.position(1)[0] - 1.0 - x[0]) <= 1e-12 * greatest + 1e-14);
          CHECK(std::abs(h * s.velocity(1)[0] - x[1]) <= 1e-11 * greatest + 1e-12);
        }
      }
    }
  }
}

TEST_CASE("what a step leaves of infinitely stiff motions is the spectral radius") {
  // The closed form at omega h = 1e6; the three eigenvalues meet at -rho.
  for (const double rho : radii) {
    CAPTURE(rho);
    CHECK(spectral_radius(amplification(rho, 1e8, 0.0, 0.01)) == doctest::Approx(rho).epsilon(1e-3));
  }
  // Simulated, by the ratio of states 16 steps apart: eigenvalues -rho with one vector give rho^k (1, k, k^2).
  const double h = 0.01, omega = 1e4 / h;
  for (const double rho : {0.3, 0.8, 1.0}) {
    CAPTURE(rho);
    Simulation s = simulate(oscillator(damped(omega * omega, 0.0), 1.0, 1e-2), generalized_alpha(rho), h);
    std::vector<double> size;
    for (int i = 0; i < 24; ++i) {
      s.step();
      size.push_back(std::abs(s.position(1)[0] - 1.0));
    }
    // Third differences of size / rho^k vanish: growth is polynomial beside rho^k.
    const auto scaled = [&](int k) { return size[static_cast<std::size_t>(k)] / std::pow(rho, k); };
    const double third = scaled(8) - 3.0 * scaled(7) + 3.0 * scaled(6) - scaled(5);
    CHECK(std::abs(third) <= 1e-3 * std::abs(scaled(8)));
  }
}

TEST_CASE("with spectral radius 0 stiff motions are gone after the first step") {
  const double h = 0.01, omega = 1e6 / h;
  Simulation s = simulate(oscillator(damped(omega * omega, 0.0), 1.0, 1e-2), generalized_alpha(0.0), h);
  s.step();
  CHECK(std::abs(s.position(1)[0] - 1.0) <= 1e-12);
  for (int i = 0; i < 3; ++i) s.step();
  CHECK(std::abs(s.velocity(1)[0]) <= 1e-8);  // from 2 m/s after the first step
}

TEST_CASE("with spectral radius 1 nothing is damped; with less, fast motions are and slow ones hardly") {
  const Network net = oscillator(damped(100.0, 0.0), 1.0, 0.1);
  const double h = 0.05, energy = 0.5;  // omega h = 0.5
  for (const double rho : radii) {
    CAPTURE(rho);
    Simulation s = simulate(net, generalized_alpha(rho), h);
    s.advance_to(200.0 * h);
    const double left = (s.kinetic_energy() + s.potential_energy()) / energy;
    if (rho == 1.0) {
      CHECK(left == doctest::Approx(1.0).epsilon(1e-9));
    } else {
      const double magnitude = spectral_radius(amplification(rho, 10.0, 0.0, h));
      CHECK(left == doctest::Approx(std::pow(magnitude, 400.0)).epsilon(0.05).scale(0.05));
    }
  }
}

TEST_CASE("momentum of a body is kept to rounding, angular momentum to second order") {
  Lattice lattice;
  lattice.nodes = {4, 4, 4};
  lattice.diagonals = Diagonals::all;
  Network net;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(30.0, 0.2)));
  for (NodeIndex k = 0; k < 64; ++k) {
    Node node = net.nodes()[k];
    node.velocity = {0.1 * std::sin(k), 0.1 * std::cos(2.0 * k), 0.05 * std::sin(3.0 * k)};
    net.set_node(k, node);
  }
  double off[2];
  for (int i = 0; i < 2; ++i) {
    Simulation s = simulate(net, generalized_alpha(0.8), i == 0 ? 0.02 : 0.01);
    const Vector3 momentum = s.momentum(), spin = s.angular_momentum();
    s.advance_to(2.0);
    CHECK((s.momentum() - momentum).norm() <= 1e-11);
    off[i] = (s.angular_momentum() - spin).norm();
  }
  CHECK(std::log2(off[0] / off[1]) >= 1.8);
}

TEST_CASE("loads that vary, and jumps of loads within a step, keep the second order") {
  const double mass = 0.5;
  Network net = oscillator(damped(20.0, 0.4), mass, 0.0);
  Load pull{{1}, {3.0, 0, 0}};
  pull.course.ramp = 0.437;  // ends within a step
  net.add_load(pull);
  Load late{{1}, {-2.0, 0, 0}};
  late.from = 0.553;
  net.add_load(late);
  const double exact = elongation_after(net, cvode(1e-12), 0.1, 1.0);
  for (const double rho : radii) {
    CAPTURE(rho);
    const auto error = [&](double h) {
      return std::abs(elongation_after(net, generalized_alpha(rho), h, 1.0) - exact);
    };
    const double coarse = error(0.01), fine = error(0.0025);
    CHECK(std::log2(coarse / fine) / 2.0 >= 1.8);
    CHECK(fine <= 1e-4);
  }
}

TEST_CASE("steps of changing length keep the state, and start the method anew") {
  const Network net = oscillator(damped(20.0, 0.4), 0.5, 0.1);
  const double exact = elongation_after(net, cvode(1e-12), 0.1, 1.0);
  Simulation s = simulate(net, generalized_alpha(0.8), 0.01);
  for (const double time : {0.013, 0.2, 0.317, 0.61, 1.0}) s.advance_to(time);
  CHECK(std::abs(s.position(1)[0] - 1.0 - exact) <= 1e-4);
}

TEST_CASE("every step is stable, as inspection says, and an unsolvable one is an error with its time") {
  Simulation s = simulate(oscillator(damped(1e8, 0.0), 1.0, 1e-3), generalized_alpha(0.8), 1.0);
  for (int i = 0; i < 300; ++i) s.step();
  CHECK(std::abs(s.position(1)[0] - 1.0) <= 1e-2);
}
