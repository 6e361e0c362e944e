#include "scene/csv_columns.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "mesh/cursor.hpp"
#include "scene/file_text.hpp"
#include "text/grouped.hpp"

namespace springnet::scene {
namespace {

static_assert(largest_csv <= largest_scene, "read_scene_text reads no more");

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

class CsvReader {
 public:
  CsvReader(std::string_view text, std::string_view name) : text_(text), name_(name) {
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // of UTF-8
    if (text_.starts_with(byte_order_mark)) text_.remove_prefix(byte_order_mark.size());
  }

  [[noreturn]] void fail(std::string_view what) const {
    throw Error(ErrorKind::input,
                fmt::format("{}:{}: {}", printable(name_, max_path_length), std::max(line_, 1u), what));
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

// What is wrong with a cell that should be a finite number; nothing if it is one.
std::string_view read_number(std::string_view cell, double& value) {
  if (cell.empty()) return "has no value here; fill it in, or remove the row";
  if (!meshes::parse_real(cell, value)) return "must have a number here, with a point for the decimals";
  if (!std::isfinite(value)) return "must have a finite number here; remove the row";
  return {};
}

}  // namespace

CsvTable::CsvTable(std::string_view text, std::string name, std::size_t most_cells) : file_(std::move(name)) {
  CsvReader reader(text, file_);
  const std::optional<std::string_view> header = reader.next();
  if (!header) reader.fail("the file has no header line; begin it with the names of its columns, separated by commas");
  header_line_ = reader.line();
  const std::size_t width = for_each_cell(*header, [&](std::size_t column, std::string_view cell) {
    if (column == most_csv_columns)
      reader.fail(fmt::format("the file has more than {} columns; leave out some", grouped(most_csv_columns)));
    columns_.push_back({std::string(without_quotes(cell)), {}});
  });
  while (const std::optional<std::string_view> row = reader.next()) {
    if (lines_.size() == most_csv_rows)
      reader.fail(fmt::format("the file has more than {} rows; leave out some", grouped(most_csv_rows)));
    if ((lines_.size() + 1) * width > most_cells) {
      reader.fail(fmt::format("the CSV files of the scene have more than {} cells; leave out columns or rows",
                              grouped(most_csv_cells)));
    }
    const std::size_t count = for_each_cell(*row, [&](std::size_t number, std::string_view cell) {
      if (number >= width) return;
      Column& column = columns_[number];
      double value = 0.0;
      const std::string_view wrong = read_number(cell, value);
      column.values.push_back(value);
      if (wrong.empty() || column.wrong_line > 0) return;
      column.wrong_line = reader.line();
      column.wrong = wrong;
    });
    if (count != width) {
      reader.fail(fmt::format("this row has {} cells, the header line has {}; separate them by commas", count, width));
    }
    lines_.push_back(reader.line());
  }
}

bool CsvTable::has(std::string_view name) const {
  return std::any_of(columns_.begin(), columns_.end(), [&](const Column& column) { return column.name == name; });
}

std::size_t CsvTable::first_other_than(const std::vector<std::string>& names) const {
  const auto other = std::find_if(columns_.begin(), columns_.end(), [&](const Column& column) {
    return std::find(names.begin(), names.end(), column.name) == names.end();
  });
  return other == columns_.end() ? 0 : static_cast<std::size_t>(other - columns_.begin()) + 1;
}

CsvColumns CsvTable::columns(const std::vector<std::string>& names) const {
  const auto fail = [&](std::uint32_t line, std::string_view what) {
    throw Error(ErrorKind::input, fmt::format("{}:{}: {}", printable(file_, max_path_length), line, what));
  };
  CsvColumns result;
  const Column* first_wrong = nullptr;
  for (const std::string& name : names) {
    const auto is_named = [&](const Column& column) { return column.name == name; };
    const auto found = std::find_if(columns_.begin(), columns_.end(), is_named);
    if (found == columns_.end()) {
      fail(header_line_,
           fmt::format("no column is named '{}' (this header line has {} names, separated by commas); correct the name",
                       printable(name), columns_.size()));
    }
    if (std::find_if(found + 1, columns_.end(), is_named) != columns_.end())
      fail(header_line_, fmt::format("two columns are named '{}'; rename one", printable(name)));
    if (found->wrong_line > 0 && (first_wrong == nullptr || found->wrong_line < first_wrong->wrong_line))
      first_wrong = &*found;
    result.values.push_back(found->values);
  }
  if (first_wrong != nullptr) {
    // Named as asked for: the same text, which is not from the file.
    fail(first_wrong->wrong_line, fmt::format("column '{}' {}", printable(first_wrong->name), first_wrong->wrong));
  }
  result.file = printable(file_, max_path_length);
  result.lines = lines_;
  return result;
}

const CsvTable& CsvFiles::read(const std::filesystem::path& file) {
  if (const auto known = known_.find(file); known != known_.end()) return known->second;
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
  const CsvTable& table = known_.try_emplace(file, text, file.string(), most_csv_cells - cells_).first->second;
  cells_ += table.cells();
  return table;
}

}  // namespace springnet::scene
