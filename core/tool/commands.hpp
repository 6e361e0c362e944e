// The tool's commands. Each adds itself to the command line; what it returns is the exit status.
#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace springnet::tool {

// Set by a command's callback to what is to be done once the whole command line is known to be right.
using Action = std::function<int()>;

// The whole command line: what it is called and says of itself, and every command below.
void add_all(CLI::App& app, Action& action);

void add_new(CLI::App& app, Action& action);
void add_run(CLI::App& app, Action& action);
void add_validate(CLI::App& app, Action& action);
void add_inspect(CLI::App& app, Action& action);
void add_convert(CLI::App& app, Action& action);
void add_plugin(CLI::App& app, Action& action);

}  // namespace springnet::tool
