// Shared libraries, which stay loaded for the life of the process, and the folders of the library's own plugins.
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

// The folders of the plugins that come with the library, preferred ones first.
[[nodiscard]] std::vector<std::filesystem::path> own_plugin_folders();

}  // namespace springnet
