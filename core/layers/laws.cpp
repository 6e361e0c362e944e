#include "layers/laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include <springnet/error.hpp>

#include "layers/kernels.hpp"
#include "layers/law_fit.hpp"
#include "network/corners.hpp"
#include "plugin_host/call.hpp"
#include "plugin_host/law_use.hpp"
#include "plugin_host/message.hpp"

namespace springnet::layers {
namespace {

struct MaterialLaws {
  std::uint32_t group;
  std::vector<double> parameters;  // of both functions
};

Law resolve(const std::optional<LawUse>& use, ComponentKind kind, std::size_t first_column, const PluginHost& plugins,
            std::vector<double>& parameters, PreparedTables& prepared, std::size_t material) {
  Law law;
  if (!use) return law;
  law.component = component_of(*use, kind, plugins);
  const springnet_component& description = *law.component->description;
  const springnet_law& implementation = law.component->law();
  const std::string where = fmt::format("{} '{}'", name_of(kind), use->id);
  const auto refuse = [&](std::string_view what) {
    throw Error(ErrorKind::plugin,
                fmt::format("{}: {}, which this version of springnet does not evaluate; use another law", where, what));
  };
  if (implementation.invariant < SPRINGNET_LENGTH || implementation.invariant > SPRINGNET_SEVERAL)
    refuse(fmt::format("reads invariant number {}", implementation.invariant));
  if (implementation.state_count > max_states)
    refuse(fmt::format("has {} internal states, more than {}", implementation.state_count, max_states));
  if (implementation.input_count > max_inputs)
    refuse(fmt::format("reads {} input signals, more than {}", implementation.input_count, max_inputs));
  if (description.parameter_count > max_parameters)
    refuse(fmt::format("has {} parameters, more than {}", description.parameter_count, max_parameters));
  law.invariant = implementation.invariant;
  law.relative = implementation.invariant == SPRINGNET_RELATIVE_SPEED;
  if (implementation.invariant == SPRINGNET_SEVERAL) {
    law.scalar_count = implementation.invariant_count;
    law.reads_direction = implementation.reads_direction != 0;
  }
  law.reads_rate = !law.relative && (description.capabilities & SPRINGNET_READS_RATE) != 0;
  law.parameter_count = description.parameter_count;
  law.input_count = implementation.input_count;
  law.state_count = implementation.state_count;
  law.update_order = implementation.update_order;
  law.reads_start = implementation.reads_start != 0;
  law.first_column = first_column;
  const std::vector<double> values = complete_parameters(description, use->parameters, where);
  try {
    std::vector<std::span<const double>> tables = complete_tables(description, use->tables, where);
    law.prepared = prepared.of(law.component, values, tables);
    if (law.prepared) law.tables = std::move(tables);
  } catch (const Error& error) {
    throw Error(error.kind(), fmt::format("material {}: {}", material, error.what()));
  }
  parameters.insert(parameters.end(), values.begin(), values.end());
  return law;
}

ElementScalar scalar_of(const springnet_invariant& from) {
  ElementScalar scalar{Measure::length, (from.flags & SPRINGNET_REFERENCE_ONLY) != 0, {}};
  if (from.kind == SPRINGNET_ANGLE) scalar.measure = Measure::angle;
  if (from.kind == SPRINGNET_AREA) scalar.measure = Measure::area;
  if (from.kind == SPRINGNET_VOLUME) scalar.measure = Measure::volume;
  if (from.kind == SPRINGNET_DIHEDRAL) scalar.measure = Measure::dihedral;
  for (std::size_t c = 0; c < scalar.corner_count(); ++c) scalar.corner[c] = static_cast<std::uint8_t>(from.corners[c]);
  return scalar;
}

// The scalars of both laws, each once.
ScalarList join_scalars(Law& spring, Law& viscosity, std::size_t material) {
  ScalarList list;
  for (Law* const law : {&spring, &viscosity}) {
    if (!*law || law->scalar_count == 0) continue;
    const springnet_law& from = law->component->law();
    list.corners = from.shape == SPRINGNET_CHAIN || from.shape == SPRINGNET_TRIANGLE ? 3 : 4;
    for (std::uint32_t i = 0; i < law->scalar_count; ++i) {
      const ElementScalar scalar = scalar_of(*from.invariants[i]);
      const auto begin = list.scalar.begin(), end = begin + static_cast<std::ptrdiff_t>(list.count);
      const auto known = std::find_if(begin, end, [&](const ElementScalar& other) {
        return other.measure == scalar.measure && other.corner == scalar.corner;
      });
      if (known == end) {
        if (list.count == max_scalars)
          throw Error(ErrorKind::input,
                      fmt::format("material {}: '{}' and '{}' together read more than {} scalars of an element; use "
                                  "laws that read the same ones",
                                  material, spring.component->id(), viscosity.component->id(), max_scalars));
        list.scalar[list.count++] = scalar;
      } else if (!scalar.reference_only) {
        known->reference_only = false;
      }
      law->scalar[i] = static_cast<std::uint8_t>(known - begin);
      law->reads[i] = !scalar.reference_only;
    }
  }
  return list;
}

// what: see misfit(); whose(): "spring 3".
template <class Whose>
void check_fit(const Component& law, const std::string& what, const Whose& whose) {
  if (!what.empty())
    throw Error(ErrorKind::input, fmt::format("{}: {} '{}' {}", whose(), name_of(law.kind()), law.id(), what));
}

// Looks at the rows of springs, of which there are few in a regular net, and for the spring only when one is wrong.
void check_rest_lengths(const SpringList& springs, const CompiledLaws& compiled) {
  const auto divides = [](const Law& law) { return law.can(SPRINGNET_DIVIDES_BY_REFERENCE); };
  const auto wrong = [&](const Group& group) {
    if (!divides(group.spring) && !divides(group.viscosity)) return false;
    const Column<double>& lengths = group.columns[0];
    for (std::size_t row = 0; row < (lengths.is_uniform() ? 1 : group.row_count()); ++row)
      if (group.row_count() > 0 && !(lengths[row] > 0.0)) return true;
    return false;
  };
  if (std::none_of(compiled.groups.begin(), compiled.groups.end(), wrong)) return;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const Group& group = compiled.groups[compiled.group[s]];
    const double length = springs.rest_lengths()[s];
    if (length > 0.0 || !wrong(group)) continue;
    const Component& law = *(divides(group.spring) ? group.spring : group.viscosity).component;
    throw Error(ErrorKind::input,
                fmt::format("spring {}: {} '{}' divides by the rest length, which is {} here; give one above 0, or use "
                            "another law",
                            s, name_of(law.kind()), law.id(), length));
  }
}

// Key of a row: the material, the rest length or reference, and the signals.
struct RowKey {
  std::uint32_t material;
  std::uint32_t inputs;  // set of InputSets
  double reference;
};

// Distinct keys, numbered in the order in which they were first asked for. Four to eight bytes a key besides the keys:
// every spring of an irregular mesh may have its own.
class RowKeys {
 public:
  std::uint32_t number_of(const RowKey& key) {
    if (!keys_.empty() && is_same(key, keys_[last_])) return last_;
    if (2 * keys_.size() >= places_.size()) grow();
    std::uint32_t& place = places_[place_of(key)];
    if (place == none) {
      place = static_cast<std::uint32_t>(keys_.size());
      keys_.push_back(key);
    }
    return last_ = place;
  }
  [[nodiscard]] const std::vector<RowKey>& keys() const noexcept { return keys_; }

