// The shipped plugins of laws and neurons, as they are loaded from their files.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include <springnet/plugin_host.hpp>

#include "law_call.hpp"

namespace springnet::test {

// But for those that need tables.
inline const std::vector<const springnet_plugin*>& shipped_plugins() {
  static const PluginHost host = PluginHost::with_default_search();
  static const std::vector<const springnet_plugin*> plugins = [] {
    std::vector<const springnet_plugin*> found;
    for (const auto& component : host.components()) {
      const bool is_law =
          component->kind() == ComponentKind::spring_function || component->kind() == ComponentKind::viscosity_function;
      if (component->kind() == ComponentKind::integrator || (is_law && component->law().table_count > 0)) continue;
      if (found.empty() || found.back() != component->plugin) found.push_back(component->plugin);
    }
    return found;
  }();
  return plugins;
}

inline const springnet_component& shipped(std::uint32_t kind, const std::string& id) {
  for (const springnet_plugin* plugin : shipped_plugins()) {
    for (std::uint32_t i = 0; i < plugin->component_count; ++i) {
      const springnet_component& component = *plugin->components[i];
      if (component.kind == kind && id == component.id) return component;
    }
  }
  throw std::runtime_error("no component " + id);
}
inline const springnet_component& spring(const std::string& id) { return shipped(SPRINGNET_SPRING_FUNCTION, id); }
inline const springnet_component& viscosity(const std::string& id) { return shipped(SPRINGNET_VISCOSITY_FUNCTION, id); }

// One element of a law: its force and so on as plain numbers.
struct Sample {
  double q = 0.0, rate = 0.0, reference = 1.0;
  std::vector<double> parameters;
};

inline LawAnswer evaluate(const springnet_component& law, const Sample& at) {
  LawInput input;
  input.count = 1;
  input.q = {at.q};
  input.rate = {at.rate};
  input.reference = {at.reference};
  for (const double p : at.parameters) input.parameters.push_back({p});
  LawAnswer answer = evaluate(law, input);
  if (answer.status != SPRINGNET_OK) throw std::runtime_error(answer.message);
  return answer;
}
inline double force(const springnet_component& law, const Sample& at) { return evaluate(law, at).force[0]; }
inline double energy(const springnet_component& law, const Sample& at) { return evaluate(law, at).energy[0]; }
inline double margin(const springnet_component& law, const Sample& at) { return evaluate(law, at).margin[0]; }

// |a - b| in units of the larger, or of `least` where both are small.
inline double relative(double a, double b, double least = 1.0) {
  return std::abs(a - b) / std::max({std::abs(a), std::abs(b), least});
}

}  // namespace springnet::test
