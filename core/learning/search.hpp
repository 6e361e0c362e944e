// The search for values in its legs: parts of the motion, then all of it, from one start or several.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include <springnet/learn.hpp>

#include "learning/fit.hpp"
#include "learning/minimise.hpp"
#include "learning/search_journal.hpp"
#include "learning/variables.hpp"

namespace springnet::learning {

// The reason of a search that an error has ended.
[[nodiscard]] std::string ended_by(const std::string& failure);

// Legs are told to the program as one search, and taken from the journal where they have been made before.
struct Search {
  const LearnOptions& options;
  const Variables& variables;
  SearchJournal& journal;
  std::vector<LearnProgress>& history;
  int start = 0, stage = 0, stages = 1;  // of the next leg
  bool stopped = false;
  std::string failure{};  // an error that ended the search from this start, after it had found better values
  double work = 0.0;      // see LearnProgress; Fit::count_in()

  [[nodiscard]] bool is_over() const noexcept { return stopped || !failure.empty(); }
  // is_last: others lead to a search that goes on from there. An error ends the search with the best values until then;
  // it is thrown if they are those of the network, or of a plugin.
  [[nodiscard]] Minimum run(Fit& fit, const Eigen::VectorXd& from, double share, bool is_last);

 private:
  [[nodiscard]] Minimum made(Fit& fit, const Eigen::VectorXd& from, const MinimiseOptions& own) const;
};

}  // namespace springnet::learning
