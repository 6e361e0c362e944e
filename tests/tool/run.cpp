#include <chrono>
#include <csignal>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <springnet/output.hpp>

#include "csv.hpp"
#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

// At rest until a load pulls at 0.5 s; then the synchronous rule, far beyond its time constant, does not settle.
constexpr const char* failing_scene = R"(
[simulation]
duration = 1.0
time_step = 0.1
integrator = { name = "recurrent", update = "synchronous" }
[[body]]
name = "pair"
nodes = [[0, 0, 0], [1, 0, 0]]
springs = [[0, 1]]
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "linear", stiffness = 1000.0 }
[[fix]]
select = { nodes = [0] }
[[force]]
select = { nodes = [1] }
force = [1, 0, 0]
from = 0.5
)";

}  // namespace

TEST_CASE("run writes trajectory, events and summary to results/<scene>") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(folder, "run pair.toml");
  CAPTURE(answer.err);
  CHECK(answer.status == 0);
  CHECK(answer.out.find("records) to results/pair") != std::string::npos);
  CHECK(answer.out.find("outcome    settled") != std::string::npos);
  CHECK(answer.err.empty());

  const testing::Csv csv = testing::read_csv(folder.path() / "results/pair/trajectory.csv");
  CHECK(csv.header == "time,node,x,y,z,vx,vy,vz");
  REQUIRE(csv.rows.size() == 22);
  CHECK(csv.rows[0] == std::vector<std::string>{"0", "0", "0", "0", "0", "0", "0", "0"});
  CHECK(csv.rows[1] == std::vector<std::string>{"0", "1", "1", "0", "0", "0", "0", "0"});
  CHECK(csv.number(21, 0) == 1.0);

  const auto summary = testing::read_json(folder.path() / "results/pair/summary.json");
  for (const char* key : {"nodes", "springs", "steps", "simulated_s", "wall_s", "spring_updates_per_s",
                          "sweeps_per_step", "outcome", "ruptured", "cut"}) {
    CAPTURE(key);
    CHECK(summary.contains(key));
  }
  CHECK(summary["scene"] == "pair.toml");
  CHECK(summary["title"] == "A pair");
  CHECK(summary["outcome"] == "settled");
  CHECK(std::filesystem::exists(folder.path() / "results/pair/events.csv"));
}

TEST_CASE("--json prints the summary and nothing else") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(folder, "run pair.toml --json -o out");
  CHECK(answer.status == 0);
  CHECK(answer.err.empty());
  CHECK(answer.json() == testing::read_json(folder.path() / "out/summary.json"));
}

TEST_CASE("--quiet prints nothing") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(folder, "run pair.toml --quiet --output a/b/c");
  CHECK(answer.status == 0);
  CHECK(answer.out.empty());
  CHECK(answer.err.empty());
  CHECK(std::filesystem::exists(folder.path() / "a/b/c/trajectory.csv"));
}

TEST_CASE("time step, duration, threads and keys of the scene can be given") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(
      folder,
      "run pair.toml --json -o out --time-step 0.05 --duration 2 --threads 1 --set output.interval=0.5 "
      "--set output.reactions=true --set 'title=\"Other\"'");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  const auto summary = answer.json();
  CHECK(summary["time_step_s"] == 0.05);
  CHECK(summary["duration_s"] == 2.0);
  CHECK(summary["steps"] == 40);
  CHECK(summary["threads"] == 1);
  CHECK(summary["records"] == 5);
  CHECK(summary["title"] == "Other");
  CHECK(testing::read_csv(folder.path() / "out/trajectory.csv").rows.size() == 10);
  CHECK(testing::read_csv(folder.path() / "out/reactions.csv").rows.size() == 5);
}

TEST_CASE("another integrator starts with its defaults and its own options") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(
      folder, "run pair.toml --json --integrator cvode --set 'simulation.integrator.method=\"adams\"'");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(answer.json()["integrator"]["name"] == "cvode");
  CHECK(answer.json()["integrator"]["options"] == nlohmann::json{{"method", "adams"}});
}

TEST_CASE("the integrator that the scene names already keeps its options") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(folder, "run pair.toml --json --integrator recurrent");
  REQUIRE(answer.status == 0);
  CHECK(answer.json()["integrator"]["options"]["max_sweeps"] == 500.0);
}

