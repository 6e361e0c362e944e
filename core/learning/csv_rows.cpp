#include "learning/csv_rows.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "text/grouped.hpp"

namespace springnet::learning {
namespace {

constexpr std::size_t max_path_length = 200;  // characters of it in messages
constexpr std::size_t block = std::size_t{1} << 20;
constexpr std::size_t longest_line = 1'000'000;  // bytes
constexpr std::string_view spaces = " \t\r";

std::string_view without_spaces(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(spaces);
  return begin == std::string_view::npos ? std::string_view()
                                         : text.substr(begin, text.find_last_not_of(spaces) + 1 - begin);
}

// Where the quotation mark is that ends a cell; two of them are one within it.
std::size_t find_closing_quote(std::string_view line, std::size_t begin) {
  std::size_t quote = line.find('"', begin);
  while (quote < line.size() && line.substr(quote).starts_with("\"\"")) quote = line.find('"', quote + 2);
  return quote;
}

}  // namespace

CsvRows::CsvRows(const std::filesystem::path& file) : name_(printable(file.string(), max_path_length)), in_(file) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // of UTF-8
  fill();
  if (begins_with(byte_order_mark)) at_ = byte_order_mark.size();
  bytes_read_ = at_;
}

std::string CsvRows::place() const { return fmt::format("{}:{}", name_, std::max(line_, 1u)); }

void CsvRows::fail(std::string_view what) const { throw Error(ErrorKind::input, fmt::format("{}: {}", place(), what)); }

bool CsvRows::next() {
  while (const std::optional<std::string_view> line = next_line()) {
    const std::string_view text = without_spaces(*line);
    if (text.empty() || text.front() == '#') continue;
    split(text);
    return true;
  }
  return false;
}

// Appends bytes to what is left in the buffer; false at the end.
bool CsvRows::fill() {
  buffer_.erase(0, at_);
  at_ = 0;
  const std::size_t before = buffer_.size();
  if (!is_read_) is_read_ = !in_.read(buffer_, block);
  return buffer_.size() > before;
}

std::optional<std::string_view> CsvRows::next_line() {
  std::size_t searched = 0, end = std::string::npos;
  while ((end = buffer_.find('\n', at_ + searched)) == std::string::npos) {
    searched = buffer_.size() - at_;
    if (searched > longest_line || !fill()) break;
  }
  is_ended_ = end != std::string::npos;
  if (!is_ended_) end = buffer_.size();
  const std::size_t length = end - at_;
  if (length == 0 && !is_ended_) return std::nullopt;
  if (line_ == std::numeric_limits<std::uint32_t>::max())
    fail(fmt::format("the file has more than {} lines; divide it", grouped(line_)));
  ++line_;
  if (length > longest_line)
    fail(fmt::format("this line has more than {} bytes; name a table with a row each line", grouped(longest_line)));
  const std::string_view line(buffer_.data() + at_, length);
  at_ = end + (is_ended_ ? 1 : 0);
  bytes_read_ += length + (is_ended_ ? 1 : 0);
  return line;
}

void CsvRows::split(std::string_view line) {
  cells_.clear();
  std::size_t at = 0;
  while (true) {
    const std::size_t begin = std::min(line.find_first_not_of(spaces, at), line.size());
    std::size_t end = 0;  // of the cell, a comma or the end of the line
    if (begin < line.size() && line[begin] == '"') {
      const std::size_t quote = find_closing_quote(line, begin + 1);
      if (quote == std::string_view::npos)
        fail(fmt::format("the quotation mark before cell {} is not closed on this line; close or remove it",
                         cells_.size() + 1));
      end = std::min(line.find_first_not_of(spaces, quote + 1), line.size());
      if (end < line.size() && line[end] != ',')
        fail(fmt::format(
            "text follows the quotation mark that ends cell {}; put all of the cell between quotation marks",
            cells_.size() + 1));
      cells_.push_back(without_spaces(line.substr(begin + 1, quote - begin - 1)));
    } else {
      end = std::min(line.find(',', begin), line.size());
      cells_.push_back(without_spaces(line.substr(begin, end - begin)));
    }
    if (end == line.size()) return;
    at = end + 1;
  }
}

}  // namespace springnet::learning
