// A motion with its derivatives: what MotionDerivatives consists of. Forwards in motion_forwards.cpp, backwards in
// motion_backwards.cpp, parts of divided steps in motion_parts.cpp.
#pragma once

#include <cmath>
#include <deque>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/motion_derivatives.hpp>
#include <springnet/sdk/host.hpp>

#include "learning/constrained_outputs.hpp"
#include "learning/event_condition.hpp"
#include "learning/event_jump.hpp"
#include "learning/internal_states.hpp"
#include "learning/learned_values.hpp"
#include "learning/motion_checks.hpp"
#include "learning/removals.hpp"
#include "learning/scene_changes.hpp"
#include "learning/solution_guess.hpp"
#include "learning/step_constraints.hpp"
#include "learning/step_parts.hpp"
#include "learning/step_solver.hpp"
#include "learning/straight_angles.hpp"
#include "learning/trajectory.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"

namespace springnet {

// Vectors of all nodes have the engine's order, x of all nodes, then y, then z.
struct MotionDerivatives::Impl {
  using State = learning::Trajectory::State;
  // A step, or a part of one that is divided, at the state where it ends, and how its derivatives are weighed.
  struct Step {
    std::size_t number;  // counts parts
    const State &from, &until;
    double w, c;                                    // s
    bool kept = false;                              // contacts, which no sweep has decided
    bool starts_at_event = false;                   // at a time that changes
    bool is_instant = false;                        // between events at the same time
    const learning::LocatedEvent* event = nullptr;  // which determines its end; null: none does
  };
  // Of a time step, with the states within it.
  struct Parts {
    std::deque<State> states;
    std::vector<Step> steps;
  };
  // How V, the outputs of a step and internal states at its end change with a time.
  struct ByTime {
    Eigen::VectorXd free, p, v, z;
  };
  struct ByTimes {
    ByTime start, end;
  };
  // Of the node of an event where the part before it begins, and of the time there: a column for each change.
  struct StartChanges {
    Eigen::Matrix3Xd positions, velocities;
    Eigen::RowVectorXd times;
  };

  Impl(const std::shared_ptr<const Network>& net, const std::shared_ptr<const PluginHost>& plugins,
       const SimulationOptions& options, double duration, std::vector<LearnedValues> values)
      : learned(*net, std::move(values)),
        simulation(net, plugins, options),
        locates(learning::option(options.integrator, "events", 0.0) != 0.0),
        recorder(locates, [this](const learning::PartRecorder::Committed& committed) { take_part(committed); }),
        trajectory(
            simulation, [this](State& to) { record(to); }, recorder, locates || !net->changes().empty()),
        time_step(options.time_step),
        engine(net->without_constraints(), *plugins, options),
        table(make_host_table(engine)),
        host(table),
        solver(engine, host),
        theta(learning::option(options.integrator, "theta", 1.0)),
        internal(engine, theta),
        same_at_both(net->inputs().empty() && !internal.any()),
        removals(engine),
        scene_changes(*net, engine, learned),
        steps(static_cast<std::size_t>(std::llround(duration / options.time_step))) {
    learning::check_method(options.integrator);
    learning::check_net(*net);
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
      scene_changes.follow(constraints->engine());
    }
    trajectory.set_reserved(scene_changes.bytes());
    internal.check_start(learned, network_values);
    saved_start = simulation.save();
    for (Eigen::VectorXd* each : {&dp, &dv, &rhs, &product, &other, &solution}) each->setZero(size());
  }

