// What all searches of minimise.hpp share: where they may begin, their course with its criteria, and the states from
// which they go on.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "learning/minimise.hpp"
#include "text/archive.hpp"

namespace springnet::learning {

inline constexpr double rounding_of_cost = 1e-15;  // relative

// At the start of an iteration; methods add what they keep beside it.
struct SearchState {
  int iteration = 0;
  int small_decreases = 0;  // of the cost, in the iterations before, in a row
  Eigen::VectorXd x;
  std::vector<Progress> history;  // of the iterations before
  void archive(Archive& archive);
};

void archive_history(Archive& archive, std::vector<Progress>& history);
// A list that keeps its size.
void archive_numbers(Archive& archive, Eigen::VectorXd& values, const char* what);

template <class State>
void take_up(State& state, const MinimiseOptions& options) {
  if (options.state.empty()) return;
  Archive archive{std::string_view(options.state)};
  state.archive(archive);
  if (archive.left() > 0) Archive::refuse("it goes on after its end");
}
template <class State>
void keep(State& state, const MinimiseOptions& options) {
  if (!options.on_state) return;
  std::string bytes;
  Archive archive(&bytes);
  state.archive(archive);
  options.on_state(bytes);
}

// Throw Error(input) for bounds that do not fit the start, and for residuals there that are not finite.
void check_start(const Eigen::VectorXd& start, const Bounds& bounds, const MinimiseOptions& options);
[[nodiscard]] double cost_at_start(const Eigen::VectorXd& residuals);

// Whether a bound keeps a variable from going down the gradient.
[[nodiscard]] bool is_held(const Eigen::VectorXd& x, const Eigen::VectorXd& gradient, const Bounds& bounds,
                           Eigen::Index variable);

class Course {
 public:
  // small_decreases: in a row, with which a search has come to its end.
  explicit Course(const MinimiseOptions& options, int small_decreases = 1)
      : options_(options), most_small_decreases_(small_decreases) {}

  // Tells where an iteration starts. The minimum, if the search ends there.
  [[nodiscard]] std::optional<Minimum> ends(SearchState& state, double cost, double gradient) const;
  // The next iteration starts at x.
  void go_on(SearchState& state, Eigen::VectorXd x, double cost_before, double cost) const;

  [[nodiscard]] Minimum end(const SearchState& state, double cost, Minimum::Stop stop, std::string reason) const;
  [[nodiscard]] Minimum end_by_step(const SearchState& state, double cost) const;
  [[nodiscard]] Minimum end_by_rounding(const SearchState& state, double cost) const;
  [[nodiscard]] Minimum end_stuck(const SearchState& state, double cost) const;

 private:
  const MinimiseOptions& options_;
  int most_small_decreases_;
};

// The variables in units of their own, u = x / unit, for methods that depend on units; bounds are met exactly.
class Scaled {
 public:
  Scaled(const Bounds& bounds, const MinimiseOptions& options);
  [[nodiscard]] const Eigen::VectorXd& unit() const noexcept { return unit_; }
  [[nodiscard]] const Eigen::VectorXd& lower() const noexcept { return lower_; }  // of u
  [[nodiscard]] const Eigen::VectorXd& upper() const noexcept { return upper_; }

  [[nodiscard]] Eigen::VectorXd u_of(const Eigen::VectorXd& x) const { return x.cwiseQuotient(unit_); }
  [[nodiscard]] Eigen::VectorXd x_of(const Eigen::VectorXd& u) const;
  [[nodiscard]] Eigen::VectorXd within(const Eigen::VectorXd& u) const { return u.cwiseMax(lower_).cwiseMin(upper_); }
  // Derivatives of the cost by u, at x with these residuals.
  [[nodiscard]] Eigen::VectorXd gradient(LeastSquares& problem, const Eigen::VectorXd& x,
                                         const Eigen::VectorXd& residuals) const;
  // |J u| / |u| down the gradient (by x) where the problem was linearised; 1 where that is 0.
  [[nodiscard]] double sensitivity(LeastSquares& problem, const Eigen::VectorXd& by_x) const;
  // Progress::gradient.
  [[nodiscard]] double greatest(const Eigen::VectorXd& x, const Eigen::VectorXd& by_u, double cost,
                                double sensitivity) const;

 private:
  const Bounds& bounds_;
  Eigen::VectorXd unit_, lower_, upper_;
};

}  // namespace springnet::learning
