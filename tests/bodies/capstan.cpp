// A rope over a fixed cylinder of nodes: how friction divides its tension.

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "bodies.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double radius = 0.1, thickness = 0.01, rope = 0.005, turn = 7.5 * 3.14159265358979323846 / 180.0;

// Where the middle of a facet is, `height` above it.
Vector3 over(int facet, double height) {
  return {height * std::cos(facet * turn), 0.03, height * std::sin(facet * turn)};
}

// A fixed cylinder about the y axis of 48 facets, whose middles are at `radius`.
void add_cylinder(Network& net) {
  net.begin_body("cylinder");
  const double corner = radius / std::cos(0.5 * turn);
  for (int k = 0; k < 48; ++k)
    for (const double y : {-0.1, 0.1}) {
      const double angle = (k - 0.5) * turn;
      Node node = point({corner * std::cos(angle), y, corner * std::sin(angle)}, 1.0);
      node.fixed = true;
      net.add_node(node);
    }
  for (NodeIndex k = 0; k < 48; ++k) {
    const NodeIndex a = 2 * k, b = 2 * ((k + 1) % 48);
    net.add_face({a, a + 1, b + 1});
    net.add_face({a, b + 1, b});
  }
  net.end_body();
  net.set_extent(0, thickness, 0.0);
}

}  // namespace

// At each node the rope turns by `turn`: its tensions T < U and the facet's reaction N balance with
//
//   (T + U) sin(turn/2) = N,   (U - T) cos(turn/2) = mu N
//
// where it slides, so that U/T = (1 + mu tan(turn/2)) / (1 - mu tan(turn/2)); for small turns all of them make
// exp(mu angle), the capstan's formula (L. Euler, 1762).
TEST_CASE("a rope that is pulled over a cylinder holds with what friction leaves of its tension") {
  constexpr int count = 25;  // half a turn
  const double mu = 0.3, pull = 10.0, height = radius + 0.5 * thickness + rope, stiffness = 1e6, h = 1e-3;
  Network net;
  add_cylinder(net);
  net.begin_body("rope");
  const MaterialIndex material = net.add_material(damped(stiffness, 30.0));
  Node anchor = point(over(-1, height), 0.01);
  anchor.fixed = true;
  NodeIndex last = net.add_node(anchor);
  for (int k = 0; k < count; ++k) {
    const NodeIndex node = net.add_node(point(over(k, height), 0.01));
    net.add_spring(last, node, material);
    last = node;
  }
  net.end_body();
  net.set_extent(1, 0.0, rope);
  touch(net, 0, 1, {Friction::Kind::coulomb, mu});
  Load load;
  load.nodes = {last};
  load.force = pull * (over(count, height) - over(count - 1, height)).normalized();
  load.from = 0.0;
  load.course.ramp = 0.4;  // slowly, so that no node slides back
  net.add_load(load);
  Simulation s = simulate(net, recurrent(newton, 1e-5), h);
  advance(s, 420);
  const double tangent = mu * std::tan(0.5 * turn), ratio = (1.0 + tangent) / (1.0 - tangent);
  constexpr double off = 5e-3;  // nodes slide up to 0.2 mm, 2 % of a facet
  double tension = pull;
  for (int k = count - 1; k >= 0; --k) {
    CAPTURE(k);
    tension /= ratio;
    CHECK(s.tension(static_cast<SpringIndex>(k)) == doctest::Approx(tension).epsilon(off));
  }
  CHECK(tension == doctest::Approx(pull * std::exp(-mu * count * turn)).epsilon(2e-3));  // of small turns
  CHECK(s.reaction(2 * 48).norm() == doctest::Approx(tension).epsilon(off));
  CHECK(s.body_touches().size() >= count);
}
