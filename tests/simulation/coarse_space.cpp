// Groups of nodes that move as rigid bodies, as a second level of preconditioners.

#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "../elements/bodies.hpp"
#include "layers/linear/coarse_space.hpp"
#include "prepared_system.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// Two heaps of 24 nodes each that are far from each other along x, and two nodes that do not move.
struct Heaps {
  static constexpr Index nodes = 50, first_fixed = 48;
  Heaps() {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (Index k = 0; k < nodes; ++k)
      at.col(k) << (k % 2 == 0 ? -10.0 : 10.0) + unit(random), unit(random), 0.5 * unit(random);
    constrained.assign(nodes, 0);
    constrained[first_fixed] = constrained[first_fixed + 1] = 1;
    x = at.row(0);
    y = at.row(1);
    z = at.row(2);
    std::uniform_int_distribution<Index> node(0, nodes - 1);
    for (int s = 0; s < 300; ++s) {
      const Index i = node(random), j = node(random);
      if (i == j) continue;
      const double a = s % 3 == 0 ? 0.2 + 0.1 * unit(random) : 0.0;
      springs.push_back({i, j, a, Vector3d(unit(random), unit(random), unit(random)) * 3.0});
    }
  }
  struct Spring {
    Index i, j;
    double a;
    Vector3d q;
  };
  // The matrix, with masses of 0.1, without nodes that do not move.
  [[nodiscard]] MatrixXd system() const {
    MatrixXd s = 0.1 * MatrixXd::Identity(3 * nodes, 3 * nodes);
    for (const Spring& each : springs) {
      const Matrix3d b = each.a * Matrix3d::Identity() + each.q * each.q.transpose();
      s.block<3, 3>(3 * each.i, 3 * each.i) += b;
      s.block<3, 3>(3 * each.j, 3 * each.j) += b;
      s.block<3, 3>(3 * each.i, 3 * each.j) -= b;
      s.block<3, 3>(3 * each.j, 3 * each.i) -= b;
    }
    return s;
  }
  // Six motions of each heap.
  [[nodiscard]] MatrixXd motions() const {
    MatrixXd p = MatrixXd::Zero(3 * nodes, 12);
    for (Index k = 0; k < first_fixed; ++k)
      for (Index c = 0; c < 3; ++c) {
        p.block<3, 1>(3 * k, 6 * (k % 2) + c) = Vector3d::Unit(c);
        p.block<3, 1>(3 * k, 6 * (k % 2) + 3 + c) = Vector3d::Unit(c).cross(Vector3d(at.col(k)));
      }
    return p;
  }
  Eigen::Matrix3Xd at{3, nodes};
  VectorXd x, y, z;
  std::vector<std::uint8_t> constrained;
  std::vector<Spring> springs;
};

constexpr double t = 0.02;  // s

// 1000 nodes with k t^2 / m of 1000.
Network stiff_block() {
  Network net;
  Lattice shape;
  shape.nodes = {10, 10, 10};
  shape.spacing = Vector3::Constant(0.1);
  shape.diagonals = Diagonals::all;
  Node prototype;
  prototype.mass = 1.0;
  net.add_lattice("block", shape, prototype, net.add_material(damped(1000.0 / (t * t), 0.0)));
  return net;
}

}  // namespace

TEST_CASE("the coarse correction is the solution among rigid motions of the groups") {
  const Heaps heaps;
  const MatrixXd s = heaps.system(), p = heaps.motions();
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  VectorXd r(3 * Heaps::nodes);
  for (double& each : r) each = unit(random);
  r.tail(6).setZero();
  const VectorXd expected = p * (p.transpose() * s * p).ldlt().solve(p.transpose() * r);
  for (const bool by_springs : {true, false}) {
    CAPTURE(by_springs);
    layers::CoarseSpace coarse;
    coarse.begin({heaps.x.data(), heaps.y.data(), heaps.z.data()}, heaps.constrained);
    for (Index k = 0; k < Heaps::nodes; ++k)
      for (Index l = 0; l < Heaps::nodes; ++l) {
        const Matrix3d block = by_springs && k == l ? Matrix3d(0.1 * Matrix3d::Identity())
                               : by_springs         ? Matrix3d(Matrix3d::Zero())
                                                    : Matrix3d(s.block<3, 3>(3 * k, 3 * l));
        coarse.add_block(static_cast<std::size_t>(k), static_cast<std::size_t>(l), block);
      }
    for (const Heaps::Spring& each : heaps.springs)
      if (by_springs)
        coarse.add_spring(static_cast<std::size_t>(each.i), static_cast<std::size_t>(each.j), each.a, each.q);
    coarse.factorise();
    REQUIRE(coarse.any());
    VectorXd z = VectorXd::Zero(r.size());
    const double along = coarse.correct<3>(r.data(), z.data());
    CHECK(along == doctest::Approx(r.dot(z)).epsilon(1e-5));  // of single precision
    // 1e-5 of its diagonal is added, which the smallest of its eigenvalues, some hundredths of it, see most.
    CHECK((z - expected).norm() < 1e-3 * expected.norm());
  }
}

