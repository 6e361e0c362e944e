// Local propagation: its fixed point, its single sweeps, and the agreement of the update rules.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/Dense>

#include "nets.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

// A tetrahedron of soft, damped springs under gravity with one corner fixed, set into rotation: every kind of term
// of the equations of motion is there, none of them symmetric.
struct Tetrahedron {
  static constexpr double stiffness = 7.0, damping = 0.9, mass = 1.3, gravity = 2.0;
  std::vector<Vector3> position{{0, 0, 0}, {1, 0.1, 0}, {0.2, 1.1, 0}, {0.3, 0.4, 0.9}};
  std::vector<Vector3> velocity{{0, 0, 0}, {0.3, -0.5, 0.4}, {-0.7, 0.2, 0.1}, {0.5, 0.6, -0.3}};
  std::vector<double> rest;  // of springs (0,1), (0,2), (0,3), (1,2), (1,3), (2,3)

  [[nodiscard]] Network network() {
    Network net;
    const MaterialIndex material = net.add_material(damped(stiffness, damping));
    for (std::size_t k = 0; k < 4; ++k) {
      Node node = point(position[k], mass, velocity[k]);
      node.fixed = k == 0;
      net.add_node(node);
    }
    rest.clear();
    for (std::uint32_t a = 0; a < 4; ++a) {
      for (std::uint32_t b = a + 1; b < 4; ++b) {
        rest.push_back(0.8 * (position[a] - position[b]).norm());  // stretched from the start
        net.add_spring(a, b, material, rest.back());
      }
    }
    net.set_gravity({0, 0, -gravity});
    return net;
  }

  // Net forces on nodes 1, 2, 3, written out here once more.
  [[nodiscard]] Eigen::VectorXd forces(const std::vector<Vector3>& p, const std::vector<Vector3>& v) const {
    std::vector<Vector3> f(4, Vector3(0, 0, -mass * gravity));
    std::size_t s = 0;
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = a + 1; b < 4; ++b, ++s) {
        const Vector3 d = p[a] - p[b];
        const Vector3 n = d.normalized();
        const Vector3 pull = (stiffness * (d.norm() - rest[s]) + damping * n.dot(v[a] - v[b])) * n;
        f[a] -= pull;
        f[b] += pull;
      }
    }
    Eigen::VectorXd result(9);
    result << f[1], f[2], f[3];
    return result;
  }

  // Newton's method on R(U) = m (U - v) - t_c F(p + t_c U, U), Jacobian by central differences.
  [[nodiscard]] Eigen::VectorXd backward_euler_velocity(double t_c) const {
    const auto residual = [&](const Eigen::VectorXd& u) {
      std::vector<Vector3> p = position, v(4, Vector3::Zero());
      Eigen::VectorXd start(9);
      for (std::size_t k = 1; k < 4; ++k) {
        v[k] = u.segment<3>(3 * (static_cast<Eigen::Index>(k) - 1));
        p[k] += t_c * v[k];
        start.segment<3>(3 * (static_cast<Eigen::Index>(k) - 1)) = velocity[k];
      }
      return Eigen::VectorXd(mass * (u - start) - t_c * forces(p, v));
    };
    Eigen::VectorXd u = Eigen::VectorXd::Zero(9);
    for (int iteration = 0; iteration < 30; ++iteration) {
      Eigen::MatrixXd jacobian(9, 9);
      for (Eigen::Index j = 0; j < 9; ++j) {
        Eigen::VectorXd up = u, down = u;
        up[j] += 1e-6;
        down[j] -= 1e-6;
        jacobian.col(j) = (residual(up) - residual(down)) / 2e-6;
      }
      u -= jacobian.partialPivLu().solve(residual(u));
    }
    REQUIRE(residual(u).norm() < 1e-13);  // Newton's method has converged to rounding
    return u;
  }
};

// Some nodes of a lattice with velocities that are different for each.
Network jelly(std::uint32_t nodes) {
  Network net;
  Lattice lattice;
  lattice.nodes = {nodes, nodes, nodes};
  lattice.diagonals = Diagonals::all;
  net.add_lattice("jelly", lattice, point(Vector3::Zero(), 0.5), net.add_material(damped(4.0, 0.3)));
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    const double phase = static_cast<double>(k);
    node.velocity = {std::sin(phase), std::cos(1.3 * phase), std::sin(0.7 * phase + 1.0)};
    net.set_node(k, node);
  }
  return net;
}

}  // namespace

