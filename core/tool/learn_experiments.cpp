#include "learn_experiments.hpp"

#include <memory>
#include <utility>

#include <fmt/format.h>
#include <springnet/printable.hpp>

namespace springnet::tool {

Observations observations_of(const Scene& scene, const std::vector<std::filesystem::path>& files) {
  Observations result;
  for (const std::filesystem::path& file : files) result.append(read_observations(file));
  check_observations(result, scene.network.nodes().size(), 0.0, scene.duration);
  return result;
}

Experiment experiment_of(const Scene& scene, const std::vector<std::filesystem::path>& files) {
  Experiment result{std::make_shared<const Network>(scene.network), scene.options, observations_of(scene, files)};
  result.options.threads = 0;  // those of the scene are for all experiments
  return result;
}

SceneExperiment experiment_of(const std::string& text, const SceneArguments& first, const PluginHost& host) {
  const std::size_t sign = text.find('=');
  std::vector<std::filesystem::path> files;
  for (std::size_t begin = sign; begin != std::string::npos;) {
    const std::size_t end = text.find(',', begin + 1);
    files.emplace_back(text.substr(begin + 1, end == std::string::npos ? end : end - begin - 1));
    begin = end;
  }
  bool is_right = sign != std::string::npos && sign > 0;
  for (const std::filesystem::path& file : files) is_right = is_right && !file.empty();
  if (!is_right)
    throw Error(ErrorKind::input, fmt::format("--experiment {}: write SCENE=FILE or SCENE=FILE,FILE,…: a scene, and "
                                              "the tables of what was observed of it",
                                              printable(text)));
  SceneArguments arguments = first;
  arguments.file = text.substr(0, sign);
  Scene scene = arguments.load(host);
  Experiment experiment = experiment_of(scene, files);
  experiment.name = arguments.file.string();
  return {std::move(scene), std::move(experiment)};
}

}  // namespace springnet::tool
