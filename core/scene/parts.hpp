// The parts of a scene that make its network, in the order in which they are read.
#pragma once

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>

#include "scene/reader.hpp"

namespace springnet::scene {

// Each takes the whole document, and throws Error(input) with the place of what is wrong.
void read_bodies(const Table& root, const PluginHost& plugins, Network& network);       // [[body]]
void read_connections(const Table& root, const PluginHost& plugins, Network& network);  // [[connect]], [[rigid]]
// [[node]], [[spring]], [[fix]], [[force]], [[cut]]
void read_changes(const Table& root, const PluginHost& plugins, Network& network);
void read_surroundings(const Table& root, Network& network);  // [[move]], [[plane]], [[instrument]]
// [output], whose selections see the whole network.
void read_output(const Table& root, const Network& network, OutputOptions& output);

}  // namespace springnet::scene