TEST_CASE("the fixed point is the backward Euler step, found independently by Newton's method") {
  Tetrahedron tetrahedron;
  const Network net = tetrahedron.network();
  constexpr double t_c = 0.1, force_tolerance = 1e-11;
  const Eigen::VectorXd expected = tetrahedron.backward_euler_velocity(t_c);
  for (const double update : {synchronous, wavefront}) {
    CAPTURE(update);
    Simulation simulation = simulate(net, recurrent(update, force_tolerance), t_c);
    const StepReport report = simulation.step();
    CHECK(report.outcome == Outcome::settled);
    CHECK(report.force_difference <= force_tolerance);
    // The iteration contracts by about t_c^2 k/m + t_c d/m times the four springs at a node, below 0.8: what is left
    // after the last sweep is a few times what it changed.
    CHECK(report.residual < 10 * force_tolerance);
    for (NodeIndex k = 1; k < 4; ++k) {
      const Vector3 u = expected.segment<3>(3 * (static_cast<Eigen::Index>(k) - 1));
      // Residual force times t_c / m, times ten for the inverse of the contraction; 1e-13 for rounding.
      CHECK((simulation.velocity(k) - u).norm() < 10 * force_tolerance * t_c + 1e-13);
      CHECK((simulation.position(k) - (tetrahedron.position[k] + t_c * u)).norm() < 1e-11);
    }
    CHECK(simulation.position(0) == Vector3::Zero());
  }
}

TEST_CASE("the reported residual is the error of the equation of motion") {
  // The force that the test computes itself, at the outputs that the simulation gives, after too few sweeps.
  Tetrahedron tetrahedron;
  const Network net = tetrahedron.network();
  constexpr double t_c = 0.1;
  Simulation simulation = simulate(net, recurrent(synchronous, 0, {{"sweeps", 3}}), t_c);
  const StepReport report = simulation.step();
  CHECK(report.sweeps == 3);
  std::vector<Vector3> p, u;
  for (NodeIndex k = 0; k < 4; ++k) {
    p.push_back(simulation.position(k));
    u.push_back(simulation.velocity(k));
  }
  const Eigen::VectorXd force = tetrahedron.forces(p, u);
  double residual = 0.0;
  for (std::size_t k = 1; k < 4; ++k) {
    const Vector3 f = force.segment<3>(3 * (static_cast<Eigen::Index>(k) - 1));
    residual = std::max(residual, (Tetrahedron::mass * (u[k] - tetrahedron.velocity[k]) / t_c - f).norm());
    CHECK((simulation.force(static_cast<NodeIndex>(k)) - f).norm() < 1e-12);  // rounding of forces of some newtons
  }
  CHECK(residual > 1e-3);                                             // there is something to report
  CHECK(report.residual == doctest::Approx(residual).epsilon(1e-9));  // rounding, against forces of some newtons
}

TEST_CASE("one synchronous sweep is the symplectic Euler step, n sweeps are n iterations by hand") {
  Tetrahedron tetrahedron;
  const Network net = tetrahedron.network();
  constexpr double t_c = 0.1;
  std::vector<Vector3> p = tetrahedron.position, u = tetrahedron.velocity;
  Eigen::VectorXd last_force;
  for (int sweeps = 1; sweeps <= 4; ++sweeps) {
    CAPTURE(sweeps);
    const Eigen::VectorXd force = tetrahedron.forces(p, u);
    for (std::size_t k = 1; k < 4; ++k) {
      const Vector3 f = force.segment<3>(3 * (static_cast<Eigen::Index>(k) - 1));
      u[k] = tetrahedron.velocity[k] + t_c * f / Tetrahedron::mass;
      p[k] = tetrahedron.position[k] + t_c * u[k];
    }
    Simulation simulation = simulate(net, recurrent(synchronous, 0, {{"sweeps", static_cast<double>(sweeps)}}), t_c);
    const StepReport report = simulation.step();
    CHECK(report.outcome == Outcome::settled);
    CHECK(report.sweeps == static_cast<std::uint64_t>(sweeps));
    CHECK(std::isnan(report.residual) == (sweeps == 1));
    CHECK(report.start_node == -1);
    if (sweeps > 1) {
      // Of nodes 1, 2, 3 and of node 0, whose force is the opposite of their sum.
      const Eigen::VectorXd change = force - last_force;
      double greatest = (change.segment<3>(0) + change.segment<3>(3) + change.segment<3>(6)).norm();
      for (Eigen::Index i = 0; i < 9; i += 3) greatest = std::max(greatest, change.segment<3>(i).norm());
      CHECK(report.force_difference == doctest::Approx(greatest).epsilon(1e-12));
    }
    last_force = force;
    for (std::size_t k = 0; k < 4; ++k) {
      // Rounding only.
      CHECK((simulation.position(static_cast<NodeIndex>(k)) - p[k]).norm() < 1e-14);
      CHECK((simulation.velocity(static_cast<NodeIndex>(k)) - u[k]).norm() < 1e-13);
    }
  }
}

