// Values of springs or elements in a CSV file, a row for each of them.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "scene/files.hpp"
#include "scene/reader.hpp"

namespace springnet::scene {

// Names of the columns: the owner's number, its value at rest, and parameters of its laws, as spring.stiffness.
inline constexpr const char* spring_column = "spring";
inline constexpr const char* element_column = "element";
inline constexpr const char* rest_length_column = "rest_length";
inline constexpr const char* reference_column = "reference";
inline constexpr const char* spring_function_prefix = "spring.";
inline constexpr const char* viscosity_function_prefix = "viscosity.";

// Rows name springs by their numbers in the network. All of them must have what a column is of. Throws Error(input) at
// `file`, with the line, for a number that does not exist or is there twice, a column of nothing, a value out of
// bounds.
void read_spring_values(const Value& file, const PluginHost& plugins, const Files& files, Network& network);
// Of `count` elements that are to be added with this material, by their place among them.
struct ElementValues {
  std::vector<MaterialIndex> materials;           // [element]
  std::vector<std::optional<double>> references;  // [element]; none: as it would be
};
[[nodiscard]] ElementValues read_element_values(const Value& file, const PluginHost& plugins, const Files& files,
                                                std::size_t count, MaterialIndex material, Network& network);

}  // namespace springnet::scene
