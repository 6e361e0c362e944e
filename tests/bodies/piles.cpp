// Bodies that come to rest on each other, and a sheet on itself.

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "bodies.hpp"
#include "crossings.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// A strip that lies on a floor, turns up and back, and falls onto itself.
constexpr std::uint32_t across = 4, along = 31;
Network folding_sheet(const Friction& friction) {
  Network net;
  net.begin_body("strip");
  const double spacing = 0.02, radius = 0.04, length = 0.24, mass = 0.0005;
  const MaterialIndex material = net.add_material(damped(60.0, 0.02));
  for (std::uint32_t j = 0; j < across; ++j)
    for (std::uint32_t i = 0; i < along; ++i) {
      // Along the floor, up a half circle, and back above.
      const double x = spacing * i, turn = std::clamp((x - length) / radius, 0.0, std::numbers::pi);
      const double back = std::max(0.0, x - length - std::numbers::pi * radius);
      net.add_node(point({std::min(x, length) + radius * std::sin(turn) - back, spacing * j + 0.1 * back,
                          radius * (1.0 - std::cos(turn)) + 0.001},
                         mass));
    }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i + along * j; };
  for (std::uint32_t j = 0; j < across; ++j)
    for (std::uint32_t i = 0; i < along; ++i) {
      if (i + 1 < along) net.add_spring(at(i, j), at(i + 1, j), material);
      if (j + 1 < across) net.add_spring(at(i, j), at(i, j + 1), material);
      if (i + 1 == along || j + 1 == across) continue;
      net.add_spring(at(i, j), at(i + 1, j + 1), material);
      net.add_face({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      net.add_face({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  net.end_body();
  net.set_extent(0, 0.004, 0.0);
  touch_all(net, friction);
  Plane floor;
  floor.friction = {Friction::Kind::coulomb, 0.4};
  net.add_plane(floor);
  net.set_gravity({0, 0, -9.81});
  return net;
}

}  // namespace

TEST_CASE("a dropped stack of soft blocks comes to rest, none enters another, and the floor carries all") {
  const int count = 4;
  const double mass = 0.02;
  const Network net = dropped_blocks(count, mass);
  Simulation s = simulate(net, verlet, 0.001);
  double carried = 0.0;  // N s
  while (s.time() < 2.0) {
    s.step();
    if (s.time() > 1.5) carried -= 0.001 * s.surface_force(0)[2];
    if (s.steps() % 50 == 0) REQUIRE(count_crossings(net, s) == 0);
  }
  double fastest = 0.0;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) fastest = std::max(fastest, s.velocity(k).norm());
  // They rock on each other for long: soft corners carry them. They fell at 2 m/s.
  CHECK(fastest <= 0.05);
  CHECK(carried == doctest::Approx(0.5 * count * 27 * mass * 9.81).epsilon(0.02));
}

// Faces on faces have far more pairs than their nodes have places to go, and thousands of small slips.
TEST_CASE("a dropped stack of ten soft blocks settles in few sweeps of the network, and none enters another") {
  for (const double friction : {0.0, 0.1, 0.5}) {
    CAPTURE(friction);
    const Network net = dropped_blocks(10, 0.02, friction);
    Simulation s = simulate(net, {"recurrent", {}}, 0.005);
    while (s.time() < 0.25) {
      s.step();
      if (s.steps() % 10 == 0) REQUIRE(count_crossings(net, s) == 0);
    }
    CHECK(s.body_touches().size() > 100);
    // What friction has no say in, like the rest, settles within the step.
    const auto held = s.statistics().find("held_friction");
    CHECK((held == s.statistics().end() || held->second <= 2.0));  // of 50 steps
    CHECK(s.statistics().count("escalated_steps") == 0);
    CHECK(static_cast<double>(s.sweeps()) <= 10.0 * static_cast<double>(s.steps()));
  }
}

TEST_CASE("a sheet that folds onto itself does not pass through itself") {
  struct Case {
    LawUse integrator;
    double step;  // s
    Friction friction;
  };
  // With friction the network takes a minute.
  const LawUse network = recurrent(newton, 1e-6, {{"unsettled", on_unsettled_adapt}});
  for (const auto& [integrator, h, friction] :
       {Case{verlet, 0.0005, {Friction::Kind::coulomb, 0.2}}, Case{network, 0.005, frictionless}}) {
    CAPTURE(integrator.id);
    const Network net = folding_sheet(friction);
    Simulation s = simulate(net, integrator, h);
    bool met = false;
    while (s.time() < 0.4) {
      s.step();
      met = met || !s.body_touches().empty();
      if (s.steps() % (integrator.id == "verlet" ? 40 : 4) == 0) REQUIRE(count_crossings(net, s) == 0);
    }
    CHECK(met);
    // The end lies on the part below it, not on the floor.
    CHECK(s.position(along - 1 + along)[2] >= 0.0035);
  }
}
