#include "layers/input_sets.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "plugin_host/law_use.hpp"

namespace springnet::layers {
namespace {

// Calls what(component) for the laws of a material.
template <class What>
void for_laws(const Material& material, const PluginHost& plugins, const What& what) {
  if (material.spring) what(component_of(*material.spring, ComponentKind::spring_function, plugins));
  if (material.viscosity) what(component_of(*material.viscosity, ComponentKind::viscosity_function, plugins));
}

const springnet_parameter* find_input(const Component& component, std::string_view name) {
  const springnet_law& law = component.law();
  for (std::uint32_t k = 0; k < law.input_count; ++k)
    if (law.inputs[k]->name == name) return law.inputs[k];
  return nullptr;
}

std::string description_of(const Input& input) {
  return input.name.empty() ? fmt::format("the signal for the input '{}'", printable(input.input))
                            : fmt::format("the input signal '{}'", printable(input.name));
}

std::set<MaterialIndex> materials_of(const Network& network, const Input& input) {
  std::set<MaterialIndex> materials;
  const Column<MaterialIndex>& of_springs = network.springs().materials();
  MaterialIndex last = 0;
  for (const SpringIndex spring : input.springs) {
    if (materials.empty() || of_springs[spring] != last) materials.insert(last = of_springs[spring]);
  }
  for (const ElementIndex element : input.elements) materials.insert(network.elements()[element].material);
  return materials;
}

[[noreturn]] void refuse_unread(const Input& input, const std::set<std::string>& known) {
  const std::vector<std::string> names(known.begin(), known.end());
  const std::string nearest = suggestion(input.input, names);
  throw Error(ErrorKind::input,
              fmt::format("{}: no law of the springs and elements that it is for has an input '{}'; {}",
                          description_of(input), printable(input.input),
                          names.empty() ? std::string("none of them reads an input")
                                        : fmt::format("{}{}their inputs: {}", nearest, nearest.empty() ? "" : "; ",
                                                      fmt::join(names, ", "))));
}

}  // namespace

std::vector<bool> materials_reading(const Network& network, std::string_view input, const PluginHost& plugins) {
  std::vector<bool> reading;
  for (const Material& material : network.materials()) {
    bool reads = false;
    for_laws(material, plugins,
             [&](const std::shared_ptr<const Component>& law) { reads = reads || find_input(*law, input) != nullptr; });
    reading.push_back(reads);
  }
  return reading;
}

void check_input_value(const std::vector<InputReader>& readers, double value, std::string_view what) {
  for (const InputReader& reader : readers) {
    const std::string wrong = check_value(*reader.declared, value);
    if (wrong.empty()) continue;
    throw Error(ErrorKind::input,
                fmt::format("{} {} ({} '{}')", what, wrong, name_of(reader.law->kind()), reader.law->id()));
  }
}

std::vector<InputReader> find_readers(const Network& network, const Input& input, const PluginHost& plugins) {
  std::vector<InputReader> readers;
  std::set<std::string> known;
  for (const MaterialIndex material : materials_of(network, input)) {
    for_laws(network.materials()[material], plugins, [&](const std::shared_ptr<const Component>& law) {
      for (std::uint32_t k = 0; k < law->law().input_count; ++k) known.insert(law->law().inputs[k]->name);
      const springnet_parameter* const declared = find_input(*law, input.input);
      const bool is_new =
          std::none_of(readers.begin(), readers.end(), [&](const InputReader& reader) { return reader.law == law; });
      if (declared != nullptr && is_new) readers.push_back({law, declared});
    });
  }
  if (readers.empty()) refuse_unread(input, known);
  return readers;
}

std::vector<InputReader> readers_of(const Network& network, const Input& input, const PluginHost& plugins) {
  std::vector<InputReader> readers = find_readers(network, input, plugins);
  const Signal& signal = input.signal;
  const std::string what = description_of(input);
  for (std::size_t k = 0; k < signal.values.size(); ++k)  // between them the signal does not overshoot
    check_input_value(readers, signal.values[k], fmt::format("{}: entry {} of its table", what, k));
  if (!signal.values.empty()) return readers;
  const double swing = signal.frequency > 0.0 ? std::abs(signal.amplitude) : 0.0;
  check_input_value(readers, signal.mean - swing, fmt::format("{}: its {}value", what, swing > 0.0 ? "least " : ""));
  check_input_value(readers, signal.mean + swing, fmt::format("{}: its greatest value", what));
  return readers;
}

InputSets::InputSets(const Network& network, const PluginHost& plugins) : inputs_(network.inputs()) {
  if (inputs_.empty()) {
    springs_.append(network.springs().size(), 0);
    elements_.append(network.elements().size(), 0);
    return;
  }
  std::vector<std::uint32_t> of_spring(network.springs().size()), of_element(network.elements().size());
  std::map<std::pair<std::uint32_t, InputIndex>, std::uint32_t> known;
  std::map<std::string, std::vector<bool>> reading;  // [name of the input][material]
  for (InputIndex k = 0; k < inputs_.size(); ++k) {
    const auto [found, first] = reading.try_emplace(inputs_[k].input);
    if (first) found->second = materials_reading(network, inputs_[k].input, plugins);
    // Signals that no law of a member reads are left out: sets that differ by them would split rows.
    const auto add = [&, &reads = found->second](std::uint32_t& set, MaterialIndex material) {
      if (!reads[material]) return;
      const auto [place, is_new] = known.try_emplace({set, k}, static_cast<std::uint32_t>(sets_.size()));
      if (is_new) {
        std::vector<InputIndex> signals;
        for (const InputIndex each : sets_[set])
          if (inputs_[each].input != inputs_[k].input) signals.push_back(each);  // the last one counts
        signals.push_back(k);
        sets_.push_back(std::move(signals));
      }
      set = place->second;
    };
    for (const SpringIndex spring : inputs_[k].springs) add(of_spring[spring], network.springs().materials()[spring]);
    for (const ElementIndex element : inputs_[k].elements)
      add(of_element[element], network.elements()[element].material);
  }
  const std::vector<std::uint32_t> numbers = numbers_of_equal_sets();
  for (const std::uint32_t set : of_spring) springs_.push_back(numbers[set]);
  for (const std::uint32_t set : of_element) elements_.push_back(numbers[set]);
}

// Signals that were overridden on the way leave several sets that end alike.
std::vector<std::uint32_t> InputSets::numbers_of_equal_sets() const {
  std::vector<std::uint32_t> numbers;
  std::map<std::vector<InputIndex>, std::uint32_t> first;
  for (std::vector<InputIndex> set : sets_) {
    std::sort(set.begin(), set.end());
    numbers.push_back(first.try_emplace(std::move(set), static_cast<std::uint32_t>(numbers.size())).first->second);
  }
  return numbers;
}

std::uint32_t InputSets::signal(std::uint32_t set, std::string_view input) const {
  const std::vector<InputIndex>& signals = sets_[set];
  const auto found =
      std::find_if(signals.begin(), signals.end(), [&](InputIndex each) { return inputs_[each].input == input; });
  return found == signals.end() ? none : *found;
}

}  // namespace springnet::layers
