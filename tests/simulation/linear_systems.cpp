// Linear systems of small nets, solved by the host, against dense ones made of products with the derivatives.

#include <doctest/doctest.h>

#include "../elements/bodies.hpp"
#include "../layers/random_net.hpp"
#include "layers/linear/thinness.hpp"
#include "prepared_system.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double t = 0.05;              // s: weights t and t^2
constexpr double unreachable = 1e-300;  // accuracy

// Solves a system, and compares the solution with that of the dense one. The error allowed: a residual of `accuracy`,
// by the condition of the matrix.
void check_solution(PreparedSystem& system, double accuracy = 1e-10, double tolerance = 1e-7) {
  const Eigen::VectorXd b = system.right_side();
  REQUIRE(system.solve(b, accuracy) == SPRINGNET_OK);
  CHECK(system.answer.outcome == SPRINGNET_SOLVED);
  CHECK(system.answer.residual <= accuracy);
  const Eigen::VectorXd expected = system.reference(b);
  REQUIRE(expected.allFinite());
  CHECK((system.x - expected).norm() <= tolerance * expected.norm());
  for (std::size_t k = 0; k < system.node_count(); ++k)
    for (std::size_t c = 0; c < 3; ++c)
      if (system.constrained(k)) CHECK(system.x[static_cast<Eigen::Index>(c * system.node_count() + k)] == 0.0);
  const Eigen::MatrixXd g = system.rows();
  if (g.rows() > 0) CHECK((g * system.x).norm() <= 1e-12 * system.x.norm());
}

// |S - S^T| / |S| of the nodes that move.
double dense_asymmetry(PreparedSystem& system) {
  Eigen::MatrixXd s = system.masses().asDiagonal() * system.dense();
  const std::size_t n = system.node_count();
  for (std::size_t i = 0; i < 3 * n; ++i)
    if (system.constrained(i % n))
      s.row(static_cast<Eigen::Index>(i)).setZero(), s.col(static_cast<Eigen::Index>(i)).setZero();
  return (s - s.transpose()).norm() / s.norm();
}

// Of the matrix that the host has at hand.
double measured_asymmetry(PreparedSystem& system) {
  Model& model = system.engine.model();
  layers::BlockSystem blocks(model.layout, model.mass, model.contact.constrained(), 1);
  blocks.assemble(system.engine.linear().matrices(), system.weights);
  return blocks.asymmetry();
}

// A closed surface with springs and a filling of stiffness `bulk` about a point.
void add_filled(Network& net, const TriangleMesh& mesh, const Vector3& centre, double stiffness, double bulk) {
  const auto first = static_cast<NodeIndex>(net.nodes().size());
  for (const Vector3& p : mesh.points) net.add_node(point(p + centre, 0.01));
  const MaterialIndex skin = net.add_material(damped(stiffness, 0.0)), filling = net.add_material(damped(bulk, 0.0));
  for (const auto& [a, b] : sides(mesh)) net.add_spring(first + a, first + b, skin);
  std::vector<NodeIndex> triangles = mesh.triangles;
  for (NodeIndex& node : triangles) node += first;
  net.add_element(Invariant::enclosed_volume, triangles, filling);
}

Network sheet(std::uint32_t side, double stiffness, double mass, double spacing, double rest = 1.0) {
  Network net;
  const MaterialIndex cloth = net.add_material(damped(stiffness, 0.0));
  const auto at = [side](std::uint32_t i, std::uint32_t j) { return i + side * j; };
  for (std::uint32_t j = 0; j < side; ++j)
    for (std::uint32_t i = 0; i < side; ++i) net.add_node(point(spacing * Vector3(i, j, 0), mass));
  for (std::uint32_t j = 0; j < side; ++j)
    for (std::uint32_t i = 0; i < side; ++i) {
      if (i + 1 < side) net.add_spring(at(i, j), at(i + 1, j), cloth, rest * spacing);
      if (j + 1 < side) net.add_spring(at(i, j), at(i, j + 1), cloth, rest * spacing);
      if (i + 1 < side && j + 1 < side)
        net.add_spring(at(i, j), at(i + 1, j + 1), cloth, rest * spacing * std::sqrt(2.0));
    }
  return net;
}

}  // namespace

