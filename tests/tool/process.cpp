// What happens to the tool's process: signals, limits, pipes that close, standard streams that are closed.
#include <unistd.h>

#include <csignal>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "csv.hpp"
#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

// Starts a run by `tool`, which does not end by itself, and waits until it has begun.
std::string start_run(const std::string& tool, const std::string& then) {
  return tool +
         " \"$SPRINGNET\" run pair.toml --realtime=0.001 -q -o out & tool=$!; "
         "while [ ! -e out/events.csv ] && kill -0 $tool; do sleep 0.02; done; " +
         then + "; wait $tool";
}

}  // namespace

TEST_CASE("a closed terminal and the limit of processor time stop a run in order, as Ctrl-C does") {
  for (const char* signal : {"HUP", "XCPU", "TERM", "INT"}) {
    CAPTURE(signal);
    const TemporaryFolder folder;
    folder.write("pair.toml", testing::pair_scene);
    // A shell without job control ignores Ctrl-C for background commands.
    const std::string tool = "env --default-signal=INT";
    const Answer answer = testing::shell(folder, start_run(tool, fmt::format("kill -{} $tool", signal)));
    CHECK(answer.status == 1);
    CHECK(answer.err.find("stopped at") != std::string::npos);
    CHECK(testing::read_json(folder.path() / "out/summary.json")["outcome"] == "stopped");
  }
}

TEST_CASE("signals that the system repeats do not kill the process") {
  for (const char* signal : {"HUP", "XCPU"}) {
    const TemporaryFolder folder;
    folder.write("pair.toml", testing::pair_scene);
    const Answer answer =
        testing::shell(folder, start_run("", fmt::format("kill -{0} $tool; kill -{0} $tool; kill -{0} $tool", signal)));
    CHECK(answer.status == 1);
    CHECK(testing::read_json(folder.path() / "out/summary.json")["outcome"] == "stopped");
  }
}

TEST_CASE("a signal that is ignored at the start, as by nohup, stays ignored") {
  for (const char* signal : {"HUP", "XCPU", "INT"}) {
    CAPTURE(signal);
    const TemporaryFolder folder;
    folder.write("pair.toml", testing::pair_scene);
    const Answer answer = testing::shell(
        folder, fmt::format("trap '' {0}; \"$SPRINGNET\" run pair.toml --realtime=5 -q -o out & tool=$!; "
                            "while [ ! -e out/events.csv ] && kill -0 $tool; do sleep 0.02; done; kill -{0} $tool; "
                            "wait $tool",
                            signal));
    CHECK(answer.status == 0);
    CHECK(testing::read_json(folder.path() / "out/summary.json")["outcome"] == "settled");
  }
}

TEST_CASE("a closed pipe ends the printing, not the run") {
  for (const char* read : {"2>&1 | head -n 1", "2>&1 | true", "| true"}) {
    CAPTURE(read);
    const TemporaryFolder folder;
    folder.write("pair.toml", testing::pair_scene);
    const Answer answer = testing::shell(
        folder, fmt::format("{{ \"$SPRINGNET\" run pair.toml -o out --realtime=5; echo $? > status; }} {}", read));
    CHECK(testing::read_text(folder.path() / "status") == "0\n");
    CHECK(testing::read_json(folder.path() / "out/summary.json")["outcome"] == "settled");
    CHECK(answer.err.find("error") == std::string::npos);
  }
}

TEST_CASE("a requested summary that cannot be printed is a failure, after the run") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  // Standard output is a pipe without a reader by the time it is written.
  const Answer answer = testing::shell(
      folder,
      "{ \"$SPRINGNET\" run pair.toml --json -o out --realtime=5 2> error; echo $? > status; } | true; sleep 0.01; "
      "while [ ! -s status ]; do sleep 0.02; done; cat error >&2");
  CHECK(testing::read_text(folder.path() / "status") == "1\n");
  CHECK(answer.err.find("the standard output cannot be written") != std::string::npos);
  CHECK(testing::read_json(folder.path() / "out/summary.json")["outcome"] == "settled");
}

TEST_CASE("with closed standard streams, nothing that is printed ends up in a table") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene + std::string("[[plane]]\npoint = [0, 0, -5]\nnormal = [0, 0, 1]\n"));
  CHECK(testing::shell(folder, "\"$SPRINGNET\" run pair.toml -q -o open").status == 0);
  for (const char* closed : {"<&- >&- 2>&-", ">&- 2>&-", "2>&-", "<&-"}) {
    CAPTURE(closed);
    const bool output = std::string(closed).find(">&- 2") != std::string::npos;
    // A run that fails to print its results says so in its status.
    CHECK(testing::shell(folder, fmt::format("\"$SPRINGNET\" run pair.toml -o out {}", closed)).status ==
          (output ? 1 : 0));
    for (const char* name : {"events.csv", "trajectory.csv", "surfaces.csv"}) {
      CHECK(testing::read_text(folder.path() / "out" / name) == testing::read_text(folder.path() / "open" / name));
    }
  }
}

