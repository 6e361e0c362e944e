// Values of a TOML document with their location, read strictly: every error is "file:line:column: key: what; what to
// do".
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>
#include <springnet/error.hpp>
#include <springnet/network.hpp>

namespace springnet::scene {

class Table;

// All readers throw Error(input) if the value does not have the requested form.
class Value {
 public:
  // `path` as in body.0.mesh.spacing; `document` is the name in messages. Node and name must outlive the value.
  Value(const toml::node& node, std::string path, std::string_view document);

  [[noreturn]] void fail(std::string_view what) const;
  // "must be <wanted>, is a list"
  [[noreturn]] void wrong_type(std::string_view wanted) const;
  // "file:line:column"; of an override "--set key=value"
  [[nodiscard]] std::string place() const;
  // The same with the key: "file:line:column: path"
  [[nodiscard]] std::string where() const;
  [[nodiscard]] const std::string& path() const noexcept { return path_; }

  [[nodiscard]] double number() const;  // finite
  [[nodiscard]] double number_above_0(std::string_view unit) const;
  [[nodiscard]] double number_from_0(std::string_view unit) const;
  [[nodiscard]] double coordinate() const;  // a number, or an infinity
  [[nodiscard]] std::int64_t integer(std::int64_t smallest = std::numeric_limits<std::int64_t>::min(),
                                     std::int64_t largest = std::numeric_limits<std::int64_t>::max()) const;
  [[nodiscard]] bool boolean() const;
  static constexpr std::size_t longest_text = 4096;  // bytes, as for a path
  // Not empty, not longer than that, without control characters.
  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::string prose(std::size_t longest = longest_text) const;  // the same, but may have several lines
  [[nodiscard]] std::size_t choice(const std::vector<std::string>& choices, std::string_view or_else = {}) const;
  [[nodiscard]] Vector3 vector() const;     // [x, y, z]
  [[nodiscard]] Vector3 direction() const;  // the same, normalised

  [[nodiscard]] bool is_text() const noexcept { return node_->is_string(); }
  [[nodiscard]] bool is_boolean() const noexcept { return node_->is_boolean(); }
  [[nodiscard]] bool is_number() const noexcept { return node_->is_number(); }
  [[nodiscard]] bool is_table() const noexcept { return node_->is_table(); }
  [[nodiscard]] bool is_list() const noexcept { return node_->is_array(); }
  [[nodiscard]] std::vector<Value> elements() const;
  [[nodiscard]] std::vector<Value> elements(std::size_t count) const;  // exactly so many
  [[nodiscard]] Value element(std::size_t index) const;                // of a list that has it
  [[nodiscard]] std::vector<double> numbers(std::size_t most) const;   // a list of finite numbers, at most so many

  // A table with no keys other than those of `schema`.
  [[nodiscard]] Table table(std::string_view schema) const;
  // The same without checking its keys.
  [[nodiscard]] Table open_table(std::string_view schema) const;

  // Calls `change` and adds the location to any Error(input) that it throws.
  template <class Change>
  auto at_this_place(Change&& change) const {
    try {
      return change();
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::input) fail(error.what());
      throw;
    }
  }

 private:
  friend class Table;

  const toml::node* node_;
  std::string path_;
  std::string_view document_;
};

class Table {
 public:
  // `schema` is the path of the table in the list of keys: body.mesh for body.0.mesh.
  Table(const Value& value, std::string_view schema);

  [[noreturn]] void fail(std::string_view what) const { value_.fail(what); }
  [[nodiscard]] const Value& value() const noexcept { return value_; }
  [[nodiscard]] std::string_view schema() const noexcept { return schema_; }

  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] std::optional<Value> find(std::string_view key) const;
  [[nodiscard]] Value need(std::string_view key) const;
  // Elements of a list of tables; none if the key is missing.
  [[nodiscard]] std::vector<Value> tables(std::string_view key) const;
  // All keys that are there, in the order of their names.
  [[nodiscard]] std::vector<std::string> keys() const;
  // A component's parameter, which is not in the list of keys.
  [[nodiscard]] std::optional<Value> find_parameter(std::string_view key) const;

  // Throws for the first key that is neither listed for this table nor among `more`; `owner` describes those.
  void check_keys(const std::vector<std::string>& more = {}, std::string_view owner = {}) const;

 private:
  [[nodiscard]] std::string path_of(std::string_view key) const;

  Value value_;
  const toml::table* table_;
  std::string schema_;
};

}  // namespace springnet::scene
