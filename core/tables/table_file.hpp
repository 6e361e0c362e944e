// The file of one table, in text or binary form.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include <springnet/network.hpp>
#include <springnet/output_folder.hpp>

#include "files/checked_file.hpp"
#include "tables/csv_file.hpp"
#include "tables/table_form.hpp"

namespace springnet {

class TableFile {
 public:
  // Creates the file and writes its header: binary with this precision, if given, or text.
  // Throws Error(input) if the file cannot be created, OutputError, as all below, if it cannot be written.
  TableFile(const OutputFile& file, const TableForm& form, std::optional<OutputOptions::Precision> binary = {});
  // Opens one that ended there; see CheckedFile.
  TableFile(const OutputFile& file, const CheckedFile::End& end, std::optional<OutputOptions::Precision> binary);
  void go_on() { text_ ? text_->go_on() : numbers_->go_on(); }

  // Begins the record of this time, s, and drops a record that an exception left unfinished.
  void begin_record(double time);
  // Begins a row of this time, s; its cells follow in the order of the columns.
  void row(double time) {
    if (!text_) return;
    if (row_is_open_) *text_ << '\n';
    row_is_open_ = true;
    *text_ << time;
  }
  TableFile& operator<<(double value) {
    if (text_) {
      *text_ << ',' << value;
    } else {
      write(value);
    }
    return *this;
  }
  TableFile& operator<<(const Vector3& vector) {
    for (const double coordinate : vector) *this << coordinate;
    return *this;
  }
  // The number of a node, spring and so on, or a count. In text only: in the binary form the header has these numbers.
  TableFile& operator<<(std::uint32_t value) {
    if (text_) *text_ << ',' << value;
    return *this;
  }
  TableFile& operator<<(std::string_view text);  // in text only
  void end_record();

  // Writes all records to the file, and tells where it ends.
  [[nodiscard]] CheckedFile::End flushed_end() { return text_ ? text_->flushed_end() : numbers_->flushed_end(); }
  void close();

 private:
  void write(double value) {
    if (*binary_ == OutputOptions::Precision::float64) {
      write_number(*numbers_, value);
    } else {
      write_number(*numbers_, static_cast<float>(value));
    }
  }

  std::optional<OutputOptions::Precision> binary_;
  std::optional<CsvFile> text_;         // one of these two
  std::optional<CheckedFile> numbers_;  // binary
  double time_ = 0.0;                   // s, of the record
  bool row_is_open_ = false;            // its line has not been ended
};

}  // namespace springnet
