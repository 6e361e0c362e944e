// A scene's TOML with its overrides in place, not looked at any further.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>
#include <springnet/scene.hpp>

namespace springnet::scene {

// Throws Error(input) with file, line and column for text that is not TOML, and for an override that is not or that
// leads nowhere.
[[nodiscard]] toml::table parse_document(std::string_view text, std::string_view name,
                                         const std::vector<SceneOverride>& overrides);

}  // namespace springnet::scene
