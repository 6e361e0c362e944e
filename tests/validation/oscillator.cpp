// A mass on a spring, whose true course and whose backward Euler steps are both known in closed form.
#include <algorithm>
#include <cmath>
#include <memory>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/validation.hpp>

#include "nets.hpp"

using namespace springnet;
using testing::plugins;

namespace {

constexpr double stiffness = 4.0, mass = 1.0, amplitude = 0.25;

// Node 1 swings along x around 1 m; node 0 holds the spring.
Scene oscillator(double time_step) {
  Scene scene;
  scene.network = testing::oscillator(testing::damped(stiffness, 0.0), mass, amplitude);
  scene.duration = 3.0;
  scene.options.time_step = time_step;
  scene.options.threads = 1;
  scene.options.integrator = testing::recurrent(testing::wavefront, 1e-13);
  return scene;
}

struct Expected {
  double max = 0.0, rms = 0.0;
};

// Backward Euler of x'' = -k/m x by its 2 x 2 matrix, against amplitude cos(sqrt(k/m) t), at multiples of `record`.
Expected backward_euler_error(double time_step, double record, double duration) {
  Expected result;
  double x = amplitude, v = 0.0, squares = 0.0;
  int records = 0;
  const int steps = static_cast<int>(std::lround(duration / time_step));
  const int every = static_cast<int>(std::lround(record / time_step));
  for (int step = 1; step <= steps; ++step) {
    v = (v - time_step * stiffness / mass * x) / (1.0 + time_step * time_step * stiffness / mass);
    x += time_step * v;
    if (step % every != 0) continue;
    const double error = std::abs(x - amplitude * std::cos(std::sqrt(stiffness / mass) * step * time_step));
    result.max = std::max(result.max, error);
    squares += error * error;
    ++records;
  }
  result.rms = std::sqrt(squares / (2.0 * records));  // two nodes, one without error
  return result;
}

// An integrator that reports success, but commits nothing.
int idle_instance = 0;
constexpr springnet_integrator idle_functions{
    sizeof(springnet_integrator),
    0,
    nullptr,
    [](void*, springnet_integrator_creation* creation) -> springnet_status {
      creation->integrator = &idle_instance;
      return SPRINGNET_OK;
    },
    [](void*) -> springnet_status { return SPRINGNET_OK; },
    [](void*, const springnet_advance*) -> springnet_status { return SPRINGNET_OK; },
    nullptr,
    nullptr,
    nullptr,
    nullptr,
    nullptr,
    nullptr,
    nullptr};
constexpr springnet_component idle{
    sizeof(springnet_component), SPRINGNET_INTEGRATOR, "idle", "", "", 0, 0, 0, 0, nullptr, &idle_functions};
constexpr const springnet_component* idle_components[] = {&idle};
constexpr springnet_plugin idle_plugin{SPRINGNET_MAGIC,
                                       sizeof(springnet_plugin),
                                       SPRINGNET_ABI_MAJOR,
                                       SPRINGNET_ABI_MINOR,
                                       0,
                                       1,
                                       0,
                                       "test.idle",
                                       "1",
                                       "tests",
                                       "MIT",
                                       idle_components};

}  // namespace

TEST_CASE("the errors of the network are those of backward Euler, within the reference's uncertainty") {
  const Validation validation = validate(oscillator(0.02), plugins());
  REQUIRE(validation.runs.size() == 3);
  CHECK(validation.reference == "cvode");
  CHECK(validation.relative_tolerance == 1e-8);
  CHECK(validation.uncertainty() > 0.0);
  // A few hundred internal steps, each within 1e-8 of the length scale of 1 m.
  CHECK(validation.uncertainty() < 1e-5);
  // The certified uncertainty is an estimate; three times it is room for the reference's true error.
  const double slack = 3.0 * validation.uncertainty() + 1e-10;
  const std::vector<double> time_steps{0.02, 0.01, 0.005};
  for (std::size_t k = 0; k < 3; ++k) {
    const ValidationRun& run = validation.runs[k];
    CHECK(run.time_step == doctest::Approx(time_steps[k]).epsilon(1e-12));
    CHECK(run.of_scene == (k == 0));
    CHECK(run.outcome == "settled");
    CHECK(run.finished());
    CHECK(run.error.node == 1);
    CHECK(run.steps == static_cast<std::uint64_t>(std::lround(3.0 / run.time_step)));
    const Expected expected = backward_euler_error(run.time_step, 0.02, 3.0);
    CHECK(std::abs(run.error.max - expected.max) <= slack);
    CHECK(std::abs(run.error.rms - expected.rms) <= slack);
    CHECK(run.error.max_by_time.size() == validation.times.size());
  }
  const double order = std::log2(backward_euler_error(0.02, 0.02, 3.0).rms / backward_euler_error(0.01, 0.02, 3.0).rms);
  CHECK(validation.runs[1].order == doctest::Approx(order).epsilon(1e-3));
  CHECK(std::isnan(validation.runs[0].order));
  // First order with a part of second order that has not died out at these time steps.
  CHECK(std::abs(validation.observed_order - 1.0) < 0.1);
}

