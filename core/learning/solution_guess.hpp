// A first guess of the solution of a linear system that changes little from step to step.
#pragma once

#include <array>

#include <Eigen/Core>

namespace springnet::learning {

// Solutions and right sides of the last two steps go on in straight lines; what the right side departs from its own
// changes the solution by a share of it, in the mean as it did in the steps so far. In steps that springs hardly resist
// this is nearly all of it, in stiff ones next to nothing.
class SolutionGuess {
 public:
  void clear() noexcept { count_ = 0; }
  // Writes x.
  void find(const Eigen::VectorXd& right_side, Eigen::VectorXd& x);
  // The solution that was found for the right side of the last find().
  void take(const Eigen::VectorXd& x);

 private:
  std::array<Eigen::VectorXd, 2> solutions_, right_sides_;  // the last one first
  Eigen::VectorXd straight_;                                // of the solution
  Eigen::VectorXd departure_;                               // of the right side
  double common_ = 0.0, square_ = 0.0;                      // sums of products: of both departures, of this one
  int count_ = 0;                                           // of the steps before, at most 2
};

}  // namespace springnet::learning