TEST_CASE("springs with every kind of viscosity, and two kinds of neurons, are solved") {
  for (const std::uint32_t nodes : {2u, 3u, 25u, 90u}) {
    CAPTURE(nodes);
    Network net = random_network(nodes, 4, 21);
    if (nodes > 20) {
      net.fix(3);
      net.fix(17);
    }
    PreparedSystem system(net);
    REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
    check_solution(system);
    CHECK(measured_asymmetry(system) == doctest::Approx(dense_asymmetry(system)).epsilon(1e-9));
    if (nodes > 3) CHECK(measured_asymmetry(system) > 1e-4);
    REQUIRE(system.prepare(t, t * t, 3.0) == SPRINGNET_OK);  // with a shift
    check_solution(system);
    REQUIRE(system.prepare(0.0, 0.0) == SPRINGNET_OK);  // the identity
    check_solution(system);
    CHECK(system.answer.iterations <= 1);
  }
}

TEST_CASE("elements of every kind are solved, and their asymmetry is that of the matrix") {
  for (const unsigned seed : {1u, 2u, 3u}) {
    for (const bool damped_too : {false, true}) {
      Network net = all_kinds(seed, damped_too);
      net.fix(2);
      net.fix(20);
      PreparedSystem system(net);
      REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
      check_solution(system);
      if (!damped_too) CHECK(measured_asymmetry(system) <= 1e-13);
      // What enclosures and the rest have in common is left out of the norms.
      CHECK(measured_asymmetry(system) == doctest::Approx(dense_asymmetry(system)).epsilon(0.2));
    }
  }
}

TEST_CASE("nets of one node, without springs, and with every node fixed are solved") {
  Network one;
  one.add_node(point({0, 0, 0}, 2.0));
  PreparedSystem single(one);
  REQUIRE(single.prepare(t, t * t, 1.0) == SPRINGNET_OK);
  check_solution(single);
  Network fixed = random_network(10, 3, 2);
  for (NodeIndex k = 0; k < 10; ++k) fixed.fix(k);
  PreparedSystem still(fixed);
  REQUIRE(still.prepare(t, t * t) == SPRINGNET_OK);
  REQUIRE(still.solve(still.right_side(), 1e-6) == SPRINGNET_OK);
  CHECK(still.answer.outcome == SPRINGNET_SOLVED);
  CHECK(still.x.norm() == 0.0);
}

TEST_CASE("iterations do not grow with the stiffness of a filling") {
  std::uint64_t softest = 0;
  for (const double bulk : {1.0, 1e2, 1e4, 1e6}) {
    CAPTURE(bulk);
    const TriangleMesh mesh = icosphere(2, 1.0);
    Network net;
    add_filled(net, mesh, {0, 0, 0}, 10.0, bulk);
    add_filled(net, mesh, {3, 0, 0}, 10.0, 3.0 * bulk);
    for (int c = 0; c < 20; ++c) net.add_spring(static_cast<NodeIndex>(c), static_cast<NodeIndex>(c + 162), 0);
    net.fix(0);
    PreparedSystem system(net);
    REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
    REQUIRE(system.solve(system.right_side(), 1e-6) == SPRINGNET_OK);
    CHECK(system.answer.outcome == SPRINGNET_SOLVED);
    CHECK(system.residual_of(system.right_side(), system.x) <= 1e-5);
    if (softest == 0) softest = system.answer.iterations;
    CHECK(system.answer.iterations > 0);
    CHECK(system.answer.iterations <= softest + softest / 2);
  }
}

TEST_CASE("enclosures that share nodes are solved") {
  const TriangleMesh mesh = icosphere(0, 1.0);
  Network net = filled(mesh, 0.1, 20.0, 3e4, 0.0);
  net.add_element(Invariant::enclosed_volume, mesh.triangles, net.add_material(damped(1e5, 2.0)));
  // Half of a tetrahedron's corners are the surface's.
  net.add_node(point({2, 0, 0}, 0.1));
  net.add_node(point({2, 1, 0}, 0.1));
  net.add_element(Invariant::enclosed_volume, {0, 12, 11, 0, 11, 13, 11, 12, 13, 12, 0, 13},
                  net.add_material(damped(2e4, 0.0)));
  PreparedSystem system(net, 1, InstructionSet::best, 0.02);
  REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
  check_solution(system, 1e-10, 1e-6);
}

