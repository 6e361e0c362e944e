// The scalars of an element's nodes that a law over several invariants reads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <springnet/sdk/plugin.h>

namespace springnet::sdk {

// The nodes of its elements, numbered from 0 in the order of abi/law.h.
enum class Shape : std::uint32_t {
  none = 0,  // a law over one invariant
  chain = SPRINGNET_CHAIN,
  triangle = SPRINGNET_TRIANGLE,
  hinge = SPRINGNET_HINGE,
  tetrahedron = SPRINGNET_TETRAHEDRON
};
[[nodiscard]] constexpr std::size_t corners_of(Shape shape) {
  return shape == Shape::none ? 0 : (shape == Shape::chain || shape == Shape::triangle ? 3 : 4);
}

// One entry of `static constexpr Scalar invariants[]`.
struct Scalar {
  std::uint32_t kind;
  std::array<std::uint32_t, 4> corners;
  std::uint32_t flags = 0;

  // Number of corners that the kind has.
  [[nodiscard]] constexpr std::size_t corner_count() const {
    return kind == SPRINGNET_LENGTH ? 2 : (kind == SPRINGNET_VOLUME || kind == SPRINGNET_DIHEDRAL ? 4 : 3);
  }
  [[nodiscard]] constexpr bool reference_only() const { return (flags & SPRINGNET_REFERENCE_ONLY) != 0; }
  [[nodiscard]] constexpr springnet_invariant abi() const {
    return {sizeof(springnet_invariant), kind, {corners[0], corners[1], corners[2], corners[3]}, flags, 0};
  }
};

// m, between two nodes
[[nodiscard]] constexpr Scalar length_of(std::uint32_t a, std::uint32_t b) { return {SPRINGNET_LENGTH, {a, b, 0, 0}}; }
// rad, at b between the directions to a and c, 0 to pi
[[nodiscard]] constexpr Scalar angle_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return {SPRINGNET_ANGLE, {a, b, c, 0}};
}
// rad, -pi to pi: of the edge a b between the triangles (a, b, c) and (b, a, d); 0 where flat
[[nodiscard]] constexpr Scalar dihedral_of(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return {SPRINGNET_DIHEDRAL, {a, b, c, d}};
}
// m^2
[[nodiscard]] constexpr Scalar area_of(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return {SPRINGNET_AREA, {a, b, c, 0}};
}
// m^3, signed
[[nodiscard]] constexpr Scalar volume_of(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return {SPRINGNET_VOLUME, {a, b, c, d}};
}
// The law reads the value at rest alone, e.reference; there is no force on it, and it costs nothing in a step.
[[nodiscard]] constexpr Scalar at_rest(Scalar scalar) {
  scalar.flags |= SPRINGNET_REFERENCE_ONLY;
  return scalar;
}

namespace detail {

[[nodiscard]] constexpr bool is_same(const Scalar& a, const Scalar& b) {
  return a.kind == b.kind && a.corners == b.corners;
}
// Whether a list suits a shape: corners that exist, each once in an invariant, and no invariant twice.
[[nodiscard]] constexpr bool is_valid(Shape shape, std::span<const Scalar> list) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (std::size_t a = 0; a < list[i].corner_count(); ++a) {
      if (list[i].corners[a] >= corners_of(shape)) return false;
      for (std::size_t b = 0; b < a; ++b)
        if (list[i].corners[a] == list[i].corners[b]) return false;
    }
    for (std::size_t j = 0; j < i; ++j)
      if (is_same(list[i], list[j])) return false;
  }
  return true;
}

// A list in the form of the ABI.
template <class List>
struct ScalarTable {
  static constexpr std::size_t count = List::get().size();
  static constexpr auto entries = [] {
    std::array<springnet_invariant, (count > 0 ? count : 1)> result{};
    for (std::size_t i = 0; i < count; ++i) result[i] = List::get()[i].abi();
    return result;
  }();
  static constexpr auto pointers = [] {
    std::array<const springnet_invariant*, (count > 0 ? count : 1)> result{};
    for (std::size_t i = 0; i < count; ++i) result[i] = &entries[i];
    return result;
  }();
  static constexpr const springnet_invariant* const* pointer = count > 0 ? pointers.data() : nullptr;
};

}  // namespace detail
}  // namespace springnet::sdk
