#include "files/checked_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <springnet/whole_records.hpp>

#include "files/output_error.hpp"

namespace springnet {
namespace {

// Open files, for write_whole_records(): a signal handler can lock nothing. Files beyond these are not saved.
std::array<std::atomic<const CheckedFile*>, 64> open_files{};

void replace(const CheckedFile* from, const CheckedFile* to) noexcept {
  for (std::atomic<const CheckedFile*>& place : open_files) {
    const CheckedFile* expected = from;
    if (place.compare_exchange_strong(expected, to)) return;
  }
}

}  // namespace

void write_whole_records() noexcept {
  for (const std::atomic<const CheckedFile*>& place : open_files) {
    if (const CheckedFile* const file = place.load()) file->save_whole_records();
  }
}

CheckedFile::CheckedFile(const OutputFile& file, std::string_view remedy)
    : file_(file), remedy_(remedy), descriptor_(-1), buffer_(std::make_unique_for_overwrite<char[]>(capacity)) {
  descriptor_ = open_output(file);  // last, because nothing would close it if the constructor threw
  replace(nullptr, this);
}

void CheckedFile::End::archive(Archive& archive) {
  archive.number(offset);
  archive.number(time);
  archive.flag(has_ended);
}

CheckedFile::CheckedFile(const OutputFile& file, const End& end, std::string_view remedy)
    : file_(file),
      remedy_(remedy),
      descriptor_(-1),
      buffer_(std::make_unique_for_overwrite<char[]>(capacity)),
      written_(end.offset),
      marked_(end.has_ended),
      kept_{end.has_ended ? end.offset : 0, end.time} {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorKind::input, fmt::format("{}: {}; run again without resuming", file.path().string(), what));
  };
  const int opened = ::open(file.path().c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
  if (opened < 0) refuse(fmt::format("cannot be opened to go on with it: {}", std::strerror(errno)));
  // Above the descriptors of the standard streams.
  descriptor_ = ::fcntl(opened, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int reason = errno;
  ::close(opened);
  if (descriptor_ < 0) refuse(fmt::format("cannot be opened to go on with it: {}", std::strerror(reason)));
  try {
    struct stat status;
    if (fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode) || is_gone())
      refuse("is no regular file of the folder");
    if (static_cast<std::uint64_t>(status.st_size) < end.offset)
      refuse(fmt::format("has {} bytes, and had {} at the checkpoint", status.st_size, end.offset));
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
  replace(nullptr, this);
}

void CheckedFile::go_on() {
  const auto end = static_cast<off_t>(written_);
  if (ftruncate(descriptor_, end) == 0 && lseek(descriptor_, end, SEEK_SET) >= 0) return;
  throw Error(ErrorKind::input, fmt::format("{}: cannot be cut at the checkpoint: {}; run again without resuming",
                                            file_.path().string(), std::strerror(errno)));
}

CheckedFile::~CheckedFile() {
  replace(this, nullptr);
  if (descriptor_ < 0) return;
  try {
    if (failure_.empty()) {
      drop_unfinished();
      flush();
    }
  } catch (...) {  // a destructor has nobody to report to
  }
  ::close(descriptor_);
}

void CheckedFile::make_room_for(std::size_t bytes) {
  // Only complete records if there are any, so that a killed run leaves no partial one (unless it exceeds the buffer).
  if (!marks_.empty()) write_out(static_cast<std::size_t>(marks_.back().offset - written_));
  if (capacity - used_ < bytes) write_out(used_);
}

void CheckedFile::write(const void* data, std::size_t bytes) {
  if (bytes == 0) return;  // an empty array may have a null address, which memcpy does not allow
  const char* const begin = static_cast<const char*>(data);
  if (bytes > capacity - used_) make_room_for(std::min(bytes, capacity));
  if (bytes > capacity) {
    put(begin, bytes);
    return;
  }
  std::memcpy(buffer_.get() + used_, begin, bytes);
  used_ += bytes;
}

void CheckedFile::flush() { write_out(used_); }

CheckedFile::End CheckedFile::flushed_end() {
  drop_unfinished();
  flush();
  return {written_, kept_.time, marked_};
}

void CheckedFile::sync() {
  flush();
  // A pipe, for instance, has no disk.
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOTSUP) fail(errno);
}

void CheckedFile::write_out(std::size_t bytes) {
  put(buffer_.get(), bytes);
  used_ -= bytes;
  std::memmove(buffer_.get(), buffer_.get() + bytes, used_);
}

