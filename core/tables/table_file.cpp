#include "tables/table_file.hpp"

#include <limits>

namespace springnet {

TableFile::TableFile(const OutputFile& file, const TableForm& form, std::optional<OutputOptions::Precision> binary)
    : binary_(binary) {
  if (!binary_) {
    text_.emplace(file, csv_header(form));
    return;
  }
  const std::string header = binary_header(form, *binary_);
  numbers_.emplace(file);
  numbers_->write(header.data(), header.size());
  numbers_->end_record(std::numeric_limits<double>::quiet_NaN());
  numbers_->flush();
}

TableFile::TableFile(const OutputFile& file, const CheckedFile::End& end,
                     std::optional<OutputOptions::Precision> binary)
    : binary_(binary) {
  if (binary_)
    numbers_.emplace(file, end);
  else
    text_.emplace(file, end);
}

void TableFile::begin_record(double time) {
  time_ = time;
  row_is_open_ = false;
  if (text_) {
    text_->drop_unfinished();
  } else {
    numbers_->drop_unfinished();
    write_number(*numbers_, time);  // eight bytes for every precision
  }
}

TableFile& TableFile::operator<<(std::string_view text) {
  if (text_) *text_ << ',' << csv_cell(text);
  return *this;
}

void TableFile::end_record() {
  if (text_) {
    if (row_is_open_) *text_ << '\n';
    row_is_open_ = false;
    text_->end_record(time_);
    return;
  }
  numbers_->end_record(time_);
  numbers_->flush();  // so that a reader finds complete records during the run, or after it was killed
}

void TableFile::close() {
  if (text_) {
    text_->close();
  } else {
    numbers_->close();
  }
}

}  // namespace springnet
