#include "scene/csv_columns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "mesh/cursor.hpp"
#include "scene/file_text.hpp"
#include "text/grouped.hpp"

namespace springnet::scene {
namespace {

constexpr std::size_t max_path_length = 200;  // characters of it in messages
static_assert(largest_csv <= largest_scene, "read_scene_text reads no more");
constexpr std::size_t not_asked_for = std::numeric_limits<std::size_t>::max();

std::string_view without_spaces(std::string_view text) {
  constexpr std::string_view spaces = " \t\r";
  const std::size_t begin = text.find_first_not_of(spaces);
  return begin == std::string_view::npos ? std::string_view()
                                         : text.substr(begin, text.find_last_not_of(spaces) + 1 - begin);
}

// Spreadsheets put names into quotation marks.
std::string_view without_quotes(std::string_view name) {
  return name.size() >= 2 && name.front() == '"' && name.back() == '"' ? name.substr(1, name.size() - 2) : name;
}

class Reader {
 public:
  Reader(std::string_view text, std::string_view name) : text_(text), name_(name) {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // of UTF-8
    if (text_.starts_with(byte_order_mark)) text_.remove_prefix(byte_order_mark.size());
  }

  [[noreturn]] void fail(std::string_view what) const {
    throw Error(ErrorKind::input, fmt::format("{}:{}: {}", printable(name_, max_path_length), line_, what));
  }
  [[nodiscard]] std::uint32_t line() const noexcept { return line_; }

  // The next line that says something; none at the end.
  std::optional<std::string_view> next() {
    while (!text_.empty()) {
      const std::size_t end = std::min(text_.find('\n'), text_.size());
      const std::string_view line = without_spaces(text_.substr(0, end));
      text_.remove_prefix(std::min(end + 1, text_.size()));
      ++line_;
      if (!line.empty() && line.front() != '#') return line;
    }
    return std::nullopt;
  }

 private:
  std::string_view text_, name_;
  std::uint32_t line_ = 0;
};

// Calls take(number, cell) for the cells of a line; returns how many there are.
template <class Take>
std::size_t for_each_cell(std::string_view line, const Take& take) {
  std::size_t count = 0;
  while (true) {
    const std::size_t comma = line.find(',');
    take(count++, without_spaces(line.substr(0, comma)));
    if (comma == std::string_view::npos) return count;
    line.remove_prefix(comma + 1);
  }
}

double number_in(std::string_view cell, const std::string& column, const Reader& reader) {
  double value = 0.0;
  if (cell.empty()) {
    reader.fail(fmt::format("column '{}' has no value here; fill it in, or remove the row", printable(column)));
  }
  if (!meshes::parse_real(cell, value)) {
    reader.fail(fmt::format("column '{}' must have a number here, with a point for the decimals", printable(column)));
  }
  if (!std::isfinite(value)) {
    reader.fail(fmt::format("column '{}' must have a finite number here; remove the row", printable(column)));
  }
  return value;
}

}  // namespace

CsvColumns parse_csv_columns(std::string_view text, std::string_view name, const std::vector<std::string>& names) {
  Reader reader(text, name);
  const std::optional<std::string_view> header = reader.next();
  if (!header) reader.fail("the file has no header line; begin it with the names of its columns, separated by commas");

  std::vector<std::size_t> asked;  // [column of the file] which of `names`
  const std::size_t width = for_each_cell(*header, [&](std::size_t, std::string_view cell) {
    const auto found = std::find(names.begin(), names.end(), without_quotes(cell));
    asked.push_back(found == names.end() ? not_asked_for : static_cast<std::size_t>(found - names.begin()));
  });
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto count = std::count(asked.begin(), asked.end(), k);
    if (count == 1) continue;
    if (count > 1) reader.fail(fmt::format("two columns are named '{}'; rename one", printable(names[k])));
    reader.fail(
        fmt::format("no column is named '{}' (this header line has {} names, separated by commas); correct the name",
                    printable(names[k]), width));
  }

  CsvColumns result;
  result.values.resize(names.size());
  while (const std::optional<std::string_view> row = reader.next()) {
    if (result.lines.size() == most_csv_rows) {
      reader.fail(fmt::format("the file has more than {} rows; leave out some", grouped(most_csv_rows)));
    }
    const std::size_t count = for_each_cell(*row, [&](std::size_t column, std::string_view cell) {
      if (column >= width || asked[column] == not_asked_for) return;
      result.values[asked[column]].push_back(number_in(cell, names[asked[column]], reader));
    });
    if (count != width) {
      reader.fail(fmt::format("this row has {} cells, the header line has {}; separate them by commas", count, width));
    }
    result.lines.push_back(reader.line());
  }
  return result;
}

CsvColumns read_csv_columns(const std::filesystem::path& file, const std::vector<std::string>& names) {
  const auto fail = [&](std::string_view what) {
    throw Error(ErrorKind::input, fmt::format("{}: {}", printable(file.string(), max_path_length), what));
  };
  std::error_code failed;
  const std::filesystem::file_status status = std::filesystem::status(file, failed);
  if (!std::filesystem::exists(status)) fail("there is no such file; check the path");
  // Pipes and devices may never end.
  if (!std::filesystem::is_regular_file(status)) fail("this is not a file; name a CSV file");
  const std::string text = read_scene_text(file);
  if (text.size() > largest_csv) fail(fmt::format("the file has more than {} bytes; shorten it", grouped(largest_csv)));
  return parse_csv_columns(text, file.string(), names);
}

}  // namespace springnet::scene
