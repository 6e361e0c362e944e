// Profiles and traces: where the time of a simulation goes.

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <springnet/profile.hpp>

#include "nets.hpp"
#include "profile/recording.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

using Kind = ProfileStage::Kind;

// Falls on a floor, held by a spring.
Network falling_block(std::uint32_t side) {
  Lattice lattice;
  lattice.nodes = {side, side, side};
  Network net;
  net.add_lattice("block", lattice, point(Vector3::Zero(), 1.0, {0.4, 0.1, -0.2}), net.add_material(damped(50.0, 1.0)));
  net.add_element(Invariant::angle, {0, 1, 2}, net.add_material(damped(0.1, 0.0)), 1.0);
  net.set_gravity({0.3, 0, -1.0});
  net.add_plane({});
  return net;
}

struct Run {
  std::vector<Vector3> states;  // positions and velocities
  Profile profile;
  nlohmann::json trace;
};

Run run(const Network& net, const LawUse& integrator, unsigned threads, const std::shared_ptr<Profiler>& profiler,
        int steps = 4) {
  SimulationOptions options;
  options.time_step = 0.01;
  options.integrator = integrator;
  options.threads = threads;
  options.profiler = profiler;
  Simulation simulation(net, plugins(), options);
  for (int i = 0; i < steps; ++i) simulation.step();
  Run run;
  for (NodeIndex k = 0; k < simulation.node_count(); ++k) {
    run.states.push_back(simulation.position(k));
    run.states.push_back(simulation.velocity(k));
  }
  if (!profiler) return run;
  run.profile = profiler->profile();
  std::ostringstream text;
  profiler->write_trace(text);
  run.trace = nlohmann::json::parse(text.str());
  return run;
}

const ProfileStage* find(const Profile& profile, const std::string& label) {
  const auto found = std::find_if(profile.stages.begin(), profile.stages.end(),
                                  [&](const ProfileStage& stage) { return label_of(stage) == label; });
  return found == profile.stages.end() ? nullptr : &*found;
}

// Names of the stages that have a part of this name. Which comes first is a matter of their times.
std::set<std::string> parents_of(const Profile& profile, const std::string& label) {
  std::set<std::string> names;
  for (const ProfileStage& stage : profile.stages)
    if (label_of(stage) == label) names.insert(profile.stages[static_cast<std::size_t>(stage.parent)].name);
  return names;
}

void check_adds_up(const Profile& profile) {
  double top = 0.0, own = 0.0;
  std::vector<double> parts(profile.stages.size(), 0.0);
  for (std::size_t k = 0; k < profile.stages.size(); ++k) {
    const ProfileStage& stage = profile.stages[k];
    CAPTURE(label_of(stage));
    CHECK(stage.calls > 0);
    CHECK(stage.seconds >= 0.0);
    CHECK(stage.own_seconds >= 0.0);
    CHECK(stage.parent < static_cast<std::ptrdiff_t>(k));
    own += stage.own_seconds;
    (stage.parent < 0 ? top : parts[static_cast<std::size_t>(stage.parent)]) += stage.seconds;
  }
  CHECK(profile.seconds > 0.0);
  CHECK(top == doctest::Approx(profile.seconds).epsilon(1e-9));
  CHECK(own == doctest::Approx(profile.seconds).epsilon(1e-9));
  for (std::size_t k = 0; k < profile.stages.size(); ++k) {
    CAPTURE(label_of(profile.stages[k]));
    CHECK(parts[k] <= profile.stages[k].seconds * (1.0 + 1e-9) + 1e-12);
  }
}

// Complete events, in order of time, each within the ones around it.
void check_trace(const nlohmann::json& trace) {
  std::map<int, std::vector<double>> ends;  // of the stages that are open, of each thread
  std::map<int, double> last;
  for (const auto& event : trace.at("traceEvents")) {
    if (event.at("ph") != "X") continue;
    const int thread = event.at("tid");
    const double begin = event.at("ts"), end = begin + event.at("dur").get<double>();
    CHECK(begin >= last[thread]);
    last[thread] = begin;
    constexpr double rounding = 1e-6;  // us, of ts + dur
    std::vector<double>& open = ends[thread];
    while (!open.empty() && open.back() <= begin + rounding) open.pop_back();
    if (!open.empty()) CHECK(end <= open.back() + rounding);
    open.push_back(end);
  }
}

std::size_t count_of(const nlohmann::json& trace, const std::string& name) {
  const auto& events = trace.at("traceEvents");
  return static_cast<std::size_t>(std::count_if(events.begin(), events.end(), [&](const nlohmann::json& event) {
    return event.at("ph") == "X" && event.at("name") == name;
  }));
}

}  // namespace

