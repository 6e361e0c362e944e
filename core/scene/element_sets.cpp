#include "scene/element_sets.hpp"

#include <algorithm>
#include <set>
#include <string>

#include <fmt/format.h>

#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "scene/select.hpp"

namespace springnet::scene {
namespace {

const ElementSet& find_set(const Value& name, const std::vector<ElementSet>& sets) {
  const std::string wanted = name.text();
  const auto found = std::find_if(sets.begin(), sets.end(), [&](const ElementSet& set) { return set.name == wanted; });
  if (found != sets.end()) return *found;
  std::vector<std::string> known;
  for (const ElementSet& set : sets) {
    if (!set.name.empty()) known.push_back(set.name);
  }
  if (known.empty()) {
    name.fail(
        fmt::format("there is no [[element]] '{}': none has a name; give it one (element.name), or name a body that "
                    "consists of elements",
                    printable(wanted)));
  }
  const std::string nearest = suggestion(wanted, known);
  name.fail(fmt::format("there is no [[element]] '{}'{}{}; known: {}", printable(wanted), nearest.empty() ? "" : "; ",
                        nearest, list_of(known)));
}

}  // namespace

std::vector<ElementIndex> select_elements(const Value& names, const std::vector<ElementSet>& sets) {
  std::set<ElementIndex> numbers;
  for (const Value& name : names.elements()) {
    const ElementSet& set = find_set(name, sets);
    for (ElementIndex k = 0; k < set.count; ++k) numbers.insert(set.first + k);
  }
  return {numbers.begin(), numbers.end()};
}

}  // namespace springnet::scene
