// The files of a new plugin: a project of its own, with a test.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <springnet/plugin_host.hpp>

namespace springnet::tool {

// Of a parameter of a formula.
struct GivenValue {
  double number = 0.0;
  std::string unit;  // SI; empty: not said
};

struct PluginProject {
  std::string name;  // of the component, the files and the target of CMake
  ComponentKind kind = ComponentKind::spring_function;
  std::string formula;                      // of a law; empty: one to begin with
  std::map<std::string, GivenValue> given;  // of parameters of the formula
  std::string value = "1.0";                // of the others, in the scene
};

struct ProjectFile {
  std::string name, text;
};

// Throws Error(input) for a formula that cannot be translated, values of what it does not read, units that do not fit.
[[nodiscard]] std::vector<ProjectFile> files_of(const PluginProject& project);

// The scene of a law without its plugin: with the formula in its place.
[[nodiscard]] std::string scene_with_formula(const PluginProject& project);

}  // namespace springnet::tool
