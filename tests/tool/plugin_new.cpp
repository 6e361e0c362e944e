// Plugins to start from: what is written, and what is refused. tests/package/check_plugin_new builds and runs them.
#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>

#include <doctest/doctest.h>

#include "facts.hpp"
#include "tool.hpp"

using namespace springnet;
using springnet::testing::has;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

std::size_t line_count(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

constexpr const char* fene = "plugin new fene --kind spring --formula 'stiffness*e/(1 - (e/limit)^2)'";

}  // namespace

TEST_CASE("a new plugin has a source, a project, a test, a scene and a page") {
  const TemporaryFolder folder;
  for (const char* kind : {"spring", "viscosity", "neuron", "integrator"}) {
    CAPTURE(kind);
    const std::string name = std::string("my_") + kind;
    const Answer answer = testing::springnet(folder, "plugin new " + name + " --kind " + kind);
    CAPTURE(answer.err);
    REQUIRE(answer.status == 0);
    for (const std::string& file : {name + ".cpp", name + ".toml", std::string("CMakeLists.txt"),
                                    std::string("test.cmake"), std::string("README.md")}) {
      CAPTURE(file);
      CHECK(std::filesystem::exists(folder.path() / name / file));
      CHECK(has(answer.out, name + "/" + file));
    }
    CHECK(has(answer.out, "Next:\n  cmake -S " + name + " -B " + name + "/build"));
    const std::string source = testing::read_text(folder.path() / name / (name + ".cpp"));
    CHECK(has(source, "SPRINGNET_PLUGIN(\"org.example." + name + "\""));
    if (kind != std::string("integrator")) CHECK(line_count(source) <= 20);
  }
}

TEST_CASE("a formula becomes C++ with its names as parameters to be described") {
  const TemporaryFolder folder;
  REQUIRE(testing::springnet(folder, fene).status == 0);
  const std::string source = testing::read_text(folder.path() / "fene/fene.cpp");
  CAPTURE(source);
  CHECK(line_count(source) <= 20);
  CHECK(has(source, "struct FeneLaw : SpringFunction {\n  enum { stiffness, limit };\n"));
  CHECK(has(source, "number(\"stiffness\", \"1\", \"\").learnable(), number("));
  CHECK(has(source, "TODO: units, meanings, bounds"));
  CHECK(has(source,
            "const auto x1 = e.elongation() / p[limit];\n"
            "    return p[stiffness] * e.elongation() / (1.0 - x1 * x1);"));
  CHECK(has(testing::read_text(folder.path() / "fene/fene.toml"),
            "spring    = { type = \"fene\", stiffness = 1.0, limit = 1.0 }"));

  // The engine refuses a plugin with a summary of more than 8192 bytes.
  std::string many = "stiffness*e";
  for (int k = 0; k < 400; ++k) many += " + 0.00001*stiffness";
  REQUIRE(testing::springnet(folder, "plugin new many --kind spring --formula '" + many + "'").status == 0);
  CHECK(has(testing::read_text(folder.path() / "many/many.cpp"), "*summary = \"stiffness*e + 0.00001*stiffness"));
  CHECK(has(testing::read_text(folder.path() / "many/many.cpp"), "...\";\n"));

  REQUIRE(testing::springnet(folder, "plugin new honey --kind viscosity --formula 'drag*rate' -o a/b").status == 0);
  CHECK(has(testing::read_text(folder.path() / "a/b/honey.cpp"), "return p[drag] * e.rate; }"));
}

