// What Newton's method takes from earlier steps may be useless: a step is then as good as without it.
#include <cmath>

#include <doctest/doctest.h>
#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double step = 0.01;

// A node on a spring whose tension is not finite beyond 0.7 of its length.
Network stiffening() {
  return oscillator(Material{LawUse{"exponential", {{"stiffness", 100}, {"exponent", 1000.0}}}, std::nullopt}, 1.0,
                    0.0);
}

Simulation at_rest() { return simulate(stiffening(), recurrent(newton, 1e-9), step); }

}  // namespace

TEST_CASE("a step whose guess has no finite forces starts from its start") {
  Simulation simulation = at_rest(), fresh = at_rest();
  for (int i = 0; i < 3; ++i) simulation.step();
  // 0.7 m in a step, or more if the change of velocity is extrapolated, too.
  for (Simulation* each : {&simulation, &fresh}) each->set_velocity(1, {70, 0, 0});
  CHECK(simulation.step().outcome == Outcome::settled);
  CHECK(fresh.step().outcome == Outcome::settled);
  CHECK((simulation.position(1) - fresh.position(1)).norm() <= 1e-12);
}
