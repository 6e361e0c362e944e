#include "files/input_file.hpp"

#include <algorithm>
#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <springnet/error.hpp>

namespace springnet {
namespace {

constexpr std::size_t piece = std::size_t{1} << 16;

// Bytes read, 0 at the end, or -1 with errno; waits for a pipe's writer.
ssize_t read_some(int descriptor, char* buffer, std::size_t size) {
  while (true) {
    const ssize_t count = read(descriptor, buffer, size);
    if (count >= 0 || (errno != EINTR && errno != EAGAIN)) return count;
    if (errno == EINTR) continue;
    pollfd wait{descriptor, POLLIN, 0};
    if (poll(&wait, 1, -1) < 0 && errno != EINTR) return -1;
  }
}

}  // namespace

// Nonblocking: opening a named pipe would wait for a writer.
InputFile::InputFile(const std::filesystem::path& file)
    : file_(file), descriptor_(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  struct stat status {};
  if (descriptor_ < 0 || fstat(descriptor_, &status) != 0 || S_ISDIR(status.st_mode)) {
    const std::string reason =
        descriptor_ >= 0 && S_ISDIR(status.st_mode) ? "it is a folder" : std::generic_category().message(errno);
    if (descriptor_ >= 0) close(descriptor_);
    fail(reason);
  }
  if (S_ISREG(status.st_mode)) size_ = static_cast<std::uint64_t>(status.st_size);
  is_pipe_ = S_ISFIFO(status.st_mode);
}

InputFile::~InputFile() { close(descriptor_); }

bool InputFile::read(std::string& bytes, std::uint64_t count) {
  while (count > 0) {
    const std::size_t before = bytes.size();
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(count, std::max(piece, before)));
    bytes.resize(before + wanted);
    const ssize_t found = read_some(descriptor_, bytes.data() + before, wanted);
    const int reason = errno;
    bytes.resize(before + static_cast<std::size_t>(std::max<ssize_t>(found, 0)));
    if (found < 0) fail(std::generic_category().message(reason));
    if (found == 0) return false;
    count -= static_cast<std::uint64_t>(found);
  }
  return true;
}

void InputFile::fail(const std::string& reason) const {
  throw Error(ErrorKind::input,
              fmt::format("{}: cannot be read ({}); check its name and its permissions", file_.string(), reason));
}

}  // namespace springnet
