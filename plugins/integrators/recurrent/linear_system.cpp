#include "linear_system.hpp"

#include <algorithm>
#include <cmath>

namespace springnet::recurrent {
namespace {

constexpr double same_weight = 1e-9;

}  // namespace

void LinearSystem::attach(const springnet_network& network) {
  constrained_ = network.surface_count > 0 || network.rigid_count > 0 || network.body_contact_count > 0;
  has_true_friction_ = network.rigid_count == 0;  // as in the host's systems
  prepared_ = false;
}

void LinearSystem::prepare(const springnet_evaluation& at, double weight, double shift, bool exact) {
  prepared_ = false;
  host_.prepare_system({weight, weight * weight, shift}, at, exact);
  prepared_ = true;
  weight_ = weight;
  shift_ = shift;
}

bool LinearSystem::has(double weight, double shift) const noexcept {
  // Steps of equal length differ by the rounding of their ends.
  return prepared_ && std::abs(weight_ - weight) <= same_weight * weight && shift_ == shift;
}

void LinearSystem::project(std::vector<double>& values) const {
  if (constrained_) host_.project(nullptr, values.data(), has_true_friction_ ? SPRINGNET_TRUE_FRICTION : 0);
}

bool LinearSystem::solve(const std::vector<double>& b, double accuracy, std::vector<double>& x) {
  truncated_ = false;
  try {
    const sdk::Host::Solved solved = host_.solve_system(b.data(), accuracy, x.data());
    host_.count("krylov_iterations", static_cast<double>(solved.iterations));
    iterations_ = solved.iterations;
    truncated_ = solved.outcome == SPRINGNET_TRUNCATED;
    if (truncated_) return solved.iterations > 0;
    // At a deadline what was found so far has to do.
    const bool late = solved.iterations > 0 && host_.time_left() <= 0.0;
    const bool useful = solved.outcome == SPRINGNET_SOLVED || solved.residual <= max_useful_residual || late;
    return useful && std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
  } catch (const sdk::Failure& failure) {
    if (!failure.recoverable()) throw;
    return false;
  }
}

}  // namespace springnet::recurrent
