// Coordinates in messages.
#pragma once

#include <string>

#include <fmt/format.h>
#include <springnet/network.hpp>

namespace springnet::meshes {

[[nodiscard]] inline std::string text(const Vector3& p) {
  return fmt::format("[{:g}, {:g}, {:g}]", p.x(), p.y(), p.z());
}

}  // namespace springnet::meshes
