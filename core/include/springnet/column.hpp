// A list of values of which only one is stored while all are the same.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <springnet/huge_pages.hpp>

namespace springnet {

namespace detail {

// Equal bits, so that a stored value is that which was added: 0 and -0 differ, a nan is itself.
template <class Value>
struct SameBits {
  [[nodiscard]] static bool of(const Value& a, const Value& b) { return a == b; }
};
template <>
struct SameBits<double> {
  [[nodiscard]] static bool of(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  }
};

}  // namespace detail

template <class Value>
class Column {
 public:
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  // Whether all values are the same, so that one is stored.
  [[nodiscard]] bool is_uniform() const noexcept { return each_.empty(); }
  [[nodiscard]] Value operator[](std::size_t i) const { return each_.empty() ? common_ : each_[i]; }
  [[nodiscard]] const Value* find(std::size_t i) const { return each_.empty() ? &common_ : &each_[i]; }

  void push_back(const Value& value) {
    if (each_.empty()) {
      if (size_ == 0) common_ = value;
      if (detail::SameBits<Value>::of(value, common_)) {
        ++size_;
        return;
      }
      spread();
    }
    each_.push_back(value);
    ++size_;
  }
  // Appends `count` times the same.
  void append(std::size_t count, const Value& value) {
    if (count == 0) return;
    if (each_.empty()) {
      if (size_ == 0) common_ = value;
      if (detail::SameBits<Value>::of(value, common_)) {
        size_ += count;
        return;
      }
      spread();
    }
    each_.insert(each_.end(), count, value);
    size_ += count;
  }
  // Appends `count` values that may differ; they are to be written where the result points to.
  [[nodiscard]] Value* append_each(std::size_t count) {
    if (each_.empty()) spread();
    size_ += count;
    if (capacity_ < size_) capacity_ = size_;
    reserve_huge(each_, capacity_);
    each_.resize(size_);
    return each_.data() + (size_ - count);
  }
  void set(std::size_t i, const Value& value) {
    if (each_.empty()) {
      if (detail::SameBits<Value>::of(value, common_)) return;
      if (size_ == 1) {
        common_ = value;
        return;
      }
      spread();
    }
    each_[i] = value;
  }
  // Takes effect once values differ.
  void reserve(std::size_t capacity) {
    capacity_ = std::max(capacity_, capacity);
    if (!each_.empty()) reserve_huge(each_, capacity_);
  }
  [[nodiscard]] std::size_t capacity() const noexcept { return std::max(capacity_, each_.capacity()); }

 private:
  void spread() {
    reserve_huge(each_, std::max(capacity_, size_ + 1));
    each_.assign(size_, common_);
  }

  std::size_t size_ = 0, capacity_ = 0;
  Value common_{};
  std::vector<Value> each_;  // empty: all are `common_`
};

}  // namespace springnet
