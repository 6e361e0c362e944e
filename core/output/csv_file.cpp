#include "output/csv_file.hpp"

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

CsvFile::CsvFile(const std::filesystem::path& file, std::string_view header, Clock::duration patience)
    : file_(file), buffer_(std::size_t{1} << 16), patience_(patience), flushed_(Clock::now() - patience) {
  *this << header << '\n';
  flush();
}

// Left open by an exception: what was recorded should be there.
CsvFile::~CsvFile() { file_.write_anyway(buffer_.data(), used_); }

CsvFile& CsvFile::operator<<(std::string_view text) {
  for (const char character : text) *this << character;
  return *this;
}

void CsvFile::end_record() {
  const Clock::time_point now = Clock::now();
  if (now - flushed_ < patience_) return;
  flush();
  flushed_ = now;
}

void CsvFile::flush() {
  write_buffer();
  file_.flush();
}

void CsvFile::close() {
  if (!file_.is_open()) return;
  write_buffer();
  file_.close();
}

void CsvFile::write_buffer() {
  const std::size_t count = used_;
  used_ = 0;
  file_.write(buffer_.data(), count);
}

}  // namespace springnet
