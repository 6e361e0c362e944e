// inspect with nets under load.
#include <cmath>

#include <doctest/doctest.h>
#include <springnet/inspection.hpp>

#include "loaded.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("a following pressure counts in the limits of time constants, as it acts at the start") {
  // One free node on three springs at right angles at rest, K = k I, and a corner of a pressed triangle, whose other
  // corners are fixed: K = k I + [s]x with s = p (c - b) / 6, and eigenvalues k, k + i s, k - i s.
  constexpr double mass = 0.5, stiffness = 3.0, pressure = 60.0;
  for (const bool later : {false, true}) {
    Network net;
    net.add_node(point(Vector3::Zero(), mass));
    const MaterialIndex material = net.add_material(damped(stiffness, 0.0));
    for (const Vector3& p : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)}) {
      net.fix(net.add_node(point(p)));
      net.add_spring(0, static_cast<NodeIndex>(net.nodes().size() - 1), material);
    }
    Load load = pressed({{0, 1, 2}}, pressure, true);
    if (later) load.from = 1.0;
    net.add_load(load);
    const Inspection found = inspect(net, *plugins());
    const TimeConstantLimit& limit = found.limit("synchronous");
    REQUIRE(limit.kind == TimeConstantLimit::Kind::known);
    const double skew = later ? 0.0 : pressure / 6.0 * std::sqrt(2.0);
    CHECK(limit.time_constant == doctest::Approx(std::sqrt(mass / std::hypot(stiffness, skew))).epsilon(2e-3));
    CHECK(found.mobility.mechanisms == 0);
    CHECK(found.loads == 1);
  }
}
