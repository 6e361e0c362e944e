// Events and steps as the program is told of them.

#include <doctest/doctest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include <springnet/error.hpp>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// A ball above a floor, and two nodes that fly apart until the spring between them breaks.
Network ball_and_pair() {
  Network net;
  net.add_node(point({5, 0, 0.1}, 1.0, {0, 0, -1}));
  net.add_node(point({0, 0, 3}, 1.0, {-1, 0, 0}));
  net.add_node(point({1, 0, 3}, 1.0, {1, 0, 0}));
  net.add_spring(1, 2, net.add_material({LawUse{"rupturing", {{"stiffness", 1.0}, {"strength", 0.4}}}, std::nullopt}));
  net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  return net;
}

bool same(const Event& a, const Event& b) {
  return a.kind == b.kind && a.time == b.time && a.index == b.index && a.element == b.element && a.surface == b.surface;
}

}  // namespace

TEST_CASE("callbacks get every event in order, and every step, at consistent states") {
  for (const LawUse& integrator : {recurrent(newton, 1e-10), LawUse{"verlet", {}}, cvode(1e-8), generalized_alpha()}) {
    CAPTURE(integrator.id);
    Simulation simulation = simulate(ball_and_pair(), integrator, 0.01);
    std::vector<Event> told;
    std::vector<double> steps;
    simulation.on_event([&](const Event& event) {
      told.push_back(event);
      CHECK(event.time <= simulation.time());
      CHECK(&event == &simulation.events()[told.size() - 1]);
      // What the event has done is done.
      if (event.kind == Event::Kind::ruptured) CHECK_FALSE(simulation.alive(event.index));
      if (event.kind == Event::Kind::touched) CHECK(simulation.touching(0));
    });
    simulation.on_step([&](const StepReport& report) {
      CHECK(&report == &simulation.last_report());
      CHECK(told.size() == simulation.events().size());  // events come first
      steps.push_back(simulation.time());
    });
    simulation.advance_to(0.5);
    CHECK(steps.size() == 50);
    CHECK(std::is_sorted(steps.begin(), steps.end()));
    CHECK(told.size() >= 2);
    REQUIRE(told.size() == simulation.events().size());
    for (std::size_t k = 0; k < told.size(); ++k) CHECK(same(told[k], simulation.events()[k]));
  }
}

TEST_CASE("callbacks do not change the motion") {
  Simulation silent = simulate(ball_and_pair(), recurrent(newton, 1e-10), 0.01);
  Simulation told = simulate(ball_and_pair(), recurrent(newton, 1e-10), 0.01);
  double sum = 0.0;
  told.on_event([&](const Event&) { sum += told.reactions().sum() + told.tensions().sum(); });
  told.on_step([&](const StepReport&) { sum += told.forces().sum() + told.energies().total(); });
  silent.advance_to(1.0);
  told.advance_to(1.0);
  CHECK(silent.positions() == told.positions());
  CHECK(silent.velocities() == told.velocities());
}

TEST_CASE("a cut by the program is told at once") {
  Simulation simulation = simulate(ball_and_pair(), cvode(1e-8), 0.01);
  std::vector<Event> told;
  simulation.on_event([&](const Event& event) { told.push_back(event); });
  CHECK(simulation.cut({0}) == 1);
  REQUIRE(told.size() == 1);
  CHECK(told[0].kind == Event::Kind::cut);
  CHECK(told[0].index == 0);
  simulation.on_event({});
  simulation.advance_to(0.5);
  CHECK(told.size() == 1);
  // What happened while nobody listened is no news.
  simulation.on_event([&](const Event& event) { told.push_back(event); });
  simulation.advance_to(0.51);
  CHECK(told.size() == 1);
}

