// A number that tells values from others: a CRC-32 of their bits. Not against those who mean to deceive.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <type_traits>
#include <vector>

#include <zlib.h>

namespace springnet {

[[nodiscard]] inline std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<z_size_t>(bytes.size())));
}

class Digest {
 public:
  template <class Number>
  requires std::is_arithmetic_v<Number> || std::is_enum_v<Number>
  void add(const Number& value) { bytes(&value, sizeof value); }
  void add(std::string_view text) {
    add(text.size());
    bytes(text.data(), text.size());
  }
  // Three coordinates, and others with begin() and end(): as many as there are.
  template <class List>
  requires requires(const List& list) { list.begin(); }
  void add(const List& list) {
    add(static_cast<std::uint64_t>(list.size()));
    for (const auto& each : list) add(each);
  }
  template <class Value>
  void add(const std::optional<Value>& value) {
    add(value.has_value());
    if (value) add(*value);
  }
  // Of an array without gaps.
  void bytes(const void* data, std::size_t size) {
    if (size > buffer_.size() - used_) flush();
    if (size > buffer_.size()) {
      sum_ = static_cast<std::uint32_t>(crc32_z(sum_, static_cast<const Bytef*>(data), static_cast<z_size_t>(size)));
      return;
    }
    if (size > 0) std::memcpy(buffer_.data() + used_, data, size);
    used_ += size;
  }
  [[nodiscard]] std::uint32_t value() {
    flush();
    return sum_;
  }

 private:
  void flush() {
    sum_ = static_cast<std::uint32_t>(crc32_z(sum_, buffer_.data(), static_cast<z_size_t>(used_)));
    used_ = 0;
  }

  std::array<Bytef, 4096> buffer_;  // single numbers take longer
  std::size_t used_ = 0;
  std::uint32_t sum_ = 0;
};

}  // namespace springnet
