// Forces and derivatives of loads on faces, in the layers.
#include <cmath>

#include <doctest/doctest.h>

#include "../layers/random_net.hpp"
#include "layers/linear/linearisation.hpp"
#include "loaded.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Without steps: the forces at the start.
std::vector<Vector3> forces_at_start(const Network& net) {
  const Simulation simulation = simulate(net, recurrent(newton, 1e-9), 0.1);
  std::vector<Vector3> forces;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) forces.push_back(simulation.force(k));
  return forces;
}

Vector3 sum_of(const std::vector<Vector3>& forces) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& force : forces) sum += force;
  return sum;
}
Vector3 torque_of(const std::vector<Vector3>& forces, const std::vector<Vector3>& points) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 0; k < forces.size(); ++k) sum += points[k].cross(forces[k]);
  return sum;
}

Network points_of(const TriangleMesh& mesh) {
  Network net;
  for (const Vector3& p : mesh.points) net.add_node(point(p));
  return net;
}

// A random net with springs and elements; its closed surface and an open patch of it under different pressures.
Network pressed_net() {
  Network net = all_kinds(5);
  std::vector<Face> faces = faces_of(icosphere(0, 1.0));
  for (Face& face : faces)
    for (NodeIndex& node : face) node += 14;
  net.add_load(pressed(faces, 1.7, true));
  net.add_load(pressed({faces[0], faces[1], faces[7]}, -2.3, true));
  net.add_load(pressed({{0, 1, 2}, {2, 1, 3}}, 4.0, true));
  return net;
}

}  // namespace

TEST_CASE("a triangle has a third of its load on each node") {
  Network net;
  for (const Vector3& p : {Vector3(0, 0, 1), Vector3(3, 0, 1), Vector3(0, 2, 1)}) net.add_node(point(p));
  for (const bool follow : {false, true}) {
    Network pressed_one = net;
    pressed_one.add_load(pressed({{0, 1, 2}}, 5.0, follow));
    for (const Vector3& force : forces_at_start(pressed_one))
      CHECK((force - Vector3(0, 0, -5)).norm() <= 1e-14);  // 3 m^2
  }
  Load load;
  load.faces = {{0, 1, 2}};
  load.traction = {1, -2, 4};
  net.add_load(load);
  for (const Vector3& force : forces_at_start(net)) CHECK((force - Vector3(1, -2, 4)).norm() <= 1e-14);
}

TEST_CASE("a traction sums to traction times area, a pressure on a closed surface to zero") {
  const TriangleMesh mesh = crumpled(2, 3);
  const std::vector<Face> faces = faces_of(mesh);
  const Network net = points_of(mesh);
  double area = 0.0;
  for (const Face& face : faces) area += net.area_of(face).norm();
  Network pulled = net;
  Load load;
  load.faces = faces;
  load.traction = {10, 20, -5};
  pulled.add_load(load);
  CHECK((sum_of(forces_at_start(pulled)) - area * load.traction).norm() <= 1e-13 * area * load.traction.norm());
  for (const bool follow : {false, true}) {
    Network inflated = net;
    inflated.add_load(pressed(faces, -100.0, follow));
    const std::vector<Vector3> forces = forces_at_start(inflated);
    const std::vector<Vector3> plain = plain_pressure(faces, mesh.points, -100.0);
    for (std::size_t k = 0; k < forces.size(); ++k) CHECK((forces[k] - plain[k]).norm() <= 1e-11);
    CHECK(sum_of(forces).norm() <= 1e-13 * 100.0 * area);  // rounding of 320 faces
    CHECK(torque_of(forces, mesh.points).norm() <= 1e-13 * 100.0 * area);
  }
}

TEST_CASE("a following pressure on a closed surface equals an enclosed volume with the negative force") {
  const TriangleMesh mesh = crumpled(2, 7);
  Network filling = points_of(mesh), gas = filling;
  const ElementIndex e =
      filling.add_element(Invariant::enclosed_volume, mesh.triangles, filling.add_material(damped(30.0, 0.0)), 1.0);
  const double q = simulate(filling, recurrent(newton, 1e-9), 0.1).element_force(e);
  CHECK(q > 1.0);
  gas.add_load(pressed(faces_of(mesh), q, true));
  const std::vector<Vector3> a = forces_at_start(filling), b = forces_at_start(gas);
  for (std::size_t k = 0; k < a.size(); ++k) CHECK((a[k] - b[k]).norm() <= 1e-14 * q);
}

