// Words about components of plugins, as scenes and the tool use them.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <springnet/plugin_host.hpp>

namespace springnet::tool {

[[nodiscard]] bool is_law(const Component& component);
// Of laws; none of other components.
[[nodiscard]] std::vector<const springnet_parameter*> inputs_of(const Component& component);
[[nodiscard]] std::vector<const springnet_parameter*> states_of(const Component& component);
[[nodiscard]] std::vector<const springnet_parameter*> parameters_of(const Component& component);
[[nodiscard]] std::span<const springnet_table* const> tables_of(const Component& component);

// Makes texts of a plugin's author and file names printable.
[[nodiscard]] std::string shown(const char* text);
[[nodiscard]] std::string shown(const std::filesystem::path& path);

[[nodiscard]] bool required(const springnet_parameter& parameter);
// The default; of a required parameter its scale, within its bounds.
[[nodiscard]] double sample_value(const springnet_parameter& parameter);
// Of each table of a law, as few as it takes, around 0.
[[nodiscard]] std::vector<std::vector<double>> sample_tables(const Component& component);

// A parameter's value as in a scene.
[[nodiscard]] std::string value_text(const springnet_parameter& parameter, double value);
// The id, with the plugin's where several have one of the kind and id.
[[nodiscard]] std::string name_in_scenes(const PluginHost& host, const Component& component);
// A line of a scene that uses the component. Tables are columns of a file, or the sample's numbers.
enum class TablesAs { file, numbers };
[[nodiscard]] std::string scene_line(const Component& component, const std::string& name,
                                     TablesAs tables = TablesAs::file);

}  // namespace springnet::tool
