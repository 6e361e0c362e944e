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
#include <springnet/scene.hpp>

namespace springnet {

// A number with its place in the scene.
struct SceneGuess {
  std::string key;    // where the number stands: "body.0.material.youngs_modulus", "body.0.density"
  std::string words;  // what the scene says instead: "feel = soft, like = liver"
  double value = 0.0;
  // The guess's standard deviation: of the value, or of its decimal logarithm.
  double width = 0.0;
  bool is_logarithmic = false;
  std::shared_ptr<const fuzzy::RuleBase> rules;
  std::string rules_name;  // the file as the scene names it, or "soft_tissue.fcl", which comes with springnet
  std::size_t output = 0;  // whose guess it is
  fuzzy::Inputs inputs;
  std::optional<std::size_t> term;  // if the words are a term of the output itself, which no rule concludes
};

// In the order of the scene. Throws Error(input) as load_scene() does for what it reads of a scene: words and rules
// alone.
[[nodiscard]] SPRINGNET_API std::vector<SceneGuess> find_guesses(const std::filesystem::path& file,
                                                                 const std::vector<SceneOverride>& overrides = {},
                                                                 OutsideFiles outside = OutsideFiles::refused);

// "4,920 (to a factor of 1.6)", "1079 (+- 20)".
[[nodiscard]] SPRINGNET_API std::string text_of(const SceneGuess& guess);

}  // namespace springnet
