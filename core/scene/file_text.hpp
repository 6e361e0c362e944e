// A scene's file as text.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace springnet::scene {

// Bytes. A scene of this size lists millions of numbers, and the TOML library takes up to thirty times as much memory.
inline constexpr std::size_t largest_scene = 64'000'000;

// Of a file, a pipe or a device, read until it ends or is too large. Throws Error(input) for what is larger than that,
// is a folder, is a pipe that nothing writes to, or cannot be read.
[[nodiscard]] std::string read_scene_text(const std::filesystem::path& file);

}  // namespace springnet::scene
