// Runs that run out of memory at any point.
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <springnet/output.hpp>

#include "csv.hpp"
#include "nets.hpp"
#include "short_of_memory.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::plugins;
using testing::TemporaryFolder;

TEST_CASE("a run that is out of memory keeps complete records, and reports it") {
  Scene scene;
  scene.network = testing::chain(4, {0, 0, 0}, {1, 0, 0}, testing::damped(40.0, 0.5));
  scene.network.fix(0);
  scene.network.set_gravity({0, 0, -10});
  scene.network.add_plane({"ground", Vector3(0, 0, -0.1), Vector3::UnitZ()});
  scene.network.add_cut({0.25, {1}, {}});
  scene.duration = 0.5;
  scene.options.time_step = 0.05;
  scene.options.threads = 1;
  scene.output.vtk = true;
  scene.output.view_size = 1.2e6;
  int failed = 0;
  // From here on it fails at the 1st, 2nd, … allocation of a step and of the record after it.
  for (int allocation = 0; allocation < 60; ++allocation) {
    CAPTURE(allocation);
    const TemporaryFolder folder;
    RunOptions options{folder.path(), "chain", {}};
    options.progress = [&](const RunProgress& now) {
      testing::allocations_left = now.steps == 4 ? allocation : -1;
      return true;
    };
    const RunSummary summary = run_scene(scene, plugins(), options);
    testing::allocations_left = -1;
    const testing::Csv csv = testing::read_csv(folder.path() / "trajectory.csv");
    CHECK(testing::read_text(folder.path() / "trajectory.csv").ends_with('\n'));
    CHECK(csv.rows.size() % 4 == 0);
    CHECK(csv.rows.size() >= 5 * 4);
    CHECK(testing::read_text(folder.path() / "vtk/run.pvd").ends_with("</VTKFile>\n"));
    const auto json = nlohmann::json::parse(testing::read_text(folder.path() / "summary.json"));
    CHECK(json["error"].is_null() == !summary.failure);
    if (!summary.failure) continue;
    ++failed;
    CHECK(summary.failure == ErrorKind::simulation);
    CHECK(summary.outcome == "failed");
    CHECK(summary.error.find("out of memory: ") != std::string::npos);
    CHECK(summary.error.find("bad_alloc") == std::string::npos);
    CHECK(std::filesystem::exists(folder.path() / "view.html"));
  }
  CHECK(failed >= 10);
}
