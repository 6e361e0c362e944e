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

constexpr int steps_before = 8, steps_after = 8;  // steps

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
void check_copies(const Network& net, const SimulationOptions& options, int first) {
  Simulation own(net, plugins(), options);
  for (int i = 0; i < first; ++i)
    if (!step(own)) return;  // nothing to compare
  std::vector<Simulation> copies;
  for (int copy = 1; copy < 5; ++copy) copies.push_back(own.clone());
  const std::string saved = own.save();
  for (Simulation& each : copies) CHECK(difference(own, each) == "");
  std::vector<std::thread> threads;
  threads.push_back(going_on(own, 0, steps_after));
  for (int copy = 1; copy < 5; ++copy)
    threads.push_back(going_on(copies[static_cast<std::size_t>(copy) - 1], copy, steps_after));
  for (std::thread& each : threads) each.join();
  for (int copy = 0; copy < 5; ++copy) {
    CAPTURE(copy);
    Simulation expected(net, plugins(), options);
    expected.restore(saved);
    going_on(expected, copy, steps_after).join();
    CHECK(difference(copy == 0 ? own : copies[static_cast<std::size_t>(copy) - 1], expected) == "");
  }
}

}  // namespace

TEST_CASE("copies go on side by side in threads with the same bits, whatever the rule") {
  const Network net = eventful();
  for (SimulationOptions& options : all_methods()) {
    CAPTURE(options.integrator.id);
    CAPTURE(options.integrator.parameters["update"]);
    check_copies(net, options, steps_before);
  }
  SimulationOptions summed = with(recurrent(newton, 0.0), 0.02);
  summed.dissipated_energy = true;
  check_copies(net, summed, steps_before);
  // Before anything was found that copies share.
  for (const double rule : {synchronous, wavefront, newton}) check_copies(net, with(recurrent(rule, 0.0), 0.005), 0);
  check_copies(net, with(recurrent(newton, 0.0), 0.02, 2), steps_before);
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

TEST_CASE("an element that is changed in one copy is changed in no other, also the first of its batch") {
  Network net;
  for (NodeIndex k = 0; k < 8; ++k) net.add_node(point({double(k), 0.1 * double(k % 3), 0.0}));
  const MaterialIndex bend = net.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, std::nullopt});
  for (NodeIndex k = 0; k + 2 < 8; ++k) net.add_element(Invariant::angle, {k, k + 1, k + 2}, bend);
  Simulation first(net, plugins(), with(recurrent(newton, 0.0), 0.01));
  const Simulation untouched = first.clone();
  Simulation second = first.clone();
  second.set_references({2}, {2.0});
  first.set_element_parameter({1}, ComponentKind::spring_function, "stiffness", {5.0});
  const auto rebuilt = [](const Simulation& of) {
    return Simulation(of.present_network(), plugins(), with(recurrent(newton, 0.0), 0.01));
  };
  for (const Simulation* each : std::initializer_list<const Simulation*>{&first, &second, &untouched}) {
    const Simulation fresh = rebuilt(*each);
    for (NodeIndex k = 0; k < 8; ++k) CHECK((fresh.force(k) - each->force(k)).norm() < 1e-14);
  }
  CHECK(untouched.force(3) != second.force(3));
}

TEST_CASE("a copy of a net without some elements takes up a state with all of them") {
  Network net;
  for (NodeIndex k = 0; k < 40; ++k) net.add_node(point({double(k), 0.1 * double(k % 3), 0.0}));
  const MaterialIndex bend = net.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, std::nullopt});
  std::vector<ElementIndex> all;
  for (NodeIndex k = 0; k + 2 < 40; ++k) all.push_back(net.add_element(Invariant::angle, {k, k + 1, k + 2}, bend, 2.9));
  Simulation whole(net, plugins(), with(recurrent(newton, 0.0), 0.01));
  const std::string steps_before = whole.save();
  const Simulation reference = whole.clone();
  whole.remove_elements({all.begin() + 2, all.end()});
  Simulation copy = whole.clone();
  copy.restore(steps_before);
  for (NodeIndex k = 0; k < 40; ++k) CHECK(same_bits(copy.force(k), reference.force(k)));
}

TEST_CASE("springs that were removed little by little lie in a copy as in the original; their states stay") {
  Network net;
  const MaterialIndex law = net.add_material(
      {LawUse{"maxwell", {{"stiffness", 50.0}, {"relaxation_time", 0.1}}}, LawUse{"linear", {{"damping", 0.5}}}});
  for (NodeIndex k = 0; k < 60; ++k) net.add_node(point({double(k), std::sin(double(k)), std::cos(double(k))}));
  for (NodeIndex k = 0; k < 60; ++k)
    for (NodeIndex l = k + 1; l < std::min<NodeIndex>(k + 8, 60); ++l) net.add_spring(k, l, law, 1.5);
  Simulation first(net, plugins(), with(recurrent(newton, 0.0), 0.002));
  for (int i = 0; i < 3; ++i) first.step();
  // More than half of them, in three parts: units are laid out anew on the way.
  for (SpringIndex part = 0; part < 3; ++part) {
    std::vector<SpringIndex> list;
    for (SpringIndex s = part; s < 300; s += 4) list.push_back(s);
    first.cut(list);
    first.step();
  }
  const std::vector<double> state = first.internal_states(4);
  const std::string saved = first.save();
  Simulation second(net, plugins(), with(recurrent(newton, 0.0), 0.002));
  second.restore(saved);
  for (int i = 0; i < 4; ++i) {
    first.step();
    second.step();
    CHECK(difference(first, second) == "");
    CHECK(first.internal_states(4) == state);
  }
}
