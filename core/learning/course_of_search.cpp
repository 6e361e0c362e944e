// How the cost of the whole motion falls on the way of a search.
#include <cmath>
#include <cstddef>
#include <utility>

#include <springnet/learn.hpp>

#include "learning/fit.hpp"

namespace springnet {

namespace {

// The first value of each variable, or of each field.
std::vector<std::size_t> leading(const learning::Variables& variables, std::size_t values) {
  constexpr std::size_t most = 12;
  std::vector<std::size_t> result;
  std::size_t next = 0;  // variable
  for (std::size_t k = 0; k < values && result.size() < most; ++k) {
    if (variables.variable_of(k) != next) continue;
    next += static_cast<std::size_t>(variables.weights_of(k).size());
    result.push_back(k);
  }
  return result;
}

}  // namespace

LearnCourse course_of(const std::string& method, const std::vector<LearnProgress>& told, const Experiment& experiment,
                      const std::shared_ptr<const PluginHost>& plugins, const std::vector<Learnable>& learnables,
                      const LearnOptions& options) {
  learning::Fit fit({experiment}, plugins, learnables, 0.0, options.threads, options.memory);
  const Eigen::VectorXd start = fit.variables().values(fit.variables().start());
  LearnCourse result;
  result.method = method;
  result.parameters = leading(fit.variables(), static_cast<std::size_t>(start.size()));
  const auto add = [&](double work, const Eigen::VectorXd& values) {
    LearnCourse::Point point{work / fit.steps(), fit.cost_of(values), 0.0, {}};
    point.rms = std::sqrt(2.0 * point.cost / static_cast<double>(fit.observed()));
    point.values.resize(static_cast<Eigen::Index>(result.parameters.size()));
    for (std::size_t k = 0; k < result.parameters.size(); ++k)
      point.values[static_cast<Eigen::Index>(k)] = values[static_cast<Eigen::Index>(result.parameters[k])];
    result.points.push_back(std::move(point));
  };
  add(0.0, start);
  for (const LearnProgress& each : told)
    if (each.start == 0) add(each.work, each.values);
  return result;
}

}  // namespace springnet
