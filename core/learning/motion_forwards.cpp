#include "learning/motion.hpp"

#include <functional>
#include <utility>

#include <springnet/error.hpp>

namespace springnet {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Each column of dps and dvs is the change of a state.
void MotionDerivatives::Impl::step_forwards(const Step& step) {
  begin_step(step);
  const Index columns = dps.cols();
  rhss = dvs;
  const auto add = [&](const sdk::Host& of, const springnet_evaluation& where, double weight, bool at_end) {
    std::function<double*(Index)> of_states;
    if (at_end && internal.any()) of_states = [this](Index j) { return internal.by_values(j); };
    learned.tangents(engine_of(of), of, where, changes, by_values, of_states);
    rhss += weight * by_values;
    for (Index j = 0; j < columns; ++j) {
      of.jacobian_times(dps.col(j).data(), dvs.col(j).data(), product.data(), SPRINGNET_TRUE_FRICTION);
      if (&of != &host) {
        work = dps.col(j);
        constraints->add_carried(work, product);
      }
      rhss.col(j) += weight * product;
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
  find_arrivals(step);
  const springnet_evaluation end = end_of(step);
  find_outputs(step);
  const bool timed = start_time_changes.size() > 0;
  ByTimes by_times;
  if (timed) by_times = find_times(step);
  solver.prepare(end, step.w, columns, &outputs);
  internal.add_by_start(start, end, step.w, dps, dvs, rhss);
  // Without the velocities V that are yet to be found.
  for (Index j = 0; j < columns; ++j) {
    outputs.from_start(dps.col(j), dvs.col(j), solution, product);
    if (outputs.any()) {
      outputs.add_masses(learned.mass_changes(changes.col(j), nodes), solution, product);
      if (learned.has_friction()) outputs.add_friction(learned.friction_changes(changes.col(j)), solution, product);
    }
    if (timed) {
      clear_pinned(solution);
      clear_pinned(product);
      solution += start_time_changes[j] * by_times.start.p + end_time_changes[j] * by_times.end.p;
      product += start_time_changes[j] * by_times.start.v + end_time_changes[j] * by_times.end.v;
      rhss.col(j) += start_time_changes[j] * by_times.start.free + end_time_changes[j] * by_times.end.free;
    }
    dps.col(j) = solution;
    dvs.col(j) = product;
  }
  add(host, end, step.w, true);
  for (Index j = 0; j < columns; ++j) {
    rhs = rhss.col(j);
    clear_pinned(rhs);
    outputs.clear_unused(rhs);
    solver.solve(rhs, accuracy, solution);
    outputs.from_free(solution, product, other);
    product += dps.col(j);
    other += dvs.col(j);
    if (!timed) {
      clear_pinned(product);
      clear_pinned(other);
    }
    dps.col(j) = product;
    dvs.col(j) = other;
  }
  internal.end_step(end, dps, dvs);
  for (Index j = 0; j < columns && timed; ++j)
    internal.change(j) += start_time_changes[j] * by_times.start.z + end_time_changes[j] * by_times.end.z;
  for (Index j = 0; j < columns && !arrivals.empty(); ++j) {
    product = dps.col(j);
    other = dvs.col(j);
    land(product, other);
    dvs.col(j) = other;
  }
}

// What changes of internal states at the start make of the accelerations there.
void MotionDerivatives::Impl::add_internal_at_start(const sdk::Host& of, const springnet_evaluation& start,
                                                    double weight) {
  if (!internal.any()) return;
  if (&of == &host) return internal.add_accelerations(start, weight, rhss);
  host.linearise(start);
  MatrixXd free = MatrixXd::Zero(size(), rhss.cols());
  internal.add_accelerations(start, weight, free);
  for (Index j = 0; j < free.cols(); ++j) constraints->project(false, free.col(j).data());
  rhss += free;
}

void MotionDerivatives::Impl::begin_tangent(const MatrixXd& directions) {
  for (Index j = 0; j < directions.cols(); ++j) learned.check(directions.col(j));
  changes = directions;
  dps.setZero(size(), directions.cols());
  dvs.setZero(size(), directions.cols());
  event_time_changes.setZero(directions.cols());
  internal.begin_changes(directions.cols());
  for (Index j = 0; j < directions.cols(); ++j) {
    product.setZero();
    learned.start_velocity(directions.col(j), product);
    dvs.col(j) = product;
  }
}

MatrixXd MotionDerivatives::Impl::columns_in_user_order(const MatrixXd& values) const {
  MatrixXd result(values.rows(), values.cols());
  for (Index j = 0; j < values.cols(); ++j) result.col(j) = in_user_order(values.col(j)).reshaped();
  return result;
}

void MotionDerivatives::Impl::tangent(const MatrixXd& directions, const StateTangents& told) {
  begin_tangent(directions);
  for (std::size_t k = 0;; ++k) {
    told(k, columns_in_user_order(dps), columns_in_user_order(dvs));
    if (k + 1 >= trajectory.size()) return;
    with_messages([&] {
      const Parts parts = parts_of(k + 1);
      for (const Step& each : parts.steps) part_forwards(each);
    });
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
  check_start(trajectory.at(0));
}

void MotionDerivatives::Impl::make_step(const VectorXd& values, const MatrixXd& directions) {
  if (trajectory.size() != 2 || directions.cols() != dps.cols())
    throw Error(ErrorKind::input, "learning: steps are made after begin_steps(), with as many changes");
  learned.check(values);
  for (Index j = 0; j < directions.cols(); ++j) learned.check(directions.col(j));
  removals.begin_at_last();
  scene_changes.begin_at_last();
  set_for_step(1);
  learned.set_without_start(simulation, values);
  begin_parts();
  settled.assign(1, settled.back());
  if (constraints) constraints->history().begin(simulation);
  recorder.step(simulation, true);
  check_step(1);
  State reached = present();
  reached.parts = recorder.parts();
  trajectory.hold(trajectory.at(1), std::move(reached));
  set_for_step(1);
  set_engines(values);
  changes = directions;
  dps_before = dps;
  dvs_before = dvs;
  with_messages([&] {
    const Parts parts = parts_of(1);
    for (const Step& each : parts.steps) part_forwards(each);
  });
}

}  // namespace springnet
