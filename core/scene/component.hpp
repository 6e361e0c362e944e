// Uses of components in a scene: { type = "linear", stiffness = 3.0 }, checked against the plugin's own description.
#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "scene/files.hpp"
#include "scene/formula.hpp"
#include "scene/reader.hpp"

namespace springnet::scene {

// `name_key` is the key of the component's id, "type" or "name". Other keys of the schema are left to the caller; every
// key not in the schema is a parameter or a table. Parameters in `supplied` come from elsewhere: the component must
// have them, the table must not.
[[nodiscard]] LawUse read_component(const Table& table, std::string_view name_key, ComponentKind kind,
                                    const PluginHost& plugins, const Files& files,
                                    const ParameterValues& supplied = {});

// Throws Error(input) for values that the law itself refuses.
void check_use(const LawUse& use, const std::shared_ptr<const Component>& component);

// A component given by its name only.
[[nodiscard]] LawUse read_component_name(const Value& name, ComponentKind kind, const PluginHost& plugins,
                                         const ParameterValues& supplied = {});

// Parameters of components of a kind, or inputs of laws, in a table that has nothing else: {stiffness = 3.0}. Each key
// is one that some of them have, its value within the bounds of all of these.
enum class Named { parameters, inputs };
[[nodiscard]] ParameterValues read_values(const Table& table, Named what,
                                          const std::vector<std::shared_ptr<const Component>>& components);

// A law under the key of a table, by its name or as a formula, for springs, or for elements of an invariant, each of
// which is checked when it is known (ElementCheck). `given`: see read_formula().
[[nodiscard]] LawUse read_law(const Value& law, std::string_view schema, ComponentKind kind, const PluginHost& plugins,
                              const Files& files, std::optional<Invariant> elements = {},
                              const std::vector<MaterialParameter>& given = {});
// The functions under the keys `spring` and `viscosity` of a table; both are optional.
[[nodiscard]] Material read_material(const Table& table, const PluginHost& plugins, const Files& files,
                                     std::optional<Invariant> elements = {});

// Whether the laws of a material fit elements.
class ElementCheck {
 public:
  ElementCheck(const Material& material, const PluginHost& plugins);
  // Fails at this place if a law cannot be used on the element.
  void operator()(const Value& place, const Network& network, ElementIndex element) const;
  [[nodiscard]] bool reads_direction() const;

 private:
  std::vector<std::shared_ptr<const Component>> laws_;
};

}  // namespace springnet::scene
