#include "learning/guess_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "learning/guess_weight.hpp"
#include "learning/observed_values.hpp"
#include "learning/result.hpp"

namespace springnet::learning {

using Eigen::VectorXd;

bool have_plain_weights(const std::vector<Experiment>& experiments) {
  const auto are_1 = [](const auto& rows) {
    return std::all_of(rows.begin(), rows.end(), [](const auto& row) {
      if constexpr (requires { row.weight.size(); })
        return ((row.weight.array() == 1.0) || (row.weight.array() == 0.0)).all();
      else
        return row.weight == 1.0 || row.weight == 0.0;
    });
  };
  bool result = true;
  for (const Experiment& each : experiments)
    for_each_list(each.observations, [&](const auto& rows, const char*) { result = result && are_1(rows); });
  return result;
}

void search_by_rule(Search& search, Fit& fit, double greatest, LearnedNet& result, Minimum& minimum) {
  const VectorXd start = minimum.x;
  const Variables& variables = fit.variables();
  const auto rms_at = [&](const VectorXd& x) { return rms_of(fit.observed_residuals(x), fit.observed()); };
  const auto trial = [&](double weight, const VectorXd* from) {
    fit.set_guess_weight(weight);
    const auto cost = [&](const VectorXd& x) { return fit.residuals(x).squaredNorm(); };
    const VectorXd& first = from != nullptr && cost(*from) < cost(start) ? *from : start;
    GuessTrial found;
    found.x = search.run(fit, cost(variables.start()) < cost(first) ? variables.start() : first, 1.0, false).x;
    found.point = {weight, rms_at(found.x),
                   (found.x - variables.start()).cwiseQuotient(variables.scale()).norm() /
                       std::sqrt(static_cast<double>(variables.count()))};
    found.stopped = search.is_over();
    return found;
  };
  GuessChoice choice = search.options.guess_rule == GuessRule::discrepancy
                           ? weight_by_discrepancy(greatest, rms_at(variables.start()), fit.observed(), trial)
                           : weight_by_l_curve(greatest, trial);
  fit.set_guess_weight(choice.found.point.weight);
  result.guess_curve = std::move(choice.curve);
  if (!choice.note.empty()) result.notes.push_back(std::move(choice.note));
  minimum.x = choice.found.x;
  if (!search.is_over()) {
    minimum = search.run(fit, choice.found.x, 1.0, true);
    return;
  }
  minimum.cost = 0.5 * fit.residuals(minimum.x).squaredNorm();
  if (!search.failure.empty()) minimum.reason = ended_by(search.failure);
}

}  // namespace springnet::learning
