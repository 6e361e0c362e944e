#include "output/checked_file.hpp"

#include <sys/types.h>

#include <cerrno>
#include <utility>

#include <fmt/format.h>
#include <springnet/error.hpp>

namespace springnet {

CheckedFile::CheckedFile(const std::filesystem::path& file) : path_(file), file_(std::fopen(file.c_str(), "wb")) {
  if (file_ == nullptr) {
    throw Error(ErrorKind::input, fmt::format("{}: cannot be created: {}; name another folder for the output",
                                              path_.string(), std::strerror(errno)));
  }
}

CheckedFile::~CheckedFile() {
  if (file_ != nullptr) static_cast<void>(std::fclose(file_));
}

void CheckedFile::write(const void* data, std::size_t bytes) {
  if (std::fwrite(data, 1, bytes, file_) != bytes) fail(errno);
}

void CheckedFile::flush() {
  if (std::fflush(file_) != 0) fail(errno);
}

void CheckedFile::seek(std::uint64_t place) {
  if (fseeko(file_, static_cast<off_t>(place), SEEK_SET) != 0) fail(errno);
}

void CheckedFile::close() {
  if (file_ == nullptr) return;
  flush();
  if (std::fclose(std::exchange(file_, nullptr)) != 0) fail(errno);
}

void CheckedFile::write_anyway(const void* data, std::size_t bytes) noexcept {
  if (file_ != nullptr) static_cast<void>(std::fwrite(data, 1, bytes, file_));
}

void CheckedFile::fail(int reason) {
  throw Error(ErrorKind::simulation,
              fmt::format("{}: cannot be written: {}; what was written before is kept. Make room, write to another "
                          "disk, or record less often (output.interval)",
                          path_.string(), std::strerror(reason)));
}

}  // namespace springnet
