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
  // Prepares I - w da/dv - w^2 da/dp + shift at a state; exact: without approximations of the host's.
  void prepare(const springnet_evaluation& at, double weight, double shift, bool exact);
  // Whether the prepared system has these weights.
  [[nodiscard]] bool has(double weight, double shift) const noexcept;
  // Solves the system among the changes that the constraints allow; [3 nodes], x of all nodes first. accuracy: relative
  // to b. False: the matrix has negative curvature along b, or is practically singular.
  [[nodiscard]] bool solve(const std::vector<double>& b, double accuracy, std::vector<double>& x);
  // The matrix met negative curvature in the last solve().
  [[nodiscard]] bool truncated() const noexcept { return truncated_; }
  // Of Krylov's method in the last solve().
  [[nodiscard]] std::uint64_t iterations() const noexcept { return iterations_; }
  // Projects values onto the constraints; no effect without any.
  void project(std::vector<double>& values) const;

 private:
  // Relative residual above which a solution is not used.
  static constexpr double max_useful_residual = 0.5;

  sdk::Host host_;
  bool has_true_friction_ = false;
  bool constrained_ = false;
  bool prepared_ = false;  // with the weights below
  bool truncated_ = false;
  double weight_ = 0.0, shift_ = 0.0;
  std::uint64_t iterations_ = 0;
};

}  // namespace springnet::recurrent
