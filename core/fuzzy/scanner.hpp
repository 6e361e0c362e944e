// The text of a rule base as a sequence of words, numbers and symbols, each with its place.
#pragma once

#include <string>
#include <string_view>

namespace springnet::fuzzy {

struct Token {
  enum class Kind { word, number, symbol, end };
  Kind kind = Kind::end;
  std::string_view text;  // symbols: ( ) , ; : := ..
  std::size_t place = 0;  // bytes from the begin
  double number = 0.0;
};

class Scanner {
 public:
  // The text must outlive the scanner and its tokens.
  Scanner(std::string_view text, std::string_view name);

  [[nodiscard]] const Token& peek() const noexcept { return next_; }
  Token take();
  // Throws Error(input): "name:line:column: what".
  [[noreturn]] void fail(std::size_t place, std::string_view what) const;
  [[noreturn]] void fail(const Token& token, std::string_view what) const { fail(token.place, what); }

 private:
  void skip();
  Token scan();
  Token scan_number();

  std::string_view text_, name_;
  std::size_t place_ = 0;
  Token next_;
};

// As messages name it: "'low'", "the end of the file".
[[nodiscard]] std::string shown(const Token& token);

}  // namespace springnet::fuzzy
