// A file that gets its name only once it is complete: no reader sees a part of it, and a killed run leaves none.
#pragma once

#include <ostream>
#include <streambuf>

#include "files/checked_file.hpp"

namespace springnet {

class WholeFile {
 public:
  // Creates it as "<name>.part". Throws OutputError if it cannot.
  explicit WholeFile(const OutputFile& file);
  ~WholeFile();  // removes it unless finish() succeeded
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  [[nodiscard]] std::ostream& stream() noexcept { return stream_; }  // throws OutputError if it cannot be written
  // Closes it and gives it its name. Throws OutputError if it cannot be written. on_disk: waits until the file, then
  // its name, are on the disk, so that a crash of the machine leaves the file before or this one.
  void finish(bool on_disk = false);

 private:
  class Buffer : public std::streambuf {
   public:
    explicit Buffer(CheckedFile& file) : file_(file) {}

   protected:
    std::streamsize xsputn(const char* text, std::streamsize count) override;
    int_type overflow(int_type character) override;

   private:
    CheckedFile& file_;
  };

  OutputFile file_;  // in its folder
  OutputFile part_;
  CheckedFile out_;
  Buffer buffer_{out_};
  std::ostream stream_{&buffer_};
  bool finished_ = false;
};

}  // namespace springnet
