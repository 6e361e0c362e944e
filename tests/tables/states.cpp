// Internal states and energies in tables.
#include <cmath>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/output.hpp>

#include "csv.hpp"
#include "facts.hpp"
#include "nets.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::Csv;
using testing::plugins;
using testing::TemporaryFolder;

namespace {

// Spring 0 is held at 1.2 m, its rest length 1 m; spring 1 has no states, spring 2 and the angle do.
const std::string text = R"(
[simulation]
duration = 0.2
time_step = 0.01
threads = 1
integrator = { name = "recurrent", update = "newton", theta = 0.5, force_tolerance = 1e-11 }
[[body]]
name = "net"
neuron = { type = "point_mass", mass = 1 }
nodes = [[0, 0, 0], [1.2, 0, 0], [1.2, 1, 0], [1.2, 1, 1.3]]
springs = [[0, 1], [1, 2], [2, 3]]
spring = { type = "maxwell", stiffness = 40, relaxation_time = 0.1 }
[[spring]]
select = { springs = [1] }
spring = { type = "linear", stiffness = 50 }
[[spring]]
select = { springs = [0] }
rest_length = 1.0
[[fix]]
select = { nodes = [0, 1] }
[[element]]
invariant = "angle"
nodes = [[0, 1, 2]]
spring = { type = "plastic", stiffness = 20, yield_tension = 0.5, relaxation_time = 0.05 }
[output]
view = false
)";

Scene scene_with(const std::string& output) { return parse_scene(text + output, "states", *plugins()); }

void run_states(const Scene& scene, const TemporaryFolder& folder) {
  const RunSummary summary = run_scene(scene, plugins(), {folder.path(), "states", {}});
  CAPTURE(summary.error);
  CHECK_FALSE(summary.failure);
}

}  // namespace

TEST_CASE("states.csv has the internal states of springs and elements") {
  const TemporaryFolder folder;
  const Scene scene = scene_with("states = true\ninterval = 0.05\n");
  run_states(scene, folder);
  const Csv table = testing::read_csv(folder.path() / "states.csv");
  CHECK(table.header == "time,element,index,function,state,value");
  REQUIRE(table.rows.size() == 5 * 3);
  Simulation simulation(scene.network, plugins(), scene.options);
  for (std::size_t record = 0; record < 5; ++record) {
    if (record > 0) simulation.advance_to(0.05 * static_cast<double>(record));
    const auto beginning = [&](std::size_t k) {
      const std::vector<std::string>& row = table.rows[3 * record + k];
      return std::vector<std::string>(row.begin() + 1, row.begin() + 5);
    };
    CHECK(beginning(0) == std::vector<std::string>{"spring", "0", "spring", "flow"});
    CHECK(beginning(1) == std::vector<std::string>{"spring", "2", "spring", "flow"});
    CHECK(beginning(2) == std::vector<std::string>{"element", "0", "spring", "flow"});
    CHECK(table.number(3 * record, 5) == doctest::Approx(simulation.internal_states(0)[0]).epsilon(1e-12));
    CHECK(table.number(3 * record + 1, 5) == doctest::Approx(simulation.internal_states(2)[0]).epsilon(1e-9));
    CHECK(table.number(3 * record + 2, 5) == doctest::Approx(simulation.element_internal_states(0)[0]).epsilon(1e-9));
    // The dashpot takes over the elongation of the spring that is held: x (1 - exp(-t / tau)).
    const double time = table.number(3 * record, 0), closed_form = 0.2 * (1.0 - std::exp(-time / 0.1));
    CHECK(std::abs(table.number(3 * record, 5) - closed_form) < 0.2 * 0.01 * 0.01 / (0.1 * 0.1));
  }
  CHECK(simulation.internal_state_names(0) == std::vector<InternalState>{{"flow", "m", false}});
  CHECK(simulation.internal_state_names(1).empty());
  CHECK(simulation.element_internal_state_names(0) == std::vector<InternalState>{{"flow", "m", false}});
}

