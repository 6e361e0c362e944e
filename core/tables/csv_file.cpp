#include "tables/csv_file.hpp"

#include <limits>

namespace springnet {

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char character : text) {
    if (character == '"') quoted += '"';
    quoted += character;
  }
  return quoted + '"';
}

CsvFile::CsvFile(const OutputFile& file, std::string_view header, Clock::duration flush_interval)
    : file_(file), flush_interval_(flush_interval), flushed_(Clock::now() - flush_interval) {
  *this << header << '\n';
  file_.end_record(std::numeric_limits<double>::quiet_NaN());
  flush();
}

CsvFile& CsvFile::operator<<(std::string_view text) {
  file_.write(text.data(), text.size());
  return *this;
}

void CsvFile::end_record(double time) {
  file_.end_record(time);
  const Clock::time_point now = Clock::now();
  if (now - flushed_ < flush_interval_) return;
  flush();
  flushed_ = now;
}

void CsvFile::flush() { file_.flush(); }

void CsvFile::close() { file_.close(); }

}  // namespace springnet
