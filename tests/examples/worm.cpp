// examples/worm: signals activate muscles, and friction makes the worm crawl.
#include "course.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr NodeIndex nodes = 52;

double centre(const Simulation& simulation) { return positions_of(simulation).row(0).mean(); }

}  // namespace

TEST_CASE("the worm crawls ahead, as far as in the reference") {
  const Scene scene = example("worm/worm.toml", {"simulation.duration=2"});
  const Simulation network = run(scene, [](const Simulation&) {});
  const Simulation reference =
      run(example("worm/worm.toml", {"simulation.duration=2", in_cvode}), [](const Simulation&) {});
  REQUIRE(network.node_count() == nodes);
  // From 12 cm: 1.5 cm in the first second, while it shortens about its centre, and 1.6 cm in each that follows.
  CHECK(centre(network) > 0.145);
  CHECK(centre(network) == doctest::Approx(centre(reference)).epsilon(0.01));
  // Each contraction takes nearly a third of the length away.
  const auto length = [](const Simulation& simulation) {
    const Positions at = positions_of(simulation);
    return at.row(0).maxCoeff() - at.row(0).minCoeff();
  };
  CHECK(length(network) == doctest::Approx(length(reference)).epsilon(0.01));
  CHECK(length(network) < 0.18);
}

TEST_CASE("without signals the worm stays where it is, and with the wave reversed it crawls back") {
  const Scene scene = example("worm/worm.toml", {"simulation.duration=2"});
  Simulation resting(scene.network, plugins(), scene.options);
  for (InputIndex k = 0; k < 12; ++k) resting.set_input(k, 0.0);
  resting.advance_to(1.0);
  CHECK(centre(resting) == doctest::Approx(0.12).epsilon(1e-3));

  std::vector<std::string> reversed{"simulation.duration=2"};
  for (int k = 0; k < 12; ++k) {
    const double phase = -scene.network.inputs()[static_cast<std::size_t>(k)].signal.phase;
    reversed.push_back("input." + std::to_string(k) + ".sinusoid.phase=" + std::to_string(phase));
  }
  const Simulation back = run(example("worm/worm.toml", reversed), [](const Simulation&) {});
  CHECK(centre(back) < 0.12);
}
