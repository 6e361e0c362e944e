// Notes about plugins, the scene and the run are on the terminal and in the files.
#include <algorithm>
#include <set>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

std::string late_scene() {
  return std::string(testing::pair_scene) +
         "[[force]]\nselect = { nodes = [1] }\nforce = [1, 0, 0]\nfrom = 3\n"
         "[[cut]]\ntime = 2\nselect = { springs = [0] }\n";
}

constexpr const char* late_force = "Force 0";  // which starts at 3 s
constexpr const char* late_cut = "Cut 0";      // at 2 s

bool one_has(const nlohmann::json& notes, const std::string& part) {
  for (const auto& note : notes) {
    if (note.get<std::string>().find(part) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("run, validate and inspect note what a material becomes") {
  const TemporaryFolder folder;
  folder.write("box.toml",
               "[simulation]\nduration = 0.1\ntime_step = 0.1\n[[body]]\nname = \"box\"\n"
               "mesh = { lattice = [2, 2, 2], spacing = 1.0, diagonals = \"all\" }\ndensity = 1.0\n"
               "neuron = { type = \"point_mass\" }\nmaterial = { youngs_modulus = 1.0, poisson_ratio = 0.4 }\n");
  const std::string note = "Body 'box': a solid of springs has a Poisson ratio of 1/4";
  CHECK(testing::springnet(folder, "run box.toml").out.find("note: " + note) != std::string::npos);
  CHECK(one_has(testing::read_json(folder.path() / "results/box/summary.json")["notes"], note));
  CHECK(testing::springnet(folder, "inspect box.toml").out.find("note: " + note) != std::string::npos);
  CHECK(one_has(testing::springnet(folder, "validate box.toml --json --time-steps 0.05").json()["notes"], note));
}

TEST_CASE("run and validate note what lies outside of the simulated time") {
  const TemporaryFolder folder;
  folder.write("late.toml", late_scene());
  const Answer run = testing::springnet(folder, "run late.toml");
  CAPTURE(run.err);
  CHECK(run.status == 0);
  const auto summary = testing::read_json(folder.path() / "results/late/summary.json");
  for (const char* note : {late_force, late_cut}) {
    // Once, and before the run.
    const std::size_t place = run.out.find(std::string("note: ") + note);
    CHECK(place < run.out.find("writing about"));
    CHECK(run.out.find(note, place + 10) == std::string::npos);
    CHECK(one_has(summary["notes"], note));
  }
  const auto validation = testing::springnet(folder, "validate late.toml --json --time-steps 0.05").json();
  CHECK(one_has(validation["notes"], late_force));
  CHECK(one_has(validation["notes"], late_cut));
  CHECK(testing::springnet(folder, "validate late.toml --time-steps 0.05").out.find(late_cut) != std::string::npos);
  // A longer run has no such notes.
  CHECK_FALSE(one_has(testing::springnet(folder, "run late.toml --duration 4 --json").json()["notes"], "outside"));
  CHECK(testing::springnet(folder, "run late.toml --quiet").out.empty());
}

TEST_CASE("a time step longer than the duration is noted, and the duration is simulated") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  for (const char* step : {"1.5", "1e9"}) {
    CAPTURE(step);
    const Answer answer = testing::springnet(folder, std::string("run pair.toml --set simulation.time_step=") + step);
    CAPTURE(answer.err);
    CHECK(answer.out.find("is longer than the duration") != std::string::npos);
    const auto summary = testing::read_json(folder.path() / "results/pair/summary.json");
    CHECK(summary["simulated_s"] == 1.0);
    CHECK(summary["steps"] == 1);
    CHECK(one_has(summary["notes"], "is longer than the duration"));
  }
  CHECK_FALSE(one_has(testing::springnet(folder, "run pair.toml --time-step 1 --json").json()["notes"], "longer than"));
}

TEST_CASE("time steps that had to be divided are counted") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const std::string arguments =
      "run pair.toml --time-step 2 --duration 4 --set 'simulation.integrator.unsettled=\"adapt\"' "
      "--set 'simulation.integrator.update=\"synchronous\"'";
  const Answer answer = testing::springnet(folder, arguments);
  CAPTURE(answer.err);
  CAPTURE(answer.out);
  CHECK(answer.status == 0);
  const auto summary = testing::read_json(folder.path() / "results/pair/summary.json");
  const std::string substeps = summary["substeps"].dump(), divided = summary["divided_steps"].dump();
  CHECK(summary["substeps"].get<int>() > 2);
  CHECK(answer.out.find(divided + " of 2 time steps divided, " + substeps + " ") != std::string::npos);
}

TEST_CASE("a folder without plugins is noted") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  std::filesystem::create_directory(folder.path() / "mine");
  folder.write("mine/readme.txt", "to come");
  const std::string note = "There is no plugin (*.springnet.so) in mine";
  CHECK(testing::springnet(folder, "run pair.toml --plugins mine").out.find("note: " + note) != std::string::npos);
  CHECK(testing::springnet(folder, "run --plugins mine --set 'simulation.time_step=0.1' pair.toml")
            .out.find("note: " + note) != std::string::npos);
  CHECK(testing::springnet(folder, "plugin list --plugins mine").out.find(note) != std::string::npos);
  CHECK(one_has(testing::springnet(folder, "run pair.toml --json --plugins mine").json()["notes"], note));
  // One that is not there at all as well.
  CHECK(testing::springnet(folder, "run pair.toml --plugins nowhere").out.find("nowhere: ") != std::string::npos);
  CHECK(testing::springnet(folder, "run pair.toml").out.find("no plugin") == std::string::npos);
}

