#include "run/time_loop.hpp"

#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "nets.hpp"

using namespace springnet;

namespace {

// Tells what is asked of it: "a" to advance, "r" to record.
struct Told : Timeline {
  [[nodiscard]] double time() const override { return stage; }
  [[nodiscard]] bool has_ended() const override { return stage == last; }
  void advance() override {
    ++stage;
    told += 'a';
  }
  void record_if_due() override { told += 'r'; }

  int stage = 0, last = 3;
  std::string told;
};

}  // namespace

TEST_CASE("a timeline goes on to its end, and records after each stage") {
  Told timeline;
  CHECK(go_through(timeline, nullptr, [&] {
    timeline.told += '?';
    return true;
  }));
  CHECK(timeline.told == "ar?ar?ar?");
}

TEST_CASE("a timeline that is stopped has recorded its last stage") {
  Told timeline;
  CHECK_FALSE(go_through(timeline, nullptr, [&] { return timeline.stage < 2; }));
  CHECK(timeline.told == "arar");
  // At its end there is nothing left to stop.
  CHECK(go_through(timeline, nullptr, [] { return false; }));
  CHECK(timeline.told == "ararar");
}

TEST_CASE("a timeline waits for each stage, and can be stopped there") {
  Told timeline;
  double now = 0.0;
  Pace pace(1.0, 0.0, {[&] { return now; }, [&](double end) { now = end; }});
  CHECK_FALSE(go_through(timeline, &pace, [&] { return now < 1.5; }));
  CHECK(timeline.told == "arar");
  CHECK(pace.report().frames == 2);
  CHECK(pace.report().missed == 0);
}

TEST_CASE("steps end at the time step's multiples and at the end") {
  Simulation simulation =
      testing::simulate(testing::oscillator(testing::damped(4.0, 0.5), 1.0, 0.1), testing::single_sweep(), 0.25);
  double now = 0.0;
  Stepper stepper(simulation, {[&] { return now += 1.0; }, [](double) {}});
  std::vector<double> times;
  while (!stepper.has_reached(0.875)) {
    stepper.step(0.875);
    times.push_back(simulation.time());
  }
  CHECK(times == std::vector<double>{0.25, 0.5, 0.75, 0.875});
  CHECK(stepper.totals().wall == 4.0);  // each step looks at the clock before and after
  CHECK(stepper.totals().spring_updates == static_cast<double>(simulation.sweeps()));
  CHECK(stepper.totals().worst == Outcome::settled);
  CHECK(stepper.totals().unsettled == 0);
  // From there the multiples are others, and a remainder that is rounding is no step.
  stepper.advance_to(1.375);
  CHECK(simulation.time() == 1.375);
  stepper.advance_to(1.375 * (1.0 + 1e-9));
  CHECK(simulation.steps() == 6);
}

TEST_CASE("steps that do not settle are counted by their outcome, and those that throw by their work") {
  Network net = testing::oscillator(testing::damped(4000.0, 0.0), 1.0, 0.1);
  const auto stepped = [&](double policy) {
    auto simulation = std::make_unique<Simulation>(testing::simulate(
        net, testing::recurrent(testing::synchronous, 1e-9, {{"unsettled", policy}, {"max_sweeps", 20}}), 0.1));
    Stepper stepper(*simulation, or_machine({}));
    if (policy == testing::on_unsettled_error) {
      CHECK_THROWS_AS(stepper.advance_to(0.3), Error);
    } else {
      stepper.advance_to(0.3);
    }
    return std::pair(stepper.totals(), simulation->steps());
  };
  const auto [accepted, steps] = stepped(testing::on_unsettled_accept);
  CHECK(steps == 3);
  CHECK(accepted.unsettled == 3);
  CHECK(accepted.worst != Outcome::settled);
  const auto [failed, none] = stepped(testing::on_unsettled_error);
  CHECK(none == 0);
  CHECK(failed.spring_updates > 0.0);
  const auto [adapted, whole] = stepped(testing::on_unsettled_adapt);
  CHECK(adapted.divided == 3);
  CHECK(adapted.substeps >= 6);
  CHECK(adapted.worst == Outcome::settled);
}
