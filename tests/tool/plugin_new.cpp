// Plugins to start from: what is written, and what is refused. tests/package/check_plugin_new builds and runs them.
#include <algorithm>
#include <filesystem>

#include <doctest/doctest.h>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::size_t lines_of(const std::string& text) {
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
    if (kind != std::string("integrator")) CHECK(lines_of(source) <= 20);
  }
}

TEST_CASE("a formula becomes C++ with its names as parameters to be described") {
  const TemporaryFolder folder;
  REQUIRE(testing::springnet(folder, fene).status == 0);
  const std::string source = testing::read_text(folder.path() / "fene/fene.cpp");
  CAPTURE(source);
  CHECK(lines_of(source) <= 20);
  CHECK(has(source, "struct FeneLaw : SpringFunction {\n  enum { stiffness, limit };\n"));
  CHECK(has(source, "{number(\"stiffness\", \"1\", \"\"), number(\"limit\", \"1\", \"\")};"));
  CHECK(has(source, "TODO: units, meanings and bounds"));
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
  CHECK(has(source, "{number(\"stiffness\", \"N/m\", \"\").learnable(3),\n"));
  CHECK(has(source, "number(\"limit\", \"m\", \"\").learnable(0.5)};\n"));
  CHECK(has(source, "TODO: meanings and bounds"));
  CHECK(has(testing::read_text(folder.path() / "fene/fene.toml"),
            "{ type = \"fene\", stiffness = 3.0, limit = 0.5 }  # N/m, m\n"));
  // A unit that is not given is one to be added.
  REQUIRE(testing::springnet(folder, given + "0.5 -o half").status == 0);
  CHECK(has(testing::read_text(folder.path() / "half/fene.cpp"), "TODO: units, meanings and bounds"));
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
        Wrong{"law --kind spring --formula 'curve(e)'", "a curve by points is a table of the plugin"},
        Wrong{"law --kind spring --formula 'k*rest(a)'", "laws over several scalars"},
        Wrong{"law --kind spring --formula 'k*direction_0'", "laws over several scalars"},
        Wrong{"law --kind spring --formula 'k*angle'", "write 'value'"},
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
