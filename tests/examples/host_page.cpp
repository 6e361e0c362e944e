// The code of examples/host/README.md does what it says.
#include <filesystem>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/simulation.hpp>

#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;

Vector3 best_pull(Simulation& simulation, NodeIndex node, const std::vector<Vector3>& forces, double time);
void run_with_file(Simulation& simulation, const std::filesystem::path& file, double until);

namespace {

Simulation hanging_chain() {
  Network net = testing::chain(4, {0, 0, 0}, {1, 0, 0}, testing::damped(40.0, 0.5));
  net.fix(0);
  net.set_gravity({0, 0, -10});
  SimulationOptions options;
  options.time_step = 0.05;
  return {net, testing::plugins(), options};
}

}  // namespace

TEST_CASE("the host's page: copies in threads find the best force") {
  Simulation simulation = hanging_chain();
  simulation.advance_to(0.2);
  const Vector3 before = simulation.position(3);
  const std::vector<Vector3> forces{{0, 0, 5}, {0, 0, 60}, {0, 0, -5}, {5, 0, 0}};
  CHECK(best_pull(simulation, 3, forces, 0.5) == forces[1]);
  CHECK(simulation.position(3) == before);
  CHECK(simulation.time() == doctest::Approx(0.2));
}

TEST_CASE("the host's page: a run that is ended goes on from its file") {
  const testing::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "run.state";
  Simulation whole = hanging_chain();
  run_with_file(whole, folder.path() / "whole.state", 4.0);
  Simulation first = hanging_chain();
  run_with_file(first, file, 2.0);
  Simulation second = hanging_chain();
  run_with_file(second, file, 4.0);
  CHECK(second.time() == whole.time());
  CHECK(second.steps() == whole.steps());
  CHECK(second.position(3) == whole.position(3));
}
