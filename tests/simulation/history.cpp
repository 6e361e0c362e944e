// Simulation::drop_history(): what follows depends on the state alone.

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <string>
#include <vector>

#include <springnet/error.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/sdk/host.hpp>

#include "constraints/vectors.hpp"
#include "generator.hpp"
#include "nets.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr int before = 12, after = 10;  // steps

// Engine and integrator without the public face: the integrator can be created anew in the middle of a run.
class Driven {
 public:
  Driven(const Network& net, const SimulationOptions& options)
      : options_(options),
        component_(plugins()->require(ComponentKind::integrator, options.integrator.id)),
        engine_(net, *plugins(), options),
        host_(make_host_table(engine_)) {
    create();
  }
  ~Driven() { component_->integrator().destroy(integrator_); }
  Driven(const Driven&) = delete;
  Driven& operator=(const Driven&) = delete;

  // False: the step failed.
  [[nodiscard]] bool step() {
    const double until = static_cast<double>(++steps_) * options_.time_step;
    springnet_step_report report{};
    report.struct_size = sizeof report;
    engine_.calls().begin_advance(until);
    auto request = sdk::sized<springnet_advance>();
    request.until = until;
    request.report = &report;
    return component_->integrator().advance(integrator_, &request) == SPRINGNET_OK;
  }
  // The host forgets, and all that the integrator could keep is gone with it.
  void begin_anew() {
    engine_.forget();
    component_->integrator().destroy(integrator_);
    create();
  }
  // Uses what the host keeps, for a system that no step has.
  void disturb() {
    const Model& model = engine_.model();
    springnet_evaluation at{};
    at.struct_size = sizeof at;
    at.time = model.time;
    at.position = read_only(model.state.view.position);
    at.velocity = read_only(model.state.view.velocity);
    springnet_linear_system system{};
    system.struct_size = sizeof system;
    system.velocity_weight = 0.3;
    system.position_weight = 0.7;
    system.shift = 2.0;
    system.at = &at;
    static_cast<void>(host_.prepare_system(host_.context, &system));
    auto linearisation = sdk::sized<springnet_linearisation>();
    linearisation.at = &at;
    static_cast<void>(host_.linearise(host_.context, &linearisation));
  }
  [[nodiscard]] Engine& engine() noexcept { return engine_; }

 private:
  void create() {
    const std::vector<double> values =
        complete_parameters(*component_->description, options_.integrator.parameters, "integrator");
    auto creation = sdk::sized<springnet_integrator_creation>();
    creation.host = &host_;
    creation.option_count = static_cast<std::uint32_t>(values.size());
    creation.options = values.data();
    REQUIRE(component_->integrator().create(component_->integrator().context, &creation) == SPRINGNET_OK);
    integrator_ = creation.integrator;
  }

  SimulationOptions options_;
  std::shared_ptr<const Component> component_;
  Engine engine_;
  springnet_host host_;
  void* integrator_ = nullptr;
  int steps_ = 0;
};

Eigen::MatrixXd state_of(const Simulation& simulation) {
  Eigen::MatrixXd result(6, simulation.positions().cols());
  result << simulation.positions(), simulation.velocities();
  return result;
}
Eigen::MatrixXd state_of(Driven& driven) {
  const State& state = driven.engine().model().state;
  const auto n = static_cast<Eigen::Index>(driven.engine().model().node_count());
  Eigen::MatrixXd result(6, n);
  const springnet_vectors both[] = {state.view.position, state.view.velocity};
  for (Eigen::Index half = 0; half < 2; ++half)
    for (Eigen::Index k = 0; k < n; ++k)
      result.block<3, 1>(3 * half, k) << both[half].x[k], both[half].y[k], both[half].z[k];
  return result;
}

bool step(Simulation& simulation) {
  try {
    simulation.step();
    return true;
  } catch (const Error&) {
    return false;
  }
}

// Whether the step after the first ones fails, or has other bits where the history goes on. Checks that it has the same
// bits after drop_history() as with an integrator that was created anew.
bool history_matters(const Network& net, const SimulationOptions& options) {
  Simulation dropped(net, plugins(), options), kept(net, plugins(), options);
  Driven anew(net, options);
  for (int i = 0; i < before; ++i) {
    const bool done = step(dropped);
    if (step(kept) != done || anew.step() != done) FAIL("not the same steps");
    if (!done) return false;  // nothing to compare
  }
  CHECK((state_of(dropped) == state_of(anew)));
  const auto statistics = dropped.statistics();
  const std::size_t notes = dropped.notes().size();
  dropped.drop_history();
  CHECK(dropped.statistics() == statistics);
  CHECK(dropped.notes().size() == notes);
  anew.disturb();
  anew.begin_anew();
  bool matters = false;
  for (int i = 0; i < after; ++i) {
    const bool done = step(dropped);
    CHECK(anew.step() == done);
    const bool same = state_of(dropped) == state_of(anew);
    CHECK(same);
    if (!done || !same) return matters;
    matters = !step(kept) || state_of(kept) != state_of(dropped) || matters;
  }
  CHECK(dropped.events().size() == anew.engine().model().journal.events().size());
  for (const auto& [name, value] : statistics) {
    CAPTURE(name);
    // Counters go on.
    if (name == "evaluations" || name == "krylov_iterations" || name == "internal_steps" || name == "rhs_evaluations")
      CHECK(dropped.statistics().at(name) >= value);
  }
  return matters;
}

