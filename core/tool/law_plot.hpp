// 'springnet plugin show … --plot': curves of laws, to a file.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <springnet/plugin_host.hpp>

#include "common.hpp"

namespace springnet::tool {

struct PlotArguments {
  std::filesystem::path file;     // .svg or .html
  std::vector<std::string> sets;  // "stiffness=3"; of a scene: overrides
  std::string range;              // "0.5:2"; empty: that of the law
  double reference = 1.0, period = 1.0;

  void add_to(CLI::App& command);
};

// The laws among these components, with parameters, and inputs, as given. Returns the notes to print.
[[nodiscard]] std::vector<std::string> plot_components(const std::vector<std::shared_ptr<const Component>>& components,
                                                       const PlotArguments& arguments);
// All laws of a scene's materials.
[[nodiscard]] std::vector<std::string> plot_scene(const std::filesystem::path& scene, const PluginHost& host,
                                                  const PlotArguments& arguments);

}  // namespace springnet::tool
