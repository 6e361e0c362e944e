// repeats, memory, leaks: what an integrator keeps, and that it keeps no more.
#include <array>
#include <string>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "check/child.hpp"
#include "check/heap.hpp"
#include "check/integrator_checks.hpp"
#include "check/trial.hpp"

namespace springnet::check {
namespace {

constexpr double memory_step = 0.01;  // s

LawUse stiffening() { return law_by_formula("k*e + c*e^3", {{"k", oscillator::stiffness}, {"c", 20.0}}); }
Network oscillating() { return pair(stiffening(), {0.2, 0.1}, true); }

// Large enough that several threads share it.
Network block() {
  Network net;
  const LawUse damping = law_by_formula("d*rate", {{"d", 0.01}}, "", ComponentKind::viscosity_function);
  Lattice lattice;
  lattice.nodes = {24, 24, 24};
  lattice.diagonals = Diagonals::face;
  Node node;
  node.mass = 1e-3;
  net.add_lattice("block", lattice, node, net.add_material({stiffening(), damping}));
  net.fix(0);
  net.set_gravity(Vector3(1.0, 0.3, -9.81));
  return net;
}

void make_steps(Simulation& simulation, int count) {
  for (int k = 0; k < count; ++k) simulation.step();
}

// The state after some steps, what `between` does, and some more.
template <class Between>
std::string bits_after(const Trial& trial, const Between& between) {
  Simulation simulation = trial.run(oscillating(), memory_step);
  make_steps(simulation, 12);
  between(simulation);
  make_steps(simulation, 12);
  return bits_of(simulation);
}

// Empty if these bytes are refused with a reason, and nothing is kept of them.
std::string refuses(const Trial& trial, const std::string& memory, const char* what) {
  bool refused = false;
  const std::string after = bits_after(trial, [&](Simulation& simulation) {
    try {
      simulation.set_integrator_memory(memory);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::plugin) throw;
      refused = true;
    }
  });
  if (!refused) return fmt::format("`restore` takes {}: compare what it reads with the network, and the length", what);
  if (after != bits_after(trial, [](Simulation& simulation) { simulation.drop_history(); }))
    return fmt::format("`restore` refuses {}, but keeps a part of it: forget all then", what);
  return {};
}

// anew: with instances that know nothing but what they restore.
std::string check_restore(const Trial& trial, const Trial& anew) {
  std::string memory, of_another;
  const std::string uninterrupted =
      bits_after(trial, [&](Simulation& simulation) { memory = simulation.integrator_memory(); });
  const std::string restored =
      bits_after(anew, [&](Simulation& simulation) { simulation.set_integrator_memory(memory); });
  if (restored != uninterrupted)
    return "a run that goes on from saved memory has other bits than one without a pause: `save` all that the next "
           "step "
           "reads of those before";
  const std::size_t heading = memory.find('\n') + 1;
  if (heading >= memory.size()) return {};  // nothing to keep
  const std::size_t half = heading + (memory.size() - heading) / 2;
  for (const auto& [length, what] : {std::pair(heading, "no bytes"), std::pair(half, "half of its bytes"),
                                     std::pair(memory.size() - 1, "all of its bytes but one")})
    if (std::string wrong = refuses(trial, memory.substr(0, length), what); !wrong.empty()) return wrong;
  if (std::string wrong = refuses(trial, memory + std::string(8, '\0'), "eight bytes too many"); !wrong.empty())
    return wrong;
  Network larger = oscillating();
  larger.add_node(Node{.position = Vector3(0.0, 3.0, 0.0)});
  larger.add_spring(0, 2, 0);
  Simulation other = trial.run(larger, memory_step);
  make_steps(other, 12);
  return refuses(trial, other.integrator_memory(), "the memory of a larger network");
}

}  // namespace

Outcome check_integrator_repeats(const Component& component, const PluginHost& host) {
  const Trial trial(component, host);
  now_doing("repeating a run");
  const auto nothing = [](Simulation&) {};
  const std::string once = bits_after(trial, nothing);
  for (int k = 0; k < 3; ++k)
    if (bits_after(trial, nothing) != once)
      return {Result::failed,
              "two runs of the same network have other bits: keep no memory outside of the instance, and "
              "read nothing that was not written"};
  now_doing("simulating with one, two and four threads");
  const Network net = block();
  std::string of_one;
  for (const unsigned threads : {1u, 2u, 4u, 4u}) {
    Simulation simulation = trial.run(net, 1e-3, threads);
    make_steps(simulation, 3);
    if (threads == 1) of_one = bits_of(simulation);
    if (bits_of(simulation) != of_one)
      return {
          Result::failed,
          fmt::format("with {} threads the bits are others than with one: sum up in an order that does not depend on "
                      "which thread comes first",
                      threads)};
  }
  return {};
}

Outcome check_integrator_memory(const Component& component, const PluginHost& host) {
  const Trial trial(component, host);
  const Trial anew(component, host, false);
  const springnet_integrator& functions = component.integrator();
  std::string told;
  if (functions.forget != nullptr) {
    now_doing("forgetting its history");
    const auto drop = [](Simulation& simulation) { simulation.drop_history(); };
    if (bits_after(trial, drop) != bits_after(anew, drop))
      return {Result::failed,
              "after `forget` the next steps have other bits than those of an integrator created now: drop all that is "
              "kept from one step to the next"};
    told = "forgets";
  }
  if (!SPRINGNET_HAS_FIELD(springnet_integrator, &functions, restore) || functions.save == nullptr ||
      functions.restore == nullptr)
    return {Result::passed, told.empty() ? "has neither `forget` nor `save`" : told};
  now_doing("saving and restoring its memory");
  if (const std::string wrong = check_restore(trial, anew); !wrong.empty()) return {Result::failed, wrong};
  return {Result::passed, told + (told.empty() ? "" : ", ") + "saves and restores"};
}

Outcome check_integrator_leaks(const Component& component, const PluginHost& host) {
  if (!heap_in_use()) return {Result::passed, "not known on this system"};
  const Trial trial(component, host);
  const Network net = oscillating();
  now_doing("making steps");
  Simulation simulation = trial.run(net, memory_step);
  const double by_steps = kept_by_each([&] { simulation.step(); }, 200);
  if (by_steps >= 1.0)
    return {Result::failed, fmt::format("each step keeps {:.0f} bytes: give them back when it ends", by_steps)};
  now_doing("creating and destroying it");
  const double by_lives = kept_by_each(
      [&] {
        Simulation another = trial.run(net, memory_step);
        another.step();
      },
      10);
  if (by_lives > 0.0)
    return {Result::failed, fmt::format("each instance leaves {:.0f} bytes behind: `destroy` frees all", by_lives)};
  return {};
}

}  // namespace springnet::check
