#include "scene/reader.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "network/checks.hpp"
#include "scene/keys.hpp"
#include "text/grouped.hpp"

namespace springnet::scene {
namespace {

std::string_view describe(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "a text";
    case toml::node_type::integer:
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

// Values of overrides come from separate documents, named after the override.
std::string location(const toml::source_region& region, std::string_view document) {
  if (region.path && *region.path != document) return *region.path;
  if (region.begin.line == 0) return std::string(document);
  return fmt::format("{}:{}:{}", document, region.begin.line, region.begin.column);
}

[[noreturn]] void fail_at(const std::string& where, std::string_view path, std::string_view what) {
  throw Error(ErrorKind::input,
              path.empty() ? fmt::format("{}: {}", where, what) : fmt::format("{}: {}: {}", where, path, what));
}

}  // namespace

Value::Value(const toml::node& node, std::string path, std::string_view document)
    : node_(&node), path_(std::move(path)), document_(document) {}

void Value::fail(std::string_view what) const { fail_at(place(), path_, what); }

std::string Value::place() const { return location(node_->source(), document_); }

std::string Value::where() const { return path_.empty() ? place() : fmt::format("{}: {}", place(), path_); }

void Value::wrong_type(std::string_view wanted) const {
  fail(fmt::format("must be {}, is {}", wanted, describe(*node_)));
}

double Value::coordinate() const {
  const std::optional<double> value = node_->is_number() ? node_->value<double>() : std::nullopt;
  if (!value) wrong_type("a number");
  if (std::isnan(*value)) fail("must be a number, is nan");
  return *value;
}

double Value::number() const {
  const double value = coordinate();
  if (!std::isfinite(value)) fail(fmt::format("must be a finite number, is {}", value));
  return value;
}

double Value::number_above_0(std::string_view unit) const {
  const double value = number();
  if (!(value > 0)) fail(fmt::format("must be above 0{}{}, is {}", unit.empty() ? "" : " ", unit, value));
  return value;
}

double Value::number_from_0(std::string_view unit) const {
  const double value = number();
  if (!(value >= 0)) fail(fmt::format("must be at least 0{}{}, is {}", unit.empty() ? "" : " ", unit, value));
  return value;
}

std::int64_t Value::integer(std::int64_t smallest, std::int64_t largest) const {
  const std::optional<std::int64_t> value = node_->value_exact<std::int64_t>();
  if (!value) {
    if (node_->is_floating_point()) fail(fmt::format("must be a whole number, is {}", *node_->value<double>()));
    wrong_type("a whole number");
  }
  if (*value < smallest) fail(fmt::format("must be at least {}, is {}", smallest, *value));
  if (*value > largest) fail(fmt::format("must be at most {}, is {}", largest, *value));
  return *value;
}

bool Value::boolean() const {
  const std::optional<bool> value = node_->value_exact<bool>();
  if (!value) wrong_type("true or false");
  return *value;
}

std::string Value::text() const {
  std::string value = prose();
  if (value.find_first_of("\n\r\t") != std::string::npos) fail("must be one line, without tabs; remove them");
  return value;
}

std::string Value::prose(std::size_t longest) const {
  const std::optional<std::string> value = node_->value_exact<std::string>();
  if (!value) wrong_type("a text in quotes");
  if (value->empty()) fail("must not be empty");
  if (value->size() > longest) {
    fail(fmt::format("must have at most {} bytes, has {}; shorten it", grouped(longest), grouped(value->size())));
  }
  const auto control = std::find_if(value->begin(), value->end(), [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return (code < 0x20 && c != '\n' && c != '\r' && c != '\t') || code == 0x7f;
  });
  // In UTF-8, which TOML requires, the control characters from U+0080 on are c2 and a byte up to 9f.
  bool second_control = false;
  for (std::size_t k = 0; k + 1 < value->size(); ++k) {
    second_control = second_control || ((*value)[k] == '\xc2' && static_cast<unsigned char>((*value)[k + 1]) < 0xa0);
  }
  if (control != value->end() || second_control) {
    fail(fmt::format("must not have control characters, is '{}'; remove them", printable(*value)));
  }
  return *value;
}

std::size_t Value::choice(const std::vector<std::string>& choices, std::string_view or_else) const {
  const std::string chosen = text();
  const auto found = std::find(choices.begin(), choices.end(), chosen);
  if (found == choices.end()) {
    const std::string nearest = suggestion(chosen, choices);
    fail(fmt::format("must be one of '{}'{}{}, is '{}'{}{}", fmt::join(choices, "', '"), or_else.empty() ? "" : " or ",
                     or_else, printable(chosen), nearest.empty() ? "" : "; ", nearest));
  }
  return static_cast<std::size_t>(found - choices.begin());
}

std::vector<Value> Value::elements() const {
  const toml::array* array = node_->as_array();
  if (array == nullptr) wrong_type("a list");
  std::vector<Value> values;
  values.reserve(array->size());
  for (std::size_t i = 0; i < array->size(); ++i) {
    values.emplace_back((*array)[i], fmt::format("{}.{}", path_, i), document_);
  }
  return values;
}

Value Value::element(std::size_t index) const {
  return {node_->as_array()->at(index), fmt::format("{}.{}", path_, index), document_};
}

std::vector<double> Value::numbers(std::size_t most) const {
  const toml::array* array = node_->as_array();
  if (array == nullptr) wrong_type("a list of numbers");
  if (array->size() > most) {
    fail(fmt::format("must have at most {} numbers, has {}; leave out some", grouped(most), grouped(array->size())));
  }
  std::vector<double> values;
  values.reserve(array->size());
  for (const toml::node& node : *array) {
    const std::optional<double> value = node.is_number() ? node.value<double>() : std::nullopt;
    values.push_back(value && std::isfinite(*value) ? *value : element(values.size()).number());
  }
  return values;
}

std::vector<Value> Value::elements(std::size_t count) const {
  std::vector<Value> values = elements();
  if (values.size() != count) fail(fmt::format("must have {} elements, has {}", count, values.size()));
  return values;
}

Vector3 Value::vector() const {
  if (!is_list()) wrong_type("three numbers [x, y, z]");
  const std::vector<Value> values = elements(3);
  return {values[0].number(), values[1].number(), values[2].number()};
}

Vector3 Value::direction() const {
  const Vector3 given = vector();
  if (!(given.stableNorm() > 0)) fail("has length zero; give a direction, as [0, 0, 1]");
  return checks::to_unit(given);
}

Table Value::open_table(std::string_view schema) const { return {*this, schema}; }

Table Value::table(std::string_view schema) const {
  Table result(*this, schema);
  result.check_keys();
  return result;
}

Table::Table(const Value& value, std::string_view schema)
    : value_(value), table_(value.node_->as_table()), schema_(schema) {
  if (table_ == nullptr) value.wrong_type(form_of_table(schema));
}

std::string Table::path_of(std::string_view key) const {
  return value_.path_.empty() ? std::string(key) : fmt::format("{}.{}", value_.path_, key);
}

std::vector<std::string> Table::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, node] : *table_) keys.emplace_back(key.str());
  return keys;
}

