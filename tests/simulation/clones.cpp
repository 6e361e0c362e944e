// Simulation::clone(): a copy that goes on by itself, and shares what neither changes.

#include <doctest/doctest.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "generator.hpp"
#include "repetitions.hpp"
#include "saved_states.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// Bytes that the program has asked for and not given back; 0 where nobody counts them.
double allocated() {
#ifdef __GLIBC__
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
#else
  return 0.0;
#endif
}

constexpr int before = 8, after = 8;  // steps

// What copies do that goes its own way, by the number of the copy.
void intervene(Simulation& simulation, int copy) {
  switch (copy % 4) {
    case 1:
      CHECK(simulation.cut({5, 9, 50, 51, 52, 101}) > 0);
      break;
    case 2:
      simulation.set_force(3, {0.4, 0, 1.0});
      simulation.set_input("drive", 0.9);
      simulation.move_node(20, simulation.position(20) + Vector3(0, 0, 0.1), simulation.time() + 0.1);
      break;
    case 3:
      simulation.cut_polygon({{0.5, -9, -9}, {0.5, 9, -9}, {0.5, 9, 9}, {0.5, -9, 9}});
      simulation.set_gravity({0, 0.1, -3.0});
      break;
    default:
      break;
  }
}

// Steps in a thread; all that is asked of the simulation is found there, too.
std::thread going_on(Simulation& simulation, int copy, int steps) {
  return std::thread([&simulation, copy, steps] {
    intervene(simulation, copy);
    for (int i = 0; i < steps; ++i)
      if (!step(simulation)) break;
    for (SpringIndex s = 0; s < simulation.spring_count(); ++s) static_cast<void>(simulation.tension(s));
  });
}

// The original and copies of it side by side, each in a thread, against simulations that were restored from the bytes
// and made the same steps one after the other.
void check(const Network& net, const SimulationOptions& options, int first) {
  Simulation own(net, plugins(), options);
  for (int i = 0; i < first; ++i)
    if (!step(own)) return;  // nothing to compare
  std::vector<Simulation> copies;
  for (int copy = 1; copy < 5; ++copy) copies.push_back(own.clone());
  const std::string saved = own.save();
  for (Simulation& each : copies) CHECK(difference(own, each) == "");
  std::vector<std::thread> threads;
  threads.push_back(going_on(own, 0, after));
  for (int copy = 1; copy < 5; ++copy)
    threads.push_back(going_on(copies[static_cast<std::size_t>(copy) - 1], copy, after));
  for (std::thread& each : threads) each.join();
  for (int copy = 0; copy < 5; ++copy) {
    CAPTURE(copy);
    Simulation expected(net, plugins(), options);
    expected.restore(saved);
    going_on(expected, copy, after).join();
    CHECK(difference(copy == 0 ? own : copies[static_cast<std::size_t>(copy) - 1], expected) == "");
  }
}

}  // namespace

TEST_CASE("copies go on side by side in threads with the same bits, whatever the rule") {
  const Network net = eventful();
  for (SimulationOptions& options : all_methods()) {
    CAPTURE(options.integrator.id);
    CAPTURE(options.integrator.parameters["update"]);
    check(net, options, before);
  }
  SimulationOptions summed = with(recurrent(newton, 0.0), 0.02);
  summed.dissipated_energy = true;
  check(net, summed, before);
  // Before anything was found that copies share.
  for (const double rule : {synchronous, wavefront, newton}) check(net, with(recurrent(rule, 0.0), 0.005), 0);
  check(net, with(recurrent(newton, 0.0), 0.02, 2), before);
}

TEST_CASE("copies of random nets go on with the same bits") {
  for (std::uint64_t seed = 21; seed < 24; ++seed) {
    CAPTURE(seed);
    const Network net = RandomNet(seed).network;
    Simulation own(net, plugins(), with(recurrent(automatic, 0.0, {{"unsettled", on_unsettled_adapt}}), 0.01));
    for (int i = 0; i < 4; ++i) {
      if (!step(own)) break;
      Simulation copy = own.clone();
      CHECK(difference(own, copy) == "");
      Simulation other = own.clone();
      if (!step(copy) || !step(other)) break;
      CHECK(difference(copy, other) == "");
      own = std::move(copy);
    }
  }
}

TEST_CASE("what one copy changes shows in no other") {
  const Network net = eventful();
  const SimulationOptions options = with(recurrent(newton, 0.0), 0.02);
  std::optional<Simulation> own;
  own.emplace(net, plugins(), options);
  for (int i = 0; i < 4; ++i) own->step();
  Simulation cut = own->clone();
  // A first copy had a cut, of which there is another copy; then the original a further one.
  const std::size_t all = own->live_spring_count();
  CHECK(cut.cut({1, 2, 3}) == 3);
  Simulation of_cut = cut.clone();
  CHECK(own->cut({10}) == 1);
  CHECK(own->live_spring_count() == all - 1);
  CHECK(of_cut.live_spring_count() == all - 3);
  CHECK(of_cut.alive(10));
  CHECK(!of_cut.alive(1));
  CHECK(own->alive(1));
  // Back to before, in one alone.
  const std::string late = of_cut.save();
  of_cut.restore(cut.save());
  CHECK(difference(of_cut, cut) == "");
  of_cut.restore(late);
  // The original may end first.
  own.reset();
  Simulation last = of_cut.clone();
  cut.step();
  of_cut.step();
  last.step();
  CHECK(difference(of_cut, last) == "");
  CHECK(difference(of_cut, cut) == "");
}

TEST_CASE("simulations made, cloned, restored and destroyed") {
  // tests/long makes 10,000.
  const auto count = static_cast<int>(repetitions("SPRINGNET_COPIES", 200));
  const Network net = eventful();
  const std::vector<SimulationOptions> methods = all_methods();
  double after_some = 0.0;
  for (int i = 0; i < count; ++i) {
    if (i == count / 2) after_some = allocated();
    const auto method = static_cast<std::size_t>(i) % methods.size();
    CAPTURE(method);
    Simulation made(net, plugins(), methods[method]);
    if (i % 3 == 0) step(made);
    Simulation copy = made.clone();
    if (i % 5 == 0) copy.cut({static_cast<SpringIndex>(i % 100)});
    const std::string state = copy.save();
    made.restore(state);
    if (i % 7 == 0) CHECK(difference(made, copy) == "");
    if (i % 2 == 0) made = copy.clone();
    if (i % 11 == 0 && step(copy)) CHECK(step(made));
  }
  constexpr double a_simulation = 50e3;  // bytes
  CHECK(allocated() < after_some + a_simulation);
  MESSAGE(count << " simulations made, cloned, restored and destroyed");
}
