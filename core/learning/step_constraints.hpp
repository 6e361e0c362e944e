// Surfaces and rigid connections of a motion, for its derivatives: what they make of the outputs of each step, and the
// accelerations of the constrained motion at its start.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include <springnet/network.hpp>
#include <springnet/sdk/host.hpp>
#include <springnet/simulation.hpp>

#include "learning/constrained_outputs.hpp"
#include "learning/contact_history.hpp"
#include "learning/learned_values.hpp"
#include "simulation/engine.hpp"

namespace springnet::learning {

class StepConstraints {
 public:
  StepConstraints(const Network& network, const PluginHost& plugins, const SimulationOptions& options);
  ~StepConstraints();
  StepConstraints(const StepConstraints&) = delete;
  StepConstraints& operator=(const StepConstraints&) = delete;

  // Its parameters must be those of the motion.
  [[nodiscard]] Engine& engine() noexcept { return engine_; }
  [[nodiscard]] ContactHistory& history() noexcept { return history_; }
  // Throws Error(input) if start velocities are learned of nodes that are constrained from the start: they are
  // projected, which is not differentiated. simulation: at the start.
  void check_starts(const LearnedSets& learned, const Simulation& simulation) const;
  [[nodiscard]] bool is_rigid(std::uint32_t node) const;  // the engine's number: whether it is rigidly connected
  // Throws Error(simulation) if a node that touches a surface belongs to too great a cluster.
  void check_touching_cluster(std::uint32_t node, std::int32_t surface, double time) const;
  // Whether anything constrains the accelerations at a state.
  [[nodiscard]] bool any_at(std::size_t state);
  // Or the outputs of the step that ends at a state.
  [[nodiscard]] bool any_within(std::size_t step);
  // The host of the constrained motion from this state to the next, s; its contacts are those committed at the state.
  [[nodiscard]] const sdk::Host& begin_step(std::size_t state, double from, double until);

  // After begin_step(): nodes that stick to a surface have its acceleration, which depends on where they are if it
  // turns; the host's products leave that out. Adds its change by dp, [3 node], and the transpose.
  void add_carried(const Eigen::VectorXd& dp, Eigen::VectorXd& accelerations);
  void add_carried_transposed(const Eigen::VectorXd& weights, Eigen::VectorXd& by_position);

  // A step with its ends, [3 node]: m, m/s, and V (see ConstrainedOutputs).
  struct Step {
    std::size_t until;  // number of the state at its end
    double from_time, until_time, theta;
    const Eigen::VectorXd &p, &v, &P, &U;
    bool kept = false;                     // contacts, which no sweep has decided
    double unsettled = 0.0;                // m/s, see NodeOverStep
    const LearnedSets* learned = nullptr;  // whose derivatives are wanted; null: of no surface
    bool timed = true;                     // its start or end may move
  };
  // Nodes that arrive at a surface in a step; U is that at its end.
  [[nodiscard]] std::vector<Arrival> arrivals(const Step& step);
  // U: in the step, of nodes that arrive. Throws Error(simulation) for a contact that is not differentiated, with its
  // node and time.
  void find_outputs(const Step& step, const Eigen::VectorXd& free, ConstrainedOutputs& outputs);

  // Of accelerations without constraints, [3 node], where the host was linearised: what these make of them; or the
  // transpose.
  void project(bool transposed, double* accelerations) {
    engine_.linear().project_accelerations(transposed, accelerations);
  }

 private:
  template <class Use>
  void for_each_carried(const Use& use);
  struct Places {
    const StepPlacement& step;
    const std::shared_ptr<const Placement>& start;
  };
  void add_clusters(const Step& step, const Eigen::VectorXd& free, const std::vector<StepContact>& contacts,
                    const Places& places, ConstrainedOutputs& outputs);

  Engine engine_;
  springnet_host table_;
  sdk::Host host_;
  ContactHistory history_;
  double state_time_ = 0.0;  // s, at which a step was begun
};

}  // namespace springnet::learning
