// Linear systems of nets so large that they are solved without a matrix, or by several threads.

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "../elements/bodies.hpp"
#include "layers/instruction_set.hpp"
#include "prepared_system.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double t = 0.02;  // s: weights t and t^2

// One face fixed; `side` nodes a side.
Network lattice(std::uint32_t side, double stiffness, double damping, const LawUse* neuron = nullptr) {
  Network net;
  Lattice shape;
  shape.nodes = {side, side, side};
  shape.spacing = Vector3::Constant(0.1);
  shape.diagonals = Diagonals::all;
  Node prototype;
  prototype.mass = 1.0;
  if (neuron != nullptr) prototype.neuron = net.add_neuron(*neuron);
  net.add_lattice("block", shape, prototype, net.add_material(damped(stiffness, damping)));
  for (NodeIndex k = 0; k < side * side; ++k) net.fix(k);
  return net;
}

void set_masses(Network& net, double decades) {
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    node.mass = std::pow(10.0, decades * (static_cast<double>((7919 * k) % 101) / 100.0 - 0.5));
    net.set_node(k, node);
  }
}

void give_velocities(PreparedSystem& system, double speed) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(-speed, speed);
  for (auto& component : system.v)
    for (std::size_t k = 0; k < system.node_count(); ++k)
      if (!system.constrained(k)) component[k] = unit(random);
}

// Through the lattice's face x = 0, whose nodes are fixed along one of its edges.
Plane wall(const Friction& friction) {
  Plane result;
  result.name = "wall";
  result.normal = {1, 0, 0};
  result.friction = friction;
  return result;
}

// A lattice that slides along a wall, or along the edge of two.
Network sliding_lattice(const Friction& friction, bool on_edge) {
  Network net = lattice(13, 2e4, 1.0);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    if (!node.fixed) node.velocity = {0.0, 0.3, on_edge ? 0.0 : 0.1 + 1e-3 * (k % 7)};
    net.set_node(k, node);
  }
  net.add_plane(wall(friction));
  if (on_edge) {
    Plane other = wall(friction);
    other.name = "other";
    other.point = {0, 0, 1.2};
    other.normal = {0, 0, -1};
    net.add_plane(other);
  }
  net.set_gravity({-9.81, 0, on_edge ? 3.0 : 0.0});
  return net;
}

// Solves without a matrix, and compares with the products of the exact derivatives at the same state. `left_out`: what
// is not symmetric, and single precision, relative to the right-hand side.
void check_matrix_free(PreparedSystem& system, double shift, double accuracy, double left_out) {
  const Eigen::VectorXd b = system.right_side();
  REQUIRE(system.prepare(t, t * t, shift, false) == SPRINGNET_OK);
  CHECK_FALSE(system.engine.linear().known());  // no derivatives were computed: it is without a matrix
  REQUIRE(system.solve(b, accuracy) == SPRINGNET_OK);
  REQUIRE(system.answer.outcome == SPRINGNET_SOLVED);
  CHECK(system.answer.residual <= accuracy);
  CHECK(system.answer.iterations > 0);
  const springnet_evaluation at = system.evaluation();
  REQUIRE(system.linearise(at) == SPRINGNET_OK);
  CHECK(system.residual_of(b, system.x) <= accuracy + left_out);
  const std::size_t n = system.node_count();
  for (std::size_t i = 0; i < 3 * n; ++i)
    if (system.constrained(i % n)) REQUIRE(system.x[static_cast<Eigen::Index>(i)] == 0.0);
}

bool available(InstructionSet set) {
  try {
    return layers::choose_instruction_set(set) == set;
  } catch (const Error&) {
    return false;
  }
}