TEST_CASE("forces turn with the scene; a mirrored scene has mirrored forces") {
  const TriangleMesh mesh = crumpled(1, 11);
  std::vector<Face> faces = faces_of(mesh);
  faces.resize(30);  // open
  for (const bool follow : {false, true}) {
    Network net = points_of(mesh);
    Load load = pressed(faces, 3.0, follow);
    load.traction = {1, 2, 3};
    net.add_load(load);
    const std::vector<Vector3> forces = forces_at_start(net);
    const Eigen::Matrix3d turn(Eigen::AngleAxisd(1.1, Vector3(1, 2, -1).normalized()));
    const Eigen::Matrix3d mirror = Vector3(1, 1, -1).asDiagonal();
    for (const Eigen::Matrix3d& map : {turn, Eigen::Matrix3d(turn * mirror)}) {
      Network mapped;
      for (const Vector3& p : mesh.points) mapped.add_node(point(map * p + Vector3(5, 6, 7)));
      Load other = load;
      other.areas.clear();
      other.traction = map * load.traction;
      if (map.determinant() < 0)
        for (Face& face : other.faces) std::swap(face[1], face[2]);
      mapped.add_load(other);
      const std::vector<Vector3> found = forces_at_start(mapped);
      for (std::size_t k = 0; k < forces.size(); ++k) CHECK((found[k] - map * forces[k]).norm() <= 1e-13);
    }
  }
}

TEST_CASE("a pressure on the start areas keeps its direction, one that follows turns") {
  const TriangleMesh mesh = crumpled(0, 2);
  const std::vector<Face> faces = faces_of(mesh);
  Network net = points_of(mesh);
  net.add_load(pressed(faces, 2.0, false));
  net.add_load(pressed(faces, -2.0, true));
  Simulation simulation = simulate(net, recurrent(newton, 1e-9), 0.1);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) CHECK(simulation.force(k).norm() <= 1e-14);
  const Eigen::Matrix3d turn(Eigen::AngleAxisd(0.5 * std::acos(-1.0), Vector3::UnitZ()));
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) simulation.set_position(k, 2.0 * (turn * mesh.points[k]));
  const std::vector<Vector3> before = plain_pressure(faces, mesh.points, 2.0);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k)
    CHECK((simulation.force(k) - (before[k] - 4.0 * (turn * before[k]))).norm() <= 1e-13);
}

