// Files that a scene names, and where they may lie.
#pragma once

#include <filesystem>

#include <springnet/scene.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

struct Files {
  std::filesystem::path folder;  // of the scene; may be empty
  OutsideFiles outside = OutsideFiles::refused;

  // The path in a text of the scene, seen from its folder. Every reader of a file uses this. Throws Error(input) for a
  // path that leads out of the folder, by "..", by links or because it is absolute, unless that is allowed.
  [[nodiscard]] std::filesystem::path resolve(const Value& name) const;
};

}  // namespace springnet::scene