TEST_CASE("rigid connections bind the solution, by the iteration and by factorisation") {
  for (const bool with_fillings : {false, true}) {
    Network net = random_network(40, 4, 8);
    for (const auto& [a, b] : {std::pair(0u, 1u), std::pair(1u, 2u), std::pair(5u, 9u), std::pair(12u, 30u)})
      net.add_rigid(a, b);
    net.fix(9);
    if (with_fillings) {
      const TriangleMesh mesh = icosphere(0, 1.0);
      add_filled(net, mesh, {3, 0, 0}, 10.0, 1e5);
      net.add_rigid(40, 41);
      net.add_rigid(3, 45);
    }
    PreparedSystem system(net);
    for (NodeIndex k = 0; k < 40; ++k)  // velocities that the connections allow
      for (auto& component : system.v) component[k] = 0.0;
    REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
    REQUIRE(system.rows().rows() >= 4);
    check_solution(system);
  }
}

TEST_CASE("nodes that slide stay on their surface, nodes that stick do not move") {
  for (const Friction::Kind kind : {Friction::Kind::none, Friction::Kind::held, Friction::Kind::coulomb}) {
    Network net;
    Lattice lattice;
    lattice.nodes = {3, 3, 3};
    lattice.diagonals = Diagonals::all;
    net.add_lattice("cube", lattice, Node{}, net.add_material(damped(100.0, 2.0)));
    net.set_gravity({0.3, 0, -9.81});
    Plane floor;
    floor.normal = {0, 0, 1};
    floor.friction = {kind, 0.5};
    net.add_plane(floor);
    PreparedSystem system(net);
    REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
    CHECK(system.rows().rows() == (kind == Friction::Kind::none ? 9 : 0));
    check_solution(system);
  }
}

TEST_CASE("a factorisation takes over where the iteration gives up, and answers among allowed changes") {
  Network net = sheet(15, 1e8, 1e-3, 0.1);
  for (const bool rods : {false, true}) {
    CAPTURE(rods);
    if (rods) {
      net.add_rigid(10, 12);
      net.add_rigid(40, 71);
    }
    PreparedSystem system(net, 1, InstructionSet::best, rods ? 0.0 : 1e-4);
    REQUIRE(system.prepare(t, t * t, 0.5) == SPRINGNET_OK);
    for (const unsigned seed : {1u, 2u}) {
      const Eigen::VectorXd b = system.right_side(seed);
      REQUIRE(system.solve(b, unreachable) == SPRINGNET_OK);
      CHECK(system.answer.outcome == SPRINGNET_SOLVED);
      CHECK(system.answer.iterations == 0);
      const Eigen::VectorXd expected = system.reference(b);
      CHECK((system.x - expected).norm() <= 1e-6 * expected.norm());
      if (rods) CHECK((system.rows() * system.x).norm() <= 1e-9 * system.x.norm());
    }
  }
}

TEST_CASE("accuracy is reached in the norm that it is stated in") {
  for (const double accuracy : {1e-1, 1e-2, 1e-4, 1e-8}) {
    CAPTURE(accuracy);
    // Masses over six decades; viscosities that make the matrix anything but symmetric, and none.
    for (const bool symmetric : {false, true}) {
      CAPTURE(symmetric);
      Network net = symmetric ? sheet(14, 1e3, 0.01, 0.1) : random_network(150, 4, 33);
      for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
        Node node = net.nodes()[k];
        node.mass *= std::pow(10.0, static_cast<double>(k % 7) - 3.0);
        net.set_node(k, node);
      }
      PreparedSystem system(net);
      REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
      const Eigen::VectorXd b = system.right_side();
      REQUIRE(system.solve(b, accuracy) == SPRINGNET_OK);
      REQUIRE(system.answer.outcome == SPRINGNET_SOLVED);
      CHECK(system.answer.residual <= accuracy);
      CHECK(system.residual_of(b, system.x) <= 1.01 * accuracy);
    }
  }
}

