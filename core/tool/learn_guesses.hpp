// Words of a scene as what `springnet learn` knows beforehand, and what it learns of them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <springnet/guessed_values.hpp>

#include "common.hpp"

namespace springnet::tool {

// Null for a scene without words, or from a pipe, which is read once.
[[nodiscard]] std::unique_ptr<const GuessedValues> guesses_of(const SceneArguments& scene,
                                                              const std::shared_ptr<const PluginHost>& host,
                                                              const std::vector<Learnable>& learnables);

struct CorrectedRules {
  // The rule base with terms that would have guessed what was learned; empty if no learned value tells that.
  std::string fcl;
  std::vector<std::string> notes;  // one for each guess, or why there is none
};
[[nodiscard]] CorrectedRules corrected_rules(const GuessedValues& guesses, const LearnedNet& learned,
                                             const SceneArguments& scene);

}  // namespace springnet::tool
