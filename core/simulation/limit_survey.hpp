// What integrators tell of their largest time steps at the start of a network; see springnet_integrator::limits.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "simulation/engine.hpp"

namespace springnet {

struct ToldLimit {
  std::string rule;               // "": the integrator has no rules to choose from
  std::uint32_t kind;             // SPRINGNET_LIMIT_KNOWN …
  double time_step = 0.0;         // s
  double weight = 0.0;            // s, see springnet_limit
  std::optional<NodeIndex> node;  // user's
  std::string reason;
};

// One engine that stands at the start, for all integrators that are asked.
class LimitSurvey {
 public:
  // Throws as Simulation.
  LimitSurvey(const Network& network, const PluginHost& plugins);

  // Rule by rule; empty if the integrator tells nothing. An integrator that fails, or does not take the parameters, is
  // one limit that is unknown, with the reason.
  [[nodiscard]] std::vector<ToldLimit> ask(const Component& integrator, const ParameterValues& parameters);

  // At the start, at rest if the network is.
  [[nodiscard]] Engine& engine() noexcept { return engine_; }
  [[nodiscard]] const springnet_host& table() const noexcept { return table_; }

 private:
  Engine engine_;
  springnet_host table_;
};

}  // namespace springnet