TEST_CASE("the scene's time step is judged with the reference's uncertainty") {
  const Validation validation = validate(oscillator(0.02), plugins(), {{0.01}, 1e-8, 1e-10, "", {}});
  const double error = validation.run_of_scene().error.max;
  CHECK(validation.run_of_scene().time_step == 0.02);
  CHECK(validation.within(error + 1.01 * validation.uncertainty()));
  CHECK_FALSE(validation.within(error + 0.99 * validation.uncertainty()));
}

TEST_CASE("time steps may be coarser than the scene's, in any order, and the scene's named again") {
  const Validation validation = validate(oscillator(0.02), plugins(), {{0.01, 0.04, 0.02}, 1e-8, 1e-10, "", {}});
  REQUIRE(validation.runs.size() == 3);
  CHECK(validation.runs[0].time_step == 0.04);
  CHECK(validation.runs[1].time_step == 0.02);
  CHECK(validation.runs[1].of_scene);
  CHECK(validation.runs[2].time_step == 0.01);
  CHECK(validation.times[1] == doctest::Approx(0.04));
}

TEST_CASE("a failed run keeps its outcome, and the others go on") {
  Scene scene = oscillator(0.02);
  // t^2 k / m is 4 for the coarse time step: a synchronous sweep makes differences four times as large.
  scene.options.integrator = testing::recurrent(testing::synchronous, 0.0);
  const Validation validation = validate(scene, plugins(), {{1.0, 0.01}, 1e-8, 1e-10, "", {}});
  REQUIRE(validation.runs.size() == 3);
  const ValidationRun& failed = validation.runs[0];
  CHECK_FALSE(failed.finished());
  CHECK((failed.outcome == "diverging" || failed.outcome == "out of sweeps" || failed.outcome == "oscillating"));
  CHECK(failed.failure_kind == ErrorKind::simulation);
  CHECK(failed.reached == 0.0);
  CHECK(std::isnan(failed.error.max));  // nothing could be compared
  CHECK(std::isnan(failed.error.rms));
  CHECK(validation.runs[1].outcome == "settled");
  CHECK(validation.runs[2].outcome == "settled");
  CHECK(validation.runs[2].error.max_by_time.size() == validation.times.size());
  CHECK(std::isnan(validation.runs[1].order));
  CHECK(std::isfinite(validation.observed_order));
  REQUIRE_FALSE(validation.notes.empty());
  CHECK(validation.notes[0].find(failed.failure) != std::string::npos);
}

TEST_CASE("a run whose integrator breaks the rules is a failure of the plugin") {
  auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  REQUIRE(host->add(idle_plugin));
  Scene scene = oscillator(0.02);
  scene.options.integrator = {"idle", {}};
  const Validation validation = validate(scene, host);
  const ValidationRun& own = validation.run_of_scene();
  CHECK(own.failure.find("integrator 'idle' of plugin test.idle") != std::string::npos);
  CHECK(own.failure_kind == ErrorKind::plugin);
}

TEST_CASE("a scene of the reference's integrator is compared with the recurrent network") {
  Scene scene = oscillator(0.02);
  scene.options.integrator = {"cvode", {{"relative_tolerance", 1e-5}, {"max_order", 3.0}}};
  const Validation validation = validate(scene, plugins());
  CHECK(validation.relative_tolerance == 1e-8);
  CHECK(validation.run_of_scene().integrator.id == "recurrent");
}

TEST_CASE("tolerances of the reference that certify nothing are refused") {
  CHECK_THROWS_AS(static_cast<void>(validate(oscillator(0.02), plugins(), {{}, 1e-8, 1e-8, "", {}})), Error);
  CHECK_THROWS_AS(static_cast<void>(validate(oscillator(0.02), plugins(), {{}, 1e-8, 0.0, "", {}})), Error);
}