TEST_CASE("a profile has the stages of each integrator, and its times add up") {
  const Network net = falling_block(5);
  struct Expected {
    LawUse integrator;
    std::vector<std::string> stages;
  };
  const std::vector<Expected> all{
      {recurrent(synchronous, 1e-6), {"integrator recurrent", "begin", "sweep", "commit", "impulses", "update"}},
      {recurrent(wavefront, 1e-6), {"integrator recurrent", "begin", "sweep", "commit", "update", "constraints"}},
      {recurrent(coloured, 1e-6), {"integrator recurrent", "begin", "sweep", "commit"}},
      {recurrent(newton, 1e-6), {"integrator recurrent", "begin", "linearise", "commit"}},
      {{"verlet", {}}, {"integrator verlet", "begin", "evaluate", "constrain", "commit"}},
      {cvode(1e-6), {"integrator cvode", "begin", "evaluate", "linearise", "factorise", "solve", "events", "commit"}}};
  for (const Expected& expected : all) {
    CAPTURE(expected.stages.front());
    const Run found = run(net, expected.integrator, 1, std::make_shared<Profiler>());
    check_adds_up(found.profile);
    for (const std::string& name : expected.stages) {
      CAPTURE(name);
      CHECK(find(found.profile, name) != nullptr);
    }
    for (const char* law : {"spring function linear", "viscosity function linear", "neuron point_mass"}) {
      CAPTURE(law);
      REQUIRE(find(found.profile, law) != nullptr);
      CHECK(find(found.profile, law)->estimated);
    }
    const ProfileStage& step = found.profile.stages.front();
    CHECK(step.name == "step");
    CHECK(step.calls == 4);
    CHECK(!step.estimated);
    const ProfileStage& integrator = *find(found.profile, expected.stages.front());
    CHECK(integrator.parent == 0);
    CHECK(integrator.calls == 4);
  }
}

TEST_CASE("results are the same bits with a profiler") {
  const Network net = falling_block(5);
  for (const LawUse& integrator : {recurrent(synchronous, 1e-6), recurrent(wavefront, 1e-6), recurrent(newton, 1e-6),
                                   LawUse{"verlet", {}}, cvode(1e-6)}) {
    CAPTURE(integrator.id);
    CHECK(run(net, integrator, 1, std::make_shared<Profiler>(1000)).states == run(net, integrator, 1, nullptr).states);
  }
}

TEST_CASE("several threads: the times of their parts are means, and what is left is waiting") {
  const Network net = falling_block(21);  // two units of the layout
  for (const double update : {synchronous, coloured}) {
    const LawUse integrator{"recurrent", {{"update", update}, {"sweeps", 3}}};
    const auto profiler = std::make_shared<Profiler>(10000);
    const Run found = run(net, integrator, 2, profiler);
    check_adds_up(found.profile);
    CHECK(parents_of(found.profile, "wait for threads").contains("sweep"));
    CHECK(parents_of(found.profile, "spring function linear").contains("springs"));
    check_trace(found.trace);
    std::set<int> threads;
    for (const auto& event : found.trace.at("traceEvents"))
      if (event.at("ph") == "X") threads.insert(event.at("tid").get<int>());
    CHECK(threads == std::set<int>{0, 1});
    CHECK(found.states == run(net, integrator, 2, nullptr).states);
  }
}

TEST_CASE("the time of a part in threads is the mean of theirs") {
  profile::Recording recording(0, {});
  REQUIRE(recording.prepare(2));
  profile::Lane &first = recording.first(), &second = recording.lane(1);
  const auto work = [](profile::Lane& lane, std::uint32_t region, int rounds) {
    REQUIRE(lane.begin_share(region, 2));
    REQUIRE(lane.begin(Kind::stage, "work"));
    const profile::Nanoseconds begin = profile::now();
    while (profile::now() < begin + rounds * 100000) {
    }
    lane.end();
    const profile::Nanoseconds time = lane.nodes().back().time;
    lane.end_share(profile::none);
    return time;
  };
  REQUIRE(first.begin(Kind::stage, "sweep"));
  REQUIRE(first.begin_region());
  const std::uint32_t region = first.present();
  const profile::Nanoseconds sum = work(first, region, 1) + work(second, region, 3);
  first.end_region();
  first.end();
  const Profile profile = recording.merged();
  check_adds_up(profile);
  REQUIRE(find(profile, "work") != nullptr);
  CHECK(find(profile, "work")->seconds == doctest::Approx(0.5e-9 * static_cast<double>(sum)).epsilon(1e-9));
  CHECK(find(profile, "work")->calls == 2);
  // One after the other here: each waits for half of the time, or more if other programs come between.
  CHECK(find(profile, "wait for threads")->seconds >= 0.4999e-9 * static_cast<double>(sum));
}

TEST_CASE("the calls of parts of tiles are estimated within their scatter") {
  const LawUse integrator{"recurrent", {{"update", synchronous}, {"sweeps", 50}}};
  const Profile profile = run(falling_block(5), integrator, 1, std::make_shared<Profiler>(), 400).profile;
  const ProfileStage& springs = *find(profile, "springs");
  const ProfileStage& sweep = profile.stages[static_cast<std::size_t>(springs.parent)];
  REQUIRE(sweep.name == "sweep");
  CHECK(sweep.calls == 20000);
  // 125 nodes are two tiles. Of the 40,000 about 1 in 256 is measured, 156, which scatter by 5 %.
  CHECK(static_cast<double>(springs.calls) / static_cast<double>(sweep.calls) == doctest::Approx(2.0).epsilon(0.16));
}

