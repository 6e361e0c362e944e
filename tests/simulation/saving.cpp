// Simulation::save() and restore(): what follows has the same bits as in the simulation that went on.

#include <doctest/doctest.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "generator.hpp"
#include "saved_states.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr int before = 12, after = 10;  // steps

// A simulation that is saved, and goes on, against one that takes up the bytes.
void check(const Network& net, const SimulationOptions& options, int first = before) {
  Simulation own(net, plugins(), options), other(net, plugins(), options);
  for (int i = 0; i < first; ++i)
    if (!step(own)) return;  // nothing to compare
  const std::string saved = own.save();
  other.restore(saved);
  CHECK(difference(own, other) == "");
  for (int i = 0; i < after; ++i) {
    const bool done = step(own);
    CHECK(step(other) == done);
    const std::string what = difference(own, other);
    CHECK(what == "");
    if (!done || !what.empty()) break;
  }
  // Back to what was saved, whatever has happened since.
  own.restore(saved);
  Simulation again(net, plugins(), options);
  again.restore(saved);
  CHECK(difference(own, again) == "");
  for (int i = 0; i < after; ++i) {
    const bool done = step(own);
    CHECK(step(again) == done);
    const std::string what = difference(own, again);
    CHECK(what == "");
    if (!done || !what.empty()) break;
  }
}

}  // namespace

TEST_CASE("a restored simulation goes on with the same bits, whatever the rule") {
  const Network net = eventful();
  for (SimulationOptions& options : all_methods()) {
    CAPTURE(options.integrator.id);
    CAPTURE(options.integrator.parameters["update"]);
    check(net, options);
  }
  SimulationOptions summed = with(recurrent(newton, 0.0), 0.025);
  summed.dissipated_energy = true;
  check(net, summed);
  check(net, with(recurrent(newton, 0.0), 0.025, 2));
  check(net, with(recurrent(newton, 0.0), 0.025), 0);
}

TEST_CASE("a simulation is restored and copied with the same bits at every step") {
  // Nodes slip, stick and separate: with theta 1/2 what a surface did not do in a step follows in the next one.
  Network hopping;
  const MaterialIndex spring = hopping.add_material(damped(60.0, 0.2));
  for (const double speed : {1.5, 2.5, 3.5}) {
    const NodeIndex foot = hopping.add_node(point({speed, 0, 0}, 0.2));
    hopping.add_spring(foot, hopping.add_node(point({speed, 0, 1}, 1.0, {1, 0, speed})), spring);
  }
  Plane floor{"floor", {0, 0, 0}, {0, 0, 1}};
  floor.friction = {Friction::Kind::coulomb, 0.3};
  hopping.add_plane(floor);
  hopping.set_gravity({0, 0, -10});
  const std::vector<LawUse> methods{recurrent(newton, 0.0, {{"theta", 0.5}, {"unsettled", on_unsettled_adapt}}),
                                    recurrent(newton, 0.0, {{"theta", 0.5}, {"events", 1}}), cvode(1e-6)};
  for (const Network& each : {eventful(), hopping})
    for (const LawUse& method : methods) {
      const SimulationOptions options = with(method, 0.02);
      const auto net = std::make_shared<const Network>(each);
      Simulation own(net, plugins(), options);
      std::string what;
      for (int i = 0; i < 60 && what.empty(); ++i) {
        Simulation other(net, plugins(), options);
        other.restore(own.save());
        Simulation copy = own.clone();
        const bool done = step(own);
        CHECK(step(other) == done);
        CHECK(step(copy) == done);
        what = difference(own, other);
        if (what.empty()) what = difference(own, copy);
        if (!done) break;
      }
      CHECK(what == "");
    }
}

TEST_CASE("random nets are restored with the same bits") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {  // the next one takes most of a minute
    CAPTURE(seed);
    const Network net = RandomNet(seed).network;
    for (const double theta : {1.0, 0.5})
      check(net, with(recurrent(automatic, 0.0, {{"theta", theta}, {"unsettled", on_unsettled_adapt}}), 0.01));
    check(net, with({"verlet", {{"substeps", 20}}}, 0.002));
    check(net, with(testing::generalized_alpha(), 0.002));
  }
}

TEST_CASE("what the program has changed is saved, and undone by an earlier state") {
  const Network net = eventful();
  const SimulationOptions options = with(recurrent(newton, 0.0), 0.02);
  Simulation own(net, plugins(), options), plain(net, plugins(), options);
  for (int i = 0; i < 4; ++i) {
    own.step();
    plain.step();
  }
  const std::string early = own.save();
  static_cast<void>(plain.save());
  own.set_force(5, {0.3, 0, 1.0});
  own.set_gravity({0, 0.1, -3.0});
  own.set_input("drive", 0.9);
  own.move_surface(2, {1.0, 1.5, 3.3}, own.time() + 0.3);
  own.move_node(20, own.position(20) + Vector3(0, 0, 0.2), own.time() + 0.3);
  own.set_fixed(40, true);
  own.set_velocity(50, {0, 0.3, 0});
  CHECK(own.cut({7, 8, 9, 100}) == 4);
  own.step();
  const std::string late = own.save();
  Simulation other(net, plugins(), options);
  other.restore(late);
  for (int i = 0; i < 12; ++i) {
    own.step();
    other.step();
    CHECK(difference(own, other) == "");
  }
  own.restore(early);
  CHECK(own.alive(7));
  CHECK(difference(own, plain) == "");
  for (int i = 0; i < 12; ++i) {
    own.step();
    plain.step();
    CHECK(difference(own, plain) == "");
  }
}

