// Memory for the arrays of a call: with room around each array, or with pages around it that cannot be accessed.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <type_traits>
#include <vector>

namespace springnet::check {

// What an access that ended a process was next to; plain data, because it crosses processes.
struct Fault {
  enum class Kind { none, beyond, before, read_only, null };
  Kind kind;
  char name[64];  // of the array
};
// Async-signal-safe, for a handler of SIGSEGV.
[[nodiscard]] Fault fault_at(const void* address) noexcept;

class Memory {
 public:
  // roomy: 64 numbers before and after each array, so that a small overrun is harmless. at_end, at_start: each array
  // ends or begins next to a page that cannot be accessed, and inputs are read-only.
  enum class Layout { roomy, at_end, at_start };

  explicit Memory(Layout layout, std::size_t offset = 0) : layout_(layout), offset_(offset) {}
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory();

  // An array that is an input once protect() is called; `name` for reports. Of a length of 0: an address that cannot
  // be read, except in the roomy layout.
  template <class T>
  [[nodiscard]] T* input(const std::vector<T>& values, const std::string& name) {
    T* const place = static_cast<T*>(take(values.size() * sizeof(T), name, true));
    for (std::size_t i = 0; i < values.size(); ++i) place[i] = values[i];
    if constexpr (std::is_pointer_v<T>) {
      // Whoever reads one pointer too many gets numbers that mean nothing.
      if (layout_ == Layout::roomy)
        for (std::size_t i = 0; i < spare_entries; ++i) place[values.size() + i] = spare();
    }
    return place;
  }
  // An array that the component writes; filled with `fill`.
  template <class T>
  [[nodiscard]] T* output(std::size_t count, const std::string& name, const T& fill) {
    T* const place = static_cast<T*>(take(count * sizeof(T), name, false));
    for (std::size_t i = 0; i < count; ++i) place[i] = fill;
    return place;
  }
  // Makes the inputs read-only; the roomy layout leaves them as they are.
  void protect();

 private:
  static constexpr std::size_t spare_entries = 8;
  [[nodiscard]] static double* spare() noexcept;
  [[nodiscard]] void* take(std::size_t bytes, const std::string& name, bool is_input);

  Layout layout_;
  std::size_t offset_;  // numbers by which roomy arrays are off a multiple of 64 bytes
  std::deque<std::vector<double>> roomy_;
  std::vector<std::size_t> regions_;  // places in the table of guarded arrays
};

}  // namespace springnet::check
