// Checkpoints of runs: one that resumes writes the same bytes as one that was not disturbed.
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include <springnet/output.hpp>

#include "facts.hpp"
#include "saved_states.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::plugins;
using testing::TemporaryFolder;

namespace {

constexpr double every = 0.1;  // s, checkpoints

// All outputs of a net in which everything changes.
Scene eventful_scene(const SimulationOptions& options) {
  Scene scene;
  scene.network = testing::eventful();
  scene.options = options;
  scene.duration = 0.36;
  OutputOptions& output = scene.output;
  output.interval = 0.03;
  output.reactions = output.energies = output.states = output.vtk = output.force = true;
  output.vtk_interval = 0.07;
  output.law_states = find_law_states(scene.network, *plugins());
  for (SpringIndex s = 0; s < scene.network.springs().size(); ++s) output.springs.push_back(s);
  return scene;
}

// Stops at this time, if above 0.
RunSummary run(const Scene& scene, const std::filesystem::path& folder, bool resume, double time) {
  RunOptions options;
  options.folder = folder;
  options.scene_name = "eventful";
  options.checkpoint = resume ? 0.0 : every;
  options.resume = resume;
  if (time > 0.0) options.progress = [time](const RunProgress& now) { return now.time < time; };
  return run_scene(scene, plugins(), options);
}

std::map<std::string, std::string> files_in(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().filename() == "summary.json") continue;
    std::ostringstream text;
    text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
    files[std::filesystem::relative(entry.path(), folder).string()] = text.str();
  }
  return files;
}

void check_same(const std::filesystem::path& a, const std::filesystem::path& b) {
  const auto of_a = files_in(a), of_b = files_in(b);
  for (const auto& [name, text] : of_a) {
    CAPTURE(name);
    REQUIRE(of_b.contains(name));
    CHECK(of_b.at(name) == text);
  }
  CHECK(of_a.size() == of_b.size());
}

std::string refusal(const Scene& scene, const RunOptions& options) {
  try {
    run_scene(scene, plugins(), options);
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    return error.what();
  }
  return "";
}

RunOptions resuming(const std::filesystem::path& folder) {
  RunOptions options;
  options.folder = folder;
  options.resume = true;
  return options;
}

}  // namespace

TEST_CASE("a run that was stopped and resumed, several times, writes what an undisturbed one does") {
  for (const SimulationOptions& options : testing::all_methods()) {
    CAPTURE(options.integrator.id);
    const TemporaryFolder whole, parts;
    const Scene scene = eventful_scene(options);
    const RunSummary undisturbed = run(scene, whole.path(), false, 0);
    CHECK_FALSE(std::filesystem::exists(whole.path() / "checkpoint"));
    // Within the second interval, and just after the second checkpoint.
    CHECK(run(scene, parts.path(), false, 0.15).outcome == "stopped");
    CHECK(std::filesystem::exists(parts.path() / "checkpoint"));
    CHECK(run(scene, parts.path(), true, 0.21).outcome == "stopped");
    const RunSummary resumed = run(scene, parts.path(), true, 0);
    CHECK_FALSE(std::filesystem::exists(parts.path() / "checkpoint"));
    check_same(whole.path(), parts.path());
    CHECK(resumed.outcome == undisturbed.outcome);
    CHECK(resumed.records == undisturbed.records);
    CHECK(resumed.steps == undisturbed.steps);
    CHECK(resumed.sweeps == undisturbed.sweeps);
    CHECK(resumed.simulated == undisturbed.simulated);
    CHECK(resumed.bytes == undisturbed.bytes);
    CHECK(resumed.events.cut == undisturbed.events.cut);
    CHECK(resumed.events.ruptured == 1);
    CHECK(resumed.events.touched == undisturbed.events.touched);
    CHECK(resumed.events.touched > 0);
  }
}

TEST_CASE("what a run left behind its last checkpoint, also more pictures and parts of records, is cut off") {
  const TemporaryFolder whole, parts;
  const Scene scene = eventful_scene(testing::all_methods()[0]);
  run(scene, whole.path(), false, 0);
  run(scene, parts.path(), false, 0.25);
  std::ofstream(parts.path() / "events.csv", std::ios::app) << "0.3,touched,no" << std::string(100000, ' ');
  std::ofstream(parts.path() / "trajectory.csv", std::ios::app) << "0.27,0,1";
  std::ofstream(parts.path() / "vtk" / "net_000006.vtu") << "no picture";
  std::ofstream(parts.path() / "vtk" / "net_000007.vtu") << "no picture";
  std::ofstream(parts.path() / "summary.json") << "{}";
  run(scene, parts.path(), true, 0);
  check_same(whole.path(), parts.path());
}

