#include "scene/component.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "layers/law_fit.hpp"
#include "layers/prepared.hpp"
#include "plugin_host/law_use.hpp"
#include "scene/law_tables.hpp"

namespace springnet::scene {
namespace {

std::shared_ptr<const Component> find_component(const Value& name, ComponentKind kind, const PluginHost& plugins) {
  try {
    return plugins.require(kind, name.text());
  } catch (const Error& error) {
    // An unknown name in a scene is an input error: it is corrected in the scene.
    if (error.kind() == ErrorKind::plugin) name.fail(error.what());
    throw;
  }
}

double read_parameter(const Value& value, const springnet_parameter& parameter) {
  switch (parameter.type) {
    case SPRINGNET_BOOLEAN:
      return value.boolean() ? 1.0 : 0.0;
    case SPRINGNET_CHOICE:
      return static_cast<double>(value.choice({parameter.choices, parameter.choices + parameter.choice_count}));
    case SPRINGNET_INTEGER:
      return static_cast<double>(value.integer());
    default:
      return value.number();
  }
}

std::vector<std::string> parameters_of(const springnet_component& description) {
  std::vector<std::string> names;
  for (std::uint32_t i = 0; i < description.parameter_count; ++i) names.emplace_back(description.parameters[i]->name);
  return names;
}

// A use with the supplied parameters, which the component must have.
LawUse begin_use(const Value& name, const Component& component, ComponentKind kind, const ParameterValues& supplied) {
  const std::vector<std::string> names = parameters_of(*component.description);
  for (const auto& [parameter, value] : supplied) {
    if (std::find(names.begin(), names.end(), parameter) != names.end()) continue;
    name.fail(fmt::format("{} '{}' has no parameter '{}', which is set here; choose one that has it", name_of(kind),
                          component.id(), parameter));
  }
  return {name.text(), supplied, {}};  // with its plugin's id, if that is given
}

bool needs_preparation(const Component& component) {
  const ComponentKind kind = component.kind();
  const bool is_law = kind == ComponentKind::spring_function || kind == ComponentKind::viscosity_function;
  return is_law && component.law().prepare != nullptr;
}

// What is missing, and what the law itself refuses, is told at this place.
void check_at(const LawUse& use, const std::shared_ptr<const Component>& component, const Value& place) {
  const springnet_component& description = *component->description;
  const std::vector<double> parameters = complete_parameters(description, use.parameters, place.where());
  const std::vector<std::span<const double>> tables = complete_tables(description, use.tables, place.where());
  if (needs_preparation(*component))
    place.at_this_place([&] { return layers::Prepared(component, parameters, tables); });
}

}  // namespace

void check_use(const LawUse& use, const std::shared_ptr<const Component>& component) {
  if (!needs_preparation(*component)) return;
  const springnet_component& description = *component->description;
  static_cast<void>(layers::Prepared(component, complete_parameters(description, use.parameters, component->id()),
                                     complete_tables(description, use.tables, component->id())));
}

LawUse read_component(const Table& table, std::string_view name_key, ComponentKind kind, const PluginHost& plugins,
                      const Files& files, const ParameterValues& supplied) {
  const Value name = table.need(name_key);
  const std::shared_ptr<const Component> component = find_component(name, kind, plugins);
  const springnet_component& description = *component->description;
  LawUse use = begin_use(name, *component, kind, supplied);

  std::vector<std::string> names = parameters_of(description);
  for (const springnet_table* declared : tables_of(description)) names.emplace_back(declared->name);
  table.check_keys(names, fmt::format("{} '{}'", name_of(kind), use.id));

  for (std::uint32_t i = 0; i < description.parameter_count; ++i) {
    const springnet_parameter& parameter = *description.parameters[i];
    const std::optional<Value> given = table.find_parameter(parameter.name);
    if (!given) continue;
    if (supplied.contains(parameter.name)) given->fail("is set by the material here; remove it");
    const double value = read_parameter(*given, parameter);
    if (const std::string wrong = check_value(parameter, value); !wrong.empty()) given->fail(wrong);
    use.parameters.emplace(parameter.name, value);
  }
  use.tables = read_law_tables(table, description, files);
  check_at(use, component, table.value());
  return use;
}

ParameterValues read_values(const Table& table, Named what,
                            const std::vector<std::shared_ptr<const Component>>& components) {
  ParameterValues values;
  std::vector<std::string> names, owners;
  for (const std::shared_ptr<const Component>& component : components) {
    const springnet_component& description = *component->description;
    const bool inputs = what == Named::inputs;
    const std::uint32_t count = inputs ? component->law().input_count : description.parameter_count;
    owners.push_back(fmt::format("'{}'", component->id()));
    for (std::uint32_t i = 0; i < count; ++i) {
      const springnet_parameter& declared = inputs ? *component->law().inputs[i] : *description.parameters[i];
      names.emplace_back(declared.name);
      const std::optional<Value> given = table.find_parameter(declared.name);
      if (!given) continue;
      const double value = read_parameter(*given, declared);
      if (const std::string wrong = check_value(declared, value); !wrong.empty())
        given->fail(fmt::format("{} ('{}')", wrong, component->id()));
      values[declared.name] = value;
    }
  }
  table.check_keys(names, owners.empty() ? std::string("what is selected, which has none of these,")
                                         : fmt::format("what is selected ({})", fmt::join(owners, ", ")));
  return values;
}

LawUse read_component_name(const Value& name, ComponentKind kind, const PluginHost& plugins,
                           const ParameterValues& supplied) {
  const std::shared_ptr<const Component> component = find_component(name, kind, plugins);
  LawUse use = begin_use(name, *component, kind, supplied);
  check_at(use, component, name);
  return use;
}

LawUse read_law(const Value& law, std::string_view schema, ComponentKind kind, const PluginHost& plugins,
                const Files& files, std::optional<Invariant> elements, const std::vector<MaterialParameter>& given) {
  const Table table = law.open_table(schema);
  const bool is_formula = is_formula_of(table);
  LawUse use = is_formula ? read_formula(table, kind, files, elements, given)
                          : read_component(table, "type", kind, plugins, files);
  if (!elements) {
    const std::string wrong = layers::misfit(*component_of(use, kind, plugins));
    if (!wrong.empty()) (is_formula ? table.value() : table.need("type")).fail(fmt::format("'{}' {}", use.id, wrong));
  }
  return use;
}

Material read_material(const Table& table, const PluginHost& plugins, const Files& files,
                       std::optional<Invariant> elements) {
  const auto read = [&](std::string_view key, ComponentKind kind) -> std::optional<LawUse> {
    const std::optional<Value> value = table.find(key);
    if (!value) return std::nullopt;
    return read_law(*value, fmt::format("{}.{}", table.schema(), key), kind, plugins, files, elements);
  };
  return {read("spring", ComponentKind::spring_function), read("viscosity", ComponentKind::viscosity_function)};
}

ElementCheck::ElementCheck(const Material& material, const PluginHost& plugins) {
  if (material.spring) laws_.push_back(component_of(*material.spring, ComponentKind::spring_function, plugins));
  if (material.viscosity)
    laws_.push_back(component_of(*material.viscosity, ComponentKind::viscosity_function, plugins));
}

void ElementCheck::operator()(const Value& place, const Network& network, ElementIndex element) const {
  const Element& own = network.elements()[element];
  for (const std::shared_ptr<const Component>& law : laws_) {
    const std::string wrong = layers::misfit(*law, own);
    if (!wrong.empty())
      place.fail(fmt::format("element {} ({}): {} '{}' {}", element, name_of(own.invariant), name_of(law->kind()),
                             law->id(), wrong));
  }
}

bool ElementCheck::reads_direction() const {
  return std::any_of(laws_.begin(), laws_.end(), [](const auto& law) { return law->law().reads_direction != 0; });
}

}  // namespace springnet::scene
