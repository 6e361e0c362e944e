// What the reference integrator counts for the summary.
#include <cstdint>

#include "integrator.hpp"

namespace springnet::cvode {

Counters ReferenceIntegrator::counters() const {
  Counters result;
  void* memory = memory_.get();
  if (memory == nullptr) return result;
  CVodeGetNumSteps(memory, &result.internal_steps);
  CVodeGetNumLinSolvSetups(memory, &result.linear_setups);
  CVodeGetNumNonlinSolvIters(memory, &result.nonlinear_iterations);
  CVodeGetNumNonlinSolvConvFails(memory, &result.convergence_failures);
  CVodeGetNumErrTestFails(memory, &result.error_test_failures);
  if (callbacks_.newton) CVodeGetNumLinIters(memory, &result.krylov_iterations);
  return result;
}

long ReferenceIntegrator::internal_steps() const { return total_.internal_steps + counters().internal_steps; }

// What has come since the last report is added to what the host has, of the whole run.
void ReferenceIntegrator::report_statistics() {
  Counters sum = total_;
  sum += counters();
  const Equations::Work& work = equations_.work();
  const auto count = [this](const char* name, auto total) {
    double& before = reported_[name];
    host_.count(name, static_cast<double>(total) - before);
    before = static_cast<double>(total);
  };
  count("internal_steps", sum.internal_steps);
  count("rhs_evaluations", work.evaluations);
  count("linear_setups", sum.linear_setups);
  count("linearisations", work.linearisations);
  count("jacobian_products", work.jacobian_products);
  count("krylov_iterations", sum.krylov_iterations);
  count("nonlinear_iterations", sum.nonlinear_iterations);
  count("convergence_failures", sum.convergence_failures);
  count("error_test_failures", sum.error_test_failures);
  count("root_evaluations", work.event_evaluations);
  if (sensitivities_.any()) count("parameter_products", work.parameter_products);
  if (projects_) count("projections", work.projections);
  count("restarts", restarts_);
  if (!memory_) return;
  double last_step = 0.0;
  int order = 0;
  CVodeGetLastStep(memory_.get(), &last_step);
  CVodeGetLastOrder(memory_.get(), &order);
  host_.report("last_step_s", last_step);
  host_.report("order", order);
}

}  // namespace springnet::cvode