std::optional<Value> Table::find_parameter(std::string_view key) const {
  const toml::node* node = table_->get(key);
  if (node == nullptr) return std::nullopt;
  return Value(*node, path_of(key), value_.document_);
}

std::optional<Value> Table::find(std::string_view key) const {
  static_cast<void>(form_of(schema_.empty() ? std::string(key) : fmt::format("{}.{}", schema_, key)));
  return find_parameter(key);
}

bool Table::has(std::string_view key) const { return find(key).has_value(); }

Value Table::need(std::string_view key) const {
  if (std::optional<Value> value = find(key)) return *value;
  const std::string_view form = form_of(schema_.empty() ? std::string(key) : fmt::format("{}.{}", schema_, key));
  fail(fmt::format("the key '{}' is missing; add it: {}", key, form));
}

std::vector<Value> Table::tables(std::string_view key) const {
  const std::optional<Value> value = find(key);
  if (!value) return {};
  if (!value->is_list()) {
    value->fail(fmt::format("must be a list of tables, is {}; write [[{}]]", describe(*value->node_), key));
  }
  return value->elements();
}

void Table::check_keys(const std::vector<std::string>& more, std::string_view owner) const {
  std::vector<std::string> known = keys_in(schema_);
  known.insert(known.end(), more.begin(), more.end());
  for (const auto& [key, node] : *table_) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    const std::string nearest = suggestion(key.str(), known);
    const bool has_place = key.source().begin.line != 0;
    fail_at(location(has_place ? key.source() : node.source(), value_.document_), path_of(printable(key.str())),
            fmt::format("there is no key '{}'{}{}; {}known: {}", printable(key.str()), owner.empty() ? "" : " of ",
                        owner, nearest.empty() ? "" : nearest + " ", fmt::join(known, ", ")));
  }
}

}  // namespace springnet::scene
