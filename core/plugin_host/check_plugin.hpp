// Whether what a plugin shows of itself can be used. Everything behind the pointers was written by someone else,
// perhaps for another version: nothing is read before the size that covers it was checked.
#pragma once

#include <string>

#include <springnet/plugin_host.hpp>

namespace springnet {

// Empty if every component of the plugin can be taken, else what is wrong and what to do.
[[nodiscard]] std::string check_plugin(const springnet_plugin& plugin);

}  // namespace springnet