// The solution's bits for 1 to 4 threads and every available instruction set.
void check_same_bits(const Network& net, bool exact, double stir, double accuracy) {
  Eigen::VectorXd first;
  std::uint64_t iterations = 0;
  for (const InstructionSet set : {InstructionSet::generic, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!available(set)) continue;
    for (const unsigned threads : {1u, 2u, 3u, 4u, 13u}) {
      if (set != InstructionSet::generic && threads > 2) continue;
      CAPTURE(threads);
      CAPTURE(static_cast<int>(set));
      PreparedSystem system(net, threads, set, stir);
      REQUIRE(system.prepare(t, t * t, 0.0, exact) == SPRINGNET_OK);
      REQUIRE(system.solve(system.right_side(), accuracy) == SPRINGNET_OK);
      CHECK(system.answer.outcome == SPRINGNET_SOLVED);
      if (first.size() == 0) {
        first = system.x;
        iterations = system.answer.iterations;
        CHECK(iterations > 1);
      }
      CHECK(system.x == first);
      CHECK(system.answer.iterations == iterations);
    }
  }
}

}  // namespace

TEST_CASE("a large lattice is solved without a matrix") {
  const Network net = lattice(14, 2e4, 1.0);
  struct Case {
    double shift, accuracy, speed, left_out;
  };
  for (const auto& [shift, accuracy, speed, left_out] : {Case{0.0, 1e-3, 0.0, 1e-6}, Case{0.0, 1e-7, 0.0, 1e-6},
                                                         Case{5.0, 1e-7, 0.0, 1e-6}, Case{0.0, 1e-7, 0.01, 1e-2}}) {
    CAPTURE(shift);
    CAPTURE(accuracy);
    CAPTURE(speed);
    PreparedSystem system(net, 1, InstructionSet::best, 1e-3);
    if (speed > 0.0) give_velocities(system, speed);
    check_matrix_free(system, shift, accuracy, left_out);
  }
}

// What is solved is x = w da/dv x + w^2 da/dp x + b, with the accelerations of the constrained motion, whose normal
// reactions and friction follow the change.
TEST_CASE("nodes that slide, with friction and without, are solved without a matrix") {
  for (const double coefficient : {0.0, 0.3, 0.9})
    for (const bool on_edge : {false, true})
      for (const double accuracy : {1e-3, 1e-6}) {
        CAPTURE(coefficient);
        CAPTURE(on_edge);
        CAPTURE(accuracy);
        const Friction friction{coefficient > 0.0 ? Friction::Kind::coulomb : Friction::Kind::none, coefficient};
        PreparedSystem system(sliding_lattice(friction, on_edge));
        REQUIRE(system.prepare(t, t * t, 0.0, false) == SPRINGNET_OK);
        CHECK_FALSE(system.engine.linear().known());
        Eigen::VectorXd b = system.right_side();
        system.engine.linear().project_accelerations(false, b.data());
        REQUIRE(system.solve(b, accuracy) == SPRINGNET_OK);
        REQUIRE(system.answer.outcome == SPRINGNET_SOLVED);
        CHECK_FALSE(system.engine.linear().known());
        REQUIRE(system.linearise(system.evaluation()) == SPRINGNET_OK);
        REQUIRE(system.engine.model().constraints.rows().size() >= 100);
        const Eigen::VectorXd dp = t * t * system.x, dv = t * system.x;
        Eigen::VectorXd change(b.size());
        REQUIRE(system.engine.linear().times(dp.data(), dv.data(), true, change.data()) == SPRINGNET_OK);
        // Accuracy is that of the preconditioned residual, which differs by the spread of the nodes' own blocks; single
        // precision leaves 1e-6.
        CHECK((system.x - change - b).norm() <= (20.0 * accuracy + 1e-6) * b.norm());
        CHECK((system.rows() * system.x).norm() <= 1e-6 * system.x.norm());
      }
}

TEST_CASE("drag, cut springs, springs of length zero and nodes by themselves are solved without a matrix") {
  const LawUse dragged{"dragged", {{"drag", 40.0}}};
  Network net = lattice(14, 2e4, 1.0, &dragged);
  net.add_node(point({5, 5, 5}));
  net.add_node(point({6, 5, 5}));
  net.add_node(point({6, 5, 5}));
  net.add_spring(2745, 2746, 0, 0.5);  // of length zero, where it has no direction
  PreparedSystem system(net);
  const std::vector<std::uint32_t> cut{0, 1, 17, 400, 401, 402, 403, 5000, 9000, 9001};
  REQUIRE(system.engine.topology().cut(cut) == cut.size());
  check_matrix_free(system, 0.0, 1e-6, 1e-6);
}

