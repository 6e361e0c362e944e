// Total work over all restarts. CVODE's own counters are reset by each restart.
#pragma once

#include <cstdint>

namespace springnet::cvode {

struct Counters {
  long internal_steps = 0;
  long linear_setups = 0;  // factorisations or preconditioners
  long krylov_iterations = 0;
  long nonlinear_iterations = 0;
  long convergence_failures = 0;
  long error_test_failures = 0;

  Counters& operator+=(const Counters& other) noexcept {
    internal_steps += other.internal_steps;
    linear_setups += other.linear_setups;
    krylov_iterations += other.krylov_iterations;
    nonlinear_iterations += other.nonlinear_iterations;
    convergence_failures += other.convergence_failures;
    error_test_failures += other.error_test_failures;
    return *this;
  }
};

}  // namespace springnet::cvode
