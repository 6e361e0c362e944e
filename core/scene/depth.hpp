// Nesting depth of a TOML text, checked before parsing: the TOML library recurses without bound for keys with many
// dots.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace springnet::scene {

// Largest depth of tables, lists and parts of dotted keys; a scene needs six.
inline constexpr std::size_t deepest_level = 32;

struct TextPlace {
  std::size_t line;    // from 1
  std::size_t column;  // from 1, in bytes
};

// Where a text first nests deeper than `deepest_level`, by brackets, dots of a key, or both. For text that is not TOML
// the result is arbitrary, but only beyond the place of the TOML error.
[[nodiscard]] std::optional<TextPlace> find_too_deep(std::string_view text);

}  // namespace springnet::scene
