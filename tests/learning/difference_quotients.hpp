// Sensitivities of a motion that share no derivative with the library: CVODES on y = (p, v) by Adams' method, with its
// own difference quotients for the right-hand side of the sensitivities. Of the library there are accelerations alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <Eigen/Core>

#include <springnet/motion_derivatives.hpp>
#include <springnet/sdk/host.hpp>

#include "learning/learned_values.hpp"
#include "nets.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"

namespace springnet::testing {

// Positions and velocities, x y z of node 0, of node 1, …: p first.
inline Eigen::VectorXd stacked(const Eigen::Matrix3Xd& positions, const Eigen::Matrix3Xd& velocities) {
  Eigen::VectorXd result(2 * positions.size());
  result << positions.reshaped(), velocities.reshaped();
  return result;
}

class DifferenceQuotients {
 public:
  // Relative to the size of each scalar: increments are its square root, their errors of second order, so that
  // quotients are good to about it.
  static constexpr double tolerance = 1e-9;

  // Values are those of the network + changes q, at q = 0; a column of `changes` for each scalar of this size.
  DifferenceQuotients(const Network& network, std::vector<LearnedValues> values, const Eigen::MatrixXd& changes,
                      const std::vector<double>& sizes)
      : learned_(network, std::move(values)),
        engine_(network, *plugins(), options()),
        table_(make_host_table(engine_)),
        host_(table_),
        nodes_(host_.network().node_count),
        changes_(changes),
        q_(sizes.size(), 0.0),
        set_(sizes.size(), 0.0),
        sizes_(sizes) {
    learned_.attach(engine_);
    base_ = learned_.values_of(engine_);
  }

  // The state, and beside it a column for each scalar, at a time (s) from the start.
  [[nodiscard]] Eigen::MatrixXd at(double until) {
    SUNContext context = nullptr;
#if SUNDIALS_VERSION_MAJOR >= 7
    SUNContext_Create(SUN_COMM_NULL, &context);
#else
    SUNContext_Create(nullptr, &context);
#endif
    const auto size = static_cast<sunindextype>(6 * nodes_);
    const int count = static_cast<int>(q_.size());
    N_Vector y = N_VNew_Serial(size, context);
    N_Vector* s = N_VCloneVectorArray(count, y);
    host_.begin_interval(0.0, std::min(until, host_.next_discontinuity(0.0)));
    const springnet_state& start = host_.committed().state;
    double* to = N_VGetArrayPointer(y);
    for (const springnet_vectors& part : {start.position, start.velocity})
      for (const double* component : {part.x, part.y, part.z}) to = std::copy_n(component, nodes_, to);
    for (int j = 0; j < count; ++j) {
      Eigen::VectorXd velocity = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * nodes_));
      learned_.start_velocity(changes_.col(j), velocity);
      N_VConst(0.0, s[j]);
      std::copy_n(velocity.data(), 3 * nodes_, N_VGetArrayPointer(s[j]) + 3 * nodes_);
    }
    void* memory = CVodeCreate(CV_ADAMS, context);
    SUNNonlinearSolver solver = SUNNonlinSol_FixedPoint(y, 0, context);
    SUNNonlinearSolver solver_of_changes = SUNNonlinSol_FixedPointSens(count, y, 0, context);
    std::vector<double> absolute;
    for (const double each : sizes_) absolute.push_back(10.0 * tolerance / each);
    double time = 0.0;
    int status = CVodeInit(memory, &right_side, 0.0, y);
    const auto then = [&status](int next) { status = status < 0 ? status : next; };
    then(CVodeSetUserData(memory, this));
    then(CVodeSStolerances(memory, tolerance, 0.1 * tolerance));
    then(CVodeSetNonlinearSolver(memory, solver));
    then(CVodeSetMaxNumSteps(memory, 1000000));
    then(CVodeSensInit(memory, count, CV_STAGGERED, nullptr, s));
    then(CVodeSetNonlinearSolverSensStg(memory, solver_of_changes));
    then(CVodeSetSensParams(memory, q_.data(), sizes_.data(), nullptr));
    then(CVodeSetSensDQMethod(memory, CV_CENTERED, 0.0));
    then(CVodeSensSStolerances(memory, 10.0 * tolerance, absolute.data()));
    then(CVodeSetSensErrCon(memory, SUNTRUE));
    while (status >= 0 && time < until) {
      const double stop = std::min(until, host_.next_discontinuity(time));
      if (time > 0.0) {
        host_.begin_interval(time, stop);
        then(CVodeReInit(memory, time, y));
        then(CVodeSensReInit(memory, CV_STAGGERED, s));
      }
      then(CVodeSetStopTime(memory, stop));
      then(CVode(memory, stop, y, &time, CV_NORMAL));
      then(CVodeGetSens(memory, &time, s));
    }
    Eigen::MatrixXd result(6 * static_cast<Eigen::Index>(nodes_), count + 1);
    result.col(0) = in_user_order(N_VGetArrayPointer(y));
    for (int j = 0; j < count; ++j) result.col(j + 1) = in_user_order(N_VGetArrayPointer(s[j]));
    CVodeFree(&memory);
    SUNNonlinSolFree(solver);
    SUNNonlinSolFree(solver_of_changes);
    N_VDestroyVectorArray(s, count);
    N_VDestroy(y);
    SUNContext_Free(&context);
    if (status < 0) throw std::runtime_error("CVODES failed");
    return result;
  }

 private:
  static SimulationOptions options() {
    SimulationOptions result;
    result.integrator = cvode(tolerance);
    result.threads = 1;
    return result;
  }
  static int right_side(double time, N_Vector y, N_Vector rate, void* user) {
    auto& self = *static_cast<DifferenceQuotients*>(user);
    const std::size_t n = self.nodes_;
    if (self.q_ != self.set_) {
      self.set_ = self.q_;
      const Eigen::Map<const Eigen::VectorXd> q(self.q_.data(), static_cast<Eigen::Index>(self.q_.size()));
      self.learned_.set(self.engine_, self.base_ + self.changes_ * q);
    }
    const double* const from = N_VGetArrayPointer(y);
    double* const to = N_VGetArrayPointer(rate);
    std::copy_n(from + 3 * n, 3 * n, to);
    auto evaluation = sdk::sized<springnet_evaluation>();
    evaluation.time = time;
    evaluation.position = {from, from + n, from + 2 * n};
    evaluation.velocity = {from + 3 * n, from + 4 * n, from + 5 * n};
    evaluation.acceleration = {to + 3 * n, to + 4 * n, to + 5 * n};
    self.host_.evaluate(evaluation);
    return 0;
  }
  [[nodiscard]] Eigen::VectorXd in_user_order(const double* values) const {
    Eigen::VectorXd result(6 * static_cast<Eigen::Index>(nodes_));
    const std::vector<std::uint32_t>& number = engine_.model().layout.ordering().engine;
    Eigen::Index next = 0;
    for (std::size_t half = 0; half < 2; ++half)
      for (std::size_t k = 0; k < nodes_; ++k)
        for (std::size_t axis = 0; axis < 3; ++axis) result[next++] = values[(3 * half + axis) * nodes_ + number[k]];
    return result;
  }

  learning::LearnedSets learned_;
  Engine engine_;
  springnet_host table_;
  sdk::Host host_;
  std::size_t nodes_;
  Eigen::MatrixXd changes_;
  Eigen::VectorXd base_;
  std::vector<double> q_, set_;  // that CVODES changes; that the engine has
  std::vector<double> sizes_;
};

}  // namespace springnet::testing
