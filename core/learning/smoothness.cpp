#include "learning/smoothness.hpp"

namespace springnet::learning {

template <class Use>
void Smoothness::for_each_row_of(std::size_t state, const Use& use) const {
  for (std::size_t k = state > 0 ? state - 1 : 0; k <= state + 1; ++k)
    if (k >= 1 && k < steps_) use(3 * nodes_ * static_cast<Eigen::Index>(k - 1), (k == state ? -2.0 : 1.0) * factor_);
}

void Smoothness::residuals(const MotionDerivatives& motion, Eigen::Ref<Eigen::VectorXd> out) const {
  out.setZero();
  for (std::size_t state = 0; count() > 0 && state <= steps_; ++state) {
    const Eigen::Matrix3Xd v = motion.velocities(state);
    for_each_row_of(state,
                    [&](Eigen::Index row, double factor) { out.segment(row, v.size()) += factor * v.reshaped(); });
  }
}

void Smoothness::add_tangent(std::size_t state, const Eigen::MatrixXd& velocities,
                             Eigen::Ref<Eigen::MatrixXd> out) const {
  for_each_row_of(
      state, [&](Eigen::Index row, double factor) { out.middleRows(row, velocities.rows()) += factor * velocities; });
}

void Smoothness::add_adjoint(std::size_t state, const Eigen::Ref<const Eigen::VectorXd>& weights,
                             MotionDerivatives::StateChange& to) const {
  for_each_row_of(state, [&](Eigen::Index row, double factor) {
    to.velocities.reshaped() += factor * weights.segment(row, to.velocities.size());
  });
}

}  // namespace springnet::learning