TEST_CASE("a run in binary form resumes") {
  const TemporaryFolder whole, parts;
  Scene scene = eventful_scene(testing::all_methods()[0]);
  scene.output.format = OutputOptions::Format::binary;
  run(scene, whole.path(), false, 0);
  run(scene, parts.path(), false, 0.23);
  run(scene, parts.path(), true, 0);
  check_same(whole.path(), parts.path());
}

TEST_CASE("what cannot be resumed is told, and nothing is changed") {
  const TemporaryFolder folder;
  const Scene scene = eventful_scene(testing::all_methods()[0]);
  const auto refused = [&](const Scene& of, const char* facts) {
    const auto before = files_in(folder.path());
    const std::string message = refusal(of, resuming(folder.path()));
    INFO(message);
    CHECK(testing::has_facts(message, facts));
    CHECK(files_in(folder.path()) == before);
  };
  refused(scene, "checkpoint: there is none | --checkpoint");
  run(scene, folder.path(), false, 0.25);

  Scene other = scene;
  other.duration = 0.5;
  refused(other, "is of another run: duration: 0.36 s there, 0.5 s now");
  other = scene;
  other.output.vtk = false;
  refused(other, "is of another run: output files");
  other = scene;
  other.options.time_step = 0.004;
  refused(other, "is of another run: time step");
  // A table goes on under the header that it has.
  other = scene;
  other.output.velocity = !other.output.velocity;
  refused(other, "is of another run: columns of trajectory.csv: time,node,x,y,z | there, | now");
  other = scene;
  other.output.nodes = {1, 2};
  refused(other, "is of another run: output.nodes: all there, 2 ( | ): 1, 2 now");
  other = scene;
  other.output.springs = {0};
  refused(other, "is of another run");
  other = scene;
  other.output.format = OutputOptions::Format::binary;
  refused(other, "is of another run: output files: | trajectory.csv, | there, | trajectory.bin, | now");
  other = scene;
  other.title = "another title";
  refused(other, "is of another run: title");
  other = scene;
  other.options.integrator = testing::generalized_alpha();
  refused(other, "another simulation: integrator");

  RunOptions options = resuming(folder.path());
  options.checkpoint = 0.2;
  const auto all_files = files_in(folder.path());
  CHECK(testing::has_facts(refusal(scene, options), "--checkpoint is 0.2 s, and was 0.1 s"));
  CHECK(files_in(folder.path()) == all_files);
  options.resume = false;
  options.checkpoint = std::nan("");
  CHECK(testing::has_facts(refusal(scene, options), "checkpoint: must be a time above 0 s"));

  const std::filesystem::path checkpoint = folder.path() / "checkpoint";
  const std::string good = files_in(folder.path()).at("checkpoint");
  const auto put = [&](const std::string& bytes) { std::ofstream(checkpoint, std::ios::binary) << bytes; };
  put(good.substr(0, good.size() - 1));
  refused(scene, "checkpoint: is damaged: it has | bytes in place of");
  put(good.substr(0, 10));
  refused(scene, "checkpoint: is no checkpoint of springnet");
  std::string changed = good;
  changed[good.size() / 2] = static_cast<char>(changed[good.size() / 2] ^ 1);
  put(changed);
  refused(scene, "checkpoint: is damaged: its checksum is another one");
  put(good);
  std::filesystem::resize_file(folder.path() / "trajectory.csv", 100);
  refused(scene, "trajectory.csv: has 100 bytes, and had | at the checkpoint");
  std::filesystem::remove(folder.path() / "trajectory.csv");
  std::filesystem::create_symlink("events.csv", folder.path() / "trajectory.csv");
  CHECK(testing::has_facts(refusal(scene, resuming(folder.path())), "trajectory.csv: cannot be opened"));
}

TEST_CASE("a run that does not resume removes an earlier checkpoint, and one that has ended is not resumed") {
  const TemporaryFolder folder;
  const Scene scene = eventful_scene(testing::all_methods()[0]);
  run(scene, folder.path(), false, 0.25);
  REQUIRE(std::filesystem::exists(folder.path() / "checkpoint"));
  RunOptions plain;
  plain.folder = folder.path();
  CHECK(run_scene(scene, plugins(), plain).outcome == "settled");
  CHECK_FALSE(std::filesystem::exists(folder.path() / "checkpoint"));
  CHECK(testing::has_facts(refusal(scene, resuming(folder.path())), "there is none: the run has reached its end"));
}
