// Units of laws' parameters, for readers.
#pragma once

#include <string>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet::view {

// "linear (stiffness 6 N/m)"; without units where the plugins, which may be null, do not have the law.
[[nodiscard]] std::string text_of(const PluginHost* plugins, ComponentKind kind, const LawUse& use);
[[nodiscard]] std::string text_of(const PluginHost* plugins, const Material& material);

}  // namespace springnet::view
