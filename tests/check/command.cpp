// The command: targets, exit statuses, outputs.
#include <doctest/doctest.h>

#include <string>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

std::string broken(const char* name) { return std::string("'" BROKEN "/") + name + ".springnet" LIBRARY_SUFFIX "'"; }

}  // namespace

TEST_CASE("exit statuses: 0 passed, 1 failed, 2 usage, 3 not loaded") {
  const TemporaryFolder folder;
  const auto status = [&](const std::string& arguments) {
    return testing::springnet(folder, "plugin check " + arguments).status;
  };
  CHECK(status("linear --kind spring --only call") == 0);
  CHECK(status(broken("right") + " --only energy") == 0);
  CHECK(status(broken("wrong_energy") + " --only energy") == 1);
  CHECK(status(broken("prefix") + " --only load") == 0);
  CHECK(status("") == 2);
  CHECK(status("linear --only everything") == 2);
  CHECK(status("no_such_scene.toml") == 2);
  CHECK(status(broken("constructor")) == 3);
  CHECK(status("no_such_law") == 3);
  folder.write("text.springnet" LIBRARY_SUFFIX, "this is no library");
  CHECK(status("text.springnet" LIBRARY_SUFFIX) == 3);
}

TEST_CASE("the table and the JSON have every check, with its reason and the seed") {
  const TemporaryFolder folder;
  const Answer answer = testing::springnet(folder, "plugin check " + broken("crashes") + " --seed 5 --json");
  CHECK(answer.status == 1);
  const auto report = answer.json();
  CHECK(report["seed"] == 5);
  CHECK(report["loaded"] == true);
  CHECK(report["passed"] == false);
  REQUIRE(report["checks"].size() == 14);
  CHECK(report["checks"][1]["check"] == "call");
  CHECK(report["checks"][1]["result"] == "crash");
  CHECK(report["checks"][2]["result"] == "skipped");
  const std::string text = testing::springnet(folder, "plugin check " + broken("crashes") + " --seed 5").out;
  for (const char* part : {"broken (spring function)", "crash", "skipped", "SIGSEGV", "seed 5", "1 failed"}) {
    CAPTURE(std::string(part));
    CHECK(text.find(part) != std::string::npos);
  }
}

TEST_CASE("a plugin of the search path that ends the process is a line of the report, and left out") {
  const TemporaryFolder folder;
  const auto check = [&](const char* name, const std::string& target, const std::string& path) {
    return testing::shell(folder, "rm -rf p && mkdir p && cp " + broken(name) + " p && " + path +
                                      " \"$SPRINGNET\" plugin check --json --only call " + target);
  };
  for (const char* name : {"constructor", "aborts", "thread"}) {
    CAPTURE(std::string(name));
    const Answer other = check(name, "linear --kind spring --plugins p", "");
    CHECK(other.status == 3);
    const auto checks = other.json()["checks"];
    REQUIRE(checks.size() == 2);
    CHECK(checks[0]["component"] == std::string(name) + ".springnet" LIBRARY_SUFFIX);
    CHECK(checks[1]["component"] == "linear");
    CHECK(checks[1]["result"] == "pass");
    const Answer itself = check(name, "broken --plugins p", "");
    CHECK(itself.status == 3);
    CHECK(itself.json()["checks"].size() == 2);  // that it cannot be loaded, and that there is no such component
    const Answer file = check(name, broken(name), "SPRINGNET_PLUGIN_PATH=$PWD/p");
    CHECK(file.status == 3);
    CHECK(file.json()["checks"].size() == 2);  // a copy of it, and itself
  }
  const Answer last = check("destructor", "linear --kind spring --plugins p", "");
  CHECK(last.status == 1);
  REQUIRE(last.json()["checks"].size() == 2);
  CHECK(last.json()["checks"][1]["component"] == "destructor.springnet" LIBRARY_SUFFIX);
}

TEST_CASE("a law that ends the process while its scene is loaded is a line of the report") {
  const TemporaryFolder folder;
  std::string scene = testing::pair_scene;
  const std::string law = "{ type = \"linear\", stiffness = 4.0 }";
  scene.replace(scene.find(law), law.size(), "{ type = \"broken\", points = [0.0, 1.0] }");
  folder.write("pair.toml", scene);
  const Answer answer = testing::shell(
      folder, "mkdir p && cp " + broken("prepares") + " p && \"$SPRINGNET\" plugin check pair.toml --plugins p --json");
  CHECK(answer.status == 1);
  REQUIRE(answer.json()["checks"].size() == 1);
  const auto found = answer.json()["checks"][0];
  CHECK(found["component"] == "broken");
  CHECK(found["result"] == "crash");
  CHECK(found["why"].get<std::string>().find("SIGABRT") != std::string::npos);
}

TEST_CASE("a scene's laws are checked with the scene's parameters, formulas among them") {
  const TemporaryFolder folder;
  std::string scene = testing::pair_scene;
  folder.write("pair.toml", scene);
  const Answer good = testing::springnet(folder, "plugin check pair.toml --only derivatives --json");
  CHECK(good.status == 0);
  CHECK(good.json()["checks"].size() == 2);  // the spring and the viscosity function
  const std::string law = "spring = { type = \"linear\", stiffness = 4.0 }";
  const auto with = [&](const std::string& formula) {
    std::string changed = scene;
    changed.replace(changed.find(law), law.size(), formula);
    folder.write("formula.toml", changed);
    return testing::springnet(folder, "plugin check formula.toml --seed 3 --json");
  };
  const Answer cubic = with("spring = { formula = \"stiffness*e + cubic*e^3\", stiffness = 4.0, cubic = 2.0 }");
  CHECK(cubic.status == 0);
  CHECK(cubic.json()["checks"][0]["component"] == "formula");
  // A formula that is not finite where it should be.
  const Answer wrong = with("spring = { formula = \"stiffness*log(strain + 0.9)\", stiffness = 4.0 }");
  CHECK(wrong.status == 1);
}
