// [[input]] in scenes.
#include <fstream>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/scene.hpp>

#include "laws.hpp"
#include "temporary_folder.hpp"

namespace {

using namespace springnet;
using namespace springnet::testing;

constexpr const char* head = R"([simulation]
duration  = 1
time_step = 0.1
[[body]]
name    = "arm"
nodes   = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]
springs = [[0, 1], [1, 2]]
neuron  = { type = "point_mass", mass = 1 }
spring  = { type = "motor" }
[[body]]
name    = "rope"
nodes   = [[0, 1, 0], [1, 1, 0], [2, 1, 0]]
springs = [[0, 1], [1, 2]]
neuron  = { type = "point_mass", mass = 1 }
spring  = { type = "linear", stiffness = 1 }
[[element]]
name      = "elbow"
invariant = "angle"
body      = "arm"
nodes     = [[0, 1, 2]]
spring    = { type = "motor" }
[[input]]
)";

Scene read(const std::string& input, const std::filesystem::path& folder = {}) {
  return parse_scene(head + input, "scene.toml", *plugins_with_inputs(), {}, folder);
}
// The message, with line 23 for the first line of the input.
std::string refusal(const std::string& input, const std::filesystem::path& folder = {}) {
  try {
    static_cast<void>(read(input, folder));
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    return error.what();
  }
  return "accepted";
}
bool says(const std::string& text, std::string_view part) {
  INFO(text);
  const bool found = text.find(part) != std::string::npos;
  CHECK(found);
  return found;
}

}  // namespace

TEST_CASE("a scene gives signals to all springs and elements that read them, or to those selected") {
  const auto inputs = [](const std::string& text) { return read(text).network.inputs(); };
  const auto all = inputs("input = 'tension'\nvalue = 3");
  REQUIRE(all.size() == 1);
  CHECK(all[0].springs == std::vector<SpringIndex>{0, 1});
  CHECK(all[0].elements == std::vector<ElementIndex>{0});
  CHECK(all[0].signal.mean == 3);
  const auto one = inputs(
      "input = 'tension'\nname = 'left'\nselect = { springs = [1, 2] }\ntimes = [0, 1, 2]\n"
      "values = [0, 5, 1]\ninterpolation = 'cubic'");
  CHECK(one[0].springs == std::vector<SpringIndex>{1});
  CHECK(one[0].elements.empty());
  CHECK(one[0].name == "left");
  CHECK(one[0].signal.values == std::vector<double>{0, 5, 1});
  CHECK(one[0].signal.interpolation == Signal::Interpolation::cubic);
  const auto elbow = inputs(
      "input = 'tension'\nelements = ['elbow']\n"
      "sinusoid = { frequency = 2, amplitude = 3, mean = 1, phase = 0.5 }");
  CHECK(elbow[0].springs.empty());
  CHECK(elbow[0].elements == std::vector<ElementIndex>{0});
  CHECK(elbow[0].signal.frequency == 2);
  CHECK(elbow[0].signal.amplitude == 3);
  CHECK(elbow[0].signal.mean == 1);
  CHECK(elbow[0].signal.phase == 0.5);
  CHECK(inputs("input = 'tension'\ntimes = [0, 1]\nvalues = [0, 5]")[0].signal.interpolation ==
        Signal::Interpolation::linear);
}

