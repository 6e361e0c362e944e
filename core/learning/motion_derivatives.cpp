#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <span>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/motion_derivatives.hpp>
#include <springnet/sdk/host.hpp>

#include "learning/constrained_outputs.hpp"
#include "learning/internal_states.hpp"
#include "learning/learned_values.hpp"
#include "learning/motion_checks.hpp"
#include "learning/removals.hpp"
#include "learning/step_constraints.hpp"
#include "learning/step_solver.hpp"
#include "learning/trajectory.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"

namespace springnet {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double default_accuracy = 1e-10;

}  // namespace

// Vectors of all nodes have the engine's order, x of all nodes, then y, then z.
struct MotionDerivatives::Impl {
  using State = learning::Trajectory::State;
  // A step at the state where it ends, and how its derivatives are weighed.
  struct Step {
    std::size_t number;  // of the state at its end
    const State &from, &until;
    double w, c;  // s
  };

  Impl(const std::shared_ptr<const Network>& net, const std::shared_ptr<const PluginHost>& plugins,
       const SimulationOptions& options, double duration, std::vector<LearnedValues> values)
      : learned(*net, std::move(values)),
        simulation(net, plugins, options),
        trajectory(simulation, [this](State& to) { record(to); }),
        engine(net->without_constraints(), *plugins, options),
        table(make_host_table(engine)),
        host(table),
        solver(host),
        theta(learning::option(options.integrator, "theta", 1.0)),
        internal(engine, theta),
        same_at_both(learning::have_no_jumps(*net) && !internal.any()),
        removals(engine),
        steps(static_cast<std::size_t>(std::llround(duration / options.time_step))) {
    learning::check_method(*net, options.integrator);
    if (!(duration > 0.0) || !std::isfinite(duration) || steps == 0)
      throw Error(ErrorKind::input,
                  fmt::format("learning: a duration of {} s has no time step of {} s", duration, options.time_step));
    nodes = host.network().node_count;
    learned.attach(engine);
    network_values = learned.values_of(engine);
    if (!net->planes().empty() || !net->instruments().empty() || !net->rigids().empty()) {
      constraints = std::make_unique<learning::StepConstraints>(*net, *plugins, options);
      constraints->check_starts(learned, simulation);
      removals.follow(constraints->engine());
    }
    internal.check_start(learned, network_values);
    saved_start = simulation.save();
    for (VectorXd* each : {&dp, &dv, &rhs, &product, &other, &solution}) each->setZero(size());
  }

