#include <algorithm>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <springnet/output.hpp>

#include "csv.hpp"
#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::plugins;
using testing::TemporaryFolder;

namespace {

// A fixed node, and one that hangs from it by a spring along x, at rest.
Scene pair() {
  Scene scene;
  const MaterialIndex material =
      scene.network.add_material({LawUse{"linear", {{"stiffness", 4.0}}}, LawUse{"linear", {{"damping", 0.5}}}});
  scene.network.add_node({});
  Node second;
  second.position = Vector3(1.0, 0.0, 0.0);
  scene.network.add_node(second);
  scene.network.add_spring(0, 1, material);
  scene.network.fix(0);
  scene.duration = 1.0;
  scene.options.time_step = 0.1;
  scene.options.threads = 1;
  return scene;
}

RunSummary run(const Scene& scene, const TemporaryFolder& folder) {
  return run_scene(scene, plugins(), {folder.path(), "pair", {}});
}

}  // namespace

TEST_CASE("the trajectory has the states of a simulation stepped by hand, bit for bit") {
  const TemporaryFolder folder;
  Scene scene = pair();
  scene.network.set_gravity({1.0, 0.5, -0.25});
  run(scene, folder);
  const testing::Csv csv = testing::read_csv(folder.path() / "trajectory.csv");
  CHECK(csv.header == "time,node,x,y,z,vx,vy,vz");
  REQUIRE(csv.rows.size() == 22);  // 11 records of two nodes

  Simulation simulation(scene.network, plugins(), scene.options);
  for (std::size_t record = 0; record <= 10; ++record) {
    if (record > 0) simulation.step();
    for (NodeIndex node = 0; node < 2; ++node) {
      const std::size_t row = 2 * record + node;
      CHECK(csv.rows[row].size() == 8);
      // The run ends at the duration itself, the tenth step at ten time steps: a rounding apart.
      CHECK(csv.number(row, 0) == doctest::Approx(simulation.time()).epsilon(1e-15));
      CHECK(csv.number(row, 1) == node);
      if (record == 10) continue;
      for (int axis = 0; axis < 3; ++axis) {
        CHECK(csv.number(row, static_cast<std::size_t>(2 + axis)) == simulation.position(node)[axis]);
        CHECK(csv.number(row, static_cast<std::size_t>(5 + axis)) == simulation.velocity(node)[axis]);
      }
    }
  }
}

TEST_CASE("records are made at the first time step at or after each multiple of the interval, and at the end") {
  const TemporaryFolder folder;
  Scene scene = pair();
  scene.output.interval = 0.25;
  run(scene, folder);
  const testing::Csv csv = testing::read_csv(folder.path() / "trajectory.csv");
  std::vector<double> times;
  for (std::size_t row = 0; row < csv.rows.size(); row += 2) times.push_back(csv.number(row, 0));
  const std::vector<double> expected{0.0, 0.3, 0.5, 0.8, 1.0};
  REQUIRE(times.size() == expected.size());
  for (std::size_t k = 0; k < times.size(); ++k) CHECK(times[k] == doctest::Approx(expected[k]).epsilon(1e-12));
}

TEST_CASE("a duration that is not a multiple of the time step is reached exactly") {
  const TemporaryFolder folder;
  Scene scene = pair();
  scene.duration = 0.95;
  const RunSummary summary = run(scene, folder);
  CHECK(summary.simulated == 0.95);
  CHECK(summary.steps == 10);
  CHECK(summary.records == 11);
  const testing::Csv csv = testing::read_csv(folder.path() / "trajectory.csv");
  CHECK(csv.number(csv.rows.size() - 1, 0) == 0.95);
}

TEST_CASE("a duration of zero records the start") {
  const TemporaryFolder folder;
  Scene scene = pair();
  scene.duration = 0.0;
  const RunSummary summary = run(scene, folder);
  CHECK(summary.records == 1);
  CHECK(summary.steps == 0);
  CHECK(summary.outcome == "settled");
}

