// Words in place of numbers: a rule base turns them into numbers before the scene is interpreted.
#pragma once

#include <string_view>
#include <vector>

#include <toml++/toml.h>
#include <springnet/plugin_host.hpp>
#include <springnet/scene_guesses.hpp>

#include "scene/files.hpp"

namespace springnet::scene {

// Replaces the words of the document by numbers, each at its place: in body.material the inputs of the rule base by the
// constants that the rules give and the scene does not, and by the body's density; elsewhere a term where a key has the
// name of an output. Throws Error(input) at a word that is no term. Without plugins (null) the units of their
// parameters are not known.
std::vector<SceneGuess> replace_words(toml::table& root, std::string_view document, const Files& files,
                                      const PluginHost* plugins);

}  // namespace springnet::scene
