#include "scene/value_tables.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <springnet/printable.hpp>

#include "plugin_host/law_use.hpp"
#include "scene/component.hpp"
#include "scene/select.hpp"

namespace springnet::scene {
namespace {

// What the rows are of.
struct Owners {
  std::string noun;     // "spring", also the column with its number
  std::string where;    // "the network"
  std::string at_rest;  // the column of its value at rest
  std::size_t count;
  std::function<MaterialIndex(std::size_t)> material;
  std::function<void(std::size_t, MaterialIndex)> set_material;
  std::function<void(std::size_t, double)> set_at_rest;
};

struct Law {
  const char* prefix;
  ComponentKind kind;
  std::optional<LawUse> Material::*use;
};
constexpr Law laws[] = {{spring_function_prefix, ComponentKind::spring_function, &Material::spring},
                        {viscosity_function_prefix, ComponentKind::viscosity_function, &Material::viscosity}};

bool is_number(const springnet_parameter& parameter) {
  return parameter.type != SPRINGNET_BOOLEAN && parameter.type != SPRINGNET_CHOICE;
}

const springnet_parameter* find_parameter(const Component& component, std::string_view name) {
  for (std::uint32_t i = 0; i < component.description->parameter_count; ++i)
    if (const springnet_parameter& each = *component.description->parameters[i]; name == each.name && is_number(each))
      return &each;
  return nullptr;
}

// The columns that some of the owners have, each once.
std::vector<std::string> columns_of(const Owners& owners, const PluginHost& plugins, const Network& network) {
  std::vector<std::string> names{owners.at_rest};
  std::vector<bool> is_seen(network.materials().size(), false);
  for (std::size_t k = 0; k < owners.count; ++k) {
    const MaterialIndex index = owners.material(k);
    if (is_seen[index]) continue;
    is_seen[index] = true;
    for (const Law& law : laws) {
      const std::optional<LawUse>& use = network.materials()[index].*law.use;
      if (!use) continue;
      const std::shared_ptr<const Component> component = component_of(*use, law.kind, plugins);
      for (std::uint32_t i = 0; i < component->description->parameter_count; ++i) {
        const springnet_parameter& parameter = *component->description->parameters[i];
        const std::string name = std::string(law.prefix) + parameter.name;
        if (is_number(parameter) && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      }
    }
  }
  return names;
}

class ValueReader {
 public:
  ValueReader(const Value& file, const PluginHost& plugins, Network& network, const Owners& owners)
      : file_(file), plugins_(plugins), network_(network), owners_(owners) {}

  void read(const Files& files) {
    const std::vector<std::string> known = columns_of(owners_, plugins_, network_);
    const CsvTable& table = files.csv_table(file_);
    names_ = {owners_.noun};
    for (const std::string& each : known)
      if (table.has(each)) names_.push_back(each);
    if (const std::size_t other = table.first_other_than(names_))
      file_.fail(
          fmt::format("column {} of '{}' is not named '{}', nor as a value of these {}s: {}; correct its "
                      "name, or remove it",
                      other, printable(file_.text()), owners_.noun, owners_.noun, list_of(known)));
    if (names_.size() == 1)
      file_.fail(fmt::format("'{}' has no values; add a column with one of these names: {}", printable(file_.text()),
                             list_of(known)));
    rows_ = files.csv_columns(file_, names_);
    if (rows_.lines.empty())
      file_.fail(fmt::format("'{}' has no rows; give one for each {}", printable(file_.text()), owners_.noun));
    std::vector<bool> is_set(owners_.count, false);
    for (std::size_t row = 0; row < rows_.lines.size(); ++row) {
      const std::size_t number = number_of(row);
      if (is_set[number]) fail(row, fmt::format("{} {} has a row already; remove one", owners_.noun, number));
      is_set[number] = true;
      set(row, number);
    }
  }

 private:
  [[noreturn]] void fail(std::size_t row, const std::string& what) const {
    file_.fail(fmt::format("{}: {}", rows_.place(row), what));
  }

  std::size_t number_of(std::size_t row) const {
    const double number = rows_.values[0][row];
    if (number != std::floor(number))
      fail(row, fmt::format("the number of a {} must be whole, is {}", owners_.noun, number));
    if (!(number >= 0.0 && number < static_cast<double>(owners_.count)))
      fail(row, fmt::format("there is no {} {} in {}, which has {}, numbered from 0", owners_.noun, number,
                            owners_.where, owners_.count));
    return static_cast<std::size_t>(number);
  }

  void set(std::size_t row, std::size_t number) {
    std::vector<double> key;
    for (std::size_t column = 1; column < names_.size(); ++column) {
      const double value = rows_.values[column][row];
      if (names_[column] != owners_.at_rest)
        key.push_back(value);
      else
        at_row(row, [&] { owners_.set_at_rest(number, value); });
    }
    if (key.empty()) return;
    const MaterialIndex old = owners_.material(number);
    const auto [found, is_new] = made_.try_emplace({old, std::move(key)}, old);
    if (is_new) found->second = network_.add_material(with_values(row, number, network_.materials()[old]));
    owners_.set_material(number, found->second);
  }

  // By value: the list of materials grows.
  Material with_values(std::size_t row, std::size_t number, Material material) const {
    for (const Law& law : laws) {
      std::optional<LawUse>& use = material.*law.use;
      bool has_changed = false;
      for (std::size_t column = 1; column < names_.size(); ++column) {
        if (!names_[column].starts_with(law.prefix)) continue;
        const std::string parameter = names_[column].substr(std::string_view(law.prefix).size());
        const auto component = use ? component_of(*use, law.kind, plugins_) : nullptr;
        const springnet_parameter* declared = component ? find_parameter(*component, parameter) : nullptr;
        if (declared == nullptr)
          fail(row, fmt::format("{} {} has no {} with '{}'; put {}s with other laws into a file of their own",
                                owners_.noun, number, name_of(law.kind), parameter, owners_.noun));
        const double value = rows_.values[column][row];
        if (const std::string wrong = check_value(*declared, value); !wrong.empty())
          fail(row, fmt::format("column '{}' {}", names_[column], wrong));
        use->parameters[parameter] = value;
        has_changed = true;
      }
      if (has_changed) at_row(row, [&] { check_use(*use, component_of(*use, law.kind, plugins_)); });
    }
    return material;
  }

  template <class Change>
  void at_row(std::size_t row, const Change& change) const {
    try {
      change();
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::input) fail(row, error.what());
      throw;
    }
  }

  const Value& file_;
  const PluginHost& plugins_;
  Network& network_;
  const Owners& owners_;
  std::vector<std::string> names_;
  CsvColumns rows_;
  std::map<std::pair<MaterialIndex, std::vector<double>>, MaterialIndex> made_;
};

}  // namespace

void read_spring_values(const Value& file, const PluginHost& plugins, const Files& files, Network& network) {
  const Owners springs{
      spring_column,
      "the network",
      rest_length_column,
      network.springs().size(),
      [&](std::size_t k) { return network.springs()[k].material; },
      [&](std::size_t k, MaterialIndex own) { network.set_spring_material(static_cast<SpringIndex>(k), own); },
      [&](std::size_t k, double length) { network.set_rest_length(static_cast<SpringIndex>(k), length); }};
  ValueReader(file, plugins, network, springs).read(files);
}

ElementValues read_element_values(const Value& file, const PluginHost& plugins, const Files& files, std::size_t count,
                                  MaterialIndex material, Network& network) {
  ElementValues result{std::vector<MaterialIndex>(count, material), std::vector<std::optional<double>>(count)};
  const Owners elements{element_column,
                        "this table",
                        reference_column,
                        count,
                        [&](std::size_t k) { return result.materials[k]; },
                        [&](std::size_t k, MaterialIndex own) { result.materials[k] = own; },
                        [&](std::size_t k, double value) { result.references[k] = value; }};
  ValueReader(file, plugins, network, elements).read(files);
  return result;
}

}  // namespace springnet::scene
