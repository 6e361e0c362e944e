#include "learning/result.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace springnet::learning {

using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

double rms_of(const VectorXd& residuals, std::size_t observed) {
  return observed > 0 ? std::sqrt(residuals.squaredNorm() / static_cast<double>(observed)) : 0.0;
}

Observations part_of(const Observations& all, double from, double until) {
  Observations part;
  part.files = all.files;
  part.outlier_distance = all.outlier_distance;
  const auto copy = [&](const auto& rows, auto& to) {
    std::copy_if(rows.begin(), rows.end(), std::back_inserter(to),
                 [&](const auto& row) { return row.time >= from && row.time <= until; });
  };
  copy(all.positions, part.positions);
  copy(all.velocities, part.velocities);
  copy(all.reactions, part.reactions);
  copy(all.distances, part.distances);
  copy(all.surface_points, part.surface_points);
  return part;
}

std::vector<LearnedParameter> list_parameters(const std::vector<Learnable>& learnables) {
  std::vector<LearnedParameter> result;
  for (const Learnable& each : learnables)
    for (const std::uint32_t member : each.values.members)
      for (int axis = 0; axis < (each.values.kind == Kind::initial_velocity ? 3 : 1); ++axis) {
        LearnedParameter parameter;
        parameter.kind = each.values.kind;
        parameter.of_elements = each.values.of_elements;
        parameter.parameter = each.values.parameter;
        parameter.member = member;
        parameter.axis = each.values.kind == Kind::initial_velocity ? axis : -1;
        parameter.body = each.body;
        parameter.together = each.together;
        result.push_back(std::move(parameter));
      }
  return result;
}

void describe(LearnedNet& learned, const Variables& variables, const VectorXd& x, const Certainty* certainty,
              const VectorXd& shift) {
  for (std::size_t k = 0; k < learned.parameters.size(); ++k) {
    LearnedParameter& each = learned.parameters[k];
    each.variable = variables.variable_of(k);
    const VectorXd weights = variables.weights_of(k);
    each.variables = static_cast<std::size_t>(weights.size());
    each.start = variables.value_at(k, variables.start(), 0.0);
    each.value = variables.value_at(k, x, 0.0);
    const auto first = static_cast<Eigen::Index>(each.variable);
    for (Eigen::Index j = first; j < first + weights.size(); ++j)
      if (weights[j - first] > 0.0 && (x[j] <= variables.lower()[j] || x[j] >= variables.upper()[j]))
        each.at_bound = true;
    const VectorXd scaled = weights.cwiseProduct(variables.scale().segment(first, weights.size()));
    const double infinite = std::numeric_limits<double>::infinity();
    const double width = certainty == nullptr ? infinite : certainty->half_width(first, scaled);
    const bool is_known = std::isfinite(width);  // else the bounds of the law would pass for an interval
    const double middle = certainty == nullptr ? 0.0 : certainty->middle(first, scaled);
    const double ends[] = {is_known ? variables.value_at(k, x, middle - width) : -infinite,
                           is_known ? variables.value_at(k, x, middle + width) : infinite};
    each.lower = std::min(ends[0], ends[1]);
    each.upper = std::max(ends[0], ends[1]);
    const double rounding = 1e-9 * (each.upper - each.lower);
    each.is_outside = each.value < each.lower - rounding || each.value > each.upper + rounding;
    each.determined =
        certainty == nullptr ? std::numeric_limits<double>::quiet_NaN() : certainty->determined(first, scaled);
    each.has_influence = certainty == nullptr || certainty->has_influence(first, scaled);
    each.from_guess =
        certainty == nullptr ? std::numeric_limits<double>::quiet_NaN() : certainty->from_guess(first, scaled);
    each.by_time_step = shift.size() == 0 ? std::numeric_limits<double>::quiet_NaN()
                                          : variables.slope(k, x) * weights.dot(shift.segment(first, weights.size()));
  }
}

}  // namespace springnet::learning
