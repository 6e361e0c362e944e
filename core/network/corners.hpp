// How many nodes the elements of an invariant have.
#pragma once

#include <cstddef>

#include <springnet/network.hpp>

namespace springnet {

// 0 for an enclosed volume, which has as many as its surface.
[[nodiscard]] constexpr std::size_t corners_of(Invariant invariant) noexcept {
  switch (invariant) {
    case Invariant::angle:
    case Invariant::area:
      return 3;
    case Invariant::dihedral:
    case Invariant::volume:
      return 4;
    case Invariant::enclosed_volume:
      break;
  }
  return 0;
}

}  // namespace springnet
