#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <springnet/printable.hpp>
#include <springnet/suggestion.hpp>

#include "commands.hpp"
#include "common.hpp"
#include "crash.hpp"
#include "process.hpp"

namespace {

using namespace springnet;

// "; did you mean '--threads'?" for a word that is not an option or command of `command`, or a scene without a command.
std::string near(const CLI::App& command, const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_lnames().empty()) known.push_back("--" + option->get_lnames().front());
  }
  const std::vector<const CLI::App*> commands = command.get_subcommands(nullptr);
  if (!commands.empty() && word.ends_with(".toml")) return fmt::format("; did you mean 'springnet run {}'?", word);
  for (const CLI::App* inner : commands) known.push_back(inner->get_name());
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
  // An unknown word is the likely cause of whatever else is missing.
  const std::vector<std::string> unknown = app->remaining(true);
  if (!unknown.empty()) {
    const auto option = std::find_if(unknown.begin(), unknown.end(), [](const std::string& w) { return w[0] == '-'; });
    const std::string& word = option != unknown.end() ? *option : unknown.front();
    what = fmt::format("unknown argument '{}'{}", word, near(*command, word));
  } else if (error.get_name() == "RequiredError" && !command->get_subcommands(nullptr).empty()) {
    what = "a command is missing";
  }
  return fmt::format("springnet: error: {}; see '{} --help'\n", printable_message(what), name);
}

// CLI11 would read "--realtime=" as "--realtime".
void refuse_missing_values(int argc, char** argv) {
  for (int k = 1; k < argc; ++k) {
    const std::string_view word = argv[k];
    if (!word.starts_with("--") || word.find('=') != word.size() - 1) continue;
    throw Error(ErrorKind::input, fmt::format("'{}' has no value after its '='", word));
  }
}

// An empty value is no name, file or number. It is probably an unset variable of a script.
void refuse_empty_values(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_items_expected_min() == 0) continue;  // its value is optional
    const std::vector<std::string>& values = option->results();
    if (std::find(values.begin(), values.end(), "") == values.end()) continue;
    throw Error(ErrorKind::input,
                fmt::format("{}: the value is empty; give one, or leave the option out", option->get_name()));
  }
  for (const CLI::App* inner : command.get_subcommands()) refuse_empty_values(*inner);
}

int run(int argc, char** argv) {
  refuse_missing_values(argc, argv);
  CLI::App app;
  app.failure_message(usage_error);
  tool::Action action;
  tool::add_all(app, action);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // CLI11 reports help and version as errors with status 0.
    return app.exit(error) == 0 ? tool::done : tool::wrong_usage;
  }
  refuse_empty_values(app);
  return action();
}

// Output that could not be written is a failure.
int checked(int status) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  tool::print_error("the standard output cannot be written");
  return status == tool::done ? tool::failed : status;
}

}  // namespace

int main(int argc, char** argv) {
  tool::prepare_process();
  tool::report_crashes();
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
