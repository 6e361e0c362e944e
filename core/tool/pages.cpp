// Generates the manual page or the shell completion from the command line itself, so that they have every command and
// option. Used by the build; not installed.
//   springnet_pages man | bash
#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <springnet/version.hpp>

#include "commands.hpp"

namespace {

using Words = std::vector<std::string>;

// ---- the manual page

// Escapes text for roff: backslashes, hyphens (so that they can be searched for and copied), control lines.
std::string roff(std::string_view text) {
  std::string result;
  bool starts = true;
  for (const char c : text) {
    if (starts && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
    starts = c == '\n';
  }
  return result;
}

// "-o, --output DIR".
std::string usage(const CLI::Option& option) {
  if (option.get_positional()) return option.get_name(true);
  std::string names;
  for (const std::string& name : option.get_snames()) names += (names.empty() ? "-" : ", -") + name;
  for (const std::string& name : option.get_lnames()) names += (names.empty() ? "--" : ", --") + name;
  const std::string type = option.get_type_name();
  if (!type.empty() && type != "TEXT") names += (type.starts_with("[=") ? "" : " ") + type;
  return names;
}

std::string options_of(const CLI::App& command) {
  std::string text;
  for (const CLI::Option* option : command.get_options()) {
    text += fmt::format(".TP\n\\fB{}\\fR\n{}\n", roff(usage(*option)), roff(option->get_description()));
  }
  return text;
}

std::string command_section(const CLI::App& command, const std::string& path) {
  std::string text = fmt::format(".SS springnet {}\n{}.\n", roff(path), roff(command.get_description()));
  text += options_of(command);
  const std::string footer = command.get_footer();
  if (!footer.empty()) text += fmt::format(".PP\n.nf\n{}\n.fi\n", roff(footer));
  for (const CLI::App* inner : command.get_subcommands(nullptr)) {
    text += command_section(*inner, path + " " + inner->get_name());
  }
  return text;
}

std::string manual(const CLI::App& app) {
  std::string text = fmt::format(
      ".TH SPRINGNET 1 \"\" \"springnet {}\" \"User Commands\"\n.SH NAME\nspringnet \\- simulate dynamic spring "
      "models\n"
      ".SH SYNOPSIS\n.B springnet\n.I COMMAND\n[\\fIOPTION\\fR]...\n.SH DESCRIPTION\n{}\n.SH OPTIONS\n{}.SH COMMANDS\n",
      springnet::version(), roff(app.get_description()), options_of(app));
  for (const CLI::App* command : app.get_subcommands(nullptr)) text += command_section(*command, command->get_name());
  text += fmt::format(".SH NOTES\n.nf\n{}\n.fi\n", roff(app.get_footer()));
  return text;
}

// ---- completion for bash

Words words_of(const CLI::App& command) {
  Words words;
  for (const CLI::App* inner : command.get_subcommands(nullptr)) words.push_back(inner->get_name());
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
    for (const std::string& name : option->get_snames()) words.push_back("-" + name);
  }
  return words;
}

void add_cases(const CLI::App& command, const std::string& path, std::string& paths, std::string& cases) {
  cases += fmt::format("    \"{}\") words=\"{}\" ;;\n", path, fmt::join(words_of(command), " "));
  for (const CLI::App* inner : command.get_subcommands(nullptr)) {
    const std::string further = path + " " + inner->get_name();
    paths += fmt::format("{}\"{}\"", paths.empty() ? "" : " | ", further);
    add_cases(*inner, further, paths, cases);
  }
}

// Completes options if the word begins with '-', commands if one is missing, and files (bash's default) otherwise.
std::string bash(const CLI::App& app) {
  std::string paths, cases;
  add_cases(app, "", paths, cases);
  return fmt::format(
      R"(# Completion of springnet's command line for bash.
_springnet() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} path="" words="" k
  for ((k = 1; k < COMP_CWORD; k++)); do
    case "$path ${{COMP_WORDS[k]}}" in
    {}) path="$path ${{COMP_WORDS[k]}}" ;;
    esac
  done
  case "$path" in
{}  esac
  COMPREPLY=()
  if [[ $word == -* || -z $path || $path == " plugin" ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  fi
}}
complete -o default -F _springnet springnet
)",
      paths, cases);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app;
  springnet::tool::Action unused;
  springnet::tool::add_all(app, unused);
  const std::string_view wanted = argc == 2 ? argv[1] : "";
  if (wanted != "man" && wanted != "bash") {
    std::fputs("usage: springnet_pages man | bash\n", stderr);
    return 2;
  }
  const std::string text = wanted == "man" ? manual(app) : bash(app);
  return std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0 ? 1 : 0;
}
