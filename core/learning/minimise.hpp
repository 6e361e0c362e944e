// Searches for the least sum of squares within bounds.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace springnet::learning {

// Cost 1/2 |r(x)|^2. Where residuals are not finite, x is not admissible, and a search steps back.
class LeastSquares {
 public:
  virtual ~LeastSquares() = default;
  [[nodiscard]] virtual Eigen::VectorXd residuals(const Eigen::VectorXd& x) = 0;
  // Derivatives J of the residuals at x, for the functions below.
  virtual void linearise(const Eigen::VectorXd& x) = 0;
  [[nodiscard]] virtual Eigen::VectorXd times(const Eigen::VectorXd& change) = 0;
  [[nodiscard]] virtual Eigen::VectorXd transposed_times(const Eigen::VectorXd& weights) = 0;
  // J, with a column for each variable.
  [[nodiscard]] virtual Eigen::MatrixXd jacobian(Eigen::Index variables) = 0;
};

struct Bounds {
  Eigen::VectorXd lower, upper;  // infinite: none; equal: the variable stays
};

struct Progress {
  int iteration = 0;  // 0: the start
  double cost = 0.0;
  // Greatest cosine between the residuals and what a variable that may move changes of them; 0 at a minimum. Where the
  // Jacobian is not known, all variables count as sensitive, in their units, as they were down the first gradient.
  double gradient = 0.0;
  double aside = 0.0;  // see MinimiseOptions
};

struct MinimiseOptions {
  int max_iterations = 100;
  double gradient_tolerance = 1e-10;  // of Progress::gradient
  double cost_tolerance = 1e-10;      // decrease in an iteration, relative
  double step_tolerance = 1e-10;      // relative to the variables
  // Jacobians of up to so many variables are known as a whole; else steps are found with products alone.
  Eigen::Index most_dense = 2000;
  double most_numbers = 2.5e7;  // of such a Jacobian; five times as many are kept at a time
  // Changes of the variables that count as the same, for methods that know no Jacobian; none: 1.
  Eigen::VectorXd unit{};
  // The part of the cost at x that is told by itself; none: 0.
  std::function<double(const Eigen::VectorXd& x)> aside{};
  // After the start and each iteration, with the best so far; false ends the search.
  std::function<bool(const Progress&, const Eigen::VectorXd& best)> on_iteration{};
  // Before these, bytes with which a search of the same method, problem and options goes on there, with the same bits;
  // iterations before are not told again. For the same machine and version.
  std::function<void(const std::string& state)> on_state{};
  std::string state{};  // to go on from; empty: the start
};

struct Minimum {
  enum class Stop : std::uint8_t { gradient, cost, step, iterations, asked, stuck };
  Eigen::VectorXd x;
  double cost = 0.0;
  Stop stop = Stop::iterations;
  std::string reason;             // a sentence
  std::vector<Progress> history;  // from the start on
};

// All throw Error(input) for bounds that do not fit the start, if the residuals there are not finite, and for a state
// that is damaged; and what `problem` throws.

// Levenberg's and Marquardt's method, the damping by Nielsen (1999); steps that leave the bounds end at them, and
// variables that are pressed against them stay.
[[nodiscard]] Minimum levenberg_marquardt(LeastSquares& problem, const Eigen::VectorXd& start, const Bounds& bounds,
                                          const MinimiseOptions& options = {});
// L-BFGS-B (Byrd, Lu, Nocedal, Zhu, SIAM J. Sci. Comput. 16, 1995), with the projected subspace step of Morales and
// Nocedal (ACM TOMS 38, 2011). Needs gradients alone, but for one product with the Jacobian at the start, which gives
// the first step its length.
[[nodiscard]] Minimum lbfgs(LeastSquares& problem, const Eigen::VectorXd& start, const Bounds& bounds,
                            const MinimiseOptions& options = {});
// Gradient descent with momentum (the paper's section 3.5). No step raises the cost: where one would, the momentum is
// dropped and the rate is halved, so that the search cannot blow up whatever the rate; it grows with each step that is
// made. The first rate is the best one for a linear problem.
[[nodiscard]] Minimum gradient_descent(LeastSquares& problem, const Eigen::VectorXd& start, const Bounds& bounds,
                                       const MinimiseOptions& options = {});

}  // namespace springnet::learning
