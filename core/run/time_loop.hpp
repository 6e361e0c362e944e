// The time loop of everything that simulates a scene: a run, and a validation, in which several simulations advance
// together.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>

#include <springnet/simulation.hpp>

#include "run/pace.hpp"
#include "text/archive.hpp"

namespace springnet {

// Advances a simulation step by step and accumulates what its steps report.
class Stepper {
 public:
  Stepper(Simulation& simulation, RunClock clock) : simulation_(&simulation), clock_(std::move(clock)) {}

  // Whether the simulation has reached this time, s, up to rounding.
  [[nodiscard]] bool has_reached(double time) const;
  // One time step towards `end`, s; the last one is shortened to end there. Throws as Simulation::step() does; a failed
  // step counts in the totals.
  void step(double end);
  void advance_to(double time) {
    while (!has_reached(time)) step(time);
  }

  struct Totals {
    Outcome worst = Outcome::settled;
    std::uint64_t unsettled = 0;  // steps that were accepted without having settled
    std::uint64_t divided = 0;    // steps that were made as several smaller ones
    std::uint64_t substeps = 0;   // those smaller ones
    std::uint64_t stages = 0;     // smaller time constants passed on the way to the full one
    double largest_residual = std::numeric_limits<double>::quiet_NaN();  // N; nan if it was never evaluated
    double last_residual = std::numeric_limits<double>::quiet_NaN();     // N
    double spring_updates = 0.0;                                         // springs evaluated
    double wall = 0.0;                                                   // s, of the clock
  };
  [[nodiscard]] const Totals& totals() const noexcept { return totals_; }
  void archive(Archive& archive);  // the totals

 private:
  void count(const StepReport& report);

  Simulation* simulation_;
  RunClock clock_;
  Totals totals_;
};

// Something that advances in stages: time steps, or the intervals between records that several simulations share.
class Timeline {
 public:
  virtual ~Timeline() = default;
  [[nodiscard]] virtual double time() const = 0;     // s, simulated
  [[nodiscard]] virtual bool has_ended() const = 0;  // the whole duration is simulated
  virtual void advance() = 0;                        // by a stage
  virtual void record_if_due() = 0;                  // after a stage
};

// Advances until the timeline has ended or `go_on`, called after each stage and ten times a second while waiting,
// returns false. Keeps pace with a clock if `pace` is not null. Returns whether the timeline has ended.
bool advance_to_end(Timeline& timeline, Pace* pace, const std::function<bool()>& go_on);

}  // namespace springnet
