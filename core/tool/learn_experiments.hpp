// The experiments of `springnet learn`: the scene itself, and those of --experiment.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <springnet/learn.hpp>
#include <springnet/scene.hpp>

#include "common.hpp"

namespace springnet::tool {

// Tables of a scene's motion. Throws Error(input) for observations that do not fit it.
[[nodiscard]] Observations observations_of(const Scene& scene, const std::vector<std::filesystem::path>& files);

// The scene with these tables.
[[nodiscard]] Experiment experiment_of(const Scene& scene, const std::vector<std::filesystem::path>& files);

struct SceneExperiment {
  Scene scene;
  Experiment experiment;
};

// "SCENE=FILE,FILE,…"; overrides of the first scene count for it, too. Throws Error(input) for other texts, for files
// that cannot be read or do not fit, and for a net with other nodes, springs or elements than the first.
[[nodiscard]] SceneExperiment experiment_of(const std::string& text, const SceneArguments& first,
                                            const PluginHost& host);

}  // namespace springnet::tool