TEST_CASE("a run that fails midway has status 1 and keeps what was written") {
  const TemporaryFolder folder;
  folder.write("failing.toml", failing_scene);
  const Answer answer = testing::springnet(folder, "run failing.toml");
  CHECK(answer.status == 1);
  CHECK(answer.err.starts_with("springnet: error: "));
  CHECK(answer.err.find("results/failing") != std::string::npos);
  const testing::Csv csv = testing::read_csv(folder.path() / "results/failing/trajectory.csv");
  REQUIRE(csv.rows.size() == 12);  // six records, from 0 to 0.5 s
  CHECK(csv.number(11, 0) == doctest::Approx(0.5));
  const auto summary = testing::read_json(folder.path() / "results/failing/summary.json");
  CHECK(summary["outcome"] != "settled");
  CHECK(summary["simulated_s"].get<double>() == doctest::Approx(0.5));
  CHECK(answer.err.find(summary["error"].get<std::string>()) != std::string::npos);
}

TEST_CASE("a full disk has status 1, and keeps the output up to the last complete record") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  // Files of at most 128 blocks of 512 bytes; about 900 kB would be written.
  const Answer answer =
      testing::shell(folder, "ulimit -f 128; \"$SPRINGNET\" run pair.toml --time-step 0.0001 --duration 0.5 -q -o out");
  CHECK(answer.status == 1);
  CHECK(answer.err.find("trajectory.csv: cannot be written") != std::string::npos);
  CHECK(answer.err.find("output.interval") != std::string::npos);
  CHECK(std::filesystem::file_size(folder.path() / "out/trajectory.csv") <= 128 * 512);
  const testing::Csv csv = testing::read_csv(folder.path() / "out/trajectory.csv");
  CHECK(csv.rows.size() % 2 == 0);
  const double last = csv.number(csv.rows.size() - 1, 0);
  const auto summary = testing::read_json(folder.path() / "out/summary.json");
  CHECK(summary["outcome"] == "failed");
  CHECK(summary["error"].get<std::string>().find("trajectory.csv") != std::string::npos);
  CHECK(summary["simulated_s"].get<double>() > last);
  REQUIRE(summary["cut_short"].size() == 1);
  CHECK(summary["cut_short"][0]["file"] == "trajectory.csv");
  CHECK(summary["cut_short"][0]["until_s"] == last);
  CHECK(answer.err.find(fmt::format("trajectory.csv: up to {:g} s", last)) != std::string::npos);
}

TEST_CASE("an error that cannot be printed still has its status") {
  if (!std::filesystem::exists("/dev/full")) return;
  const TemporaryFolder folder;
  folder.write("failing.toml", failing_scene);
  CHECK(testing::shell(folder, "\"$SPRINGNET\" run failing.toml -q 2> /dev/full").status == 1);
  CHECK(testing::shell(folder, "\"$SPRINGNET\" run nowhere.toml -q 2> /dev/full").status == 2);
}

TEST_CASE("output that would not fit the disk is refused with a remedy, status 2") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(folder, "run pair.toml --quiet --time-step 1e-9 --duration 1e7");
  CHECK(answer.status == 2);
  CHECK(answer.err.find("output.interval") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "results"));
}

TEST_CASE("SIGTERM stops the run in order") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  // A thousand million time steps: it does not end by itself. events.csv is there when the run has begun.
  const Answer answer =
      testing::shell(folder,
                     "\"$SPRINGNET\" run pair.toml --duration 1e8 --set output.interval=1e8 -q -o out & "
                     "tool=$!; while [ ! -e out/events.csv ] && kill -0 $tool; do sleep 0.05; done; sleep 0.2; "
                     "kill -TERM $tool; wait $tool");
  CHECK(answer.status == 1);
  CHECK(answer.err.find("stopped at") != std::string::npos);
  const auto summary = testing::read_json(folder.path() / "out/summary.json");
  CHECK(summary["outcome"] == "stopped");
  // How far it came is in the tables, though the interval was not over.
  const testing::Csv csv = testing::read_csv(folder.path() / "out/trajectory.csv");
  REQUIRE(csv.rows.size() == 4);
  CHECK(csv.number(3, 0) == summary["simulated_s"].get<double>());
}

