// A look into steps while they are made: the parts that an integrator commits within a step, and the events that it has
// located. For what takes steps apart, such as their derivatives.
#pragma once

#include <cstdint>

#include "simulation/state.hpp"

namespace springnet {

class Engine;

class StepWatch {
 public:
  StepWatch() = default;
  StepWatch(const StepWatch&) = delete;
  StepWatch& operator=(const StepWatch&) = delete;
  virtual ~StepWatch() = default;

  // Before the marked events (see ContactEvents::fire) are carried out at `time`, s, on this state.
  virtual void fires(Engine& engine, double time, const State& state, const std::int32_t* fired) = 0;
  // When a commit is complete. decided: the sweeps decided about contacts.
  virtual void committed(Engine& engine, bool decided) = 0;

  // Of the steps that the calling thread makes.
  class Scope {
   public:
    explicit Scope(StepWatch& watch) noexcept;
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    StepWatch* before_;
  };
  // Null: nobody watches.
  [[nodiscard]] static StepWatch* current() noexcept;
};

}  // namespace springnet
