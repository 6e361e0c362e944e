// The bytes of a saved state: this head, the identity (what it is of), then the state.
#pragma once

#include <cstdint>
#include <string_view>

#include "text/archive.hpp"

namespace springnet {

struct SavedHead {
  static constexpr std::string_view heading = "springnet state 8\n";
  static constexpr std::size_t size = heading.size() + 24;  // bytes

  SavedHead() = default;
  // Throws Error(input) if they do not begin with a head.
  explicit SavedHead(std::string_view saved);

  std::uint64_t identity_size = 0, state_size = 0;  // bytes
  std::uint32_t identity_sum = 0, state_sum = 0;    // checksums
  void archive(Archive& archive);
  // Throws Error(input) if the head, identity and state do not have so many bytes in all.
  void check_size(std::uint64_t bytes) const;
};

}  // namespace springnet
