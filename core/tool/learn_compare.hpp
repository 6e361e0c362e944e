// `springnet learn --compare`: both methods from the same start, by the cost of the whole motion over the work.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <springnet/learn.hpp>

namespace springnet::tool {

// What a search has told, evenly thinned: of long motions values at each step would not fit into memory.
class ToldProgress {
 public:
  void add(const LearnProgress& now);
  [[nodiscard]] std::vector<LearnProgress> points() const;  // the last one among them

 private:
  std::vector<LearnProgress> kept_;
  LearnProgress last_;
  std::size_t count_ = 0, pitch_ = 1;
};

// What both methods are given.
struct Compared {
  const Experiment& experiment;
  const std::shared_ptr<const PluginHost>& plugins;
  const std::vector<Learnable>& learnables;
  LearnOptions whole;  // without a state
  OnlineOptions online;
  std::function<bool(const LearnProgress&)> on_iteration, on_step;
};

// Adds the courses of both to what one has found and told. Learns by the other one, unless the first was stopped; if
// that fails, a note says so.
void add_courses(LearnedNet& learned, const std::string& method, const ToldProgress& told, Compared both);

// A table of them.
[[nodiscard]] std::string comparison_table(const std::vector<LearnCourse>& courses);

}  // namespace springnet::tool
