// Linear systems of Newton's method. Iterative: BiCGSTAB, preconditioned with the 3x3 blocks of the nodes. Direct: by
// the host with a reused pattern; for small networks, and as fallback if the iteration does not converge, unless the
// network is so large that its factors would fill in.
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
  // Solves (I - w da/dv - w^2 da/dp + shift) x = b in the subspace that the constraints allow and that contains b; [3
  // nodes], x of all nodes first. accuracy: of the iteration, relative to b. False: the matrix is practically singular.
  [[nodiscard]] bool solve(double weight, double shift, const std::vector<double>& b, double accuracy,
                           std::vector<double>& x);
  // Projects values onto the constraints; no effect without any.
  void project(std::vector<double>& values) const;

 private:
  bool solve_directly(double velocity_weight, double position_weight, const std::vector<double>& b,
                      std::vector<double>& x);
  bool iterate(double velocity_weight, double position_weight, const std::vector<double>& b, double accuracy,
               std::vector<double>& x);
  void make_preconditioner(double velocity_weight, double position_weight);

  sdk::Host host_;
  std::size_t nodes_ = 0;
  bool direct_ = true;         // now
  bool may_factorise_ = true;  // if the iteration does not converge
  bool constrained_ = false;
  bool factorised_ = false;  // with the weights below, the derivatives since linearise()
  double velocity_weight_ = 0.0, position_weight_ = 0.0;
  double krylov_iterations_ = 0.0;          // of the run
  std::vector<double> mass_;                // kg
  std::vector<double> inverse_, mobility_;  // [node][3][3]
  std::vector<double> scaled_p_, scaled_v_, work_;
};

}  // namespace springnet::recurrent
