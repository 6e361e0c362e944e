// Judges components as a strict colleague would: is what a plugin does what it says? core/docs/check.md lists the
// checks.
//
// Everything that calls a component runs in a child process, so that a crash, a loop or a call of exit is a line of the
// report. A plugin's file is loaded in a child first, and only then by the caller.
#pragma once

#include <filesystem>
#include <memory>
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
  std::shared_ptr<const PluginHost>
      host;  // what components are tried with: integrators, `linear`, `point_mass`; not null
};

// Names that Options::only takes, in the order of the checks.
[[nodiscard]] const std::vector<std::string_view>& check_names();

// All components of a plugin's file.
[[nodiscard]] Report check_file(const std::filesystem::path& file, const Options& options);
// Components that the caller has loaded.
[[nodiscard]] Report check_components(const std::vector<std::shared_ptr<const Component>>& components,
                                      const Options& options);
// All laws of a network's materials, formulas among them, with the parameters and tables that it gives them. Throws
// Error(plugin) for a law that the host does not have.
[[nodiscard]] Report check_laws_of(const Network& network, const Options& options);

}  // namespace springnet::check
