// How a node is in contact, and how that changes: one function says what follows from what happened.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

namespace springnet {

// A node that touches one surface, or two or three where they meet. It slides along all of them, or all take it along.
struct Touch {
  std::int32_t surface = -1;  // -1: none
  bool slides = false;        // else the surfaces take it along
  std::int32_t second = -1;   // likewise
  std::int32_t third = -1;    // with three there is no direction left to slide in

  [[nodiscard]] int count() const noexcept { return third >= 0 ? 3 : second >= 0 ? 2 : surface >= 0 ? 1 : 0; }
  [[nodiscard]] std::array<std::int32_t, 3> surfaces() const noexcept { return {surface, second, third}; }
  [[nodiscard]] bool has(std::int32_t other) const noexcept {
    return other >= 0 && (surface == other || second == other || third == other);
  }
  friend bool operator==(const Touch&, const Touch&) = default;
};

enum class ContactStatus : std::uint8_t { free, sticking, sliding, cornered };
[[nodiscard]] ContactStatus status_of(const Touch& touch) noexcept;

// What happened to a node's contact.
struct ContactCause {
  enum class Kind : std::uint8_t {
    touch,    // it met `surface`
    release,  // it left `surface`
    slip,     // friction cannot hold it any more
    stick     // its slip came to an end
  };
  Kind kind;
  std::int32_t surface = -1;  // of touch and release
  bool sticks = false;        // of touch: friction stopped it
};
// The contact that follows. A surface touched a second time, left without having been touched, a fourth surface, slip
// and stick of a free node change nothing. Who leaves one of several surfaces goes on with the others as it did.
[[nodiscard]] Touch after(const Touch& before, const ContactCause& cause) noexcept;

// Nodes that rebound, and the surfaces from which they do.
using Rebounds = std::map<std::uint32_t, std::vector<std::int32_t>>;

}  // namespace springnet
