#include "output/view/energy.hpp"

#include <algorithm>

namespace springnet::view {

namespace {

template <class Surface>
bool any_moves(const std::vector<Surface>& surfaces) {
  return std::any_of(surfaces.begin(), surfaces.end(), [](const Surface& each) { return each.motion.has_value(); });
}

bool any_damps(const Network& network) {
  return std::any_of(network.materials().begin(), network.materials().end(),
                     [](const Material& each) { return each.viscosity.has_value(); }) ||
         std::any_of(network.neurons().begin(), network.neurons().end(),
                     [](const LawUse& each) { return each.id != "point_mass"; });
}

// Laws of spring functions without an energy: "'tether'".
std::string without_energy(const Network& network, const PluginHost& plugins) {
  std::vector<std::string> laws;
  for (const Material& material : network.materials()) {
    if (!material.spring) continue;
    const auto component = plugins.find(ComponentKind::spring_function, material.spring->id);
    const std::string name = "'" + material.spring->id + "'";
    if (!component || (component->description->capabilities & SPRINGNET_HAS_ENERGY) != 0) continue;
    if (std::find(laws.begin(), laws.end(), name) == laws.end()) laws.push_back(name);
  }
  std::string text;
  for (const std::string& law : laws) text += (text.empty() ? "" : ", ") + law;
  return text;
}

}  // namespace

std::vector<std::string> left_out_of_energy(const Content& content) {
  const Network& network = content.scene.network;
  std::vector<std::string> parts;
  if (content.forces.all > 0) parts.emplace_back("the work of loads");
  if (!network.moves().empty()) parts.emplace_back("the work that moves nodes");
  if (any_moves(network.planes()) || any_moves(network.instruments())) {
    parts.emplace_back("the work of moving obstacles");
  }
  if (any_damps(network)) parts.emplace_back("what damping took");
  if (!network.planes().empty() || !network.instruments().empty()) parts.emplace_back("what contact took");
  if (!content.removed.empty()) parts.emplace_back("what was stored in removed springs");
  if (content.plugins) {
    const std::string laws = without_energy(network, *content.plugins);
    if (!laws.empty()) parts.push_back("the energy of " + laws + ", which has no formula for it");
  }
  return parts;
}

}  // namespace springnet::view
