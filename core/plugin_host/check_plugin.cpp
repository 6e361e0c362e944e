#include "plugin_host/check_plugin.hpp"

#include <string.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <springnet/printable.hpp>

namespace springnet {
namespace {

// No plugin has more of anything; a greater count comes from a damaged or foreign struct.
constexpr std::uint32_t max_count = 4096;
// Bytes of a name, and of any other text.
constexpr std::size_t max_name_length = 100, max_text_length = 8192;

const char* const rebuild = "rebuild the plugin with the SDK of this springnet";

std::string too_short(std::string_view what, std::uint32_t size, std::size_t needed) {
  return fmt::format("{} has {} bytes, plugin ABI {}.0 needs {}: {}", what, size, SPRINGNET_ABI_MAJOR, needed, rebuild);
}

// Rejects struct pointers that are null or too short for ABI 2.0. Every struct except springnet_plugin begins with its
// size.
template <class Struct>
std::string check_struct(const Struct* pointer, std::size_t needed, std::string_view what) {
  if (pointer == nullptr) return fmt::format("{} is a null pointer: set it", what);
  if (pointer->struct_size < needed) return too_short(what, pointer->struct_size, needed);
  return {};
}

// Empty if all texts of `owner` (none of them null) have a plausible length: a damaged one may be unterminated.
std::string check_lengths(std::string_view owner, std::initializer_list<std::pair<const char*, const char*>> texts) {
  for (const auto& [name, text] : texts) {
    if (strnlen(text, max_text_length + 1) > max_text_length)
      return fmt::format("{}: its {} has more than {} bytes: shorten it", owner, name, max_text_length);
  }
  return {};
}

std::string shown(const char* text) {
  return text == nullptr ? std::string() : printable({text, strnlen(text, max_name_length + 1)});
}

bool is_snake_case(const char* text) {
  const std::string_view name(text, strnlen(text, max_name_length + 1));
  if (name.size() > max_name_length) return false;
  const auto allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  return !name.empty() && name[0] >= 'a' && name[0] <= 'z' && std::all_of(name.begin(), name.end(), allowed);
}

// Keys that share a scene's table with parameters.
bool is_taken_by_scenes(std::string_view name, std::uint32_t kind) {
  return name == "type" || name == "name" || (kind == SPRINGNET_NEURON && name == "mass");
}

std::string check_choices(const springnet_parameter& parameter, const std::string& what) {
  if (parameter.choice_count == 0 || parameter.choice_count > max_count || parameter.choices == nullptr) {
    return fmt::format("{} is a choice without a list of choices: list their names", what);
  }
  std::set<std::string_view> names;
  for (std::uint32_t i = 0; i < parameter.choice_count; ++i) {
    const char* name = parameter.choices[i];
    if (name == nullptr || *name == '\0') return fmt::format("{}: choice {} has no name: give it one", what, i);
    if (std::string wrong = check_lengths(fmt::format("{}: choice {}", what, i), {{"name", name}}); !wrong.empty())
      return wrong;
    if (!names.insert(name).second) return fmt::format("{} has two choices '{}': rename one", what, printable(name));
  }
  return {};
}

std::string check_bounds(const springnet_parameter& parameter, const std::string& what) {
  const bool has_bounds = parameter.type == SPRINGNET_NUMBER || parameter.type == SPRINGNET_INTEGER;
  if (has_bounds && !(parameter.smallest <= parameter.largest)) {  // also if one is nan
    return fmt::format("{}: no value is between smallest {} and largest {}: correct them", what, parameter.smallest,
                       parameter.largest);
  }
  const bool has_scale = parameter.type == SPRINGNET_NUMBER || (parameter.flags & SPRINGNET_LEARNABLE) != 0;
  if (has_scale && !(parameter.scale > 0 && std::isfinite(parameter.scale))) {
    return fmt::format("{}: scale must be a finite number above 0, but is {}: give a typical magnitude", what,
                       parameter.scale);
  }
  if ((parameter.flags & SPRINGNET_REQUIRED) == 0) {
    const std::string wrong = check_value(parameter, parameter.default_value);
    if (!wrong.empty()) return fmt::format("{}: its default {}: correct default or bounds", what, wrong);
  }
  return {};
}

std::string check_parameter(const springnet_parameter* parameter, const std::string& what) {
  if (std::string wrong = check_struct(parameter, SPRINGNET_PARAMETER_SIZE_2_0, what); !wrong.empty()) return wrong;
  if (parameter->name == nullptr || !is_snake_case(parameter->name)) {
    return fmt::format("{} has the name '{}': give it one of lower-case letters, digits and '_' (a key in scenes)",
                       what, shown(parameter->name));
  }
  const std::string named = fmt::format("{} '{}'", what, parameter->name);
  if (parameter->unit == nullptr || *parameter->unit == '\0') {
    return fmt::format("{} has no unit: give an SI unit, \"1\" where there is none", named);
  }
  if (parameter->summary == nullptr) return fmt::format("{} has no summary: say in one line what it is", named);
  if (std::string wrong = check_lengths(named, {{"unit", parameter->unit}, {"summary", parameter->summary}});
      !wrong.empty())
    return wrong;
  if (parameter->type > SPRINGNET_CHOICE) {
    return fmt::format("{} is of type {}, which springnet does not know: {}", named, parameter->type, rebuild);
  }
  if (parameter->type == SPRINGNET_CHOICE) {
    if (std::string wrong = check_choices(*parameter, named); !wrong.empty()) return wrong;
  }
  return check_bounds(*parameter, named);
}

// Checks a list of parameters, states or inputs.
std::string check_parameters(const springnet_parameter* const* list, std::uint32_t count, std::uint32_t kind,
                             const std::string& owner, std::string_view noun) {
  if (count == 0) return {};
  if (count > max_count) return fmt::format("{} claims to have {} {}s: {}", owner, count, noun, rebuild);
  if (list == nullptr) return fmt::format("{}: its list of {}s is a null pointer: set it", owner, noun);
  std::set<std::string_view> names;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::string wrong = check_parameter(list[i], fmt::format("{}: {} {}", owner, noun, i));
    if (!wrong.empty()) return wrong;
    if (is_taken_by_scenes(list[i]->name, kind)) {
      return fmt::format("{}: scenes use '{}' for something else: rename the {}", owner, list[i]->name, noun);
    }
    if (!names.insert(list[i]->name).second) {
      return fmt::format("{} has two {}s '{}': rename one", owner, noun, list[i]->name);
    }
  }
  return {};
}

std::string missing_function(const std::string& owner, std::string_view function) {
  return fmt::format("{} has no function '{}': provide one", owner, function);
}

// Tables are keys in scenes beside parameters and inputs.
std::string check_tables(const springnet_component& component, const springnet_law& law, const std::string& owner) {
  if (law.table_count == 0) return {};
  if (law.table_count > max_count)
    return fmt::format("{} claims to have {} tables: {}", owner, law.table_count, rebuild);
  if (law.tables == nullptr) return fmt::format("{}: its list of tables is a null pointer: set it", owner);
  std::set<std::string_view> names;
  for (std::uint32_t i = 0; i < component.parameter_count; ++i) names.insert(component.parameters[i]->name);
  for (std::uint32_t i = 0; i < law.input_count; ++i) names.insert(law.inputs[i]->name);
  for (std::uint32_t i = 0; i < law.table_count; ++i) {
    const std::string what = fmt::format("{}: table {}", owner, i);
    const springnet_table* const table = law.tables[i];
    if (std::string wrong = check_struct(table, SPRINGNET_TABLE_SIZE_2_0, what); !wrong.empty()) return wrong;
    if (table->name == nullptr || !is_snake_case(table->name))
      return fmt::format("{} has the name '{}': give it one of lower-case letters, digits and '_' (a key in scenes)",
                         what, shown(table->name));
    const std::string named = fmt::format("{} '{}'", what, table->name);
    if (table->unit == nullptr || *table->unit == '\0' || table->summary == nullptr)
      return fmt::format("{} has no unit or summary: fill them in, \"1\" for no unit", named);
    if (std::string wrong = check_lengths(named, {{"unit", table->unit}, {"summary", table->summary}}); !wrong.empty())
      return wrong;
    if ((table->flags & ~std::uint32_t{SPRINGNET_INCREASING | SPRINGNET_OPTIONAL}) != 0)
      return fmt::format("{} has flags {:#x}, which springnet does not know: {}", named, table->flags, rebuild);
    if (table->least > most_table_values)
      return fmt::format("{} asks for {} values or more, a table has at most {}: ask for fewer", named, table->least,
                         most_table_values);
    if (table->as_long_as >= law.table_count)
      return fmt::format("{} is to be as long as table {}, of {}: give the number of a table", named, table->as_long_as,
                         law.table_count);
    if (!(table->smallest <= table->largest))
      return fmt::format("{}: no value is between smallest {} and largest {}: correct them", named, table->smallest,
                         table->largest);
    if (is_taken_by_scenes(table->name, SPRINGNET_SPRING_FUNCTION) || !names.insert(table->name).second)
      return fmt::format("{}: its name is taken: rename it", named);
  }
  return {};
}

// The list of a law over several invariants.
std::string check_invariants(const springnet_component& component, const springnet_law& law, const std::string& owner) {
  if (law.invariant != SPRINGNET_SEVERAL) return {};
  if (std::string wrong = check_struct(&law, SPRINGNET_LAW_SIZE_2_1, owner + ": its law"); !wrong.empty()) return wrong;
  if ((component.needs & SPRINGNET_NEEDS_SEVERAL) == 0)
    return fmt::format("{} reads several invariants: set SPRINGNET_NEEDS_SEVERAL", owner);
  if (law.shape < SPRINGNET_CHAIN || law.shape > SPRINGNET_TETRAHEDRON)
    return fmt::format("{} is for elements of shape {}, which springnet does not know: {}", owner, law.shape, rebuild);
  const std::uint32_t corners = law.shape == SPRINGNET_CHAIN || law.shape == SPRINGNET_TRIANGLE ? 3 : 4;
  if (law.invariant_count < 1 || law.invariant_count > SPRINGNET_MOST_INVARIANTS)
    return fmt::format("{} reads {} invariants: list 1 to {}", owner, law.invariant_count, SPRINGNET_MOST_INVARIANTS);
  if (law.invariants == nullptr) return fmt::format("{}: its list of invariants is a null pointer: set it", owner);
  std::set<std::array<std::uint32_t, 5>> known;
  for (std::uint32_t i = 0; i < law.invariant_count; ++i) {
    const springnet_invariant* const one = law.invariants[i];
    const std::string what = fmt::format("{}: invariant {}", owner, i);
    if (std::string wrong = check_struct(one, SPRINGNET_INVARIANT_SIZE_2_1, what); !wrong.empty()) return wrong;
    std::uint32_t count = 0;
    if (one->kind == SPRINGNET_LENGTH) count = 2;
    if (one->kind == SPRINGNET_ANGLE || one->kind == SPRINGNET_AREA) count = 3;
    if (one->kind == SPRINGNET_VOLUME || one->kind == SPRINGNET_DIHEDRAL) count = 4;
    if (count == 0) return fmt::format("{} is of kind {}, which is not one of several: {}", what, one->kind, rebuild);
    if ((one->flags & ~std::uint32_t{SPRINGNET_REFERENCE_ONLY}) != 0)
      return fmt::format("{} has flags {:#x}, which springnet does not know: {}", what, one->flags, rebuild);
    for (std::uint32_t a = 0; a < count; ++a) {
      if (one->corners[a] >= corners)
        return fmt::format("{} has the corner {}, its elements have {}: number them from 0", what, one->corners[a],
                           corners);
      for (std::uint32_t b = 0; b < a; ++b)
        if (one->corners[a] == one->corners[b])
          return fmt::format("{} has the corner {} twice: give different ones", what, one->corners[a]);
    }
    std::array<std::uint32_t, 5> key{one->kind, 0, 0, 0, 0};
    std::copy_n(one->corners, count, key.begin() + 1);
    if (!known.insert(key).second) return fmt::format("{} is there already: list each one once", what);
  }
  return {};
}

std::string check_law(const springnet_component& component, const std::string& owner) {
  const auto* law = static_cast<const springnet_law*>(component.implementation);
  if (std::string wrong = check_struct(law, SPRINGNET_LAW_SIZE_2_0, owner + ": its law"); !wrong.empty()) return wrong;
  if (law->evaluate == nullptr) return missing_function(owner, "evaluate");
  if (law->state_count > 0 && law->update == nullptr) return missing_function(owner, "update");
  if (law->update_order < 1 || law->update_order > 2)
    return fmt::format("{} has an update of order {}: give 1 or 2", owner, law->update_order);
  if (law->table_count > 0 && law->prepare == nullptr) return missing_function(owner, "prepare");
  if (law->prepare != nullptr && law->release == nullptr) return missing_function(owner, "release");
  if (!(law->smallest_stretch <= law->largest_stretch))
    return fmt::format("{} holds from a stretch of {} to {}: correct the bounds", owner, law->smallest_stretch,
                       law->largest_stretch);
  if (law->invariant == SPRINGNET_RELATIVE_SPEED && (component.capabilities & SPRINGNET_READS_RATE) != 0) {
    return fmt::format("{} reads the rate of the relative speed, which has none: drop SPRINGNET_READS_RATE", owner);
  }
  std::string wrong = check_invariants(component, *law, owner);
  if (wrong.empty()) wrong = check_parameters(law->states, law->state_count, component.kind, owner, "state");
  if (wrong.empty()) wrong = check_parameters(law->inputs, law->input_count, component.kind, owner, "input");
  return wrong.empty() ? check_tables(component, *law, owner) : wrong;
}

std::string check_neuron(const springnet_component& component, const std::string& owner) {
  const auto* neuron = static_cast<const springnet_neuron_model*>(component.implementation);
  std::string wrong = check_struct(neuron, SPRINGNET_NEURON_MODEL_SIZE_2_0, owner + ": its model");
  if (wrong.empty() && neuron->evaluate == nullptr) wrong = missing_function(owner, "evaluate");
  return wrong;
}

std::string check_integrator(const springnet_component& component, const std::string& owner) {
  const auto* integrator = static_cast<const springnet_integrator*>(component.implementation);
  std::string wrong = check_struct(integrator, SPRINGNET_INTEGRATOR_SIZE_2_0, owner + ": its implementation");
  if (!wrong.empty()) return wrong;
  if (integrator->create == nullptr) return missing_function(owner, "create");
  if (integrator->destroy == nullptr) return missing_function(owner, "destroy");
  if (integrator->advance == nullptr) return missing_function(owner, "advance");
  return {};
}

// Why this host cannot use a component whose struct and id are valid, although its plugin may be all right.
std::string why_not_usable(const springnet_component& component) {
  constexpr std::uint64_t known =
      SPRINGNET_NEEDS_STATES | SPRINGNET_NEEDS_INPUTS | SPRINGNET_NEEDS_TABLES | SPRINGNET_NEEDS_SEVERAL;
  const char* const remedy = "use a newer springnet";
  if (component.needs_minor > SPRINGNET_ABI_MINOR)
    return fmt::format("component '{}' needs plugin ABI {}.{}, this springnet has {}.{}: {}", component.id,
                       SPRINGNET_ABI_MAJOR, component.needs_minor, SPRINGNET_ABI_MAJOR, SPRINGNET_ABI_MINOR, remedy);
  if ((component.needs & ~known) != 0)
    return fmt::format("component '{}' needs what this springnet does not provide (bits {:#x} of `needs`): {}",
                       component.id, component.needs & ~known, remedy);
  if (component.kind < SPRINGNET_SPRING_FUNCTION || component.kind > SPRINGNET_INTEGRATOR)
    return fmt::format("component '{}' is of kind {}, which this springnet does not know: {}", component.id,
                       component.kind, remedy);
  return {};
}

// not_usable: why the component, in itself valid, cannot be used by this host.
std::string check_component(const springnet_component* component, std::uint32_t number, std::string& not_usable) {
  const std::string what = fmt::format("component {}", number);
  if (std::string wrong = check_struct(component, SPRINGNET_COMPONENT_SIZE_2_0, what); !wrong.empty()) return wrong;
  if (component->id == nullptr || !is_snake_case(component->id)) {
    return fmt::format("{} has the id '{}': give it one of lower-case letters, digits and '_' (its name in scenes)",
                       what, shown(component->id));
  }
  // What a later version means by the rest is not known.
  if (not_usable = why_not_usable(*component); !not_usable.empty()) return {};
  const std::string owner = fmt::format("{} '{}'", name_of(static_cast<ComponentKind>(component->kind)), component->id);
  if (std::string_view(component->id) == "none") {
    return fmt::format("{}: in scenes \"none\" stands for no function: rename it", owner);
  }
  if (component->summary == nullptr || component->reference == nullptr) {
    return fmt::format("{} has no summary or reference: fill them in, \"\" where there is no literature", owner);
  }
  std::string wrong = check_lengths(owner, {{"summary", component->summary}, {"reference", component->reference}});
  if (!wrong.empty()) return wrong;
  wrong = check_parameters(component->parameters, component->parameter_count, component->kind, owner, "parameter");
  if (!wrong.empty()) return wrong;
  switch (component->kind) {
    case SPRINGNET_NEURON:
      return check_neuron(*component, owner);
    case SPRINGNET_INTEGRATOR:
      return check_integrator(*component, owner);
    default:
      return check_law(*component, owner);
  }
}

// Checks magic number, version and size, in the order in which they can be read safely.
std::string check_header(const springnet_plugin& plugin) {
  if (plugin.magic != SPRINGNET_MAGIC) {
    return fmt::format(
        "{} does not begin with springnet's magic number, so it is not a springnet plugin: declare it "
        "with the SDK",
        SPRINGNET_ENTRY_SYMBOL);
  }
  constexpr std::size_t up_to_version = SPRINGNET_SIZE_TO(springnet_plugin, abi_minor);
  if (plugin.struct_size >= up_to_version && plugin.abi_major != SPRINGNET_ABI_MAJOR) {
    return fmt::format(
        "built for plugin ABI {}.{}, this springnet reads {}.x (it has {}.{}): {}, or use a springnet "
        "of ABI {}",
        plugin.abi_major, plugin.abi_minor, SPRINGNET_ABI_MAJOR, SPRINGNET_ABI_MAJOR, SPRINGNET_ABI_MINOR, rebuild,
        plugin.abi_major);
  }
  if (plugin.struct_size < SPRINGNET_PLUGIN_SIZE_2_0) {
    return too_short("the plugin's entry", plugin.struct_size, SPRINGNET_PLUGIN_SIZE_2_0);
  }
  if (plugin.needs_minor > SPRINGNET_ABI_MINOR) {
    return fmt::format("it needs plugin ABI {}.{}, this springnet has {}.{}: use a newer springnet",
                       SPRINGNET_ABI_MAJOR, plugin.needs_minor, SPRINGNET_ABI_MAJOR, SPRINGNET_ABI_MINOR);
  }
  return {};
}

}  // namespace

