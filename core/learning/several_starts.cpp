#include "learning/several_starts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): the same on every platform. From -1 to 1.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : state_(seed) {}
  double next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-52 - 1.0;
  }

 private:
  std::uint64_t state_;
};

double cost_at(Fit& fit, const VectorXd& x) { return 0.5 * fit.residuals(x).squaredNorm(); }

// The start, or how far from it towards the first one a motion succeeds; nothing: nowhere.
bool move_until_it_moves(Fit& fit, VectorXd& start, double& cost) {
  constexpr int most_halvings = 10;
  const VectorXd first = fit.variables().start();
  for (int k = 0; k <= most_halvings; ++k) {
    cost = cost_at(fit, start);
    if (std::isfinite(cost)) return true;
    start = 0.5 * (start + first);
  }
  return false;
}

int iterations_of(const std::vector<LearnProgress>& history) { return history.empty() ? 0 : history.back().iteration; }

}  // namespace

void check_starts(const LearnOptions& options) {
  constexpr int most_starts = 1000000;
  if (options.starts < 1 || options.starts > most_starts)
    throw Error(ErrorKind::input,
                fmt::format("learning: there are {} starts, must be 1 to {}", options.starts, most_starts));
  if (!(options.start_factor > 1.0) || !std::isfinite(options.start_factor))
    throw Error(ErrorKind::input,
                fmt::format("learning: the factor of starts is {}, must be above 1", options.start_factor));
}

VectorXd random_start(const Variables& variables, const LearnOptions& options, int number) {
  // Of each start numbers of its own, whatever the number of variables.
  Numbers seeds(options.seed + static_cast<std::uint64_t>(number) * 0xd1342543de82ef95u);
  seeds.next();
  const double size = std::log(options.start_factor);
  VectorXd x = variables.start();
  for (Index k = 0; k < x.size(); ++k) {
    const double logarithm = size * seeds.next();
    x[k] = variables.is_logarithmic(k) ? x[k] + logarithm : x[k] * std::exp(logarithm);
  }
  return x.cwiseMax(variables.lower()).cwiseMin(variables.upper());
}

Minimum best_of_starts(Fit& fit, Search& search, Minimum first,
                       const std::function<Minimum(const VectorXd& start)>& search_from, LearnedNet& result) {
  const Variables& variables = fit.variables();
  Minimum best = std::move(first);
  std::vector<LearnProgress> history = result.history;
  const auto add = [&](double start_cost, const Minimum& found) {
    LearnedStart own;
    own.start_cost = start_cost;
    own.cost = found.cost;
    own.iterations = iterations_of(result.history);
    own.values = variables.values(found.x);
    own.reason = found.reason;
    result.starts.push_back(std::move(own));
  };
  add(result.start_cost, best);
  for (int k = 1; k < search.options.starts && !search.stopped; ++k) {
    search.start = k;
    search.history.clear();
    VectorXd start = random_start(variables, search.options, k);
    double cost = 0.0;
    if (!move_until_it_moves(fit, start, cost)) {
      const double none = std::numeric_limits<double>::quiet_NaN();
      result.starts.push_back({none, none, 0, false, {}, "Motions from there fail: " + fit.why_failed()});
      continue;
    }
    Minimum found = search_from(start);
    add(cost, found);
    if (!(found.cost < best.cost)) continue;
    best = std::move(found);
    history = result.history;
    result.failure = search.failure;
  }
  result.history = std::move(history);
  constexpr double as_good = 1e-2, as_nothing = 1e-8;
  for (LearnedStart& each : result.starts)
    each.is_as_good = each.cost <= (1.0 + as_good) * best.cost + as_nothing * result.start_cost;
  return best;
}

void describe_starts(LearnedNet& result) {
  if (result.starts.empty()) return;
  std::size_t as_good = 0;
  double worst = 0.0;
  for (const LearnedStart& each : result.starts) {
    worst = std::max(worst, each.cost);
    if (!each.is_as_good) continue;
    ++as_good;
    for (std::size_t k = 0; k < result.parameters.size(); ++k) {
      LearnedParameter& parameter = result.parameters[k];
      const double value = each.values[static_cast<Index>(k)];
      parameter.starts_lower = std::fmin(parameter.starts_lower, value);
      parameter.starts_upper = std::fmax(parameter.starts_upper, value);
    }
  }
  std::string note = fmt::format("{} of {} starts end with the cost of the best one.", as_good, result.starts.size());
  if (as_good < result.starts.size())
    note += fmt::format(
        " The others end elsewhere, with costs up to {:.3g}: the cost has several minima, or some "
        "searches were not at their end.",
        worst);
  double spread = 0.0;
  for (const LearnedParameter& each : result.parameters) {
    const double size = std::max(std::abs(each.starts_lower), std::abs(each.starts_upper));
    if (size > 0.0) spread = std::max(spread, (each.starts_upper - each.starts_lower) / size);
  }
  note += fmt::format(" Values of those that are as good differ by up to {:.2g} of themselves.", spread);
  result.notes.push_back(std::move(note));
}

}  // namespace springnet::learning
