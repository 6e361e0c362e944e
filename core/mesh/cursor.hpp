// Reads words, numbers and bytes of a file one after the other.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "mesh/source.hpp"

namespace springnet::meshes {

template <class T>
[[nodiscard]] T from_bytes(const char* bytes, bool swap) noexcept {
  char ordered[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i) ordered[i] = bytes[swap ? sizeof(T) - 1 - i : i];
  T value;
  std::memcpy(&value, ordered, sizeof(T));
  return value;
}

class Cursor {
 public:
  // Reads [begin, end) of the file.
  Cursor(const Source& source, std::size_t begin, std::size_t end) : source_(&source), at_(begin), end_(end) {}
  explicit Cursor(const Source& source) : Cursor(source, 0, source.text().size()) {}

  [[nodiscard]] const Source& source() const noexcept { return *source_; }
  [[nodiscard]] std::size_t offset() const noexcept { return at_; }
  [[nodiscard]] std::size_t left() const noexcept { return end_ - at_; }
  // Errors name bytes from here on.
  void set_binary(bool binary) noexcept { binary_ = binary; }
  // Of what was read last, or of here.
  [[nodiscard]] Place place() const noexcept { return {last_, binary_}; }
  [[nodiscard]] Place here() const noexcept { return {at_, binary_}; }
  [[noreturn]] void fail(std::string_view message) const { source_->fail(place(), message); }

  // Whether nothing but white space is left; skips it.
  bool at_end() noexcept;
  // All that follow name what should be there, for the error.
  std::string_view word(std::string_view what);
  [[nodiscard]] std::string_view peek() noexcept;  // the next word, empty at the end
  double real(std::string_view what);              // finite
  template <std::integral T>
  T integer(std::string_view what);
  // A number of things of which each takes that many bytes at least: checked against what is left, before anything is
  // reserved for them.
  std::size_t count(std::string_view what, std::size_t bytes_each);
  void check_count(std::uint64_t count, std::size_t bytes_each, std::string_view what) const;

  // What is left of this line, without the end of it; goes to the next one.
  std::string_view line() noexcept;
  template <class T>
  T binary(bool swap, std::string_view what) {
    return from_bytes<T>(bytes(sizeof(T), what).data(), swap);
  }
  std::string_view bytes(std::size_t count, std::string_view what);
  void skip_to(std::size_t offset) noexcept { at_ = last_ = offset; }

 private:
  const Source* source_;
  std::size_t at_;
  std::size_t end_;
  std::size_t last_ = 0;
  bool binary_ = false;
};

// The whole of `text` as a number. False if it is none, or too great.
[[nodiscard]] bool parse_real(std::string_view text, double& value);
template <std::integral T>
[[nodiscard]] bool parse_integer(std::string_view text, T& value);

}  // namespace springnet::meshes
