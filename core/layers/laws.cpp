#include "layers/laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <unordered_map>

#include <springnet/error.hpp>

#include "layers/kernels.hpp"
#include "plugin_host/call.hpp"
#include "plugin_host/message.hpp"

namespace springnet::layers {
namespace {

struct MaterialLaws {
  std::uint32_t group;
  std::vector<double> parameters;  // of both functions
};

Law resolve(const std::optional<LawUse>& use, ComponentKind kind, std::size_t first_column, const PluginHost& plugins,
            std::vector<double>& parameters) {
  Law law;
  if (!use) return law;
  law.component = plugins.require(kind, use->id);
  const springnet_component& description = *law.component->description;
  const springnet_law& implementation = law.component->law();
  const std::string where = fmt::format("{} '{}'", name_of(kind), use->id);
  const auto refuse = [&](std::string_view what) {
    throw Error(ErrorKind::plugin,
                fmt::format("{}: {}, which this version of springnet does not evaluate; use another law", where, what));
  };
  if (implementation.invariant < SPRINGNET_LENGTH || implementation.invariant > SPRINGNET_ENCLOSED_VOLUME)
    refuse(fmt::format("reads invariant number {}", implementation.invariant));
  if (implementation.state_count > 0) refuse("has internal state");
  if (implementation.input_count > 0) refuse("reads input signals");
  if (implementation.prepare != nullptr) refuse("prepares a table");
  if (description.parameter_count > max_parameters)
    refuse(fmt::format("has {} parameters, more than {}", description.parameter_count, max_parameters));
  law.invariant = implementation.invariant;
  law.relative = implementation.invariant == SPRINGNET_RELATIVE_SPEED;
  law.reads_rate = !law.relative && (description.capabilities & SPRINGNET_READS_RATE) != 0;
  law.parameter_count = description.parameter_count;
  law.first_column = first_column;
  const std::vector<double> values = complete_parameters(description, use->parameters, where);
  parameters.insert(parameters.end(), values.begin(), values.end());
  return law;
}

// For messages.
std::string_view reading(std::uint32_t invariant) {
  switch (invariant) {
    case SPRINGNET_RELATIVE_SPEED:
      return "the relative speed of two nodes";
    case SPRINGNET_ANGLE:
      return "an angle";
    case SPRINGNET_AREA:
      return "an area";
    case SPRINGNET_VOLUME:
      return "a volume";
    case SPRINGNET_ENCLOSED_VOLUME:
      return "an enclosed volume";
    default:
      return "a length";
  }
}

// A law of a length is a formula in one scalar and its rate, so it may be used on any invariant.
bool fits(const Law& law, Invariant invariant) {
  switch (law.invariant) {
    case SPRINGNET_LENGTH:
      return true;
    case SPRINGNET_ANGLE:
      return invariant == Invariant::angle || invariant == Invariant::dihedral;
    case SPRINGNET_AREA:
      return invariant == Invariant::area;
    case SPRINGNET_VOLUME:
      return invariant == Invariant::volume || invariant == Invariant::enclosed_volume;
    case SPRINGNET_ENCLOSED_VOLUME:
      return invariant == Invariant::enclosed_volume;
    default:
      return false;
  }
}

void check_use(const Law& law, std::size_t spring) {
  if (!law || law.invariant == SPRINGNET_LENGTH || law.invariant == SPRINGNET_RELATIVE_SPEED) return;
  throw Error(ErrorKind::input,
              fmt::format("spring {}: {} '{}' reads {}; use a law on the length or the relative speed of two nodes",
                          spring, name_of(law.component->kind()), law.component->id(), reading(law.invariant)));
}
void check_use(const Law& law, Invariant invariant, std::size_t element) {
  if (!law || fits(law, invariant)) return;
  throw Error(
      ErrorKind::input,
      fmt::format("element {} ({}): {} '{}' reads {}; use a law on the length, which may read any invariant, or "
                  "one made for this",
                  element, name_of(invariant), name_of(law.component->kind()), law.component->id(),
                  reading(law.invariant)));
}

// Key of a row: the material, and the bits of the rest length or reference.
struct RowKey {
  std::uint32_t material;
  std::uint64_t rest_length;
  bool operator==(const RowKey&) const = default;
};
struct RowKeyHash {
  std::size_t operator()(const RowKey& key) const noexcept {
    return std::hash<std::uint64_t>{}(key.rest_length * 0x9e3779b97f4a7c15u + key.material);
  }
};

}  // namespace

CompiledLaws compile_laws(const Network& network, const PluginHost& plugins) {
  CompiledLaws compiled;
  std::vector<MaterialLaws> materials;
  for (const Material& material : network.materials()) {
    std::vector<double> parameters;
    const Law spring = resolve(material.spring, ComponentKind::spring_function, 1, plugins, parameters);
    const Law viscosity =
        resolve(material.viscosity, ComponentKind::viscosity_function, 1 + parameters.size(), plugins, parameters);
    std::uint32_t index = 0;
    while (index < compiled.groups.size() && (compiled.groups[index].spring.component != spring.component ||
                                              compiled.groups[index].viscosity.component != viscosity.component))
      ++index;
    if (index == compiled.groups.size()) {
      compiled.groups.push_back({spring, viscosity, std::vector<std::vector<double>>(1 + parameters.size())});
    }
    materials.push_back({index, std::move(parameters)});
  }

  const std::vector<Spring>& springs = network.springs();
  compiled.group.reserve(springs.size());
  compiled.row.reserve(springs.size());
  std::unordered_map<RowKey, std::uint32_t, RowKeyHash> rows;
  RowKey last_key{0xffffffffu, 0};
  std::uint32_t last_row = 0;
  const auto row_of = [&](MaterialIndex index, double reference) {
    const MaterialLaws& material = materials[index];
    Group& group = compiled.groups[material.group];
    const RowKey key{index, std::bit_cast<std::uint64_t>(reference)};
    if (key != last_key) {
      const auto [entry, is_new] = rows.try_emplace(key, static_cast<std::uint32_t>(group.row_count()));
      if (is_new) {
        group.columns[0].push_back(reference);
        for (std::size_t k = 0; k < material.parameters.size(); ++k)
          group.columns[k + 1].push_back(material.parameters[k]);
      }
      last_key = key;
      last_row = entry->second;
    }
    return last_row;
  };
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const std::uint32_t group = materials[springs[s].material].group;
    check_use(compiled.groups[group].spring, s);
    check_use(compiled.groups[group].viscosity, s);
    compiled.group.push_back(group);
    compiled.row.push_back(row_of(springs[s].material, springs[s].rest_length));
  }
  const std::vector<Element>& elements = network.elements();
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const std::uint32_t group = materials[elements[e].material].group;
    check_use(compiled.groups[group].spring, elements[e].invariant, e);
    check_use(compiled.groups[group].viscosity, elements[e].invariant, e);
    compiled.element_group.push_back(group);
    compiled.element_row.push_back(row_of(elements[e].material, elements[e].reference));
  }

  for (Group& group : compiled.groups)
    for (const std::vector<double>& column : group.columns)
      group.same.push_back(std::equal(column.begin() + (column.empty() ? 0 : 1), column.end(), column.begin()) ? 1 : 0);

  for (const LawUse& use : network.neurons()) {
    NeuronKind neuron;
    neuron.component = plugins.require(ComponentKind::neuron, use.id);
    if (neuron.component->description->parameter_count > max_parameters)
      throw Error(ErrorKind::plugin, fmt::format("neuron '{}' has more than {} parameters", use.id, max_parameters));
    neuron.parameters =
        complete_parameters(*neuron.component->description, use.parameters, fmt::format("neuron '{}'", use.id));
    compiled.neurons.push_back(std::move(neuron));
  }
  return compiled;
}

springnet_status require_derivatives(const Component& component, springnet_message& message) {
  if ((component.description->capabilities & SPRINGNET_HAS_DERIVATIVES) != 0) return SPRINGNET_OK;
  const char* header = component.kind() == ComponentKind::neuron ? "neuron" : "law";
  set_message(message, fmt::format("{} '{}' offers no derivatives, which implicit methods need; write it with "
                                   "springnet/sdk/{}.hpp, or choose an explicit method",
                                   name_of(component.kind()), component.id(), header));
  return SPRINGNET_FAILED;
}

}  // namespace springnet::layers