void CheckedFile::put(const char* data, std::size_t bytes) {
  if (!failure_.empty()) throw_failure();
  while (bytes > 0) {
    const ssize_t count = ::write(descriptor_, data, bytes);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail(count < 0 ? errno : ENOSPC);
    data += count;
    bytes -= static_cast<std::size_t>(count);
    written_ += static_cast<std::uint64_t>(count);
  }
  keep_marks(written_);
}

void CheckedFile::end_record(double time) {
  marked_ = true;
  const std::uint64_t offset = written_ + used_;
  if (offset == kept_.offset && marks_.empty()) {
    kept_.time = time;  // a record without rows
  } else if (!marks_.empty() && marks_.back().offset == offset) {
    marks_.back().time = time;
  } else {
    marks_.push_back({offset, time});
    if (used_ == 0) keep_marks(offset);
  }
}

void CheckedFile::keep_marks(std::uint64_t offset) {
  const auto beyond = std::find_if(marks_.begin(), marks_.end(), [offset](const Mark& m) { return m.offset > offset; });
  if (beyond == marks_.begin()) return;
  kept_ = *std::prev(beyond);
  marks_.erase(marks_.begin(), beyond);
}

void CheckedFile::drop_unfinished() {
  if (!marked_) return;
  const std::uint64_t end = marks_.empty() ? kept_.offset : marks_.back().offset;
  if (end >= written_) {
    used_ = static_cast<std::size_t>(end - written_);
  } else {
    used_ = 0;
    cut(end);
  }
}

void CheckedFile::save_whole_records() const noexcept {
  if (descriptor_ < 0 || !failure_.empty() || !marked_) return;
  if (marks_.empty()) {
    // Part of a record that exceeds the buffer may be in the file. ftruncate is safe in a signal handler.
    if (kept_.offset < written_) {
      [[maybe_unused]] const int failed = ::ftruncate(descriptor_, static_cast<off_t>(kept_.offset));
    }
    return;
  }
  const char* data = buffer_.get();
  for (std::uint64_t left = marks_.back().offset - written_; left > 0;) {
    const ssize_t count = ::write(descriptor_, data, left);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    data += count;
    left -= static_cast<std::uint64_t>(count);
  }
}

// A pipe, for instance, cannot be cut: then the partial record stays.
void CheckedFile::cut(std::uint64_t offset) noexcept {
  if (ftruncate(descriptor_, static_cast<off_t>(offset)) == 0) written_ = offset;
}

void CheckedFile::close() {
  if (descriptor_ < 0) return;
  if (failure_.empty()) {
    drop_unfinished();
    flush();
    if (is_gone()) {
      failure_ = fmt::format(
          "{}: was removed or replaced by another file during the run; its records are lost. Run again, and leave the "
          "folder alone until the end",
          file_.path().string());
      throw OutputError(failure_, std::numeric_limits<double>::quiet_NaN(), true);
    }
  }
  // Linux releases the descriptor even if close() fails.
  const int failed = ::close(std::exchange(descriptor_, -1)) == 0 ? 0 : errno;
  if (failed != 0 && failed != EINTR && failure_.empty()) fail(failed);
}

bool CheckedFile::is_gone() const noexcept {
  if (file_.folder()) return !file_.folder()->has(file_.name(), descriptor_);
  struct stat status;
  return fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode) && status.st_nlink == 0;
}

void CheckedFile::seek(std::uint64_t offset) {
  flush();
  if (lseek(descriptor_, static_cast<off_t>(offset), SEEK_SET) < 0) fail(errno);
  written_ = offset;
}

void CheckedFile::restore_end(std::uint64_t offset, std::string_view end) noexcept {
  if (ftruncate(descriptor_, static_cast<off_t>(offset)) != 0) return;
  [[maybe_unused]] const ssize_t count = pwrite(descriptor_, end.data(), end.size(), static_cast<off_t>(offset));
}

void CheckedFile::fail(int reason) {
  used_ = 0;
  if (marked_) {
    keep_marks(written_);
    cut(kept_.offset);
  }
  std::string kept;
  if (marked_) {
    kept = std::isnan(kept_.time) ? "none of its records was written; "
                                  : fmt::format("its records up to {:g} s are kept; ", kept_.time);
  }
  failure_ =
      fmt::format("{}: cannot be written: {}; {}{}", file_.path().string(), std::strerror(reason), kept, remedy_);
  throw_failure();
}

void CheckedFile::throw_failure() const { throw OutputError(failure_, kept_.time); }

}  // namespace springnet
