// The input signals of laws while a network is simulated: their values at the times of evaluations.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

#include "network/signal_course.hpp"
#include "text/archive.hpp"

namespace springnet::layers {

class Signals {
 public:
  // Numbered as the inputs of the network.
  explicit Signals(const std::vector<Input>& inputs);

  // Another signal, of the same value at all times; returns its number.
  std::uint32_t add_constant(double value);
  // For those after the first ones, all constant.
  void set_constant(std::uint32_t signal, double value);
  [[nodiscard]] std::size_t count() const noexcept { return courses_.size(); }
  void drop_constants_from(std::size_t count);

  // The present step, s: signals are left limits at its end and right limits at its start. Returns whether one jumps
  // there, the first time that a step starts at the jump. An end that is not after the start: no step, right limits
  // everywhere. time_step: s, the user's; times that differ by a billionth of it, or of the step, are the same.
  bool set_interval(double from, double until, double time_step);
  // To be called before evaluations at a time, s, on several threads, which then cost little.
  void sample(double time);
  // From now on the signal has this value.
  void hold(std::uint32_t signal, double value);
  [[nodiscard]] bool is_held(std::uint32_t signal) const { return replaced_.contains(signal); }

  // At the time of an evaluation, s.
  [[nodiscard]] double at(std::uint32_t signal, double time) const {
    return time == sampled_time_ ? sampled_[signal] : value(signal, time);
  }
  // Where a step of `time_step` seconds up to `time` starts.
  [[nodiscard]] double at_start(std::uint32_t signal, double time, double time_step) const;
  // What hold() has set, and the present step, of the signals before the network was extended; `inputs` of them are its
  // inputs. time: s, now.
  void take_over(const Signals& before, std::size_t inputs, double time);
  // The present step, and what hold() has set.
  void archive(Archive& archive);
  // The next time after `time` at which one of them jumps or has a kink, s; infinity if there is none.
  [[nodiscard]] double next_kink(double time) const;

 private:
  [[nodiscard]] double value(std::uint32_t signal, double time) const;
  // The time at which a signal that jumps is to be read.
  [[nodiscard]] double one_sided(double time) const noexcept;
  void sample_all(double time, std::vector<double>& values) const;

  std::vector<SignalCourse> courses_;
  std::vector<std::uint32_t> varying_;              // not constant
  std::map<std::uint32_t, SignalCourse> replaced_;  // by hold()
  double from_ = 0.0;                               // s
  double until_ = std::numeric_limits<double>::infinity();
  double slack_ = 0.0;         // s: times this near are those of its ends
  double sampled_time_ = 0.0;  // s
  std::vector<double> sampled_, at_start_;
  std::vector<double> at_end_;  // of the step before, for those that jump
};

}  // namespace springnet::layers
