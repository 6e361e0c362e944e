// Residuals of every kind of observation, and their derivatives by variables of every kind, against differences.

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include "learning/fit.hpp"
#include "learning_nets.hpp"

using namespace springnet;
using namespace springnet::learning;
using namespace springnet::testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

// A block of springs, dampers and volumes; one node is fixed, another one moved; a load comes and goes.
Network held_block() {
  Network net;
  Lattice lattice;
  lattice.nodes = {3, 3, 2};
  lattice.diagonals = Diagonals::face;
  Node node;
  node.neuron = net.add_neuron({"dragged", {{"drag", 0.1}}});
  net.add_lattice("block", lattice, node, net.add_material(damped(60.0, 1.0)));
  Dice dice(5);
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    Node own = net.nodes()[k];
    own.position += dice.in_box(0.05);
    own.velocity = dice.in_box(0.5);
    own.mass = dice.between(0.5, 2.0);
    net.set_node(k, own);
  }
  net.fix(0);
  const MaterialIndex filling =
      net.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, LawUse{"linear", {{"damping", 0.2}}}});
  net.add_element(Invariant::volume, {0, 4, 7, 12}, filling, 0.2);
  net.add_element(Invariant::area, {2, 4, 7}, filling, 0.6);
  Move move;
  move.nodes = {2};
  move.motion.times = {0.0, 0.15, 0.3};
  move.motion.displacements = {{0, 0, 0}, {0.1, 0.1, 0.0}, {0.2, 0, 0.1}};
  net.add_move(move);
  Load load;
  load.nodes = {0, 2, 11};
  load.force = {2.0, 0, 1.0};
  load.from = 0.03;
  load.until = 0.17;
  net.add_load(load);
  net.set_gravity({0, 0, -3.0});
  return net;
}

Observations of_every_kind(const Network& net) {
  Observations seen;
  Dice dice(8);
  for (const double time : {0.02, 0.05, 0.071, 0.2}) {
    seen.positions.push_back(row(time, 5, net.nodes()[5].position + dice.in_box(0.1)));
    seen.velocities.push_back(row(time, 8, dice.in_box(0.3)));
    for (const NodeIndex held : {0u, 2u}) seen.reactions.push_back(row(time, held, dice.in_box(5.0)));
    Observations::DistanceRow distance;
    distance.time = time;
    distance.node = 3;
    distance.other = 16;
    distance.distance = 1.0;
    distance.weight = 2.0;
    seen.distances.push_back(distance);
    for (int i = 0; i < 12; ++i) {
      Observations::SurfacePoint on;
      on.time = time;
      on.point = Vector3(1, 1, 0.5) + dice.in_box(1.5);
      on.weight = 3.0;
      seen.surface_points.push_back(on);
    }
  }
  seen.reactions.push_back(row(0.0, 0, {1, 2, 3}));  // at the start, too
  return seen;
}

std::vector<Learnable> of_every_kind(std::size_t springs, std::size_t nodes) {
  std::vector<std::uint32_t> moving = from_to(0, nodes);
  std::erase_if(moving, [](std::uint32_t k) { return k == 0 || k == 2; });
  std::vector<Learnable> all{{{Kind::spring_parameter, false, "stiffness", from_to(0, springs)}},
                             {{Kind::viscosity_parameter, false, "damping", from_to(0, springs)}},
                             {{Kind::rest_length, false, "", from_to(0, springs)}},
                             {{Kind::spring_parameter, true, "stiffness", {0, 1}}},
                             {{Kind::mass, false, "", from_to(0, nodes)}},
                             {{Kind::neuron_parameter, false, "drag", from_to(0, nodes)}, true},
                             {{Kind::initial_velocity, false, "", moving}},
                             {{Kind::load, false, "", {0}}},
                             {{Kind::gravity, false, "", {2, 0}}}};
  for (const std::size_t field : {std::size_t{0}, std::size_t{2}, std::size_t{6}}) all[field].field_degree = 1;
  return all;
}

}  // namespace

