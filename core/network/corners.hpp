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
    case Invariant::chain:
    case Invariant::triangle:
      return 3;
    case Invariant::dihedral:
    case Invariant::volume:
    case Invariant::hinge:
    case Invariant::tetrahedron:
      return 4;
    case Invariant::enclosed_volume:
      break;
  }
  return 0;
}

// The invariant that counts as the value of an element.
[[nodiscard]] constexpr Invariant value_invariant(Invariant invariant) noexcept {
  switch (invariant) {
    case Invariant::chain:
      return Invariant::angle;
    case Invariant::triangle:
      return Invariant::area;
    case Invariant::hinge:
      return Invariant::dihedral;
    case Invariant::tetrahedron:
      return Invariant::volume;
    default:
      return invariant;
  }
}

}  // namespace springnet