TEST_CASE("synchronous sweeps of a large net read only the outputs of the sweep before") {
  const Network net = jelly(21);  // 9261 nodes: more than a unit holds
  constexpr double t_c = 0.02, stiffness = 4.0, damping = 0.3, mass = 0.5;
  constexpr int sweeps = 3;
  std::vector<Vector3> p, u;
  for (const Node& node : net.nodes()) {
    p.push_back(node.position);
    u.push_back(node.velocity);
  }
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    std::vector<Vector3> force(p.size(), Vector3::Zero());
    for (const Spring& spring : net.springs()) {
      const Vector3 d = p[spring.first] - p[spring.second];
      const Vector3 n = d.normalized();
      const double rate = n.dot(u[spring.first] - u[spring.second]);
      const Vector3 pull = (stiffness * (d.norm() - spring.rest_length) + damping * rate) * n;
      force[spring.first] -= pull;
      force[spring.second] += pull;
    }
    for (std::size_t k = 0; k < p.size(); ++k) {
      u[k] = net.nodes()[k].velocity + t_c * force[k] / mass;
      p[k] = net.nodes()[k].position + t_c * u[k];
    }
  }
  Simulation simulation = simulate(net, recurrent(synchronous, 0, {{"sweeps", sweeps}}), t_c);
  simulation.step();
  double worst = 0.0;
  for (NodeIndex k = 0; k < p.size(); ++k) worst = std::max(worst, (simulation.velocity(k) - u[k]).norm());
  CHECK(worst < 1e-13);  // rounding of sums of 26 forces
}

TEST_CASE("one wavefront sweep updates the nodes one by one, each from the newest outputs") {
  Tetrahedron tetrahedron;
  const Network net = tetrahedron.network();
  constexpr double t_c = 0.1;
  const Eigen::VectorXd at_start = tetrahedron.forces(tetrahedron.position, tetrahedron.velocity);
  std::size_t start = 1;
  for (std::size_t k = 2; k < 4; ++k) {
    const auto at = [&](std::size_t i) { return at_start.segment<3>(3 * (static_cast<Eigen::Index>(i) - 1)).norm(); };
    if (at(k) > at(start)) start = k;
  }
  std::vector<Vector3> p = tetrahedron.position, u = tetrahedron.velocity;
  std::vector<std::size_t> order{start};  // all corners are neighbours: the others follow by their number
  for (std::size_t k = 1; k < 4; ++k) {
    if (k != start) order.push_back(k);
  }
  for (const std::size_t k : order) {
    const Vector3 f = tetrahedron.forces(p, u).segment<3>(3 * (static_cast<Eigen::Index>(k) - 1));
    u[k] = tetrahedron.velocity[k] + t_c * f / Tetrahedron::mass;
    p[k] = tetrahedron.position[k] + t_c * u[k];
  }
  Simulation simulation = simulate(net, recurrent(wavefront, 0, {{"sweeps", 1}}), t_c);
  const StepReport report = simulation.step();
  CHECK(report.start_node == static_cast<std::int64_t>(start));
  for (std::size_t k = 1; k < 4; ++k) {
    CHECK((simulation.velocity(static_cast<NodeIndex>(k)) - u[k]).norm() < 1e-13);  // rounding
  }
}

TEST_CASE("wavefront and synchronous reach the same fixed point to the threshold") {
  const Network net = jelly(4);
  constexpr double t_c = 0.05, force_tolerance = 1e-9;
  constexpr int steps = 20;
  Simulation a = simulate(net, recurrent(synchronous, force_tolerance), t_c);
  Simulation b = simulate(net, recurrent(wavefront, force_tolerance), t_c);
  for (int i = 0; i < steps; ++i) {
    a.step();
    b.step();
  }
  // A step is off by at most t_c tolerance / m in a velocity, times the inverse of what the iteration contracts short
  // of one (26 springs a node: it contracts by about 0.6 a sweep, so 3). The net damps what it is given: errors add up.
  const double bound = steps * 3 * t_c * force_tolerance / 0.5;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    CHECK((a.velocity(k) - b.velocity(k)).norm() < bound);
    CHECK((a.position(k) - b.position(k)).norm() < bound * t_c * steps);
  }
  CHECK(b.sweeps() < a.sweeps());
}

