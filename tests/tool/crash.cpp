// A law that crashes: it is named with the springs it was called for, what was recorded is whole, the exit status is
// that of the signal.
#include <cmath>
#include <csignal>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "csv.hpp"
#include "tool.hpp"

// Sanitizers report crashes themselves.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

// Spring 1 grows by 1 m/s and is longer than 1.5 m after 0.5 s; spring 0 is of another law.
constexpr const char* crashing_scene = R"(
[simulation]
duration = 1.0
time_step = 0.01
[[body]]
name = "still"
nodes = [[0, 5, 0], [1, 5, 0]]
springs = [[0, 1]]
neuron = { type = "point_mass", mass = 2.0 }
spring = { type = "linear", stiffness = 4.0 }
[[body]]
name = "pulled"
nodes = [[0, 0, 0], [1, 0, 0]]
springs = [[0, 1]]
neuron = { type = "point_mass", mass = 2.0 }
spring = { type = "crashing", how = 0 }
[[fix]]
select = { body = "still" }
[[fix]]
select = { body = "pulled", nodes = [0] }
[[move]]
select = { body = "pulled", nodes = [1] }
table = [[0, 0, 0, 0], [1, 1, 0, 0]]
[output]
springs = { body = "pulled" }
)";

Answer run(const TemporaryFolder& folder, const std::string& options) {
  return testing::shell(folder, "ulimit -c 0; \"$SPRINGNET\" run crashing.toml -o out --plugins '" SPRINGNET_CRASHING
                                "' " +
                                    options + "; exit $?");
}

}  // namespace

TEST_CASE("a law that crashes is named, and its records are kept, by every signal and integrator") {
  struct Crash {
    int how, signal;
    const char* name;
  };
  for (const char* integrator : {"recurrent", "verlet", "cvode"}) {
    for (const Crash& crash : {Crash{0, SIGSEGV, "SIGSEGV"}, Crash{1, SIGABRT, "SIGABRT"}, Crash{2, SIGFPE, "SIGFPE"},
                               Crash{3, SIGILL, "SIGILL"}, Crash{4, SIGBUS, "SIGBUS"}}) {
      if (crash.how > 0 && std::string(integrator) != "recurrent") continue;
      CAPTURE(integrator);
      CAPTURE(crash.name);
      const TemporaryFolder folder;
      folder.write("crashing.toml", crashing_scene);
      const Answer answer =
          run(folder, fmt::format("-q --integrator {} --set body.1.spring.how={}", integrator, crash.how));
      CAPTURE(answer.err);
      CHECK(answer.status == 128 + crash.signal);  // as shells say
      const std::size_t begin = answer.err.find("springnet: error: ");
      REQUIRE(begin != std::string::npos);
      const std::string line = answer.err.substr(begin, answer.err.find('\n', begin) - begin);
      for (const char* part :
           {"spring function 'crashing' of plugin org.example.crashing", SPRINGNET_CRASHING "/crashing.springnet.so",
            crash.name, "kept in out", "springnet plugin check"}) {
        CAPTURE(part);
        CHECK(line.find(part) != std::string::npos);
      }
      // Spring 1 alone has the law; some integrators ask for the springs of node 2 or 3.
      const bool of_springs = line.find("called for springs 1;") != std::string::npos;
      const bool of_nodes = line.find("called for springs of nodes 2, 3;") != std::string::npos ||
                            line.find("called for springs of nodes 3;") != std::string::npos;
      CHECK((of_springs || of_nodes));
      // All records before the step that crashed, each whole.
      const std::string text = testing::read_text(folder.path() / "out/trajectory.csv");
      CHECK(text.ends_with('\n'));
      const testing::Csv csv = testing::read_csv(folder.path() / "out/trajectory.csv");
      REQUIRE(csv.rows.size() % 4 == 0);
      const double last = csv.number(csv.rows.size() - 1, 0);
      CHECK(last > 0.45);
      CHECK(last < 0.515);
      CHECK(csv.rows.size() == 4 * static_cast<std::size_t>(std::lround(last / 0.01) + 1));
      CHECK(testing::read_text(folder.path() / "out/springs.csv").ends_with('\n'));
      CHECK_FALSE(std::filesystem::exists(folder.path() / "out/summary.json"));
    }
  }
}

// The handler cannot run on a stack that is used up: each thread needs another one.
TEST_CASE("a law that recurses until its thread has no stack left is named, in whatever thread and in a worker") {
  for (const int how : {5, 6}) {
    CAPTURE(how);
    const TemporaryFolder folder;
    // Long enough to crash, and so many nodes that both threads have some.
    folder.write("crashing.toml", R"(
[simulation]
duration = 1.0
time_step = 0.01
[[body]]
name = "net"
mesh = { lattice = [100, 100, 2], spacing = 2.0 }
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "crashing", how = 0 }
[output]
view = false
)");
    const Answer answer = run(folder, fmt::format("-q --threads 2 --set body.0.spring.how={}", how));
    CAPTURE(answer.err);
    CHECK(answer.status == 128 + SIGSEGV);
    CHECK(answer.err.find("spring function 'crashing' of plugin org.example.crashing") != std::string::npos);
    CHECK(answer.err.find("called for springs ") != std::string::npos);
  }
}

TEST_CASE("the next run in the folder of a crashed one works") {
  const TemporaryFolder folder;
  folder.write("crashing.toml", crashing_scene);
  CHECK(run(folder, "-q").status == 128 + SIGSEGV);
  CHECK(run(folder, "-q --duration 0.3").status == 0);
  CHECK(testing::read_json(folder.path() / "out/summary.json")["outcome"] != "stopped");
}

TEST_CASE("a signal that was ignored at the start, or comes from elsewhere, does what it did") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::shell(
      folder,
      "ulimit -c 0; \"$SPRINGNET\" run pair.toml --realtime=0.001 -q -o out & tool=$!; "
      "while [ ! -e out/events.csv ] && kill -0 $tool; do sleep 0.02; done; kill -SEGV $tool; wait $tool; exit $?");
  CHECK(answer.status == 128 + SIGSEGV);
  CHECK(answer.err.find("springnet crashed (SIGSEGV") != std::string::npos);
}

#endif