TEST_CASE("a refused plugin that would provide a law of the scene is noted with the reason") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const auto shown = testing::springnet(folder, "plugin show linear --kind spring --json").json();
  const std::string own = shown[0]["file"].get<std::string>();
  const std::string arguments = "run pair.toml --set 'body.0.spring={type=\"linear\"}' --plugins " +
                                (std::filesystem::path(SPRINGNET_FIXTURES) / "double").string();
  const auto notes = testing::springnet(folder, arguments + " --json").json()["notes"];
  CAPTURE(notes);
  CHECK(one_has(notes, own + ": spring function 'linear' is already provided by a plugin of the same id, "
                             "springnet.spring.linear 1.2.3"));
  CHECK(testing::springnet(folder, arguments).out.find("note: Plugin refused: " + own) != std::string::npos);
}

TEST_CASE("a scene says whose law it means where two plugins have one of that name") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const std::string arguments =
      "run pair.toml --json --plugins " + (std::filesystem::path(SPRINGNET_FIXTURES) / "rival").string();
  const auto ambiguous = testing::springnet(folder, arguments);
  CHECK(ambiguous.status != 0);
  CHECK(ambiguous.err.find("pair.toml") != std::string::npos);
  CHECK(ambiguous.err.find("'linear@org.example.rival' or 'linear@springnet.spring.linear'") != std::string::npos);
  for (const char* law : {"linear@org.example.rival", "linear@springnet.spring.linear"}) {
    CAPTURE(std::string(law));
    CHECK(testing::springnet(folder, arguments + " --set 'body.0.spring={type=\"" + law + "\",stiffness=4}'").status ==
          0);
  }
}

TEST_CASE("refused plugins that do not matter to the run are counted in one note") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const auto components = testing::springnet(folder, "plugin list --json").json()["components"];
  std::filesystem::create_directory(folder.path() / "mine");
  std::set<std::string> files;
  for (const auto& component : components) files.insert(component["file"].get<std::string>());
  REQUIRE(files.size() > 3);
  for (const std::string& file : files)
    std::filesystem::copy_file(file, folder.path() / "mine" / std::filesystem::path(file).filename());
  const auto notes = testing::springnet(folder, "run pair.toml --json --plugins mine").json()["notes"];
  CAPTURE(notes.dump());
  CHECK(one_has(notes, std::to_string(files.size()) + " plugin files were refused"));
  CHECK_FALSE(one_has(notes, "Plugin refused"));
  // So are refused files in folders of the environment variable.
  folder.write("mine/broken.springnet.so", "no library");
  for (const std::string& file : files)
    std::filesystem::remove(folder.path() / "mine" / std::filesystem::path(file).filename());
  const Answer quiet = testing::shell(folder, "SPRINGNET_PLUGIN_PATH=\"$PWD/mine\" \"$SPRINGNET\" run pair.toml");
  CHECK(quiet.out.find("note: 1 plugin file was refused") != std::string::npos);
  // The reason fits into the note if it is a single file in a folder of the command line; more of them are still one
  // note.
  const Answer named = testing::springnet(folder, "run pair.toml --plugins mine/");
  CHECK(named.out.find("note: Plugin refused: mine/broken.springnet.so: cannot be loaded") != std::string::npos);
  for (int k = 0; k < 9; ++k) folder.write(fmt::format("mine/broken{}.springnet.so", k), "no library");
  const auto many = testing::springnet(folder, "run pair.toml --json --plugins mine").json()["notes"];
  CAPTURE(many.dump());
  CHECK_FALSE(one_has(many, "Plugin refused"));
  CHECK(one_has(many,
                "10 plugin files were refused (broken.springnet.so, broken0.springnet.so, broken1.springnet.so, …); "
                "'springnet plugin list' with the same --plugins lists the reasons."));
  CHECK_FALSE(one_has(testing::springnet(folder, "run pair.toml --json").json()["notes"], "refused"));
}

