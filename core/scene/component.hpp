// Uses of components in a scene: { type = "linear", stiffness = 3.0 }, checked against the plugin's own description.
#pragma once

#include <optional>
#include <string_view>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "scene/files.hpp"
#include "scene/reader.hpp"

namespace springnet::scene {

// `name_key` is the key of the component's id, "type" or "name". Other keys of the schema are left to the caller; every
// key not in the schema is a parameter or a table. Parameters in `supplied` come from elsewhere: the component must
// have them, the table must not.
[[nodiscard]] LawUse read_component(const Table& table, std::string_view name_key, ComponentKind kind,
                                    const PluginHost& plugins, const Files& files,
                                    const ParameterValues& supplied = {});

// A component given by its name only.
[[nodiscard]] LawUse read_component_name(const Value& name, ComponentKind kind, const PluginHost& plugins,
                                         const ParameterValues& supplied = {});

// The functions under the keys `spring` and `viscosity` of a table; both are optional.
[[nodiscard]] Material read_material(const Table& table, const PluginHost& plugins, const Files& files);

}  // namespace springnet::scene
