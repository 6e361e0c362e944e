// A mesh file, read whole, and where in it something is wrong.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace springnet::meshes {

// An offset into the file, told as a line of text or as a byte.
struct Place {
  std::size_t offset = 0;
  bool binary = false;
};

class Source {
 public:
  // Throws Error(input) for what is no file, cannot be read, or is empty.
  explicit Source(const std::filesystem::path& file);

  [[nodiscard]] std::string_view text() const noexcept { return text_; }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

  // Throws Error(input): "file:line: message" or "file: byte n: message".
  [[noreturn]] void fail(Place place, std::string_view message) const;
  // Throws Error(input): "file: message".
  [[noreturn]] void fail(std::string_view message) const;

 private:
  std::string name_;
  std::string text_;
};

// A piece of a file as a message may show it: short, and without what is no letter.
[[nodiscard]] std::string shown(std::string_view text);
[[nodiscard]] bool equal_ignoring_case(std::string_view a, std::string_view b) noexcept;

}  // namespace springnet::meshes
