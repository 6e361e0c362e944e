// The local force model against closed forms, and against whole steps that take a grasped node or a surface elsewhere.
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <Eigen/Eigenvalues>
#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

using Matrix = Eigen::Matrix3d;

constexpr double step = 0.02;

// Wall, free node of 0.5 kg, handle: 2 m along x, springs at rest. Node 2 is the handle.
Network two_springs(double first_stiffness, double first_damping, double second_stiffness, double second_damping) {
  Network net;
  Node wall = point({0, 0, 0});
  wall.fixed = true;
  net.add_node(wall);
  net.add_node(point({1, 0, 0}, 0.5));
  Node handle = point({2, 0, 0});
  handle.fixed = true;
  net.add_node(handle);
  net.add_spring(0, 1, net.add_material(damped(first_stiffness, first_damping)));
  net.add_spring(1, 2, net.add_material(damped(second_stiffness, second_damping)));
  return net;
}

// A soft block, 4 x 4 x 4 nodes 0.1 m apart, with its lower side fixed.
Network soft_block(bool elements = false) {
  Network net;
  const Material tissue{LawUse{"nonlinear", {{"stiffness", 200.0}, {"cubic", 1e5}}},
                        LawUse{"linear", {{"damping", 0.4}}}};
  net.add_lattice("block", {.nodes = {4, 4, 4}, .spacing = Vector3::Constant(0.1), .diagonals = Diagonals::all},
                  point(Vector3::Zero(), 0.01), net.add_material(tissue));
  for (NodeIndex k = 0; k < 16; ++k) net.fix(k);
  if (elements) {
    net.add_element(Invariant::volume, {21, 22, 25, 37},
                    net.add_material({LawUse{"linear", {{"stiffness", 1e6}}}, {}}));
    net.add_element(Invariant::dihedral, {21, 22, 25, 26},
                    net.add_material({LawUse{"linear", {{"stiffness", 0.1}}}, {}}));
  }
  net.set_gravity({0, 0, -9.81});
  return net;
}

// What is moved in the last step, and the force on it.
struct Handle {
  std::optional<NodeIndex> node{};
  std::size_t surface = 0;
  [[nodiscard]] LocalForce model(Simulation& simulation, double over = 0.0) const {
    return node ? simulation.local_force(*node, over) : simulation.local_surface_force(surface, over);
  }
  [[nodiscard]] Vector3 force(const Simulation& simulation) const {
    return node ? Vector3(-simulation.reaction(*node)) : simulation.surface_force(surface);
  }
  [[nodiscard]] Vector3 position(const Simulation& simulation) const {
    return node ? simulation.position(*node) : simulation.surface_position(surface);
  }
  void move(Simulation& simulation, const Vector3& to, double time) const {
    if (node)
      simulation.move_node(*node, to, time);
    else
      simulation.move_surface(surface, to, time);
  }
};

constexpr int steps = 12;

// After `steps` steps in which the handle moves by `way`, in the last one by `further` more.
Simulation moved(const Network& net, const Handle& handle, const Vector3& way, const Vector3& further,
                 double force_tolerance = 1e-9) {
  Simulation simulation = simulate(net, recurrent(newton, force_tolerance), step);
  const Vector3 start = handle.position(simulation);
  for (int i = 1; i <= steps; ++i) {
    const Vector3 to = start + way * i / steps + (i == steps ? further : Vector3(Vector3::Zero()));
    handle.move(simulation, to, i * step);
    simulation.step();
  }
  return simulation;
}

// Central differences of the force by steps that end elsewhere.
Matrix by_differences(const Network& net, const Handle& handle, const Vector3& way, double distance) {
  Matrix result;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Vector3 further = distance * Vector3::Unit(axis);
    const Vector3 there = handle.force(moved(net, handle, way, further));
    const Vector3 back = handle.force(moved(net, handle, way, -further));
    result.col(axis) = -(there - back) / (2.0 * distance);
  }
  return result;
}

// The linear systems are solved to 1e-5. Less is left by differences over 1e-5 m in a net of 0.1 m, and of forces to
// 1e-9 N.
constexpr double distance = 1e-5, tolerance = 2e-5;
void check_against_steps(const Network& net, const Handle& handle, const Vector3& way, double allowed = tolerance) {
  Simulation simulation = moved(net, handle, way, Vector3::Zero());
  const LocalForce model = handle.model(simulation);
  CHECK(model.time == simulation.time());
  CHECK(model.position == handle.position(simulation));
  CHECK(model.force == handle.force(simulation));
  const Matrix expected = by_differences(net, handle, way, distance);
  CHECK(expected.norm() > 1.0);  // N/m
  CHECK((model.stiffness - expected).cwiseAbs().maxCoeff() <= allowed * expected.cwiseAbs().maxCoeff());
}

}  // namespace

