#include "run/time_loop.hpp"

#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "nets.hpp"

using namespace springnet;

namespace {

// Logs its calls: "a" for advance(), "r" for record_if_due().
struct LoggedTimeline : Timeline {
  [[nodiscard]] double time() const override { return stage; }
  [[nodiscard]] bool has_ended() const override { return stage == last; }
  void advance() override {
    ++stage;
    log += 'a';
  }
  void record_if_due() override { log += 'r'; }

  int stage = 0, last = 3;
  std::string log;
};

}  // namespace

TEST_CASE("a timeline advances to its end, and records after each stage") {
  LoggedTimeline timeline;
  CHECK(advance_to_end(timeline, nullptr, [&] {
    timeline.log += '?';
    return true;
  }));
  CHECK(timeline.log == "ar?ar?ar?");
}

TEST_CASE("a timeline that is stopped has recorded its last stage") {
  LoggedTimeline timeline;
  CHECK_FALSE(advance_to_end(timeline, nullptr, [&] { return timeline.stage < 2; }));
  CHECK(timeline.log == "arar");
  // At its end there is nothing left to stop.
  CHECK(advance_to_end(timeline, nullptr, [] { return false; }));
  CHECK(timeline.log == "ararar");
}

TEST_CASE("a timeline waits for each stage, and can be stopped there") {
  LoggedTimeline timeline;
  double now = 0.0;
  Pace pace(1.0, 0.0, {[&] { return now; }, [&](double end) { now = end; }});
  CHECK_FALSE(advance_to_end(timeline, &pace, [&] { return now < 1.5; }));
  CHECK(timeline.log == "arar");
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
  CHECK(stepper.totals().wall == 4.0);  // each step reads the clock before and after
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
    Stepper stepper(*simulation, clock_or_system({}));
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
