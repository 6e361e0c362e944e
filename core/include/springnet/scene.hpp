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

struct OutputOptions {
  double interval = 0.0;  // s between records; 0: every time step
  bool trajectory = true;
  bool reactions = false;   // reactions.csv
  bool surfaces = true;     // surfaces.csv, if there are planes or instruments
  bool rigid = true;        // rigid.csv, if there are rigid connections
  bool view = true;         // view.html
  double view_size = 16e6;  // bytes that view.html should not exceed
};

struct Scene {
  std::string title;
  double duration = 0.0;  // s
  Network network;
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

// Throws Error(input) that says "file:line:column: key: what; what to do", also for a component that no plugin offers:
// the message then has the nearest names and the plugins that were not taken.
[[nodiscard]] Scene load_scene(const std::filesystem::path& file, const PluginHost& plugins,
                               const std::vector<SceneOverride>& overrides = {});
// The same from text; `name` stands for the file in messages.
[[nodiscard]] Scene parse_scene(std::string_view text, std::string_view name, const PluginHost& plugins,
                                const std::vector<SceneOverride>& overrides = {});

// What in a scene is likely not meant: cuts, loads and motions wholly outside of the simulated time. Plain sentences.
[[nodiscard]] std::vector<std::string> notes_of(const Scene& scene);

// Every key a scene may have, as "body.mesh.lattice": the reference page is checked against it.
[[nodiscard]] const std::vector<std::string>& scene_keys();

}  // namespace springnet