TEST_CASE("local force model of two springs with a mass between them, by hand") {
  constexpr double k1 = 300, c1 = 2, k2 = 800, c2 = 0.5, m = 0.5;
  Simulation simulation = simulate(two_springs(k1, c1, k2, c2), recurrent(newton, 1e-9), step);
  simulation.step();
  for (const double over : {0.0, 1e-4, 1e-2, 1.0, 1e6}) {
    CAPTURE(over);
    const double h = over > 0.0 ? over : step;
    const double s1 = k1 + c1 / h, s2 = k2 + c2 / h;
    const LocalForce model = simulation.local_force(2, over);
    Matrix expected = Matrix::Zero();  // springs at rest have no stiffness across
    expected(0, 0) = s2 - s2 * s2 / (s1 + s2 + m / (h * h));
    CHECK((model.stiffness - expected).cwiseAbs().maxCoeff() <= 1e-7 * expected(0, 0));
    CHECK(model.force.norm() <= 1e-9);
    CHECK(model.at({2.001, 0, 0}).x() == doctest::Approx(-0.001 * expected(0, 0)).epsilon(1e-6));
  }
}

// The derivative of the viscous force changes within rates of millimetres a second, so the model must not take larger
// differences of the velocity, however short the time is.
TEST_CASE("local force model with a viscosity that is curved in the rate, over short times, by hand") {
  constexpr double stiffness = 50.0;
  for (const double exponent : {1.0, 1.2, 2.0}) {
    for (const double over : {5e-4, 5e-3, 0.5}) {
      INFO("exponent " << exponent << ", over " << over << " s");
      Network net;
      const MaterialIndex material = net.add_material(
          {LawUse{"linear", {{"stiffness", stiffness}}}, LawUse{"power", {{"damping", 1.0}, {"exponent", exponent}}}});
      const Vector3 ends[2] = {Vector3::Zero(), {1, 0, 0}}, middle(0.5, 0.8, 0.1);
      for (const Vector3& end : ends) net.fix(net.add_node(point(end)));
      net.add_node(point(middle, 1.0, {0.003, 0.001, 0}));
      for (const NodeIndex end : {0u, 1u}) net.add_spring(end, 2, material);
      Simulation s = simulate(net, recurrent(newton, 1e-12), 0.005);
      s.step();
      // dF/dx of each end over the step, with x' = x / over.
      Matrix by_end[2];
      for (int e = 0; e < 2; ++e) {
        const Vector3 d = ends[e] - s.position(2), dv = -s.velocity(2), n = d.normalized();
        const double length = d.norm(), rate = n.dot(dv);
        const double tension =
            stiffness * (length - (ends[e] - middle).norm()) + std::copysign(std::pow(std::abs(rate), exponent), rate);
        const double by_rate = exponent * std::pow(std::abs(rate), exponent - 1.0);
        const Matrix across = (Matrix::Identity() - n * n.transpose()) / length;
        by_end[e] = (stiffness + by_rate / over) * n * n.transpose() + tension * across +
                    by_rate * n * (across * dv).transpose();
      }
      const Matrix inertia = Matrix::Identity() / (over * over);
      const Matrix expected = by_end[0] - by_end[0] * (by_end[0] + by_end[1] + inertia).inverse() * by_end[0];
      // The linear system is solved to 1e-5.
      CHECK((s.local_force(0, over).stiffness - expected).norm() <= 2e-5 * expected.norm());
    }
  }
}