TEST_CASE("values and units of parameters stand in the source and the scene") {
  const TemporaryFolder folder;
  const std::string given = std::string(fene) + " --set stiffness='3 N/m' --set limit=";
  REQUIRE(testing::springnet(folder, given + "'0.5 m'").status == 0);
  const std::string source = testing::read_text(folder.path() / "fene/fene.cpp");
  CAPTURE(source);
  CHECK(has(source, "number(\"stiffness\", \"N/m\", \"\").learnable(3), number("));
  CHECK(has(source, "number(\"limit\", \"m\", \"\").learnable(0.5)};\n"));
  CHECK(has(source, "TODO: meanings, bounds"));
  CHECK(has(testing::read_text(folder.path() / "fene/fene.toml"),
            "{ type = \"fene\", stiffness = 3.0, limit = 0.5 }  # N/m, m\n"));
  // A unit that is not given is one to be added.
  REQUIRE(testing::springnet(folder, given + "0.5 -o half").status == 0);
  CHECK(has(testing::read_text(folder.path() / "half/fene.cpp"), "TODO: units, meanings, bounds"));
  CHECK(has(testing::read_text(folder.path() / "half/fene.toml"), "limit = 0.5 }\n"));
}

TEST_CASE("parameters have values with which the scene runs, or it is said that none was found") {
  const TemporaryFolder folder;
  // With k = 1 the upper spring would be longer by 0.2 m.
  REQUIRE(testing::springnet(folder, "plugin new short --kind spring --formula 'if(e < 0.1, k*e, sqrt(-1))'").status ==
          0);
  CHECK(has(testing::read_text(folder.path() / "short/short.toml"), "{ type = \"short\", k = 10.0 }"));
  const Answer never = testing::springnet(folder, "plugin new never --kind spring --formula 'k*sqrt(e - 100)'");
  CHECK(never.status == 0);
  CHECK(has(never.out, "The test will fail until never.toml has values that suit the law (--set"));
  CHECK(has(testing::read_text(folder.path() / "never/never.toml"), "k = 1.0"));
  CHECK_FALSE(has(testing::springnet(folder, fene).out, "will fail"));
}

TEST_CASE("what 'plugin new' cannot do is a usage error, and nothing is written") {
  const TemporaryFolder folder;
  struct Wrong {
    const char* arguments;
    const char* message;
  };
  for (const Wrong& wrong :
       {Wrong{"--kind spring", "NAME is required"},
        Wrong{"law", "--kind is required"},
        Wrong{"law --kind sprung", "sprung not in {spring,viscosity,neuron,integrator}"},
        Wrong{"Law --kind spring", "the name 'Law': names of components are lower-case letters, digits and '_'"},
        Wrong{"../law --kind spring", "the name '../law'"},
        Wrong{"7up --kind spring", "the name '7up'"},
        Wrong{"test --kind spring", "CMake has a target of this name"},
        Wrong{"linear --kind spring", "a spring function of this name already, in springnet.spring.linear"},
        Wrong{"law --kind neuron --formula e", "--formula is for springs and viscosities"},
        Wrong{"law --kind spring --formula ''", "--formula: the value is empty"},
        Wrong{"law --kind spring --formula 'k*(e'", "column 3: this '(' is not closed\n    k*(e\n      ^"},
        Wrong{"law --kind spring --formula 'k*sni(e)'", "no function 'sni'; did you mean 'sin'"},
        Wrong{"law --kind spring --formula 'k*rest(a)'", "laws over several scalars"},
        Wrong{"law --kind spring --formula 'k*direction_0'", "'direction_0' is not known"},
        Wrong{"law --kind neuron --energy e", "--formula is for springs and viscosities"},
        Wrong{"law --kind spring --margin 'k*e'", "the law has no formula"},
        Wrong{"law --kind spring --formula e --state z", "--state 'z': write NAME: RATE"},
        Wrong{"law --kind spring --formula e-z --state ': e'", "--state ': e': write NAME: RATE"},
        Wrong{"law --kind spring --formula e-z --state 'z: y('", "rate of z"},
        Wrong{"law --kind spring --formula e --input drive", "input 'drive': no formula of the law reads it"},
        Wrong{"law --kind spring --energy a --scalar a", "--scalar 'a': write NAME = SCALAR"},
        Wrong{"law --kind spring --formula a --scalar 'a = length(0, 1)'", "--scalar: give the --energy"},
        Wrong{"law --kind spring --energy a --scalar 'a = size(0, 1)'", "'size(0, 1)' is none"},
        Wrong{"law --law body.0.spring --kind spring", "--law requires --from"},
        Wrong{"law --from nothing.toml", "nothing.toml"},
        Wrong{"law --from nothing.toml --formula e", "--formula excludes --from"},
        Wrong{"law --kind spring --formula 'K*e'", "lower case"},
        Wrong{"law --kind spring --formula '_k*e'", "begin with a lower-case letter"},
        Wrong{"law --kind spring --formula 'type*e'", "scenes have this key"},
        Wrong{"law --kind spring --set k=1", "--set gives values of a formula's parameters"},
        Wrong{"law --kind spring --formula 'stiffness*e' --set stifness=1",
              "no parameter 'stifness'; did you mean 'stiffness'"},
        Wrong{"law --kind spring --formula 'k*e' --set k='1 N'", "is in J, and must be in N"},
        Wrong{"law --kind spring --formula 'k*e' --set k=N", "--set 'k=N': write NAME=NUMBER"},
        Wrong{"law --kind spring --formula 'k*e' --set k=1N", "--set 'k=1N': write NAME=NUMBER"},
        Wrong{"law --kind spring --formula 'k*e' --set k", "--set 'k': write NAME=NUMBER"},
        Wrong{"law --kind spring --formula 'k*e' --set k=1 --set k=2", "given twice"},
        Wrong{"law --kind spring --formula 'k*speed'", "'speed' is read by viscosities alone"}}) {
    CAPTURE(wrong.arguments);
    const Answer answer = testing::springnet(folder, std::string("plugin new ") + wrong.arguments);
    CAPTURE(answer.err);
    CHECK(answer.status == 2);
    CHECK(has(answer.err, wrong.message));
    CHECK(answer.out.empty());
    CHECK_FALSE(std::filesystem::exists(folder.path() / "law"));
  }
}

