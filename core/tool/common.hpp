// What several commands share: the scene and its overrides, plugins, the output folder.
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
#include <springnet/output_folder.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>

namespace springnet::tool {

enum ExitStatus { done = 0, failed = 1, wrong_usage = 2, plugin_trouble = 3 };
[[nodiscard]] ExitStatus status_of(ErrorKind kind) noexcept;

// "springnet: error: …" on stderr.
void print_error(std::string_view message);

// For options that take a number; adds nothing to the help.
[[nodiscard]] CLI::Validator number_between(double smallest, double largest);
inline constexpr double above_zero = std::numeric_limits<double>::min();
inline constexpr double finite = std::numeric_limits<double>::max();

// "16 nodes touched a surface, 2 springs cut", or "none".
[[nodiscard]] std::string describe(const EventCounts& events);

struct PluginArguments {
  std::vector<std::filesystem::path> folders;

  void add_to(CLI::App& command);
  [[nodiscard]] std::shared_ptr<const PluginHost> load() const;
  // A sentence for each folder without a plugin.
  [[nodiscard]] std::vector<std::string> empty_folders() const;
  // These, then folders that could not be searched, then refused plugin files that would provide a component of the
  // scene, or the given integrator, if the folders were searched in another order. Other files are counted in one note;
  // a single one in a folder of --plugins has its reason there.
  [[nodiscard]] std::vector<std::string> notes(const PluginHost& host, const Scene& scene,
                                               std::string_view integrator = {}) const;

 private:
  // Whether --plugins names the folder.
  [[nodiscard]] bool is_named(const std::filesystem::path& folder) const;
  [[nodiscard]] static bool would_matter(const Refusal& refusal, const PluginHost& host, const Scene& scene,
                                         std::string_view integrator);
};

struct SceneArguments {
  std::filesystem::path file;
  std::vector<std::string> sets;
  std::optional<std::string> integrator;  // else the scene's
  std::optional<double> time_step;        // s; else the scene's
  std::optional<double> duration;         // s; else the scene's
  std::optional<unsigned> threads;        // else the scene's
  bool allow_outside = false;             // the scene may name files outside of its folder
  PluginArguments plugins;

  // --set, --allow-outside and --plugins; `simulation`: --integrator, --time-step, --duration and --threads as well.
  void add_to(CLI::App& command, bool simulation);
  [[nodiscard]] Scene load(const PluginHost& host, const LoadingCallback& loading = {}) const;
};

struct OutputArguments {
  std::filesystem::path folder;
  bool json = false;
  bool quiet = false;

  void add_to(CLI::App& command);
  // The folder given, else results/<name of the scene>.
  [[nodiscard]] std::filesystem::path folder_for(const std::filesystem::path& scene) const;
  // The same, made and locked until these files are written.
  [[nodiscard]] OutputFolder::Pointer open_for(const std::filesystem::path& scene,
                                               const std::vector<std::string>& files) const;
  [[nodiscard]] bool silent() const noexcept { return json || quiet; }
};

// Prints to stdout, with names and foreign texts made printable. If stdout is a pipe whose reader has gone (| head),
// the rest is dropped without an error.
void print_report(std::string_view report);

}  // namespace springnet::tool
