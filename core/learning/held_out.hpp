// Observations that are not learned from, and judge what was learned.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <springnet/learn.hpp>

namespace springnet::learning {

// The experiments that are learned from. Throws Error(input) for one without any observations.
[[nodiscard]] std::vector<Experiment> learned_from(const std::vector<Experiment>& experiments);

[[nodiscard]] std::vector<Experiment> with_half_the_step(std::vector<Experiment> experiments);

class Judge {
 public:
  // Throws Error(input) as Fit, and for a value that is also learned from.
  Judge(const std::vector<Experiment>& experiments, const std::shared_ptr<const PluginHost>& plugins,
        const std::vector<Learnable>& learnables, const LearnOptions& options);
  // Sets held_out, of the variables at the start and at x; a motion that fails is a note.
  void judge(const Eigen::VectorXd& x, LearnedNet& learned);
  // Sets half_step_rms, of the motions with half the time step and these variables; after judge().
  void judge_half_step(const Eigen::VectorXd& x, LearnedNet& learned);

 private:
  std::vector<Experiment> experiments_;  // `observations` are those that were held out
  const std::shared_ptr<const PluginHost>& plugins_;
  const std::vector<Learnable>& learnables_;
  double start_rms_ = 0.0;
  unsigned threads_;
  std::size_t memory_;
};

}  // namespace springnet::learning