TEST_CASE("derivatives of following pressures are those of the forces, in the whole net and in a node by itself") {
  const Network net = pressed_net();
  EvaluatorFixture fixture(net);
  const std::vector<double> pressures{1.7, -2.3, 4.0};
  fixture.external.pressure = pressures.data();
  const std::uint32_t n = fixture.layout.node_count();
  const auto size = static_cast<Eigen::Index>(3 * n);
  std::vector<std::uint8_t> constrained(n, 0);
  constrained[3] = 1;
  layers::Linearisation linearisation(fixture.layout, *fixture.evaluator, constrained);
  springnet_message message{};
  REQUIRE(linearisation.update(0.0, fixture.nodes(), fixture.external, message) == SPRINGNET_OK);
  Eigen::MatrixXd by_p(size, size), by_v(size, size);
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(size, j);
    linearisation.times(unit.data(), zero.data(), by_p.col(j).data());
    linearisation.times(zero.data(), unit.data(), by_v.col(j).data());
  }
  const auto accelerations = [&] {
    fixture.evaluate();
    Eigen::VectorXd a(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const auto k = static_cast<std::size_t>(i % n);
      a[i] = constrained[k] != 0 ? 0.0 : fixture.f[i / n][k] / fixture.mass[k];
    }
    return a;
  };
  for (Eigen::Index j = 0; j < size; ++j) {
    double& coordinate = fixture.p[j / n][static_cast<std::size_t>(j % n)];
    const double value = coordinate;
    const auto at = [&](double h) {
      coordinate = value + h;
      Eigen::VectorXd a = accelerations();
      coordinate = value;
      return a;
    };
    constexpr double h = 4e-4;
    const Eigen::VectorXd difference =
        (45.0 * (at(h) - at(-h)) - 9.0 * (at(2 * h) - at(-2 * h)) + (at(3 * h) - at(-3 * h))) / (60.0 * h);
    // As with elements: far below 1e-6.
    CHECK((difference - by_p.col(j)).cwiseAbs().maxCoeff() <= 1e-6 * (1.0 + by_p.col(j).cwiseAbs().maxCoeff()));
  }

  const double wv = 0.05, wp = 0.0025;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(size, size) - wv * by_v - wp * by_p;
  const Eigen::VectorXd right_side = Eigen::VectorXd::LinSpaced(size, -1.0, 2.0);
  Eigen::VectorXd x(size);
  REQUIRE(linearisation.factorise(wv, wp, {}, message) == SPRINGNET_OK);
  REQUIRE(linearisation.solve(false, right_side.data(), x.data(), message) == SPRINGNET_OK);
  CHECK((dense * x - right_side).norm() <= 1e-10 * right_side.norm());
  REQUIRE(linearisation.solve(true, right_side.data(), x.data(), message) == SPRINGNET_OK);
  CHECK((dense.transpose() * x - right_side).norm() <= 1e-10 * right_side.norm());

  fixture.evaluate();
  std::vector<double> blocks(9 * std::size_t{n});
  linearisation.diagonal_blocks(wv, wp, blocks.data());
  for (std::uint32_t k = 0; k < n; ++k) {
    Vector3 force, acceleration;
    layers::NodeDerivatives own;
    double energy = 0.0;
    REQUIRE(fixture.evaluator->evaluate_node(k, 0.0, fixture.nodes(), fixture.external, nullptr, force, acceleration,
                                             &own, &energy, message) == SPRINGNET_OK);
    CHECK((force - Vector3(fixture.f[0][k], fixture.f[1][k], fixture.f[2][k])).norm() <= 1e-12 * (1.0 + force.norm()));
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto row = static_cast<Eigen::Index>(r * n + k), column = static_cast<Eigen::Index>(c * n + k);
        CHECK(blocks[9 * k + 3 * r + c] == doctest::Approx(dense(row, column)).epsilon(1e-11));
        if (constrained[k] == 0) {
          CHECK(own.by_position[3 * r + c] == doctest::Approx(by_p(row, column)).epsilon(1e-10).scale(10.0));
        }
      }
  }
}

TEST_CASE("the Jacobian of a following pressure is symmetric on a closed surface, and not on an open one") {
  const TriangleMesh mesh = crumpled(1, 4);
  for (const bool open : {false, true}) {
    std::vector<Face> faces = faces_of(mesh);
    if (open) faces.pop_back();
    Network net = points_of(mesh);
    net.add_load(pressed(faces, 2.0, true));
    EvaluatorFixture fixture(net);
    const double pressure = 2.0;
    fixture.external.pressure = &pressure;
    const std::vector<std::uint8_t> constrained(net.nodes().size(), 0);
    layers::Linearisation linearisation(fixture.layout, *fixture.evaluator, constrained);
    springnet_message message{};
    REQUIRE(linearisation.update(0.0, fixture.nodes(), fixture.external, message) == SPRINGNET_OK);
    const auto size = static_cast<Eigen::Index>(3 * net.nodes().size());
    Eigen::MatrixXd by_p(size, size);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(size);
    for (Eigen::Index j = 0; j < size; ++j) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(size, j);
      linearisation.times(unit.data(), zero.data(), by_p.col(j).data());
    }
    const double skew = (by_p - by_p.transpose()).cwiseAbs().maxCoeff();
    CHECK((open ? skew > 0.1 : skew <= 1e-14));
    // Whether a node by itself has a potential.
    std::size_t without = 0;
    for (std::uint32_t k = 0; k < net.nodes().size(); ++k) {
      Vector3 force, acceleration;
      double energy = 0.0;
      REQUIRE(fixture.evaluator->evaluate_node(k, 0.0, fixture.nodes(), fixture.external, nullptr, force, acceleration,
                                               nullptr, &energy, message) == SPRINGNET_OK);
      if (std::isnan(energy)) ++without;
    }
    CHECK(without == (open ? 3 : 0));
  }
}
