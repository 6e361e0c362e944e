#include "output/csv_file.hpp"

#include <cerrno>
#include <cstring>
#include <string>

#include <fmt/format.h>
#include <springnet/error.hpp>

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

CsvFile::CsvFile(const std::filesystem::path& file, std::string_view header)
    : path_(file), file_(std::fopen(file.c_str(), "wb")), buffer_(std::size_t{1} << 16) {
  if (file_ == nullptr) {
    throw Error(ErrorKind::input, fmt::format("{}: cannot be created: {}; name another folder for the output",
                                              path_.string(), std::strerror(errno)));
  }
  *this << header << '\n';
}

CsvFile::~CsvFile() {
  if (file_ == nullptr) return;
  // Left open by an exception: what was recorded should be there; a failure now has nobody to hear of it.
  static_cast<void>(std::fwrite(buffer_.data(), 1, used_, file_));
  static_cast<void>(std::fclose(file_));
}

CsvFile& CsvFile::operator<<(std::string_view text) {
  for (const char character : text) *this << character;
  return *this;
}

void CsvFile::flush() {
  write_buffer();
  if (std::fflush(file_) != 0) fail(errno);
}

void CsvFile::close() {
  if (file_ == nullptr) return;
  flush();
  std::FILE* const file = file_;
  file_ = nullptr;
  if (std::fclose(file) != 0) fail(errno);
}

void CsvFile::write_buffer() {
  const std::size_t count = used_;
  used_ = 0;
  if (std::fwrite(buffer_.data(), 1, count, file_) != count) fail(errno);
}

void CsvFile::fail(int reason) {
  throw Error(ErrorKind::simulation,
              fmt::format("{}: cannot be written: {}; what was written before is kept. Make room, write to another "
                          "disk, or record less often (output.interval)",
                          path_.string(), std::strerror(reason)));
}

}  // namespace springnet