TEST_CASE("a folder of plugins that was not searched is told once, with who names it") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  folder.write("a.springnet.so", "no library");
  const Answer answer = testing::shell(
      folder, "SPRINGNET_PLUGIN_PATH=/nowhere/a:here:/nowhere/a \"$SPRINGNET\" run pair.toml --plugins a.springnet.so");
  CAPTURE(answer.out);
  CHECK(answer.status == 0);
  for (const char* note : {"not searched: /nowhere/a: the folder, which SPRINGNET_PLUGIN_PATH names, cannot be read",
                           "not searched: here: SPRINGNET_PLUGIN_PATH names a relative folder"}) {
    CAPTURE(note);
    const std::size_t place = answer.out.find(note);
    REQUIRE(place != std::string::npos);
    CHECK(answer.out.find(note, place + 1) == std::string::npos);
  }
  CHECK(answer.out.find("a.springnet.so: the folder cannot be read (it is a file): name the folder") !=
        std::string::npos);
}

TEST_CASE("a scene whose law is missing: where was searched, and every file with why it was refused, once") {
  const TemporaryFolder folder;
  std::string scene = testing::pair_scene;
  scene.replace(scene.find("type = \"linear\", stiffness"), 16, "type = \"fene\", ");
  folder.write("fene.toml", scene);
  std::filesystem::create_directory(folder.path() / "mine");
  for (const char* name : {"another", "fene", "third"})
    folder.write(fmt::format("mine/{}.springnet.so", name), "no library");
  for (const char* arguments : {"run fene.toml", "validate fene.toml", "inspect fene.toml", "plugin show fene",
                                "plugin show fene --kind spring"}) {
    CAPTURE(arguments);
    const Answer answer = testing::springnet(folder, std::string(arguments) + " --plugins mine");
    CAPTURE(answer.err);
    CHECK(answer.status == (std::string(arguments).starts_with("plugin") ? 3 : 2));
    CHECK(answer.out.empty());
    for (const char* name : {"another", "fene", "third"}) {
      const std::string file = fmt::format("mine/{}.springnet.so: cannot be loaded", name);
      const std::size_t place = answer.err.find(file);
      REQUIRE(place != std::string::npos);
      CHECK(answer.err.find(file, place + 1) == std::string::npos);
    }
  }
  const Answer run = testing::springnet(folder, "run fene.toml --plugins mine");
  CHECK(run.err.find("\nSearched: mine (3 plugin files), ") != std::string::npos);
  // The likely one comes first.
  CHECK(run.err.find("mine/fene.springnet.so: ") < run.err.find("mine/another.springnet.so: "));
}

TEST_CASE("names of files and bodies are printed without control and bidirectional characters") {
  const TemporaryFolder folder;
  const std::string file = "a\x1b[31m.toml";
  folder.write(file,
               "[simulation]\nduration = 0.1\ntime_step = 0.1\n[[body]]\nname = \"b\\u202eody\"\n"
               "nodes = [[0, 0, 0], [0.0001, 0, 0]]\nsprings = [[0, 1]]\n"
               "neuron = { type = \"point_mass\", mass = 1.0 }\nspring = { type = \"linear\", stiffness = 4.0 }\n");
  for (const char* command : {"run", "validate", "inspect"}) {
    CAPTURE(command);
    const Answer answer = testing::springnet(folder, fmt::format("{} '{}'", command, file));
    CAPTURE(answer.err);
    CHECK(answer.status == 0);
    CHECK(answer.out.find("a\\u001b[31m.toml") != std::string::npos);
    CHECK(answer.out.find('\x1b') == std::string::npos);
    CHECK(answer.out.find("\u202e") == std::string::npos);
  }
  CHECK(testing::springnet(folder, fmt::format("inspect '{}'", file)).out.find("Body 'b\\u202eody'") !=
        std::string::npos);
}

TEST_CASE("wrong arguments are printed without control characters") {
  const TemporaryFolder folder;
  for (const char* arguments : {"'a\x1b[31m'", "run '--a\x1b[31m' pair.toml", "run pair.toml --threads '1\x1b[31m'"}) {
    CAPTURE(arguments);
    const Answer answer = testing::springnet(folder, arguments);
    CHECK(answer.status == 2);
    CHECK(answer.err.find('\x1b') == std::string::npos);
    CHECK(answer.err.find("\\u001b[31m") != std::string::npos);
  }
}

TEST_CASE("descriptions of plugins are printed without control characters") {
  const TemporaryFolder folder;
  const std::string plugins = " --plugins " + (std::filesystem::path(SPRINGNET_FIXTURES) / "rude").string();
  for (const char* command : {"plugin list", "plugin show fixture"}) {
    const Answer answer = testing::springnet(folder, command + plugins);
    CAPTURE(answer.out);
    CHECK(answer.status == 0);
    CHECK(answer.out.find('\x1b') == std::string::npos);
    CHECK(answer.out.find("\\u001b[2J\\u001b]0;owned\\u0007 \\xff\\xfe") != std::string::npos);
  }
  CHECK(testing::springnet(folder, "plugin show fixture --json" + plugins).json()[0]["id"] == "fixture");
}
