#include "learning/certainty.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <boost/math/distributions/students_t.hpp>

#include "learning/svd.hpp"

namespace springnet::learning {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Sensitivities are good to some 1e-11 of the greatest ones: what is smaller than this share of them is rounding.
constexpr double without_influence = 1e-9;
// Of a variable without influence even that is 0; others are far above.
constexpr double no_influence = 1e-13;     // of the greatest column
constexpr double all_but_rounding = 1e-6;  // of the determined share
constexpr double confidence = 0.95;

}  // namespace

Certainty::Certainty(const MatrixXd& jacobian, const VectorXd& residuals, std::size_t observed, double guess_weight,
                     double unseen, bool is_held) {
  const Svd svd = thin_svd(jacobian);
  const VectorXd& values = svd.values;
  singular_values_.assign(values.data(), values.data() + values.size());
  const Eigen::Index variables = jacobian.cols();
  const VectorXd lengths = jacobian.colwise().norm();
  has_influence_ = lengths.array() > std::max(no_influence * lengths.maxCoeff(), unseen);
  Eigen::Index rank = 0;
  while (rank < values.size() && values[rank] > std::max(without_influence * values[0], unseen)) ++rank;
  undetermined_ = static_cast<std::size_t>(variables - rank);
  const MatrixXd u = svd.left.leftCols(rank);
  const VectorXd own = values.head(rank), inverse = own.cwiseInverse();
  directions_ = svd.right.leftCols(rank);
  kept_ = own.array().square() / (own.array().square() + guess_weight);
  inverse_ = directions_ * kept_.cwiseProduct(inverse).asDiagonal() * u.transpose();
  middle_ = VectorXd::Zero(variables);
  const double left = static_cast<double>(observed) - static_cast<double>(rank);  // degrees of freedom
  if (!(left >= 1.0)) return;
  double square = residuals.squaredNorm();
  if (guess_weight > 0.0 || is_held) {  // else the search has left nothing along these directions, or bounds hold it
    const VectorXd along = u.transpose() * residuals;
    square = std::max(0.0, square - along.squaredNorm());
    middle_ = -(directions_ * inverse.cwiseProduct(along));
  }
  const double deviation = std::sqrt(std::max(square, unseen * unseen) / left);
  const double quantile = boost::math::quantile(boost::math::students_t(left), 0.5 * (1.0 + confidence));
  widths_ = quantile * deviation * inverse;
}

double Certainty::determined(Eigen::Index first, const VectorXd& weights) const {
  const double all = weights.squaredNorm();
  return all > 0.0 ? (directions_.middleRows(first, weights.size()).transpose() * weights).squaredNorm() / all : 0.0;
}

bool Certainty::has_influence(Eigen::Index first, const VectorXd& weights) const {
  for (Eigen::Index k = 0; k < weights.size(); ++k)
    if (weights[k] != 0.0 && has_influence_[first + k]) return true;
  return false;
}

double Certainty::from_guess(Eigen::Index first, const VectorXd& weights) const {
  const double all = weights.squaredNorm();
  if (!(all > 0.0)) return 1.0;
  const VectorXd along = directions_.middleRows(first, weights.size()).transpose() * weights;
  return std::max(0.0, 1.0 - along.cwiseAbs2().dot(kept_) / all);
}

double Certainty::middle(Eigen::Index first, const VectorXd& weights) const {
  return middle_.segment(first, weights.size()).dot(weights);
}

double Certainty::half_width(Eigen::Index first, const VectorXd& weights) const {
  if (widths_.size() != directions_.cols() || determined(first, weights) < 1.0 - all_but_rounding)
    return std::numeric_limits<double>::infinity();
  const VectorXd along = directions_.middleRows(first, weights.size()).transpose() * weights;
  return along.cwiseProduct(widths_).norm();
}

VectorXd Certainty::with_influence(const VectorXd& change) const {
  const VectorXd along = directions_ * (directions_.transpose() * change);
  return has_influence_.select(along.array(), 0.0).matrix();
}

VectorXd Certainty::change_for(const VectorXd& residuals) const { return -(inverse_ * residuals); }

}  // namespace springnet::learning
