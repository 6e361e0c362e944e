// The largest time steps that integrators report for the start of a network; see springnet_integrator::limits.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "simulation/engine.hpp"

namespace springnet {

struct ReportedLimit {
  std::string rule;               // "": the integrator has no rules to choose from
  std::uint32_t kind;             // SPRINGNET_LIMIT_KNOWN …
  double time_step = 0.0;         // s
  double weight = 0.0;            // s, see springnet_limit
  std::optional<NodeIndex> node;  // user's
  std::string reason;
};

// One engine at the start, on which all integrators report their limits.
class LimitSurvey {
 public:
  // Throws like Simulation.
  LimitSurvey(const Network& network, const PluginHost& plugins, const SimulationOptions& options = {});

  // Rule by rule; empty if the integrator reports none. An integrator that fails, or does not take the parameters,
  // gives one unknown limit with the reason.
  [[nodiscard]] std::vector<ReportedLimit> ask(const Component& integrator, const ParameterValues& parameters);

  // In the state at the start.
  [[nodiscard]] Engine& engine() noexcept { return engine_; }
  [[nodiscard]] const springnet_host& table() const noexcept { return table_; }

 private:
  Engine engine_;
  springnet_host table_;
};

}  // namespace springnet
