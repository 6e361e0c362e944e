// Validation of a plugin's description. Everything behind its pointers is foreign data, perhaps of another version:
// a field is read only after the size of its struct was checked.
#pragma once

#include <string>

#include <springnet/plugin_host.hpp>

namespace springnet {

// Empty if every component of the plugin is valid, else what is wrong and what to do.
[[nodiscard]] std::string check_plugin(const springnet_plugin& plugin);

}  // namespace springnet
