// A mesh file, read as a whole, and error messages with a place in it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include <springnet/loading.hpp>

namespace springnet::meshes {

// An offset into the file, reported as a line of text or as a byte.
struct Place {
  std::size_t offset = 0;
  bool binary = false;
};

class Source {
 public:
  // Throws Error(input) if it is not a regular file, cannot be read, or is empty.
  // wants_cells: else points alone are read, also those that no cell uses.
  explicit Source(const std::filesystem::path& file, LoadingCallback loading = {}, bool wants_cells = true);

  [[nodiscard]] std::string_view text() const noexcept { return text_; }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] bool wants_cells() const noexcept { return wants_cells_; }
  [[nodiscard]] std::string description(Place place) const;  // "line 3" or "byte 80"

  // Tells how much of the file has been read.
  void tell(Place place) const;

  // Error messages quote nothing from the file: a scene may name any file, even one that the reader of the message must
  // not see. Throws Error(input): "file:line: message" or "file: byte n: message".
  [[noreturn]] void fail(Place place, std::string_view message) const;
  // Throws Error(input): "file: message".
  [[noreturn]] void fail(std::string_view message) const;

 private:
  [[nodiscard]] std::ptrdiff_t line_of(Place place) const;

  std::string name_;
  std::string text_;
  LoadingCallback loading_;  // empty: nothing is told
  std::string stage_;
  bool wants_cells_;
};

[[nodiscard]] bool equal_ignoring_case(std::string_view a, std::string_view b) noexcept;

}  // namespace springnet::meshes