TEST_CASE("signals from a CSV file") {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "emg.csv") << "# measured\ntime, left, tension\n0,1,2\n0.5,3,4\n\n1.5,-5,6\n";
  const Signal named = read("input = 'tension'\nfile = 'emg.csv'", folder.path()).network.inputs()[0].signal;
  CHECK(named.times == std::vector<double>{0, 0.5, 1.5});
  CHECK(named.values == std::vector<double>{2, 4, 6});
  const Signal column =
      read("input = 'tension'\nfile = 'emg.csv'\ncolumn = 'left'\ninterpolation = 'hold'", folder.path())
          .network.inputs()[0]
          .signal;
  CHECK(column.values == std::vector<double>{1, 3, -5});
  CHECK(column.interpolation == Signal::Interpolation::hold);
  says(refusal("input = 'tension'\nfile = 'emg.csv'\ncolumn = 'right'", folder.path()), "scene.toml:24:8");
  says(refusal("input = 'tension'\nfile = 'none.csv'", folder.path()), "none.csv");
  says(refusal("input = 'tension'\nfile = '../emg.csv'", folder.path()), "scene.toml:24:8");
  std::ofstream(folder.path() / "back.csv") << "time,tension\n0,1\n1,2\n0.5,3\n";
  says(refusal("input = 'tension'\nfile = 'back.csv'", folder.path()), "back.csv:4: times must increase");
  std::ofstream(folder.path() / "one.csv") << "time,tension\n0,1\n";
  says(refusal("input = 'tension'\nfile = 'one.csv'", folder.path()), "two or more");
  std::ofstream(folder.path() / "text.csv") << "time,tension\n0,1\n1,much\n";
  says(refusal("input = 'tension'\nfile = 'text.csv'", folder.path()), "text.csv:3");
}

TEST_CASE("what a scene's signal lacks or has too much of is said with its place") {
  says(refusal("value = 1"), "scene.toml:22");
  says(refusal("input = 'tension'"), "gives no signal");
  says(refusal("input = 'tension'\nvalue = 1\ntimes = [0, 1]\nvalues = [0, 1]"), "cannot be combined with 'times'");
  says(refusal("input = 'tension'\nvalue = 1\nvalues = [0, 1]"), "requires 'times'");
  says(refusal("input = 'tension'\nvalue = 1\ninterpolation = 'hold'"), "scene.toml:25");
  says(refusal("input = 'tension'\nvalue = 1\ncolumn = 'a'"), "requires 'file'");
  says(refusal("input = 'tension'\ntimes = [0, 1]"), "values");
  says(refusal("input = 'tension'\ntimes = [0, 1]\nvalues = [0, 1, 2]"), "scene.toml:25:10");
  says(refusal("input = 'tension'\ntimes = [0, 2, 1]\nvalues = [0, 1, 2]"), "scene.toml:24:16");
  says(refusal("input = 'tension'\ntimes = [0]\nvalues = [0]"), "two times or more");
  says(refusal("input = 'tension'\ntimes = [0, nan]\nvalues = [0, 1]"), "scene.toml:24:13");
  says(refusal("input = 'tension'\ntimes = [0, 1]\nvalues = [0, 99]"),
       "scene.toml:25:14: input.0.values.1: the value must be at most 50 N");
  says(refusal("input = 'tension'\ntimes = [0, 1]\nvalues = [0, 9]\ninterpolation = 'smooth'"), "'cubic'");
  says(refusal("input = 'tension'\nvalue = 99"), "must be at most 50 N");
  says(refusal("input = 'tensoin'\nvalue = 1"), "did you mean 'tension'");
  says(refusal("input = 'tension'\nselect = { body = 'rope' }\nvalue = 1"), "none of them reads an input");
  says(refusal("input = 'tension'\nelements = ['knee']\nvalue = 1"), "there is no [[element]] 'knee'");
  says(refusal("input = 'tension'\nsinusoid = { frequency = 1 }"), "amplitude");
  says(refusal("input = 'tension'\nsinusoid = { frequency = 0, amplitude = 1 }"), "above 0");
  says(refusal("input = 'tension'\nsinusoid = { frequency = 1, amplitude = 60 }"), "value must be at");
  says(refusal("input = 'tension'\nunit = 'N'\nvalue = 1"), "unit");
  says(refusal("input = 'tension'\nname = 'a'\nvalue = 1\n[[input]]\ninput = 'tension'\nname = 'a'\nvalue = 1"),
       "scene.toml:26");
}
