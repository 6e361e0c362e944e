#include "check/texts.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <springnet/printable.hpp>

#include "text/units.hpp"

namespace springnet::check {
namespace {

// Empty, or the first name in a unit that is none of SI's without a prefix. What follows '^' is an exponent, and may be
// the name of a parameter.
std::string unknown_unit(std::string_view unit) {
  for (std::size_t k = 0; k < unit.size();) {
    if (std::isalpha(static_cast<unsigned char>(unit[k])) == 0) {
      ++k;
      continue;
    }
    std::size_t end = k;
    while (end < unit.size() && (std::isalnum(static_cast<unsigned char>(unit[end])) != 0 || unit[end] == '_')) ++end;
    const std::string_view word = unit.substr(k, end - k);
    const bool is_exponent = k > 0 && unit[k - 1] == '^';
    if (!is_exponent && find_unit(word) == nullptr) return std::string(word);
    k = end;
  }
  return {};
}

std::string remark(const springnet_parameter& p, const char* what) {
  const std::string name = fmt::format("{} '{}'", what, printable(p.name));
  const std::string_view summary = p.summary, unit = p.unit;
  if (summary.empty()) return name + " has no summary: say in one line what it is";
  if (summary.find('\n') != std::string_view::npos) return name + " has a summary of several lines: write one";
  if (const std::string word = unknown_unit(unit); !word.empty())
    return fmt::format(
        "{} has the unit '{}', and '{}' is no unit of the SI: quantities are in m, kg, s without prefixes", name,
        printable(p.unit), printable(word));
  const long open = std::count(unit.begin(), unit.end(), '('), closed = std::count(unit.begin(), unit.end(), ')');
  if (open != closed) return fmt::format("{} has the unit '{}': close the brackets", name, printable(p.unit));
  if (p.type == SPRINGNET_NUMBER && !(p.smallest < p.largest))
    return fmt::format("{} can only be {:g}: drop it", name, p.smallest);
  return {};
}

}  // namespace

Outcome check_texts(const Component& component) {
  const springnet_component& description = *component.description;
  // A formula is its own description.
  if (component.file.empty() && std::string_view(component.plugin->id) == "formula") return {};
  if (std::string_view(description.summary).empty())
    return {Result::warned, "it has no summary: say in one line what it is"};
  if (std::string_view(description.summary).find('\n') != std::string_view::npos)
    return {Result::warned, "it has a summary of several lines: write one"};
  // Of a file: those who use it want to know what they have.
  const springnet_plugin& plugin = *component.plugin;
  for (const auto& [name, text] :
       {std::pair("version", plugin.version), std::pair("author", plugin.author), std::pair("licence", plugin.licence)})
    if (!component.file.empty() && (text == nullptr || *text == '\0'))
      return {Result::warned, fmt::format("its plugin has no {}: fill it in", name)};
  for (std::uint32_t i = 0; i < description.parameter_count; ++i)
    if (const std::string text = remark(*description.parameters[i], "parameter"); !text.empty())
      return {Result::warned, text};
  const bool is_law =
      component.kind() == ComponentKind::spring_function || component.kind() == ComponentKind::viscosity_function;
  if (!is_law) return {};
  const springnet_law& law = component.law();
  for (std::uint32_t i = 0; i < law.state_count; ++i)
    if (const std::string text = remark(*law.states[i], "state"); !text.empty()) return {Result::warned, text};
  for (std::uint32_t i = 0; i < law.input_count; ++i)
    if (const std::string text = remark(*law.inputs[i], "input"); !text.empty()) return {Result::warned, text};
  for (std::uint32_t i = 0; i < law.table_count; ++i)
    if (const std::string word = unknown_unit(law.tables[i]->unit); !word.empty())
      return {Result::warned,
              fmt::format("table '{}' has the unit '{}', and '{}' is no unit of the SI", printable(law.tables[i]->name),
                          printable(law.tables[i]->unit), printable(word))};
  return {};
}

}  // namespace springnet::check