// Springs of a tile that has lost most of them are laid out anew, and all of them again when an early state is
// restored.
TEST_CASE("springs with memory come back after most of them were cut") {
  Network net;
  Lattice lattice;
  lattice.nodes = {4, 4, 4};
  lattice.diagonals = Diagonals::space;
  net.add_lattice("memory", lattice, Node{},
                  net.add_material({LawUse{"maxwell", {{"stiffness", 50.0}, {"relaxation_time", 0.1}}}, std::nullopt}));
  net.set_gravity({0, 0, -1});
  net.fix(0);
  Simulation own = simulate(net, recurrent(newton, 0.0), 0.01), plain = simulate(net, recurrent(newton, 0.0), 0.01);
  for (int i = 0; i < 3; ++i) {
    own.step();
    plain.step();
  }
  const std::string early = own.save();
  static_cast<void>(plain.save());
  std::vector<SpringIndex> most;
  for (SpringIndex s = 0; s < own.spring_count(); ++s)
    if (s % 4 != 0) most.push_back(s);
  own.cut(most);
  own.step();
  static_cast<void>(own.save());
  own.restore(early);
  for (int i = 0; i < 3; ++i) {
    CHECK(difference(own, plain) == "");
    own.step();
    plain.step();
  }
}

TEST_CASE("a state that is damaged or of another simulation is refused, and changes nothing") {
  const Network net = eventful();
  const SimulationOptions options = with(recurrent(newton, 0.0), 0.02);
  Simulation own(net, plugins(), options), plain(net, plugins(), options);
  for (int i = 0; i < 3; ++i) own.step();
  const std::string saved = own.save();
  const auto refused = [&](Simulation& simulation, const std::string& bytes, const std::string& message) {
    std::string said;
    try {
      simulation.restore(bytes);
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::input);
      said = error.what();
    }
    CAPTURE(said);
    CHECK(said.find(message) != std::string::npos);
  };
  refused(own, "", "this is no state saved by springnet");
  refused(own, "springnet state 8\n", "ends too early");
  refused(own, saved.substr(0, saved.size() - 1), "damaged: it has");
  for (const std::size_t place : {std::size_t{40}, saved.size() / 2, saved.size() - 1}) {
    std::string flipped = saved;
    flipped[place] = static_cast<char>(flipped[place] ^ 4);
    refused(own, flipped, "damaged: its checksum");
  }
  Simulation other_step(net, plugins(), with(recurrent(newton, 0.0), 0.01));
  refused(other_step, saved, "time step: 0.02 s there, 0.01 s here");
  Simulation other_integrator(net, plugins(), with({"verlet", {}}, 0.02));
  refused(other_integrator, saved, "integrator: recurrent@");
  Network heavier = eventful();
  heavier.add_node(point({20, 0, 0}));
  Simulation other_net(heavier, plugins(), options);
  refused(other_net, saved, "nodes: ");
  CHECK(own.save() == saved);

  // With a checksum that fits, whatever the bytes are: an error that changes nothing, or a motion.
  const std::size_t head = std::strlen("springnet state 5\n") + 24;
  std::uint64_t told = 0;
  std::memcpy(&told, saved.data() + head - 24, sizeof told);
  std::mt19937 random(1);
  int taken = 0;
  for (int i = 0; i < 400; ++i) {
    std::string bytes = saved.substr(head + told);
    const int changes = 1 + static_cast<int>(random() % 4);
    for (int k = 0; k < changes; ++k) {
      const std::size_t place = random() % bytes.size();
      if (random() % 8 == 0)
        bytes.erase(place, random() % 64);
      else
        bytes[place] = static_cast<char>(random() % 3 == 0 ? 255 : random());
      if (bytes.empty()) bytes = "x";
    }
    const std::uint64_t size = bytes.size();
    const auto sum = static_cast<std::uint32_t>(crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
    std::string whole = saved.substr(0, head + told);
    std::memcpy(whole.data() + head - 12, &size, sizeof size);
    std::memcpy(whole.data() + head - 4, &sum, sizeof sum);
    Simulation victim(net, plugins(), options);
    try {
      victim.restore(whole + bytes);
      ++taken;
      for (int k = 0; k < 2; ++k) victim.step();
    } catch (const Error&) {
    }
    victim.restore(saved);
    CHECK(difference(victim, own) == "");
  }
  CHECK(taken > 10);
}
