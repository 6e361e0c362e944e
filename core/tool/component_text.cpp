#include "component_text.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <springnet/printable.hpp>

namespace springnet::tool {

bool is_law(const Component& component) {
  return component.kind() == ComponentKind::spring_function || component.kind() == ComponentKind::viscosity_function;
}

std::vector<const springnet_parameter*> inputs_of(const Component& component) {
  if (!is_law(component)) return {};
  return {component.law().inputs, component.law().inputs + component.law().input_count};
}

std::vector<const springnet_parameter*> states_of(const Component& component) {
  if (!is_law(component)) return {};
  return {component.law().states, component.law().states + component.law().state_count};
}

std::vector<const springnet_parameter*> parameters_of(const Component& component) {
  const springnet_component& description = *component.description;
  return {description.parameters, description.parameters + description.parameter_count};
}

std::span<const springnet_table* const> tables_of(const Component& component) {
  return springnet::tables_of(*component.description);
}

std::string shown(const char* text) {
  constexpr std::size_t max_length = 400;
  return printable(text, max_length);
}
std::string shown(const std::filesystem::path& path) { return printable_message(path.string()); }

std::string value_text(const springnet_parameter& parameter, double value) {
  switch (parameter.type) {
    case SPRINGNET_CHOICE:
      return fmt::format("\"{}\"", shown(parameter.choices[static_cast<std::size_t>(value)]));
    case SPRINGNET_BOOLEAN:
      return value != 0.0 ? "true" : "false";
    default:
      return fmt::format("{:g}", value);
  }
}

bool required(const springnet_parameter& parameter) { return (parameter.flags & SPRINGNET_REQUIRED) != 0; }

double sample_value(const springnet_parameter& parameter) {
  return required(parameter) ? std::clamp(parameter.scale, parameter.smallest, parameter.largest)
                             : parameter.default_value;
}

std::vector<std::vector<double>> sample_tables(const Component& component) {
  constexpr std::size_t fewest = 3;
  const std::span<const springnet_table* const> tables = tables_of(component);
  std::size_t count = fewest;
  for (const springnet_table* table : tables) count = std::max<std::size_t>(count, table->least);
  std::vector<std::vector<double>> result;
  for (const springnet_table* table : tables) {
    std::vector<double>& numbers = result.emplace_back();
    if ((table->flags & SPRINGNET_OPTIONAL) != 0) continue;
    const double from = std::clamp(-0.5, table->smallest, table->largest), to = std::min(from + 1.0, table->largest);
    for (std::size_t k = 0; k < count; ++k)
      numbers.push_back(from + (to - from) * static_cast<double>(k) / static_cast<double>(count - 1));
  }
  return result;
}

std::string name_in_scenes(const PluginHost& host, const Component& component) {
  const auto& all = host.components();
  const auto same = std::count_if(all.begin(), all.end(), [&component](const auto& other) {
    return other->kind() == component.kind() && other->id() == component.id();
  });
  const std::string id(component.id());
  return same < 2 ? id : id + '@' + shown(component.plugin->id);
}

std::string scene_line(const Component& component, const std::string& name, TablesAs tables) {
  std::string key, text;
  switch (component.kind()) {
    case ComponentKind::spring_function:
      key = "spring", text = "type";
      break;
    case ComponentKind::viscosity_function:
      key = "viscosity", text = "type";
      break;
    case ComponentKind::neuron:
      key = "neuron", text = "type";
      break;
    case ComponentKind::integrator:
      key = "integrator", text = "name";
      break;
  }
  text = fmt::format("{} = \"{}\"", text, name);
  if (component.kind() == ComponentKind::neuron) text += ", mass = 1";
  for (const springnet_parameter* parameter : parameters_of(component)) {
    text += fmt::format(", {} = {}", parameter->name, value_text(*parameter, sample_value(*parameter)));
  }
  const std::vector<std::vector<double>> numbers = sample_tables(component);
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const springnet_table& table = *tables_of(component)[k];
    if ((table.flags & SPRINGNET_OPTIONAL) != 0) continue;
    text += tables == TablesAs::file ? fmt::format(", {} = {{ file = \"{}.csv\" }}", table.name, component.id())
                                     : fmt::format(", {} = [{:g}]", table.name, fmt::join(numbers[k], ", "));
  }
  return fmt::format("{} = {{ {} }}", key, text);
}

}  // namespace springnet::tool
