// Loops in the host's threads, and the question whether to stop.
#include <doctest/doctest.h>

#include <atomic>
#include <cstdint>
#include <limits>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <springnet/error.hpp>

#include "probe.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

using Parts = std::set<std::pair<std::uint64_t, std::uint64_t>>;

// The parts of a loop, and in how many threads they ran.
Parts parts_of(std::uint64_t count, std::uint64_t part, unsigned threads, std::size_t* used = nullptr) {
  Parts parts;
  std::set<std::thread::id> by;
  std::mutex adding;
  // Large enough for the host to use several threads.
  Lattice lattice;
  lattice.nodes = {30, 30, 30};
  Network net;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(50.0, 1.0)));
  within_step(
      net,
      [&](const sdk::Host& host) {
        host.parallel_for(
            count,
            [&](std::uint64_t begin, std::uint64_t end) {
              std::this_thread::sleep_for(std::chrono::milliseconds(1));
              const std::lock_guard<std::mutex> lock(adding);
              CHECK(parts.insert({begin, end}).second);
              by.insert(std::this_thread::get_id());
            },
            part);
      },
      threads);
  if (used != nullptr) *used = by.size();
  return parts;
}

}  // namespace

TEST_CASE("a loop has the same parts for every number of threads, which cover it once") {
  std::size_t used = 0;
  const Parts one = parts_of(10000, 1000, 1), three = parts_of(10000, 1000, 3, &used);
  CHECK(one == three);
  CHECK(used == 3);
  CHECK(one.size() == 10);
  std::uint64_t next = 0;
  for (const auto& [begin, end] : one) {
    CHECK(begin == next);
    next = end;
  }
  CHECK(next == 10000);
  CHECK(parts_of(1025, 0, 2) == Parts{{0, 1024}, {1024, 1025}});
  CHECK(parts_of(0, 5, 2).empty());
}

TEST_CASE(
    "an exception from a loop is that of the first part that throws; functions that change the network are refused") {
  const auto failing = [](const sdk::Host& host) {
    host.parallel_for(
        100,
        [](std::uint64_t begin, std::uint64_t) {
          if (begin >= 30) throw std::runtime_error(std::to_string(begin));
        },
        10);
  };
  const Network net = oscillator(damped(1.0, 0.0), 1.0, 0.1);
  CHECK_THROWS_WITH_AS(within_step(net, failing, 2), doctest::Contains(": 30"), Error);
  const auto meddling = [](const sdk::Host& host) {
    host.parallel_for(1, [&](std::uint64_t, std::uint64_t) {
      const At at(host);
      host.linearise(at.evaluation());
    });
  };
  CHECK_THROWS_AS(within_step(net, meddling), Error);
}

TEST_CASE("a program, or the deadline, stops a step, and the next one goes on") {
  std::vector<std::uint32_t> reasons;
  std::vector<double> left;
  task() = [&](const sdk::Host& host) {
    reasons.push_back(host.stop_reason());
    left.push_back(host.time_left());
  };
  Simulation s = probe(oscillator(damped(1.0, 0.0), 1.0, 0.1));
  s.step();
  s.ask_to_stop();
  s.step();
  s.step();
  s.step_within(0.0);
  s.step_within(1000.0);
  CHECK(reasons == std::vector<std::uint32_t>{SPRINGNET_GO_ON, SPRINGNET_STOP_ASKED, SPRINGNET_GO_ON,
                                              SPRINGNET_STOP_DEADLINE, SPRINGNET_GO_ON});
  CHECK(left[0] == std::numeric_limits<double>::infinity());
  CHECK(left[1] < 0.0);
}

TEST_CASE("another thread stops a step that takes long") {
  // Newton's method for a large net with a tolerance that it cannot reach.
  Network net = cube(3e4, 1.0, 10.0, 0.0);
  for (const LawUse& integrator : {recurrent(newton, 1e-9), LawUse{"generalized_alpha", {}}}) {
    CAPTURE(integrator.id);
    Simulation s = simulate(net, integrator, 0.05);
    s.ask_to_stop();
    CHECK(s.step().outcome == Outcome::out_of_time);
    CHECK(s.step().outcome == Outcome::settled);
  }
}
