// Scene files: TOML, strict. core/docs/scene.md describes every key.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/loading.hpp>
#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

// The internal states of a law.
struct LawStates {
  ComponentKind kind;  // spring function or viscosity function
  std::string law;
  std::vector<InternalState> states;
};
// Of the laws of the network's materials, those that have any.
[[nodiscard]] SPRINGNET_API std::vector<LawStates> find_law_states(const Network& network, const PluginHost& plugins);

// Outputs of a run. core/docs/output.md describes the files.
struct OutputOptions {
  enum class Format { csv, binary };
  // Numbers in binary files and VTK files: double precision, or half the size with seven digits.
  enum class Precision { float64, float32 };

  double interval = 0.0;  // s between records; 0: every time step
  bool trajectory = true;
  bool reactions = false;                     // if nodes are held
  bool surfaces = true;                       // if there are planes or instruments
  bool rigid = true;                          // if there are rigid connections
  bool contacts = true;                       // of bodies with each other, if the scene has any
  bool elements = true;                       // if there are any
  bool energies = false;                      // of the whole, and what laws have dissipated
  bool states = false;                        // internal states of laws, of `springs` (empty: of all) and elements
  std::vector<NodeIndex> nodes;               // of trajectory and reactions, ascending; empty: all
  std::vector<SpringIndex> springs;           // whose forces are recorded, ascending; empty: none
  std::vector<ElementIndex> element_numbers;  // of the elements recorded, ascending; empty: all
  // Columns of the trajectory.
  bool position = true;
  bool velocity = true;
  bool force = false;
  Format format = Format::csv;  // of trajectory, springs and elements
  Precision precision = Precision::float64;
  bool vtk = false;           // files for ParaView
  double vtk_interval = 0.0;  // s, shortest interval; 0: at every record
  bool view = true;           // view.html
  double view_size = 16e6;    // bytes that view.html should not exceed
  // For estimates of sizes, and states in VTK files: laws of the network that have internal states. Scenes that are
  // read have it; for others see find_law_states().
  std::vector<LawStates> law_states;
};

// The elements of one [[element]], or of a body that consists of elements, consecutive.
struct ElementSet {
  enum class Of { table, body };
  std::string name;  // of the table, may be empty; or of the body
  ElementIndex first;
  ElementIndex count;
  Of of = Of::table;
};

struct Scene {
  std::string title;
  double duration = 0.0;  // s
  Network network;
  std::vector<ElementSet> elements;
  std::vector<std::string> surfaces;  // places of planes, then instruments: "file:line:column: plane.0"
  std::vector<std::string> contacts;  // likewise, of contacts of bodies
  std::vector<std::string> notes;     // from reading: what a mesh file has that is not used, properties of a material
  SimulationOptions options;
  OutputOptions output;
};

// "simulation.time_step=0.01": replaces or adds a key before the scene is read; the value is TOML.
struct SceneOverride {
  std::string key;
  std::string value;
};
// Throws Error(input) if the text has no '=' or no key.
[[nodiscard]] SPRINGNET_API SceneOverride parse_override(std::string_view text);

// Whether a scene may name files outside of its folder, links resolved. Allow it only for scenes that you trust like a
// program.
enum class OutsideFiles { refused, allowed };

// Reads a scene from a file, pipe or device of at most 64 MB. Files that the scene names are relative to its folder.
// Throws Error(input) with "file:line:column: key: what; what to do"; for a component that no plugin offers, with the
// nearest names and the plugins that were refused.
[[nodiscard]] SPRINGNET_API Scene load_scene(const std::filesystem::path& file, const PluginHost& plugins,
                                             const std::vector<SceneOverride>& overrides = {},
                                             OutsideFiles outside = OutsideFiles::refused,
                                             const LoadingCallback& loading = {});
// The same from text; `name` replaces the file in messages, `folder` is the scene's folder. If that is empty, a scene
// that names a file is an error, unless outside files are allowed and the path is absolute.
[[nodiscard]] SPRINGNET_API Scene parse_scene(std::string_view text, std::string_view name, const PluginHost& plugins,
                                              const std::vector<SceneOverride>& overrides = {},
                                              const std::filesystem::path& folder = {},
                                              OutsideFiles outside = OutsideFiles::refused,
                                              const LoadingCallback& loading = {});

// Scene::notes and likely mistakes, in plain sentences: cuts, loads and motions wholly outside of the simulated time.
[[nodiscard]] SPRINGNET_API std::vector<std::string> notes_of(const Scene& scene);

// Throws Error(input), with the place in the scene, if a node starts behind a plane or inside an instrument by more
// than rounding. A Simulation refuses such a network too, but does not know the scene.
SPRINGNET_API void check_starts(const Scene& scene);

// Every key a scene may have, as "body.mesh.lattice": the reference page is checked against it.
[[nodiscard]] SPRINGNET_API const std::vector<std::string>& scene_keys();

}  // namespace springnet
