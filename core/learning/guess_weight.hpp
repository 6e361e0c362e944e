// The weight of the guess by a rule, from searches with several weights.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <springnet/learn.hpp>

namespace springnet::learning {

// What a search with a weight has found.
struct GuessTrial {
  GuessPoint point;
  Eigen::VectorXd x;
  bool stopped = false;  // the program asked to
};
// from: where to start; null: where the weight's search starts at best.
using GuessSearch = std::function<GuessTrial(double weight, const Eigen::VectorXd* from)>;

struct GuessChoice {
  GuessTrial found;
  std::vector<GuessPoint> curve;  // of all weights tried, the greatest first
  std::string note;               // empty: the rule held
};

// greatest: a weight that holds all but what the observations determine best. Searches go from greater to smaller
// weights, each from what the one before found: the least determined values are set free last.

// The greatest weight (to 10 %) with which the rms of the residuals, in units of their standard deviations, is at most
// 1: what is nearer to the observations than their noise follows the noise (Morozov, Soviet Math. Dokl. 7, 1966).
// rms_of_guess: of the motion with the guess.
[[nodiscard]] GuessChoice weight_by_discrepancy(double greatest, double rms_of_guess, std::size_t observed,
                                                const GuessSearch& search);

// Where the curve of log(distance from the guess) over log(rms) bends most: with smaller weights values move away
// without getting nearer to the observations (Hansen and O'Leary, SIAM J. Sci. Comput. 14, 1993).
[[nodiscard]] GuessChoice weight_by_l_curve(double greatest, const GuessSearch& search);

}  // namespace springnet::learning
