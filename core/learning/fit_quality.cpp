#include "learning/fit_quality.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "learning/guess_search.hpp"

namespace springnet::learning {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Of an rms in units of standard deviations: 1 is noise.
constexpr double clearly_above = 1.5, far_below = 0.1;
// Of the share of the motion that is left.
constexpr double large_share = 0.3, visible_share = 0.02, negligible_share = 1e-3, rounding_share = 1e-4;
// Of the differences with the values at the start.
constexpr double hardly_fell = 0.5, as_at_start = 0.7;
// Of the correlation in time. That of n independent pairs deviates by 1/sqrt(n).
constexpr double strong_correlation = 0.5, by_chance = 4.0, no_correlation = 0.2;
constexpr std::size_t least_pairs = 10, many_pairs = 30;

// The residuals of nodes in the order of ObservedMotion, as courses of values over time; and how large they could be.
class Courses {
 public:
  void add(const Experiment& experiment, const VectorXd& residuals, Index& next) {
    const Observations& seen = experiment.observations;
    const Network& net = *experiment.network;
    courses_.clear();
    for (const Observations::VectorRow& row : seen.positions)
      add_vector(row, net.nodes()[row.node].position, 0, residuals, next);
    for (const Observations::VectorRow& row : seen.velocities) add_vector(row, Vector3::Zero(), 1, residuals, next);
    for (const Observations::DistanceRow& row : seen.distances) {
      if (row.weight == 0.0) continue;
      const double start = (net.nodes()[row.node].position - net.nodes()[row.other].position).norm();
      const auto [first, second] = std::minmax(row.node, row.other);
      add_value({2, first, second}, row.time, residuals[next++], row.weight, row.distance - start);
    }
    for (const Observations::SurfacePoint& row : seen.surface_points)
      if (row.weight > 0.0) next += 3;  // which belongs to which in another scan is not known
    for (const Observations::VectorRow& row : seen.reactions) add_vector(row, Vector3::Zero(), 3, residuals, next);
    for (auto& [key, course] : courses_) add_pairs(course);
  }

  // nan: nothing of nodes was observed, or they did not move.
  [[nodiscard]] double share() const { return std::sqrt(left_ / extent_); }
  [[nodiscard]] std::size_t pairs() const { return pairs_; }
  [[nodiscard]] double correlation() const { return products_ / std::sqrt(earlier_ * later_); }

 private:
  using Key = std::tuple<int, NodeIndex, NodeIndex>;  // quantity; node, axis or other node
  using Course = std::vector<std::pair<double, double>>;

  void add_vector(const Observations::VectorRow& row, const Vector3& start, int quantity, const VectorXd& residuals,
                  Index& next) {
    if (row.weight.isZero(0.0)) return;
    for (Index axis = 0; axis < 3; ++axis, ++next)
      if (row.weight[axis] > 0.0)
        add_value({quantity, row.node, static_cast<NodeIndex>(axis)}, row.time, residuals[next], row.weight[axis],
                  row.value[axis] - start[axis]);
  }
  void add_value(const Key& key, double time, double residual, double weight, double moved) {
    courses_[key].emplace_back(time, residual);
    left_ += residual * residual;
    extent_ += weight * moved * moved;
  }
  void add_pairs(Course& course) {
    std::sort(course.begin(), course.end());
    for (std::size_t k = 0; k + 1 < course.size(); ++k) {
      const double one = course[k].second, other = course[k + 1].second;
      products_ += one * other;
      earlier_ += one * one;
      later_ += other * other;
      ++pairs_;
    }
  }