TEST_CASE("springs that rupture only in the reference are noted") {
  Scene scene = oscillator(0.02);
  // The true course swings to 0.25 m of elongation, 1 N, and back: the network, which loses energy, does not come back
  // as far. Node 1 starts compressed, so that the elongation is reached half a swing later only.
  const MaterialIndex weak =
      scene.network.add_material({LawUse{"rupturing", {{"stiffness", stiffness}, {"strength", 0.99}}}, std::nullopt});
  scene.network.set_spring_material(0, weak);
  Node node = scene.network.nodes()[1];
  node.position = Vector3(1.0 - amplitude, 0.0, 0.0);
  scene.network.set_node(1, node);
  const Validation validation = validate(scene, plugins(), {{0.04}, 1e-8, 1e-10, "", {}});
  CHECK(validation.reference_events.ruptured == 1);
  CHECK(validation.runs[0].events.ruptured == 0);
  CHECK(std::any_of(validation.notes.begin(), validation.notes.end(), [](const std::string& note) {
    return note.find("0 springs ruptured, but 1 in the reference") != std::string::npos;
  }));
}

TEST_CASE("progress is reported at every record time, and can stop the validation") {
  std::vector<double> times;
  ValidationOptions options;
  options.progress = [&](const ValidationProgress& now) {
    times.push_back(now.time);
    return now.time < 1.0;
  };
  CHECK_THROWS_AS(static_cast<void>(validate(oscillator(0.02), plugins(), options)), Error);
  REQUIRE(times.size() == 51);
  CHECK(times.back() == doctest::Approx(1.0));
}

TEST_CASE("theta = 0.5 is tried with the scene's time step, and is better for an oscillation") {
  const Validation validation = validate(oscillator(0.02), plugins());
  REQUIRE(validation.second_order);
  CHECK(validation.second_order->time_step == 0.02);
  CHECK(validation.second_order->integrator.parameters.at("theta") == 0.5);
  CHECK(validation.second_order->finished());
  CHECK(validation.second_order_is_better());
  // Its phase is wrong by (w t)^2 / 12 of itself: amplitude w^3 t^2 T / 12 at the end, with w = 2 rad/s and T = 3 s.
  CHECK(validation.second_order->error.max == doctest::Approx(amplitude * 8.0 * 4e-4 * 3.0 / 12.0).epsilon(0.1));
  // From one end to the other: the amplitude twice, to the next record (a quarter of a time step from the turn).
  CHECK(validation.displacement.max == doctest::Approx(2.0 * amplitude).epsilon(1e-3));
  CHECK(validation.displacement.node == 1);
  CHECK(validation.displacement.time == doctest::Approx(std::acos(-1.0) / 2.0).epsilon(0.01));
  CHECK(validation.share_of_displacement(0.01) == doctest::Approx(0.02).epsilon(1e-3));
}

TEST_CASE("theta = 0.5 is not tried if the scene has it, or the integrator has no theta") {
  Scene scene = oscillator(0.02);
  scene.options.integrator.parameters["theta"] = 0.5;
  CHECK_FALSE(validate(scene, plugins()).second_order);
  scene.options.integrator = LawUse{"verlet", {}};
  CHECK_FALSE(validate(scene, plugins()).second_order);
}

TEST_CASE("a body that turns and flies as a whole hardly deforms, with a note") {
  Scene scene = oscillator(0.02);
  Network net;
  const MaterialIndex material = net.add_material(testing::damped(4000.0, 1.0));
  net.begin_body("rod");
  net.add_node(testing::point({0, 0, 0}));
  net.add_node(testing::point({1, 0, 0}));
  net.add_spring(0, 1, material);
  net.end_body();
  for (const NodeIndex k : {0u, 1u}) {
    Node node = net.nodes()[k];
    node.velocity = {0, k == 0 ? -1.0 : 1.0, 3};  // turns about its middle once in pi s, and flies
    net.set_node(k, node);
  }
  scene.network = net;
  const Validation validation = validate(scene, plugins());
  CHECK(validation.displacement.max > 9.0);
  // The centrifugal force m v^2 / r = 2 N stretches the spring by about 2 N / 4000 N/m, overshooting twice that: half
  // at each end.
  CHECK(validation.displacement.deformation < 1e-3);
  CHECK(validation.displacement.deformation > 1e-4);
  CHECK(std::any_of(validation.notes.begin(), validation.notes.end(),
                    [](const std::string& note) { return note.find("as a whole") != std::string::npos; }));
}