// A mass slides at a constant speed c, pushed by a spring against the friction f: across the slip friction turns with
// it, f / c per velocity.
TEST_CASE("local force model of a rough plane under a slow slip, turned too, by hand") {
  constexpr double friction = 3.0, h = 0.005, length = 2.0;  // N, s, m
  for (const double speed : {0.1, 0.01, 1e-3, 1e-4}) {
    for (const double turn : {0.0, 0.6}) {
      INFO("speed " << speed << " m/s, turned by " << turn);
      const Matrix q = Eigen::AngleAxisd(turn, Vector3::UnitZ()).toRotationMatrix();
      Network net;
      net.fix(net.add_node(point(q * Vector3(-length, 0, 0))));
      net.add_node(point(Vector3::Zero(), 1.0, q * Vector3(speed, 0, 0)));
      net.add_spring(0, 1, net.add_material(damped(1.0, 0.0)), length + friction);
      net.set_gravity({0, 0, -10});
      Plane plane;
      plane.friction = {Friction::Kind::coulomb, 0.1 * friction};
      net.add_plane(plane);
      Simulation s = simulate(net, recurrent(newton, 1e-10), h);
      s.step();
      const double damping = friction / s.velocity(1).norm(), tension = -friction / length;  // N s/m, N/m
      for (const double over : {h, 0.1 * h}) {
        const Matrix stiffness = q.transpose() * s.local_surface_force(0, over).stiffness * q;
        const double velocity = damping / (1.0 + damping * over + tension * over * over);  // of the mass, 1/s for 1 m
        const double across = damping * (1.0 / over - velocity);
        CHECK(stiffness(1, 1) == doctest::Approx(across).epsilon(1e-3));
        CHECK(std::abs(stiffness(0, 0)) <= 1e-3 * across);
        CHECK(std::abs(stiffness(0, 1)) <= 1e-3 * across);
        CHECK(std::abs(stiffness(1, 0)) <= 1e-3 * across);
      }
    }
  }
}

TEST_CASE("local force model of a grasped node: the differences of whole steps") {
  const NodeIndex middle = 48 + 5;  // of the upper side
  for (const bool elements : {false, true}) {
    CAPTURE(elements);
    Network net = soft_block(elements);
    net.fix(middle);
    check_against_steps(net, {.node = middle}, {0.02, 0.01, 0.04});
  }
  SUBCASE("on a rod, next to a plane on which others slide") {
    Network net = soft_block();
    net.add_rigid(middle, middle + 1);
    net.add_rigid(middle + 1, middle + 2);
    net.fix(middle);
    net.add_plane({.name = "roof", .point = {0, 0, 0.3}, .normal = {0, 0, -1}, .friction = {Friction::Kind::none}});
    // The rods turn by 1e-2 in a step; as above.
    check_against_steps(net, {.node = middle}, {0.02, 0.01, -0.01}, 1e-3);
  }
}

TEST_CASE("local force model of a surface that presses: the differences of whole steps") {
  struct Case {
    std::string name;
    Friction friction;
    Vector3 way;
    double on_plane, on_sphere;  // allowed errors
  };
  // The iteration for friction ends at 1e-4. On a sphere of 0.24 m the normals of nodes that slide turn by the slip in
  // a step, 4 mm and 5 mm at most here. The model takes changes of positions for the step times those of velocities,
  // which differ by such an angle.
  for (const Case& one : {Case{"held", {Friction::Kind::held}, {0.0005, 0.0, -0.03}, tolerance, tolerance},
                          Case{"sticking", {Friction::Kind::coulomb, 5.0}, {0.004, 0.0, -0.03}, tolerance, tolerance},
                          Case{"without friction", {Friction::Kind::none}, {0.0, 0.0, -0.03}, tolerance, 1e-4},
                          Case{"slipping", {Friction::Kind::coulomb, 0.2}, {0.06, 0.0, -0.02}, 5e-4, 5e-3}}) {
    for (const bool plane : {true, false}) {
      CAPTURE(one.name);
      CAPTURE(plane);
      Network net = soft_block();
      if (plane)
        net.add_plane({.name = "tool", .point = {0, 0, 0.305}, .normal = {0, 0, -1}, .friction = one.friction});
      else
        net.add_instrument({.name = "tool",
                            .first = {0.15, 0.15, 0.3 + 0.25},
                            .second = {0.15, 0.15, 0.3 + 0.25},
                            .radius = 0.24,
                            .friction = one.friction});
      const Handle handle{.surface = 0};
      Simulation simulation = moved(net, handle, one.way, Vector3::Zero());
      CHECK(simulation.nodes_touching(0) > 0);
      check_against_steps(net, handle, one.way, plane ? one.on_plane : one.on_sphere);
    }
  }
}

