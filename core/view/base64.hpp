// Numbers as text for a page: base64 of their bytes, lowest byte first.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace springnet::view {

static_assert(std::endian::native == std::endian::little, "the page reads the bytes as they are in memory");

[[nodiscard]] std::string base64(std::span<const std::byte> bytes);

template <class Number>
[[nodiscard]] std::string base64_of(const std::vector<Number>& numbers) {
  return base64(std::as_bytes(std::span(numbers)));
}

// Characters that encode this many bytes.
[[nodiscard]] constexpr double base64_size(double bytes) { return bytes * 4.0 / 3.0; }

}  // namespace springnet::view