TEST_CASE("a compressed sheet is solved though its matrix is indefinite") {
  PreparedSystem system(sheet(9, 1e3, 0.01, 0.1, 1.3), 1, InstructionSet::best, 1e-3);
  REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
  const Eigen::MatrixXd s = system.masses().asDiagonal() * system.dense();
  REQUIRE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(s).eigenvalues()[0] < 0.0);
  const Eigen::VectorXd b = system.right_side();
  REQUIRE(system.solve(b, 1e-6) == SPRINGNET_OK);
  REQUIRE(system.answer.outcome == SPRINGNET_SOLVED);
  CHECK(system.residual_of(b, system.x) <= 1e-4);
  // Enough of a shift makes it definite.
  REQUIRE(system.prepare(t, t * t, 1000.0) == SPRINGNET_OK);
  check_solution(system);
}

TEST_CASE("an incomplete factorisation in several pieces solves a long surface") {
  Network net = sheet(70, 1e3, 0.01, 0.1, 0.9);  // 4900 nodes, under tension
  net.fix(0);
  net.fix(69);
  PreparedSystem system(net, 1, InstructionSet::best, 1e-3);
  REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
  const Eigen::VectorXd b = system.right_side();
  REQUIRE(system.solve(b, 1e-8) == SPRINGNET_OK);
  REQUIRE(system.answer.outcome == SPRINGNET_SOLVED);
  CHECK(system.residual_of(b, system.x) <= 1.01e-8);
}

TEST_CASE("a prepared system survives later derivatives and factorisations, and they survive it") {
  Network net = random_network(30, 4, 4);
  PreparedSystem system(net);
  const Eigen::VectorXd b = system.right_side();
  REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
  REQUIRE(system.solve(b, 1e-12) == SPRINGNET_OK);
  const Eigen::VectorXd before = system.x;
  PreparedSystem other(net, 1, InstructionSet::best, 0.3);
  springnet_evaluation elsewhere = other.evaluation();
  REQUIRE(system.linearise(elsewhere) == SPRINGNET_OK);
  REQUIRE(system.factorise(3.0 * t, t) == SPRINGNET_OK);
  REQUIRE(system.solve(b, 1e-12) == SPRINGNET_OK);
  CHECK(system.x == before);
  // With the derivatives at hand: those of `elsewhere`.
  REQUIRE(system.prepare(t, t * t, 0.0, true, false) == SPRINGNET_OK);
  check_solution(system);
  CHECK((system.x - before).norm() > 1e-3 * before.norm());
}

TEST_CASE("a factorisation of the host's and one of the integrator's do not meet") {
  PreparedSystem system(sheet(12, 1e5, 1e-2, 0.1), 1, InstructionSet::best, 1e-4);
  const Eigen::VectorXd b = system.right_side();
  Eigen::VectorXd own = b, again = b, first;
  REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
  REQUIRE(system.factorise(0.5 * t, 0.1 * t * t) == SPRINGNET_OK);
  REQUIRE(system.solve_factorised(b.data(), own.data()) == SPRINGNET_OK);
  REQUIRE(system.solve(b, unreachable) == SPRINGNET_OK);
  REQUIRE(system.answer.iterations == 0);
  first = system.x;
  REQUIRE(system.solve_factorised(b.data(), again.data()) == SPRINGNET_OK);
  CHECK(own == again);
  REQUIRE(system.factorise(0.2 * t, 0.3 * t * t) == SPRINGNET_OK);
  REQUIRE(system.solve(b, unreachable) == SPRINGNET_OK);
  CHECK(system.x == first);
}

TEST_CASE("the right-hand side may be the solution's array, and is not read where nodes are fixed") {
  Network net = random_network(20, 4, 5);
  net.fix(4);
  PreparedSystem system(net);
  REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
  Eigen::VectorXd b = system.right_side();
  const std::uint32_t fixed = system.engine.model().layout.ordering().engine[4];
  for (Eigen::Index c = 0; c < 3; ++c) b[20 * c + fixed] = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(system.solve(b, 1e-9) == SPRINGNET_OK);
  REQUIRE(system.answer.outcome == SPRINGNET_SOLVED);
  const Eigen::VectorXd expected = system.x;
  system.answer.right_side = system.answer.x = b.data();
  REQUIRE(system.table.solve_system(system.table.context, &system.answer) == SPRINGNET_OK);
  CHECK(b == expected);
}

