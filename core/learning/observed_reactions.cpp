#include "learning/observed_reactions.hpp"

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "learning/between_states.hpp"

namespace springnet::learning {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

ObservedReactions::ObservedReactions(ReactionDerivatives& reactions, const Observations& observations,
                                     const std::vector<double>& state_times)
    : reactions_(reactions), of_state_(state_times.size()) {
  for (const Observations::VectorRow& each : observations.reactions) {
    if (each.weight.isZero(0.0)) continue;
    if (!reactions.has_reaction(each.node)) {
      const std::string place = observations.text_of(each.place);
      throw Error(ErrorKind::input,
                  fmt::format("{}: node {} is neither fixed nor moved, and only of such nodes reactions are learned "
                              "from; remove the row",
                              place.empty() ? "reactions" : place, each.node));
    }
    const Between at = between_states(state_times, each.time, false);
    for (std::size_t end = 0; end < 2; ++end)
      if (const double share = end == 0 ? 1.0 - at.share : at.share; share != 0.0)
        of_state_[at.state + end].push_back({rows_.size(), share});
    rows_.push_back({each.node, each.value, each.weight.cwiseSqrt()});
  }
}

void ObservedReactions::residuals(const MotionDerivatives& motion, const VectorXd& values, Eigen::Ref<VectorXd> out) {
  reactions_.set_values(values);
  for (std::size_t k = 0; k < rows_.size(); ++k)
    out.segment<3>(3 * static_cast<Eigen::Index>(k)) = -rows_[k].root_weight.cwiseProduct(rows_[k].observed);
  for (std::size_t state = 0; state < of_state_.size(); ++state) {
    if (of_state_[state].empty()) continue;
    const Matrix3Xd reactions = reactions_.at(motion, state);
    for (const Share& each : of_state_[state]) {
      const Row& row = rows_[each.row];
      out.segment<3>(3 * static_cast<Eigen::Index>(each.row)) +=
          each.share * row.root_weight.cwiseProduct(reactions.col(row.node));
    }
  }
}

void ObservedReactions::add_tangent(const MotionDerivatives& motion, std::size_t state, const MatrixXd& changes,
                                    const MatrixXd& positions, const MatrixXd& velocities,
                                    Eigen::Ref<MatrixXd> out) const {
  if (state >= of_state_.size() || of_state_[state].empty()) return;
  const MatrixXd tangent = reactions_.tangent(motion, state, changes, positions, velocities);
  for (const Share& each : of_state_[state]) {
    const Row& row = rows_[each.row];
    out.middleRows<3>(3 * static_cast<Eigen::Index>(each.row)) +=
        each.share * (row.root_weight.asDiagonal() * tangent.middleRows<3>(3 * Eigen::Index{row.node}));
  }
}

void ObservedReactions::add_adjoint(const MotionDerivatives& motion, std::size_t state,
                                    const Eigen::Ref<const VectorXd>& weights, MotionDerivatives::StateChange& to,
                                    VectorXd& by_values) const {
  if (state >= of_state_.size() || of_state_[state].empty()) return;
  Matrix3Xd by_reaction = Matrix3Xd::Zero(3, to.positions.cols());
  for (const Share& each : of_state_[state]) {
    const Row& row = rows_[each.row];
    by_reaction.col(row.node) +=
        each.share * row.root_weight.cwiseProduct(weights.segment<3>(3 * static_cast<Eigen::Index>(each.row)));
  }
  reactions_.add_adjoint(motion, state, by_reaction, to, by_values);
}

}  // namespace springnet::learning
