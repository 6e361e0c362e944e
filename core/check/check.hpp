// Judges components as a strict colleague would: is what a plugin does what it says? core/docs/check.md lists the
// checks.
//
// Everything that calls a component runs in a child process, so that a crash, a loop or a call of exit is a line of the
// report. check_target() also loads plugins and scenes in a process of their own, never in the caller's.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "check/child.hpp"
#include "check/report.hpp"

namespace springnet::check {

struct Options {
  std::uint64_t seed = 1;
  std::string only;  // one check, and no others; empty: all
  Limits limits;     // of each check
  // What components are tried with: integrators, `linear`, `point_mass`. check_target() searches for them if this is
  // null, in `folders` first.
  std::shared_ptr<const PluginHost> host;
  std::vector<std::filesystem::path> folders;
};

// Names that Options::only takes, in the order of the checks.
[[nodiscard]] const std::vector<std::string_view>& check_names();

struct Target {
  enum class What { file, scene, component };
  What what = What::file;
  std::string name;                   // of a file or a scene: its path; of a component "id" or "id@plugin"
  std::optional<ComponentKind> kind;  // of components only this
  // Of a scene: reads the network from its file; may throw. Called in the process that loads plugins.
  std::function<Network(const std::filesystem::path& scene, const PluginHost& host)> read = {};
};
// All components of a plugin's file, all laws of a scene, or components that are installed. A plugin of the search path
// that ends the process while it is loaded is told and left out. Throws Error with what Target::read throws, and
// Error(plugin) for a component that is not there.
[[nodiscard]] Report check_target(const Target& target, const Options& options);
[[nodiscard]] inline Report check_file(const std::filesystem::path& file, const Options& options) {
  return check_target({Target::What::file, file.string(), {}}, options);
}

// Is told each finding as soon as it is there.
using Listener = std::function<void(const Finding&)>;

// Components that the caller has loaded.
void check_components(const std::vector<std::shared_ptr<const Component>>& components, const Options& options,
                      const Listener& listener);
[[nodiscard]] Report check_components(const std::vector<std::shared_ptr<const Component>>& components,
                                      const Options& options);
// All laws of a network's materials, formulas among them, with the parameters and tables that it gives them. Throws
// Error(plugin) for a law that the host does not have.
void check_laws_of(const Network& network, const Options& options, const Listener& listener);
[[nodiscard]] Report check_laws_of(const Network& network, const Options& options);

}  // namespace springnet::check
