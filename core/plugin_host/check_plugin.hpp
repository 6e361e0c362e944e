// Validation of a plugin's description. Everything behind its pointers is foreign data, perhaps of another version:
// a field is read only after the size of its struct was checked.
#pragma once

#include <string>
#include <vector>

#include <springnet/plugin_host.hpp>

namespace springnet {

struct PluginCheck {
  std::string wrong;                    // with the whole plugin, and what to do; empty: nothing
  std::vector<std::string> not_usable;  // [component] why this host cannot use it; empty: it can
};

// A mistake in a description refuses the plugin. A component that needs a newer host is not usable, but the others are.
[[nodiscard]] PluginCheck check_plugin(const springnet_plugin& plugin);

}  // namespace springnet
