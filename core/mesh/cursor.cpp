#include "mesh/cursor.hpp"

#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

namespace springnet::meshes {
namespace {

bool is_space(char c) noexcept { return c == ' ' || (c >= '\t' && c <= '\r'); }

std::string_view without_plus(std::string_view text) noexcept {
  return text.size() > 1 && text[0] == '+' && text[1] != '-' ? text.substr(1) : text;
}

}  // namespace

bool parse_real(std::string_view text, double& value) {
  text = without_plus(text);
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return false;
  // from_chars reports underflow and overflow alike: accept underflow as zero, reject overflow.
  if (failed == std::errc::result_out_of_range) {
    const std::size_t exponent = text.find_first_of("eE");
    const bool small = exponent == std::string_view::npos ? text.find_first_of("123456789") > text.find('.')
                                                          : text.substr(exponent + 1).starts_with('-');
    value = small ? 0.0 : std::numeric_limits<double>::infinity();
  }
  return failed != std::errc::invalid_argument;
}

template <std::integral T>
bool parse_integer(std::string_view text, T& value) {
  text = without_plus(text);
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failed == std::errc() && end == text.data() + text.size();
}
template bool parse_integer(std::string_view, std::int32_t&);
template bool parse_integer(std::string_view, std::int64_t&);
template bool parse_integer(std::string_view, std::uint64_t&);

bool Cursor::at_end() noexcept {
  const std::string_view text = source_->text();
  while (at_ < end_ && is_space(text[at_])) ++at_;
  return at_ == end_;
}

std::string_view Cursor::peek() noexcept {
  const std::string_view text = source_->text();
  std::size_t end = at_end() ? end_ : at_;
  while (end < end_ && !is_space(text[end])) ++end;
  return text.substr(at_, end - at_);
}

std::string_view Cursor::word(std::string_view what) {
  const std::string_view found = peek();
  last_ = at_;
  if (found.empty()) fail(fmt::format("the file ends where {} should be; it is cut off, export it again", what));
  at_ += found.size();
  return found;
}

double Cursor::real(std::string_view what) {
  const std::string_view text = word(what);
  double value = 0.0;
  if (!parse_real(text, value)) {
    fail(fmt::format("this should be {}, a number; correct the line or export the mesh again", what));
  }
  if (!std::isfinite(value)) {
    fail(fmt::format("{} is not finite; correct the mesh where it was made", what));
  }
  return value;
}

template <std::integral T>
T Cursor::integer(std::string_view what) {
  const std::string_view text = word(what);
  T value = 0;
  if (!parse_integer(text, value)) {
    fail(fmt::format("this should be {}, a whole number; correct the line or export the mesh again", what));
  }
  return value;
}
template std::int32_t Cursor::integer(std::string_view);
template std::int64_t Cursor::integer(std::string_view);
template std::uint64_t Cursor::integer(std::string_view);

std::size_t Cursor::count(std::string_view what, std::size_t bytes_each) {
  const auto value = integer<std::uint64_t>(what);
  check_count(value, bytes_each, what);
  return static_cast<std::size_t>(value);
}

void Cursor::check_count(std::uint64_t count, std::size_t bytes_each, std::string_view what) const {
  if (bytes_each == 0 || count <= left() / bytes_each) return;
  fail(fmt::format(
      "{} is {}, but only {} bytes of the file are left; it is cut off or the number is wrong, export it again", what,
      count, left()));
}

std::string_view Cursor::line() noexcept {
  const std::string_view text = source_->text();
  const std::size_t begin = at_;
  last_ = at_;
  while (at_ < end_ && text[at_] != '\n') ++at_;
  std::size_t end = at_;
  if (at_ < end_) ++at_;
  if (end > begin && text[end - 1] == '\r') --end;
  return text.substr(begin, end - begin);
}

std::string_view Cursor::bytes(std::size_t count, std::string_view what) {
  last_ = at_;
  if (count > left()) {
    fail(fmt::format("the file ends within {}; it is cut off, export it again", what));
  }
  at_ += count;
  return source_->text().substr(last_, count);
}

}  // namespace springnet::meshes