PluginCheck check_plugin(const springnet_plugin& plugin) {
  if (std::string wrong = check_header(plugin); !wrong.empty()) return {wrong, {}};
  if (plugin.id == nullptr || *plugin.id == '\0')
    return {"the plugin has no id: give it one, as \"org.example.laws\"", {}};
  if (plugin.version == nullptr || plugin.author == nullptr || plugin.licence == nullptr)
    return {"version, author or licence of the plugin is a null pointer: fill them in, \"\" where unknown", {}};
  if (std::string wrong = check_lengths(
          "the plugin",
          {{"id", plugin.id}, {"version", plugin.version}, {"author", plugin.author}, {"licence", plugin.licence}});
      !wrong.empty())
    return {wrong, {}};
  if (plugin.component_count == 0 || plugin.component_count > max_count || plugin.components == nullptr)
    return {fmt::format("the plugin offers {} components{}: list them", plugin.component_count,
                        plugin.components == nullptr ? " behind a null pointer" : ""),
            {}};
  PluginCheck result;
  std::set<std::pair<std::uint32_t, std::string_view>> taken;
  for (std::uint32_t i = 0; i < plugin.component_count; ++i) {
    std::string not_usable;
    if (std::string wrong = check_component(plugin.components[i], i, not_usable); !wrong.empty()) return {wrong, {}};
    result.not_usable.push_back(std::move(not_usable));
    if (!result.not_usable.back().empty()) continue;
    const springnet_component& component = *plugin.components[i];
    if (!taken.emplace(component.kind, component.id).second)
      return {fmt::format("the plugin has two {}s '{}': rename one",
                          name_of(static_cast<ComponentKind>(component.kind)), component.id),
              {}};
  }
  return result;
}

}  // namespace springnet
