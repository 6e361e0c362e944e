// Contact of bodies whose events are located: faces on faces, with more pairs than determine forces.

#include <doctest/doctest.h>

#include <cmath>

#include <springnet/events.hpp>

#include "bodies.hpp"
#include "crossings.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

double mean_height(const Simulation& s, NodeIndex first, NodeIndex count) {
  double sum = 0.0;
  for (NodeIndex k = first; k < first + count; ++k) sum += s.position(k)[2] / count;
  return sum;
}

}  // namespace

TEST_CASE("the reference: soft blocks that fall onto each other rock, stick and slip, and lose energy only") {
  for (const double mu : {0.0, 0.5}) {
    CAPTURE(mu);
    const Network net = dropped_blocks(2, 0.02, mu);
    Simulation s = simulate(net, reference(1e-6), 0.005);
    Simulation explicit_steps = simulate(net, verlet, 2e-5);
    double energy = s.kinetic_energy() + s.potential_energy();
    while (s.time() < 0.1199) {
      s.step();
      while (explicit_steps.time() < s.time() - 1e-6) explicit_steps.step();
      const double now = s.kinetic_energy() + s.potential_energy();
      CHECK(now <= energy + 1e-7);
      energy = now;
      REQUIRE(count_crossings(net, s) == 0);
      // Steps of `verlet` take impacts, at 1 m/s, to be somewhere in them: 2e-5 m each, of which several follow.
      for (const NodeIndex first : {0u, 27u})
        CHECK(std::abs(mean_height(s, first, 27) - mean_height(explicit_steps, first, 27)) <= 8e-5);
    }
    // They meet at 0.08 s. Forces that alternate between pairs take at least five times as many, and the slips that
    // each small impact leaves in all pairs around it three times as many.
    CHECK(s.statistics().at("restarts") <= 1300.0);
    const auto events = count_events(s);
    CHECK(events.met >= 50);
    CHECK(events.slipped <= 150);
  }
}

// Corner on corner, with edges and diagonals above each other, so that most pairs are redundant: they share the weight
// within their cones, and hardly any slips. The search for meetings once halved its steps for ever here.
TEST_CASE("the reference: a soft block rests on another exactly below it") {
  const double mass = 0.02, mu = 0.5;
  const Network net = boxes_above_each_other(0.0, 0.11, mu);
  Simulation s = simulate(net, reference(1e-6), 0.005);
  advance(s, 300);  // by then hardly anything is left of what its weight makes it sway
  CHECK(count_events(s).slipped <= 2);
  CHECK(s.statistics().at("restarts") <= 20.0);
  Vector3 carried = Vector3::Zero();
  REQUIRE(s.body_touches().size() >= 4);
  for (const BodyTouch& each : s.body_touches()) {
    carried += (each.nodes[0] >= 8 ? 1.0 : -1.0) * each.force;
    const double pressing = each.normal.dot(each.force);
    CHECK(pressing >= -1e-7);
    CHECK((each.force - pressing * each.normal).norm() <= mu * pressing + 1e-7);
  }
  CHECK((carried - Vector3(0, 0, 8 * mass * g)).norm() <= 1e-2 * 8 * mass * g);
}

TEST_CASE(
    "the reference: a soft block slides on a sheet until friction stops it, and each slip ends in one direction") {
  const double mu = 0.5, speed = 0.3, thickness = 0.01;
  Network net;
  add_sheet(net, "floor", 2, 4.0, {0, 0, 0}, Vector3::UnitX(), Vector3::UnitY(), thickness, 1.0, true);
  add_block(net, "block", 4, 0.1, {0.013, 0.007, thickness}, {speed, 0.05, 0}, 0.02, thickness, 1500.0, 1.0);
  touch(net, 0, 1, {Friction::Kind::coulomb, mu});
  net.set_gravity({0, 0, -g});
  Simulation s = simulate(net, reference(1e-6), 0.005);
  const auto drift = [&] {
    Vector3 sum = Vector3::Zero();
    for (NodeIndex k = 4; k < 68; ++k) sum += s.velocity(k) / 64.0;
    return sum;
  };
  double energy = s.kinetic_energy() + s.potential_energy();
  while (s.time() < 0.1499) {
    s.step();
    const double now = s.kinetic_energy() + s.potential_energy();
    CHECK(now <= energy + 1e-7);
    energy = now;
    // As long as all of it slides, which its soft corners soon do not.
    if (s.time() < 0.011) CHECK(drift()[0] == doctest::Approx(speed - mu * g * s.time()).epsilon(0.02));
  }
  CHECK(count_events(s).stuck >= 10);
  CHECK(drift().head<2>().norm() <= 0.05);  // it sways
  // Slips that go round their end take half as many again.
  CHECK(s.statistics().at("restarts") <= 150.0);
}
