// Where a PluginHost searches, for programs that look at plugins before they load them.
#pragma once

#include <filesystem>
#include <vector>

#include <springnet/export.hpp>

namespace springnet {

// The files that PluginHost::with_default_search(folders) opens, in its order, each once. Opens none of them. Folders
// that cannot be read are left out.
[[nodiscard]] SPRINGNET_API std::vector<std::filesystem::path> plugin_files(
    const std::vector<std::filesystem::path>& folders = {});

}  // namespace springnet