TEST_CASE("reactions balance what pulls at a fixed node") {
  const TemporaryFolder folder;
  Scene scene = pair();
  scene.duration = 60.0;  // damped for 30 time constants of 2 m / d: at rest
  scene.options.time_step = 0.05;
  scene.output.reactions = true;
  scene.network.set_gravity({1.5, 0.0, 0.0});
  run(scene, folder);
  const testing::Csv csv = testing::read_csv(folder.path() / "reactions.csv");
  CHECK(csv.header == "time,node,fx,fy,fz,tx,ty,tz,jx,jy,jz,surface");
  REQUIRE(csv.rows.size() == 1201);  // the fixed node only
  const std::size_t last = csv.rows.size() - 1;
  CHECK(csv.rows[last][1] == "0");
  // Weight of both nodes, 1 kg each. Within the settling tolerance of a step, 1e-6 of the force scale.
  CHECK(csv.number(last, 2) == doctest::Approx(-3.0).epsilon(1e-5));
  CHECK(csv.number(last, 3) == doctest::Approx(0.0));
}

TEST_CASE("cuts and contacts are counted and listed with the user's numbers") {
  const TemporaryFolder folder;
  Scene scene = pair();
  scene.duration = 2.0;
  scene.network.set_gravity({0.0, 0.0, -10.0});
  scene.network.add_plane({"ground", Vector3(0.0, 0.0, -1.0), Vector3::UnitZ()});
  scene.network.add_cut({0.3, {0}, {}});
  const RunSummary summary = run(scene, folder);
  CHECK(summary.events.cut == 1);
  CHECK(summary.events.touched == 1);
  CHECK(summary.events.ruptured == 0);
  CHECK(summary.springs == 1);
  CHECK(summary.springs_left == 0);
  const testing::Csv csv = testing::read_csv(folder.path() / "events.csv");
  CHECK(csv.header == "time,event,element,index,surface,jx,jy,jz,x,y,z,vx,vy,vz,nx,ny,nz,value,force,pair");
  REQUIRE(csv.rows.size() == 2);
  CHECK(csv.number(0, 0) == doctest::Approx(0.3));
  CHECK(csv.rows[0][1] == "cut");
  CHECK(csv.rows[0][2] == "spring");
  CHECK(csv.rows[0][3] == "0");
  CHECK(csv.rows[1][1] == "touched");
  CHECK(csv.rows[1][2] == "node");
  CHECK(csv.rows[1][3] == "1");
}

TEST_CASE("files that the scene does not request do not exist, not even old ones") {
  const TemporaryFolder folder;
  Scene scene = pair();
  scene.output.reactions = true;
  run(scene, folder);
  CHECK(std::filesystem::exists(folder.path() / "reactions.csv"));
  scene.output.reactions = false;
  scene.output.trajectory = false;
  scene.output.view = false;
  const RunSummary summary = run(scene, folder);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "reactions.csv"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "view.html"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "trajectory.csv"));
  CHECK(summary.files == std::vector<std::string>{"events.csv", "summary.json"});
}

TEST_CASE("a run that is stopped keeps what was written") {
  const TemporaryFolder folder;
  const Scene scene = pair();
  const RunSummary summary =
      run_scene(scene, plugins(), {folder.path(), "pair", [](const RunProgress& now) { return now.steps < 4; }});
  CHECK(summary.outcome == "stopped");
  CHECK_FALSE(summary.failure);
  CHECK(summary.simulated == doctest::Approx(0.4));
  CHECK(testing::read_csv(folder.path() / "trajectory.csv").rows.size() == 10);
  CHECK(nlohmann::json::parse(testing::read_text(folder.path() / "summary.json"))["outcome"] == "stopped");
}

TEST_CASE("a run that is stopped between two records has its last state and all events in the tables") {
  for (const bool paced : {false, true}) {
    CAPTURE(paced);
    const TemporaryFolder folder;
    Scene scene = pair();
    scene.output.interval = 0.8;
    scene.network.set_gravity({0.0, 0.0, -1.0});
    scene.network.add_cut({0.25, {0}, {}});
    RunOptions options{folder.path(), "pair", [](const RunProgress& now) { return now.steps < 4; }};
    double clock = 0.0;
    if (paced) {
      // Stopped while it waits for the clock.
      options.realtime = 0.01;
      options.clock = {[&] { return clock; }, [&](double until) { clock = until; }};
    }
    const RunSummary summary = run_scene(scene, plugins(), options);
    CHECK(summary.outcome == "stopped");
    CHECK(summary.records == 2);
    const testing::Csv states = testing::read_csv(folder.path() / "trajectory.csv");
    REQUIRE(states.rows.size() == 4);
    CHECK(states.number(3, 0) == summary.simulated);
    CHECK(states.number(3, 0) == doctest::Approx(0.4));
    const testing::Csv events = testing::read_csv(folder.path() / "events.csv");
    REQUIRE(events.rows.size() == 1);
    CHECK(events.rows[0][1] == "cut");
  }
}

