// Rigid bodies in contact, where what one node's contact allows depends on those of the others: the network goes on,
// keeps lengths and surfaces, and takes no energy from nowhere.

#include <doctest/doctest.h>

#include "run.hpp"
#include "tumbling.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("rigid bodies that tumble onto surfaces do not stop the network") {
  const Way ways[] = {{"newton, theta 1", recurrent(newton, 1e-9), 1.0},
                      {"newton, theta 1/2", recurrent(newton, 1e-9, {{"theta", 0.5}}), 2.0},
                      {"block, theta 1", recurrent(block, 1e-9), 1.0}};
  for (const std::uint64_t seed : {0, 2, 11, 12, 17, 27, 37, 41, 47, 49, 50, 51, 56, 59}) {
    const Tumbling scene(seed);
    const Reference shapes = surfaces_of(scene.net);
    for (const Way& way : ways) {
      INFO(scene.name() << ", seed " << seed << ": " << way.name);
      Simulation s = simulate(scene.net, way.integrator, 0.0025);
      Run run;
      double lowest = s.kinetic_energy() + s.potential_energy(), gained = 0.0, scale = s.kinetic_energy();
      for (int i = 0; i < 600 && steps_on(s); ++i) {
        look(scene.net, shapes, s, run);
        const double energy = s.kinetic_energy() + s.potential_energy();
        scale = std::max(scale, s.kinetic_energy());
        gained = std::max(gained, energy - lowest);
        lowest = std::min(lowest, energy);
      }
      // Theta 1/2 keeps energy to the second order of a step.
      CHECK(gained <= 0.01 * scale);
      CHECK(run.stretch <= 1.001e-8);
      CHECK(run.sink <= 1e-7);
      CHECK(run.pull <= 1e-6);
    }
  }
}
