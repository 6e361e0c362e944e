#include "view/energy.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace springnet::view {

namespace {

template <class Surface>
bool any_moving(const std::vector<Surface>& surfaces) {
  return std::any_of(surfaces.begin(), surfaces.end(), [](const Surface& each) { return each.motion || each.turn; });
}

bool has_damping(const Network& network) {
  return std::any_of(network.materials().begin(), network.materials().end(),
                     [](const Material& each) { return each.viscosity.has_value(); }) ||
         std::any_of(network.neurons().begin(), network.neurons().end(),
                     [](const LawUse& each) { return each.id != "point_mass"; });
}

// Spring functions without an energy.
std::vector<std::string> without_energy(const Network& network, const PluginHost& plugins) {
  std::vector<std::string> laws;
  for (const Material& material : network.materials()) {
    if (!material.spring) continue;
    const auto component = material.spring->component != nullptr
                               ? material.spring->component
                               : plugins.find(ComponentKind::spring_function, material.spring->id);
    if (!component || (component->description->capabilities & SPRINGNET_HAS_ENERGY) != 0) continue;
    if (std::find(laws.begin(), laws.end(), material.spring->id) == laws.end()) laws.push_back(material.spring->id);
  }
  return laws;
}

}  // namespace

std::vector<std::string> left_out_of_energy(const Content& content) {
  const Network& network = content.scene.network;
  std::vector<std::string> sources, parts;
  if (content.forces.all > 0) sources.emplace_back("loads");
  if (!network.moves().empty()) sources.emplace_back("moved nodes");
  if (any_moving(network.planes()) || any_moving(network.instruments())) sources.emplace_back("moving obstacles");
  if (!network.inputs().empty()) sources.emplace_back("input signals");
  if (!sources.empty()) parts.push_back(fmt::format("the work of {}", fmt::join(sources, " and ")));
  if (has_damping(network)) parts.emplace_back("damping");
  if (!content.law_states.empty()) parts.emplace_back("what laws with memory dissipate");
  if (!network.planes().empty() || !network.instruments().empty() || !network.contacts().empty())
    parts.emplace_back("contact");
  if (!content.removed.empty()) parts.emplace_back("removed springs");
  if (content.plugins) {
    const std::vector<std::string> laws = without_energy(network, *content.plugins);
    if (!laws.empty()) parts.push_back(fmt::format("the energy of springs with the law {}", fmt::join(laws, " and ")));
  }
  return parts;
}

}  // namespace springnet::view