 private:
  static constexpr std::uint32_t none = 0xffffffffu;

  static bool is_same(const RowKey& a, const RowKey& b) {
    return a.material == b.material && a.inputs == b.inputs && detail::SameBits<double>::of(a.reference, b.reference);
  }
  // Of the key, or the free one where it belongs.
  [[nodiscard]] std::size_t place_of(const RowKey& key) const {
    const std::size_t mask = places_.size() - 1;
    std::uint64_t hash = (std::bit_cast<std::uint64_t>(key.reference) ^ key.material * 0xff51afd7ed558ccdu) +
                         key.inputs * 0xc4ceb9fe1a85ec53u;
    hash = (hash ^ hash >> 32) * 0x9e3779b97f4a7c15u;
    std::size_t at = (hash ^ hash >> 29) & mask;
    while (places_[at] != none && !is_same(keys_[places_[at]], key)) at = (at + 1) & mask;
    return at;
  }
  void grow() {
    places_.assign(std::max<std::size_t>(64, 2 * places_.size()), none);
    for (std::size_t i = 0; i < keys_.size(); ++i) places_[place_of(keys_[i])] = static_cast<std::uint32_t>(i);
  }

  std::vector<RowKey> keys_;
  std::vector<std::uint32_t> places_;  // a power of two, open addressing
  std::uint32_t last_ = 0;
};

// Numbers the rows of the groups. The number of a key of springs or elements becomes that of a row in its group.
class Rows {
 public:
  Rows(std::vector<Group>& groups, const std::vector<MaterialLaws>& materials, const InputSets& inputs,
       Signals& signals)
      : groups_(groups), materials_(materials), inputs_(inputs), signals_(signals) {}

