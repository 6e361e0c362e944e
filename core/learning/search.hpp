// The search for values in its legs: parts of the motion, then all of it, from one start or several.
#pragma once

#include <vector>

#include <Eigen/Core>

#include <springnet/learn.hpp>

#include "learning/fit.hpp"
#include "learning/minimise.hpp"
#include "learning/search_journal.hpp"
#include "learning/variables.hpp"

namespace springnet::learning {

// Legs are told to the program as one search, and taken from the journal where they have been made before.
struct Search {
  const LearnOptions& options;
  const Variables& variables;
  SearchJournal& journal;
  std::vector<LearnProgress>& history;
  int start = 0, stage = 0, stages = 1;  // of the next leg
  bool stopped = false;
  double work = 0.0;  // see LearnProgress; Fit::count_in()

  // is_last: others lead to a search that goes on from there.
  [[nodiscard]] Minimum run(Fit& fit, const Eigen::VectorXd& from, double share, bool is_last);

 private:
  [[nodiscard]] Minimum made(Fit& fit, const Eigen::VectorXd& from, const MinimiseOptions& own) const;
};

}  // namespace springnet::learning
