// A file, pipe or device that is read piece by piece.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace springnet {

class InputFile {
 public:
  // Throws Error(input) that names the file if it is a folder or cannot be opened.
  explicit InputFile(const std::filesystem::path& file);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  // Bytes; empty for what is no regular file.
  [[nodiscard]] std::optional<std::uint64_t> size() const noexcept { return size_; }
  [[nodiscard]] bool is_pipe() const noexcept { return is_pipe_; }
  // Appends up to `count` bytes, fewer only at the end, where it returns false. Takes memory as bytes arrive, not for
  // what is yet to come. Waits for a pipe's writer. Throws Error(input) if the file cannot be read.
  bool read(std::string& bytes, std::uint64_t count);

 private:
  [[noreturn]] void fail(const std::string& reason) const;

  std::filesystem::path file_;
  int descriptor_;
  std::optional<std::uint64_t> size_;
  bool is_pipe_ = false;
};

}  // namespace springnet
