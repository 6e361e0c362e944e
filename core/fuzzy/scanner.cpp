#include "fuzzy/scanner.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "fuzzy/names.hpp"

namespace springnet::fuzzy {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

std::string shown(const Token& token) {
  return token.kind == Token::Kind::end ? "the end of the file" : fmt::format("'{}'", printable(token.text));
}

Scanner::Scanner(std::string_view text, std::string_view name) : text_(text), name_(name) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (text_.starts_with(byte_order_mark)) text_.remove_prefix(byte_order_mark.size());
  next_ = scan();
}

Token Scanner::take() {
  const Token taken = next_;
  next_ = scan();
  return taken;
}

void Scanner::fail(std::size_t place, std::string_view what) const {
  const std::string_view before = text_.substr(0, place);
  const std::size_t line_begin = before.rfind('\n') + 1;  // npos + 1 is 0
  // Columns count characters, not the bytes that follow the first one of a character.
  const auto column = 1 + std::count_if(before.begin() + static_cast<std::ptrdiff_t>(line_begin), before.end(),
                                        [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; });
  throw Error(ErrorKind::input,
              fmt::format("{}:{}:{}: {}", name_, 1 + std::count(before.begin(), before.end(), '\n'), column, what));
}

// White space, (* comments *) and // comments.
void Scanner::skip() {
  while (place_ < text_.size()) {
    const std::string_view rest = text_.substr(place_);
    if (rest.starts_with("//")) {
      place_ = std::min(text_.find('\n', place_), text_.size());
    } else if (rest.starts_with("(*")) {
      const std::size_t end = text_.find("*)", place_ + 2);
      if (end == std::string_view::npos) fail(place_, "this comment does not end; write '*)' after it");
      place_ = end + 2;
    } else if (rest[0] == ' ' || rest[0] == '\t' || rest[0] == '\n' || rest[0] == '\r') {
      ++place_;
    } else {
      return;
    }
  }
}

Token Scanner::scan() {
  skip();
  if (place_ >= text_.size()) return {Token::Kind::end, {}, text_.size(), 0.0};
  const std::string_view rest = text_.substr(place_);
  const char c = rest[0];
  if (is_letter(c)) {
    std::size_t length = 1;
    while (length < rest.size() && (is_letter(rest[length]) || is_digit(rest[length]))) ++length;
    const Token word{Token::Kind::word, rest.substr(0, length), place_, 0.0};
    place_ += length;
    return word;
  }
  const auto digit_at = [&](std::size_t at) { return at < rest.size() && is_digit(rest[at]); };
  const std::size_t sign = c == '-' || c == '+' ? 1 : 0;
  if (digit_at(sign) || (rest.substr(sign).starts_with('.') && digit_at(sign + 1))) return scan_number();
  for (const std::string_view symbol : {":=", "..", "(", ")", ",", ";", ":"}) {
    if (!rest.starts_with(symbol)) continue;
    const Token found{Token::Kind::symbol, rest.substr(0, symbol.size()), place_, 0.0};
    place_ += symbol.size();
    return found;
  }
  std::size_t length = 1;
  while (length < rest.size() && (static_cast<unsigned char>(rest[length]) & 0xc0U) == 0x80U) ++length;
  fail(place_, fmt::format("'{}' has no meaning in FCL", printable(rest.substr(0, length))));
}

// "0..1" is a range, not 0. and .1.
Token Scanner::scan_number() {
  const std::size_t begin = place_;
  std::size_t at = begin + (text_[begin] == '-' || text_[begin] == '+' ? 1 : 0);
  const auto skip_digits = [&] {
    while (at < text_.size() && is_digit(text_[at])) ++at;
  };
  skip_digits();
  if (at < text_.size() && text_[at] == '.' && !text_.substr(at).starts_with("..")) {
    ++at;
    skip_digits();
  }
  if (at < text_.size() && (text_[at] == 'e' || text_[at] == 'E')) {
    ++at;
    if (at < text_.size() && (text_[at] == '-' || text_[at] == '+')) ++at;
    skip_digits();
  }
  Token token{Token::Kind::number, text_.substr(begin, at - begin), begin, 0.0};
  const char* const first = text_.data() + begin + (text_[begin] == '+' ? 1 : 0);
  const auto [end, error] = std::from_chars(first, text_.data() + at, token.number);
  if (error == std::errc::result_out_of_range)
    fail(begin, fmt::format("'{}' is too large or too small for a number", printable(token.text)));
  if (at < text_.size() && is_letter(text_[at])) ++at;
  if (error != std::errc() || end != text_.data() + at)
    fail(begin, fmt::format("'{}' is not a number", printable(text_.substr(begin, at - begin))));
  place_ = at;
  return token;
}

}  // namespace springnet::fuzzy