  [[nodiscard]] Eigen::Index size() const { return 3 * static_cast<Eigen::Index>(nodes); }
  // With the internal states as they are, or of the step that ends there.
  [[nodiscard]] springnet_evaluation evaluation(const State& at) {
    springnet_evaluation result = nodes_at(at);
    result.internal = internal.as_they_are(at.z);
    return result;
  }
  [[nodiscard]] springnet_evaluation end_of(const Step& step) {
    springnet_evaluation result = nodes_at(step.until);
    result.internal = internal.stepped(step.until.time - step.from.time);
    return result;
  }
  [[nodiscard]] springnet_evaluation nodes_at(const State& at) const {
    auto result = sdk::sized<springnet_evaluation>();
    result.time = at.time;
    result.position = {at.p.data(), at.p.data() + nodes, at.p.data() + 2 * nodes};
    result.velocity = {at.v.data(), at.v.data() + nodes, at.v.data() + 2 * nodes};
    return result;
  }
  [[nodiscard]] Step step(std::size_t k) {
    const auto [from, until] = trajectory.step(k);
    const double h = until.time - from.time;
    return {k, from, until, theta * h, (1.0 - theta) * h};
  }
  // Of nodes whose motion is given nothing depends on what is learned.
  void clear_pinned(VectorXd& values) const {
    const springnet_network& network = host.network();
    for (std::size_t k = 0; k < nodes; ++k)
      if (network.fixed[k] != 0 || network.held[k] != 0)
        for (std::size_t axis = 0; axis < 3; ++axis) values[static_cast<Eigen::Index>(axis * nodes + k)] = 0.0;
  }
  [[nodiscard]] Eigen::Matrix3Xd in_user_order(const VectorXd& values) const {
    Eigen::Matrix3Xd result(3, static_cast<Eigen::Index>(nodes));
    const std::vector<std::uint32_t>& number = engine.model().layout.ordering().engine;
    for (std::size_t k = 0; k < nodes; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        result(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(k)) =
            values[static_cast<Eigen::Index>(axis * nodes + number[k])];
    return result;
  }
  void add_from_user_order(const Eigen::Matrix3Xd& from, VectorXd& to) const {
    const std::vector<std::uint32_t>& number = engine.model().layout.ordering().engine;
    for (std::size_t k = 0; k < nodes; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        to[static_cast<Eigen::Index>(axis * nodes + number[k])] +=
            from(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(k));
  }

  void check_number(std::size_t state) const {
    if (state >= trajectory.size())
      throw Error(ErrorKind::input,
                  fmt::format("learning: state {} does not exist: the last run has {}", state, trajectory.size()));
  }
  [[nodiscard]] const State& at(std::size_t state) {
    check_number(state);
    return trajectory.at(state);
  }
  void begin(const VectorXd& values);
  void run(const VectorXd& values);
  void record(State& to) const;
  [[nodiscard]] State present() const {
    State result;
    record(result);
    return result;
  }
  void check_step(std::size_t state);
  void begin_tangent(const MatrixXd& directions);
  [[nodiscard]] MatrixXd columns_in_user_order(const MatrixXd& values) const;
  void tangent(const MatrixXd& directions, const StateTangents& told);
  void begin_steps(const VectorXd& values, const MatrixXd& directions);
  void make_step(const VectorXd& values, const MatrixXd& directions);
  VectorXd adjoint(const std::function<void(std::size_t, StateChange&)>& add);
  void begin_step(const Step& step);
  void step_forwards(const Step& step);
  void add_internal_at_start(const sdk::Host& of, const springnet_evaluation& start, double weight);
  void step_backwards(std::size_t k);
  void add_start(const sdk::Host& of);
  void start_backwards(std::size_t k);
  void guess_backwards();
  void set_engines(const VectorXd& values);
  void find_outputs(const Step& step);
  [[nodiscard]] const sdk::Host& host_at_start(std::size_t state, double from, double until);
  [[nodiscard]] Engine& engine_of(const sdk::Host& of) { return &of == &host ? engine : constraints->engine(); }
  [[nodiscard]] bool is_constrained_at(std::size_t state) { return constraints && constraints->any_at(state); }
  template <class Function>
  void with_messages(const Function& function) const {
    try {
      function();
    } catch (const sdk::Failure& failure) {
      throw Error(ErrorKind::simulation, std::string("learning: ") + failure.what());
    }
  }

  learning::LearnedSets learned;
  Simulation simulation;
  learning::Trajectory trajectory;  // of the last run
  // Answers for derivatives, at the states of the last run, of the net without constraints; which, null: there are
  // none, are by themselves.
  Engine engine;
  springnet_host table;
  sdk::Host host;
  std::unique_ptr<learning::StepConstraints> constraints;
  learning::ConstrainedOutputs outputs;  // of a step
  learning::StepSolver solver;
  double theta;
  learning::InternalStates internal;
  bool same_at_both;  // accelerations at a time, as the end of a step and as the start of the next one
  learning::Removals removals;
  double accuracy = default_accuracy;
  std::size_t steps, nodes = 0;
  std::string saved_start;
  VectorXd network_values;
  VectorXd dp, dv;  // the change of a state, or derivatives of the loss by it
  VectorXd rhs, product, other, solution, work;
  VectorXd weights;                  // of the accelerations at a state
  std::deque<VectorXd> solved;       // backwards: of the last steps
  VectorXd pending;                  // those that the step after a state has for its start; empty: none
  MatrixXd changes, dps, dvs, rhss;  // of the tangent: a column for each change of values
  MatrixXd dps_before, dvs_before;   // at the start of the step made last
};

void MotionDerivatives::Impl::record(State& to) const {
  to.time = simulation.time();
  to.p.resize(size());
  to.v.resize(size());
  const auto n = static_cast<Eigen::Index>(nodes);
  const ConstNodeMap p = simulation.positions(), v = simulation.velocities();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    to.p.segment(axis * n, n) = p.row(axis).transpose();
    to.v.segment(axis * n, n) = v.row(axis).transpose();
  }
  internal.record(simulation, to.z);
}

// What the derivative of a fixed point does not describe.
void MotionDerivatives::Impl::check_step(std::size_t state) {
  const auto refuse = [this](const std::string& what) {
    throw Error(ErrorKind::simulation,
                fmt::format("learning: {} at {:g} s is not differentiated", what, simulation.time()));
  };
  const StepReport& report = simulation.last_report();
  if (report.outcome != Outcome::settled) refuse("a step that has not settled");
  if (report.substeps > 0) refuse("a step that was divided as it did not settle");
  if (removals.take(simulation.events(), state, simulation.time()) != nullptr) refuse("a node that is jammed");
  if (constraints) constraints->history().record(simulation, state);
}

void MotionDerivatives::Impl::begin(const VectorXd& values) {
  simulation.restore(saved_start);
  removals.begin(simulation.events().size());
  learned.set(simulation, values);
  if (constraints) constraints->history().begin(simulation);
}

void MotionDerivatives::Impl::run(const VectorXd& values) {
  learned.check(values);
  begin(values);
  trajectory.run(steps, [this](std::size_t state) { check_step(state); });
  set_engines(values);
}

void MotionDerivatives::Impl::set_engines(const VectorXd& values) {
  learned.set(engine, values);
  if (constraints) learned.set(constraints->engine(), values);
}

void MotionDerivatives::Impl::begin_step(const Step& step) {
  internal.start_at(nodes_at(step.from), step.from.z);
  host.begin_step(step.from.time, step.until.time);
}

// For accelerations at the start of a step, at this state.
const sdk::Host& MotionDerivatives::Impl::host_at_start(std::size_t state, double from, double until) {
  if (is_constrained_at(state)) return constraints->begin_step(state, from, until);
  host.begin_step(from, until);
  return host;
}

// Where `host` has begun the step: what constraints make of it.
void MotionDerivatives::Impl::find_outputs(const Step& step) {
  outputs.begin(nodes, step.c, step.w);
  if (!constraints || !constraints->any_within(step.number)) return;
  const auto accelerations = [&](const sdk::Host& of, springnet_evaluation where) {
    VectorXd result(size());
    where.acceleration = {result.data(), result.data() + nodes, result.data() + 2 * nodes};
    of.evaluate(where);
    return result;
  };
  VectorXd free = step.from.v + step.w * accelerations(host, end_of(step));
  if (step.c > 0.0) {
    const sdk::Host& of = host_at_start(step.number - 1, step.from.time, step.until.time);
    free += step.c * accelerations(of, evaluation(step.from));
    begin_step(step);
  }
  constraints->find_outputs(
      {step.number, step.from.time, step.until.time, theta, step.from.p, step.from.v, step.until.p, step.until.v}, free,
      outputs);
}

// Each column of dps and dvs is the change of a state.
void MotionDerivatives::Impl::step_forwards(const Step& step) {
  begin_step(step);
  const Eigen::Index columns = dps.cols();
  rhss = dvs;
  const auto add = [&](const sdk::Host& of, const springnet_evaluation& where, double weight, bool at_end) {
    other.setZero();
    for (Eigen::Index j = 0; j < columns; ++j) {
      of.jacobian_times(dps.col(j).data(), dvs.col(j).data(), product.data(), SPRINGNET_TRUE_FRICTION);
      if (&of != &host) {
        work = dps.col(j);
        constraints->add_carried(work, product);
      }
      learned.tangent(engine_of(of), of, where, changes.col(j), other.data(), at_end ? internal.by_values(j) : nullptr);
      rhss.col(j) += weight * (product + other);
    }
  };
  const springnet_evaluation start = evaluation(step.from);
  if (step.c > 0.0) {
    const sdk::Host& of = host_at_start(step.number - 1, step.from.time, step.until.time);
    of.linearise(start);
    add(of, start, step.c, false);
    add_internal_at_start(of, start, step.c);
    begin_step(step);
  }
  const springnet_evaluation end = end_of(step);
  find_outputs(step);
  solver.prepare(end, step.w, columns, &outputs);
  internal.add_by_start(start, end, step.w, dps, dvs, rhss);
  // Without the velocities V that are yet to be found.
  for (Eigen::Index j = 0; j < columns; ++j) {
    outputs.from_start(dps.col(j), dvs.col(j), solution, product);
    if (outputs.any()) outputs.add_masses(learned.mass_changes(changes.col(j), nodes), solution, product);
    dps.col(j) = solution;
    dvs.col(j) = product;
  }
  add(host, end, step.w, true);
  for (Eigen::Index j = 0; j < columns; ++j) {
    rhs = rhss.col(j);
    clear_pinned(rhs);
    solver.solve(rhs, accuracy, solution);
    outputs.from_free(solution, product, other);
    product += dps.col(j);
    other += dvs.col(j);
    clear_pinned(product);
    clear_pinned(other);
    dps.col(j) = product;
    dvs.col(j) = other;
  }
  internal.end_step(end, dps, dvs);
}

// What changes of internal states at the start make of the accelerations there.
void MotionDerivatives::Impl::add_internal_at_start(const sdk::Host& of, const springnet_evaluation& start,
                                                    double weight) {
  if (!internal.any()) return;
  if (&of == &host) return internal.add_accelerations(start, weight, rhss);
  host.linearise(start);
  MatrixXd free = MatrixXd::Zero(size(), rhss.cols());
  internal.add_accelerations(start, weight, free);
  for (Eigen::Index j = 0; j < free.cols(); ++j) constraints->project(false, free.col(j).data());
  rhss += free;
}

void MotionDerivatives::Impl::begin_tangent(const MatrixXd& directions) {
  for (Eigen::Index j = 0; j < directions.cols(); ++j) learned.check(directions.col(j));
  changes = directions;
  dps.setZero(size(), directions.cols());
  dvs.setZero(size(), directions.cols());
  internal.begin_changes(directions.cols());
  for (Eigen::Index j = 0; j < directions.cols(); ++j) {
    product.setZero();
    learned.start_velocity(directions.col(j), product);
    dvs.col(j) = product;
  }
}

MatrixXd MotionDerivatives::Impl::columns_in_user_order(const MatrixXd& values) const {
  MatrixXd result(values.rows(), values.cols());
  for (Eigen::Index j = 0; j < values.cols(); ++j) result.col(j) = in_user_order(values.col(j)).reshaped();
  return result;
}

void MotionDerivatives::Impl::tangent(const MatrixXd& directions, const StateTangents& told) {
  begin_tangent(directions);
  for (std::size_t k = 0;; ++k) {
    told(k, columns_in_user_order(dps), columns_in_user_order(dvs));
    if (k + 1 >= trajectory.size()) return;
    removals.set_for_step(k + 1);
    with_messages([&] { step_forwards(step(k + 1)); });
  }
}

void MotionDerivatives::Impl::begin_steps(const VectorXd& values, const MatrixXd& directions) {
  learned.check(values);
  begin(values);
  set_engines(values);
  begin_tangent(directions);
  dps_before = dps;
  dvs_before = dvs;
  trajectory.hold(present(), present());
}

void MotionDerivatives::Impl::make_step(const VectorXd& values, const MatrixXd& directions) {
  if (trajectory.size() != 2 || directions.cols() != dps.cols())
    throw Error(ErrorKind::input, "learning: steps are made after begin_steps(), with as many changes");
  learned.check(values);
  for (Eigen::Index j = 0; j < directions.cols(); ++j) learned.check(directions.col(j));
  learned.set_without_start(simulation, values);
  removals.begin_at_last();
  if (constraints) constraints->history().begin(simulation);
  simulation.step();
  check_step(1);
  trajectory.hold(trajectory.at(1), present());
  removals.set_for_step(1);
  set_engines(values);
  changes = directions;
  dps_before = dps;
  dvs_before = dvs;
  with_messages([&] { step_forwards(step(1)); });
}

// What a step has for the accelerations at its start, at the derivatives of that state which are at hand. dp and dv are
// derivatives by this state.
void MotionDerivatives::Impl::add_start(const sdk::Host& of) {
  of.jacobian_transposed_times(pending.data(), product.data(), other.data(), SPRINGNET_TRUE_FRICTION);
  if (&of != &host) constraints->add_carried_transposed(pending, product);
  dp += product;
  dv += other;
  weights += pending;
  pending.resize(0);
}

void MotionDerivatives::Impl::start_backwards(std::size_t k) {
  const springnet_evaluation start = evaluation(trajectory.at(k));
  const sdk::Host& of = host_at_start(k, trajectory.time(k), trajectory.time(k + 1));
  of.linearise(start);
  if (internal.any()) {
    work = pending;
    if (&of != &host) {
      host.linearise(start);
      constraints->project(true, work.data());
    }
    internal.weigh_accelerations(start, work);
  }
  weights.setZero(size());
  add_start(of);
  learned.add_cotangent(engine_of(of), of, start, weights.data());
}

// The solutions of the steps after this one go on, nearly.
void MotionDerivatives::Impl::guess_backwards() {
  while (solved.size() > 2) solved.pop_front();
  if (solved.empty())
    solution.setZero();
  else
    solution = solved.size() == 1 ? solved.back() : VectorXd(2.0 * solved.back() - solved.front());
}

void MotionDerivatives::Impl::step_backwards(std::size_t k) {
  // The accelerations at the start of the next step may have other loads, states, springs or contacts than those at the
  // end of this one.
  if (pending.size() > 0 && (!same_at_both || removals.any_at(k) || is_constrained_at(k))) start_backwards(k);
  removals.set_for_step(k);
  const Step own = step(k);
  const springnet_evaluation start = nodes_at(own.from), end = end_of(own);
  weights.setZero(size());
  begin_step(own);
  find_outputs(own);
  solver.prepare(end, own.w, 1, &outputs);
  if (pending.size() > 0) add_start(host);
  internal.weigh_end(end, dp, dv);
  clear_pinned(dp);
  clear_pinned(dv);
  outputs.to_free(dp, dv, rhs);
  clear_pinned(rhs);
  guess_backwards();
  solver.solve_transposed(rhs, accuracy, solution, product, other);
  solved.push_back(solution);
  weights += own.w * solution;
  learned.add_cotangent(engine, host, end, weights.data(), internal.weights());
  product = dp + own.w * product;
  other = dv + own.w * other;
  if (outputs.any()) learned.add_to_masses(outputs.to_masses(product, other));
  outputs.to_start(product, other, dp, dv);
  dv += solution;
  internal.weigh_start(start, end, own.w * solution, dp, dv);
  clear_pinned(dp);
  clear_pinned(dv);
  if (own.c > 0.0) pending = own.c * solution;
}

VectorXd MotionDerivatives::Impl::adjoint(const std::function<void(std::size_t, StateChange&)>& add) {
  learned.begin_cotangent();
  solved.clear();
  dp.setZero();
  dv.setZero();
  internal.begin_weights();
  pending.resize(0);
  const Eigen::Matrix3Xd zero = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(nodes));
  for (std::size_t k = trajectory.size(); k-- > 0;) {
    StateChange own{zero, zero};
    add(k, own);
    if (own.positions.cols() != zero.cols() || own.velocities.cols() != zero.cols())
      throw Error(ErrorKind::input,
                  fmt::format("learning: derivatives by state {} are of {} and {} nodes, must be of {}", k,
                              own.positions.cols(), own.velocities.cols(), zero.cols()));
    add_from_user_order(own.positions, dp);
    add_from_user_order(own.velocities, dv);
    if (k > 0) with_messages([&] { step_backwards(k); });
  }
  if (pending.size() > 0) {
    removals.set_for_step(1);
    with_messages([&] { start_backwards(0); });
  }
  clear_pinned(dv);
  return learned.cotangent(dv);
}

