// Every integration scheme for a network with constraints, with its order of convergence.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "nets.hpp"

namespace springnet::testing {

struct Scheme {
  std::string name;
  LawUse integrator;
  double order;  // of convergence; 0: the reference
};

// force_tolerance: N, so small that it does not matter beside the errors of the steps.
inline std::vector<Scheme> stepping_schemes(double force_tolerance) {
  std::vector<Scheme> schemes;
  const std::pair<const char*, double> rules[] = {
      {"synchronous", synchronous}, {"wavefront", wavefront}, {"block", block},
      {"coloured", coloured},       {"newton", newton},       {"automatic", automatic}};
  for (const auto& [name, rule] : rules) {
    for (const double theta : {1.0, 0.5}) {
      schemes.push_back({std::string(name) + (theta == 1.0 ? ", theta 1" : ", theta 1/2"),
                         recurrent(rule, force_tolerance, {{"theta", theta}}), theta == 1.0 ? 1.0 : 2.0});
    }
  }
  schemes.push_back({"verlet", {"verlet", {}}, 2.0});
  schemes.push_back({"generalized_alpha", generalized_alpha(), 2.0});
  return schemes;
}
inline std::vector<Scheme> reference_schemes() {
  return {{"bdf, direct", cvode(1e-9, {{"linear_solver", 1}}), 0.0},
          {"bdf, krylov", cvode(1e-9, {{"linear_solver", 2}}), 0.0}};
}
inline std::vector<Scheme> all_schemes(double force_tolerance) {
  std::vector<Scheme> schemes = stepping_schemes(force_tolerance);
  for (Scheme& scheme : reference_schemes()) schemes.push_back(std::move(scheme));
  return schemes;
}

// Greatest relative error of the length of a rigid connection.
inline double worst_length(const Network& net, const Simulation& simulation) {
  double worst = 0.0;
  for (const Rigid& rigid : net.rigids()) {
    const double length = (simulation.position(rigid.first) - simulation.position(rigid.second)).norm();
    worst = std::max(worst, std::abs(length / rigid.length - 1.0));
  }
  return worst;
}

// Greatest distance of a node from where it is in another simulation, m.
inline double distance(const Simulation& a, const Simulation& b) {
  double greatest = 0.0;
  for (NodeIndex k = 0; k < a.node_count(); ++k) greatest = std::max(greatest, (a.position(k) - b.position(k)).norm());
  return greatest;
}

}  // namespace springnet::testing