TEST_CASE("no file that a run opens takes the place of a closed standard stream") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer =
      testing::shell(folder,
                     "(exec \"$SPRINGNET\" run pair.toml --realtime=0.001 -q -o out <&- >&- 2>&-) & tool=$!; "
                     "while [ ! -e out/events.csv ] && kill -0 $tool; do sleep 0.02; done; "
                     "for stream in 0 1 2; do readlink /proc/$tool/fd/$stream; done; kill -TERM $tool; wait $tool");
  CHECK(answer.out == "/dev/null\n/dev/null\n/dev/null\n");
}

TEST_CASE("two runs in one folder: the second one has status 2, also of validate") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::shell(
      folder, start_run("",
                        "\"$SPRINGNET\" run pair.toml -q -o out; echo $?; \"$SPRINGNET\" validate pair.toml -q -o out; "
                        "echo $?; kill -KILL $tool; wait $tool; \"$SPRINGNET\" run pair.toml -q -o out; echo $?; "
                        "true & tool=$!"));
  CHECK(answer.out == "2\n2\n0\n");  // a run that was killed leaves no lock
  CHECK(answer.err.find("out: another run") != std::string::npos);
}

TEST_CASE("validate replaces links, and detects a folder with the name of its files before it computes") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  folder.write("victim", "mine");
  std::filesystem::create_directory(folder.path() / "out");
  for (const char* name : {"validation.json", "report.html", "validation.json.part", "report.html.part"}) {
    std::filesystem::create_symlink("../victim", folder.path() / "out" / name);
  }
  CHECK(testing::springnet(folder, "validate pair.toml -q -o out").status == 0);
  CHECK(testing::read_text(folder.path() / "victim") == "mine");
  CHECK(testing::read_json(folder.path() / "out/validation.json")["runs"].size() == 3);
  for (const char* name : {"validation.json", "report.html"}) {
    const std::filesystem::path taken = folder.path() / "taken";
    std::filesystem::create_directories(taken / name);
    const Answer answer = testing::springnet(folder, "validate pair.toml -q -o taken");
    CHECK(answer.status == 2);
    CHECK(answer.err.find(std::string(name) + ": a folder has the name of this file") != std::string::npos);
    std::filesystem::remove(taken / name);
  }
}

TEST_CASE("convert follows only a link that the user names") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  REQUIRE(testing::springnet(folder, "run pair.toml -q -o out --set 'output.format=\"binary\"'").status == 0);
  folder.write("victim", "mine");
  std::filesystem::create_symlink("../victim", folder.path() / "out/trajectory.csv");
  CHECK(testing::springnet(folder, "convert out/trajectory.bin -q").status == 0);
  CHECK(testing::read_text(folder.path() / "victim") == "mine");
  CHECK_FALSE(std::filesystem::is_symlink(folder.path() / "out/trajectory.csv"));
  const std::string text = testing::read_text(folder.path() / "out/trajectory.csv");
  CHECK(testing::springnet(folder, "convert out/trajectory.bin -q -o /dev/stdout").out == text);
}

#if !defined(__SANITIZE_ADDRESS__)  // which reserves more memory than any limit
TEST_CASE("running out of memory is reported, wherever it happens") {
  const TemporaryFolder folder;
  folder.write("block.toml", R"([simulation]
duration = 0.1
time_step = 0.1
[[body]]
name = "block"
mesh = { lattice = [30, 30, 30], spacing = 0.01 }
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "linear", stiffness = 1.0 }
)");
  int failed = 0;
  for (const char* integrator : {"recurrent", "cvode"}) {
    // Memory runs out while the scene is read, the simulation is created or a step is made; or it just suffices.
    for (const int limit : {45000, 48000, 51000, 54000, 57000, 60000, 65000, 75000}) {
      CAPTURE(limit);
      const Answer answer = testing::shell(
          folder, fmt::format("ulimit -v {}; \"$SPRINGNET\" run block.toml --integrator {} --threads 1 -q -o out",
                              limit, integrator));
      CAPTURE(answer.err);
      CHECK((answer.status == 0 || answer.status == 1));
      if (answer.status == 0) continue;
      ++failed;
      CHECK(answer.err.find("out of memory: ") != std::string::npos);
    }
  }
  CHECK(failed > 1);
}
#endif
