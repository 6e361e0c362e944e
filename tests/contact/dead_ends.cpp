// Rigid bodies in contact, where what one node's contact allows depends on those of the others: the reference goes on,
// keeps lengths and surfaces, takes no energy from nowhere, and finds what it finds at every tolerance.

#include <doctest/doctest.h>
#include <initializer_list>

#include "fate.hpp"
#include "tumbling.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("rigid bodies that tumble onto surfaces do not stop the reference") {
  for (const auto seed :
       std::initializer_list<std::uint64_t>{12, 34, 47, 50, 61, 73, 84, 99, 112, 117, 128, 143, 147, 164, 191, 196}) {
    const Tumbling scene(seed);
    INFO(scene.name() << ", seed " << seed);
    check_fate(scene.net, Tumbling::until);
  }
}

// These rocked without end, lay wedged, slipped where no direction was found, or went two ways.
TEST_CASE("rigid bodies that tumble into grooves come to rest there") {
  for (const auto seed : std::initializer_list<std::uint64_t>{27, 44, 56, 63, 104, 131, 156, 184, 307}) {
    const Tumbling scene(seed);
    INFO(scene.name() << ", seed " << seed);
    check_fate(scene.net, Tumbling::until);
  }
}

// Where these stopped, what held one corner had to pull, and without it the corner went into the surface.
TEST_CASE("a rigid triangle that springs draw over a plane that holds it does not stop the reference") {
  Network net;
  for (const Vector3& corner : {Vector3(0, 0, 0.2), Vector3(0.5, 0.1, 0.3), Vector3(0.2, 0.45, 0.25)})
    net.add_node(point(corner, 0.4, {0.8, -0.3, -1.0}));
  for (NodeIndex i = 0; i < 3; ++i) net.add_rigid(i, (i + 1) % 3);
  net.add_node(point({0.3, 0.2, 0.9}, 0.3, {-0.5, 0.6, 1.5}));
  const MaterialIndex material = net.add_material(damped(60.0, 0.2));
  for (NodeIndex i = 0; i < 3; ++i) net.add_spring(i, 3, material);
  net.set_gravity({0, 0, -4});
  net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  check_fate(net, 1.0);
}

TEST_CASE("a rigid link with friction between a sphere and a plane does not stop the reference") {
  for (const double coefficient : {0.2, 0.5, 0.9}) {
    CAPTURE(coefficient);
    Network net;
    net.add_node(point({0.25, 0.05, 1.2}, 0.5, {0.3, 0, -0.4}));
    net.add_node(point({0.85, 0.1, 0.6}, 0.3, {0.2, 0.1, 0}));
    net.add_rigid(0, 1);
    net.set_gravity({0, 0, -5});
    Plane plane;
    plane.friction = {Friction::Kind::coulomb, coefficient};
    net.add_plane(plane);
    Instrument sphere;
    sphere.first = sphere.second = {0, 0, 0.5};
    sphere.radius = 0.5;
    sphere.friction = plane.friction;
    net.add_instrument(sphere);
    check_fate(net, 1.0);
  }
}
