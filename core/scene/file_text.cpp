#include "scene/file_text.hpp"

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <springnet/error.hpp>

#include "text/grouped.hpp"

namespace springnet::scene {
namespace {

class Descriptor {
 public:
  // Nonblocking: opening a named pipe would wait for a writer.
  explicit Descriptor(const std::filesystem::path& file)
      : number_(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  [[nodiscard]] int number() const noexcept { return number_; }

 private:
  int number_;
};

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

std::string read_scene_text(const std::filesystem::path& file) {
  const auto fail = [&](const std::string& reason) {
    throw Error(ErrorKind::input,
                fmt::format("{}: cannot be read ({}); check its name and its permissions", file.string(), reason));
  };
  const Descriptor descriptor(file);
  struct stat status {};
  if (descriptor.number() < 0 || fstat(descriptor.number(), &status) != 0) {
    fail(std::generic_category().message(errno));
  }
  if (S_ISDIR(status.st_mode)) fail("it is a folder");
  std::string text;
  constexpr std::size_t piece = 1 << 16;
  while (text.size() <= largest_scene) {
    const std::size_t before = text.size();
    text.resize(before + piece);
    const ssize_t count = read_some(descriptor.number(), text.data() + before, piece);
    if (count < 0) fail(std::generic_category().message(errno));
    text.resize(before + static_cast<std::size_t>(count));
    if (count == 0) break;
  }
  if (text.empty() && S_ISFIFO(status.st_mode)) fail("it is a pipe that nothing writes to");
  return text;
}

}  // namespace springnet::scene
