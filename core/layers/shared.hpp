// Values that copies have in common until one of them changes its own. Copies may be read, changed and destroyed by
// different threads at the same time.
#pragma once

#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

#include <springnet/column.hpp>

namespace springnet::layers {

template <class Value>
class Shared {
 public:
  Shared() : block_(new Block) {}
  explicit Shared(Value value) : block_(new Block(std::move(value))) {}
  Shared(const Shared& other) noexcept : block_(other.block_) {
    block_->owners.fetch_add(1, std::memory_order_relaxed);
  }
  Shared& operator=(const Shared& other) noexcept {
    Shared copy(other);
    std::swap(block_, copy.block_);
    return *this;
  }
  ~Shared() {
    if (block_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1) delete block_;
  }

  [[nodiscard]] const Value& operator*() const noexcept { return block_->value; }
  [[nodiscard]] const Value* operator->() const noexcept { return &block_->value; }
  // Acquire: what other owners read, they have read before.
  [[nodiscard]] bool is_shared() const noexcept { return block_->owners.load(std::memory_order_acquire) > 1; }
  // To be changed: a copy of it first, if others have it.
  [[nodiscard]] Value& own() {
    if (is_shared()) *this = Shared(block_->value);
    return block_->value;
  }
  // A new one in its place, without a copy.
  Value& renew() {
    if (is_shared())
      *this = Shared();
    else
      block_->value = Value();
    return block_->value;
  }

 private:
  struct Block {
    Block() = default;
    explicit Block(Value given) : value(std::move(given)) {}
    Value value{};
    std::atomic<std::size_t> owners{1};
  };
  Block* block_;
};

// Reads as a std::vector does.
template <class Value>
class SharedVector {
 public:
  using value_type = Value;
  SharedVector() = default;
  SharedVector(std::vector<Value> values) : values_(std::move(values)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] std::size_t size() const noexcept { return values_->size(); }
  [[nodiscard]] bool empty() const noexcept { return values_->empty(); }
  [[nodiscard]] const Value* data() const noexcept { return values_->data(); }
  [[nodiscard]] const Value& operator[](std::size_t i) const noexcept { return (*values_)[i]; }
  [[nodiscard]] const Value& front() const noexcept { return values_->front(); }
  [[nodiscard]] const Value& back() const noexcept { return values_->back(); }
  [[nodiscard]] auto begin() const noexcept { return values_->begin(); }
  [[nodiscard]] auto end() const noexcept { return values_->end(); }
  [[nodiscard]] const std::vector<Value>& get() const noexcept { return *values_; }

  [[nodiscard]] bool is_shared() const noexcept { return values_.is_shared(); }
  // The vector itself, to be changed.
  [[nodiscard]] std::vector<Value>& own() { return values_.own(); }
  void clear() { values_.renew(); }
  void push_back(const Value& value) { own().push_back(value); }
  void assign(std::size_t count, const Value& value) {
    if (is_shared()) clear();
    own().assign(count, value);
  }

 private:
  Shared<std::vector<Value>> values_;
};

// Reads as a Column does.
template <class Value>
class SharedColumn {
 public:
  SharedColumn() = default;
  SharedColumn(Column<Value> column) : column_(std::move(column)) {}   // NOLINT(google-explicit-constructor)
  operator const Column<Value>&() const noexcept { return *column_; }  // NOLINT(google-explicit-constructor)

  [[nodiscard]] std::size_t size() const noexcept { return column_->size(); }
  [[nodiscard]] bool is_uniform() const noexcept { return column_->is_uniform(); }
  [[nodiscard]] Value operator[](std::size_t i) const { return (*column_)[i]; }
  // The column itself, to be changed.
  [[nodiscard]] Column<Value>& own() { return column_.own(); }

 private:
  Shared<Column<Value>> column_;
};

}  // namespace springnet::layers
