// The tables of laws: what a law asks for, and what it is given.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "text/counted.hpp"
#include "text/grouped.hpp"

namespace springnet {
namespace {

std::string with_unit(double value, const springnet_table& table) {
  const std::string unit = printable(table.unit);
  return unit == "1" ? fmt::format("{}", value) : fmt::format("{} {}", value, unit);
}

std::string list_tables(std::span<const springnet_table* const> tables) {
  if (tables.empty()) return "it has no tables";
  std::string text = "it has ";
  for (const springnet_table* table : tables) {
    if (text.back() != ' ') text += ", ";
    text += fmt::format("'{}' ({})", table->name, printable(table->unit));
  }
  return text;
}

bool is_optional(const springnet_table& table) { return (table.flags & SPRINGNET_OPTIONAL) != 0; }

}  // namespace

std::span<const springnet_table* const> tables_of(const springnet_component& component) {
  if (component.kind != SPRINGNET_SPRING_FUNCTION && component.kind != SPRINGNET_VISCOSITY_FUNCTION) return {};
  const auto& law = *static_cast<const springnet_law*>(component.implementation);
  return {law.tables, law.table_count};
}

std::optional<TableMistake> check_table(const springnet_table& table, std::span<const double> values) {
  const std::size_t least = std::max<std::size_t>(table.least, 1);
  if (values.size() < least)
    return TableMistake{std::nullopt,
                        fmt::format("must have {} or more, has {}", counted(least, "value"), values.size())};
  if (values.size() > most_table_values)
    return TableMistake{std::nullopt, fmt::format("must have at most {} values, has {}; leave out some",
                                                  grouped(most_table_values), grouped(values.size()))};
  const bool increasing = (table.flags & SPRINGNET_INCREASING) != 0;
  for (std::size_t row = 0; row < values.size(); ++row) {
    const double value = values[row];
    if (!std::isfinite(value)) return TableMistake{row, fmt::format("must be a finite number, is {}", value)};
    if (value < table.smallest)
      return TableMistake{row, fmt::format("must be at least {}, is {}", with_unit(table.smallest, table), value)};
    if (value > table.largest)
      return TableMistake{row, fmt::format("must be at most {}, is {}", with_unit(table.largest, table), value)};
    if (increasing && row > 0 && !(values[row - 1] < value))
      return TableMistake{
          row, fmt::format("must be above the one before, {}, is {}; sort the rows, and give each value once",
                           with_unit(values[row - 1], table), value)};
  }
  return std::nullopt;
}

std::vector<std::span<const double>> complete_tables(const springnet_component& component, const TableValues& given,
                                                     std::string_view where) {
  const std::string what = fmt::format("{} '{}'", name_of(static_cast<ComponentKind>(component.kind)), component.id);
  const std::span<const springnet_table* const> tables = tables_of(component);
  const auto fail = [&](const std::string& wrong) {
    throw Error(ErrorKind::input, fmt::format("{}: {}", where, wrong));
  };
  std::vector<std::span<const double>> complete(tables.size());
  std::vector<bool> is_given(tables.size(), false);
  for (const auto& [name, values] : given) {
    const auto found =
        std::ranges::find_if(tables, [&wanted = name](const springnet_table* table) { return wanted == table->name; });
    if (found == tables.end()) {
      std::vector<std::string> known;
      for (const springnet_table* table : tables) known.emplace_back(table->name);
      const std::string nearest = suggestion(name, known);
      fail(fmt::format("{} has no table '{}'; {}{}", what, printable(name), nearest.empty() ? "" : nearest + " ",
                       list_tables(tables)));
    }
    if (const std::optional<TableMistake> wrong = check_table(**found, values)) {
      fail(fmt::format("table '{}' of {}{} {}", name, what,
                       wrong->row ? fmt::format(": row {}", *wrong->row + 1) : std::string(), wrong->what));
    }
    const auto index = static_cast<std::size_t>(found - tables.begin());
    complete[index] = values;
    is_given[index] = true;
  }
  for (std::size_t k = 0; k < tables.size(); ++k) {
    const springnet_table& table = *tables[k];
    if (!is_given[k] && !is_optional(table)) {
      fail(fmt::format("{} needs the table '{}' ({}: {})", what, table.name, printable(table.unit),
                       printable(table.summary, 200)));
    }
    if (!is_given[k] || table.as_long_as == k) continue;
    const springnet_table& other = *tables[table.as_long_as];
    if (!is_given[table.as_long_as])
      fail(fmt::format("{} needs the table '{}' beside '{}'", what, other.name, table.name));
    if (complete[k].size() != complete[table.as_long_as].size()) {
      fail(fmt::format("table '{}' of {} has {}, but '{}' has {}; give as many", table.name, what,
                       counted(complete[k].size(), "value"), other.name, complete[table.as_long_as].size()));
    }
  }
  return complete;
}

}  // namespace springnet
