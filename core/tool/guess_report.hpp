// How the guesses of a scene come about: terms, rules, widths, as text, JSON and pictures.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <springnet/scene_guesses.hpp>

#include "figure/figure.hpp"

namespace springnet::tool {

// Lines for the terminal; empty if there are no guesses.
[[nodiscard]] std::string guesses_text(const std::vector<SceneGuess>& guesses);
[[nodiscard]] nlohmann::ordered_json guesses_json(const std::vector<SceneGuess>& guesses);
// A figure each: the membership functions of the inputs that are given, and of the output; what applies is drawn solid.
[[nodiscard]] std::vector<figure::Figure> guess_figures(const std::vector<SceneGuess>& guesses);

}  // namespace springnet::tool
