#include "tables/table.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace springnet::tables {

namespace {

using Cell = Columns::Cell;

// Characters of the longest number, "-2.2250738585072014e-308", and of the longest time, which has no sign.
constexpr double number_length = 24.0, time_length = 23.0;

double digits_below(double bound) { return std::floor(std::log10(std::max(bound - 1.0, 1.0))) + 1.0; }

bool is_binary(const Table& table, const OutputOptions& options) {
  return table.numbers != nullptr && options.format == OutputOptions::Format::binary;
}

bool is_wanted(const Columns& columns, const OutputOptions& options) {
  return columns.wanted == nullptr || columns.wanted(options);
}

// Characters of a row without its text, with commas and the end of the line.
double row_length(const Table& table, const OutputOptions& options, double count_bound) {
  double length = time_length + 1.0;
  for (const Columns& columns : table.columns) {
    if (!is_wanted(columns, options)) continue;
    double cell = 0.0;
    switch (columns.cell) {
      case Cell::number:
        cell = number_length;
        break;
      case Cell::flag:
        cell = 1.0;
        break;
      case Cell::count:
        cell = digits_below(count_bound);
        break;
      case Cell::text:
        break;
    }
    length += static_cast<double>(columns.names.size()) * (1.0 + cell);
  }
  return length;
}

RowCount count_rows(const Table& table, const Network& network, const OutputOptions& options) {
  if (table.rows != nullptr) return table.rows(network, options);
  const std::vector<std::uint32_t> numbers = table.numbers(network, options);
  return {static_cast<double>(numbers.size()), numbers.empty() ? 1.0 : numbers.back() + 1.0};
}

}  // namespace

std::string file_name(const Table& table, const OutputOptions& options) {
  return std::string(table.name) + (is_binary(table, options) ? ".bin" : ".csv");
}

std::vector<std::string> file_names(const Table& table) {
  std::vector<std::string> names{std::string(table.name) + ".csv"};
  if (table.numbers != nullptr) names.push_back(std::string(table.name) + ".bin");
  return names;
}

TableForm form_of(const Table& table, const Network& network, const OutputOptions& options) {
  TableForm form{std::string(table.columns.front().names.front()), {}, {}, {}};
  if (table.numbers != nullptr) form.numbers = table.numbers(network, options);
  for (auto columns = table.columns.begin() + 1; columns != table.columns.end(); ++columns) {
    if (!is_wanted(*columns, options)) continue;
    form.columns.insert(form.columns.end(), columns->names.begin(), columns->names.end());
    form.units.insert(form.units.end(), columns->names.size(), std::string(columns->unit));
  }
  return form;
}

std::unique_ptr<TableFile> create(const Table& table, const OutputFile& file, const Network& network,
                                  const OutputOptions& options) {
  return std::make_unique<TableFile>(file, form_of(table, network, options),
                                     is_binary(table, options) ? std::optional(options.precision) : std::nullopt);
}

std::unique_ptr<TableFile> reopen(const Table& table, const OutputFile& file, const OutputOptions& options,
                                  const CheckedFile::End& end) {
  return std::make_unique<TableFile>(file, end,
                                     is_binary(table, options) ? std::optional(options.precision) : std::nullopt);
}

std::optional<FileEstimate> estimate(const Table& table, const Network& network, const OutputOptions& options,
                                     double records) {
  if (table.rows == nullptr && table.numbers == nullptr) return std::nullopt;
  const std::string file = file_name(table, options);
  if (is_binary(table, options)) {
    const TableForm form = form_of(table, network, options);
    const auto header = static_cast<double>(binary_header(form, options.precision).size());
    return FileEstimate{file, header + records * static_cast<double>(record_bytes(form, options.precision)), true};
  }
  const RowCount count = count_rows(table, network, options);
  if (std::isnan(count.rows)) return std::nullopt;
  return FileEstimate{file, records * (count.rows * row_length(table, options, count.count_bound) + count.text), false};
}

std::vector<std::uint32_t> chosen_or_all(const std::vector<std::uint32_t>& chosen, std::size_t count) {
  if (!chosen.empty()) return chosen;
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

}  // namespace springnet::tables