  // Of springs or elements with these materials, sets of signals and references.
  template <class References>
  Column<std::uint32_t> of(std::size_t count, const Column<MaterialIndex>& materials, const Column<std::uint32_t>& sets,
                           const References& references, bool all_alike) {
    Column<std::uint32_t> rows;
    if (count == 0) return rows;
    if (all_alike && sets.is_uniform()) {
      rows.append(count, row_of({materials[0], sets[0], references(0)}));
      return rows;
    }
    // Pieces by themselves, then their keys in the order of the pieces: the numbers do not depend on the threads.
    constexpr std::size_t piece = std::size_t{1} << 19;
    constexpr double irregular_share = 0.75;
    const std::size_t pieces = (count + piece - 1) / piece;
    std::vector<std::vector<RowKey>> keys(pieces);
    std::uint32_t* const row = rows.append_each(count);
#pragma omp parallel for schedule(dynamic, 1) if (pieces > 1)
    for (std::size_t p = 0; p < pieces; ++p) {
      RowKeys own;
      for (std::size_t i = p * piece; i < std::min(count, (p + 1) * piece); ++i)
        row[i] = own.number_of({materials[i], sets[i], references(i)});
      keys[p] = own.keys();
    }
    if (materials.is_uniform()) {
      std::size_t most = groups_[materials_[materials[0]].group].row_count();
      for (const std::vector<RowKey>& own : keys) most += own.size();
      groups_[materials_[materials[0]].group].columns.own()[0].reserve(most);
    }
    std::vector<std::vector<std::uint32_t>> rows_of(pieces);
    for (std::size_t p = 0; p < pieces; ++p) {
      rows_of[p].reserve(keys[p].size());
      // Springs of an irregular mesh have hardly any two rest lengths alike: to look for them would find nothing.
      const bool irregular = static_cast<double>(keys[p].size()) >
                             irregular_share * static_cast<double>(std::min(piece, count - p * piece));
      for (const RowKey& key : keys[p]) rows_of[p].push_back(irregular ? new_row(key) : row_of(key));
      std::vector<RowKey>().swap(keys[p]);
    }
#pragma omp parallel for schedule(static) if (pieces > 1)
    for (std::size_t p = 0; p < pieces; ++p)
      for (std::size_t i = p * piece; i < std::min(count, (p + 1) * piece); ++i) row[i] = rows_of[p][row[i]];
    return rows;
  }

 private:
  std::uint32_t row_of(const RowKey& key) {
    const std::uint32_t number = known_.number_of(key);
    if (number == rows_.size()) rows_.push_back(new_row(key));
    return rows_[number];
  }
  std::uint32_t new_row(const RowKey& key) {
    const MaterialLaws& material = materials_[key.material];
    Group& group = groups_[material.group];
    const auto row = static_cast<std::uint32_t>(group.row_count());
    std::vector<Column<double>>& columns = group.columns.own();
    columns[0].push_back(key.reference);
    for (std::size_t k = 0; k < material.parameters.size(); ++k) columns[k + 1].push_back(material.parameters[k]);
    for (const Law* const law : group.laws()) {
      for (std::size_t k = 0; k < law->input_count; ++k)
        columns[law->first_input_column + k].push_back(signal_of(key.inputs, *law->component->law().inputs[k]));
    }
    return row;
  }
  // An input that has no signal has the declared value.
  double signal_of(std::uint32_t set, const springnet_parameter& input) {
    std::uint32_t signal = inputs_.signal(set, input.name);
    if (signal == InputSets::none) {
      const auto [place, is_new] = constants_.try_emplace(input.default_value, 0u);
      if (is_new) place->second = signals_.add_constant(input.default_value);
      signal = place->second;
    }
    return signal;
  }