TEST_CASE("SIGTERM in a long time step: a line says what it waits for, and a second one ends the run at once") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  // A single time step of three hundred million periods.
  const Answer answer = testing::shell(
      folder,
      "\"$SPRINGNET\" run pair.toml --duration 1e9 --time-step 1e9 "
      "--set 'simulation.integrator={name=\"cvode\",max_steps=1000000000}' "
      "--set body.0.viscosity.damping=0 -q -o out 2> err & "
      "tool=$!; while [ ! -e out/events.csv ] && kill -0 $tool; do sleep 0.05; done; kill -TERM $tool; "
      "for i in $(seq 200); do grep -q 'ends after this time step' err && break; sleep 0.05; done; cat err >&2; "
      "kill -TERM $tool; wait $tool");
  CHECK(answer.status == 128 + SIGTERM);
  CHECK(answer.err.find("another Ctrl-C or SIGTERM ends it at once") != std::string::npos);
}

TEST_CASE("a separate multiple of real time is an error that shows how to write it") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  for (const char* arguments : {"run pair.toml --realtime 2", "run --realtime 2 pair.toml"}) {
    CAPTURE(arguments);
    const Answer answer = testing::springnet(folder, arguments);
    CHECK(answer.status == 2);
    CHECK(answer.err.find("'2'; did you mean '--realtime=2'") != std::string::npos);
    CHECK(answer.err.find("springnet run --help") != std::string::npos);
  }
  CHECK(testing::springnet(folder, "run pair.toml --realtime=").err.find("'--realtime=' has no value") !=
        std::string::npos);
  // Other unknown arguments are reported as usual.
  CHECK(testing::springnet(folder, "run pair.toml --realtime fast").err.find("unknown argument 'fast';") !=
        std::string::npos);
  CHECK(testing::springnet(folder, "run pair.toml 2").err.find("unknown argument '2';") != std::string::npos);
  CHECK(testing::springnet(folder, "run --realtime pair.toml --thrads 2").err.find("did you mean '--threads'") !=
        std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "results"));
}

TEST_CASE("a scene without a command, and a mesh instead of a scene, give an error with the right command") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  CHECK(testing::springnet(folder, "pair.toml").err.find("did you mean 'springnet run pair.toml'?") !=
        std::string::npos);
  folder.write("box.msh", "");
  for (const char* command : {"run box.msh", "validate box.msh"}) {
    const Answer answer = testing::springnet(folder, command);
    CHECK(answer.status == 2);
    CHECK(answer.err.find("springnet new box.msh") != std::string::npos);
  }
}

TEST_CASE("a folder that cannot be created is a usage error") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  folder.write("taken", "a file");
  const Answer answer = testing::springnet(folder, "run pair.toml -q -o taken/out");
  CHECK(answer.status == 2);
  CHECK(answer.err.find("taken/out") != std::string::npos);
}

TEST_CASE("the size of each file is reported before the run") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(
      folder, "run pair.toml --set 'output.format=\"binary\"' --set output.vtk=true --set output.reactions=true");
  CAPTURE(answer.out);
  REQUIRE(answer.status == 0);
  const auto size = std::filesystem::file_size(folder.path() / "results/pair/trajectory.bin");
  const std::size_t line = answer.out.find("  trajectory.bin   ");
  REQUIRE(line != std::string::npos);
  CHECK(answer.out.substr(line + 19).starts_with(readable_bytes(static_cast<double>(size)) + "\n"));
  for (const char* file : {"  reactions.csv    at most ", "  vtk/             at most "}) {
    CHECK(answer.out.find(file) != std::string::npos);
  }
  CHECK(answer.out.find("times real time") != std::string::npos);
}

TEST_CASE("a run in real time takes as long as it simulates, and reports how it kept pace") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const auto begin = std::chrono::steady_clock::now();
  const Answer answer = testing::springnet(folder, "run --realtime=5 pair.toml -o out");
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  CAPTURE(answer.out);
  CHECK(answer.status == 0);
  // Ten steps of 0.1 s; the last one starts at 0.9 s / 5. A slow machine takes longer, no machine less.
  CHECK(wall.count() >= 0.18);
  CHECK(answer.out.find("10 frames") != std::string::npos);
  const auto summary = testing::read_json(folder.path() / "out/summary.json");
  CHECK(summary["pace"]["frames"] == 10);
  CHECK(summary["pace"]["factor"] == 5.0);
  // The time spent waiting does not count.
  CHECK(summary["times_real_time"].get<double>() ==
        doctest::Approx(1.0 / summary["wall_s"].get<double>()).epsilon(1e-12));
}

