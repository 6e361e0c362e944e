// The rows of a CSV file of any size, one after another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "files/input_file.hpp"

namespace springnet::learning {

// Cells are separated by commas. Spaces around them, quotation marks that enclose them, blank lines, lines that begin
// with '#', a byte order mark and carriage returns at ends of lines are skipped. Functions throw Error(input),
// "file:line: what; what to do".
class CsvRows {
 public:
  explicit CsvRows(const std::filesystem::path& file);

  // Whether the file begins with these bytes; before the first row.
  [[nodiscard]] bool begins_with(std::string_view bytes) const { return buffer_.starts_with(bytes); }
  // Reads the next row; false at the end. Cells are valid until the next call.
  bool next();
  [[nodiscard]] const std::vector<std::string_view>& cells() const noexcept { return cells_; }
  [[nodiscard]] std::uint32_t line() const noexcept { return line_; }              // of this row, from 1
  [[nodiscard]] bool is_ended() const noexcept { return is_ended_; }               // by an end of line
  [[nodiscard]] std::uint64_t bytes_read() const noexcept { return bytes_read_; }  // up to the end of this row
  [[nodiscard]] std::optional<std::uint64_t> file_size() const noexcept { return in_.size(); }

  [[nodiscard]] const std::string& name() const noexcept { return name_; }  // of the file, for messages
  [[nodiscard]] std::string place() const;                                  // "file:line"
  [[noreturn]] void fail(std::string_view what) const;

 private:
  std::optional<std::string_view> next_line();
  bool fill();
  void split(std::string_view line);

  std::string name_;
  InputFile in_;
  std::string buffer_;
  std::size_t at_ = 0;    // in the buffer, where the next line begins
  bool is_read_ = false;  // to the end
  bool is_ended_ = true;
  std::uint32_t line_ = 0;
  std::uint64_t bytes_read_ = 0;
  std::vector<std::string_view> cells_;
};

}  // namespace springnet::learning
