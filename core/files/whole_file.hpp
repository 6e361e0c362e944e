// A file that has its name only once it is whole: a reader, or a run that is ended by force, never leaves half of it.
#pragma once

#include <ostream>
#include <streambuf>

#include "files/checked_file.hpp"

namespace springnet {

class WholeFile {
 public:
  // Starts it under the name with ".part" behind it. Throws OutputError if that cannot be created.
  explicit WholeFile(const OutputFile& file);
  ~WholeFile();  // removes it if it was not finished
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  [[nodiscard]] std::ostream& stream() noexcept { return stream_; }  // throws OutputError if it cannot be written
  // Closes it and gives it its name. Throws OutputError if it cannot be written.
  void finish();

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

  OutputFile file_;  // by its folder
  OutputFile part_;
  CheckedFile out_;
  Buffer buffer_{out_};
  std::ostream stream_{&buffer_};
  bool finished_ = false;
};

}  // namespace springnet
