// Numbers and texts as bytes, and back: one function of a class, archive(Archive&), does both. Bytes may come from
// anywhere: sizes and numbers are checked before anything depends on them.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <springnet/error.hpp>

namespace springnet {

// What is read does not have what is wanted.
class ArchiveError : public Error {
 public:
  explicit ArchiveError(const std::string& message) : Error(ErrorKind::input, message) {}
};

class Archive {
 public:
  // Appends to `out`.
  explicit Archive(std::string* out) : out_(out) {}
  // Takes from `in`. Functions throw ArchiveError where it does not have what they want.
  explicit Archive(std::string_view in) : in_(in) {}

  [[nodiscard]] bool reads() const noexcept { return out_ == nullptr; }
  [[nodiscard]] std::size_t left() const noexcept { return in_.size(); }
  [[noreturn]] static void refuse(const std::string& what) {
    throw ArchiveError("the saved state is damaged, or of another simulation: " + what);
  }

  template <class Number>
  requires std::is_arithmetic_v<Number> &&(!std::same_as<Number, bool>)void number(Number& value) {
    bytes(&value, sizeof value);
  }
  void flag(bool& value) {
    std::uint8_t byte = value ? 1 : 0;
    number(byte);
    if (byte > 1) refuse("a flag is neither 0 nor 1");
    value = byte != 0;
  }
  // One of `count` numbers from 0 on, also of an enumeration.
  template <class Number>
  void below(Number& value, std::uint64_t count, const char* what) {
    auto number_of = static_cast<std::uint64_t>(value);
    number(number_of);
    if (number_of >= count) refuse(std::string(what) + " does not exist");
    value = static_cast<Number>(number_of);
  }
  // Three coordinates.
  template <class Vector>
  void vector(Vector& value) {
    for (int c = 0; c < 3; ++c) number(value[c]);
  }
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void numbers(Number* values, std::size_t count) { bytes(values, count * sizeof(Number)); }
  // A list that keeps its size.
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void numbers(std::vector<Number>& values, const char* what) {
    same(values.size(), what);
    numbers(values.data(), values.size());
  }
  template <class Vector>
  requires(!std::is_arithmetic_v<Vector>) void vectors(std::vector<Vector>& values, const char* what) {
    same(values.size(), what);
    for (Vector& each : values) vector(each);
  }
  // A number that must be the same.
  void same(std::uint64_t expected, const char* what) {
    std::uint64_t found = expected;
    number(found);
    if (found != expected)
      refuse(std::string(what) + ": " + std::to_string(found) + " in place of " + std::to_string(expected));
  }
  // The length of a list that is yet to come, each of whose entries takes at least so many bytes.
  [[nodiscard]] std::size_t count(std::size_t present, std::size_t bytes_each, const char* what) {
    std::uint64_t size = present;
    number(size);
    if (reads() && size > in_.size() / bytes_each) refuse(std::string(what) + " end too early");
    return static_cast<std::size_t>(size);
  }
  void text(std::string& value) {
    value.resize(count(value.size(), 1, "characters"));
    bytes(value.data(), value.size());
  }

 private:
  void bytes(void* data, std::size_t size) {
    if (!reads()) {
      out_->append(static_cast<const char*>(data), size);
      return;
    }
    if (size > in_.size()) refuse("it ends too early");
    if (size > 0) std::memcpy(data, in_.data(), size);
    in_.remove_prefix(size);
  }

  std::string* out_ = nullptr;
  std::string_view in_;
};

}  // namespace springnet
