// Simulation::set_integrator(): another integrator goes on from the present state.

#include <string>

#include <doctest/doctest.h>

#include <springnet/error.hpp>

#include "mixed_net.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Everything as in MixedNet's base at the state of a simulation.
Network at_state(const MixedNet& net, const Simulation& simulation) { return net.built(simulation); }

}  // namespace

TEST_CASE("every integrator goes on where another one has been, as one that starts there") {
  const auto all = all_integrators();
  MixedNet net(true, 3);
  Simulation simulation = simulate(net.base(), all.front().first, 0.002);
  for (std::size_t i = 0; i < all.size(); ++i) {
    // In an order in which each kind follows each other.
    const LawUse& integrator = all[(7 * i + 3) % all.size()].first;
    CAPTURE(integrator.id);
    simulation.set_integrator(integrator);
    Simulation fresh = simulate(at_state(net, simulation), integrator, 0.002);
    for (int k = 0; k < 5; ++k) {
      simulation.step();
      fresh.step();
    }
    CHECK(distance(simulation, fresh) < 1e-8);
  }
  CHECK(simulation.steps() >= 5 * all.size());  // cvode counts its own
  CHECK(simulation.time() == doctest::Approx(0.002 * 5 * double(all.size())));
}

TEST_CASE("an integrator that does not exist, or does not fit, leaves the one that is there") {
  const MixedNet net(true, 3);
  Simulation own = simulate(net.base(), recurrent(synchronous, 1e-9), 0.002);
  Simulation other = simulate(net.base(), recurrent(synchronous, 1e-9), 0.002);
  own.step();
  other.step();
  CHECK_THROWS_AS(own.set_integrator({"cvod", {}}), Error);
  CHECK_THROWS_AS(own.set_integrator({"verlet", {{"substeps", -1.0}}}), Error);
  other.drop_history();
  own.drop_history();
  for (int i = 0; i < 4; ++i) {
    CHECK(distance(own, other) == 0.0);
    own.step();
    other.step();
  }
}

TEST_CASE("a saved state has the integrator, and an earlier one takes the exchange back") {
  const MixedNet net(true, 3);
  Simulation simulation = simulate(net.base(), recurrent(newton, 1e-10), 0.002);
  simulation.step();
  const std::string early = simulation.save();
  simulation.set_integrator(cvode(1e-8));
  simulation.step();
  const std::string late = simulation.save();
  Simulation other = simulate(net.base(), recurrent(newton, 1e-10), 0.002);
  other.restore(late);
  for (int i = 0; i < 3; ++i) {
    CHECK(distance(simulation, other) == 0.0);
    simulation.step();
    other.step();
  }
  other.restore(early);
  Simulation plain = simulate(net.base(), recurrent(newton, 1e-10), 0.002);
  plain.restore(early);
  for (int i = 0; i < 3; ++i) {
    CHECK(distance(plain, other) == 0.0);
    plain.step();
    other.step();
  }
}