  std::map<Key, Course> courses_;     // of the experiment
  double left_ = 0.0, extent_ = 0.0;  // sums of weighted squares
  double products_ = 0.0, earlier_ = 0.0, later_ = 0.0;
  std::size_t pairs_ = 0;
};

// "3.4 %", "560 %"
std::string percent(double share) {
  return share < 0.1 ? fmt::format("{:.2g} %", 100.0 * share) : fmt::format("{:.0f} %", 100.0 * share);
}

// What is wrong of a fit.
struct Complaint {
  std::string warning;  // a beginning
  std::string note;
};

Complaint complaint(const LearnedNet& result, double left_of_start, std::size_t pairs, bool has_deviations) {
  const double share = result.fit.share_of_motion, correlation = result.fit.correlation_in_time;
  const double root = std::sqrt(static_cast<double>(pairs));
  const bool is_correlated = correlation > strong_correlation && correlation * root > by_chance;
  const bool is_white = pairs >= many_pairs && std::abs(correlation) < no_correlation;
  const std::string in_time =
      is_correlated
          ? fmt::format(", and correlated in time ({:.2f} from one observation of a value to the next)", correlation)
          : "";
  const double chance = 1.0 + 3.0 / std::sqrt(2.0 * static_cast<double>(std::max<std::size_t>(1, result.observed)));
  if (has_deviations && result.rms > std::max(clearly_above, chance)) {
    if (is_white && left_of_start < as_at_start)
      return {{},
              fmt::format("The rms of the weighted differences is {:.3g}, where the standard deviations say 1, but the "
                          "differences are not correlated in time: they look like noise that is larger than the tables "
                          "say, by this factor.",
                          result.rms)};
    return {fmt::format("The rms of the weighted differences is {:.3g}, where the standard deviations say 1{}",
                        result.rms, in_time),
            {}};
  }
  const std::string too_narrow =
      is_correlated && share > rounding_share
          ? fmt::format(
                "The differences that are left are correlated in time ({:.2f} from one observation of a value "
                "to the next): they are no noise, and the intervals, which take them for it, are too narrow.",
                correlation)
          : "";
  if (has_deviations && result.rms > far_below) return {{}, too_narrow};
  const std::string as_left =
      has_deviations && too_narrow.empty()
          ? fmt::format(
                "The rms of the weighted differences is {:.3g}, where the standard deviations say 1: intervals "
                "are those of the differences that are left.",
                result.rms)
          : too_narrow;
  const bool is_large = share > large_share && (!is_white || left_of_start > as_at_start);
  const bool is_of_model =
      is_correlated && (share > visible_share || (left_of_start > hardly_fell && share > negligible_share));
  // Of a pose or two there is no correlation in time.
  const bool did_not_fall = pairs < least_pairs && share > visible_share && left_of_start > as_at_start;
  if (!is_large && !is_of_model && !did_not_fall) return {{}, as_left};
  return {fmt::format("The differences that are left are {} of the motion that was observed{}{}", percent(share),
                      did_not_fall ? ", hardly less than at the start" : "", in_time),
          {}};
}

}  // namespace

void judge_fit(const std::vector<Experiment>& experiments, const VectorXd& residuals, const std::string& advice,
               LearnedNet& result) {
  Courses courses;
  Index next = 0;
  for (const Experiment& each : experiments) courses.add(each, residuals, next);
  const double left_of_start = residuals.norm() / std::sqrt(2.0 * result.start_cost);
  const double share = courses.share();
  result.fit.share_of_motion = std::isfinite(share) ? share : left_of_start;
  if (courses.pairs() >= least_pairs) result.fit.correlation_in_time = courses.correlation();
  const bool is_start_alone = std::all_of(experiments.begin(), experiments.end(), [](const Experiment& each) {
    return !(each.observations.times().back() > 0.0);
  });
  if (is_start_alone) {
    result.notes.emplace_back(
        "Only the start was observed (time 0), which hardly any value changes: observe the motion "
        "that follows.");
    return;
  }
  auto [what, note] = complaint(result, left_of_start, courses.pairs(), !have_plain_weights(experiments));
  if (!note.empty()) result.notes.push_back(std::move(note));
  if (what.empty()) return;
  result.fit.warning = fmt::format(
      "{}: that is no noise. The search has ended in a wrong minimum, or the model is not that of what was seen{}. "
      "Compare both motions on the page; {}{}.",
      what, result.method == "online" ? "" : "; the intervals do not hold then", advice,
      result.guess_weight > 0.0 ? ", or a smaller weight of the guess" : "");
}

}  // namespace springnet::learning
