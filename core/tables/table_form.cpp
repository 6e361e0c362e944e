#include "tables/table_form.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace springnet {

namespace {

using Precision = OutputOptions::Precision;

// Whether these are 0, 1, 2, …
bool are_consecutive(const std::vector<std::uint32_t>& numbers) {
  for (std::size_t k = 0; k < numbers.size(); ++k)
    if (numbers[k] != k) return false;
  return true;
}

}  // namespace

std::string csv_header(const TableForm& form) {
  return fmt::format("time,{},{}", form.row, fmt::join(form.columns, ","));
}

std::size_t record_bytes(const TableForm& form, Precision precision) {
  const std::size_t number = precision == Precision::float64 ? sizeof(double) : sizeof(float);
  return sizeof(double) + form.numbers.size() * form.columns.size() * number;
}

std::string binary_header(const TableForm& form, Precision precision) {
  nlohmann::ordered_json description{{"row", form.row},
                                     {"rows", form.numbers.size()},
                                     {"columns", form.columns},
                                     {"units", form.units},
                                     {"type", precision == Precision::float64 ? "<f8" : "<f4"},
                                     {"record_bytes", record_bytes(form, precision)}};
  description["numbers"] =
      are_consecutive(form.numbers) ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(form.numbers);
  const std::string text = description.dump();
  // Records start at a multiple of 64 bytes, so that numbers of eight bytes are aligned in memory.
  constexpr std::size_t first_line = 29;  // "springnet records 1 01234567\n"
  constexpr std::size_t alignment = 64;
  const std::size_t bytes = (first_line + text.size() + 1 + alignment - 1) / alignment * alignment;
  std::string header = fmt::format("springnet records 1 {:08}\n{}", bytes, text);
  header.resize(bytes - 1, ' ');
  return header + '\n';
}

}  // namespace springnet
