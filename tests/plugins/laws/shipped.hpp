// The shipped plugins of laws and neurons, linked into the test.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "law_call.hpp"

extern "C" {
extern const springnet_plugin springnet_plugin_entry_spring_linear;
extern const springnet_plugin springnet_plugin_entry_spring_nonlinear;
extern const springnet_plugin springnet_plugin_entry_spring_exponential;
extern const springnet_plugin springnet_plugin_entry_spring_rupturing;
extern const springnet_plugin springnet_plugin_entry_spring_muscle;
extern const springnet_plugin springnet_plugin_entry_spring_maxwell;
extern const springnet_plugin springnet_plugin_entry_spring_standard_linear_solid;
extern const springnet_plugin springnet_plugin_entry_spring_plastic;
extern const springnet_plugin springnet_plugin_entry_spring_damaging;
extern const springnet_plugin springnet_plugin_entry_spring_membrane;
extern const springnet_plugin springnet_plugin_entry_spring_solid;
extern const springnet_plugin springnet_plugin_entry_spring_fibre_solid;
extern const springnet_plugin springnet_plugin_entry_spring_shell;
extern const springnet_plugin springnet_plugin_entry_viscosity_linear;
extern const springnet_plugin springnet_plugin_entry_viscosity_relative;
extern const springnet_plugin springnet_plugin_entry_viscosity_power;
extern const springnet_plugin springnet_plugin_entry_viscosity_viscous_membrane;
extern const springnet_plugin springnet_plugin_entry_viscosity_viscous_solid;
extern const springnet_plugin springnet_plugin_entry_neuron_point_mass;
extern const springnet_plugin springnet_plugin_entry_neuron_dragged;
}

namespace springnet::test {

inline const std::vector<const springnet_plugin*>& shipped_plugins() {
  static const std::vector<const springnet_plugin*> plugins{&springnet_plugin_entry_spring_linear,
                                                            &springnet_plugin_entry_spring_nonlinear,
                                                            &springnet_plugin_entry_spring_exponential,
                                                            &springnet_plugin_entry_spring_rupturing,
                                                            &springnet_plugin_entry_spring_muscle,
                                                            &springnet_plugin_entry_spring_maxwell,
                                                            &springnet_plugin_entry_spring_standard_linear_solid,
                                                            &springnet_plugin_entry_spring_plastic,
                                                            &springnet_plugin_entry_spring_damaging,
                                                            &springnet_plugin_entry_spring_membrane,
                                                            &springnet_plugin_entry_spring_solid,
                                                            &springnet_plugin_entry_spring_fibre_solid,
                                                            &springnet_plugin_entry_spring_shell,
                                                            &springnet_plugin_entry_viscosity_linear,
                                                            &springnet_plugin_entry_viscosity_relative,
                                                            &springnet_plugin_entry_viscosity_power,
                                                            &springnet_plugin_entry_viscosity_viscous_membrane,
                                                            &springnet_plugin_entry_viscosity_viscous_solid,
                                                            &springnet_plugin_entry_neuron_point_mass,
                                                            &springnet_plugin_entry_neuron_dragged};
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
