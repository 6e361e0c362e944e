// The components that uses name.
#pragma once

#include <memory>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet {

// Its own, or the host's of its id. Throws Error(plugin) if there is none of this kind.
[[nodiscard]] std::shared_ptr<const Component> component_of(const LawUse& use, ComponentKind kind,
                                                            const PluginHost& plugins);

}  // namespace springnet