TEST_CASE("a trace has a complete event for each stage") {
  const Run found = run(falling_block(4), recurrent(synchronous, 1e-6), 1, std::make_shared<Profiler>(100000));
  check_trace(found.trace);
  CHECK(found.trace.at("otherData").at("left_out_events") == 0);
  for (const ProfileStage& stage : found.profile.stages) {
    if (stage.estimated) continue;
    CAPTURE(stage.name);
    CHECK(count_of(found.trace, stage.name) >= stage.calls);
  }
  CHECK(count_of(found.trace, "step") == 4);
}

TEST_CASE("a trace has a limited size: the first and the last steps") {
  constexpr std::size_t events = 60;
  const auto profiler = std::make_shared<Profiler>(events);
  const Run found = run(falling_block(3), single_sweep(), 1, profiler, 200);
  check_trace(found.trace);
  const std::size_t kept = count_of(found.trace, "step");
  CHECK(kept > 4);
  CHECK(kept < events);
  CHECK(found.trace.at("otherData").at("left_out_events").get<int>() > 200);
  std::ostringstream text;
  profiler->write_trace(text);
  CHECK(static_cast<double>(text.str().size()) < Profiler::trace_bytes(events));
  // Both ends, with a mark between.
  double mark = -1.0;
  for (const auto& event : found.trace.at("traceEvents"))
    if (event.at("ph") == "i") mark = event.at("ts");
  std::size_t before = 0, after = 0;
  for (const auto& event : found.trace.at("traceEvents"))
    if (event.at("ph") == "X" && event.at("name") == "step") ++(event.at("ts") < mark ? before : after);
  CHECK(before > 2);
  CHECK(after > 2);
  // Without a trace there are no events.
  CHECK(count_of(run(falling_block(3), single_sweep(), 1, std::make_shared<Profiler>()).trace, "step") == 0);
}

TEST_CASE("a program's own stages contain those of the engine") {
  const auto profiler = std::make_shared<Profiler>();
  SimulationOptions options;
  options.profiler = profiler;
  options.threads = 1;
  Simulation simulation(falling_block(3), plugins(), options);
  {
    const Profiler::Scope frame(profiler.get(), "frame");
    simulation.step();
    {
      const Profiler::Scope drawing(profiler.get(), "draw");
      static_cast<void>(simulation.potential_energy());
    }
    const Profile open = profiler->profile();  // of stages that have not ended
    CHECK(open.seconds > 0.0);
    check_adds_up([&] {
      Profile ended = open;
      ended.stages.front().calls = 1;  // not counted before its end
      return ended;
    }());
    profiler->clear();  // not within a scope
  }
  const Profile profile = profiler->profile();
  check_adds_up(profile);
  REQUIRE(profile.stages.front().name == "frame");
  REQUIRE(find(profile, "draw") != nullptr);
  CHECK(find(profile, "draw")->parent == 0);
  CHECK(find(profile, "step")->parent == 0);
  REQUIRE(find(profile, "energy") != nullptr);
  CHECK(profile.stages[static_cast<std::size_t>(find(profile, "energy")->parent)].name == "draw");
  // Outside of scopes nothing is recorded.
  static_cast<void>(simulation.potential_energy());
  CHECK(find(profiler->profile(), "energy")->calls == 1);
  profiler->clear();
  CHECK(profiler->profile().stages.empty());
  const Profiler::Scope nothing(nullptr, "nothing");
}

TEST_CASE("a scope of another thread records nothing while one is open") {
  Profiler profiler;
  {
    const Profiler::Scope mine(&profiler, "mine");
    std::thread([&] { const Profiler::Scope other(&profiler, "other"); }).join();
  }
  std::thread([&] { const Profiler::Scope later(&profiler, "later"); }).join();
  const Profile profile = profiler.profile();
  CHECK(find(profile, "mine") != nullptr);
  CHECK(find(profile, "other") == nullptr);
  CHECK(find(profile, "later") != nullptr);
}

TEST_CASE("a step that fails ends its stages") {
  Network net = oscillator(damped(1e6, 0.0), 1.0, 0.1);
  const auto profiler = std::make_shared<Profiler>(100);
  SimulationOptions options;
  options.time_step = 1.0;
  options.threads = 1;
  options.profiler = profiler;
  options.integrator = {"recurrent", {{"update", synchronous}, {"unsettled", on_unsettled_error}}};
  Simulation simulation(net, plugins(), options);
  CHECK_THROWS(simulation.step());
  CHECK_THROWS(simulation.step());
  const Profile profile = profiler->profile();
  check_adds_up(profile);
  CHECK(profile.stages.front().name == "step");
  CHECK(profile.stages.front().calls == 2);
}
