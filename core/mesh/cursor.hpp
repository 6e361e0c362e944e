// Sequential reader of words, numbers and bytes of a file.
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
  // Errors from here on give a byte offset if binary, else a line.
  void set_binary(bool binary) noexcept { binary_ = binary; }
  // Place of the last item read, and the current place.
  [[nodiscard]] Place place() const noexcept { return {last_, binary_}; }
  [[nodiscard]] Place here() const noexcept { return {at_, binary_}; }
  [[noreturn]] void fail(std::string_view message) const { source_->fail(place(), message); }

  // Skips white space; true if nothing is left.
  bool at_end() noexcept;
  // `what` in the functions below names the expected item in errors.
  std::string_view word(std::string_view what);
  [[nodiscard]] std::string_view peek() noexcept;  // the next word, empty at the end
  double real(std::string_view what);              // finite
  template <std::integral T>
  T integer(std::string_view what);
  // Reads a count of items that take at least `bytes_each` bytes each, and checks it against the rest of the file
  // before memory is reserved.
  std::size_t count(std::string_view what, std::size_t bytes_each);
  void check_count(std::uint64_t count, std::size_t bytes_each, std::string_view what) const;

  // The rest of this line without its end; advances to the next line.
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

// Parses all of `text` as a number. False if it is not one, or out of range.
[[nodiscard]] bool parse_real(std::string_view text, double& value);
template <std::integral T>
[[nodiscard]] bool parse_integer(std::string_view text, T& value);

}  // namespace springnet::meshes
