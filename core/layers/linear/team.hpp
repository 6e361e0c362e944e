// Threads that run the same code, each on its share of the nodes, with barriers where one reads what another wrote; and
// sums with the same bits for every number of threads: over ranges of nodes that do not depend on it, in their order.
#pragma once

#include <cstddef>
#include <vector>

#include "layers/linear/node_range.hpp"

namespace springnet::layers {

// One thread of a team.
class Team {
 public:
  Team(unsigned count, unsigned me) : count_(count), me_(me) {}

  [[nodiscard]] unsigned count() const noexcept { return count_; }
  [[nodiscard]] unsigned me() const noexcept { return me_; }
  void barrier() const {
    if (count_ > 1) wait();
  }
  // Runs `action` in one thread alone, between barriers.
  template <class Action>
  void alone(const Action& action) const {
    barrier();
    if (me_ == 0) action();
    barrier();
  }
  // This thread's share of `size` things, a contiguous range.
  [[nodiscard]] NodeRange share(std::size_t size) const { return {size * me_ / count_, size * (me_ + 1) / count_}; }

 private:
  friend class TeamSum;
  static void wait();  // elsewhere, so that code compiled without OpenMP has the same
  unsigned count_, me_;
  std::size_t slot_ = 0;  // of the next sum
};

// Two sums at once.
struct Sums2 {
  double first, second;
};

// Memory for sums of one team at a time.
class TeamSum {
 public:
  void resize(std::size_t parts) { values_.assign(2 * slots * parts, 0.0); }
  // The sum of part(i) over all i, the same in all threads, which compute those of `own`. A barrier.
  template <class Part>
  [[nodiscard]] double operator()(Team& team, NodeRange own, const Part& part) {
    return two(team, own, [&](std::size_t i) -> Sums2 { return {part(i), 0.0}; }).first;
  }
  template <class Part>
  [[nodiscard]] Sums2 two(Team& team, NodeRange own, const Part& part) {
    const std::size_t parts = values_.size() / (2 * slots);
    double* values = values_.data() + team.slot_ * 2 * parts;
    // A thread may still be reading the last sum, but not the one before: it has passed a barrier since.
    team.slot_ = (team.slot_ + 1) % slots;
    for (std::size_t i = own.begin; i < own.end; ++i) {
      const Sums2 value = part(i);
      values[2 * i] = value.first;
      values[2 * i + 1] = value.second;
    }
    team.barrier();
    Sums2 total{0.0, 0.0};
    for (std::size_t i = 0; i < parts; ++i) {
      total.first += values[2 * i];
      total.second += values[2 * i + 1];
    }
    return total;
  }

 private:
  static constexpr std::size_t slots = 3;
  std::vector<double> values_;
};

}  // namespace springnet::layers
