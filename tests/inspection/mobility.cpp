// Mechanisms, motions as a rigid body and redundant rigid connections, against counts by hand (Maxwell).
#include <doctest/doctest.h>
#include <springnet/inspection.hpp>

#include "nets.hpp"

using namespace springnet;
using testing::plugins;

namespace {

Mobility mobility_of(const Network& network) { return inspect(network, *plugins()).mobility; }

// Four corners of a square in a plane, springs along its sides.
Network square() {
  Network net;
  const MaterialIndex material = net.add_material(testing::damped(2.0, 0.0));
  for (const Vector3& corner : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(0, 1, 0)}) {
    net.add_node(testing::point(corner));
  }
  for (NodeIndex k = 0; k < 4; ++k) net.add_spring(k, (k + 1) % 4, material);
  return net;
}

// Five nodes, each joined to each other one.
std::vector<Vector3> five_points() { return {{0, 0, 0}, {1, 0, 0.1}, {0.2, 1, 0}, {0.1, 0.2, 1}, {0.7, 0.8, 0.9}}; }

}  // namespace

TEST_CASE("the paper's cube has three mechanisms") {
  const Mobility found = mobility_of(testing::cube(3.0, 2.0, 0.2, 0.081));
  CHECK(found.known);
  CHECK(found.mechanisms == 3);
  CHECK(found.rigid_body_motions == 6);
  CHECK(found.springs_under_tension == 0);
}

TEST_CASE("mechanisms: a triangle has none, a square shears and folds, with a diagonal it only folds") {
  const Network triangle = [] {
    Network net = testing::chain(3, Vector3::Zero(), {1.0, 0.5, 0.0}, testing::damped(1.0, 0.0));
    Node node = net.nodes()[2];
    node.position = {0.0, 2.0, 0.0};
    net.set_node(2, node);
    net.add_spring(2, 0, 0);
    return net;
  }();
  CHECK(mobility_of(triangle).mechanisms == 0);
  CHECK(mobility_of(triangle).rigid_body_motions == 6);
  Network net = square();
  CHECK(mobility_of(net).mechanisms == 2);
  net.add_spring(0, 2, 0);
  CHECK(mobility_of(net).mechanisms == 1);
}

TEST_CASE("a straight chain of three nodes bends in two directions and rotates about two axes") {
  const Mobility found = mobility_of(testing::chain(3, Vector3::Zero(), Vector3::UnitX(), testing::damped(1.0, 0.0)));
  CHECK(found.mechanisms == 2);
  CHECK(found.rigid_body_motions == 5);
}

TEST_CASE("fixed and moved nodes remove motions") {
  Network net = square();
  net.fix(0);
  CHECK(mobility_of(net).rigid_body_motions == 3);
  CHECK(mobility_of(net).mechanisms == 2);
  net.fix(1);
  CHECK(mobility_of(net).rigid_body_motions == 1);
  CHECK(mobility_of(net).mechanisms == 2);
  Motion motion;
  motion.amplitude = Vector3::UnitZ();
  motion.frequency = 1.0;
  net.add_move({{2}, motion});
  CHECK(mobility_of(net).rigid_body_motions == 0);
  CHECK(mobility_of(net).mechanisms == 1);  // the last node moves out of the plane
}

TEST_CASE("a node by itself has three motions; springs without stiffness do not count") {
  Network net;
  net.add_node({});
  CHECK(mobility_of(net).rigid_body_motions == 3);
  CHECK(mobility_of(net).mechanisms == 0);
  const Material dashpot{std::nullopt, LawUse{"linear", {{"damping", 1.0}}}};
  CHECK(mobility_of(testing::chain(2, Vector3::Zero(), Vector3::UnitX(), dashpot)).mechanisms == 1);
  CHECK(mobility_of(testing::chain(2, Vector3::Zero(), Vector3::UnitX(), testing::damped(0.0, 1.0))).mechanisms == 1);
  CHECK(mobility_of(testing::chain(2, Vector3::Zero(), Vector3::UnitX(), testing::damped(1e-9, 1.0))).mechanisms == 0);
}

TEST_CASE("rigid connections resist like springs, and redundant ones are counted") {
  Network net;
  for (const Vector3& position : five_points()) net.add_node(testing::point(position));
  for (NodeIndex a = 0; a < 5; ++a) {
    for (NodeIndex b = a + 1; b < 5; ++b) net.add_rigid(a, b);
  }
  Mobility found = mobility_of(net);
  CHECK(found.mechanisms == 0);
  CHECK(found.rigid_body_motions == 6);
  CHECK(found.redundant_rigids == 1);  // 10 connections, 3 x 5 - 6 = 9 shapes to hold
  net.fix(0);
  net.fix(1);
  found = mobility_of(net);
  CHECK(found.redundant_rigids == 2);  // that between the fixed nodes holds nothing
  CHECK(found.rigid_body_motions == 1);
}

TEST_CASE("springs under tension and under compression are counted") {
  Network net = square();
  net.set_rest_length(0, 0.9);
  net.set_rest_length(1, 0.8);
  net.set_rest_length(2, 1.1);
  CHECK(mobility_of(net).springs_under_tension == 2);
  CHECK(mobility_of(net).springs_under_compression == 1);
}
