// Small nets whose motion is known, and simulations of them by an integrator that is checked.
#pragma once

#include <array>
#include <memory>
#include <string>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/simulation.hpp>

namespace springnet::check {

// An oscillator on the x axis: node 0 is fixed at the origin, node 1 at rest 1 m from it.
namespace oscillator {
inline constexpr double stiffness = 4.0, mass = 1.0, frequency = 2.0;  // N/m, kg, rad/s
inline constexpr double rest = 1.0;                                    // m
// Elongation and its rate, a time after these.
struct State {
  double elongation, speed;  // m, m/s
  [[nodiscard]] State after(double time) const;
};
// With a force F on node 1 the elongation is that about F / stiffness.
[[nodiscard]] State forced(const State& state, double time, double force);
// Its spring: the force is `k` (N/m) times the elongation.
[[nodiscard]] LawUse hooke(double k = stiffness);
}  // namespace oscillator

// A law by its formula; names that are none of the language's get these values.
[[nodiscard]] LawUse law_by_formula(const std::string& force, const ParameterValues& values,
                                    const std::string& margin = "",
                                    ComponentKind kind = ComponentKind::spring_function);
// Node 1 moves along the x axis, held by the law; node 0 is fixed, unless `free`.
[[nodiscard]] Network pair(const LawUse& law, const oscillator::State& start, bool free = false);

class Trial {
 public:
  // others: have the neuron of point masses. with_forget: false takes the integrator's `forget` from it, so that it is
  // created anew where it would be called.
  Trial(const Component& component, const PluginHost& others, bool with_forget = true);
  [[nodiscard]] Simulation run(const Network& network, double step, unsigned threads = 1,
                               const ParameterValues& integrator = {}) const;
  [[nodiscard]] const Component& component() const noexcept { return component_; }
  [[nodiscard]] bool declares(std::uint64_t capability) const noexcept {
    return (component_.description->capabilities & capability) != 0;
  }
  // The oscillator's error after 1.6 s, relative to its amplitude, without anything that happens: what the method's own
  // order makes of this step.
  [[nodiscard]] double smooth_error(double step) const;

 private:
  const Component& component_;
  std::shared_ptr<PluginHost> host_;
};

// Elongation and speed of node 1.
[[nodiscard]] oscillator::State state_of(const Simulation& simulation);
// The larger of both differences, the second one divided by the frequency; m.
[[nodiscard]] double distance(const oscillator::State& a, const oscillator::State& b);
// Bits of positions, velocities and time.
[[nodiscard]] std::string bits_of(const Simulation& simulation);
[[nodiscard]] bool is_finite(const Simulation& simulation);

}  // namespace springnet::check