TEST_CASE("nodes that no longer move leave their groups, and come back") {
  const Heaps heaps;
  const MatrixXd s = heaps.system(), p = heaps.motions();
  layers::CoarseSpace coarse;
  coarse.begin({heaps.x.data(), heaps.y.data(), heaps.z.data()}, heaps.constrained);
  for (std::size_t k = 0; k < 50; ++k) coarse.add_block(k, k, 0.1 * Matrix3d::Identity());
  for (const Heaps::Spring& each : heaps.springs)
    coarse.add_spring(static_cast<std::size_t>(each.i), static_cast<std::size_t>(each.j), each.a, each.q);
  coarse.factorise();
  const MatrixXd inverse = (p.transpose() * s * p).inverse();
  std::vector<std::uint8_t> held = heaps.constrained;
  for (const Index k : {3, 4, 17}) held[static_cast<std::size_t>(k)] = 1;
  for (const std::vector<std::uint8_t>& constrained : {held, heaps.constrained}) {
    coarse.follow(constrained);
    VectorXd r(3 * Heaps::nodes), moves = VectorXd::Ones(r.size());
    for (Index i = 0; i < r.size(); ++i) r[i] = std::sin(1.0 + static_cast<double>(i));
    for (Index k = 0; k < Heaps::nodes; ++k)
      if (constrained[static_cast<std::size_t>(k)] != 0) moves.segment<3>(3 * k).setZero();
    VectorXd z = VectorXd::Zero(r.size());
    static_cast<void>(coarse.correct<3>(r.data(), z.data()));
    const VectorXd expected = moves.cwiseProduct(p * (inverse * (p.transpose() * moves.cwiseProduct(r))));
    CHECK((z - expected).norm() < 1e-3 * expected.norm());  // as above
    CHECK(z.cwiseProduct(VectorXd::Ones(z.size()) - moves).isZero(0.0));
  }
}

TEST_CASE("groups whose matrix is not positive definite are left out") {
  const Heaps heaps;
  layers::CoarseSpace coarse;
  coarse.begin({heaps.x.data(), heaps.y.data(), heaps.z.data()}, heaps.constrained);
  for (std::size_t k = 0; k < 50; ++k) coarse.add_block(k, k, -Matrix3d::Identity());
  coarse.factorise();
  CHECK_FALSE(coarse.any());
  // Nor are there groups of nothing.
  coarse.begin({heaps.x.data(), heaps.y.data(), heaps.z.data()}, std::vector<std::uint8_t>(50, 1));
  coarse.factorise();
  CHECK_FALSE(coarse.any());
}

TEST_CASE("a net a thousand times stiffer than its masses takes as few iterations as its groups allow") {
  // 1000 nodes hang from one face; with blocks of single nodes alone a solution takes more than 100 iterations.
  Network net = stiff_block();
  for (NodeIndex k = 0; k < 100; ++k) net.fix(k);
  // Without a matrix; and with one, as a net with a rod has it.
  for (const bool assembled : {false, true}) {
    CAPTURE(assembled);
    Network own = net;
    if (assembled) own.add_rigid(500, 502);
    PreparedSystem system(own);
    const VectorXd b = system.right_side();
    REQUIRE(system.prepare(t, t * t, 0.0, false) == SPRINGNET_OK);
    CHECK(system.engine.linear().known() == assembled);
    REQUIRE(system.solve(b, 1e-3) == SPRINGNET_OK);
    CHECK(system.answer.outcome == SPRINGNET_SOLVED);
    CHECK(system.answer.iterations < 25);
    for (const unsigned threads : {2u, 3u}) {
      PreparedSystem other(own, threads);
      REQUIRE(other.prepare(t, t * t, 0.0, false) == SPRINGNET_OK);
      REQUIRE(other.solve(b, 1e-3) == SPRINGNET_OK);
      CHECK(other.x == system.x);
    }
    PreparedSystem generic(own, 1, InstructionSet::generic);
    REQUIRE(generic.prepare(t, t * t, 0.0, false) == SPRINGNET_OK);
    REQUIRE(generic.solve(b, 1e-3) == SPRINGNET_OK);
    CHECK(generic.x == system.x);
  }
}

TEST_CASE("groups serve until what they no longer save has cost as much as making them") {
  // A block that turns: kept groups know its motions worse and worse.
  Network net = stiff_block();
  PreparedSystem system(net);
  const VectorXd b = system.right_side();
  const auto turn = [&](double angle) {
    for (std::size_t k = 0; k < system.node_count(); ++k) {
      const double y = system.p[1][k], z = system.p[2][k];
      system.p[1][k] = std::cos(angle) * y - std::sin(angle) * z;
      system.p[2][k] = std::sin(angle) * y + std::cos(angle) * z;
    }
  };
  const auto iterations = [&] {
    REQUIRE(system.prepare(t, t * t, 0.0, false) == SPRINGNET_OK);
    REQUIRE(system.solve(b, 1e-3) == SPRINGNET_OK);
    REQUIRE(system.answer.outcome == SPRINGNET_SOLVED);
    const double residual = system.answer.residual;
    CHECK(residual <= 1e-3);
    return system.answer.iterations;
  };
  const std::uint64_t fresh = iterations();
  CHECK(iterations() == fresh);  // nothing has changed
  turn(1.5);
  const std::uint64_t stale = iterations();
  CHECK(stale > fresh + 5);
  std::uint64_t now = stale;
  for (int k = 0; k < 20 && now == stale; ++k) now = iterations();
  CHECK(now <= fresh + 2);
  // Another time constant needs groups of its own.
  turn(1.5);
  REQUIRE(system.prepare(0.5 * t, 0.25 * t * t, 0.0, false) == SPRINGNET_OK);
  REQUIRE(system.solve(b, 1e-3) == SPRINGNET_OK);
  CHECK(system.answer.iterations <= fresh + 2);
  // What is kept goes with all the rest.
  static_cast<void>(iterations());
  turn(1.5);
  system.engine.forget();
  CHECK(iterations() <= fresh + 2);
}
