// The block of examples/host/README.md, "Changes while it runs".

#include <doctest/doctest.h>

#include "nets.hpp"

using namespace springnet;

namespace {
#include "changes.inl"
}  // namespace

TEST_CASE("the block of the page does what it says") {
  Network net = springnet::testing::cube(200.0, 1.0, 0.0, 1.0);
  Simulation simulation =
      springnet::testing::simulate(net, springnet::testing::recurrent(springnet::testing::newton, 1e-8), 0.01);
  simulation.step();
  treat(simulation);
  CHECK(simulation.parameter(2, ComponentKind::spring_function, "stiffness") == 300.0);
  CHECK(simulation.rest_length(3) == 0.9);
  CHECK(simulation.mass(5) == 2.0);
  simulation.step();
  const std::size_t springs = simulation.spring_count();
  suture(simulation, 0, 63);
  CHECK(simulation.spring_count() == springs + 5);
  CHECK(simulation.tension(static_cast<SpringIndex>(springs)) == doctest::Approx(0.0).epsilon(1e-9));
  go_on(simulation);
  for (int i = 0; i < 10; ++i) simulation.step();
  CHECK(simulation.time() == doctest::Approx(0.12));
}