TEST_CASE("derivatives of residuals of every kind are those of differences") {
  const Network net = held_block();
  for (const double theta : {1.0, 0.5}) {
    CAPTURE(theta);
    Observations seen = of_every_kind(net);
    if (theta == 0.5) seen.outlier_distance = 0.4;  // m, of distances up to 1
    Fit fit({experiment(net, to_learn_with(theta, 0.02), seen)}, plugins(),
            of_every_kind(net.springs().size(), net.nodes().size()), 0.0);
    const VectorXd x = fit.variables().start();
    const VectorXd& scale = fit.variables().scale();
    const VectorXd residuals = fit.residuals(x);
    REQUIRE(residuals.allFinite());
    fit.linearise(x);
    Dice dice(3);
    MatrixXd changes(x.size(), 3);
    for (Eigen::Index i = 0; i < changes.size(); ++i) changes.data()[i] = dice.between(-1, 1) * scale[i % scale.size()];
    const MatrixXd along = fit.times(changes);
    constexpr Eigen::Index nodes_rows = 4 * (3 + 3 + 1), points = 4 * 12 * 3;
    // Where a face is nearest, the way to the point changes along itself alone.
    int on_faces = 0;
    for (Eigen::Index i = nodes_rows; i < nodes_rows + points; i += 3) {
      const Vector3 way = residuals.segment<3>(i), change = along.col(0).segment<3>(i);
      if (change.norm() > 0.0 && way.cross(change).norm() < 1e-9 * way.norm() * change.norm()) ++on_faces;
    }
    CHECK(on_faces >= 5);
    CHECK(on_faces < 48);  // edges and corners are nearest to others
    const VectorXd gradient = fit.transposed_times(residuals);
    for (Eigen::Index j = 0; j < changes.cols(); ++j) {
      // The systems of steps are solved to 1e-10.
      CHECK(gradient.dot(changes.col(j)) == doctest::Approx(residuals.dot(along.col(j))).epsilon(1e-8));
      const auto cost = [&](double h) { return 0.5 * fit.residuals(x + h * changes.col(j)).squaredNorm(); };
      // Of sixth order. The cost is smooth as long as each point stays with its face, edge or corner; where it changes
      // them, the cost has a jump in the second derivative.
      constexpr double h = 1e-4;
      const double difference =
          (45.0 * (cost(h) - cost(-h)) - 9.0 * (cost(2 * h) - cost(-2 * h)) + cost(3 * h) - cost(-3 * h)) / (60.0 * h);
      CHECK(gradient.dot(changes.col(j)) == doctest::Approx(difference).epsilon(1e-6));
      // All but points of the surface have residuals whose own derivative this is.
      const auto at = [&](double by) { return fit.residuals(x + by * changes.col(j)); };
      const VectorXd change = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
      VectorXd difference_of_rows = change - along.col(j);
      difference_of_rows.segment(nodes_rows, points).setZero();
      CHECK(difference_of_rows.norm() < 1e-7 * change.norm());
    }
  }
}

TEST_CASE("residuals of points of a surface are their distances from it") {
  const Network net = held_block();
  Observations seen;
  // A face of the side y = 0 at the start: its centre, lifted along the normal.
  const Face face = net.faces().front();
  const auto corner = [&](std::size_t i) { return net.nodes()[face[i]].position; };
  const Vector3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
  Observations::SurfacePoint on;
  on.point = (corner(0) + corner(1) + corner(2)) / 3.0 + 0.03 * normal;
  on.weight = 4.0;
  seen.surface_points = {on};
  seen.positions.push_back(row(0.02, 5, {0, 0, 0}));
  Fit fit({experiment(net, to_learn_with(1.0, 0.02), seen)}, plugins(),
          {{{Kind::spring_parameter, false, "stiffness", from_to(0, net.springs().size())}, true}}, 0.0);
  const VectorXd residuals = fit.residuals(fit.variables().start()).head(fit.observation_rows());
  REQUIRE(residuals.size() == 6);
  CHECK((residuals.tail(3) + 2.0 * 0.03 * normal).norm() < 1e-14);
  CHECK(fit.observed() == 4);
  // As an outlier it has the cost weight (k d - k^2 / 2).
  seen.outlier_distance = 0.01;
  Fit robust({experiment(net, to_learn_with(1.0, 0.02), seen)}, plugins(),
             {{{Kind::spring_parameter, false, "stiffness", from_to(0, net.springs().size())}, true}}, 0.0);
  const VectorXd of_outlier = robust.residuals(robust.variables().start()).head(robust.observation_rows());
  CHECK(0.5 * of_outlier.tail(3).squaredNorm() == doctest::Approx(4.0 * (0.01 * 0.03 - 0.5 * 1e-4)).epsilon(1e-12));
  // So has a position, which is seen at (0, 0, 0) with weight 1.
  const double distance = residuals.head(3).norm();
  REQUIRE(distance > 0.05);
  CHECK(0.5 * of_outlier.head(3).squaredNorm() == doctest::Approx(0.01 * distance - 0.5 * 1e-4).epsilon(1e-12));
  CHECK(Vector3(of_outlier.head(3)).cross(Vector3(residuals.head(3))).norm() < 1e-14);
}

TEST_CASE("of a position without a component only what was seen tells whether it is an outlier") {
  const Network net = held_block();
  Observations seen;
  seen.positions.push_back(row(0.02, 5, {0, 0, 0}));
  seen.positions.back().weight = Vector3(1, 0, 4);
  seen.outlier_distance = 1e-3;
  const std::vector<Learnable> stiffness{
      {{Kind::spring_parameter, false, "stiffness", from_to(0, net.springs().size())}, true}};
  Fit robust({experiment(net, to_learn_with(1.0, 0.02), seen)}, plugins(), stiffness, 0.0);
  seen.outlier_distance = std::numeric_limits<double>::infinity();
  Fit plain({experiment(net, to_learn_with(1.0, 0.02), seen)}, plugins(), stiffness, 0.0);
  const VectorXd of_outlier = robust.residuals(robust.variables().start()).head(3);
  const VectorXd residual = plain.residuals(plain.variables().start()).head(3);
  const double distance = std::hypot(residual[0], residual[2] / 2.0);
  REQUIRE(distance > 1e-2);
  const double share = std::sqrt(2e-3 * distance - 1e-6) / distance;
  CHECK((of_outlier - share * residual).norm() < 1e-14);
  CHECK(of_outlier[1] == 0.0);
}