TEST_CASE("states.csv has the springs and elements that the scene records") {
  const TemporaryFolder folder;
  const auto rows = [&](const std::string& output) {
    run_states(scene_with("states = true\ninterval = 1\n" + output), folder);
    std::vector<std::string> found;
    for (const auto& row : testing::read_csv(folder.path() / "states.csv").rows) found.push_back(row[1] + " " + row[2]);
    return std::vector<std::string>(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2));
  };
  CHECK(rows("springs = { springs = [1, 2] }") == std::vector<std::string>{"spring 2", "element 0"});
  CHECK(rows("elements = false") == std::vector<std::string>{"spring 0", "spring 2"});
  run_states(scene_with("interval = 1"), folder);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "states.csv"));
  CHECK_FALSE(std::filesystem::exists(folder.path() / "energies.csv"));
}

TEST_CASE("a scene that asks for states where no law has any is refused") {
  try {
    static_cast<void>(scene_with("states = true\nsprings = { springs = [1] }\nelements = false"));
    FAIL_CHECK("it was not refused");
  } catch (const Error& error) {
    CAPTURE(error.what());
    CHECK(testing::has_facts(error.what(), "output.states | no spring or element | internal states"));
  }
}

TEST_CASE("the size of states.csv and energies.csv is estimated") {
  const TemporaryFolder folder;
  Scene scene = scene_with("states = true\nenergies = true\n");
  run_states(scene, folder);
  const auto size_of = [](const OutputEstimate& estimate, const std::string& name) {
    for (const FileEstimate& file : estimate.files)
      if (file.file == name) return file.bytes;
    return 0.0;
  };
  const OutputEstimate estimate = estimate_output(scene);
  for (const char* name : {"states.csv", "energies.csv"}) {
    CAPTURE(name);
    const auto bytes = static_cast<double>(std::filesystem::file_size(folder.path() / name));
    CHECK(bytes <= size_of(estimate, name) + 60.0);  // the header
    CHECK(bytes >= 0.4 * size_of(estimate, name));
  }
  // A scene in code that does not say what its laws have has no estimate, and the same file.
  const std::string written = testing::read_text(folder.path() / "states.csv");
  CHECK(scene.output.law_states.size() == 2);
  scene.output.law_states.clear();
  CHECK(size_of(estimate_output(scene), "states.csv") == 0.0);
  run_states(scene, folder);
  CHECK(testing::read_text(folder.path() / "states.csv") == written);
}

TEST_CASE("energies.csv has what is left and what is dissipated, summed up over all steps") {
  const TemporaryFolder folder;
  const Scene scene = scene_with("energies = true\ninterval = 0.05\n");
  run_states(scene, folder);
  const Csv table = testing::read_csv(folder.path() / "energies.csv");
  CHECK(table.header == "time,kinetic,potential,dissipation,dissipated");
  REQUIRE(table.rows.size() == 5);
  SimulationOptions options = scene.options;
  options.dissipated_energy = true;
  Simulation simulation(scene.network, plugins(), options);
  const double all = table.number(0, 1) + table.number(0, 2);
  CHECK(table.number(0, 4) == 0.0);
  // The held spring relaxes with the power k x^2 / tau.
  CHECK(table.number(0, 3) == doctest::Approx(40.0 * 0.2 * 0.2 / 0.1).epsilon(1e-12));
  for (std::size_t record = 0; record < 5; ++record) {
    if (record > 0) simulation.advance_to(0.05 * static_cast<double>(record));
    CHECK(table.number(record, 4) == doctest::Approx(simulation.dissipated_energy()).epsilon(1e-9));
    CHECK(table.number(record, 1) + table.number(record, 2) + table.number(record, 4) ==
          doctest::Approx(all).epsilon(1e-3));
  }
  CHECK(table.number(4, 4) > 0.5);
}
