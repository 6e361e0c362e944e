// 'springnet plugin show … --plot' and '--at': curves of laws, to a file, and their values at some places.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <springnet/plugin_host.hpp>

#include "common.hpp"
#include "law_caller.hpp"

namespace springnet::tool {

struct PlotArguments {
  std::filesystem::path file;     // .svg or .html
  std::vector<std::string> sets;  // "stiffness=3"; of a scene: overrides
  std::string range;              // "0.5:2"; empty: that of the law
  double reference = 1.0, period = 1.0;
  std::vector<double> at;  // lengths, m, …; empty: no values are asked for
  double rate = 0.0;       // there

  void add_to(CLI::App& command);
};

// A law with what it is called with, but for its references.
struct ShownLaw {
  std::shared_ptr<const Component> component;
  std::string title;
  std::vector<std::string> notes;
  LawSetting setting;
  double reference;  // m, rad, m^2, m^3
};
struct ShownScene {
  std::string title;
  std::vector<ShownLaw> laws;
  std::size_t left_out = 0;  // further laws
};
// The laws among these components, with parameters, and inputs, as given.
[[nodiscard]] std::vector<ShownLaw> laws_of_components(const std::vector<std::shared_ptr<const Component>>& components,
                                                       const PlotArguments& arguments);
// All laws of a scene's materials.
[[nodiscard]] ShownScene laws_of_scene(const std::filesystem::path& scene, const PluginHost& host,
                                       const PlotArguments& arguments);

void plot_components(const std::vector<std::shared_ptr<const Component>>& components, const PlotArguments& arguments);
// Returns the notes to print.
[[nodiscard]] std::vector<std::string> plot_scene(const std::filesystem::path& scene, const PluginHost& host,
                                                  const PlotArguments& arguments);

// A table of each law's answers at the places asked for. Throws Error(input) if a table of the law is refused.
[[nodiscard]] std::string values_text(const std::vector<ShownLaw>& laws, const PlotArguments& arguments);
[[nodiscard]] nlohmann::ordered_json values_json(const std::vector<ShownLaw>& laws, const PlotArguments& arguments);

}  // namespace springnet::tool
