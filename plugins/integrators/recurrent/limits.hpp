// The largest time steps of the update rules.
//
// With the error u of the velocities, that of the positions is w u (w = theta times the time constant), and a sweep of
// the linearised network multiplies u by a matrix made of
//
//   A = w^2 M^-1 K + w M^-1 D        (K, D: -m da/dp, -m da/dv)
//
//   synchronous          u <- -A u
//   wavefront            the same node by node, with the newest values of the others
//   block, coloured      node by node u_k <- -(I + A_kk)^-1 (rest of row k of A) u
//   newton               u <- 0
//
// A step settles while the spectral radius of that matrix is below 1. The rules sweep the linear network themselves
// (Rule::linear_sweep), so what is found is theirs, with their orders and what rigid connections make of them.
#pragma once

#include <functional>

#include <springnet/sdk/limits.hpp>

#include "rule.hpp"

namespace springnet::recurrent {

// Tells the limits of all rules at the committed state. rule(update): an attached rule.
void report_limits(Workspace& workspace, double theta, const std::function<Rule&(Update)>& rule,
                   const sdk::LimitSink& sink);

}  // namespace springnet::recurrent