TEST_CASE(
    "masses and stiffnesses over many decades are solved without a matrix, or the answer says that they are not") {
  for (const double decades : {6.0, 12.0}) {
    for (const double stiffness : {1e-6, 1e6}) {
      CAPTURE(decades);
      CAPTURE(stiffness);
      Network net = lattice(13, stiffness, 0.0);
      set_masses(net, decades);
      PreparedSystem system(net);
      const Eigen::VectorXd b = system.right_side();
      REQUIRE(system.prepare(t, t * t, 0.0, false) == SPRINGNET_OK);
      REQUIRE(system.solve(b, 1e-4) == SPRINGNET_OK);
      const springnet_evaluation at = system.evaluation();
      REQUIRE(system.linearise(at) == SPRINGNET_OK);
      const double residual = system.residual_of(b, system.x);
      if (system.answer.outcome == SPRINGNET_SOLVED) CHECK(residual <= 1e-3);
      if (decades == 6.0) CHECK(system.answer.outcome == SPRINGNET_SOLVED);
    }
  }
}

TEST_CASE("what does not fit into single precision is assembled") {
  PreparedSystem system(lattice(13, 1e43, 0.0));
  const Eigen::VectorXd b = system.right_side();
  REQUIRE(system.prepare(t, t * t, 0.0, false) == SPRINGNET_OK);
  CHECK(system.engine.linear().known());
  REQUIRE(system.solve(b, 1e-4) == SPRINGNET_OK);
  CHECK(system.x.allFinite());
}

TEST_CASE("systems that take too many iterations without a matrix are assembled") {
  // A chain: a wave crosses it within a step, for which the nodes' own blocks are a poor preconditioner.
  Network net = chain(2500, {0, 0, 0}, {0.1, 0, 0}, damped(1e7 / (t * t), 0.0));
  net.fix(0);
  PreparedSystem system(net);
  Eigen::VectorXd b = system.right_side();
  REQUIRE(system.prepare(t, t * t, 0.0, false) == SPRINGNET_OK);
  CHECK_FALSE(system.engine.linear().known());  // no matrix yet
  REQUIRE(system.solve(b, 1e-6) == SPRINGNET_OK);
  CHECK(system.engine.linear().known());
  CHECK(system.answer.outcome == SPRINGNET_SOLVED);
  CHECK(system.residual_of(b, system.x) <= 1e-6);
  const Eigen::VectorXd first = system.x;
  // The same where the solution takes the place of the right side, and from then on with the matrix at once.
  for (const bool again : {false, true}) {
    CAPTURE(again);
    PreparedSystem other(net);
    for (int i = 0; i <= (again ? 1 : 0); ++i) {
      REQUIRE(other.prepare(t, t * t, 0.0, false) == SPRINGNET_OK);
      CHECK(other.engine.linear().known() == (i > 0));
      other.x = b;
      other.answer = {};
      other.answer.struct_size = sizeof other.answer;
      other.answer.right_side = other.answer.x = other.x.data();
      other.answer.accuracy = 1e-6;
      REQUIRE(other.table.solve_system(other.table.context, &other.answer) == SPRINGNET_OK);
      CHECK(other.answer.right_side == other.x.data());
      CHECK(other.x == first);
    }
  }
}

TEST_CASE("after a solution that took too many iterations, systems without a matrix are tried ever more rarely") {
  Network net = chain(2500, {0, 0, 0}, {0.1, 0, 0}, damped(1e7 / (t * t), 0.0));
  net.fix(0);
  PreparedSystem system(net);
  const Eigen::VectorXd b = system.right_side();
  const auto assembled = [&] {  // systems until the next one without a matrix, whose solution takes too many, too
    for (int count = 0;; ++count) {
      REQUIRE(count < 1000);
      REQUIRE(system.prepare(t, t * t, 0.0, false) == SPRINGNET_OK);
      REQUIRE(system.solve(b, 1e-3) == SPRINGNET_OK);
      CHECK(system.answer.outcome == SPRINGNET_SOLVED);
      if (system.answer.iterations >= 400) return count;
    }
  };
  CHECK(assembled() == 0);
  CHECK(assembled() == 16);
  CHECK(assembled() == 32);
  CHECK(assembled() == 64);
  system.engine.forget();
  CHECK(assembled() == 0);
}

