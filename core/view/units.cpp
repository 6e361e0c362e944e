#include "view/units.hpp"

#include <string_view>

#include <fmt/format.h>

#include "text/counted.hpp"

namespace springnet::view {

namespace {

std::string unit_of(const PluginHost* plugins, ComponentKind kind, const std::string& law,
                    const std::string& parameter) {
  if (plugins == nullptr) return "";
  const auto component = plugins->find(kind, law);
  if (!component) return "";
  const std::ptrdiff_t index = parameter_index(*component->description, parameter);
  if (index < 0) return "";
  const std::string_view unit = component->description->parameters[index]->unit;
  return unit == "1" ? "" : fmt::format(" {}", unit);
}

}  // namespace

std::string text_of(const PluginHost* plugins, ComponentKind kind, const LawUse& use) {
  std::string text = use.id;
  const char* separator = " (";
  for (const auto& [name, value] : use.parameters) {
    text += fmt::format("{}{} {:g}{}", separator, name, value, unit_of(plugins, kind, use.id, name));
    separator = ", ";
  }
  for (const auto& [name, values] : use.tables) {
    text += fmt::format("{}{} {}", separator, name, counted(values.size(), "value"));
    separator = ", ";
  }
  return use.parameters.empty() && use.tables.empty() ? text : text + ")";
}

std::string text_of(const PluginHost* plugins, const Material& material) {
  std::string text;
  if (material.spring) text = "spring " + text_of(plugins, ComponentKind::spring_function, *material.spring);
  if (material.viscosity) {
    text += text.empty() ? "viscosity " : ", viscosity ";
    text += text_of(plugins, ComponentKind::viscosity_function, *material.viscosity);
  }
  return text;
}

}  // namespace springnet::view
