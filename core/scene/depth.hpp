// How deep a TOML text nests, seen before the TOML library does, which recurses without a bound for keys with many
// dots.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace springnet::scene {

// Levels of tables, lists and parts of dotted keys; the keys of a scene need six.
inline constexpr std::size_t deepest_level = 32;

struct TextPlace {
  std::size_t line;    // from 1
  std::size_t column;  // from 1, in bytes
};

// Where a text first goes deeper than `deepest_level`: by brackets within brackets, by the dots of a key, or both. Of
// text that is not TOML it may say anything, but only beyond the place where the TOML library stops.
[[nodiscard]] std::optional<TextPlace> find_too_deep(std::string_view text);

}  // namespace springnet::scene
