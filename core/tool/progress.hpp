// How far a run is: a bar on a terminal, a line now and then elsewhere. On stderr, which leaves stdout to results.
#pragma once

#include <chrono>
#include <string>

namespace springnet::tool {

class Progress {
 public:
  explicit Progress(bool silent);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(double time, double duration);  // s, simulated
  void finish();                              // removes the bar

 private:
  void print(const std::string& text);

  using Clock = std::chrono::steady_clock;
  bool silent_;
  bool terminal_;
  bool drawn_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
};

}  // namespace springnet::tool
