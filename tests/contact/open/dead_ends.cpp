// Rigid bodies in contact, where what one node's contact allows depends on those of the others: the reference goes on,
// keeps lengths and surfaces, takes no energy from nowhere, and finds what it finds at every tolerance.

#include <doctest/doctest.h>

#include "run.hpp"
#include "tumbling.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

struct Fate {
  Run run;
  double gained = 0.0;  // J, the most that energy grew from its lowest value
  double scale = 0.0;   // J
};

Fate tumble(const Network& net, double tolerance, double until) {
  constexpr int count = 60;
  const Reference shapes = surfaces_of(net);
  Simulation s = simulate(net, cvode(tolerance, {{"max_steps", 3000}}), until / count);
  const auto energy = [&] { return s.kinetic_energy() + s.potential_energy(); };
  Fate fate;
  double lowest = energy();
  for (int i = 1; i <= count; ++i) {
    s.advance_to(until * i / count);
    look(net, shapes, s, fate.run);
    auto& at = fate.run.positions.emplace_back();
    for (NodeIndex k = 0; k < s.node_count(); ++k) at.push_back(s.position(k));
    fate.scale = std::max({fate.scale, s.kinetic_energy(), std::abs(energy())});
    fate.gained = std::max(fate.gained, energy() - lowest);
    lowest = std::min(lowest, energy());
  }
  fate.run.events = s.events();
  return fate;
}

void check(const Network& net, double until) {
  std::vector<Fate> fates;
  for (const double tolerance : {1e-7, 1e-9}) {
    CAPTURE(tolerance);
    try {
      fates.push_back(tumble(net, tolerance, until));
    } catch (const std::exception& error) {
      FAIL_CHECK(std::string(error.what()));
      return;
    }
    const Fate& fate = fates.back();
    CHECK(fate.gained <= 1e3 * tolerance * fate.scale);  // a thousand steps
    CHECK(fate.run.stretch <= 1.001e-8);
    CHECK(fate.run.sink <= 1e-7);
    CHECK(fate.run.pull <= 1e-6);
    CHECK(fate.run.events.size() <= 200);
  }
  // A touch makes errors grow; a body that goes another way is off by centimetres.
  CHECK(greatest_distance(fates[0].run.positions, fates[1].run.positions) <= 1e-3);
}

}  // namespace

TEST_CASE("rigid bodies that tumble into grooves and between surfaces do not stop the reference") {
  for (const std::uint64_t seed :
       {23, 26, 27, 30, 44, 47, 56, 63, 84, 101, 113, 130, 131, 147, 156, 161, 170, 175, 184, 194}) {
    const Tumbling scene(seed);
    INFO(scene.name() << ", seed " << seed);
    check(scene.net, Tumbling::until);
  }
}
