#include <algorithm>
#include <cstring>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/host_laws.hpp>

#include "plugin_host/check_plugin.hpp"
#include "plugin_host/host_plugin.hpp"

namespace springnet {
namespace {

springnet_plugin plugin_of(const springnet_component* const* list, const char* id, const char* version) {
  return {SPRINGNET_MAGIC,
          sizeof(springnet_plugin),
          SPRINGNET_ABI_MAJOR,
          SPRINGNET_ABI_MINOR,
          0,
          1,
          0,
          id,
          version,
          "",
          "",
          list};
}

// The fields that both sides know.
template <class Struct>
Struct common_part(const Struct& given) {
  Struct result{};
  const std::size_t size = std::min<std::size_t>(given.struct_size, sizeof result);
  std::memcpy(&result, &given, size);
  result.struct_size = static_cast<std::uint32_t>(size);
  return result;
}

}  // namespace

// Copies of all that a description points to, except functions and contexts.
struct HostComponent::Copy {
  std::shared_ptr<const void> owner;  // of the contexts
  std::deque<std::string> texts;      // addresses stay
  std::deque<springnet_parameter> parameters;
  std::deque<springnet_table> tables;
  std::deque<std::vector<const char*>> choices;
  std::deque<std::vector<const springnet_parameter*>> parameter_lists;
  std::vector<const springnet_table*> table_list;
  std::deque<springnet_invariant> invariants;
  std::vector<const springnet_invariant*> invariant_list;
  springnet_law law;
  springnet_neuron_model neuron;
  springnet_integrator integrator;
  springnet_component component;

  Copy(const springnet_component& given, std::shared_ptr<const void> keeps) : owner(std::move(keeps)) {
    component = common_part(given);
    for (const char** each : {&component.id, &component.summary, &component.reference}) *each = text(*each);
    component.parameters = list_of(given.parameters, given.parameter_count);
    switch (component.kind) {
      case SPRINGNET_NEURON:
        neuron = common_part(*static_cast<const springnet_neuron_model*>(given.implementation));
        component.implementation = &neuron;
        return;
      case SPRINGNET_INTEGRATOR:
        integrator = common_part(*static_cast<const springnet_integrator*>(given.implementation));
        component.implementation = &integrator;
        return;
      default:
        copy_law(*static_cast<const springnet_law*>(given.implementation));
    }
  }
  Copy(const Copy&) = delete;
  Copy& operator=(const Copy&) = delete;

 private:
  void copy_law(const springnet_law& given) {
    law = common_part(given);
    law.states = list_of(given.states, given.state_count);
    law.inputs = list_of(given.inputs, given.input_count);
    for (std::uint32_t i = 0; i < given.table_count; ++i) {
      springnet_table& table = tables.emplace_back(common_part(*given.tables[i]));
      for (const char** each : {&table.name, &table.unit, &table.summary}) *each = text(*each);
      table_list.push_back(&table);
    }
    law.tables = table_list.data();
    for (std::uint32_t i = 0; i < law.invariant_count; ++i)
      invariant_list.push_back(&invariants.emplace_back(common_part(*given.invariants[i])));
    law.invariants = invariant_list.data();
    component.implementation = &law;
  }
  const char* text(const char* given) { return texts.emplace_back(given).c_str(); }
  const springnet_parameter* const* list_of(const springnet_parameter* const* given, std::uint32_t count) {
    auto& list = parameter_lists.emplace_back();
    for (std::uint32_t i = 0; i < count; ++i) {
      springnet_parameter& parameter = parameters.emplace_back(common_part(*given[i]));
      for (const char** each : {&parameter.name, &parameter.unit, &parameter.summary}) *each = text(*each);
      auto& names = choices.emplace_back();
      if (parameter.type != SPRINGNET_CHOICE) parameter.choice_count = 0;
      for (std::uint32_t k = 0; k < parameter.choice_count; ++k) names.push_back(text(parameter.choices[k]));
      parameter.choices = names.empty() ? nullptr : names.data();
      list.push_back(&parameter);
    }
    return list.data();
  }
};

HostComponent::HostComponent(const springnet_component& description, std::shared_ptr<const void> owner) {
  const springnet_component* const list[] = {&description};
  const PluginCheck check = check_plugin(plugin_of(list, "host", ""));
  if (!check.wrong.empty()) throw Error(ErrorKind::plugin, "a component of the program: " + check.wrong);
  if (!check.not_usable[0].empty()) throw Error(ErrorKind::plugin, check.not_usable[0]);
  copy_ = std::make_shared<const Copy>(description, std::move(owner));
}

HostComponent HostComponent::renamed(const std::string& id) const {
  springnet_component other = copy_->component;
  other.id = id.c_str();
  return {other, copy_->owner};
}

const springnet_component& HostComponent::description() const noexcept { return copy_->component; }

HostPlugin::HostPlugin(const HostComponent& given, std::string_view plugin_id, std::string_view plugin_version)
    : component(given),
      id(plugin_id),
      version(plugin_version),
      list{&component.description()},
      plugin(plugin_of(list, id.c_str(), version.c_str())) {}

}  // namespace springnet
