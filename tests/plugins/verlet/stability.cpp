// The limit of stability that verlet finds, against the method's own matrices: the number of substeps that it advises
// is accepted by the next run, is stable, and is little more than what is needed.

#include <doctest/doctest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <springnet/error.hpp>

#include "../../random_nets/generator.hpp"
#include "eigenvalues.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

LawUse verlet_of(double substeps = 1) { return {"verlet", {{"substeps", substeps}}}; }

// What the error of a first step of `time_step` advises; 0 if the step is taken.
double advice(const Network& net, double time_step, double substeps = 1) {
  Simulation simulation = simulate(net, verlet_of(substeps), time_step);
  try {
    simulation.step();
  } catch (const Error& error) {
    const std::string text = error.what();
    CAPTURE(text);
    const std::size_t at = text.find("substeps = ");
    REQUIRE(at != std::string::npos);
    CHECK(text.find("nan") == std::string::npos);
    CHECK(text.find("inf") == std::string::npos);
    return std::stod(text.substr(at + 11));
  }
  return 0.0;
}

// A linear net at rest, and its matrices over the masses: 1/s^2 and 1/s.
struct DampedNet {
  Network net;
  MatrixXd stiffness, damping;

  explicit DampedNet(std::uint64_t seed) {
    Dice dice(seed);
    const std::uint32_t count = 3 + dice.below(3);
    for (std::uint32_t k = 0; k < count; ++k) net.add_node(point(dice.in_box(1.0), dice.decades(0.1, 10.0)));
    net.fix(0);
    const auto free = static_cast<Eigen::Index>(3 * (count - 1));
    stiffness = damping = MatrixXd::Zero(free, free);
    const double ratio = dice.decades(1e-3, 1e3);  // of damping to stiffness, s
    const bool relative = dice.chance(0.3);
    for (std::uint32_t a = 0; a < count; ++a) {
      for (std::uint32_t b = a + 1; b < count; ++b) {
        if (b > a + 1 && !dice.chance(0.5)) continue;
        const double k = dice.decades(1.0, 1e4), d = dice.chance(0.8) ? ratio * k * dice.decades(0.1, 10.0) : 0.0;
        Material material = damped(k, d);
        if (relative && material.viscosity) material.viscosity->id = "relative";
        net.add_spring(a, b, net.add_material(material));
        const Vector3 n = (net.nodes()[b].position - net.nodes()[a].position).normalized();
        const Eigen::Matrix3d along = n * n.transpose();
        add(stiffness, a, b, k * along);
        add(damping, a, b, relative ? Eigen::Matrix3d(d * Eigen::Matrix3d::Identity()) : Eigen::Matrix3d(d * along));
      }
    }
  }

  void add(MatrixXd& to, std::uint32_t a, std::uint32_t b, const Eigen::Matrix3d& block) const {
    const auto place = [](std::uint32_t node) { return 3 * static_cast<Eigen::Index>(node) - 3; };
    for (const auto& [row, column, sign] : {std::tuple(a, a, 1.0), {b, b, 1.0}, {a, b, -1.0}, {b, a, -1.0}})
      if (row > 0 && column > 0) to.block<3, 3>(place(row), place(column)) += sign / net.nodes()[row].mass * block;
  }

  // s, where h^2 stiffness / 4 + h damping has the eigenvalue 1.
  [[nodiscard]] double limit() const {
    VectorXd root(stiffness.rows());
    for (Eigen::Index i = 0; i < root.size(); ++i)
      root[i] = std::sqrt(net.nodes()[static_cast<std::size_t>(i / 3 + 1)].mass);
    const auto greatest = [&](double h) {
      const MatrixXd both = 0.25 * h * h * stiffness + h * damping;
      const MatrixXd symmetric = root.asDiagonal() * both * root.cwiseInverse().asDiagonal();
      return greatest_eigenvalue(symmetric);
    };
    double low = 0.0, high = 1.0;
    while (greatest(high) < 1.0) high *= 2.0;
    for (int i = 0; i < 50; ++i) (greatest(0.5 * (low + high)) < 1.0 ? low : high) = 0.5 * (low + high);
    return low;
  }

