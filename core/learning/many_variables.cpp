#include "learning/many_variables.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

#include <fmt/format.h>

#include "text/counted.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr Index most_kept = 40;
constexpr double without_curvature = 1e-13;  // of the greatest component of J^T w
constexpr std::uint64_t probes = 2;

VectorXd gradient_of(Fit& fit, const VectorXd& weights) {
  VectorXd all = VectorXd::Zero(fit.rows());
  all.head(fit.observation_rows()) = weights;
  return fit.transposed_times(all).cwiseProduct(fit.variables().scale());
}

}  // namespace

SingularValues singular_values(Fit& fit, const LanczosOptions& options) {
  const VectorXd& scale = fit.variables().scale();
  const Index rows = fit.observation_rows();
  return greatest_singular_values(
      [&](const VectorXd& change) { return VectorXd(fit.times(scale.cwiseProduct(change)).col(0).head(rows)); },
      [&](const VectorXd& weights) { return gradient_of(fit, weights); }, scale.size(), options);
}

void describe_many(LearnedNet& learned, Fit& fit, int products) {
  const SingularValues found =
      singular_values(fit, {std::max<Index>(1, products), std::max<Index>(most_kept, products), 1e-4});
  learned.singular_values.assign(found.values.begin(), found.values.end());
  const VectorXd square = found.reached.cwiseAbs2();
  // Every direction adds to what the data determine: those that are not known could only take from the guess's share.
  const VectorXd kept = square.cwiseQuotient((square.array() + fit.guess_weight()).matrix());
  // Rows at random have a component along every column that is not 0.
  VectorXd greatest = VectorXd::Zero(fit.variables().count());
  for (std::uint64_t probe = 1; probe <= probes; ++probe)
    greatest = greatest.cwiseMax(gradient_of(fit, arbitrary_vector(fit.observation_rows(), probe)).cwiseAbs());
  const double least = without_curvature * greatest.maxCoeff();
  const Variables& variables = fit.variables();
  for (std::size_t k = 0; k < learned.parameters.size(); ++k) {
    LearnedParameter& each = learned.parameters[k];
    const auto first = static_cast<Index>(each.variable), count = static_cast<Index>(each.variables);
    const VectorXd weights = variables.weights_of(k).cwiseProduct(variables.scale().segment(first, count));
    const VectorXd along = found.reached_right.middleRows(first, count).transpose() * weights;
    // Without a guess that has weight, it is what no product has reached: that says nothing of the data.
    each.from_guess = fit.guess_weight() > 0.0
                          ? std::max(0.0, 1.0 - along.cwiseAbs2().dot(kept) / weights.squaredNorm())
                          : std::numeric_limits<double>::quiet_NaN();
    each.has_influence = (weights.array() != 0.0 && greatest.segment(first, count).array() > least).any();
  }
  learned.notes.push_back(
      found.values.size() > 0
          ? fmt::format("Singular values are the {} greatest, by Lanczos' method.", found.values.size())
          : fmt::format("No singular value has settled after {}: allow more (--certainty-products).",
                        counted(static_cast<std::size_t>(std::max(1, products)), "product")));
  if (fit.guess_weight() > 0.0)
    learned.notes.push_back(
        fmt::format("Shares of the guess are told as the most that they can be: what {} with the sensitivities reached "
                    "alone counts as determined.",
                    counted(static_cast<std::size_t>(found.reached.size()), "product")));
}

}  // namespace springnet::learning
