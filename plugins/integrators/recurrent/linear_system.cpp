#include "linear_system.hpp"

#include <algorithm>
#include <cmath>

namespace springnet::recurrent {

void LinearSystem::attach(const springnet_network& network) {
  constrained_ = network.surface_count > 0 || network.rigid_count > 0;
  prepared_ = linearised_ = false;
}

void LinearSystem::linearise(const springnet_evaluation& at) {
  host_.linearise(at);
  linearised_ = true;
  prepared_ = false;
}

bool LinearSystem::has(double weight, double shift) const noexcept {
  return linearised_ || (prepared_ && weight_ == weight && shift_ == shift);
}

void LinearSystem::project(std::vector<double>& values) const {
  if (constrained_) host_.project(nullptr, values.data());
}

bool LinearSystem::solve(double weight, double shift, const std::vector<double>& b, double accuracy,
                         std::vector<double>& x) {
  truncated_ = false;
  try {
    if (!prepared_ || weight_ != weight || shift_ != shift) {
      host_.prepare_system(weight, weight * weight, shift);
      prepared_ = true;
      weight_ = weight;
      shift_ = shift;
    }
    const sdk::Host::Solved solved = host_.solve_system(b.data(), accuracy, x.data());
    host_.report("krylov_iterations", krylov_iterations_ += static_cast<double>(solved.iterations));
    truncated_ = solved.outcome == SPRINGNET_TRUNCATED;
    if (truncated_) return solved.iterations > 0;
    const bool useful = solved.outcome == SPRINGNET_SOLVED || solved.residual <= max_useful_residual;
    return useful && std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
  } catch (const sdk::Failure& failure) {
    if (!failure.recoverable()) throw;
    return false;
  }
}

}  // namespace springnet::recurrent
