// TOML as scenes are written: numbers read back with the same bits.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <springnet/network.hpp>

namespace springnet::scene::toml_text {

// Finite, or an infinity.
[[nodiscard]] std::string number(double value);
[[nodiscard]] std::string vector(const Vector3& value);
[[nodiscard]] std::string in_quotes(std::string_view text);
// As it is, if TOML allows that, else in quotes.
[[nodiscard]] std::string key(std::string_view name);
// "[a, b, c]", over several lines if it is long. item(k): text
template <class Item>
[[nodiscard]] std::string list(std::size_t count, const Item& item) {
  constexpr std::size_t width = 110;
  std::string text = "[";
  std::size_t begin = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::string next = item(k);
    if (k > 0) text += text.size() - begin + next.size() > width ? ",\n  " : ", ";
    if (k > 0 && text.back() == ' ' && text[text.size() - 3] == '\n') begin = text.size();
    text += next;
  }
  return text + "]";
}
template <class Number>
[[nodiscard]] std::string whole_numbers(const std::vector<Number>& numbers) {
  return list(numbers.size(), [&](std::size_t k) { return std::to_string(numbers[k]); });
}
[[nodiscard]] std::string numbers(const std::vector<double>& values);
[[nodiscard]] std::string vectors(const std::vector<Vector3>& values);

// "{ a = 1, b = 2 }"
class Inline {
 public:
  Inline& add(std::string_view name, const std::string& value) {
    text_ += (text_.empty() ? "" : ", ") + key(name) + " = " + value;
    return *this;
  }
  [[nodiscard]] std::string text() const { return "{ " + text_ + " }"; }

 private:
  std::string text_;
};

// A whole document.
class Document {
 public:
  // "[simulation]", "[[body]]"
  void begin(std::string_view header) { text_ += (text_.empty() ? "" : "\n") + std::string(header) + "\n"; }
  void add(std::string_view name, const std::string& value) { text_ += std::string(name) + " = " + value + "\n"; }
  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  std::string text_;
};

}  // namespace springnet::scene::toml_text