TEST_CASE("a run that waits for the clock ends when asked to") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  // Without the request it would take a thousand seconds.
  const Answer answer = testing::shell(
      folder,
      "\"$SPRINGNET\" run pair.toml --realtime=0.001 -q -o out & tool=$!; "
      "while [ ! -e out/events.csv ] && kill -0 $tool; do sleep 0.05; done; kill -TERM $tool; wait $tool");
  CHECK(answer.status == 1);
  CHECK(answer.err.find("stopped at") != std::string::npos);
  const auto summary = testing::read_json(folder.path() / "out/summary.json");
  CHECK(summary["outcome"] == "stopped");
  CHECK(summary["pace"]["factor"] == 0.001);
}

TEST_CASE("convert writes the text that the run would have written") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  REQUIRE(testing::springnet(folder, "run pair.toml -q -o text").status == 0);
  REQUIRE(testing::springnet(folder, "run pair.toml -q -o binary --set 'output.format=\"binary\"'").status == 0);
  const Answer answer = testing::springnet(folder, "convert binary/trajectory.bin");
  CHECK(answer.status == 0);
  CHECK(answer.out == "binary/trajectory.csv: 11 records of 2 rows\n");
  const std::string text = testing::read_text(folder.path() / "text/trajectory.csv");
  CHECK(testing::read_text(folder.path() / "binary/trajectory.csv") == text);
  CHECK(testing::springnet(folder, "convert binary/trajectory.bin -q -o other.csv").out.empty());
  CHECK(testing::read_text(folder.path() / "other.csv") == text);
  const Answer same = testing::springnet(folder, "convert binary/trajectory.bin -o binary/trajectory.bin");
  CHECK(same.status == 2);
  CHECK(same.err.find("-o") != std::string::npos);
  CHECK(testing::springnet(folder, "convert text/trajectory.csv").status == 2);
}

TEST_CASE("singular and plural are right, and a run without a step has no speed") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer run = testing::springnet(folder, "run pair.toml --duration 0.1 -o out --set 'output.format=\"binary\"'");
  CAPTURE(run.out);
  CHECK(run.out.find("2 nodes, 1 spring\n") != std::string::npos);
  CHECK(run.out.find("): 1 step, ") != std::string::npos);
  const Answer convert =
      testing::springnet(folder,
                         "run pair.toml -q -o one --duration 1e-9 --time-step 1e-9 --set output.nodes.nodes=[1] "
                         "--set 'output.format=\"binary\"' && \"$SPRINGNET\" convert one/trajectory.bin");
  CAPTURE(convert.err);
  CHECK(convert.out == "one/trajectory.csv: 2 records of 1 row\n");
  // The first step fails.
  std::string scene = testing::pair_scene;
  scene.replace(scene.find("max_sweeps = 500"), 16, "update = \"synchronous\"");  // t^2 k / m is 2 below
  folder.write("fails.toml", scene);
  const Answer fails = testing::springnet(folder, "run fails.toml --duration 2 --time-step 1 -o fails");
  CAPTURE(fails.out);
  CHECK(fails.status == 1);
  CHECK(fails.out.find("0 times real time") == std::string::npos);
  CHECK(fails.out.find("(no time step): 0 steps") != std::string::npos);
}

TEST_CASE("--profile prints where the time goes, --trace writes its course") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  Answer answer = testing::springnet(folder, "run pair.toml --profile");
  CAPTURE(answer.out);
  CHECK(answer.status == 0);
  for (const char* text : {"where time goes", "share", "integrator recurrent", "view.html", "100.0 %"}) {
    CAPTURE(text);
    CHECK(answer.out.find(text) != std::string::npos);
  }
  CHECK(std::filesystem::exists(folder.path() / "results/pair/profile.json"));
  CHECK(!std::filesystem::exists(folder.path() / "results/pair/trace.json"));

  answer = testing::springnet(folder, "run pair.toml --trace");
  CHECK(answer.status == 0);
  CHECK(answer.out.find("where time goes") == std::string::npos);
  CHECK(!std::filesystem::exists(folder.path() / "results/pair/profile.json"));
  CHECK(testing::read_json(folder.path() / "results/pair/trace.json").contains("traceEvents"));
}
