// Scenes that several tests start from.
#pragma once

#include <string>

#include <springnet/error.hpp>
#include <springnet/scene.hpp>

// The components that come with springnet.
inline const springnet::PluginHost& plugins() {
  static const springnet::PluginHost host = springnet::PluginHost::with_default_search();
  return host;
}

// Meshes are those of this folder: bar.msh, 100 x 20 x 20 mm, of tetrahedra, with the groups left, right (x 0 and 100),
// skin and tissue.
inline springnet::Scene parse(const std::string& text, const std::vector<springnet::SceneOverride>& overrides = {}) {
  return springnet::parse_scene(text, "test.toml", plugins(), overrides, SCENE_FOLDER);
}

// The message of the Error(input) with which the scene is refused, "" if it is taken.
inline std::string refusal(const std::string& text, const std::vector<springnet::SceneOverride>& overrides = {}) {
  try {
    static_cast<void>(parse(text, overrides));
  } catch (const springnet::Error& error) {
    return error.kind() == springnet::ErrorKind::input ? error.what()
                                                       : std::string("not an error of input: ") + error.what();
  }
  return {};
}

inline const std::string simulation = R"([simulation]
duration = 1.0
time_step = 0.1
)";

// 27 nodes, 54 springs; eight lines of text before what a test adds.
inline const std::string small = R"([simulation]
duration = 1.0
time_step = 0.1
[[body]]
name = "a"
mesh = { lattice = [3, 3, 3], spacing = 1.0 }
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "linear", stiffness = 3.0 }
)";
