// Files that a scene names, and where they may be.
#pragma once

#include <filesystem>

#include <springnet/scene.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

struct Files {
  std::filesystem::path folder;  // of the scene; may be empty
  OutsideFiles outside = OutsideFiles::refused;

  // Resolves a path of the scene relative to its folder. Every reader of a file uses this. Throws Error(input) if the
  // path leads out of the folder, by "..", a link or an absolute path, unless that is allowed.
  [[nodiscard]] std::filesystem::path resolve(const Value& name) const;
};

}  // namespace springnet::scene
