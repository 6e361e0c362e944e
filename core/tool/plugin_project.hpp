// The files of a new plugin: a project of its own, with a test.
#pragma once

#include <string>
#include <vector>

#include <springnet/plugin_host.hpp>

namespace springnet::tool {

struct PluginProject {
  std::string name;  // of the component, the files and the target of CMake
  ComponentKind kind = ComponentKind::spring_function;
  std::string formula;        // of a law; empty: one to begin with
  std::string value = "1.0";  // of each parameter of the law, in the scene
};

struct ProjectFile {
  std::string name, text;
};

// Throws Error(input) for a formula that cannot be translated.
[[nodiscard]] std::vector<ProjectFile> files_of(const PluginProject& project);

// The scene of a law without its plugin: with the formula in its place.
[[nodiscard]] std::string scene_with_formula(const PluginProject& project);

}  // namespace springnet::tool