MotionDerivatives::MotionDerivatives(const std::shared_ptr<const Network>& network,
                                     const std::shared_ptr<const PluginHost>& plugins, const SimulationOptions& options,
                                     double duration, std::vector<LearnedValues> learned) {
  if (!network) throw Error(ErrorKind::input, "learning: there is no network");
  if (!plugins) throw Error(ErrorKind::input, "learning: there is no plugin host");
  impl_ = std::make_unique<Impl>(network, plugins, options, duration, std::move(learned));
}
MotionDerivatives::~MotionDerivatives() = default;
MotionDerivatives::MotionDerivatives(MotionDerivatives&&) noexcept = default;
MotionDerivatives& MotionDerivatives::operator=(MotionDerivatives&&) noexcept = default;

std::size_t MotionDerivatives::value_count() const noexcept { return impl_->learned.count(); }
VectorXd MotionDerivatives::values_of_network() const { return impl_->network_values; }
void MotionDerivatives::run(const VectorXd& values) { impl_->run(values); }
std::size_t MotionDerivatives::step_count() const noexcept {
  return impl_->trajectory.size() == 0 ? 0 : impl_->trajectory.size() - 1;
}
double MotionDerivatives::time(std::size_t state) const {
  impl_->check_number(state);
  return impl_->trajectory.time(state);
}
Eigen::Matrix3Xd MotionDerivatives::positions(std::size_t state) const {
  return impl_->in_user_order(impl_->at(state).p);
}
Eigen::Matrix3Xd MotionDerivatives::velocities(std::size_t state) const {
  return impl_->in_user_order(impl_->at(state).v);
}
void MotionDerivatives::tangent(const MatrixXd& changes, const StateTangents& told) { impl_->tangent(changes, told); }
void MotionDerivatives::set_accuracy(double relative) {
  if (!(relative > 0.0 && relative < 1.0))
    throw Error(ErrorKind::input, fmt::format("learning: an accuracy of {} is not between 0 and 1", relative));
  impl_->accuracy = relative;
}
std::vector<Event> MotionDerivatives::events() const { return impl_->removals.events(); }
void MotionDerivatives::set_memory(std::size_t bytes) { impl_->trajectory.set_memory(bytes); }
MotionDerivatives::Kept MotionDerivatives::kept() const noexcept {
  const learning::Trajectory::Use& use = impl_->trajectory.use();
  return {use.most_states, use.most_saved, use.part, use.places, use.steps_again};
}
void MotionDerivatives::begin_steps(const VectorXd& values, const MatrixXd& changes) {
  impl_->begin_steps(values, changes);
}
void MotionDerivatives::make_step(const VectorXd& values, const MatrixXd& changes) {
  impl_->make_step(values, changes);
}
void MotionDerivatives::step_tangents(std::size_t state, MatrixXd& positions, MatrixXd& velocities) const {
  positions = impl_->columns_in_user_order(state == 0 ? impl_->dps_before : impl_->dps);
  velocities = impl_->columns_in_user_order(state == 0 ? impl_->dvs_before : impl_->dvs);
}
VectorXd MotionDerivatives::adjoint(const std::function<void(std::size_t, StateChange&)>& add) {
  return impl_->adjoint(add);
}

}  // namespace springnet
