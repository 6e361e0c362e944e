#include "scene/law_tables.hpp"

#include <fmt/format.h>

#include <springnet/printable.hpp>

namespace springnet::scene {
namespace {

std::vector<double> read_list(const Value& given, const springnet_table& declared) {
  std::vector<double> values = given.numbers(most_table_values);
  if (const auto wrong = check_table(declared, values)) {
    (wrong->row ? given.element(*wrong->row) : given).fail(wrong->what);
  }
  return values;
}

// The column has the name of the table unless the scene gives another.
std::vector<double> read_column(const Table& given, const springnet_table& declared, const Files& files) {
  const Value file = given.need("file");
  const auto column = given.find("column");
  const std::string name = column ? column->text() : declared.name;
  CsvColumns read = files.csv_columns(file, {name});
  if (const auto wrong = check_table(declared, read.values[0])) {
    file.fail(fmt::format("{}: column '{}' {}", wrong->row ? read.place(*wrong->row) : read.file, printable(name),
                          wrong->what));
  }
  return std::move(read.values[0]);
}

}  // namespace

TableValues read_law_tables(const Table& law, const springnet_component& component, const Files& files) {
  TableValues values;
  for (const springnet_table* declared : tables_of(component)) {
    const std::optional<Value> given = law.find_parameter(declared->name);
    if (!given) continue;
    values[declared->name] =
        given->is_list() ? read_list(*given, *declared) : read_column(given->table("values"), *declared, files);
  }
  return values;
}

}  // namespace springnet::scene
