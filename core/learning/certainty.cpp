#include "learning/certainty.hpp"

#include <cmath>
#include <limits>

#include <Eigen/SVD>
#include <boost/math/distributions/students_t.hpp>

namespace springnet::learning {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Sensitivities are good to some 1e-11 of the greatest ones: what is smaller than this share of them is rounding.
constexpr double without_influence = 1e-9;
constexpr double all_but_rounding = 1e-6;  // of the determined share
constexpr double confidence = 0.95;

}  // namespace

Certainty::Certainty(const MatrixXd& jacobian, const VectorXd& residuals, std::size_t observed) {
  const Eigen::BDCSVD<MatrixXd> svd(jacobian, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const VectorXd& values = svd.singularValues();
  singular_values_.assign(values.data(), values.data() + values.size());
  const Eigen::Index variables = jacobian.cols();
  Eigen::Index rank = 0;
  while (rank < values.size() && values[rank] > without_influence * values[0] && values[rank] > 0.0) ++rank;
  undetermined_ = static_cast<std::size_t>(variables - rank);
  directions_ = svd.matrixV().leftCols(rank);
  const VectorXd inverse = values.head(rank).cwiseInverse();
  inverse_ = directions_ * inverse.asDiagonal() * svd.matrixU().leftCols(rank).transpose();
  const double left = static_cast<double>(observed) - static_cast<double>(rank);  // degrees of freedom
  if (!(left >= 1.0)) return;
  const double deviation = std::sqrt(residuals.squaredNorm() / left);
  const double quantile = boost::math::quantile(boost::math::students_t(left), 0.5 * (1.0 + confidence));
  widths_ = quantile * deviation * inverse;
}

double Certainty::determined(Eigen::Index first, const VectorXd& weights) const {
  const double all = weights.squaredNorm();
  return all > 0.0 ? (directions_.middleRows(first, weights.size()).transpose() * weights).squaredNorm() / all : 0.0;
}

double Certainty::half_width(Eigen::Index first, const VectorXd& weights) const {
  if (widths_.size() != directions_.cols() || determined(first, weights) < 1.0 - all_but_rounding)
    return std::numeric_limits<double>::infinity();
  const VectorXd along = directions_.middleRows(first, weights.size()).transpose() * weights;
  return along.cwiseProduct(widths_).norm();
}

VectorXd Certainty::change_for(const VectorXd& residuals) const { return -(inverse_ * residuals); }

}  // namespace springnet::learning
