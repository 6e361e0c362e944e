// The scalars of an element's nodes that laws over several invariants read. Plain data, for kernels too.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace springnet::layers {

// Invariant, for kernels: the header of networks has more than plain loops.
enum class Measure : std::uint8_t { angle, dihedral, area, volume, length };

// Most that the laws of an element read, both together.
inline constexpr std::size_t max_scalars = 7;

struct ElementScalar {
  Measure measure;
  bool reference_only;                 // its value is not computed, and there is no force on it
  std::array<std::uint8_t, 4> corner;  // of the element, in the order of the measure

  [[nodiscard]] constexpr std::size_t corner_count() const noexcept {
    return measure == Measure::length ? 2 : (measure == Measure::dihedral || measure == Measure::volume ? 4 : 3);
  }
  // The power of lengths that it is: as it grows with an element that grows evenly.
  [[nodiscard]] constexpr int dimension() const noexcept {
    return measure == Measure::length ? 1 : measure == Measure::area ? 2 : measure == Measure::volume ? 3 : 0;
  }
};

// Of the spring function, then those of the viscosity function that the former does not read.
struct ScalarList {
  std::size_t count = 0;  // 0: the laws read one invariant
  std::size_t corners = 0;
  std::array<ElementScalar, max_scalars> scalar{};
};

}  // namespace springnet::layers
