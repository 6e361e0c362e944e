// Linear systems of Newton's method, prepared and solved by the host.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/host.hpp>

namespace springnet::recurrent {

class LinearSystem {
 public:
  explicit LinearSystem(sdk::Host host) noexcept : host_(host) {}

  void attach(const springnet_network& network);
  // Derivatives at a state, for the systems that follow.
  void linearise(const springnet_evaluation& at);
  // Another part of the integrator may have replaced the host's derivatives.
  void others_linearised() noexcept { linearised_ = false; }
  // Whether the host's derivatives are those of the last linearise().
  [[nodiscard]] bool at_hand() const noexcept { return linearised_; }
  // Whether solve() can do with what is at hand: derivatives, or a system that was assembled with the same weights.
  [[nodiscard]] bool has(double weight, double shift) const noexcept;
  // Solves (I - w da/dv - w^2 da/dp + shift) x = b among the changes that the constraints allow; [3 nodes], x of all
  // nodes first. accuracy: relative to b. False: the matrix has negative curvature along b, or is practically singular.
  [[nodiscard]] bool solve(double weight, double shift, const std::vector<double>& b, double accuracy,
                           std::vector<double>& x);
  // The matrix met negative curvature in the last solve().
  [[nodiscard]] bool truncated() const noexcept { return truncated_; }
  // Projects values onto the constraints; no effect without any.
  void project(std::vector<double>& values) const;

 private:
  // Relative residual above which a solution is not used.
  static constexpr double max_useful_residual = 0.5;

  sdk::Host host_;
  bool constrained_ = false;
  bool linearised_ = false;  // the host's derivatives are those of the last linearise()
  bool prepared_ = false;    // with the weights below
  bool truncated_ = false;
  double weight_ = 0.0, shift_ = 0.0;
  double krylov_iterations_ = 0.0;  // of the run
};

}  // namespace springnet::recurrent
