// A file whose every write is checked, and numbers in it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <span>
#include <type_traits>

namespace springnet {

class CheckedFile {
 public:
  // Replaces the file. Throws Error(input) if it cannot be created.
  explicit CheckedFile(const std::filesystem::path& file);
  ~CheckedFile();
  CheckedFile(const CheckedFile&) = delete;
  CheckedFile& operator=(const CheckedFile&) = delete;

  // These throw Error(simulation) if the file cannot be written.
  void write(const void* data, std::size_t bytes);
  void flush();
  void seek(std::uint64_t place);  // from where it is written next
  void close();

  // For destructors: what cannot be written has nobody to hear of it.
  void write_anyway(const void* data, std::size_t bytes) noexcept;
  [[nodiscard]] bool is_open() const noexcept { return file_ != nullptr; }

 private:
  [[noreturn]] void fail(int reason);

  std::filesystem::path path_;
  std::FILE* file_;
};

// Writes values as numbers of another type, little-endian on every machine.
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
