// The generalized-alpha method, and its numbers, for tests.
#pragma once

#include <Eigen/Core>

#include "nets.hpp"

namespace springnet::testing {

// The map (p, h v, h^2 a) from one step to the next for x'' = -omega^2 x - 2 decay x', after Chung and Hulbert 1993.
inline Eigen::Matrix3d amplification(double rho, double omega, double decay, double h) {
  const double alpha_m = (2.0 * rho - 1.0) / (rho + 1.0), alpha_f = rho / (rho + 1.0);
  const double gamma = 0.5 - alpha_m + alpha_f, beta = 0.25 * (1.0 - alpha_m + alpha_f) * (1.0 - alpha_m + alpha_f);
  const double stiff = omega * omega * h * h, damp = 2.0 * decay * h, share = 1.0 - alpha_f;
  // Unknowns P, V, A: P - beta A = p + v + (1/2 - beta) a; V - gamma A = v + (1 - gamma) a; and the balance.
  Eigen::Matrix3d left, right;
  left << 1.0, 0.0, -beta, 0.0, 1.0, -gamma, share * stiff, share * damp, 1.0 - alpha_m;
  right << 1.0, 1.0, 0.5 - beta, 0.0, 1.0, 1.0 - gamma, -alpha_f * stiff, -alpha_f * damp, -alpha_m;
  return left.inverse() * right;
}

}  // namespace springnet::testing