SimulationOptions with(LawUse integrator, double time_step) {
  SimulationOptions options;
  options.integrator = std::move(integrator);
  options.time_step = time_step;
  options.threads = 1;
  return options;
}

// A cube that lies, slides and jumps on a floor with friction, with a cut and angles between its springs.
Network sliding_cube() {
  Network net = cube(300.0, 2.0, 2.0, 1e-3);
  Plane ramp{"ramp", {0, 0, -0.02}, Vector3(0.3, 0, 1).normalized()};
  ramp.friction = {Friction::Kind::coulomb, 0.2};
  net.add_plane(ramp);
  const MaterialIndex hinge = net.add_material({LawUse{"linear", {{"stiffness", 5.0}}}, std::nullopt});
  for (NodeIndex k = 0; k + 2 < 64; k += 5) net.add_element(Invariant::angle, {k, k + 1, k + 2}, hinge);
  net.add_cut({0.29, {3, 17, 40, 90}, {}});
  return net;
}

}  // namespace

TEST_CASE("after drop_history the steps are those of a new integrator, bit by bit, whatever the rule") {
  const Network net = sliding_cube();
  for (const double theta : {1.0, 0.5})
    for (const double rule : {synchronous, wavefront, block, coloured, newton, automatic}) {
      CAPTURE(theta);
      CAPTURE(rule);
      const double step = rule == synchronous || rule == wavefront ? 0.005 : 0.025;
      const bool matters =
          history_matters(net, with(recurrent(rule, 0.0, {{"theta", theta}, {"unsettled", on_unsettled_adapt}}), step));
      if (rule == newton) CHECK(matters);
    }
  CHECK(history_matters(net, with(recurrent(newton, 0.0, {{"theta", 0.5}, {"events", 1}}), 0.02)));
  CHECK(history_matters(net, with(cvode(1e-6), 0.01)));
  CHECK(history_matters(net, with(cvode(1e-6, {{"linear_solver", 2}}), 0.01)));
  history_matters(net, with({"verlet", {}}, 0.002));
  CHECK(history_matters(net, with(testing::generalized_alpha(), 0.02)));
}

TEST_CASE("drop_history drops the estimate of the forces' rounding") {
  // Of the start, where the chain is short and slow; the threshold is below it.
  Network net = chain(8, {100.0, 0, 0}, {0.1, 0, 0}, damped(1e4, 5.0), 0.1);
  net.fix(0);
  net.set_gravity({0, 0, -9.81});
  CHECK(history_matters(net, with(recurrent(newton, 1e-13), 0.02)));
}

TEST_CASE("drop_history drops the rule that was chosen") {
  // Springs that stiffen as they are stretched: synchronous sweeps at the start, Newton's method later.
  Network net;
  const MaterialIndex hardening =
      net.add_material({LawUse{"nonlinear", {{"stiffness", 10.0}, {"cubic", 4000.0}, {"quintic", 0.0}}}, std::nullopt});
  for (NodeIndex k = 0; k < 5; ++k) net.add_node(point({static_cast<double>(k), 0, 0}, 1.0, {4.0 * k, 0, 0}));
  for (NodeIndex k = 0; k + 1 < 5; ++k) net.add_spring(k, k + 1, hardening);
  net.fix(0);
  CHECK(history_matters(net, with(recurrent(automatic, 0.0), 0.012)));
}

TEST_CASE("after drop_history random nets go on as with a new integrator") {
  int mattered = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    CAPTURE(seed);
    const Network net = RandomNet(seed).network;
    for (const double theta : {1.0, 0.5}) {
      for (const double rule : {newton, automatic}) {
        CAPTURE(theta);
        CAPTURE(rule);
        mattered += history_matters(
            net, with(recurrent(rule, 0.0, {{"theta", theta}, {"unsettled", on_unsettled_adapt}}), 0.01));
      }
    }
    history_matters(net, with({"verlet", {{"substeps", 20}}}, 0.002));
    history_matters(net, with(testing::generalized_alpha(), 0.002));
  }
  CHECK(mattered > 4);
}

// Large enough for the system without its matrix.
TEST_CASE("after drop_history a lattice goes on as with a new integrator") {
  Lattice lattice;
  lattice.nodes = {14, 14, 14};
  lattice.diagonals = Diagonals::space;
  lattice.spacing = {0.1, 0.1, 0.1};
  Network net;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(2000.0, 1.0)));
  for (NodeIndex k = 0; k < 196; ++k) net.fix(k);
  net.set_gravity({1.0, 0, -5.0});
  CHECK(history_matters(net, with(recurrent(newton, 0.0), 0.02)));
}