  std::vector<Group>& groups_;
  const std::vector<MaterialLaws>& materials_;
  const InputSets& inputs_;
  Signals& signals_;
  std::map<double, std::uint32_t> constants_;  // their signals
  RowKeys known_;
  std::vector<std::uint32_t> rows_;  // [key's number]
};

Column<std::uint32_t> groups_of(const Column<MaterialIndex>& used, const std::vector<MaterialLaws>& materials) {
  Column<std::uint32_t> groups;
  if (used.is_uniform() && !used.empty()) {
    groups.append(used.size(), materials[used[0]].group);
    return groups;
  }
  groups.reserve(used.size());
  for (std::size_t i = 0; i < used.size(); ++i) groups.push_back(materials[used[i]].group);
  return groups;
}

// Numbers the groups in the order in which springs, then elements first use them, whatever the order of the materials:
// a node sums its forces group by group, so that networks with the same springs have the same bits.
void order_groups(const Network& network, std::vector<MaterialLaws>& materials, std::vector<Group>& groups) {
  constexpr std::uint32_t none = 0xffffffffu;
  std::vector<std::uint32_t> number(groups.size(), none);
  std::uint32_t next = 0;
  const auto use = [&](MaterialIndex material) {
    std::uint32_t& own = number[materials[material].group];
    if (own == none) own = next++;
  };
  const Column<MaterialIndex>& of_springs = network.springs().materials();
  const std::size_t springs = of_springs.is_uniform() ? std::min<std::size_t>(of_springs.size(), 1) : of_springs.size();
  for (std::size_t s = 0; s < springs && next < groups.size(); ++s) use(of_springs[s]);
  for (std::size_t e = 0; e < network.elements().size() && next < groups.size(); ++e)
    use(network.elements()[e].material);
  for (std::uint32_t& own : number)
    if (own == none) own = next++;
  std::vector<Group> sorted(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) sorted[number[g]] = std::move(groups[g]);
  groups = std::move(sorted);
  for (MaterialLaws& each : materials) each.group = number[each.group];
}

}  // namespace

