// A guess at the velocities that a step ends with, from those of the steps before: constant, linear or quadratic in
// time, whichever would have been closest at the last step. (A good guess saves Newton's method a sweep in four.)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <springnet/sdk/plugin.h>

namespace springnet::recurrent {

class Extrapolation {
 public:
  void forget() noexcept { known_ = 0; }
  // Learns the committed velocities (m/s, [count]) at a time, s. Call it at every step; again for the same step has no
  // effect.
  void learn(double time, const springnet_const_vectors& velocity, std::uint32_t count);
  // Writes the guess for a later time; false if too few steps are known.
  [[nodiscard]] bool guess(double time, const springnet_vectors& velocity) const;

 private:
  static constexpr std::size_t kept = 4;
  struct Known {
    double time = 0.0;
    std::vector<double> velocity;  // [3 count], x of all nodes first
  };
  // Weights of the latest `order` + 1 velocities in the polynomial through them, from `latest` on.
  [[nodiscard]] std::array<double, 3> weights(std::size_t latest, std::size_t order, double time) const;
  [[nodiscard]] const Known& at(std::size_t age) const { return steps_[(newest_ + kept - age) % kept]; }

  std::array<Known, kept> steps_;
  std::size_t newest_ = 0, known_ = 0;
  std::size_t order_ = 0;  // that would have been best at the last step
};

}  // namespace springnet::recurrent
