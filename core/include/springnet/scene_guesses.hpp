// The numbers of a scene that words stand for: for programs that show how a guess comes about.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/fuzzy.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>

namespace springnet {

// A number with its place in the scene.
struct SceneGuess {
  std::string key;    // where the number stands: "body.0.material.youngs_modulus", "body.0.density"
  std::string words;  // what the scene says instead, as far as rules that apply read it: "feel = soft, like = liver"
  double value = 0.0;
  std::string unit;  // of the value, SI; empty: none, or not known
  // The guess's standard deviation: of the value, or of its decimal logarithm.
  double width = 0.0;
  bool is_logarithmic = false;
  std::shared_ptr<const fuzzy::RuleBase> rules;
  std::string rules_name;  // the file as the scene names it, or "soft_tissue.fcl", which comes with springnet
  std::size_t output = 0;  // whose guess it is
  fuzzy::Guess number;     // the output's, whose decimal logarithm the value may be, with the rules that gave it
  fuzzy::Inputs inputs;
  std::optional<std::size_t> term;  // if the words are a term of the output itself, which no rule concludes
};

// In the order of the scene. Throws Error(input) as load_scene() does for what it reads of a scene: words and rules
// alone. The units of components' parameters are those of `plugins`, unknown without them.
[[nodiscard]] SPRINGNET_API std::vector<SceneGuess> find_guesses(const std::filesystem::path& file,
                                                                 const std::vector<SceneOverride>& overrides = {},
                                                                 OutsideFiles outside = OutsideFiles::refused,
                                                                 const PluginHost* plugins = nullptr);

// "4920 Pa (to a factor of 1.6)", "1079 kg/m^3 (+- 20)".
[[nodiscard]] SPRINGNET_API std::string text_of(const SceneGuess& guess);
// What Scene::notes say of it, once for the same words.
[[nodiscard]] SPRINGNET_API std::string note_of(const SceneGuess& guess);

}  // namespace springnet