  // The greatest magnitude of the eigenvalues of a step of h on (x, h v, h^2 a).
  [[nodiscard]] double radius(double h) const {
    const Eigen::Index n = stiffness.rows();
    const MatrixXd one = MatrixXd::Identity(n, n), k = h * h * stiffness, c = h * damping;
    MatrixXd step(3 * n, 3 * n), drift(3 * n, 3 * n);
    drift << one, one, 0.5 * one, MatrixXd::Zero(n, n), one, 0.5 * one, MatrixXd::Zero(n, n), MatrixXd::Zero(n, n),
        MatrixXd::Zero(n, n);
    MatrixXd acceleration(n, 3 * n);
    acceleration << -k, -k - c, -0.5 * k - c;
    step = drift;
    step.middleRows(n, n) += 0.5 * acceleration;
    step.bottomRows(n) = acceleration;
    return spectral_radius(step);
  }
};

int nets() {
  const char* wanted = std::getenv("SPRINGNET_VERLET_NETS");
  return wanted == nullptr ? 40 : std::atoi(wanted);
}

}  // namespace

TEST_CASE("advice of substeps is accepted by the next run, stable, and within some per cent of what is needed") {
  double worst = 0.0;
  const int count = nets();
  for (int seed = 0; seed < count; ++seed) {
    CAPTURE(seed);
    const DampedNet example(static_cast<std::uint64_t>(seed));
    const double time_step = 30.0 * example.limit();
    const double substeps = advice(example.net, time_step);
    REQUIRE(substeps >= 30.0);
    CHECK(advice(example.net, time_step, substeps) == 0.0);
    const double h = time_step / substeps;
    // Motions without stiffness have eigenvalues of 1, known to the root of the rounding.
    CHECK(example.radius(h) <= 1.0 + 1e-6);
    CHECK(example.radius(1.04 * h * substeps / (substeps - 1.0)) > 1.0 + 1e-6);
    worst = std::max(worst, example.limit() / h - 1.0);
  }
  MESSAGE(count << " damped nets, advice at most " << 100.0 * worst << " % above what is needed");
}

TEST_CASE("the limit of one oscillator is that of the closed form, without damping, with little and with much") {
  const double mass = 0.5, stiffness = 80.0;
  for (const double damping : {0.0, 0.05, 1.0, 10.0, 1e3, 1e5}) {
    CAPTURE(damping);
    const double k = stiffness / mass, c = damping / mass, limit = 2.0 / (c + std::sqrt(c * c + k));
    const Network net = oscillator(damped(stiffness, damping), mass, 0.01);
    CHECK(advice(net, 0.995 * limit) == 0.0);
    CHECK(advice(net, 1.005 * limit) == 2.0);
    CHECK(advice(net, 1e3 * limit) == doctest::Approx(1030.0).epsilon(2e-3));
    // The motion itself stays bounded, too.
    Simulation simulation = simulate(net, verlet_of(), 0.995 * limit);
    for (int i = 0; i < 300; ++i) simulation.step();
    CHECK(std::abs(simulation.position(1)[0] - 1.0) <= 0.2);
  }
}

TEST_CASE("with rigid connections the limit is that of a step that evaluates the acceleration anew") {
  // Two nodes joined rigidly along the spring move as one mass.
  const double mass = 0.5, stiffness = 80.0;
  for (const double damping : {0.0, 1.0, 10.0, 1e3}) {
    CAPTURE(damping);
    Network net = oscillator(damped(stiffness, damping), mass, 0.01);
    net.add_node(point({1.51, 0, 0}, 3.0 * mass));
    net.add_rigid(1, 2);
    const double k = stiffness / (4.0 * mass), c = damping / (4.0 * mass);
    const double limit = k > c * c ? 4.0 / (c + std::sqrt(4.0 * k - 3.0 * c * c)) : 2.0 / c;
    CHECK(advice(net, 0.995 * limit) == 0.0);
    CHECK(advice(net, 1.01 * limit) == 2.0);
    Simulation simulation = simulate(net, verlet_of(), 0.995 * limit);
    for (int i = 0; i < 300; ++i) simulation.step();
    CHECK(std::abs(simulation.position(1)[0] - 1.0) <= 0.2);
  }
}

TEST_CASE("a limit that damping alone sets is found at once, without nan or inf in messages") {
  // A step that is far above the limit.
  const Network net = oscillator(damped(1.0, 1e6), 1.0, 0.0, 1.0);
  CHECK(advice(net, 0.01) == doctest::Approx(1.03e4).epsilon(1e-3));
  CHECK(advice(net, 0.01, advice(net, 0.01)) == 0.0);
  // More substeps than there can be.
  Simulation simulation = simulate(net, verlet_of(), 1e6);
  try {
    simulation.step();
    FAIL("the step was accepted");
  } catch (const Error& error) {
    const std::string text = error.what();
    CAPTURE(text);
    CHECK(text.find("time_step") != std::string::npos);
    CHECK(text.find("substeps =") == std::string::npos);
  }
}
