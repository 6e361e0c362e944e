// A whole scene that uses a component, to start from.
#pragma once

#include <string>

#include <springnet/plugin_host.hpp>

namespace springnet::tool {

// Runs as it is, with sample values of required parameters. name: of the component in scenes.
[[nodiscard]] std::string sample_scene(const Component& component, const std::string& name);

}  // namespace springnet::tool
