// The manual page, the completion and the examples in the help agree with the command line.
#include <algorithm>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "facts.hpp"
#include "tool.hpp"

using namespace springnet;
using springnet::testing::has;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

constexpr const char* commands[] = {"",        "new",    "run",         "validate",   "inspect",
                                    "convert", "plugin", "plugin list", "plugin show"};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// "--output" and so on, of a help, whose lines begin with "  -o,--output" or "  --output".
std::set<std::string> options_in(const std::string& help) {
  constexpr const char* letters = "-abcdefghijklmnopqrstuvwxyz";
  std::set<std::string> found;
  for (const std::string& line : lines_of(help)) {
    std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
    if (begin == 0) continue;
    if (line.size() > begin + 3 && line[begin] == '-' && line[begin + 2] == ',') begin += 3;
    if (line.compare(begin, 2, "--") != 0) continue;
    found.insert(line.substr(begin, line.find_first_not_of(letters, begin) - begin));
  }
  return found;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
    text.replace(at, what.size(), with);
  return text;
}

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
      CHECK(has(manual, replaced(option, "-", "\\-")));
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
    const std::string begin = "  springnet ";
    for (std::string line : lines_of(help)) {
      if (!line.starts_with(begin)) continue;
      // The text after two spaces is an explanation. Runs are shortened, and write into the folder of the test.
      line = line.substr(begin.size());
      line = replaced(line.substr(0, line.find("  ")), "/tmp/", "");
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