TEST_CASE("a restored simulation is told what happens from then on") {
  Simulation simulation = simulate(ball_and_pair(), recurrent(newton, 1e-10), 0.01);
  const std::string start = simulation.save();
  std::vector<Event> told;
  simulation.on_event([&](const Event& event) { told.push_back(event); });
  simulation.advance_to(1.0);
  const std::size_t all = told.size();
  REQUIRE(all > 0);
  simulation.restore(start);
  CHECK(told.size() == all);
  simulation.advance_to(1.0);
  REQUIRE(told.size() == 2 * all);
  for (std::size_t k = 0; k < all; ++k) CHECK(same(told[k], told[all + k]));
}

TEST_CASE("exceptions of callbacks end the call, whose step is made; later events are told next time") {
  struct Stop : std::runtime_error {
    Stop() : std::runtime_error("stop") {}
  };
  Simulation simulation = simulate(ball_and_pair(), recurrent(newton, 1e-10), 0.01);
  Simulation other = simulate(ball_and_pair(), recurrent(newton, 1e-10), 0.01);
  std::vector<Event> told;
  simulation.on_event([&](const Event& event) {
    told.push_back(event);
    throw Stop();
  });
  std::size_t thrown = 0;
  for (int k = 0; k < 100; ++k) {
    const std::uint64_t steps = simulation.steps();
    try {
      simulation.step();
    } catch (const Stop&) {
      ++thrown;
    }
    CHECK(simulation.steps() == steps + 1);
    other.step();
    CHECK(simulation.time() == other.time());
    CHECK(simulation.positions() == other.positions());
  }
  CHECK(thrown == other.events().size());
  CHECK(told.size() == other.events().size());
}

TEST_CASE("a callback cannot step or change the simulation") {
  Simulation simulation = simulate(ball_and_pair(), recurrent(newton, 1e-10), 0.01);
  std::size_t refused = 0;
  const auto is_refused = [&](const auto& change) {
    try {
      change();
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::input);
      CHECK(std::string(error.what()).find("callbacks") != std::string::npos);
      ++refused;
    }
  };
  simulation.on_step([&](const StepReport&) {
    is_refused([&] { simulation.step(); });
    is_refused([&] { simulation.advance_to(10.0); });
    is_refused([&] { simulation.cut({0}); });
    is_refused([&] { simulation.set_force(0, {1, 0, 0}); });
    is_refused([&] { simulation.set_position(0, {1, 0, 5}); });
    is_refused([&] { static_cast<void>(simulation.save()); });
    is_refused([&] { simulation.on_step({}); });
    is_refused([&] { simulation.keep_snapshots(); });
    static_cast<void>(simulation.between(simulation.time()));  // reads
  });
  simulation.step();
  CHECK(refused == 8);
  simulation.on_step({});
  simulation.set_force(0, {1, 0, 0});
  simulation.step();
}

TEST_CASE("go_on ends advance_to after a step") {
  Simulation simulation = simulate(ball_and_pair(), recurrent(newton, 1e-10), 0.01);
  int asked = 0;
  simulation.advance_to(1.0, [&] { return ++asked < 7; });
  CHECK(asked == 7);
  CHECK(simulation.steps() == 7);
  CHECK(simulation.time() == 7 * 0.01);
  CHECK(simulation.last_report().steps == 7);
  // It goes on as if it had never stopped, and shortens the last step.
  asked = 0;
  simulation.advance_to(0.105, [&] { return ++asked > 0; });
  CHECK(asked == 4);  // after the last one too
  CHECK(simulation.time() == 0.105);
  Simulation straight = simulate(ball_and_pair(), recurrent(newton, 1e-10), 0.01);
  straight.advance_to(0.105);
  CHECK(simulation.positions() == straight.positions());
  CHECK_THROWS_AS(simulation.advance_to(1.0, std::function<bool()>{}), Error);
  CHECK_THROWS_AS(simulation.advance_to(1.0, []() -> bool { throw std::runtime_error("stop"); }), std::runtime_error);
  CHECK(simulation.time() == doctest::Approx(0.115));
}
