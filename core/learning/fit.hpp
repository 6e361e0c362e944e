// The least-squares problem of a search: residuals of all experiments by the variables.
#pragma once

#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <springnet/learn.hpp>

#include "learning/observed_motion.hpp"
#include "learning/smoothness.hpp"
#include "learning/variables.hpp"

namespace springnet::learning {

class Fit {
 public:
  // threads: in all; memory: bytes, of the states of all motions; see LearnOptions. Throws Error(input) for
  // observations and learnables that do not fit the networks, and for experiments on other objects.
  Fit(const std::vector<Experiment>& experiments, const std::shared_ptr<const PluginHost>& plugins,
      const std::vector<Learnable>& learnables, double guess_weight, unsigned threads = 0,
      std::size_t memory = std::size_t{1} << 30);

  [[nodiscard]] double guess_weight() const noexcept { return root_guess_weight_ * root_guess_weight_; }
  // The parts of the guess, and of motions that are not smooth, in 1/2 of the squares of the residuals; not a number
  // where a motion fails.
  [[nodiscard]] double guess_cost(const Eigen::VectorXd& x) const;
  [[nodiscard]] double smooth_cost(const Eigen::VectorXd& x);
  // Throws Error(input) unless it is 0 or more.
  void set_guess_weight(double weight);
  // m/s^2, see Smoothness; infinite: it does not matter. Throws Error(input) unless it is above 0. Before the first
  // residuals.
  void set_smoothness(double deviation);
  // Of derivatives, see MotionDerivatives::set_accuracy.
  void set_accuracy(double relative);
  [[nodiscard]] bool minds_smoothness() const noexcept { return smooth_rows_ > 0; }
  [[nodiscard]] const Variables& variables() const noexcept { return *variables_; }
  [[nodiscard]] std::size_t observed() const noexcept { return observed_; }
  // Of observations alone, before those of smoothness and of the guess.
  [[nodiscard]] Eigen::Index observation_rows() const noexcept { return rows_; }
  [[nodiscard]] Eigen::Index rows() const noexcept {
    return rows_ + smooth_rows_ + (root_weight() > 0.0 ? variables_->count() : 0);
  }
  // How far the residuals of the observations may be from those of steps that are settled exactly, with the values that
  // were asked for first: a change of the variables by their scale that moves them less is not seen.
  [[nodiscard]] double unseen() const noexcept { return unseen_; }

  // Not a number where a motion fails; why_failed() then tells why.
  [[nodiscard]] Eigen::VectorXd residuals(const Eigen::VectorXd& x);
  // Without those of smoothness, and those that hold variables at the guess.
  [[nodiscard]] Eigen::VectorXd observed_residuals(const Eigen::VectorXd& x) { return residuals(x).head(rows_); }
  [[nodiscard]] const std::string& why_failed() const noexcept { return failure_; }
  void forget_failure() noexcept { failure_.clear(); }
  // 1/2 their squares, of observations alone, with values of one's own; not a number where a motion fails.
  [[nodiscard]] double cost_of(const Eigen::VectorXd& values);
  // Steps of all motions; and a count to which those made from now on are added, see LearnProgress::work.
  [[nodiscard]] double steps() const;
  void count_in(double& work) { work_ = &work; }
  // A note for each motion of the last residuals in which something breaks, or contact changes.
  void note_events(std::vector<std::string>& notes) const;
  // Derivatives at x, which has finite residuals.
  void linearise(const Eigen::VectorXd& x);
  [[nodiscard]] Eigen::MatrixXd times(const Eigen::MatrixXd& changes) { return products(changes, true); }
  // Of the rows of observations alone.
  [[nodiscard]] Eigen::MatrixXd observed_times(const Eigen::MatrixXd& changes) { return products(changes, false); }
  [[nodiscard]] Eigen::VectorXd transposed_times(const Eigen::VectorXd& weights);

 private:
  struct Run {
    std::unique_ptr<MotionDerivatives> motion;
    std::unique_ptr<ObservedNet> net;
    ObservedMotion observed;
    Eigen::Index first;  // of its residuals
    Eigen::Index nodes;
    std::vector<Event> events_at_start;
    std::optional<Smoothness> smoothness{};
    Eigen::Index first_smooth = 0;  // of its residuals, behind those of all observations
  };
  // Of the rows that hold variables at the guess; what is not seen holds them, too, or rounding would move them.
  [[nodiscard]] double root_weight() const noexcept { return std::hypot(root_guess_weight_, unseen_); }
  void find_unseen();
  [[nodiscard]] bool run(const Eigen::VectorXd& x);
  [[nodiscard]] bool move(const Eigen::VectorXd& values);
  // Whether it succeeds; else why_failed() tells the error. That of a plugin is thrown.
  template <class Work>
  [[nodiscard]] bool tell(const Work& work);
  void add_residuals(const Eigen::VectorXd& values, Eigen::VectorXd& out);
  [[nodiscard]] Eigen::MatrixXd products(const Eigen::MatrixXd& changes, bool all_rows);
  void count(double motions) const {
    if (work_ != nullptr) *work_ += motions * steps();
  }
  // Calls work(k) for each experiment, in threads.
  template <class Work>
  void for_each_run(const Work& work) const;

  std::vector<Run> runs_;
  std::unique_ptr<Variables> variables_;
  double root_guess_weight_ = 0.0, unseen_ = 0.0;
  bool is_unseen_known_ = false;  // from the first motion whose residuals are asked for
  double extent_ = 0.0;           // of what was observed, as residuals
  unsigned at_a_time_ = 1;        // experiments
  std::size_t observed_ = 0;
  Eigen::Index rows_ = 0, smooth_rows_ = 0;
  Eigen::VectorXd at_;         // of the motions; empty: one has failed
  Eigen::VectorXd smooth_at_;  // where the cost of smoothness is known; empty: nowhere
  double smooth_cost_ = 0.0;
  std::string failure_;
  double* work_ = nullptr;
};

}  // namespace springnet::learning
