// A scene's parsed TOML with overrides applied, not yet interpreted.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>
#include <springnet/scene.hpp>

namespace springnet::scene {

// Throws Error(input), with file, line and column, for text that is not TOML; and for an override whose value is not
// TOML or whose path leads through something that is neither a table nor a list.
[[nodiscard]] toml::table parse_document(std::string_view text, std::string_view name,
                                         const std::vector<SceneOverride>& overrides);

// A number that stands in the document for what is at `place` (Value::place()): messages about it name that.
[[nodiscard]] toml::value<double> number_at(double number, std::string_view place);

}  // namespace springnet::scene
