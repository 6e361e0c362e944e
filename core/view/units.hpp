// Laws and their parameters with units, as text.
#pragma once

#include <string>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet::view {

// "linear (stiffness 6 N/m)"; without units if `plugins` is null or does not have the law.
[[nodiscard]] std::string text_of(const PluginHost* plugins, ComponentKind kind, const LawUse& use);
[[nodiscard]] std::string text_of(const PluginHost* plugins, const Material& material);

}  // namespace springnet::view
