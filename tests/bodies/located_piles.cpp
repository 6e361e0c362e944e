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
      // Steps of `verlet` take impacts, at 1 m/s, to be somewhere in them: 2e-5 m.
      for (const NodeIndex first : {0u, 27u})
        CHECK(std::abs(mean_height(s, first, 27) - mean_height(explicit_steps, first, 27)) <= 5e-5);
    }
    // They meet at 0.08 s. Forces that alternate between pairs take at least five times as many.
    CHECK(s.statistics().at("restarts") <= (mu > 0.0 ? 4000.0 : 1000.0));
    const auto events = count_events(s);
    CHECK(events.met >= 50);
  }
}
