// Events of rigidly connected nodes. Connections and all contacts of a cluster act at once there, and no formula gives
// what they make of it: the derivatives are those of differences of the functions with which the engine finds and
// carries out the events.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "learning/contact_history.hpp"
#include "learning/event_jump.hpp"
#include "learning/rod_lengths.hpp"
#include "learning/step_parts.hpp"
#include "simulation/engine.hpp"

namespace springnet::learning {

// How the value of an event changes; vectors [3 node of the cluster] and [node of the cluster].
struct ClusterCondition {
  Eigen::VectorXd by_position, by_velocity, by_acceleration;  // by_acceleration: of nodes that nothing constrains
  Eigen::VectorXd by_mass;                                    // at these accelerations
  double by_time = 0.0;
};

class ClusterEvent {
 public:
  // The state in which the event found all nodes, [3 node] in the engine's order, and internal states of laws.
  struct State {
    double time;      // s
    double shortest;  // s, far below the motion of surfaces
    const Eigen::VectorXd &p, &v, &z;
  };
  // The model's contacts become those before the event, and a step its present one that ends at the given time, s.
  using Begin = std::function<void(double until)>;
  using Placed = std::function<std::shared_ptr<const Placement>(double time)>;

  // The engine, the event and the vectors of the state must outlive it. Of the engine contacts and the present step are
  // others afterwards, and what nothing depends on: sums of impulses, notes.
  ClusterEvent(Engine& engine, const LocatedEvent& event, const State& state, Begin begin, Placed placed);

  // Whether it happens by forces: a release, or a slip that begins. Of others see event_condition.hpp.
  [[nodiscard]] static bool has_condition(LocatedEvent::Kind kind);
  // Of such an event, with accelerations of all nodes without constraints, m/s^2 ([3 node], the engine's order). None:
  // differences do not settle.
  [[nodiscard]] std::optional<ClusterCondition> condition(const Eigen::VectorXd& accelerations);
  // None: the event does not give what it has left, or other contacts however small the differences.
  [[nodiscard]] std::optional<EventJump> jump();

 private:
  struct Input {
    Eigen::VectorXd p, v, mass;  // of the cluster
    double time;
  };
  struct Kept;  // what the engine's functions change
  [[nodiscard]] std::optional<Eigen::VectorXd> after(const Input& input, const Kept& kept);
  [[nodiscard]] std::optional<Eigen::VectorXd> value(const Input& input, const Eigen::VectorXd& free);
  [[nodiscard]] bool only_marks() const noexcept;
  [[nodiscard]] bool surfaces_move() const;
  void write_state();
  void begin_with(const Input& input);
  // Of [node of the cluster] or [3 node], without nodes whose motion is given.
  [[nodiscard]] double largest_of_moving(const Eigen::VectorXd& of_nodes) const;
  // m/s; of a cluster at rest that of the net.
  [[nodiscard]] double speed_or_typical(double speed) const { return speed > 0.0 ? speed : model_.scales.velocity; }
  [[nodiscard]] Eigen::VectorXd gather(const Eigen::VectorXd& of) const;

  Engine& engine_;
  Model& model_;
  const LocatedEvent& event_;
  State state_;
  Begin begin_;
  Placed placed_;
  std::vector<std::uint32_t> nodes_;
  std::size_t cluster_ = 0;
  std::vector<ClusterRod> rods_;
  Eigen::VectorXd mobility_;  // 0: its motion is given
  Input found_;
  double length_ = 0.0;  // m, of the longest rod
  double begun_ = 0.0;   // s: the step that has begun ends then; nan: none
  std::vector<Slipping> slips_;
};

}  // namespace springnet::learning
