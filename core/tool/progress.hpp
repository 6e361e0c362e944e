// Progress of a run, its loading, and a search: a bar on a terminal, otherwise a line every few seconds. On stderr, so
// that stdout has only results.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace springnet::tool {

class Progress {
 public:
  explicit Progress(bool silent);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Shows what is being done before the first time step; share: nan if it is not known.
  void load(std::string_view stage, double share);
  // Shows the progress; times are simulated, s. Returns false once a signal has asked the process to end.
  bool update(double time, double duration);
  // Shows an iteration of a search; without a terminal each has its line. Returns as update().
  bool search(double share, std::string_view text);
  void finish();  // removes the bar; the next update() begins a run

 private:
  void show(double time, double duration);
  void print(const std::string& text);

  using Clock = std::chrono::steady_clock;
  bool silent_;
  bool terminal_;
  bool drawn_ = false;
  bool running_ = false;
  std::string stage_;  // of load()
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
};

}  // namespace springnet::tool
