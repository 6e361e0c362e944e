// Simulation::save() and restore(): what follows has the same bits as in the simulation that went on.

#include <doctest/doctest.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "generator.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr int before = 12, after = 10;  // steps

// A cube that falls on a ramp with friction, under a ball that moves: springs with memory, springs that break, muscles,
// a load that comes and goes, a moved node, a rigid connection, a cut.
Network eventful() {
  Network net = cube(300.0, 2.0, 2.0, 1e-3);
  Plane ramp{"ramp", {0, 0, -0.02}, Vector3(0.3, 0, 1).normalized()};
  ramp.friction = {Friction::Kind::coulomb, 0.2};
  net.add_plane(ramp);
  Instrument ball{"ball", {1.5, 1.5, 3.6}, {1.5, 1.5, 3.6}, 0.5};
  Motion down;
  down.times = {0.0, 0.5};
  down.displacements = {{0, 0, 0}, {0, 0.2, -0.4}};
  ball.motion = down;
  net.add_instrument(ball);
  const auto add = [&net](const Vector3& from, const LawUse& law) {
    const NodeIndex a = net.add_node(point(from)), b = net.add_node(point(from + Vector3(1, 0, 0), 1.0, {0.8, 0, 0}));
    return net.add_spring(a, b, net.add_material({law, LawUse{"linear", {{"damping", 0.5}}}}));
  };
  add({6, 0, 2}, {"maxwell", {{"stiffness", 50.0}, {"relaxation_time", 0.1}}});
  add({6, 0, 3}, {"rupturing", {{"stiffness", 50.0}, {"strength", 3.0}}});
  const SpringIndex muscle = add({6, 0, 4}, {"muscle", {{"strength", 20.0}, {"maximum_speed", 3.0}}});
  Input activation;
  activation.name = "drive";
  activation.input = "activation";
  activation.springs = {muscle};
  activation.signal.mean = 0.4;
  activation.signal.amplitude = 0.3;
  activation.signal.frequency = 1.5;
  net.add_input(activation);
  Load wind;
  wind.nodes = {60, 61};
  wind.force = {1.0, 0.5, 0};
  wind.from = 0.07;
  wind.until = 0.33;
  net.add_load(wind);
  const NodeIndex held = net.add_node(point({8, 8, 8})), hanging = net.add_node(point({8, 8, 7}));
  net.add_rigid(held, hanging);
  Move move;
  move.nodes = {held};
  move.motion = down;
  net.add_move(move);
  net.add_cut({0.29, {3, 17, 40, 90}, {}});
  return net;
}

SimulationOptions with(LawUse integrator, double time_step, unsigned threads = 1) {
  SimulationOptions options;
  options.integrator = std::move(integrator);
  options.time_step = time_step;
  options.threads = threads;
  return options;
}

bool step(Simulation& simulation) {
  try {
    simulation.step();
    return true;
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::simulation);
    return false;
  }
}

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same(const Vector3& a, const Vector3& b) { return same(a[0], b[0]) && same(a[1], b[1]) && same(a[2], b[2]); }

// Everything that can be asked of two simulations. Empty: it is the same; else what is not.
std::string difference(const Simulation& a, const Simulation& b) {
  if (!same(a.time(), b.time()) || a.steps() != b.steps() || a.sweeps() != b.sweeps()) return "time, steps or sweeps";
  for (NodeIndex k = 0; k < a.node_count(); ++k) {
    if (!same(a.position(k), b.position(k))) return "position";
    if (!same(a.velocity(k), b.velocity(k))) return "velocity";
    if (!same(a.force(k), b.force(k))) return "force";
    if (!same(a.reaction(k), b.reaction(k))) return "reaction";
    if (!same(a.contact_impulse(k), b.contact_impulse(k))) return "contact impulse";
    if (a.held(k) != b.held(k) || a.touching(k) != b.touching(k) || a.surfaces_of(k) != b.surfaces_of(k))
      return "contact";
  }
  for (SpringIndex s = 0; s < a.spring_count(); ++s)
    if (a.alive(s) != b.alive(s) || !same(a.tension(s), b.tension(s)) || a.internal_states(s) != b.internal_states(s))
      return "spring";
  for (ElementIndex e = 0; e < a.element_count(); ++e)
    if (a.element_alive(e) != b.element_alive(e) || !same(a.element_force(e), b.element_force(e))) return "element";
  for (std::size_t s = 0; s < a.surface_count(); ++s)
    if (!same(a.surface_position(s), b.surface_position(s)) || !same(a.surface_velocity(s), b.surface_velocity(s)) ||
        !same(a.surface_impulse(s), b.surface_impulse(s)))
      return "surface";
  if (a.events().size() != b.events().size()) return "number of events";
  for (std::size_t k = 0; k < a.events().size(); ++k) {
    const Event &x = a.events()[k], &y = b.events()[k];
    if (x.kind != y.kind || !same(x.time, y.time) || x.index != y.index || x.element != y.element ||
        x.surface != y.surface || !same(x.impulse, y.impulse))
      return "event";
  }
  // An integrator that has been created since may note once more what it finds.
  for (const std::string& note : a.notes())
    if (std::find(b.notes().begin(), b.notes().end(), note) == b.notes().end()) return "notes";
  if (!same(a.dissipated_energy(), b.dissipated_energy())) return "dissipated energy";
  return {};
}

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
  for (const double theta : {1.0, 0.5})
    for (const double rule : {synchronous, wavefront, block, coloured, newton, automatic}) {
      CAPTURE(theta);
      CAPTURE(rule);
      const double step = rule == synchronous || rule == wavefront ? 0.005 : 0.025;
      SimulationOptions options =
          with(recurrent(rule, 0.0, {{"theta", theta}, {"unsettled", on_unsettled_adapt}}), step);
      options.dissipated_energy = rule == newton;
      check(net, options);
    }
  check(net, with(recurrent(newton, 0.0, {{"theta", 0.5}, {"events", 1}}), 0.02));
  check(net, with(cvode(1e-6), 0.01));
  check(net, with({"verlet", {{"substeps", 10}}}, 0.01));
  check(net, with(testing::generalized_alpha(), 0.02));
  check(net, with(recurrent(newton, 0.0), 0.025, 2));
  check(net, with(recurrent(newton, 0.0), 0.025), 0);
}

TEST_CASE("random nets are restored with the same bits") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
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
  refused(own, "springnet state 1\n", "ends too early");
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
  const std::size_t head = std::strlen("springnet state 1\n") + 12;
  std::mt19937 random(1);
  int taken = 0;
  for (int i = 0; i < 400; ++i) {
    std::string bytes = saved.substr(head);
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
    std::string whole = saved.substr(0, head);
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
