// [[element]]: consecutive elements with the same invariant, material and inputs, set by set.
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "plugin_host/law_use.hpp"
#include "scene/value_tables.hpp"
#include "scene/writing.hpp"

namespace springnet::scene {
namespace {

using namespace toml_text;

bool reads_direction(const Material& material, const PluginHost& plugins) {
  const auto reads = [&](const std::optional<LawUse>& use, ComponentKind kind) {
    return use && component_of(*use, kind, plugins)->law().reads_direction != 0;
  };
  return reads(material.spring, ComponentKind::spring_function) ||
         reads(material.viscosity, ComponentKind::viscosity_function);
}

}  // namespace

WrittenElements::WrittenElements(const Scene& scene, const PluginHost& plugins, ValueFiles& values)
    : network_(scene.network), plugins_(plugins), values_(values) {
  const std::vector<Element>& elements = network_.elements();
  // Where a table has to begin: at a new set, and where the elements of an input or a change begin or end.
  std::set<ElementIndex> starts;
  std::map<ElementIndex, std::string> names;
  for (const ElementSet& set : scene.elements) {
    starts.insert({set.first, set.first + set.count});
    if (!set.name.empty()) names.emplace(set.first, set.name);
  }
  const auto apart = [&](const std::vector<ElementIndex>& list) {
    const std::set<ElementIndex> own(list.begin(), list.end());
    for (const ElementIndex e : own) {
      if (!own.contains(e - 1)) starts.insert(e);
      if (!own.contains(e + 1)) starts.insert(e + 1);
    }
  };
  for (const Input& input : network_.inputs()) apart(input.elements);
  for (const Change& change : network_.changes()) apart(change.elements);
  std::set<std::string> taken;
  for (const auto& [first, name] : names) taken.insert(name);
  for (ElementIndex e = 0; e < elements.size(); ++e) {
    const bool begins = e == 0 || starts.contains(e) || elements[e].invariant != elements[e - 1].invariant ||
                        values_.group_of(elements[e].material) != values_.group_of(elements[e - 1].material);
    if (!begins) {
      ++pieces_.back().count;
      continue;
    }
    std::string name;
    if (const auto given = names.find(e); given != names.end()) name = given->second;
    for (int k = 0; name.empty() || (!names.contains(e) && !taken.insert(name).second); ++k)
      name = k == 0 ? fmt::format("elements {}", e) : fmt::format("elements {} ({})", e, k);
    pieces_.push_back({e, 1, name});
  }
}

std::string WrittenElements::names_of(std::vector<ElementIndex> elements, std::string_view what) const {
  std::sort(elements.begin(), elements.end());
  std::vector<std::string> names;
  std::size_t found = 0;
  for (const Piece& piece : pieces_) {
    const auto first = std::lower_bound(elements.begin(), elements.end(), piece.first);
    const auto last = std::lower_bound(elements.begin(), elements.end(), piece.first + piece.count);
    if (first == last) continue;
    if (static_cast<ElementIndex>(last - first) < piece.count)
      throw Error(ErrorKind::input,
                  fmt::format("a scene cannot say this: {} has only some of the elements {} to {}; give them a set of "
                              "their own (Scene::elements)",
                              what, piece.first, piece.first + piece.count - 1));
    found += piece.count;
    names.push_back(in_quotes(piece.name));
  }
  if (found != elements.size())
    throw Error(ErrorKind::input, fmt::format("a scene cannot say this: {} has elements that do not exist", what));
  return list(names.size(), [&](std::size_t k) { return names[k]; });
}

void WrittenElements::write(Document& out) const {
  for (const Piece& piece : pieces_) {
    const auto each = [&](std::size_t k) -> const Element& { return network_.elements()[piece.first + k]; };
    const Element& first = each(0);
    const Material& material = network_.materials()[first.material];
    out.begin("[[element]]");
    out.add("name", in_quotes(piece.name));
    out.add("invariant", in_quotes(name_of(first.invariant)));
    out.add("nodes", list(piece.count, [&](std::size_t k) { return whole_numbers(each(k).nodes); }));
    write_material(material, plugins_, false, out);
    std::vector<ValueFiles::Row> rows;
    for (std::size_t k = 0; k < piece.count; ++k)
      if (each(k).material != first.material)
        rows.push_back({static_cast<std::uint32_t>(k), first.material, each(k).material});
    if (!rows.empty()) out.add("values", in_quotes(values_.add(element_column, rows)));
    const auto all = [&](const auto& holds) {
      for (std::size_t k = 0; k < piece.count; ++k)
        if (!holds(each(k))) return false;
      return true;
    };
    if (!reads_several(first.invariant)) {
      if (all([&](const Element& e) { return same_bits(e.reference, first.reference); }))
        out.add("reference", number(first.reference));
      else
        out.add("references", list(piece.count, [&](std::size_t k) { return number(each(k).reference); }));
      continue;
    }
    const auto at_rest = [&](const Element& e) {
      for (std::size_t i = 0; i < e.nodes.size(); ++i)
        if (!same_bits(e.rest[i], network_.nodes().positions()[e.nodes[i]])) return false;
      return true;
    };
    if (!all(at_rest)) out.add("rests", list(piece.count, [&](std::size_t k) { return vectors(each(k).rest); }));
    if (!reads_direction(material, plugins_)) continue;
    if (all([&](const Element& e) { return same_bits(e.direction, first.direction); })) {
      if (!first.direction.isZero(0.0)) out.add("direction", vector(first.direction));
    } else {
      out.add("directions", list(piece.count, [&](std::size_t k) { return vector(each(k).direction); }));
    }
  }
}

}  // namespace springnet::scene
