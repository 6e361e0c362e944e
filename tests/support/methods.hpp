// The integration methods that closed forms are checked with.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "nets.hpp"

namespace springnet::testing {

enum class Order {
  fixed_point,   // backward Euler: first order, damps
  single_sweep,  // symplectic Euler: first order in the state, no drift of the energy
  reference      // CVODE to a relative tolerance
};

struct Method {
  std::string name;
  Order order;
  LawUse integrator;
};

inline constexpr double reference_tolerance = 1e-10;

// Bound for the error of one number of the reference, relative to the scales of its tolerance: in each internal step
// the root mean square of the errors of all 6 n numbers may reach the tolerance, and in these networks errors do not
// grow.
inline double reference_error(const Simulation& simulation) {
  const double numbers = 6.0 * static_cast<double>(simulation.node_count());
  return reference_tolerance * std::sqrt(numbers) * simulation.statistics().at("internal_steps");
}

// force_tolerance: N, far below what matters in the test.
inline std::vector<Method> settled_methods(double force_tolerance) {
  return {{"synchronous", Order::fixed_point, recurrent(synchronous, force_tolerance)},
          {"wavefront", Order::fixed_point, recurrent(wavefront, force_tolerance)},
          {"bdf", Order::reference, cvode(reference_tolerance)},
          {"adams", Order::reference, cvode(reference_tolerance, {{"method", 1}})}};
}
inline std::vector<Method> all_methods(double force_tolerance) {
  std::vector<Method> methods = settled_methods(force_tolerance);
  methods.push_back({"single sweep", Order::single_sweep, single_sweep()});
  return methods;
}

}  // namespace springnet::testing
