// What a saved state is of.
#pragma once

#include <string>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "text/identity.hpp"

namespace springnet {

// "linear@springnet.springs 1.2"
[[nodiscard]] std::string identity_text(const Component& component);
// "stiffness 3, damping 0.5", in the order in which they are declared.
[[nodiscard]] std::string parameters_text(const Component& component, const std::vector<double>& values);
// Everything about a network that the motion depends on, and the laws and neurons that it names. What has no mechanical
// effect is left out: names, bodies, faces.
[[nodiscard]] Identity identity_of(const Network& network, const PluginHost& plugins);

}  // namespace springnet