TEST_CASE("the next commands can be copied whatever the folder's name") {
  const TemporaryFolder folder;
  const auto answer = testing::springnet(folder, "plugin new law --kind spring -o 'a b;$(x)'");
  CHECK(answer.status == 0);
  CHECK(has(answer.out, "cmake --build 'a b;$(x)'/build\n"));
}

TEST_CASE("a law too stiff for all settings of the scene does not hold up its project") {
  const TemporaryFolder folder;
  const auto answer = testing::springnet(folder, "plugin new stiff --kind spring --formula '1e12*e'");
  CHECK(answer.status == 0);
  CHECK(has(answer.out, "The test will fail until stiff.toml has values"));
}

TEST_CASE("states have a start and a unit, with which the units of parameters are checked") {
  const TemporaryFolder folder;
  const std::string given =
      "plugin new slow --kind spring --formula 'k*(e - z)' --state 'z: (e - z)/tau' --set k='9 N/m' ";
  REQUIRE(testing::springnet(folder, given + "--set tau='0.5 s' --set z='0.1 m'").status == 0);
  const std::string source = testing::read_text(folder.path() / "slow/slow.cpp");
  CHECK(has(source, "states[] = {number(\"z\", \"m\", \"\").preset(0.1)"));
  const Answer wrong = testing::springnet(folder, given + "--set tau='0.5 N' --set z='0.1 m' -o wrong");
  CHECK(wrong.status == 2);
  CHECK(has(wrong.err, "rate of z: "));
  CHECK(has(testing::springnet(folder, given + "--set z=0 --set z=1 -o wrong").err, "given twice"));
}

TEST_CASE("units of --set are those of springs, of which the scene is") {
  const TemporaryFolder folder;
  const Answer answer = testing::springnet(folder, "plugin new law --kind spring --formula 'k*e' --set k='2 N m'");
  CHECK(answer.status == 2);
  CHECK(has(answer.err, "must be in N;"));
  CHECK(testing::springnet(folder, "plugin new law --kind spring --formula 'k*(angle - 2)' --set k='2 N m'").status ==
        0);
}

