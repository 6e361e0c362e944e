// What several commands share: the scene and its changes, plugins, the place of the output.
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <springnet/error.hpp>
#include <springnet/events.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>

namespace springnet::tool {

enum ExitStatus { done = 0, failed = 1, wrong_usage = 2, plugin_trouble = 3 };
[[nodiscard]] ExitStatus status_of(ErrorKind kind) noexcept;

// "springnet: error: …" on stderr.
void print_error(std::string_view message);

// For options that take a number; says nothing in the help.
[[nodiscard]] CLI::Validator number_between(double smallest, double largest);
inline constexpr double above_zero = std::numeric_limits<double>::min();
inline constexpr double finite = std::numeric_limits<double>::max();

// "16 nodes touched a surface, 2 springs cut", or "none".
[[nodiscard]] std::string describe(const EventCounts& events);

struct PluginArguments {
  std::vector<std::filesystem::path> folders;

  void add_to(CLI::App& command);
  [[nodiscard]] std::shared_ptr<const PluginHost> load() const;
  // A sentence for each of the folders that holds no plugin.
  [[nodiscard]] std::vector<std::string> empty_folders() const;
  // These; then what was looked at and not taken, where it may matter to the run: what --plugins names cannot be used,
  // or a component of the scene, or the integrator named, would be another one if the folders were searched in another
  // order. The rest are counted.
  [[nodiscard]] std::vector<std::string> notes(const PluginHost& host, const Scene& scene,
                                               std::string_view integrator = {}) const;

 private:
  [[nodiscard]] bool matters(const Refusal& refusal, const PluginHost& host, const Scene& scene,
                             std::string_view integrator) const;
};

struct SceneArguments {
  std::filesystem::path file;
  std::vector<std::string> sets;
  std::optional<std::string> integrator;  // else the scene's
  std::optional<double> time_step;        // s; else the scene's
  std::optional<double> duration;         // s; else the scene's
  std::optional<unsigned> threads;        // else the scene's
  bool allow_outside = false;             // files that the scene names, outside of its folder
  PluginArguments plugins;

  // --set, --allow-outside and --plugins; `simulation`: --integrator, --time-step, --duration and --threads as well.
  void add_to(CLI::App& command, bool simulation);
  [[nodiscard]] Scene load(const PluginHost& host) const;
};

struct OutputArguments {
  std::filesystem::path folder;
  bool json = false;
  bool quiet = false;

  void add_to(CLI::App& command);
  // The folder given, else results/<name of the scene>.
  [[nodiscard]] std::filesystem::path folder_for(const std::filesystem::path& scene) const;
  [[nodiscard]] bool silent() const noexcept { return json || quiet; }
};

// Text for a reader who may have seen enough: where stdout is a pipe that nobody reads any more (| head), the rest is
// left out, which is no failure. Names and foreign texts in it are made printable.
void print_report(std::string_view report);

}  // namespace springnet::tool
