#include "output/view/units.hpp"

#include <string_view>

#include <fmt/format.h>

namespace springnet::view {

std::string LawTexts::unit_of(ComponentKind kind, const std::string& law, const std::string& parameter) {
  if (!plugins_) plugins_ = PluginHost::with_default_search();
  const auto component = plugins_->find(kind, law);
  if (!component) return "";
  const std::ptrdiff_t index = parameter_index(*component->description, parameter);
  if (index < 0) return "";
  const std::string_view unit = component->description->parameters[index]->unit;
  return unit == "1" ? "" : fmt::format(" {}", unit);
}

std::string LawTexts::of(ComponentKind kind, const LawUse& use) {
  std::string text = use.id;
  const char* separator = " (";
  for (const auto& [name, value] : use.parameters) {
    text += fmt::format("{}{} {:g}{}", separator, name, value, unit_of(kind, use.id, name));
    separator = ", ";
  }
  return use.parameters.empty() ? text : text + ")";
}

std::string LawTexts::of(const Material& material) {
  std::string text;
  if (material.spring) text = "spring " + of(ComponentKind::spring_function, *material.spring);
  if (material.viscosity) {
    text += text.empty() ? "viscosity " : ", viscosity ";
    text += of(ComponentKind::viscosity_function, *material.viscosity);
  }
  return text;
}

}  // namespace springnet::view