TEST_CASE("parameters share lines, and so do constants of one type") {
  const TemporaryFolder folder;
  REQUIRE(
      testing::springnet(
          folder, "plugin new long --kind spring --formula 'a*e + b*e^2 + c/e + d*rest + f*length + g*time + h*j*k*i'")
          .status == 0);
  const std::string source = testing::read_text(folder.path() / "long/long.cpp");
  CAPTURE(source);
  CHECK(line_count(source) <= 20);
  CHECK(has(source, "static constexpr bool reads_time = true, not_zero_at_rest = true;\n"));
  // With a state and a margin there is no room for empty lines.
  REQUIRE(testing::springnet(folder,
                             "plugin new full --kind spring --formula 'stiffness*(e - z)' --state 'z: (e - z)/"
                             "relaxation' --margin 'limit - e'")
              .status == 0);
  const std::string full = testing::read_text(folder.path() / "full/full.cpp");
  CAPTURE(full);
  CHECK(line_count(full) == 20);
  CHECK(has(full, "  enum { stiffness, limit, relaxation, z = 0 };\n"));
  for (const std::string& each : {source, full}) {
    std::istringstream lines(each);
    for (std::string line; std::getline(lines, line);) CHECK(line.size() <= 120);
  }
}

TEST_CASE("options give all of a law") {
  const TemporaryFolder folder;
  REQUIRE(testing::springnet(folder,
                             "plugin new whole --kind spring --formula '(k + drive)*(e - z)' --energy 'k/2*(e - z)^2' "
                             "--margin '9 - strain' --state 'z: (e - z)/tau' --input drive")
              .status == 0);
  const std::string source = testing::read_text(folder.path() / "whole/whole.cpp");
  CAPTURE(source);
  CHECK(has(source, "enum { k, tau, z = 0, drive = 0 };\n"));
  CHECK(has(source, "using has = Has<Energy, Margin>;"));
  CHECK(has(source, "static constexpr Parameter inputs[] = {number(\"drive\", \"1\", \"\").preset(0)};"));
  CHECK(has(source, "static auto state_rates(const auto& e, const auto& p) { return std::array{"));
  CHECK(has(testing::read_text(folder.path() / "whole/whole.toml"), "[[input]]\ninput  = \"drive\""));
  CHECK(has(testing::read_text(folder.path() / "whole/test.cmake"),
            "states = { z = { rate = \"(e - z)/tau\", start = 0.0"));
  REQUIRE(testing::springnet(folder,
                             "plugin new skin --kind spring --energy 'k*(s - rest(s))^2' --scalar 's = area(0, 1, 2)'")
              .status == 0);
  CHECK(has(testing::read_text(folder.path() / "skin/skin.cpp"), "Scalar invariants[] = {area_of(0, 1, 2)};"));
  CHECK(has(testing::read_text(folder.path() / "skin/skin.toml"), "invariant = \"triangle\""));
  REQUIRE(testing::springnet(folder,
                             "plugin new joint --kind spring --energy 'k*(a - rest(a))^2' --scalar 'a = "
                             "angle(0, 1, 2)'")
              .status == 0);
  CHECK(has(testing::read_text(folder.path() / "joint/joint.cpp"), "Shape shape = Shape::chain;"));
  CHECK(has(testing::read_text(folder.path() / "joint/joint.toml"), "invariant = \"chain\""));
}

