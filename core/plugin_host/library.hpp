// Shared libraries, which stay loaded for the life of the process, and the folder where the library finds its own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <springnet/sdk/plugin.h>

namespace springnet {

struct OpenedLibrary {
  const springnet_plugin* entry = nullptr;
  std::string reason;  // why there is no entry, and what to do
};

[[nodiscard]] OpenedLibrary open_library(const std::filesystem::path& file);

// ".so", ".dylib" or ".dll".
[[nodiscard]] std::string library_suffix();

// The folders of the plugins that came with the library, best first.
[[nodiscard]] std::vector<std::filesystem::path> own_plugin_folders();

}  // namespace springnet
