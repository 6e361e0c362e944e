#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/observations.hpp>
#include <springnet/printable.hpp>
#include <springnet/records.hpp>

#include "learning/csv_rows.hpp"
#include "learning/observed_columns.hpp"
#include "mesh/cursor.hpp"
#include "text/grouped.hpp"

namespace springnet {
namespace {

using learning::CsvRows;
using learning::ObservedColumns;
using Place = Observations::Place;

constexpr std::size_t none = ObservedColumns::none;
constexpr std::string_view binary_table = "springnet records ";
constexpr std::string_view if_missing = "leave the cell empty if the value is missing";

// Numbers of a table to rows. A missing number is nan.
class Table {
 public:
  // `name` and `place` (of the header) are those of messages.
  Table(std::vector<std::string> columns, std::string name, bool is_binary, const std::string& place)
      : names_(std::move(columns)), columns_(learning::observed_columns(names_, place)) {
    result_.files.push_back({std::move(name), is_binary});
  }

  [[nodiscard]] const std::vector<std::size_t>& numbers() const noexcept { return columns_.numbers; }
  [[nodiscard]] Observations& result() noexcept { return result_; }

  void reserve(std::size_t rows) {
    if (columns_.distance != none) return result_.distances.reserve(rows);
    if (columns_.has_surface_points()) return result_.surface_points.reserve(rows);
    if (columns_.position.is_observed()) result_.positions.reserve(rows);
    if (columns_.velocity.is_observed()) result_.velocities.reserve(rows);
    if (columns_.reaction.is_observed()) result_.reactions.reserve(rows);
  }

  // [column], of which those of numbers() are read.
  void take(std::span<const double> cells, std::uint32_t line) {
    cells_ = cells;
    line_ = line;
    for (const std::size_t column : columns_.numbers)
      if (std::isinf(cells_[column]))
        fail(column, fmt::format("is infinite or too large for a number; {}", if_missing));
    const double time = cells_[columns_.time];
    if (std::isnan(time)) fail(columns_.time, "has no value; give the time of the row in s, or remove the row");
    const Place place{0, line};
    if (columns_.has_surface_points()) return take_point(time, place);
    const NodeIndex node = node_at(columns_.node);
    if (columns_.distance != none) return take_distance(time, node, place);
    const auto take = [&](std::vector<Observations::VectorRow>& rows, const ObservedColumns::Quantity& quantity) {
      if (!quantity.is_observed()) return;
      Observations::VectorRow& row = rows.emplace_back();
      row.time = time;
      row.node = node;
      row.place = place;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t column = quantity.values[c];
        if (column == none || std::isnan(cells_[column])) continue;
        row.value[static_cast<Eigen::Index>(c)] = cells_[column];
        row.weight[static_cast<Eigen::Index>(c)] = weight(quantity.deviations[c]);
      }
    };
    take(result_.positions, columns_.position);
    take(result_.velocities, columns_.velocity);
    take(result_.reactions, columns_.reaction);
  }

  [[noreturn]] void fail(std::size_t column, const std::string& what) const {
    std::string place = result_.text_of({0, line_});
    if (result_.files.front().is_binary && column != columns_.time && columns_.node != none)
      place += fmt::format(", node {}", cells_[columns_.node]);
    throw Error(ErrorKind::input, fmt::format("{}: column '{}' {}", place, printable(names_[column]), what));
  }
  [[noreturn]] void fail_at(std::uint32_t line, std::size_t column, const std::string& what) {
    line_ = line;
    fail(column, what);
  }

 private:
  [[nodiscard]] NodeIndex node_at(std::size_t column) const {
    const double number = cells_[column];
    if (std::isnan(number)) fail(column, "has no value; give the number of the node, or remove the row");
    if (number != std::floor(number) || number < 0.0 || number > UINT32_MAX)
      fail(column, fmt::format("is {}; give the number of a node in the scene, a whole number from 0", number));
    return static_cast<NodeIndex>(number);
  }

  // Of a value that is there.
  [[nodiscard]] double weight(std::size_t deviation_column) const {
    double given = 1.0;
    if (columns_.weight != none) {
      given = cells_[columns_.weight];
      if (std::isnan(given)) fail(columns_.weight, "has no value; give the weight of the row, or 0 to leave it out");
      if (given < 0.0) fail(columns_.weight, fmt::format("is {}; weights are not negative", given));
    }
    if (deviation_column == none) return given;
    const double deviation = cells_[deviation_column];
    if (std::isnan(deviation))
      fail(deviation_column, "has no value; give the standard deviation of the value, or leave out the value");
    if (deviation <= 0.0)
      fail(deviation_column, fmt::format("is {}; a standard deviation is greater than 0", deviation));
    const double result = given / (deviation * deviation);
    if (!std::isfinite(result) || (result == 0.0 && given > 0.0))
      fail(deviation_column,
           fmt::format("is {}, which gives the weight {}; correct the standard deviation", deviation, result));
    return result;
  }