TEST_CASE("halving the time constant halves the error of the fixed point") {
  // An oscillator with omega 2/s, damping ratio 0.1, over 3 s; closed form of the free decay.
  constexpr double mass = 0.5, stiffness = 2.0, damping = 0.2, start = 0.3, end = 3.0;
  const double omega = std::sqrt(stiffness / mass), decay = damping / (2 * mass);
  const double turning = std::sqrt(omega * omega - decay * decay);
  const double exact =
      start * std::exp(-decay * end) * (std::cos(turning * end) + decay / turning * std::sin(turning * end));
  for (const double update : {synchronous, wavefront}) {
    CAPTURE(update);
    std::vector<double> error;
    for (const double t_c : {0.02, 0.01, 0.005, 0.0025}) {
      Simulation simulation =
          simulate(oscillator(damped(stiffness, damping), mass, start), recurrent(update, 1e-11), t_c);
      simulation.advance_to(end);
      error.push_back(std::abs(simulation.position(1)[0] - 1.0 - exact));
    }
    for (std::size_t i = 1; i < error.size(); ++i) {
      const double order = std::log2(error[i - 1] / error[i]);
      // First order; what is left of the second-order term falls with the step: at most omega t_c relative.
      CHECK(order == doctest::Approx(1.0).epsilon(0.04 / std::pow(2.0, static_cast<double>(i - 1))));
    }
  }
}

TEST_CASE("a node that feeds back its own velocity settles on its own backward Euler step") {
  // Free fall in a viscous medium: the net force is constant, only the drag changes from sweep to sweep.
  Network net;
  Node ball = point(Vector3::Zero(), 2.0, {0, 0, 1.0});
  ball.neuron = net.add_neuron({"dragged", {{"drag", 3.0}}});
  net.add_node(ball);
  net.set_gravity({0, 0, -9.0});
  constexpr double t_c = 0.1, force_tolerance = 1e-12;
  for (const double update : {synchronous, wavefront}) {
    CAPTURE(update);
    Simulation simulation = simulate(net, recurrent(update, force_tolerance), t_c);
    const StepReport report = simulation.step();
    const double expected = (1.0 - t_c * 9.0) / (1.0 + t_c * 3.0 / 2.0);
    // Difference times t_c / m and 1 / (1 - 0.15), the contraction; rounding.
    CHECK(std::abs(simulation.velocity(0)[2] - expected) < 1e-13);
    CHECK(report.residual < 2 * force_tolerance);
    CHECK(report.sweeps > 5);  // 0.15^n of a drag of some newtons
  }
}

TEST_CASE("the automatic tolerance is a millionth of the greatest weight") {
  const Network net = cube(3.0, 2.0, 0.2, 0.081);
  Simulation unset = simulate(net, recurrent(wavefront, 0.0), 0.05);
  Simulation given = simulate(net, recurrent(wavefront, 1e-6 * 0.2), 0.05);
  for (int i = 0; i < 20; ++i) {
    unset.step();
    given.step();
  }
  CHECK(unset.sweeps() == given.sweeps());
  CHECK(unset.positions() == given.positions());
}

TEST_CASE("nothing depends on the number of threads") {
  const Network net = jelly(27);  // 19683 nodes: a unit has 8192 at most
  for (const LawUse& integrator : {recurrent(synchronous, 1e-2), recurrent(wavefront, 0, {{"sweeps", 2}})}) {
    std::vector<Simulation> simulations;
    for (const unsigned threads : {1u, 2u, 3u}) {
      SimulationOptions options;
      options.time_step = 0.03;
      options.threads = threads;
      options.integrator = integrator;
      simulations.emplace_back(net, plugins(), options);
      REQUIRE(simulations.back().threads() == threads);
    }
    for (int i = 0; i < 2; ++i) {
      const StepReport one = simulations[0].step();
      for (std::size_t j = 1; j < simulations.size(); ++j) {
        const StepReport many = simulations[j].step();
        CHECK(many.sweeps == one.sweeps);
        CHECK(many.force_difference == one.force_difference);
        CHECK(many.residual == one.residual);
        CHECK(many.node == one.node);
        CHECK(many.start_node == one.start_node);
        CHECK(simulations[j].positions() == simulations[0].positions());
        CHECK(simulations[j].velocities() == simulations[0].velocities());
      }
    }
  }
}

TEST_CASE("the residual leaves out nodes that a surface stops, and only those") {
  // Node 1 hits the floor in the second step; node 0 hangs above it on a spring and moves on.
  Network net;
  const MaterialIndex material = net.add_material(damped(2.0, 0.1));
  net.add_node(point({0, 0, 1.06}));
  net.add_node(point({0, 0, 0.06}));
  net.add_spring(0, 1, material, 0.9);
  net.set_gravity({0, 0, -4});
  net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  constexpr double force_tolerance = 1e-9;
  for (const double update : {synchronous, wavefront}) {
    CAPTURE(update);
    Simulation simulation = simulate(net, recurrent(update, force_tolerance), 0.1);
    while (!simulation.held(1)) {
      const StepReport report = simulation.step();
      CHECK(report.outcome == Outcome::settled);
      CHECK(report.residual < force_tolerance);  // the stop of node 1 alone is some newtons
      CHECK(report.residual > 0.0);              // node 0 counts
    }
    CHECK(simulation.steps() == 2);
    CHECK(simulation.step().residual < force_tolerance);
  }
}