TEST_CASE("a text table can be read during the run") {
  const TemporaryFolder folder;
  const Scene scene = pair();
  RunOptions options{folder.path(), "pair", {}};
  std::size_t seen = 0;
  options.progress = [&](const RunProgress&) {
    for (const char* name : {"trajectory.csv", "events.csv"}) {
      CHECK(testing::read_text(folder.path() / name).starts_with("time,"));
    }
    ++seen;
    return true;
  };
  run_scene(scene, plugins(), options);
  CHECK(seen == 10);
}

TEST_CASE("a summary that cannot be written does not exist, and is a failure") {
  const TemporaryFolder folder;
  RunOptions options{folder.path(), "pair", {}};
  options.progress = [&](const RunProgress& now) {
    // The obstruction appears during the run.
    if (now.steps == 5) std::filesystem::create_directory(folder.path() / "summary.json");
    return true;
  };
  const RunSummary summary = run_scene(pair(), plugins(), options);
  CHECK(summary.failure == ErrorKind::simulation);
  CHECK(summary.error.find("summary.json: cannot be written") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "summary.json.part"));
  CHECK(std::count(summary.files.begin(), summary.files.end(), "summary.json") == 0);
}

TEST_CASE("unused output options are noted") {
  const auto has = [](const Scene& scene, const char* key) {
    const std::vector<std::string> notes = notes_of(scene);
    return std::count_if(notes.begin(), notes.end(),
                         [&](const std::string& note) { return note.find(key) != std::string::npos; }) == 1;
  };
  Scene scene = pair();
  CHECK(notes_of(scene).empty());
  scene.output.precision = OutputOptions::Precision::float32;
  CHECK(has(scene, "output.precision"));
  scene.output.format = OutputOptions::Format::binary;
  CHECK_FALSE(has(scene, "output.precision"));
  scene.output.format = OutputOptions::Format::csv;
  scene.output.vtk_interval = 0.5;
  CHECK(has(scene, "output.vtk_interval"));
  scene.output.vtk = true;
  CHECK(notes_of(scene).empty());
}

TEST_CASE("a run that fails midway keeps its output, and reports it") {
  const TemporaryFolder folder;
  Scene scene = pair();
  // At rest until a load pulls at 0.5 s; then one step needs more sweeps than allowed.
  scene.options.integrator = {"recurrent", {{"update", testing::wavefront}, {"max_sweeps", 2.0}}};
  Load load;
  load.nodes = {1};
  load.force = Vector3(100.0, 0.0, 0.0);
  load.from = 0.5;
  scene.network.add_load(load);
  const RunSummary summary = run(scene, folder);
  CHECK(summary.failure == ErrorKind::simulation);
  CHECK(summary.outcome == "out of sweeps");
  CHECK(summary.error.find("0.5") != std::string::npos);
  CHECK(summary.simulated == doctest::Approx(0.5));
  CHECK(testing::read_csv(folder.path() / "trajectory.csv").rows.size() == 12);
  const auto json = nlohmann::json::parse(testing::read_text(folder.path() / "summary.json"));
  CHECK(json["outcome"] == "out of sweeps");
  CHECK(json["error"] == summary.error);
  CHECK(json["simulated_s"] == summary.simulated);
}

