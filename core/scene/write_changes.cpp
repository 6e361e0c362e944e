// [[change]]
#include <algorithm>

#include <fmt/format.h>

#include "plugin_host/law_use.hpp"
#include "scene/writing.hpp"

namespace springnet::scene {
namespace {

using namespace toml_text;

// Calls what(component) for those of the laws that have it, until it returns true.
template <class What>
bool any_law(const Network& network, const Change& change, ComponentKind kind, const PluginHost& plugins,
             const What& what) {
  const auto of = [&](MaterialIndex index) {
    const Material& material = network.materials()[index];
    const std::optional<LawUse>& use = kind == ComponentKind::spring_function ? material.spring : material.viscosity;
    return use && what(*component_of(*use, kind, plugins));
  };
  return std::any_of(change.springs.begin(), change.springs.end(),
                     [&](SpringIndex s) { return of(network.springs().materials()[s]); }) ||
         std::any_of(change.elements.begin(), change.elements.end(),
                     [&](ElementIndex e) { return of(network.elements()[e].material); });
}

// A parameter as its component declares it: a choice by its name.
bool add_value(const Component& component, const std::string& name, double value, Inline& table) {
  for (std::uint32_t i = 0; i < component.description->parameter_count; ++i) {
    const springnet_parameter& declared = *component.description->parameters[i];
    if (name != declared.name) continue;
    table.add(name, text_of(declared, value));
    return true;
  }
  return false;
}

class Writer {
 public:
  Writer(const Network& network, const PluginHost& plugins, const WrittenElements& elements, Document& out)
      : network_(network), plugins_(plugins), elements_(elements), out_(out) {}

  void write(const Change& change) {
    if (change.remove) return write_removals(change);
    // A table has springs or elements, as what it selects.
    if (!change.springs.empty()) write_laws(change, change.springs, {});
    if (!change.elements.empty()) write_laws(change, {}, change.elements);
    if (!change.nodes.empty()) write_nodes(change);
    if (!change.integrator) return;
    begin(change);
    out_.add("integrator", text_of(*change.integrator, ComponentKind::integrator, plugins_, "name"));
  }

 private:
  void begin(const Change& change) {
    out_.begin("[[change]]");
    out_.add("time", number(change.time));
  }
  void select(const char* what, const std::vector<std::uint32_t>& numbers) {
    out_.add("select", Inline().add(what, whole_numbers(numbers)).text());
  }

  void write_removals(const Change& change) {
    const auto one = [&](const char* what, const std::vector<std::uint32_t>& list) {
      if (list.empty()) return;
      begin(change);
      select(what, list);
      out_.add("remove", in_quotes(what));
    };
    one("springs", change.springs);
    one("nodes", change.nodes);
    if (change.elements.empty()) return;
    begin(change);
    out_.add("elements", elements_.names_of(change.elements, "a change"));
    out_.add("remove", in_quotes("elements"));
  }

  void write_laws(const Change& change, const std::vector<SpringIndex>& springs,
                  const std::vector<ElementIndex>& elements) {
    Change part = change;
    part.springs = springs;
    part.elements = elements;
    std::vector<std::pair<const char*, std::string>> keys;
    const auto parameters = [&](const char* key, const ParameterValues& values, ComponentKind kind) {
      Inline table;
      bool any = false;
      for (const auto& [name, value] : values)
        any = any_law(network_, part, kind, plugins_,
                      [&](const Component& law) { return add_value(law, name, value, table); }) ||
              any;
      if (any) keys.emplace_back(key, table.text());
    };
    const auto inputs = [&](const char* key, const ParameterValues& values, ComponentKind kind) {
      Inline table;
      bool any = false;
      for (const auto& [name, value] : values) {
        const bool has = any_law(network_, part, kind, plugins_, [&](const Component& component) {
          const springnet_law& law = component.law();
          return std::any_of(law.inputs, law.inputs + law.input_count,
                             [&](const springnet_parameter* each) { return name == each->name; });
        });
        if (has) table.add(name, number(value));
        any = any || has;
      }
      if (any) keys.emplace_back(key, table.text());
    };
    parameters("spring", change.spring, ComponentKind::spring_function);
    parameters("viscosity", change.viscosity, ComponentKind::viscosity_function);
    inputs("inputs", change.spring_inputs, ComponentKind::spring_function);
    inputs("viscosity_inputs", change.viscosity_inputs, ComponentKind::viscosity_function);
    const bool of_springs = !springs.empty();
    if (change.reference) keys.emplace_back(of_springs ? "rest_length" : "reference", number(*change.reference));
    if (change.reference_scale)
      keys.emplace_back(of_springs ? "rest_length_scale" : "reference_scale", number(*change.reference_scale));
    if (keys.empty()) return;
    begin(change);
    if (of_springs)
      select("springs", springs);
    else
      out_.add("elements", elements_.names_of(elements, "a change"));
    for (const auto& [key, text] : keys) out_.add(key, text);
  }

  void write_nodes(const Change& change) {
    Inline table;
    bool any = false;
    for (const auto& [name, value] : change.neuron) {
      for (const NodeIndex node : change.nodes) {
        const LawUse& neuron = network_.neurons()[network_.nodes()[node].neuron];
        if (!add_value(*plugins_.require(ComponentKind::neuron, neuron.id), name, value, table)) continue;
        any = true;
        break;
      }
    }
    if (!any && !change.mass) return;
    begin(change);
    select("nodes", change.nodes);
    if (any) out_.add("neuron", table.text());
    if (change.mass) out_.add("mass", number(*change.mass));
  }

  const Network& network_;
  const PluginHost& plugins_;
  const WrittenElements& elements_;
  Document& out_;
};

}  // namespace

void write_changes(const Network& network, const PluginHost& plugins, const WrittenElements& elements, Document& out) {
  Writer writer(network, plugins, elements, out);
  for (const Change& change : network.changes()) writer.write(change);
}

}  // namespace springnet::scene
