#include "learning/solution_guess.hpp"

#include <algorithm>
#include <utility>

namespace springnet::learning {
namespace {

constexpr double kept_share = 0.8;  // of what steps before tell, in each one

void keep(const Eigen::VectorXd& values, std::array<Eigen::VectorXd, 2>& last) {
  std::swap(last[0], last[1]);
  last[0] = values;
}

}  // namespace

void SolutionGuess::find(const Eigen::VectorXd& right_side, Eigen::VectorXd& x) {
  if (count_ == 0) common_ = square_ = 0.0;
  if (count_ == 0) {
    straight_.setZero(right_side.size());
    departure_ = right_side;
  } else if (count_ == 1) {
    straight_ = solutions_[0];
    departure_ = right_side - right_sides_[0];
  } else {
    straight_ = 2.0 * solutions_[0] - solutions_[1];
    departure_ = right_side - 2.0 * right_sides_[0] + right_sides_[1];
  }
  const double share = square_ > 0.0 ? std::clamp(common_ / square_, 0.0, 1.0) : 1.0;
  x = straight_ + share * departure_;
  keep(right_side, right_sides_);
}

void SolutionGuess::take(const Eigen::VectorXd& x) {
  common_ = kept_share * common_ + departure_.dot(x - straight_);
  square_ = kept_share * square_ + departure_.squaredNorm();
  keep(x, solutions_);
  count_ = std::min(count_ + 1, 2);
}

}  // namespace springnet::learning