TEST_CASE("wrong requests are refused, and numbers that are not finite are no solution") {
  PreparedSystem system(random_network(12, 3, 6));
  const Eigen::VectorXd b = system.right_side();
  CHECK(system.solve(b, 1e-3) == SPRINGNET_FAILED);
  CHECK(system.message().find("without a prepared system") != std::string::npos);
  CHECK(system.prepare(t, t * t, 0.0, true, false) == SPRINGNET_FAILED);  // no derivatives yet
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  CHECK(system.prepare(nan, t * t) == SPRINGNET_FAILED);
  CHECK(system.prepare(t, infinity) == SPRINGNET_FAILED);
  for (const double shift : {-1.0, nan, infinity}) CHECK(system.prepare(t, t * t, shift) == SPRINGNET_FAILED);
  REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
  for (const double accuracy : {0.0, -1.0, nan}) CHECK(system.solve(b, accuracy) == SPRINGNET_FAILED);
  for (const double value : {nan, infinity, 1e300}) {
    Eigen::VectorXd wrong = b;
    wrong[7] = value;
    const springnet_status status = system.solve(wrong, 1e-3);
    if (status == SPRINGNET_OK) CHECK((system.answer.outcome != SPRINGNET_SOLVED || system.x.allFinite()));
  }
  CHECK(system.solve(Eigen::VectorXd::Zero(b.size()), 1e-3) == SPRINGNET_OK);
  CHECK(system.answer.outcome == SPRINGNET_SOLVED);
  CHECK(system.x.norm() == 0.0);
  system.p[0][3] = nan;
  CHECK(system.prepare(t, t * t) != SPRINGNET_OK);
  CHECK(system.solve(b, 1e-3) == SPRINGNET_FAILED);  // nothing is prepared
}

TEST_CASE("after springs and elements are cut a system has to be prepared anew, and lacks them") {
  Network net = all_kinds(9);
  PreparedSystem system(net);
  REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
  check_solution(system);
  const Eigen::VectorXd whole = system.x;
  for (const std::vector<std::uint32_t>& cut : {std::vector<std::uint32_t>{0, 3, 7}, {5, 6, 11, 12, 13}}) {
    REQUIRE(system.engine.topology().cut(cut) == cut.size());
    CHECK(system.solve(system.right_side(), 1e-3) == SPRINGNET_FAILED);
    CHECK(system.prepare(t, t * t, 0.0, true, false) == SPRINGNET_FAILED);
    REQUIRE(system.prepare(t, t * t) == SPRINGNET_OK);
    check_solution(system);
    CHECK((system.x - whole).norm() > 1e-6 * whole.norm());
  }
}

TEST_CASE("nets of several parts are taken for thin where most of their nodes are") {
  // A lone node comes first.
  Network net;
  net.add_node(point({-5, 0, 0}));
  const MaterialIndex cloth = net.add_material(damped(10.0, 0.0));
  for (NodeIndex k = 1; k < 700; ++k) {
    net.add_node(point({0.1 * k, 0, 0}));
    if (k > 1) net.add_spring(k - 1, k, cloth);
  }
  PreparedSystem system(net);
  CHECK(layers::is_thin(system.engine.model().layout));
  Lattice lattice;
  lattice.nodes = {9, 9, 9};
  lattice.diagonals = Diagonals::all;
  net.add_lattice("block", lattice, Node{}, cloth);
  PreparedSystem solid(net);
  CHECK_FALSE(layers::is_thin(solid.engine.model().layout));
  REQUIRE(solid.prepare(t, t * t) == SPRINGNET_OK);
  const Eigen::VectorXd b = solid.right_side();
  REQUIRE(solid.solve(b, 1e-9) == SPRINGNET_OK);
  CHECK(solid.residual_of(b, solid.x) <= 1.01e-9);
}
