#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

namespace springnet {
namespace {

std::span<const springnet_parameter* const> parameters_of(const springnet_component& component) {
  return {component.parameters, component.parameter_count};
}

// "1" stands for dimensionless.
std::string with_unit(double value, const springnet_parameter& parameter) {
  const std::string unit = printable(parameter.unit);
  return unit == "1" ? fmt::format("{}", value) : fmt::format("{} {}", value, unit);
}

std::string list_choices(const springnet_parameter& parameter) {
  std::string text;
  for (std::uint32_t i = 0; i < parameter.choice_count; ++i) {
    text += fmt::format("{}'{}'", i == 0 ? "" : ", ", printable(parameter.choices[i]));
  }
  return text;
}

std::string list_parameters(const springnet_component& component) {
  if (component.parameter_count == 0) return "it has no parameters";
  std::string text = "it has ";
  for (const springnet_parameter* parameter : parameters_of(component)) {
    if (text.back() != ' ') text += ", ";
    text += parameter->name;
    if (std::string_view(parameter->unit) != "1") text += fmt::format(" ({})", printable(parameter->unit));
  }
  return text;
}

}  // namespace

std::ptrdiff_t parameter_index(const springnet_component& component, std::string_view name) noexcept {
  for (std::uint32_t i = 0; i < component.parameter_count; ++i) {
    if (name == component.parameters[i]->name) return i;
  }
  return -1;
}

std::ptrdiff_t choice_index(const springnet_parameter& parameter, std::string_view choice) noexcept {
  for (std::uint32_t i = 0; i < parameter.choice_count; ++i) {
    if (choice == parameter.choices[i]) return i;
  }
  return -1;
}

std::string check_value(const springnet_parameter& parameter, double value) {
  if (!std::isfinite(value)) return fmt::format("must be a finite number, is {}", value);
  const bool whole = value == std::trunc(value);
  switch (parameter.type) {
    case SPRINGNET_CHOICE:
      if (!whole || value < 0 || value >= static_cast<double>(parameter.choice_count)) {
        return fmt::format("must be one of {} (0 to {}), is {}", list_choices(parameter), parameter.choice_count - 1,
                           value);
      }
      return {};
    case SPRINGNET_BOOLEAN:
      return value == 0 || value == 1 ? "" : fmt::format("must be true or false (1 or 0), is {}", value);
    case SPRINGNET_INTEGER:
      if (!whole) return fmt::format("must be a whole number, is {}", value);
      break;
    default:
      break;
  }
  const bool excludes_smallest = (parameter.flags & SPRINGNET_EXCLUDES_SMALLEST) != 0;
  if (excludes_smallest && value <= parameter.smallest) {
    return fmt::format("must be above {}, is {}", with_unit(parameter.smallest, parameter), value);
  }
  if (value < parameter.smallest) {
    return fmt::format("must be at least {}, is {}", with_unit(parameter.smallest, parameter), value);
  }
  if (value > parameter.largest) {
    return fmt::format("must be at most {}, is {}", with_unit(parameter.largest, parameter), value);
  }
  return {};
}

std::vector<double> complete_parameters(const springnet_component& component, const ParameterValues& given,
                                        std::string_view where) {
  const std::string what = fmt::format("{} '{}'", name_of(static_cast<ComponentKind>(component.kind)), component.id);
  std::vector<std::optional<double>> values(component.parameter_count);
  for (const auto& [name, value] : given) {
    const std::ptrdiff_t index = parameter_index(component, name);
    if (index < 0) {
      std::vector<std::string> known;
      for (const springnet_parameter* parameter : parameters_of(component)) known.emplace_back(parameter->name);
      const std::string nearest = suggestion(name, known);
      throw Error(ErrorKind::input, fmt::format("{}: {} has no parameter '{}'; {}{}", where, what, printable(name),
                                                nearest.empty() ? "" : nearest + " ", list_parameters(component)));
    }
    const std::string wrong = check_value(*component.parameters[index], value);
    if (!wrong.empty()) {
      throw Error(ErrorKind::input, fmt::format("{}: parameter '{}' of {} {}", where, name, what, wrong));
    }
    values[static_cast<std::size_t>(index)] = value;
  }
  std::vector<double> complete;
  complete.reserve(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const springnet_parameter& parameter = *component.parameters[i];
    if (!values[i] && (parameter.flags & SPRINGNET_REQUIRED) != 0) {
      throw Error(ErrorKind::input, fmt::format("{}: {} needs a value for '{}' ({}: {})", where, what, parameter.name,
                                                printable(parameter.unit), printable(parameter.summary, 200)));
    }
    complete.push_back(values[i].value_or(parameter.default_value));
  }
  return complete;
}

}  // namespace springnet
