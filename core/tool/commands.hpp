// The tool's commands. Each adds itself to the command line.
#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace springnet::tool {

// Runs a command and returns the exit status. Set by the command's callback, called once the whole command line is
// valid.
using Action = std::function<int()>;

// The whole command line: name, description and every command below.
void add_all(CLI::App& app, Action& action);

void add_new(CLI::App& app, Action& action);
void add_run(CLI::App& app, Action& action);
void add_validate(CLI::App& app, Action& action);
void add_learn(CLI::App& app, Action& action);
void add_sensitivity(CLI::App& app, Action& action);
void add_inspect(CLI::App& app, Action& action);
void add_convert(CLI::App& app, Action& action);
void add_plugin(CLI::App& app, Action& action);
// To `springnet plugin`.
void add_plugin_new(CLI::App& plugin, Action& action);
void add_plugin_check(CLI::App& plugin, Action& action);

}  // namespace springnet::tool
