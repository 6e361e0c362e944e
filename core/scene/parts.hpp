// Readers of the parts of a scene, in the order in which they are called.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include <springnet/mesh.hpp>
#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>

#include "scene/files.hpp"
#include "scene/reader.hpp"

namespace springnet::scene {

// The source of a body's cells: a mesh, a lattice, or neither.
using Shape = std::variant<std::monostate, Mesh, Lattice>;

// Each takes the whole document and throws Error(input) with the place of the mistake.

// [[body]]. Returns the shape of each.
[[nodiscard]] std::vector<Shape> read_bodies(const Table& root, const PluginHost& plugins, const Files& files,
                                             Scene& scene);
// body.mesh.start: moves nodes to their start positions, after all rest lengths have been taken.
void read_starts(const Table& root, const Files& files, Network& network);
// [[element]]
void read_elements(const Table& root, const PluginHost& plugins, const Files& files, const std::vector<Shape>& shapes,
                   Scene& scene);
void read_connections(const Table& root, const PluginHost& plugins, const Files& files,
                      Scene& scene);  // [[connect]], [[rigid]]
// [[node]], [[spring]], [[fix]], [[force]], [[cut]]
void read_changes(const Table& root, const PluginHost& plugins, const Files& files, const std::vector<Shape>& shapes,
                  Scene& scene);
void read_loads(const Table& root, const std::vector<Shape>& shapes, Scene& scene);  // [[force]]
// [[move]], [[plane]], [[instrument]]
void read_surroundings(const Table& root, Scene& scene);
// [[move]] with the key tracks: places of nodes, so it is read when these are where they start.
void read_tracks(const Table& root, const Files& files, Network& network);
// [[input]], after all springs and elements have their laws.
void read_inputs(const Table& root, const PluginHost& plugins, const Files& files, Scene& scene);
// [[change]], likewise.
void read_timed_changes(const Table& root, const PluginHost& plugins, const Files& files, Scene& scene);
// [output], read last: its selections refer to the whole network and all elements.
void read_output(const Table& root, const PluginHost& plugins, Scene& scene);

}  // namespace springnet::scene