  void take_point(double time, const Place& place) {
    Observations::SurfacePoint& row = result_.surface_points.emplace_back();
    row.time = time;
    row.place = place;
    for (std::size_t c = 0; c < 3; ++c) row.point[static_cast<Eigen::Index>(c)] = cells_[columns_.position.values[c]];
    if (row.point.hasNaN()) {
      row.point.setZero();
    } else {
      row.weight = weight(columns_.deviation);
    }
  }

  void take_distance(double time, NodeIndex node, const Place& place) {
    Observations::DistanceRow& row = result_.distances.emplace_back();
    row.time = time;
    row.node = node;
    row.other = node_at(columns_.other);
    row.place = place;
    const double distance = cells_[columns_.distance];
    if (std::isnan(distance)) return;
    if (distance < 0.0) fail(columns_.distance, fmt::format("is {} m; distances are not negative", distance));
    row.distance = distance;
    row.weight = weight(columns_.deviation);
  }

  std::vector<std::string> names_;
  ObservedColumns columns_;
  Observations result_;
  std::span<const double> cells_;
  std::uint32_t line_ = 0;
};

Observations read_text(CsvRows& file) {
  if (!file.next())
    file.fail("the file has no header line; begin it with the names of its columns, separated by commas");
  const std::size_t width = file.cells().size();
  Table table({file.cells().begin(), file.cells().end()}, file.name(), false, file.place());
  std::vector<double> cells(width);
  const std::uint64_t header_bytes = file.bytes_read();
  std::uint64_t rows = 0;
  while (file.next()) {
    const std::size_t count = file.cells().size();
    if (count < width && !file.is_ended())
      file.fail(fmt::format("the file ends within this row ({} of {} cells); remove the row, or write the file again",
                            count, width));
    if (count != width)
      file.fail(fmt::format("this row has {} cells, the header line has {}; separate them by commas", count, width));
    for (const std::size_t column : table.numbers()) {
      const std::string_view cell = file.cells()[column];
      cells[column] = std::numeric_limits<double>::quiet_NaN();
      if (!cell.empty() && !meshes::parse_real(cell, cells[column]))
        table.fail_at(
            file.line(), column,
            fmt::format("has '{}', which is no number (decimals follow a point); {}", printable(cell), if_missing));
    }
    table.take(cells, file.line());
    // The rows so far tell how many are to come. Memory that is reserved for too many is never touched.
    constexpr std::uint64_t enough_rows = 10'000;
    if (++rows == enough_rows && file.file_size())
      table.reserve(static_cast<std::size_t>(1.02 * static_cast<double>(rows) * static_cast<double>(*file.file_size()) /
                                             static_cast<double>(file.bytes_read() - header_bytes)));
  }
  return std::move(table.result());
}

Observations read_binary(const std::filesystem::path& file, const std::string& name) {
  RecordReader reader(file);
  std::vector<std::string> names{"time", reader.row_name()};
  names.insert(names.end(), reader.columns().begin(), reader.columns().end());
  if (reader.records() > UINT32_MAX)
    throw Error(ErrorKind::input,
                fmt::format("{}: the table has more than {} records; write fewer", name, grouped(UINT32_MAX)));
  Table table(names, name, true, name);
  table.reserve(reader.records() * reader.rows().size());
  std::vector<double> cells(names.size()), values;
  const auto width = static_cast<std::ptrdiff_t>(reader.columns().size());
  for (std::size_t record = 0; record < reader.records(); ++record) {
    cells[0] = reader.read(record, values);
    auto row = values.begin();
    for (const std::uint32_t number : reader.rows()) {
      cells[1] = number;
      std::copy(row, row + width, cells.begin() + 2);
      row += width;
      table.take(cells, static_cast<std::uint32_t>(record));
    }
  }
  return std::move(table.result());
}

}  // namespace

Observations read_observations(const std::filesystem::path& file) {
  CsvRows rows(file);
  if (rows.begins_with(binary_table)) return read_binary(file, rows.name());
  return read_text(rows);
}

}  // namespace springnet
