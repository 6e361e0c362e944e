// Reads a scene file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace springnet::scene {

// Bytes. A scene of this size lists millions of numbers, and the TOML library takes up to thirty times as much memory.
inline constexpr std::size_t largest_scene = 64'000'000;

inline constexpr std::size_t max_path_length = 200;  // characters of it in messages

// Reads a file, pipe or device to its end. Throws Error(input) if it is larger than `largest_scene`, a folder, a pipe
// without a writer, or cannot be read.
[[nodiscard]] std::string read_scene_text(const std::filesystem::path& file);

}  // namespace springnet::scene
