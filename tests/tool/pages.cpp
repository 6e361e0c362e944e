// The manual page, the completion and the examples in the help have and do what the command line has.
#include <algorithm>
#include <regex>
#include <set>

#include <doctest/doctest.h>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

constexpr const char* commands[] = {"",        "new",    "run",         "validate",   "inspect",
                                    "convert", "plugin", "plugin list", "plugin show"};

// "--output" and so on, of a help.
std::set<std::string> options_in(const std::string& help) {
  std::set<std::string> found;
  const std::regex option("\n +(-[a-z],)?(--[a-z-]+)");
  for (std::sregex_iterator match(help.begin(), help.end(), option), end; match != end; ++match) {
    found.insert((*match)[2].str());
  }
  return found;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("every command and option is in the manual page and the completion") {
  const TemporaryFolder folder;
  const std::string manual = testing::read_text(SPRINGNET_MANUAL), bash = testing::read_text(SPRINGNET_COMPLETION);
  REQUIRE(manual.starts_with(".TH SPRINGNET 1"));
  for (const std::string command : commands) {
    CAPTURE(command);
    const std::string path = command.empty() ? "" : " " + command;
    if (!command.empty()) CHECK(has(manual, ".SS springnet" + path + "\n"));
    const std::size_t words = bash.find("\"" + path + "\") words=");
    REQUIRE(words != std::string::npos);
    const std::string line = bash.substr(words, bash.find('\n', words) - words);
    const auto options = options_in(testing::springnet(folder, command + " --help").out);
    CHECK(options.contains("--help"));
    for (const std::string& option : options) {
      CAPTURE(option);
      CHECK(has(line, option));
      CHECK(has(manual, std::regex_replace(option, std::regex("-"), "\\-")));
    }
  }
}

TEST_CASE("the completion proposes commands, options and files") {
  const TemporaryFolder folder;
  const auto completed = [&](const std::string& words, int current) {
    const Answer answer =
        testing::shell(folder, "bash -c 'source \"" SPRINGNET_COMPLETION "\"; COMP_WORDS=(springnet " + words +
                                   "); COMP_CWORD=" + std::to_string(current) + "; _springnet; echo ${COMPREPLY[*]}'");
    CHECK(answer.err.empty());
    return answer.out;
  };
  CHECK(completed("va", 1) == "validate\n");
  CHECK(completed("run --int", 2) == "--integrator\n");
  CHECK(completed("plugin sh", 2) == "show\n");
  CHECK(completed("plugin show --ki", 3) == "--kind\n");
  CHECK(completed("run cu", 2) == "\n");  // bash's own: files
}

TEST_CASE("every example in the help works, one after the other") {
  const TemporaryFolder folder;
  std::size_t count = 0;
  std::set<std::string> done;
  for (const char* command : commands) {
    const std::string help = testing::springnet(folder, std::string(command) + " --help").out;
    const std::regex example("\n  springnet ([^\n]*)");
    for (std::sregex_iterator match(help.begin(), help.end(), example), end; match != end; ++match) {
      // What comes after two spaces explains it. The line is made to write here, and not to run for long.
      std::string line = (*match)[1].str();
      line = line.substr(0, line.find("  "));
      line = std::regex_replace(line, std::regex("/tmp/"), "");
      if (!done.insert(line).second) continue;
      if ((line.starts_with("run ") || line.starts_with("validate ")) && !has(line, "--duration")) {
        line += has(line, "--time-steps") ? " --duration 1" : " --duration 0.5";
      }
      const Answer answer = testing::springnet(folder, line);
      CAPTURE(line);
      CAPTURE(answer.err);
      CHECK(answer.status == 0);
      ++count;
    }
  }
  CHECK(count >= 15);
}
