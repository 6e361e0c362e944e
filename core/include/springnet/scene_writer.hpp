// A scene as a text that load_scene() reads back: for networks built by a program, and for the present state of a
// simulation (Simulation::present_network()).
//
//   springnet::Scene scene;
//   scene.network = simulation.present_network();
//   scene.duration = 2.0;
//   scene.options.time_step = simulation.time_step();
//   springnet::write_scene(scene, *plugins, "present.toml");
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>

namespace springnet {

// Title, settings of the simulation, outputs and the network, with all numbers bit for bit: what is read back has the
// same nodes, springs, elements, faces, laws, loads, motions, surfaces, cuts and inputs under the same numbers, so that
// a simulation of it has the same bits. Bodies list their nodes and springs, whatever mesh they came from, so that
// elements of bodies become [[element]], and springs that follow the first one of no body become [[connect]]; nodes of
// no body get one. `plugins` has the laws' components, for the names of their options. Throws Error(input) that names
// what a scene cannot say: faces with nodes of two bodies, components that no plugin offers, a text of more than 64 MB.
[[nodiscard]] SPRINGNET_API std::string to_scene(const Scene& scene, const PluginHost& plugins);

// A file that a scene reads.
struct SceneTable {
  std::string name;  // in the scene's folder
  std::string text;
};
struct SceneWithTables {
  std::string scene;
  std::vector<SceneTable> tables;
};
// The same with the numbers of laws in files where more than eight materials differ in them alone:
// "learned_springs.csv" for the stem "learned", with a row for each spring, and "learned_elements.csv".
[[nodiscard]] SPRINGNET_API SceneWithTables to_scene_with_tables(const Scene& scene, const PluginHost& plugins,
                                                                 const std::string& stem);
// As to_scene(), to a file, which is written beside it and takes its place once it is whole. Throws Error(input) that
// names the file, too.
SPRINGNET_API void write_scene(const Scene& scene, const PluginHost& plugins, const std::filesystem::path& file);

}  // namespace springnet
