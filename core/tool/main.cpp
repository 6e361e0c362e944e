#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <springnet/plugin_host.hpp>
#include <springnet/version.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "process.hpp"

namespace {

using namespace springnet;

constexpr const char* footer = R"(Examples:
  springnet run examples/cube/cube.toml              simulate; files go to results/cube
  springnet validate examples/cube/cube.toml         compare with CVODE
  springnet inspect examples/cube/cube.toml          what the network is made of
  springnet plugin show linear                       what a law does, its parameters and bounds

Exit status:
  0 done   1 the simulation failed or a tolerance was not met   2 usage or scene   3 plugin

'springnet COMMAND --help' says more about a command.)";

// "; did you mean '--threads'?" for a word that no option or command of `command` has.
std::string near(const CLI::App& command, const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_lnames().empty()) known.push_back("--" + option->get_lnames().front());
  }
  for (const CLI::App* inner : command.get_subcommands(nullptr)) known.push_back(inner->get_name());
  const std::string text = suggestion(word, known);
  return text.empty() ? "" : "; " + text;
}

std::string usage_error(const CLI::App* app, const CLI::Error& error) {
  const CLI::App* command = app;
  std::string name = "springnet";
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    name += " " + command->get_name();
  }
  std::string what = error.what();
  // The first word that nothing takes is the cause of whatever else is missing.
  const std::vector<std::string> unknown = app->remaining(true);
  if (!unknown.empty()) {
    const auto option = std::find_if(unknown.begin(), unknown.end(), [](const std::string& w) { return w[0] == '-'; });
    const std::string& word = option != unknown.end() ? *option : unknown.front();
    what = fmt::format("'{}' is not known here{}", word, near(*command, word));
  } else if (error.get_name() == "RequiredError" && !command->get_subcommands(nullptr).empty()) {
    what = "a command is missing";
  }
  return fmt::format("springnet: error: {}; '{} --help' shows how it is used\n", what, name);
}

// CLI11 takes "--realtime=" for "--realtime".
void refuse_missing_values(int argc, char** argv) {
  for (int k = 1; k < argc; ++k) {
    const std::string_view word = argv[k];
    if (!word.starts_with("--") || word.find('=') != word.size() - 1) continue;
    throw Error(ErrorKind::input, fmt::format("'{}' has no value behind its '='", word));
  }
}

int run(int argc, char** argv) {
  refuse_missing_values(argc, argv);
  CLI::App app(
      "springnet simulates dynamic spring models: as recurrent neural networks whose neurons, spring laws and\n"
      "integrators are plugins, and in CVODE as a reference.");
  app.name("springnet");
  app.set_version_flag("--version", fmt::format("springnet {}", version()));
  app.require_subcommand(1);
  app.failure_message(usage_error);
  app.footer(footer);
  tool::Action action;
  tool::add_run(app, action);
  tool::add_validate(app, action);
  tool::add_inspect(app, action);
  tool::add_convert(app, action);
  tool::add_plugin(app, action);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // Help and version are "errors" that end well.
    return app.exit(error) == 0 ? tool::done : tool::wrong_usage;
  }
  return action();
}

// Results that nobody could read are no results.
int checked(int status) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  tool::print_error("the standard output cannot be written");
  return status == tool::done ? tool::failed : status;
}

}  // namespace

int main(int argc, char** argv) {
  tool::prepare_process();
  try {
    return checked(run(argc, argv));
  } catch (const Error& error) {
    tool::print_error(error.what());
    return tool::status_of(error.kind());
  } catch (const std::bad_alloc&) {
    tool::print_error("out of memory: simulate a smaller network, or on a larger machine");
  } catch (const std::exception& error) {
    tool::print_error(error.what());
  }
  return tool::failed;
}
