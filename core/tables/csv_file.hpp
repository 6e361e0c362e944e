// A text file with every write checked.
#pragma once

#include <charconv>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include <springnet/network.hpp>

#include "files/checked_file.hpp"

namespace springnet {

// A text as it stands in a cell: in quotes where a comma, a quote or an end of line would end it early.
[[nodiscard]] std::string csv_cell(std::string_view text);

class CsvFile {
 public:
  using Clock = std::chrono::steady_clock;

  // Creates the file with this header line, which can be read at once, as can the first record. end_record() writes the
  // file at most once in `patience`. Throws Error(input) if it cannot be created, OutputError if it cannot be written.
  CsvFile(const OutputFile& file, std::string_view header, Clock::duration patience = std::chrono::seconds(1));
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;

  CsvFile& operator<<(double value) { return number(value); }
  CsvFile& operator<<(float value) { return number(value); }
  CsvFile& operator<<(std::uint32_t value) { return number(value); }
  CsvFile& operator<<(char character) {
    *file_.room(1) = character;
    file_.used(1);
    return *this;
  }
  CsvFile& operator<<(std::string_view text);
  // A comma and each coordinate.
  CsvFile& operator<<(const Vector3& vector) {
    for (const double coordinate : vector) *this << ',' << coordinate;
    return *this;
  }

  // These throw OutputError if the file cannot be written.
  // The rows since the last call are the record of this time, s, and part of the table from now on. Writes now and
  // then, so that a reader beside a run, or after its end by force, finds what happened until shortly before.
  void end_record(double time);
  void flush();
  void close();

 private:
  // Longest shortest decimal of a double is "-2.2250738585072014e-308": 24 characters.
  static constexpr std::size_t longest_number = 32;

  template <class Number>
  CsvFile& number(Number value) {
    char* const begin = file_.room(longest_number);
    file_.used(static_cast<std::size_t>(std::to_chars(begin, begin + longest_number, value).ptr - begin));
    return *this;
  }

  CheckedFile file_;
  Clock::duration patience_;
  Clock::time_point flushed_;
};

}  // namespace springnet
