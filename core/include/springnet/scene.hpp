// Scene files: TOML, strict. core/docs/scene.md describes every key.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

// What a run records. core/docs/output.md describes the files.
struct OutputOptions {
  enum class Format { csv, binary };
  // Numbers of binary files and pictures: as the engine has them, or with half the size and seven digits.
  enum class Precision { float64, float32 };

  double interval = 0.0;  // s between records; 0: every time step
  bool trajectory = true;
  bool reactions = false;                     // if nodes are held
  bool surfaces = true;                       // if there are planes or instruments
  bool rigid = true;                          // if there are rigid connections
  bool elements = true;                       // if there are any
  std::vector<NodeIndex> nodes;               // of trajectory and reactions, rising; empty: all
  std::vector<SpringIndex> springs;           // whose forces are recorded, rising; empty: none
  std::vector<ElementIndex> element_numbers;  // of the elements recorded, rising; empty: all
  // Columns of the trajectory.
  bool position = true;
  bool velocity = true;
  bool force = false;
  Format format = Format::csv;  // of trajectory, springs and elements
  Precision precision = Precision::float64;
  bool vtk = false;           // pictures for ParaView
  double vtk_interval = 0.0;  // s between them at least; 0: at every record
  bool view = true;           // view.html
  double view_size = 16e6;    // bytes that view.html should not exceed
};

// The elements of one [[element]], in a row.
struct ElementSet {
  std::string name;  // may be empty
  ElementIndex first;
  ElementIndex count;
};

struct Scene {
  std::string title;
  double duration = 0.0;  // s
  Network network;
  std::vector<ElementSet> elements;
  std::vector<std::string> surfaces;  // where planes, then instruments, stand: "file:line:column: plane.0"
  std::vector<std::string> notes;     // of reading: what a mesh has and this does not, what a material becomes
  SimulationOptions options;
  OutputOptions output;
};

// "simulation.time_step=0.01": replaces or adds a key before the scene is read; the value is TOML.
struct SceneOverride {
  std::string key;
  std::string value;
};
// Throws Error(input) if the text has no '=' or no key.
[[nodiscard]] SceneOverride parse_override(std::string_view text);

// Whether a scene may name files that lie, after following links, outside of its folder. Allow it for scenes that you
// trust as much as a program.
enum class OutsideFiles { refused, allowed };

// Throws Error(input) that says "file:line:column: key: what; what to do", also for a component that no plugin offers:
// the message then has the nearest names and the plugins that were not taken. Reads a file, a pipe or a device, at most
// 64 MB of it; files that the scene names are looked for in its folder.
[[nodiscard]] Scene load_scene(const std::filesystem::path& file, const PluginHost& plugins,
                               const std::vector<SceneOverride>& overrides = {},
                               OutsideFiles outside = OutsideFiles::refused);
// The same from text; `name` stands for the file in messages, and `folder` for the scene's folder. Where that is empty,
// a scene that names a file is an error, unless outside files are allowed and the path is absolute.
[[nodiscard]] Scene parse_scene(std::string_view text, std::string_view name, const PluginHost& plugins,
                                const std::vector<SceneOverride>& overrides = {},
                                const std::filesystem::path& folder = {}, OutsideFiles outside = OutsideFiles::refused);

// Scene::notes, and what is likely not meant: cuts, loads and motions wholly outside of the simulated time. Plain
// sentences.
[[nodiscard]] std::vector<std::string> notes_of(const Scene& scene);

// Throws Error(input), with the place in the scene, if a node starts behind a plane or inside an instrument by more
// than rounding. A Simulation refuses such a network too, but does not know the scene.
void check_starts(const Scene& scene);

// Every key a scene may have, as "body.mesh.lattice": the reference page is checked against it.
[[nodiscard]] const std::vector<std::string>& scene_keys();

}  // namespace springnet
