// A file whose every write is checked and that ends with a whole record, and numbers in it.
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

namespace springnet {

// Writes through a buffer. Once records are marked, what stands behind the last mark is part of a record: it is cut off
// where the file cannot be written any more, and at the end. No more is written after a failure.
class CheckedFile {
 public:
  static constexpr std::string_view record_less =
      "make room, write to another disk, or record less often (output.interval)";
  static constexpr std::string_view make_room = "make room or write to another disk";

  // Creates the file. Throws Error(input) if it cannot be. `remedy` is for the message where it cannot be written.
  explicit CheckedFile(const OutputFile& file, std::string_view remedy = record_less);
  // Left open by an exception: writes the whole records that there are, as far as they can be written.
  ~CheckedFile();
  CheckedFile(const CheckedFile&) = delete;
  CheckedFile& operator=(const CheckedFile&) = delete;

  // Room for so many bytes, at most `most_room`, behind what there is; used() takes those that were used.
  static constexpr std::size_t most_room = 4096;
  [[nodiscard]] char* room(std::size_t bytes) {
    if (capacity - used_ < bytes) make_room_for(bytes);
    return buffer_.get() + used_;
  }
  void used(std::size_t bytes) noexcept { used_ += bytes; }

  // These and room() throw OutputError if the file cannot be written.
  void write(const void* data, std::size_t bytes);
  void flush();
  // Also throws if the file is no longer in its folder.
  void close();

  // A record ends here: that of this time, s, or nan for what stands before all records.
  void end_record(double time);

  // For a document whose end is written again and again: from where it is written next, and its end as it was.
  void seek(std::uint64_t place);
  void restore_end(std::uint64_t place, std::string_view end) noexcept;

 private:
  static constexpr std::size_t capacity = std::size_t{1} << 16;

  struct Mark {
    std::uint64_t place;  // bytes, where the record ends
    double time;          // s
  };

  void make_room_for(std::size_t bytes);
  void write_out(std::size_t bytes);  // the first of the buffer
  void put(const char* data, std::size_t bytes);
  void reach(std::uint64_t place);  // the marks up to there
  void drop_unfinished();
  void cut(std::uint64_t place) noexcept;
  [[noreturn]] void fail(int reason);
  [[noreturn]] void throw_failure() const;
  [[nodiscard]] bool is_gone() const noexcept;

  OutputFile file_;
  std::string_view remedy_;
  int descriptor_;
  std::unique_ptr<char[]> buffer_;
  std::size_t used_ = 0;
  std::uint64_t written_ = 0;  // bytes, in the file
  bool marked_ = false;
  Mark kept_{0, std::numeric_limits<double>::quiet_NaN()};  // the last one in the file
  std::vector<Mark> marks_;                                 // of the buffer
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