CompiledLaws compile_laws(const Network& network, const PluginHost& plugins) {
  CompiledLaws compiled;
  for (const Input& input : network.inputs())
    compiled.inputs.push_back({input.name, readers_of(network, input, plugins)});
  compiled.signals = std::make_unique<Signals>(network.inputs());
  std::vector<MaterialLaws> materials;
  PreparedTables prepared;
  std::map<std::array<const void*, 4>, std::uint32_t> known_groups;
  for (const Material& material : network.materials()) {
    std::vector<double> parameters;
    Law spring =
        resolve(material.spring, ComponentKind::spring_function, 1, plugins, parameters, prepared, materials.size());
    Law viscosity = resolve(material.viscosity, ComponentKind::viscosity_function, 1 + parameters.size(), plugins,
                            parameters, prepared, materials.size());
    viscosity.first_state = spring.state_count;
    spring.first_input_column = 1 + parameters.size();
    viscosity.first_input_column = spring.first_input_column + spring.input_count;
    const ScalarList scalars = join_scalars(spring, viscosity, materials.size());
    const auto [group, is_new] = known_groups.try_emplace(
        {spring.component.get(), viscosity.component.get(), spring.prepared.get(), viscosity.prepared.get()},
        static_cast<std::uint32_t>(compiled.groups.size()));
    if (is_new) {
      compiled.groups.push_back(
          {spring, viscosity, std::vector<Column<double>>(viscosity.first_input_column + viscosity.input_count)});
      if (spring.input_count + viscosity.input_count > 0) compiled.groups.back().signals = compiled.signals.get();
      compiled.groups.back().scalars = scalars;
    }
    materials.push_back({group->second, std::move(parameters)});
  }
  order_groups(network, materials, compiled.groups);

  const SpringList& springs = network.springs();
  compiled.group = groups_of(springs.materials(), materials);
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const Group& group = compiled.groups[compiled.group[s]];
    for (const Law* const law : group.laws())
      if (*law) check_fit(*law->component, misfit(*law->component), [&] { return fmt::format("spring {}", s); });
    if (compiled.group.is_uniform()) break;  // the others have the same laws
  }
  const InputSets inputs(network, plugins);
  Rows rows(compiled.groups, materials, inputs, *compiled.signals);
  const Column<double>& rest_lengths = springs.rest_lengths();
  compiled.row = RowNumbers(rows.of(
      springs.size(), springs.materials(), inputs.of_springs(), [&](std::size_t s) { return rest_lengths[s]; },
      springs.materials().is_uniform() && rest_lengths.is_uniform()));
  check_rest_lengths(springs, compiled);

  const std::vector<Element>& elements = network.elements();
  Column<MaterialIndex> element_materials;
  element_materials.reserve(elements.size());
  for (const Element& element : elements) element_materials.push_back(element.material);
  compiled.element_group = groups_of(element_materials, materials);
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const Group& group = compiled.groups[compiled.element_group[e]];
    for (const Law* const law : group.laws())
      if (*law)
        check_fit(*law->component, misfit(*law->component, elements[e]),
                  [&] { return fmt::format("element {} ({})", e, name_of(elements[e].invariant)); });
  }
  // The references of several scalars are with the elements, so that these share rows.
  compiled.element_row = rows.of(
      elements.size(), element_materials, inputs.of_elements(),
      [&](std::size_t e) { return reads_several(elements[e].invariant) ? 0.0 : elements[e].reference; }, false);

  for (Group& group : compiled.groups) {
    group.first_rows = group.row_count();
    for (std::size_t c = 0; c < group.columns.size(); ++c) group.differs.push_back(group.is_same(c) ? 0 : 1);
  }

  // The default neuron that no node has may be ambiguous, or not exist.
  std::vector<bool> in_use(network.neurons().size(), false);
  for (const Node& node : network.nodes()) in_use[node.neuron] = true;
  for (std::size_t k = 0; k < in_use.size(); ++k) {
    compiled.neuron_number.push_back(static_cast<std::uint32_t>(compiled.neurons.size()));
    if (!in_use[k]) continue;
    const LawUse& use = network.neurons()[k];
    NeuronKind neuron;
    neuron.component = plugins.require(ComponentKind::neuron, use.id);
    if (neuron.component->description->parameter_count > max_parameters)
      throw Error(ErrorKind::plugin, fmt::format("neuron '{}' has more than {} parameters", use.id, max_parameters));
    neuron.parameters =
        complete_parameters(*neuron.component->description, use.parameters, fmt::format("neuron '{}'", use.id));
    static_cast<void>(complete_tables(*neuron.component->description, use.tables, fmt::format("neuron '{}'", use.id)));
    compiled.neurons.push_back(std::move(neuron));
  }
  return compiled;
}

bool CompiledLaws::on_one_thread() const noexcept {
  return std::any_of(groups.begin(), groups.end(),
                     [](const Group& each) { return each.can(SPRINGNET_CALLING_THREAD_ONLY); }) ||
         std::any_of(neurons.begin(), neurons.end(), [](const NeuronKind& neuron) {
           return (neuron.component->description->capabilities & SPRINGNET_CALLING_THREAD_ONLY) != 0;
         });
}

springnet_status require_derivatives(const Component& component, springnet_message& message) {
  const bool several = component.kind() != ComponentKind::neuron && component.law().invariant == SPRINGNET_SEVERAL;
  const std::uint64_t needed = several ? SPRINGNET_HAS_ALL_DERIVATIVES : SPRINGNET_HAS_DERIVATIVES;
  if ((component.description->capabilities & needed) != 0) return SPRINGNET_OK;
  const char* header = component.kind() == ComponentKind::neuron ? "neuron" : "law";
  set_message(message, fmt::format("{} '{}' offers no derivatives, which implicit methods need; write it with "
                                   "springnet/sdk/{}.hpp, or choose an explicit method",
                                   name_of(component.kind()), component.id(), header));
  return SPRINGNET_FAILED;
}

}  // namespace springnet::layers