  [[nodiscard]] Eigen::Index size() const { return 3 * static_cast<Eigen::Index>(nodes); }
  // With the internal states as they are, or of the step that ends there.
  [[nodiscard]] springnet_evaluation evaluation(const State& at) {
    springnet_evaluation result = nodes_at(at);
    result.internal = internal.as_they_are(at.z);
    return result;
  }
  [[nodiscard]] springnet_evaluation end_of(const Step& step) { return end_of(step, step.until.time - step.from.time); }
  // length: of the step of internal states, s.
  [[nodiscard]] springnet_evaluation end_of(const Step& step, double length) {
    springnet_evaluation result = nodes_at(step.until);
    if (!arrivals.empty()) {
      const double* const v = end_velocity.data();
      result.velocity = {v, v + nodes, v + 2 * nodes};
    }
    result.internal = internal.stepped(length);
    return result;
  }
  // What stops nodes that arrive at a surface in the step, of (dP, dU) with dU in the step; and the transpose.
  void land(Eigen::VectorXd& of_positions, Eigen::VectorXd& of_velocities) const;
  void land_transposed(Eigen::VectorXd& of_positions, Eigen::VectorXd& of_velocities) const;
  [[nodiscard]] springnet_evaluation nodes_at(const State& at) const {
    auto result = sdk::sized<springnet_evaluation>();
    result.time = at.time;
    result.position = {at.p.data(), at.p.data() + nodes, at.p.data() + 2 * nodes};
    result.velocity = {at.v.data(), at.v.data() + nodes, at.v.data() + 2 * nodes};
    return result;
  }
  [[nodiscard]] Parts parts_of(std::size_t k);
  [[nodiscard]] Step part(std::size_t number, const State& from, const State& until) const {
    const double h = until.time - from.time;
    return {number, from, until, theta * h, (1.0 - theta) * h, locates && decided.count(number) == 0};
  }
  // With the host's step begun, m/s^2.
  [[nodiscard]] Eigen::VectorXd accelerations(const sdk::Host& of, springnet_evaluation where) const {
    Eigen::VectorXd result(size());
    where.acceleration = {result.data(), result.data() + nodes, result.data() + 2 * nodes};
    of.evaluate(where);
    return result;
  }
  // Of nodes whose motion is given, in the step that has begun, nothing depends on what is learned.
  void clear_pinned(Eigen::VectorXd& values) const {
    for (const Eigen::Index place : pinned) values[place] = 0.0;
  }
  [[nodiscard]] Eigen::Matrix3Xd in_user_order(const Eigen::VectorXd& values) const {
    Eigen::Matrix3Xd result(3, static_cast<Eigen::Index>(nodes));
    const std::vector<std::uint32_t>& number = engine.model().layout.ordering().engine;
    for (std::size_t k = 0; k < nodes; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        result(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(k)) =
            values[static_cast<Eigen::Index>(axis * nodes + number[k])];
    return result;
  }
  void add_from_user_order(const Eigen::Matrix3Xd& from, Eigen::VectorXd& to) const {
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
  void add_settled(double residual);
  void begin(const Eigen::VectorXd& values);
  void begin_parts() {
    parts_before.clear();
    part_count = 0;
    decided.clear();
  }
  void run(const Eigen::VectorXd& values);
  void check_start(const State& start);
  void record(State& to) const;
  [[nodiscard]] State present() const {
    State result;
    record(result);
    return result;
  }
  void check_step(std::size_t state);
  void begin_tangent(const Eigen::MatrixXd& directions);
  [[nodiscard]] Eigen::MatrixXd columns_in_user_order(const Eigen::MatrixXd& values) const;
  void tangent(const Eigen::MatrixXd& directions, const StateTangents& told);
  void begin_steps(const Eigen::VectorXd& values, const Eigen::MatrixXd& directions);
  void make_step(const Eigen::VectorXd& values, const Eigen::MatrixXd& directions);
  Eigen::VectorXd adjoint(const std::function<void(std::size_t, StateChange&)>& add);
  void begin_step(const Step& step);
  void step_forwards(const Step& step);
  void add_internal_at_start(const sdk::Host& of, const springnet_evaluation& start, double weight);
  void step_backwards(const Step& own);
  void begin_backwards(const Step& own);
  // Parts of divided steps: see motion_parts.cpp.
  void take_part(const learning::PartRecorder::Committed& committed);
  void part_forwards(const Step& step);
  void part_backwards(const Step& step);
  // The state has a column more, of that change, which this takes off.
  void event_forwards(const Step& step, Eigen::Index columns, const StartChanges& start);
  [[nodiscard]] learning::StartGradient event_backwards(const Step& step);
  [[nodiscard]] double begin_of(const Step& step) const;
  // Forwards, with the changes of its times that are set, which stay no longer.
  void pass_part(const Step& step);
  void pass_instant(const Step& step);
  // How internal states change with the time where an instant begins, with these accelerations.
  [[nodiscard]] Eigen::VectorXd rates_in_instant(const Step& step, const Eigen::VectorXd& a);
  [[nodiscard]] ByTimes find_times(const Step& step);
  [[nodiscard]] learning::EventCondition condition_of(const Step& step);
  // How the value of an event of a node changes, but for what it does by accelerations, [3 node], which is written.
  void add_condition(const Step& step, const springnet_evaluation& end, learning::EventCondition& to);
  // Of nodes_of_event().
  [[nodiscard]] learning::EventJump jump_of(const Step& step);
  [[nodiscard]] static std::vector<std::uint32_t> nodes_of_event(const learning::LocatedEvent& event);
  // f(cluster event), of a part that ends with an event of rigidly connected nodes.
  template <class Function>
  auto with_cluster(const Step& step, const Function& function);
  // Derivatives by time that have no formula, of loads and of accelerations of surfaces, are central differences over
  // twice this share of the time step: of an error of 1e-8 times the square of the angle by which they swing in a step.
  static constexpr double share_of_step = 1e-4;
  static constexpr double share_of_instant = 1e-6;  // times the time step
  void begin_instant(double time);
  // How fast the value of an event changes with the time of it.
  [[nodiscard]] double rate_of(const Step& step, const learning::EventCondition& condition, const Eigen::VectorXd& p,
                               const Eigen::VectorXd& v, const Eigen::VectorXd& z) const;
  [[noreturn]] void refuse(const learning::LocatedEvent& event, double time, const std::string& what) const;
  [[noreturn]] void refuse(const Step& step, const std::string& what) const;
  void check_event_of_cluster(const learning::LocatedEvent& event, double time) const;
  [[noreturn]] void refuse_times(const Step& step, std::uint32_t node) const;
  void start_backwards(const State& at, std::size_t number, double until);
  void set_engines(const Eigen::VectorXd& values);
  void set_for_step(std::size_t until);
  // Nodes that arrive at a surface, and velocities in the step. Before end_of() of this step.
  void find_arrivals(const Step& step);
  void find_outputs(const Step& step);
  // By how much the step that ends at a time, or has it within, may have left velocities from those of one that is
  // settled exactly, m/s.
  [[nodiscard]] double unsettled_until(double time) const;
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
  bool locates;  // steps are divided where events are located
  learning::PartRecorder recorder;
  learning::Trajectory trajectory;  // of the last run
  double time_step;                 // s
  // Answers for derivatives, at the states of the last run, of the net without constraints; which, null: there are
  // none, are by themselves.
  Engine engine;
  springnet_host table;
  sdk::Host host;
  std::unique_ptr<learning::StepConstraints> constraints;
  learning::ConstrainedOutputs outputs;  // of a step
  std::vector<learning::Arrival> arrivals;
  Eigen::VectorXd end_velocity;  // m/s, in that step, if nodes arrive
  learning::StepSolver solver;
  double theta;
  learning::InternalStates internal;
  bool same_at_both;  // accelerations at a time, as the end of a step and as the start of the next one
  learning::Removals removals;
  learning::SceneChanges scene_changes;
  double accuracy = 1e-10;
  std::vector<Settled> settled;  // [state]
  std::size_t steps, nodes = 0;
  std::string saved_start;
  Eigen::VectorXd network_values;
  std::vector<Event> events;      // of the last run; those of the simulation follow the steps that are made again
  std::size_t events_before = 0;  // in the simulation
  Eigen::VectorXd dp, dv;         // the change of a state, or derivatives of the loss by it
  Eigen::VectorXd rhs, product, other, solution, work;
  Eigen::VectorXd weights;                  // of the accelerations at a state
  learning::SolutionGuess weights_guess;    // of those, backwards
  Eigen::VectorXd pending;                  // those that the step after a state has for its start; empty: none
  double pending_until = 0.0;               // s: the end of that step
  std::uint64_t pending_loads = 0;          // the engine's revision of loads in that step
  Eigen::MatrixXd changes, dps, dvs, rhss;  // of the tangent: a column for each change of values
  Eigen::MatrixXd by_values;                // accelerations for each of those
  Eigen::MatrixXd dps_before, dvs_before;   // at the start of the step made last
  // Parts: how many there are before each step that was made, and in all; those whose contacts sweeps have decided.
  std::vector<std::size_t> parts_before;
  std::size_t part_count = 0;
  std::set<std::size_t> decided;
  std::vector<Eigen::Index> pinned;  // see clear_pinned()
  // Changes of the time of the last event, at which the next part starts, 0 at the start of a time step; those of the
  // start and the end of a part while it is passed (empty: these stay); and the derivative of the loss by that time.
  Eigen::RowVectorXd event_time_changes, start_time_changes, end_time_changes;
  double by_event_time = 0.0;
};

}  // namespace springnet
