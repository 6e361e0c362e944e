// Rigid bodies in contact, where the contacts of the nodes depend on one another: the network goes on, keeps lengths
// and surfaces, and gains no energy.

#include <doctest/doctest.h>
#include <initializer_list>

#include "run.hpp"
#include "tumbling.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("rigid bodies that tumble onto surfaces do not stop the network") {
  const Scheme schemes[] = {{"newton, theta 1", recurrent(newton, 1e-9), 1.0},
                            {"newton, theta 1/2", recurrent(newton, 1e-9, {{"theta", 0.5}}), 2.0},
                            {"block, theta 1", recurrent(block, 1e-9), 1.0}};
  for (const auto seed : std::initializer_list<std::uint64_t>{0, 2, 11, 12, 17, 27, 37, 41, 47, 49, 50, 51, 56, 59}) {
    const Tumbling scene(seed);
    const Reference shapes = surfaces_of(scene.net);
    for (const Scheme& scheme : schemes) {
      INFO(scene.name() << ", seed " << seed << ": " << scheme.name);
      Simulation s = simulate(scene.net, scheme.integrator, 0.0025);
      Run run;
      double lowest = s.kinetic_energy() + s.potential_energy(), gained = 0.0, scale = s.kinetic_energy();
      for (int i = 0; i < 600 && steps_on(s); ++i) {
        record_violations(scene.net, shapes, s, run);
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

TEST_CASE("no obstacle pulls at rigid bodies that tumble, by a force or by an impulse") {
  std::vector<Scheme> schemes = {{"verlet", {"verlet", {}}, 2.0}, {"generalized_alpha", generalized_alpha(), 2.0}};
  for (const double theta : {1.0, 0.5})
    for (const double events : {0.0, 1.0})
      schemes.push_back({"theta " + std::to_string(theta) + ", events " + std::to_string(events),
                         recurrent(newton, 1e-9, {{"theta", theta}, {"events", events}}), theta == 1.0 ? 1.0 : 2.0});
  for (const auto seed : std::initializer_list<std::uint64_t>{26, 27, 37}) {  // in a groove, on a plane
    const Tumbling scene(seed);
    const std::vector<Plane>& planes = scene.net.planes();
    for (const Scheme& scheme : schemes) {
      INFO(scene.name() << ", seed " << seed << ": " << scheme.name);
      Simulation s = simulate(scene.net, scheme.integrator, 0.0025);
      double pull = 0.0, pull_impulse = 0.0;  // N, N s, the greatest
      std::size_t seen = 0;
      for (int i = 0; i < 600 && steps_on(s); ++i) {
        for (std::size_t j = 0; j < planes.size(); ++j)
          pull = std::max(pull, planes[j].normal.normalized().dot(s.surface_force(j)));
        for (; seen < s.events().size(); ++seen) {
          const Event& event = s.events()[seen];
          if (event.kind != Event::Kind::touched || static_cast<std::size_t>(event.surface) >= planes.size()) continue;
          const Plane& plane = planes[static_cast<std::size_t>(event.surface)];
          pull_impulse = std::max(pull_impulse, -plane.normal.normalized().dot(event.impulse));
        }
      }
      CHECK(seen > 0);
      // Rounding of forces of some 10 N.
      CHECK(pull <= 1e-9);
      CHECK(pull_impulse <= 1e-12);
    }
  }
}
