// Real time, with a clock that the test sets.
#include "run/pace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::plugins;
using testing::TemporaryFolder;

namespace {

// Advances only while it sleeps and when the test adds to it. Times are sums of powers of two, so nothing is rounded.
struct FakeClock {
  double time = 1024.0;      // s
  double per_call = 0.0;     // s that pass with each call of now()
  std::vector<double> ends;  // arguments of sleep_until()

  RunClock clock() {
    return {[this] { return time += per_call; },
            [this](double end) {
              ends.push_back(end);
              time = std::max(time, end);
            }};
  }
};

bool always() { return true; }

// A fixed node and one that hangs from it; a time step of 1/16 s.
Scene hanging(double duration) {
  Scene scene;
  scene.network = testing::oscillator(testing::damped(4.0, 0.5), 1.0, 0.0);
  scene.network.set_gravity({1, 0, 0});
  scene.duration = duration;
  scene.options.time_step = 0.0625;
  scene.options.threads = 1;
  return scene;
}

}  // namespace

TEST_CASE("a step starts when it is due, and is late when it ends after the next one is due") {
  FakeClock fake;
  Pace pace(1.0, 0.0, fake.clock());
  CHECK(pace.wait(0.0, always));  // starts the clock
  CHECK(fake.ends.empty());
  fake.time += 0.015625;  // done in time
  pace.count_frame(0.0625);
  CHECK(pace.wait(0.0625, always));
  CHECK(fake.time == 1024.0625);
  fake.time += 0.25;  // due at 0.125 s, done at 0.3125 s
  pace.count_frame(0.125);
  CHECK(pace.report().frames == 2);
  CHECK(pace.report().missed == 1);
  CHECK(pace.report().greatest_delay == 0.1875);

  // The next one starts at once and is late as well, though it takes no time; then it has caught up.
  const std::size_t sleeps = fake.ends.size();
  CHECK(pace.wait(0.125, always));
  pace.count_frame(0.1875);
  CHECK(pace.wait(0.1875, always));
  CHECK(fake.ends.size() == sleeps);
  CHECK(pace.report().missed == 2);
  pace.count_frame(0.5);
  CHECK(pace.wait(0.5, always));
  CHECK(fake.time == 1024.5);
  CHECK(pace.report().frames == 4);
  CHECK(pace.report().missed == 2);
  CHECK(pace.report().greatest_delay == 0.1875);
}

TEST_CASE("a factor stretches the times that are due, also from a start that is not 0") {
  FakeClock fake;
  Pace pace(0.5, 8.0, fake.clock());
  CHECK(pace.wait(8.0, always));
  CHECK(pace.wait(8.03125, always));
  CHECK(fake.time == 1024.0625);
  pace.count_frame(8.0625);  // due at 0.125 s
  CHECK(pace.report().missed == 0);
  fake.time = 1024.25;
  pace.count_frame(8.0625);
  CHECK(pace.report().missed == 1);
  CHECK(pace.report().greatest_delay == 0.125);
}

TEST_CASE("a long wait can be stopped") {
  FakeClock fake;
  Pace pace(1.0, 0.0, fake.clock());
  CHECK(pace.wait(0.0, always));
  int calls = 0;
  CHECK_FALSE(pace.wait(3600.0, [&] { return ++calls < 7; }));
  CHECK(calls == 7);
  // At most a tenth of a second passes between two calls; sums of tenths are rounded.
  CHECK(fake.time == doctest::Approx(1024.7).epsilon(1e-12));
}

TEST_CASE("a factor that is not a number above 0 is refused before anything is written") {
  const TemporaryFolder folder;
  for (const double factor : {-1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    RunOptions options{folder.path() / "new", "pair", {}};
    options.realtime = factor;
    CHECK_THROWS_AS(run_scene(hanging(1.0), plugins(), options), Error);
    CHECK_FALSE(std::filesystem::exists(folder.path() / "new"));
  }
}

TEST_CASE("a run that is fast enough waits for each step, misses none and computes the same") {
  const TemporaryFolder folder;
  FakeClock fake;
  const Scene scene = hanging(1.0);
  RunOptions options{folder.path() / "paced", "pair", {}};
  options.realtime = 2.0;
  options.clock = fake.clock();
  const RunSummary summary = run_scene(scene, plugins(), options);
  REQUIRE(summary.pace);
  CHECK(summary.pace->frames == 16);
  CHECK(summary.pace->missed == 0);
  CHECK(summary.pace->greatest_delay == 0.0);
  CHECK(summary.pace->factor == 2.0);
  // Step k begins at k/16 s of the simulation, k/32 s of the clock; the first one does not wait.
  REQUIRE(fake.ends.size() == 15);
  for (std::size_t k = 0; k < 15; ++k) CHECK(fake.ends[k] == 1024.0 + static_cast<double>(k + 1) / 32.0);

  run_scene(scene, plugins(), {folder.path() / "free", "pair", {}});
  CHECK(testing::read_text(folder.path() / "paced/trajectory.csv") ==
        testing::read_text(folder.path() / "free/trajectory.csv"));

  const auto json = nlohmann::json::parse(testing::read_text(folder.path() / "paced/summary.json"));
  CHECK(json["pace"]["frames"] == 16);
  CHECK(json["pace"]["missed_frames"] == 0);
  CHECK(json["pace"]["frames_per_s"] == 32.0);
  CHECK(json["pace"]["factor"] == 2.0);
  CHECK(nlohmann::json::parse(testing::read_text(folder.path() / "free/summary.json"))["pace"].is_null());
}

TEST_CASE("a run that is too slow makes every step, counts them as missed and does not sleep") {
  const TemporaryFolder folder;
  FakeClock fake;
  fake.per_call = 0.125;  // two time steps, and the clock is read more than once per step
  RunOptions options{folder.path(), "pair", {}};
  options.realtime = 1.0;
  options.clock = fake.clock();
  const RunSummary summary = run_scene(hanging(1.0), plugins(), options);
  REQUIRE(summary.pace);
  CHECK(summary.steps == 16);
  CHECK(summary.pace->frames == 16);
  CHECK(summary.pace->missed == 16);
  // The delay grows by a sixteenth at least with each of 16 steps.
  CHECK(summary.pace->greatest_delay >= 1.0);
  CHECK(fake.ends.empty());
  // Wall time is measured from before to after each of the 16 steps.
  CHECK(summary.wall == 16 * 0.125);
  const auto json = nlohmann::json::parse(testing::read_text(folder.path() / "summary.json"));
  CHECK(json["times_real_time"] == 0.5);
}

TEST_CASE("a run that waits for the clock can be stopped, with all that was written kept") {
  const TemporaryFolder folder;
  FakeClock fake;
  RunOptions options{folder.path(), "pair", {}};
  options.realtime = 1.0 / 1024.0;  // a time step takes 64 s
  options.clock = fake.clock();
  // Stops within the wait for the third step.
  options.progress = [&](const RunProgress&) { return fake.time < 1024.0 + 64.0 + 32.0; };
  const RunSummary summary = run_scene(hanging(1.0), plugins(), options);
  CHECK(summary.outcome == "stopped");
  CHECK_FALSE(summary.failure);
  CHECK(summary.steps == 2);
  CHECK(summary.records == 3);
  CHECK(summary.pace->frames == 2);
  CHECK(nlohmann::json::parse(testing::read_text(folder.path() / "summary.json"))["outcome"] == "stopped");
}
