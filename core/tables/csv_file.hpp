// A file of comma separated values, with every write checked.
#pragma once

#include <charconv>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "files/checked_file.hpp"

namespace springnet {

// The text of a cell, in quotes if it has a comma, a quote or an end of line.
[[nodiscard]] std::string csv_cell(std::string_view text);

class CsvFile {
 public:
  using Clock = std::chrono::steady_clock;

  // Creates the file and writes the header line. The first record is flushed at once, later ones at most once per
  // `flush_interval`. Throws Error(input) if it cannot be created, OutputError if it cannot be written.
  CsvFile(const OutputFile& file, std::string_view header, Clock::duration flush_interval = std::chrono::seconds(1));
  // Opens one that ended there; see CheckedFile.
  CsvFile(const OutputFile& file, const CheckedFile::End& end, Clock::duration flush_interval = std::chrono::seconds(1))
      : file_(file, end), flush_interval_(flush_interval), flushed_(Clock::now() - flush_interval) {}
  void go_on() { file_.go_on(); }
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

  // These throw OutputError if the file cannot be written.
  // Ends the record of this time, s: the rows since the last call. Flushes now and then, so that a reader finds recent
  // records during the run, or after it was killed.
  void end_record(double time);
  void drop_unfinished() { file_.drop_unfinished(); }  // the rows since then
  void flush();
  [[nodiscard]] CheckedFile::End flushed_end() { return file_.flushed_end(); }
  void close();

 private:
  // Shortest decimals that read back as the same double have up to 24 characters: "-2.2250738585072014e-308".
  static constexpr std::size_t max_number_length = 32;

  template <class Number>
  CsvFile& number(Number value) {
    char* const begin = file_.room(max_number_length);
    file_.used(static_cast<std::size_t>(std::to_chars(begin, begin + max_number_length, value).ptr - begin));
    return *this;
  }

  CheckedFile file_;
  Clock::duration flush_interval_;
  Clock::time_point flushed_;  // when last
};

}  // namespace springnet
