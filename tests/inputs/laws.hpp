// Laws that read inputs, for closed forms, and simulations with them.
#pragma once

#include <array>
#include <memory>

#include <springnet/sdk/law.hpp>

#include "nets.hpp"

namespace springnet::testing {

// A tension that a signal gives, in N.
struct Motor : sdk::SpringFunction {
  static constexpr const char* id = "motor";
  static constexpr const char* summary = "T = tension + extra";
  static constexpr bool adds_power = true;
  static constexpr bool not_zero_at_rest = true;
  static constexpr bool fits_elements = true;
  static constexpr sdk::Parameter parameters[] = {sdk::number("extra", "N", "more of it").preset(0)};
  static constexpr sdk::Parameter inputs[] = {
      sdk::number("tension", "N", "all of it").preset(0).at_least(-50).at_most(50)};
  static auto force(const auto& e, const auto& p) { return e.input(0) + p[0] + 0.0 * e.q; }
};

// A tension that follows a signal: z' = (u - z) / tau.
struct Follower : sdk::SpringFunction {
  static constexpr const char* id = "follower";
  static constexpr const char* summary = "T = z";
  static constexpr bool adds_power = true;
  static constexpr sdk::Parameter parameters[] = {sdk::number("lag", "s", "tau").above(0)};
  static constexpr sdk::Parameter states[] = {sdk::number("followed", "N", "z").preset(0).learnable(1)};
  static constexpr sdk::Parameter inputs[] = {sdk::number("tension", "N", "u").preset(0)};
  static auto force(const auto& e, const auto&) { return e.state(0) + 0.0 * e.q; }
  static auto state_rates(const auto& e, const auto& p) { return std::array{(e.input(0) - e.state(0)) / p[0]}; }
};

// The same with a step of its own, exact for signals that are linear within a step.
struct ExactFollower : Follower {
  using has = sdk::Has<sdk::Update>;
  static constexpr const char* id = "exact_follower";
  static constexpr int update_order = 2;
  static auto update(const auto& e, const auto& p, const auto& step) {
    // z = u - s tau + (z0 - u0 + s tau) exp(-h / tau), with the slope s = (u - u0) / h.
    const auto lag = (e.input(0) - step.start_input(0)) * (p[0] / step.duration);
    return std::array{e.input(0) - lag + (e.state(0) - step.start_input(0) + lag) * exp(-step.duration / p[0])};
  }
};

inline constexpr springnet_plugin input_laws =
    sdk::PluginEntry<Motor, Follower, ExactFollower>::make("test.inputs", "1.0.0", "springnet", "MIT");

inline std::shared_ptr<const PluginHost> plugins_with_inputs() {
  static const auto host = [] {
    auto result = std::make_shared<PluginHost>(PluginHost::with_default_search());
    result->add(input_laws);
    return std::shared_ptr<const PluginHost>(std::move(result));
  }();
  return host;
}

inline Simulation simulate_with_inputs(const Network& network, const LawUse& integrator, double time_step,
                                       unsigned threads = 1, InstructionSet set = InstructionSet::best) {
  SimulationOptions options;
  options.time_step = time_step;
  options.integrator = integrator;
  options.threads = threads;
  options.instruction_set = set;
  return {network, plugins_with_inputs(), options};
}

inline Signal table(std::vector<double> times, std::vector<double> values, Signal::Interpolation interpolation) {
  Signal signal;
  signal.times = std::move(times);
  signal.values = std::move(values);
  signal.interpolation = interpolation;
  return signal;
}
inline Signal constant(double value) {
  Signal signal;
  signal.mean = value;
  return signal;
}

}  // namespace springnet::testing
