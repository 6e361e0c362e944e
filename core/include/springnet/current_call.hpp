// Which component of a plugin the calling thread is in, for programs that report their crashes.
#pragma once

#include <cstdint>

#include <springnet/export.hpp>

namespace springnet {

struct Component;

// Whom a component is called for.
struct CalledMembers {
  enum class Are : std::uint32_t {
    unknown,
    springs,           // their numbers
    elements,          // their numbers
    springs_of_nodes,  // all or some springs of these nodes
    nodes_from         // some nodes, of which this is the first
  };
  Are are = Are::unknown;
  std::uint32_t count = 0;
  std::uint32_t stride = 1;                // of `numbers`
  const std::uint32_t* numbers = nullptr;  // [count], 0xffffffff: a place without a member
  const std::uint32_t* user = nullptr;     // numbers are indices into this, unless it is null

  // Member i as the user numbers it, or 0xffffffff.
  [[nodiscard]] std::uint32_t number(std::uint32_t i) const noexcept {
    const std::uint32_t own = numbers[i * stride];
    return user == nullptr || own == 0xffffffffu ? own : user[own];
  }
  // Those from member `begin` on.
  [[nodiscard]] CalledMembers part(std::uint32_t begin, std::uint32_t size) const noexcept {
    if (numbers == nullptr) return {};
    return {are, size, stride, numbers + begin * stride, user};
  }
};

struct CurrentCall {
  const Component* component = nullptr;  // null: none
  CalledMembers members;
};

// The innermost call of the calling thread. Async-signal-safe; what it points to is valid as long as the call lasts.
[[nodiscard]] SPRINGNET_API CurrentCall current_call() noexcept;

}  // namespace springnet