TEST_CASE("time steps accepted without having settled show in outcome and count") {
  const TemporaryFolder folder;
  Scene scene = pair();
  scene.options.integrator = {
      "recurrent", {{"update", testing::wavefront}, {"max_sweeps", 2.0}, {"unsettled", testing::on_unsettled_accept}}};
  Load load;
  load.nodes = {1};
  load.force = Vector3(1.0, 0.0, 0.0);
  load.until = 0.3;
  scene.network.add_load(load);
  const RunSummary summary = run(scene, folder);
  CHECK_FALSE(summary.failure);
  CHECK(summary.simulated == 1.0);
  CHECK(summary.outcome == "out of sweeps");
  CHECK(summary.unsettled >= 3);
  CHECK(summary.choices.at("unsettled") == "accept");
}

TEST_CASE("time steps that were divided are counted, with the smaller steps") {
  const TemporaryFolder folder;
  Scene scene = pair();
  // t^2 k / m is 4 in the first step: far beyond what synchronous propagation settles with.
  scene.options.time_step = 1.0;
  scene.duration = 3.0;
  scene.network.set_gravity({1.0, 0.0, 0.0});
  scene.options.integrator = {"recurrent",
                              {{"update", testing::synchronous}, {"unsettled", testing::on_unsettled_adapt}}};
  const RunSummary summary = run(scene, folder);
  CHECK_FALSE(summary.failure);
  CHECK(summary.steps == 3);
  CHECK(summary.divided > 0);

  Simulation simulation(scene.network, plugins(), scene.options);
  std::uint64_t divided = 0, substeps = 0, stages = 0;
  for (int k = 0; k < 3; ++k) {
    const StepReport& report = simulation.step();
    divided += report.substeps > 0 ? 1 : 0;
    substeps += report.substeps;
    stages += report.stages;
  }
  CHECK(summary.divided == divided);
  CHECK(summary.substeps == substeps);
  CHECK(summary.substeps >= 2 * divided);
  CHECK(summary.stages == stages);
  const auto json = nlohmann::json::parse(testing::read_text(folder.path() / "summary.json"));
  CHECK(json["divided_steps"] == divided);
  CHECK(json["substeps"] == substeps);
  CHECK(json["stages"] == stages);
}

TEST_CASE("the summary has the largest residual of all steps and that of the last") {
  const TemporaryFolder folder;
  Scene scene = pair();
  scene.network.set_gravity({1.0, 0.0, 0.0});
  scene.options.integrator = testing::recurrent(testing::wavefront, 1e-6);
  run(scene, folder);
  Simulation simulation(scene.network, plugins(), scene.options);
  double largest = 0.0, last = 0.0;
  for (int k = 0; k < 10; ++k) {
    last = simulation.step().residual;
    largest = std::max(largest, last);
  }
  REQUIRE(last > 0.0);
  REQUIRE(last < largest);
  const auto json = nlohmann::json::parse(testing::read_text(folder.path() / "summary.json"));
  CHECK(json["largest_residual_n"] == largest);
  CHECK(json["last_residual_n"] == last);
}

TEST_CASE("the summary is complete") {
  const TemporaryFolder folder;
  const RunSummary summary = run(pair(), folder);
  const auto json = nlohmann::json::parse(testing::read_text(folder.path() / "summary.json"));
  CHECK(json == nlohmann::json::parse(to_json(summary)));
  CHECK(json["scene"] == "pair");
  CHECK(json["nodes"] == 2);
  CHECK(json["springs"] == 1);
  CHECK(json["steps"] == 10);
  CHECK(json["simulated_s"] == 1.0);
  CHECK(json["outcome"] == "settled");
  CHECK(json["error"].is_null());
  CHECK(json["ruptured"] == 0);
  CHECK(json["cut"] == 0);
  CHECK(json["integrator"]["name"] == "recurrent");
  CHECK(json["time_step_s"] == 0.1);
  CHECK(json["threads"] == 1);
  CHECK(json["wall_s"].get<double>() > 0.0);
  CHECK(json["spring_updates_per_s"].get<double>() > 0.0);
  const double sweeps = json["sweeps"];
  CHECK(json["sweeps_per_step"] == sweeps / 10.0);
  // Integrator, neuron, spring function, viscosity function: four plugins, or fewer where one offers several.
  REQUIRE(json["plugins"].size() >= 1);
  for (const auto& plugin : json["plugins"]) {
    CHECK_FALSE(plugin["id"].get<std::string>().empty());
    CHECK(plugin["file"].get<std::string>().ends_with(".springnet.so"));
    CHECK(plugin["file"].get<std::string>().find('/') == std::string::npos);
  }
}

