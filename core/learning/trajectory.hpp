// The states of a motion, all of them or as many as a budget of memory allows: others are made again when they are
// asked for, from saved states of the simulation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <springnet/simulation.hpp>

#include "learning/step_parts.hpp"

namespace springnet::learning {

// Steps are made in parts of some states. Where a part begins the simulation forgets what it keeps for speed, so that
// what follows depends on the state alone: a state that is made again has the bits of the first time, whatever the
// budget.
class Trajectory {
 public:
  struct State {
    double time = 0.0;            // s
    Eigen::VectorXd p, v;         // m, m/s: [3 node]
    Eigen::VectorXd z;            // internal states of laws
    std::vector<StepPart> parts;  // of the step that ends here, if it was divided
  };
  using Record = std::function<void(State&)>;  // writes the present state of the simulation, but for the parts

  // recorder: makes the steps. saves: the simulation is saved at each part in any case, for there is more than springs
  // that are removed which makes a difference: changes of the net's own, events that are located.
  // Divided steps have states of their own, and how many is not known before: what is kept follows from those so far.
  Trajectory(Simulation& simulation, Record record, PartRecorder& recorder, bool saves)
      : simulation_(simulation), record_(std::move(record)), recorder_(recorder), saves_(saves) {}

  // Bytes, of states, with those within divided steps, and of saved states. Of the runs to come.
  void set_memory(std::size_t bytes) noexcept { memory_ = bytes; }
  // Bytes of these that other things take beside it.
  void set_reserved(std::size_t bytes) noexcept { reserved_ = bytes; }
  // Makes steps from the present state of the simulation; made(k) is called after each, with the number of the state
  // that it has reached. Throws what step() and `made` throw, and Error(input) if the budget is too small for a part;
  // there are then no states.
  void run(std::size_t steps, const std::function<void(std::size_t)>& made);
  // In place of a run: these two alone.
  void hold(State first, State second);
  void clear();

  [[nodiscard]] std::size_t size() const noexcept { return times_.size(); }
  [[nodiscard]] double time(std::size_t state) const { return times_[state]; }
  // Valid until another one is asked for. The one before, or the one after, stays at hand.
  [[nodiscard]] const State& at(std::size_t state);
  struct Step {
    const State &from, &until;
  };
  // The step that ends at a state; both valid until another state is asked for.
  [[nodiscard]] Step step(std::size_t until);

  // What is kept, and what it took, since the last run.
  struct Use {
    std::size_t states = 0, most_states = 0;  // now, and at most
    std::size_t saved = 0, most_saved = 0;    // saved states of the simulation
    std::size_t steps_again = 0;              // made once more
    std::size_t part = 0;                     // states
    std::size_t places = 0;                   // for saved states; 0: all states are kept
    std::size_t most_bytes = 0;               // at most, of all of them
  };
  [[nodiscard]] const Use& use() const noexcept { return use_; }

 private:
  struct Saved {
    std::size_t part;
    std::string bytes;
    std::vector<StepPart> parts;  // of the step that ends there
  };
  void record();
  [[nodiscard]] const State* find(std::size_t state) const noexcept;
  [[nodiscard]] std::size_t parts() const noexcept { return (times_.size() + use_.part - 1) / use_.part; }
  void plan(std::size_t steps);
  // For saved states, beside a part. Throws Error(input) if there is not even one.
  [[nodiscard]] std::size_t find_places() const;
  // After a state of the run was recorded: fewer states, or saved ones, if divided steps take their place.
  void stay_within_memory();
  // Of the states so far those of the last part, and the one before it.
  void keep_last_part();
  void save(std::size_t part);
  void drop_saved();
  void begin_window(std::size_t first);  // the state beside it has been put there
  [[nodiscard]] std::size_t bytes() const noexcept;
  // Whether the plan up to the part `target` keeps the simulation at the start of a part.
  [[nodiscard]] bool keeps(std::size_t part, std::size_t target) const;
  // From the start of a part on what follows depends on the state alone.
  void begin_part(std::size_t part, std::size_t target);
  void step_on();
  void load(std::size_t part);
  void count();

  Simulation& simulation_;
  Record record_;
  PartRecorder& recorder_;
  bool saves_;
  std::size_t memory_ = std::size_t{1} << 30, reserved_ = 0;
  std::size_t steps_ = 0;      // of the run
  std::vector<double> times_;  // [state] s
  // States from first_ on: all, or those of a part; and one of a part beside it.
  std::vector<State> states_;
  std::size_t first_ = 0, count_ = 0;  // count_: of states_ that are used
  State beside_;
  std::size_t beside_number_ = none;
  std::vector<Saved> saved_;  // by rising part
  std::size_t here_ = 0;      // where the simulation is: number of its state
  std::size_t events_ = 0;    // of the simulation, where it was last saved or restored
  Use use_;
  // Bytes: of a state by itself, of saved states, and of the largest one.
  std::size_t each_ = 0, saved_bytes_ = 0, largest_saved_ = 0;
  // Bytes of what divided steps have beside that: in states_ now, at most in a part, at most in a step, and at most
  // while derivatives pass a step, which makes states of its parts.
  std::size_t divided_ = 0, most_divided_ = 0, most_of_step_ = 0, most_passed_ = 0;
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
};

}  // namespace springnet::learning
