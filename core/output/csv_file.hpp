// A text file written through a buffer, with every write checked.
#pragma once

#include <charconv>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/network.hpp>

#include "output/checked_file.hpp"

namespace springnet {

// A text as it stands in a cell: in quotes where a comma, a quote or an end of line would end it early.
[[nodiscard]] std::string csv_cell(std::string_view text);

class CsvFile {
 public:
  using Clock = std::chrono::steady_clock;

  // Replaces the file by one with this header line, which can be read at once, as can the first record. end_record()
  // writes the file at most once in `patience`. Throws Error(input) if it cannot be created, Error(simulation) if it
  // cannot be written.
  CsvFile(const std::filesystem::path& file, std::string_view header,
          Clock::duration patience = std::chrono::seconds(1));
  ~CsvFile();
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;

  CsvFile& operator<<(double value) { return number(value); }
  CsvFile& operator<<(float value) { return number(value); }
  CsvFile& operator<<(std::uint32_t value) { return number(value); }
  CsvFile& operator<<(char character) {
    reserve();
    buffer_[used_++] = character;
    return *this;
  }
  CsvFile& operator<<(std::string_view text);
  // A comma and each coordinate.
  CsvFile& operator<<(const Vector3& vector) {
    for (const double coordinate : vector) *this << ',' << coordinate;
    return *this;
  }

  // These throw Error(simulation) if the file cannot be written.
  // So that a reader beside a run, or after its end by force, finds what happened until shortly before.
  void end_record();
  void flush();
  void close();

 private:
  // Longest shortest decimal of a double is "-2.2250738585072014e-308": 24 characters.
  static constexpr std::size_t longest_number = 32;

  void reserve() {
    if (buffer_.size() - used_ < longest_number) write_buffer();
  }
  template <class Number>
  CsvFile& number(Number value) {
    reserve();
    char* const begin = buffer_.data() + used_;
    used_ += static_cast<std::size_t>(std::to_chars(begin, begin + longest_number, value).ptr - begin);
    return *this;
  }
  void write_buffer();

  CheckedFile file_;
  std::vector<char> buffer_;
  std::size_t used_ = 0;
  Clock::duration patience_;
  Clock::time_point flushed_;
};

}  // namespace springnet
