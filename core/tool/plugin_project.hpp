// The files of a new plugin: a project of its own, with a test.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <springnet/formula.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet::tool {

struct PluginProject {
  std::string name;  // of the component, the files and the target of CMake
  ComponentKind kind = ComponentKind::spring_function;
  std::optional<LawFormula> formula;  // of a law; none: one to begin with
  // Of the scene.
  ParameterValues values;    // of the law's parameters
  double value = 1.0;        // of those that have none there
  double rest = 1.0;         // m, length of springs
  double mass = 0.01;        // kg, of a node
  double time_step = 0.002;  // s
};

struct ProjectFile {
  std::string name, text;
};

[[nodiscard]] bool is_law(const PluginProject& project);
// Of a law: that of the project, or the one to begin with.
[[nodiscard]] LawFormula law_of(const PluginProject& project);

// Throws Error(input) for a formula that cannot be translated.
[[nodiscard]] std::vector<ProjectFile> files_of(const PluginProject& project);

// plugin_source.cpp: the class of a law.
[[nodiscard]] std::string law_source(const PluginProject& project, const std::string& type);
// Without comments, in one line: characters of the language alone, which no text has to escape.
[[nodiscard]] std::string in_one_line(std::string_view formula);

// plugin_scene.cpp: the scene.
[[nodiscard]] std::string scene_of(const PluginProject& project);
// The same without the plugin: with the formula in its place.
[[nodiscard]] std::string scene_with_formula(const PluginProject& project);
// In the use of a law, what says that it is the plugin's, and what says it of the formula in its place; the same of the
// points of curves, which may be empty.
struct LawInScene {
  std::string type, tables;
};
[[nodiscard]] LawInScene plugin_in_scene(const PluginProject& project);
[[nodiscard]] LawInScene formula_in_scene(const PluginProject& project);

}  // namespace springnet::tool
