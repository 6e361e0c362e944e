// Snapshots for a thread that draws.

#include <doctest/doctest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("no snapshots are kept unless asked for, and the last one is that of the last step or change") {
  Simulation simulation = simulate(cube(3.0, 2.0, 0.2, 0.02), recurrent(newton, 1e-10), 0.05);
  simulation.step();
  CHECK(simulation.snapshot() == nullptr);
  simulation.keep_snapshots();
  const auto check = [&](const Snapshot& snapshot) {
    CHECK(snapshot.time == simulation.time());
    CHECK(snapshot.steps == simulation.steps());
    CHECK(snapshot.positions == simulation.in_user_order(simulation.positions()));
    CHECK(snapshot.velocities == simulation.in_user_order(simulation.velocities()));
    CHECK(snapshot.live_springs == simulation.live_spring_count());
    CHECK(snapshot.events == simulation.events().size());
  };
  REQUIRE(simulation.snapshot());
  check(*simulation.snapshot());
  const std::shared_ptr<const Snapshot> before = simulation.snapshot();
  const Eigen::Matrix3Xd positions = before->positions;
  simulation.advance_to(3.0);
  check(*simulation.snapshot());
  CHECK(before->positions == positions);  // it stays as it was
  CHECK(before->time < simulation.time());
  const std::string saved = simulation.save();
  simulation.cut({0, 1, 2});
  check(*simulation.snapshot());
  simulation.set_position(63, {5, 5, 5});
  check(*simulation.snapshot());
  simulation.set_velocity(63, {1, 0, 0});
  check(*simulation.snapshot());
  simulation.restore(saved);
  check(*simulation.snapshot());
  simulation.keep_snapshots(false);
  CHECK(simulation.snapshot() == nullptr);
  simulation.step();
  CHECK(simulation.snapshot() == nullptr);
}

TEST_CASE("a thread that draws sees whole states while the next step is made") {
  // The positions of each step, from a run of its own.
  constexpr int steps = 400;
  std::vector<Eigen::Matrix3Xd> positions, velocities;
  const auto start = [] { return simulate(cube(3.0, 2.0, 0.2, 0.02), recurrent(wavefront, 1e-8), 0.05); };
  Simulation reference = start();
  for (int step = 0; step <= steps; ++step) {
    positions.push_back(reference.in_user_order(reference.positions()));
    velocities.push_back(reference.in_user_order(reference.velocities()));
    reference.step();
  }
  Simulation simulation = start();
  simulation.keep_snapshots();
  std::atomic<bool> done = false;
  std::size_t seen = 0, torn = 0, backwards = 0;
  std::thread draws([&] {
    std::uint64_t last = 0;
    while (!done) {
      const std::shared_ptr<const Snapshot> snapshot = simulation.snapshot();
      if (snapshot->positions != positions[snapshot->steps] || snapshot->velocities != velocities[snapshot->steps])
        ++torn;
      if (snapshot->steps < last) ++backwards;
      if (snapshot->steps > last) ++seen;
      last = snapshot->steps;
    }
  });
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    if (step % 20 == 0) std::this_thread::yield();
  }
  done = true;
  draws.join();
  CHECK(torn == 0);
  CHECK(backwards == 0);
  CHECK(seen > 0);
}

TEST_CASE("other threads draw and ask to stop while a simulation is extended") {
  Simulation simulation = simulate(cube(3.0, 2.0, 0.2, 0.02), recurrent(newton, 1e-10), 0.05);
  simulation.keep_snapshots();
  const std::size_t nodes = simulation.node_count();
  constexpr int additions = 20;
  std::atomic<bool> done = false;
  std::size_t missing = 0, backwards = 0;
  std::thread draws([&] {
    std::size_t last = nodes;
    while (!done) {
      const std::shared_ptr<const Snapshot> snapshot = simulation.snapshot();
      simulation.ask_to_stop();
      if (!snapshot) {
        ++missing;
        continue;
      }
      const auto count = static_cast<std::size_t>(snapshot->positions.cols());
      if (count < last || count > nodes + additions) ++backwards;
      last = count;
    }
  });
  for (int i = 0; i < additions; ++i) {
    simulation.extend([&](Network& now) {
      const NodeIndex added = now.add_node(point(now.nodes()[63].position + Vector3(0, 0, 1.0 + i)));
      now.add_spring(63, added, 0);
    });
    simulation.step();
  }
  done = true;
  draws.join();
  CHECK(missing == 0);
  CHECK(backwards == 0);
  CHECK(static_cast<std::size_t>(simulation.snapshot()->positions.cols()) == nodes + additions);
  simulation.step();
  simulation.ask_to_stop();
  simulation.step();
  CHECK(simulation.last_report().outcome == Outcome::out_of_time);
  simulation.step();
  CHECK(simulation.last_report().outcome == Outcome::settled);
}
