// The contact state of a node and its transitions, all in one function.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

namespace springnet {

// Contact of a node with one surface, or with two or three where they meet. It slides along all of them or sticks to
// all.
struct Touch {
  std::int32_t surface = -1;  // -1: none
  bool slides = false;        // else it sticks: the surfaces carry it
  std::int32_t second = -1;   // -1: none
  std::int32_t third = -1;    // with three there is no direction to slide in

  [[nodiscard]] int count() const noexcept { return third >= 0 ? 3 : second >= 0 ? 2 : surface >= 0 ? 1 : 0; }
  [[nodiscard]] std::array<std::int32_t, 3> surfaces() const noexcept { return {surface, second, third}; }
  [[nodiscard]] bool has(std::int32_t other) const noexcept {
    return other >= 0 && (surface == other || second == other || third == other);
  }
  friend bool operator==(const Touch&, const Touch&) = default;
};

enum class ContactStatus : std::uint8_t { free, sticking, sliding, cornered };
[[nodiscard]] ContactStatus status_of(const Touch& touch) noexcept;

// A contact event of a node.
struct ContactCause {
  enum class Kind : std::uint8_t {
    touch,    // it reached `surface`
    release,  // it left `surface`
    slip,     // it begins to slip
    stick     // its slip ended
  };
  Kind kind;
  std::int32_t surface = -1;  // for touch and release
  bool sticks = false;        // for touch: friction stops it
};
// The state after an event. No change: touch of a surface already touched or of a fourth one, release from a surface
// not touched, slip and stick of a free node. A node released by one of several surfaces keeps sliding or sticking on
// the others.
[[nodiscard]] Touch after(const Touch& before, const ContactCause& cause) noexcept;

// Rebounding nodes, and the surfaces they rebound from.
using Rebounds = std::map<std::uint32_t, std::vector<std::int32_t>>;

}  // namespace springnet