TEST_CASE("local force model of the end of a free bar: its mass") {
  // A free bar: all of it follows the handle, and resists by its mass alone where the time is long enough for waves.
  Network net = chain(5, {0, 0, 0}, {0.1, 0, 0}, damped(1e5, 0.0), 0.02);
  net.fix(0);
  Simulation simulation = simulate(net, recurrent(newton, 1e-9), 1.0);
  for (const double over : {0.1, 1.0, 10.0}) {
    CAPTURE(over);
    // Over a step, a mass resists a displacement by m / h^2.
    const Matrix stiffness = simulation.local_force(0, over).stiffness;
    CHECK(stiffness(0, 0) == doctest::Approx(4 * 0.02 / (over * over)).epsilon(1e-3));
    // Differences of 1e-5 of the springs' length leave 1e-10 of their stiffness.
    CHECK(std::abs(stiffness(1, 1)) <= 1e-10 * 1e5);
  }
}

TEST_CASE("local force models are symmetric, the same for every number of threads, and change nothing") {
  Network net = soft_block(true);
  net.add_instrument({.name = "tool",
                      .first = {0.15, 0.15, 0.55},
                      .second = {0.15, 0.15, 0.55},
                      .radius = 0.24,
                      .friction = {Friction::Kind::none}});
  const NodeIndex corner = 48;
  net.fix(corner);
  for (const LawUse& integrator : {recurrent(newton, 1e-9), cvode(1e-6), recurrent(automatic, 0.0)}) {
    INFO(integrator.id);
    std::array<Matrix, 2> node, surface;
    std::optional<Simulation> plain;
    for (const unsigned threads : {1u, 2u}) {
      SimulationOptions options{.time_step = step, .integrator = integrator, .threads = threads};
      Simulation simulation(net, plugins(), options);
      if (!plain) plain.emplace(net, plugins(), options);
      for (int i = 1; i <= 10; ++i) {
        for (Simulation* each : {&simulation, &*plain}) {
          if (each->time() >= i * step - 1e-9) continue;
          each->move_node(corner, {-0.002 * i, 0, 0.3}, i * step);
          each->move_surface(0, {0.15, 0.15, 0.55 - 0.002 * i}, i * step);
          each->step();
        }
        node[threads - 1] = simulation.local_force(corner).stiffness;
        surface[threads - 1] = simulation.local_surface_force(0).stiffness;
      }
      CHECK(simulation.nodes_touching(0) > 0);
      CHECK(simulation.positions() == plain->positions());
      CHECK(simulation.velocities() == plain->velocities());
    }
    CHECK(node[0] == node[1]);
    CHECK(surface[0] == surface[1]);
    // But for dampers, whose forces turn with their springs: 0.4 N s/m at 0.1 m/s over 0.1 m, of 800 N/m.
    CHECK((node[0] - node[0].transpose()).norm() <= 2e-3 * node[0].norm());
    CHECK((surface[0] - surface[0].transpose()).norm() <= 2e-3 * surface[0].norm());
    CHECK(Eigen::SelfAdjointEigenSolver<Matrix>(surface[0]).eigenvalues()[2] > 100.0);
  }
}

TEST_CASE("local force models of what is not held, of surfaces that nothing touches, and of bad times") {
  Network net = soft_block();
  net.add_plane({.name = "far", .point = {0, 0, 5}, .normal = {0, 0, -1}});
  Simulation simulation = simulate(net, recurrent(newton, 1e-9), step);
  simulation.step();
  CHECK_THROWS_WITH_AS(static_cast<void>(simulation.local_force(63)),
                       "node 63 is free: nothing holds it; set_fixed or move_node first", Error);
  CHECK_THROWS_AS(static_cast<void>(simulation.local_force(64)), Error);
  CHECK_THROWS_AS(static_cast<void>(simulation.local_surface_force(1)), Error);
  for (const double over : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    CHECK_THROWS_AS(static_cast<void>(simulation.local_force(0, over)), Error);
  const LocalForce far = simulation.local_surface_force(0);
  CHECK(far.force == Vector3::Zero());
  CHECK(far.stiffness == Matrix::Zero());
  CHECK(far.at({1, 2, 3}) == Vector3::Zero());
  // Springs are cut meanwhile.
  const Matrix before = simulation.local_force(0).stiffness;
  std::vector<SpringIndex> all(simulation.spring_count());
  for (SpringIndex s = 0; s < all.size(); ++s) all[s] = s;
  simulation.cut(all);
  CHECK(before.norm() > 100.0);
  CHECK(simulation.local_force(0).stiffness == Matrix::Zero());
}
