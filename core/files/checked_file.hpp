// A file that checks every write and always ends with a complete record; numbers in it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <springnet/output_folder.hpp>

#include "text/archive.hpp"

namespace springnet {

// Writes through a buffer. Once a record has ended, anything after the last one is an unfinished record, which is cut
// off when a write fails, and on close. Nothing is written after a failure.
class CheckedFile {
 public:
  static constexpr std::string_view record_less =
      "make room, write to another disk, or record less often (output.interval)";
  static constexpr std::string_view make_room = "make room or write to another disk";

  // Where a file ends.
  struct End {
    std::uint64_t offset = 0;                                // bytes
    double time = std::numeric_limits<double>::quiet_NaN();  // s, of its last record; nan: it has none
    bool has_ended = false;                                  // a record, or what precedes all of them
    void archive(Archive& archive);
  };

  // Creates the file; throws Error(input) if that fails. `remedy` ends the message of a failed write.
  explicit CheckedFile(const OutputFile& file, std::string_view remedy = record_less);
  // Opens a file that ended there, and changes nothing in it before go_on(). Throws Error(input) if it is shorter, or
  // no regular file of its folder.
  CheckedFile(const OutputFile& file, const End& end, std::string_view remedy = record_less);
  // Cuts off what such a file has beyond its end; records follow there. Throws Error(input).
  void go_on();
  // If still open, after an exception for instance: writes the complete records in the buffer, if possible.
  ~CheckedFile();
  CheckedFile(const CheckedFile&) = delete;
  CheckedFile& operator=(const CheckedFile&) = delete;

  // Room for `bytes`, at most `max_room`, at the end of the buffer; call used() with the number of bytes written there.
  static constexpr std::size_t max_room = 4096;
  [[nodiscard]] char* room(std::size_t bytes) {
    if (capacity - used_ < bytes) make_room_for(bytes);
    return buffer_.get() + used_;
  }
  void used(std::size_t bytes) noexcept { used_ += bytes; }

  // These and room() throw OutputError if the file cannot be written.
  void write(const void* data, std::size_t bytes);
  void flush();
  void sync();  // also waits until the bytes are on the disk
  // Throws OutputError as well if the file is no longer in its folder.
  void close();

  // Ends the record of this time, s; nan: what precedes all records.
  void end_record(double time);
  // Drops what was written after the last record, if any has ended.
  void drop_unfinished();

  // Writes what is in the buffer, and tells where the file ends; between records.
  [[nodiscard]] End flushed_end();

  // For a document whose end is rewritten with each addition: sets where to write next, and restores the end after a
  // failure.
  void seek(std::uint64_t offset);
  void restore_end(std::uint64_t offset, std::string_view end) noexcept;

  // Writes the complete records in the buffer, or cuts off what is in the file of an unfinished one; see
  // write_whole_records().
  void save_whole_records() const noexcept;

 private:
  static constexpr std::size_t capacity = std::size_t{1} << 16;

  struct Mark {
    std::uint64_t offset;  // bytes, where the record ends
    double time;           // s
  };

  void make_room_for(std::size_t bytes);
  void write_out(std::size_t bytes);  // from the front of the buffer
  void put(const char* data, std::size_t bytes);
  void keep_marks(std::uint64_t offset);  // those up to there are in the file
  void cut(std::uint64_t offset) noexcept;
  [[noreturn]] void fail(int reason);
  [[noreturn]] void throw_failure() const;
  [[nodiscard]] bool is_gone() const noexcept;

  OutputFile file_;
  std::string_view remedy_;
  int descriptor_;
  std::unique_ptr<char[]> buffer_;
  std::size_t used_ = 0;
  std::uint64_t written_ = 0;                               // bytes, in the file
  bool marked_ = false;                                     // whether a record has ended
  Mark kept_{0, std::numeric_limits<double>::quiet_NaN()};  // the last one that is in the file
  std::vector<Mark> marks_;                                 // ends of records that are still in the buffer
  std::string failure_;                                     // the message, after one
};

// Writes a number little-endian on every machine.
template <class Stored>
void write_number(CheckedFile& file, Stored value) {
  char* const bytes = file.room(sizeof(Stored));
  std::memcpy(bytes, &value, sizeof(Stored));
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes, bytes + sizeof(Stored));
  file.used(sizeof(Stored));
}

// The same for many, as numbers of another type.
template <class Stored, class Value>
void write_numbers(CheckedFile& file, std::span<const Value> values) {
  if constexpr (std::is_same_v<Stored, Value> && std::endian::native == std::endian::little) {
    file.write(values.data(), values.size_bytes());
  } else {
    std::array<Stored, 1024> block;
    while (!values.empty()) {
      const std::size_t count = std::min(block.size(), values.size());
      for (std::size_t k = 0; k < count; ++k) block[k] = static_cast<Stored>(values[k]);
      if constexpr (std::endian::native == std::endian::big) {
        for (std::size_t k = 0; k < count; ++k) {
          auto* const bytes = reinterpret_cast<std::byte*>(&block[k]);
          std::reverse(bytes, bytes + sizeof(Stored));
        }
      }
      file.write(block.data(), count * sizeof(Stored));
      values = values.subspan(count);
    }
  }
}

// A number from its little-endian bytes.
template <class Stored>
[[nodiscard]] Stored read_number(const char* bytes) {
  std::array<char, sizeof(Stored)> copy;
  std::memcpy(copy.data(), bytes, copy.size());
  if constexpr (std::endian::native == std::endian::big) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<Stored>(copy);
}

}  // namespace springnet