TEST_CASE("a formula of a scene becomes a plugin with what it declares") {
  const TemporaryFolder folder;
  const std::string scene = FORMULAS;
  const std::string from = " --from '" + scene + "' --law ";
  REQUIRE(testing::springnet(folder, "plugin new bond" + from + "body.0.spring").status == 0);
  const std::string source = testing::read_text(folder.path() / "bond/bond.cpp");
  CAPTURE(source);
  CHECK(has(source, "number(\"depth\", \"J\", \"of the well\").above(0).at_most(100).learnable(5)"));
  CHECK(has(source, "number(\"table\", \"1/m\", \"\").at_least(0.1)};"));
  CHECK(has(source, "*summary = \"a bond, \\\"as Morse has it\\\" \\\\ tested\";"));
  CHECK(has(source, "double smallest_stretch = 0.2;\n  static constexpr double largest_stretch = 3;"));
  CHECK(has(source, "TODO: meanings, bounds"));  // one parameter has no meaning
  CHECK(has(testing::read_text(folder.path() / "bond/bond.toml"), "{ type = \"bond\", depth = 2.0, table = 3.0 }"));
  CHECK(has(testing::read_text(folder.path() / "bond/bond.toml"), "[[0, 0, 0], [0, 0, -0.5], [0, 0.05, -1]]"));
  REQUIRE(testing::springnet(folder, "plugin new slow" + from + "element.1.viscosity").status == 0);
  CHECK(has(testing::read_text(folder.path() / "slow/slow.cpp"), "struct SlowLaw : ViscosityFunction"));
  CHECK(has(testing::read_text(folder.path() / "slow/slow.toml"), "soft_x = [0.0, 1.0], soft_y = [0.0, 0.001] }"));

  const Answer several = testing::springnet(folder, "plugin new law --from '" + scene + "'");
  CHECK(several.status == 2);
  CHECK(has(several.err, "the scene has several formulas; '--law KEY' takes one of body.0.spring, body.0.viscosity"));
  const Answer other = testing::springnet(folder, "plugin new law" + from + "body.0.sprung");
  CHECK(other.status == 2);
  CHECK(has(other.err, "no formula stands at 'body.0.sprung'; did you mean 'body.0.spring'"));
  const Answer kind = testing::springnet(folder, "plugin new law --kind viscosity" + from + "body.0.spring");
  CHECK(kind.status == 2);
  CHECK(has(kind.err, "the formula at 'body.0.spring' is a spring function; leave --kind out"));
  folder.write("plain.toml",
               "[simulation]\nduration = 1\ntime_step = 1\n[[body]]\nname = \"b\"\nnodes = [[0, 0, 0], [1, 0, 0]]\n"
               "springs = [[0, 1]]\nneuron = { type = \"point_mass\", mass = 1 }\nspring = { type = \"linear\", "
               "stiffness = 1 }\n");
  const Answer none = testing::springnet(folder, "plugin new law --from plain.toml");
  CHECK(none.status == 2);
  CHECK(has(none.err, "no law of the scene is a formula"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "law"));
}

TEST_CASE("'plugin show' of a scene lists what its formulas read and declare") {
  const TemporaryFolder folder;
  const Answer shown = testing::springnet(folder, std::string("plugin show '") + FORMULAS + "'");
  CAPTURE(shown.err);
  CHECK(shown.status == 0);
  CHECK(has(shown.out, "body.0.spring (spring function)"));
  CHECK(has(shown.out, "stretch  0.2 to 3"));
  CHECK(has(shown.out, "not zero at rest"));
  CHECK(has(shown.out, "of the well (learnable)"));
  CHECK(has(shown.out, "element.1.viscosity (viscosity function)"));
  const Answer json = testing::springnet(folder, std::string("plugin show --json '") + FORMULAS + "'");
  CHECK(has(json.out, "\"id\": \"spring.0.spring\""));
  folder.write("bad.toml", "[simulation]\n");
  CHECK(testing::springnet(folder, "plugin show bad.toml").status == 2);
}

TEST_CASE("a new plugin overwrites nothing, and leaves nothing behind if it fails") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "fene");
  folder.write("fene/README.md", "mine");
  const Answer again = testing::springnet(folder, fene);
  CHECK(again.status == 2);
  CHECK(has(again.err, "fene/README.md already exists, and nothing was written"));
  CHECK(testing::read_text(folder.path() / "fene/README.md") == "mine");
  CHECK_FALSE(std::filesystem::exists(folder.path() / "fene/fene.cpp"));

  const Answer full = testing::shell(folder, std::string("ulimit -f 1; \"$SPRINGNET\" ") + fene + " -o new/deep");
  CHECK(full.status == 1);
  CHECK(has(full.err, "cannot be written"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "new"));

  folder.write("file", "");
  CHECK(testing::springnet(folder, std::string(fene) + " -o file/inside").status == 2);
}
