// The linear systems of Newton's method: iterative (BiCGSTAB, preconditioned with the 3x3 blocks of the nodes); direct,
// by the host with a reused pattern, for small networks, and for those whose iterations do not converge unless they are
// so large that their factors would fill up.
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
  // (I - w da/dv - w^2 da/dp + shift) x = b in the space that constraints allow, b being in it; [3 nodes], x of all
  // nodes first. accuracy: of the iteration, relative to b. False: no answer, the matrix is as good as singular.
  [[nodiscard]] bool solve(double weight, double shift, const std::vector<double>& b, double accuracy,
                           std::vector<double>& x);
  // values -= what constraints do not allow; nothing where there are none.
  void project(std::vector<double>& values) const;

 private:
  struct Operator;
  struct Preconditioner;
  bool solve_directly(double velocity_weight, double position_weight, const std::vector<double>& b,
                      std::vector<double>& x);
  bool iterate(double velocity_weight, double position_weight, const std::vector<double>& b, double accuracy,
               std::vector<double>& x);
  void make_preconditioner(double velocity_weight, double position_weight);

  sdk::Host host_;
  std::size_t nodes_ = 0;
  bool direct_ = true;         // now
  bool may_factorise_ = true;  // where the iteration does not converge
  bool constrained_ = false;
  bool factorised_ = false;  // with the weights below, the derivatives since linearise()
  double velocity_weight_ = 0.0, position_weight_ = 0.0;
  double krylov_iterations_ = 0.0;          // of the run
  std::vector<double> mass_;                // kg
  std::vector<double> inverse_, mobility_;  // [node][3][3]
  std::vector<double> scaled_p_, scaled_v_, work_;
};

}  // namespace springnet::recurrent