TEST_CASE("elements removed with a spring are counted separately, and a volume is summarised") {
  // Two triangles with three areas each, so that there are more elements than springs; beside them a filled
  // tetrahedron.
  const TemporaryFolder folder;
  Scene scene;
  Network& net = scene.network;
  const MaterialIndex material = net.add_material({LawUse{"linear", {{"stiffness", 4.0}}}, std::nullopt});
  for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(1, 1, 0), Vector3(5, 0, 0),
                           Vector3(6, 0, 0), Vector3(5, 1, 0), Vector3(5, 0, 1)}) {
    Node node;
    node.position = p;
    net.add_node(node);
  }
  for (const auto& [a, b] : {std::pair{0u, 1u}, {1u, 2u}, {2u, 0u}, {1u, 3u}, {3u, 2u}}) net.add_spring(a, b, material);
  for (int i = 0; i < 3; ++i) {
    net.add_element(Invariant::area, {0, 1, 2}, material);
    net.add_element(Invariant::area, {1, 3, 2}, material);
  }
  const ElementIndex filling =
      net.add_element(Invariant::enclosed_volume, {4, 6, 5, 4, 5, 7, 4, 7, 6, 5, 6, 7}, material);
  scene.elements.push_back({"filling", filling, 1});
  Cut cut;
  cut.time = 0.25;
  cut.springs = {0};
  net.add_cut(cut);
  scene.duration = 1.0;
  scene.options.time_step = 0.1;
  const RunSummary summary = run(scene, folder);
  CHECK_FALSE(summary.failure);
  CHECK(summary.events.cut == 1);
  CHECK(summary.events.elements_removed == 3);  // those of the first triangle
  CHECK(std::filesystem::exists(folder.path() / "view.html"));
  REQUIRE(summary.volumes.size() == 1);
  CHECK(summary.volumes[0].name == "filling");
  CHECK(summary.volumes[0].first == doctest::Approx(1.0 / 6.0));
  CHECK(summary.volumes[0].last == doctest::Approx(1.0 / 6.0));  // at rest from the start
}

TEST_CASE("the profile of a run has its outputs, and its trace opens; without options there is neither") {
  const TemporaryFolder folder;
  const Scene scene = pair();
  RunOptions options{folder.path(), "pair", {}};
  options.profile = options.trace = true;
  const RunSummary profiled = run_scene(scene, plugins(), options);
  const std::string trajectory = testing::read_text(folder.path() / "trajectory.csv");
  REQUIRE(profiled.profile);
  CHECK(std::count(profiled.files.begin(), profiled.files.end(), "profile.json") == 1);
  CHECK(std::count(profiled.files.begin(), profiled.files.end(), "trace.json") == 1);

  const auto document = nlohmann::json::parse(testing::read_text(folder.path() / "profile.json"));
  CHECK(document.at("steps") == 10);
  std::vector<std::string> paths;
  double own = 0.0;
  for (const auto& stage : document.at("stages")) {
    paths.push_back(stage.at("path"));
    own += stage.at("own_share").get<double>();
  }
  CHECK(own == doctest::Approx(1.0).epsilon(1e-9));
  for (const char* path : {"run", "run/set up", "run/step", "run/step/integrator recurrent/sweep", "run/record",
                           "run/record/trajectory.csv", "run/record/view.html", "run/close/view.html"}) {
    CAPTURE(path);
    CHECK(std::count(paths.begin(), paths.end(), path) == 1);
  }
  const auto trace = nlohmann::json::parse(testing::read_text(folder.path() / "trace.json"));
  const auto& events = trace.at("traceEvents");
  CHECK(std::count_if(events.begin(), events.end(), [](const auto& event) { return event.at("name") == "step"; }) ==
        10);

  // The next run removes the files of this one, and writes the same without its own.
  const RunSummary plain = run(scene, folder);
  CHECK(!plain.profile);
  CHECK(!std::filesystem::exists(folder.path() / "profile.json"));
  CHECK(!std::filesystem::exists(folder.path() / "trace.json"));
  CHECK(testing::read_text(folder.path() / "trajectory.csv") == trajectory);
}
