#include "scene/document.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "scene/depth.hpp"
#include "scene/file_text.hpp"
#include "text/grouped.hpp"

namespace springnet {
namespace scene {
namespace {

const std::string too_deep = fmt::format(
    "this nests deeper than {} levels of tables, lists and parts of a key; a scene needs six; use fewer levels",
    deepest_level);
const std::string too_large =
    fmt::format("a scene has at most {} bytes; put nodes and springs into a mesh file", grouped(largest_scene));

// A message of the TOML library, shortened: it quotes keys in full.
std::string described(const toml::parse_error& error) {
  constexpr std::size_t longest = 300;
  return printable(error.description(), longest);
}

std::vector<std::string> split(std::string_view path) {
  std::vector<std::string> steps(1);
  for (const char c : path) {
    if (c == '.') {
      steps.emplace_back();
    } else {
      steps.back() += c;
    }
  }
  return steps;
}

// Applies an override to a document. Its name replaces the file in later messages about its value.
class Override {
 public:
  explicit Override(const SceneOverride& given)
      : name_(fmt::format("--set {}={}", printable(given.key), printable(given.value))) {
    if (given.key.size() > largest_scene || given.value.size() > largest_scene) fail(too_large);
    if (find_too_deep(given.key)) fail(too_deep);
    steps_ = split(given.key);
    if (std::find(steps_.begin(), steps_.end(), "") != steps_.end()) {
      fail("the key has an empty part; write it as body.0.mesh.spacing");
    }
    value_ = parse(given.value);
  }

  void apply(toml::table& root) {
    toml::node* place = &root;
    for (std::size_t i = 0; i + 1 < steps_.size(); ++i) place = &child(*place, i);
    value_.get("value")->visit([&](auto&& value) {
      if (toml::array* list = place->as_array()) {
        const std::size_t index = element(*list, steps_.size() - 1);
        list->replace(list->begin() + static_cast<std::ptrdiff_t>(index), std::move(value));
      } else {
        toml::table& parent = table(*place, steps_.size() - 1);
        // A parameter of a formula with its bounds keeps them.
        toml::table* const described = parent.get_as<toml::table>(steps_.back());
        if (!value.is_table() && described != nullptr && described->contains("value"))
          described->insert_or_assign("value", std::move(value));
        else
          parent.insert_or_assign(steps_.back(), std::move(value));
      }
    });
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorKind::input, fmt::format("{}: {}", name_, what));
  }

  [[nodiscard]] toml::table parse(std::string_view text) const {
    if (find_too_deep(text)) fail(too_deep);
    const std::string document = fmt::format("value = {}\n", text);
    try {
      toml::table table = toml::parse(std::string_view(document), std::string_view(name_));
      if (table.size() == 1) return table;
    } catch (const toml::parse_error& error) {
      // Without its column, which would refer to text that the user did not write.
      fail(fmt::format("the value is not TOML ({}); write a number, true, [1, 2], or a text in quotes as \"abc\"",
                       described(error)));
    }
    fail("this sets more than one key; set one at a time");
  }

  // The first `count` steps of the path.
  [[nodiscard]] std::string path(std::size_t count) const {
    std::string text;
    for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : ".") + steps_[i];
    return text;
  }

  [[nodiscard]] toml::table& table(toml::node& place, std::size_t step) const {
    if (toml::table* table = place.as_table()) return *table;
    fail(fmt::format("'{}' is not a table, so it has no '{}'; set '{}' as a whole", printable(path(step)),
                     printable(steps_[step]), printable(path(step))));
  }

  [[nodiscard]] std::size_t element(const toml::array& list, std::size_t step) const {
    const std::string& text = steps_[step];
    std::size_t index = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), index);
    if (failed == std::errc() && end == text.data() + text.size() && index < list.size()) return index;
    if (list.empty()) fail(fmt::format("'{}' is an empty list; set it as a whole", printable(path(step))));
    fail(fmt::format("'{}' is a list of {}; write a number from 0 to {} in place of '{}'", printable(path(step)),
                     list.size(), list.size() - 1, printable(text)));
  }

  // The node one step further; creates a missing one in a table.
  [[nodiscard]] toml::node& child(toml::node& place, std::size_t step) const {
    if (toml::array* list = place.as_array()) return *list->get(element(*list, step));
    toml::table& parent = table(place, step);
    if (!parent.contains(steps_[step])) {
      parent.insert_or_assign(steps_[step], std::move(*parse("{}").get_as<toml::table>("value")));
    }
    return *parent.get(steps_[step]);
  }

  std::vector<std::string> steps_;
  std::string name_;
  toml::table value_;
};

}  // namespace

toml::table parse_document(std::string_view text, std::string_view name, const std::vector<SceneOverride>& overrides) {
  if (text.size() > largest_scene) throw Error(ErrorKind::input, fmt::format("{}: {}", name, too_large));
  if (const std::optional<TextPlace> place = find_too_deep(text)) {
    throw Error(ErrorKind::input, fmt::format("{}:{}:{}: {}", name, place->line, place->column, too_deep));
  }
  toml::table root;
  try {
    root = toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    throw Error(ErrorKind::input, fmt::format("{}:{}:{}: this is not TOML: {}", name, error.source().begin.line,
                                              error.source().begin.column, described(error)));
  }
  for (const SceneOverride& given : overrides) Override(given).apply(root);
  return root;
}

toml::value<double> number_at(double number, std::string_view place) {
  // toml++ gives a node its place when it parses one, and in no other way.
  toml::table document = toml::parse(std::string_view("value = 0.0"), place);
  toml::value<double>& value = *document.get_as<double>("value");
  value = number;
  return std::move(value);
}

}  // namespace scene

SceneOverride parse_override(std::string_view text) {
  const auto trim = [](std::string_view part) {
    const std::size_t first = part.find_first_not_of(" \t");
    if (first == std::string_view::npos) return std::string();
    return std::string(part.substr(first, part.find_last_not_of(" \t") - first + 1));
  };
  const std::size_t equals = text.find('=');
  SceneOverride result;
  if (equals != std::string_view::npos) result = {trim(text.substr(0, equals)), trim(text.substr(equals + 1))};
  if (result.key.empty() || result.value.empty()) {
    throw Error(ErrorKind::input,
                fmt::format("'{}' sets nothing; write key=value, as in simulation.time_step=0.01", printable(text)));
  }
  return result;
}

}  // namespace springnet
