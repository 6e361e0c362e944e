// The time step at which the synchronous update rule stops settling, against closed forms and against the rule itself.
#include <cmath>
#include <memory>
#include <numbers>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/inspection.hpp>
#include <springnet/simulation.hpp>

#include "nets.hpp"

using namespace springnet;
using testing::plugins;

namespace {

// Nodes 1 m apart along x, springs between neighbours; both ends fixed or free.
Network line(std::uint32_t nodes, double mass, double stiffness, double damping, bool fixed_ends) {
  Network network = testing::chain(nodes, Vector3::Zero(), Vector3::UnitX(), testing::damped(stiffness, damping), mass);
  if (fixed_ends) {
    network.fix(0);
    network.fix(nodes - 1);
  }
  return network;
}

double limit_of(const Network& network) {
  const auto limit = inspect(network, *plugins()).synchronous_time_constant;
  REQUIRE(limit);
  return *limit;
}

bool settles(const Network& network, double time_step) {
  Simulation simulation = testing::simulate(network, testing::recurrent(testing::synchronous, 0.0), time_step);
  try {
    simulation.step();
    return true;
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::simulation);
    return false;
  }
}

// Power iteration ends when its estimate moves by three millionths; what is left is less than a thousandth.
constexpr double tolerance = 1e-3;

}  // namespace

TEST_CASE("one node between two fixed ones: t^2 2 k / m + t 2 d / m = 1") {
  CHECK(limit_of(line(3, 2.0, 9.0, 0.0, true)) == doctest::Approx(std::sqrt(2.0 / 18.0)).epsilon(tolerance));
  const double k = 2.0 * 9.0 / 2.0, d = 2.0 * 3.0 / 2.0;
  CHECK(limit_of(line(3, 2.0, 9.0, 3.0, true)) ==
        doctest::Approx((-d + std::sqrt(d * d + 4.0 * k)) / (2.0 * k)).epsilon(tolerance));
}

TEST_CASE("a free pair moves against itself: t^2 2 k / m = 1") {
  CHECK(limit_of(line(2, 0.5, 4.0, 0.0, false)) == doctest::Approx(std::sqrt(0.5 / 8.0)).epsilon(tolerance));
}

TEST_CASE("a fixed chain of n nodes: the greatest eigenvalue is 4 k / m sin^2(n pi / (2 n + 2))") {
  const std::uint32_t free_nodes = 20;
  const double sine = std::sin(free_nodes * std::numbers::pi / (2.0 * free_nodes + 2.0));
  const double eigenvalue = 4.0 * 50.0 / 0.1 * sine * sine;
  CHECK(limit_of(line(free_nodes + 2, 0.1, 50.0, 0.0, true)) ==
        doctest::Approx(1.0 / std::sqrt(eigenvalue)).epsilon(tolerance));
}

TEST_CASE("a viscous net has a limit too: t 2 d / m = 1") {
  Network network = line(2, 1.0, 1.0, 1.0, false);
  network.set_spring_material(0, network.add_material({std::nullopt, LawUse{"linear", {{"damping", 5.0}}}}));
  CHECK(limit_of(network) == doctest::Approx(0.1).epsilon(tolerance));
}

TEST_CASE("below the limit the synchronous rule settles, above it does not") {
  Network network;
  const MaterialIndex material =
      network.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, LawUse{"linear", {{"damping", 2.0}}}});
  network.add_lattice("cube", {{4, 4, 4}, Vector3::Ones(), Vector3::Zero(), Diagonals::space}, {}, material);
  for (NodeIndex node = 0; node < 16; ++node) network.fix(node);
  network.set_gravity({0.0, 0.0, -0.2});
  const double limit = limit_of(network);
  CHECK(settles(network, 0.95 * limit));
  CHECK_FALSE(settles(network, 1.05 * limit));
}

TEST_CASE("without springs there is no limit") {
  Network network;
  network.add_node({});
  CHECK_FALSE(inspect(network, *plugins()).synchronous_time_constant);
}
