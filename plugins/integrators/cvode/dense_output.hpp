// The motion between commits: of each internal step the polynomial that CVODE went along.
#pragma once

#include <cstddef>
#include <deque>
#include <vector>

#include "sundials.hpp"

namespace springnet::cvode {

class DenseOutput {
 public:
  // Forgets what ended before `from`, s, the time that was committed last.
  void begin(double from);
  // The internal step that CVODE made last. It began at `restart` at the earliest, where CVODE was started.
  void add_step(void* memory, double restart, const Context& context);
  void forget() { steps_.clear(); }

  // The first `count` numbers of y at a time. False: no step of those has it.
  [[nodiscard]] bool evaluate(double time, std::size_t count, double* y) const;

 private:
  struct Step {
    double begin, end;                             // s
    std::vector<std::vector<double>> derivatives;  // [k] d^k y / dt^k at the end
  };
  std::deque<Step> steps_;
};

}  // namespace springnet::cvode
