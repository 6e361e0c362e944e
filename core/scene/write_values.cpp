#include "scene/write_values.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "plugin_host/law_use.hpp"
#include "scene/toml_text.hpp"
#include "scene/value_tables.hpp"

namespace springnet::scene {
namespace {

// So many stand in the scene itself, where a reader sees them.
constexpr std::size_t few_materials = 8;

bool is_number(const Component& component, const std::string& name) {
  for (std::uint32_t i = 0; i < component.description->parameter_count; ++i) {
    const springnet_parameter& each = *component.description->parameters[i];
    if (name == each.name) return each.type != SPRINGNET_BOOLEAN && each.type != SPRINGNET_CHOICE;
  }
  return false;
}

// An order in which materials that differ in numbers alone are the same.
class ByLaws {
 public:
  ByLaws(const std::vector<Material>& materials, const PluginHost& plugins)
      : materials_(materials), plugins_(plugins) {}

  bool operator()(MaterialIndex a, MaterialIndex b) const {
    const int springs = compare(materials_[a].spring, materials_[b].spring, ComponentKind::spring_function);
    return springs < 0 || (springs == 0 && compare(materials_[a].viscosity, materials_[b].viscosity,
                                                   ComponentKind::viscosity_function) < 0);
  }

 private:
  template <class Item>
  static int compare(const Item& a, const Item& b) {
    return std::less<Item>()(a, b) ? -1 : std::less<Item>()(b, a) ? 1 : 0;
  }

  int compare(const std::optional<LawUse>& a, const std::optional<LawUse>& b, ComponentKind kind) const {
    if (!a || !b) return compare(a.has_value(), b.has_value());
    int result = compare(a->id, b->id);
    if (result == 0) result = compare(a->component.get(), b->component.get());
    if (result == 0) result = compare(a->parameters.size(), b->parameters.size());
    if (result != 0) return result;
    const std::shared_ptr<const Component> component = component_of(*a, kind, plugins_);
    for (auto own = a->parameters.begin(), other = b->parameters.begin(); own != a->parameters.end(); ++own, ++other) {
      result = compare(own->first, other->first);
      if (result == 0 && !is_number(*component, own->first)) result = compare(own->second, other->second);
      if (result != 0) return result;
    }
    return compare(a->tables, b->tables);
  }

  const std::vector<Material>& materials_;
  const PluginHost& plugins_;
};

double value_of(const Material& material, const std::pair<bool, std::string>& column) {
  return (column.first ? material.viscosity : material.spring)->parameters.find(column.second)->second;
}

}  // namespace

ValueFiles::ValueFiles(const Network& network) : network_(network), groups_(network.materials().size()) {
  std::iota(groups_.begin(), groups_.end(), MaterialIndex{0});
}

ValueFiles::ValueFiles(const Network& network, const PluginHost& plugins, std::string stem) : ValueFiles(network) {
  stem_ = std::move(stem);
  const std::size_t count = network.materials().size();
  std::map<MaterialIndex, std::size_t, ByLaws> sizes(ByLaws(network.materials(), plugins));  // of each group
  for (MaterialIndex k = 0; k < count; ++k) {
    const auto group = sizes.try_emplace(k, 0).first;
    groups_[k] = group->first;
    ++group->second;
  }
  for (MaterialIndex k = 0; k < count; ++k)
    if (sizes.find(groups_[k])->second <= few_materials) groups_[k] = k;
}

std::string ValueFiles::add(const std::string& noun, const std::vector<Row>& rows) {
  std::set<std::pair<bool, std::string>> columns;  // of the viscosity function?, name
  for (const Row& row : rows) {
    const Material &written = network_.materials()[row.written], &own = network_.materials()[row.own];
    for (const bool is_viscosity : {false, true}) {
      const std::optional<LawUse>& use = is_viscosity ? own.viscosity : own.spring;
      if (!use) continue;
      for (const auto& [name, value] : use->parameters)
        if (value != value_of(written, {is_viscosity, name})) columns.insert({is_viscosity, name});
    }
  }
  std::string text = noun;
  for (const auto& [is_viscosity, name] : columns)
    text += fmt::format(",{}{}", is_viscosity ? viscosity_function_prefix : spring_function_prefix, name);
  text += '\n';
  for (const Row& row : rows) {
    text += std::to_string(row.number);
    for (const auto& column : columns) text += ',' + toml_text::number(value_of(network_.materials()[row.own], column));
    text += '\n';
  }
  const auto is_of_noun = [&](const SceneTable& each) { return each.name.starts_with(stem_ + "_" + noun); };
  const auto before = std::count_if(files_.begin(), files_.end(), is_of_noun);
  std::string name =
      before == 0 ? fmt::format("{}_{}s.csv", stem_, noun) : fmt::format("{}_{}s_{}.csv", stem_, noun, before + 1);
  files_.push_back({name, std::move(text)});
  return name;
}

}  // namespace springnet::scene