TEST_CASE("exact systems, rods, elements and viscosities across the spring are assembled") {
  const auto assembled = [](const Network& net, bool exact) {
    PreparedSystem system(net);
    REQUIRE(system.prepare(t, t * t, 0.0, exact) == SPRINGNET_OK);
    const Eigen::VectorXd b = system.right_side();
    REQUIRE(system.solve(b, 1e-6) == SPRINGNET_OK);
    CHECK(system.answer.outcome == SPRINGNET_SOLVED);
    const Eigen::MatrixXd::Index n = b.size();
    CHECK(system.x.size() == n);
    const std::vector<ConstraintRow> rows = system.engine.model().constraints.rows();
    for (const ConstraintRow& row : rows) {
      double along = 0.0;
      for (Eigen::Index c = 0; c < 3; ++c) {
        along += row.direction[c] * system.x[c * (n / 3) + row.first];
        if (row.second != ConstraintRow::no_node) along -= row.direction[c] * system.x[c * (n / 3) + row.second];
      }
      CHECK(std::abs(along) <= 1e-11);
    }
    CHECK(system.engine.linear().known());
    if (rows.empty()) CHECK(system.residual_of(b, system.x) <= 1.01e-6);
    return rows.size();
  };
  const Network plain = lattice(13, 2e4, 1.0);
  CHECK(assembled(plain, true) == 0);
  Network net = plain;
  net.add_rigid(500, 502);
  CHECK(assembled(net, false) == 1);
  // Rigid connections of which no node slides make no difference.
  net.add_plane(wall({Friction::Kind::none, 0.0}));
  net.set_gravity({-9.81, 0, 0});
  CHECK(assembled(net, false) == 13 * 12 + 1);
  net = plain;
  net.add_element(Invariant::angle, {500, 501, 700}, 0);
  CHECK(assembled(net, false) == 0);
  net = plain;
  net.add_spring(500, 1000, net.add_material({std::nullopt, LawUse{"relative", {{"damping", 1.0}}}}));
  CHECK(assembled(net, false) == 0);
}

TEST_CASE("the same bits for every number of threads and instruction set, without a matrix") {
  const Network net = lattice(29, 2e4, 1.0);  // more than 100,000 springs
  REQUIRE(PreparedSystem(net).engine.model().layout.units().size() >= 3);
  check_same_bits(net, false, 1e-3, 1e-6);
  for (const double coefficient : {0.0, 0.4}) {
    const Friction friction{coefficient > 0.0 ? Friction::Kind::coulomb : Friction::Kind::none, coefficient};
    check_same_bits(sliding_lattice(friction, false), false, 0.0, 1e-6);
  }
}

TEST_CASE("the same bits for every number of threads and instruction set, with a matrix") {
  check_same_bits(lattice(14, 2e4, 1.0), true, 1e-3, 1e-6);  // more than 20,000 blocks, by node
  // A surface: factors in pieces, an enclosure, and a viscosity that makes the matrix asymmetric.
  const TriangleMesh mesh = icosphere(5, 1.0);
  Network net = filled(mesh, 1e-3, 50.0, 1e5, 0.0);
  check_same_bits(net, true, 1e-4, 1e-6);
  const MaterialIndex across = net.add_material({std::nullopt, LawUse{"relative", {{"damping", 0.01}}}});
  const auto found = sides(mesh);
  for (std::size_t s = 0; s < found.size(); s += 3) net.add_spring(found[s].first, found[s].second, across);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node node = net.nodes()[k];
    node.velocity = Vector3(std::sin(k), std::cos(3.0 * k), std::sin(7.0 * k));
    net.set_node(k, node);
  }
  check_same_bits(net, true, 1e-4, 1e-6);
}
