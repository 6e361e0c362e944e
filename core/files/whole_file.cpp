#include "files/whole_file.hpp"

#include <cstring>
#include <limits>

#include <fmt/format.h>

#include "files/output_error.hpp"

namespace springnet {

namespace {

OutputFile in_its_folder(const OutputFile& file) {
  if (file.folder()) return file;
  return {OutputFolder::containing(file.path()), file.path().filename().string()};
}

}  // namespace

WholeFile::WholeFile(const OutputFile& file) try
    : file_(in_its_folder(file)), part_(file_.part()), out_(part_, CheckedFile::make_room) {
  stream_.exceptions(std::ios::badbit);  // throws what the file has thrown
} catch (const Error& error) {
  throw OutputError(error.what(), std::numeric_limits<double>::quiet_NaN());
}

WholeFile::~WholeFile() {
  if (!finished_) file_.folder()->remove(part_.name());
}

void WholeFile::finish(bool on_disk) {
  stream_.flush();
  if (on_disk) out_.sync();
  out_.close();
  const int reason = file_.folder()->rename(part_.name(), file_.name());
  if (reason != 0) {
    throw OutputError(fmt::format("{}: cannot be written: {}; {}", file_.path().string(), std::strerror(reason),
                                  reason == EISDIR ? "a folder has the name of this file" : CheckedFile::make_room),
                      std::numeric_limits<double>::quiet_NaN());
  }
  finished_ = true;
  if (on_disk) file_.folder()->sync();
}

std::streamsize WholeFile::Buffer::xsputn(const char* text, std::streamsize count) {
  file_.write(text, static_cast<std::size_t>(count));
  return count;
}

WholeFile::Buffer::int_type WholeFile::Buffer::overflow(int_type character) {
  if (traits_type::eq_int_type(character, traits_type::eof())) return traits_type::not_eof(character);
  const char c = traits_type::to_char_type(character);
  file_.write(&c, 1);
  return character;
}

void write_whole(const OutputFile& file, std::string_view text) {
  WholeFile whole(file);
  whole.stream() << text;
  whole.finish();
}

}  // namespace springnet
