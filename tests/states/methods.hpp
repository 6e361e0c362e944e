// Integrators that step internal states, with what theory says of their order.
#pragma once

#include <string>
#include <vector>

#include "nets.hpp"

namespace springnet::testing {

struct StateMethod {
  std::string name;
  LawUse integrator;
  int order;  // in the time step; 0: the reference, to its tolerance
};

inline constexpr double states_tolerance = 1e-10;  // relative, of the reference

inline std::vector<StateMethod> state_methods(double force_tolerance) {
  std::vector<StateMethod> methods{{"single sweep", single_sweep(), 1},
                                   {"verlet", {"verlet", {}}, 2},
                                   {"generalized_alpha", generalized_alpha(), 2},
                                   {"generalized_alpha, 0", generalized_alpha(0.0), 2},
                                   {"bdf direct", cvode(states_tolerance, {{"linear_solver", 1}}), 0},
                                   {"bdf krylov", cvode(states_tolerance, {{"linear_solver", 2}}), 0},
                                   {"adams", cvode(states_tolerance, {{"method", 1}}), 0}};
  for (const char* rule : update_rules) {
    methods.push_back({rule, recurrent(update_named(rule), force_tolerance), 1});
    methods.push_back(
        {std::string(rule) + " trapezoidal", recurrent(update_named(rule), force_tolerance, {{"theta", 0.5}}), 2});
  }
  methods.push_back({"accelerated", recurrent(wavefront, force_tolerance, {{"theta", 0.5}, {"acceleration", 5}}), 2});
  methods.push_back({"located", recurrent(newton, force_tolerance, {{"theta", 0.5}, {"events", 1}}), 2});
  return methods;
}

}  // namespace springnet::testing
