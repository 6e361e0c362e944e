// The laws of a scene that are given as formulas: for programs that show them, or make plugins of them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>

namespace springnet {

// A law with its place in the scene.
struct SceneFormula {
  std::string key;   // "body.0.spring", "body.0.material.law"
  LawUse law;        // formula_of(*law.component) (formula.hpp) has its texts, names and declarations
  double reference;  // rest length (m) or rest value of the first spring or element that has it; 0: none has
};

// In the order in which the scene is read. Throws as load_scene().
[[nodiscard]] SPRINGNET_API std::vector<SceneFormula> find_formulas(const std::filesystem::path& file,
                                                                    const PluginHost& plugins,
                                                                    const std::vector<SceneOverride>& overrides = {});

}  // namespace springnet
