// Evaluations and sweeps on behalf of an integrator: forces of springs, elements and loads, accelerations of neurons,
// the integrator's update of nodes, then what constrains them. Statuses and messages as in springnet_host.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "layers/elements/enclosure_volumes.hpp"
#include "simulation/model.hpp"
#include "simulation/requests.hpp"
#include "simulation/sweep_pairs.hpp"
#include "simulation/sweep_plans.hpp"

namespace springnet {

class Sweep {
 public:
  explicit Sweep(Model& model) : model_(model), pairs_(model) {}

  // Evaluates the layers at a state, for all nodes or some.
  springnet_status evaluate(const springnet_evaluation& request);
  springnet_status evaluate_nodes(const springnet_evaluation& request);
  // A sweep of the network; `network.revision` shows changes of its connections.
  springnet_status run(const springnet_sweep& request, const springnet_network& network);
  // The end of a sweep by itself: constraints alone.
  springnet_status constrain(const springnet_sweep& request);

  // What a commit needs to know of the sweeps since the last commit.
  struct Done {
    bool any = false;
    bool decided = false;  // about contacts
    double weight = 0.0;   // s: theta times the time constant of the last sweep
    double rest = 0.0;     // s: (1 - theta) times it
  };
  [[nodiscard]] const Done& done() const noexcept { return done_; }
  // Whether these are outputs that the last sweep left, and all are finite.
  [[nodiscard]] bool left_finite(const springnet_vectors& position, const springnet_vectors& velocity) const noexcept {
    return left_position_ != nullptr && left_position_ == position.x && left_velocity_ == velocity.x;
  }
  // Of bodies that the sweeps keep apart.
  [[nodiscard]] SweepPairs& pairs() noexcept { return pairs_; }
  void forget() noexcept {
    done_.any = false;
    left_position_ = left_velocity_ = nullptr;
  }

 private:
  struct Tiles;           // context for the finished tiles of an evaluation or a sweep
  struct NodeEvaluation;  // of one node in an order
  // Which nodes of a range to update: those of enclosures depend on each other, and come after the others.
  enum class Turn : std::uint8_t { all, others, on_enclosure };

  static springnet_status finish_tile(void* tiles, std::uint32_t unit, std::uint32_t first, std::uint32_t count,
                                      const layers::ForceArrays& force, springnet_message& message);
  springnet_status in_order(Tiles& tiles, const layers::SweepPlan* plan);
  springnet_status one_set(std::uint32_t set, Tiles& tiles);
  springnet_status range(std::uint32_t begin, std::uint32_t end, std::uint32_t unit, Turn turn, Tiles& tiles,
                         springnet_message& message);
  springnet_status by_plan(const layers::SweepPlan& plan, Tiles& tiles, springnet_message& message);
  springnet_status one(std::uint32_t node, std::uint32_t unit, Turn turn, Tiles& tiles, springnet_message& message);
  springnet_status together(const layers::NodeList& list, std::uint32_t unit, Tiles& tiles, springnet_message& message);
  [[nodiscard]] std::uint32_t end_of_run(std::uint32_t begin, std::uint32_t end, Turn turn, const Tiles& tiles);
  springnet_status cluster(std::size_t cluster, std::uint32_t unit, Tiles& tiles, springnet_message& message);
  springnet_status evaluate_node(std::uint32_t node, Tiles& tiles, NodeEvaluation& result, springnet_message& message);
  springnet_status update_node(std::uint32_t node, std::uint32_t unit, Tiles& tiles, const NodeEvaluation& evaluation,
                               springnet_message& message);
  [[nodiscard]] bool is_on_enclosure(std::uint32_t node) const;
  // Whether a node depends on its neighbours alone: it is in no cluster and on no enclosure.
  [[nodiscard]] bool is_local(std::uint32_t node) const;
  // The plan for a sweep, null if it is done without. Checks the order.
  [[nodiscard]] const layers::SweepPlan* plan_for(const springnet_sweep& sweep, const springnet_network& network);
  [[nodiscard]] layers::InternalView internal_of(const springnet_sweep& sweep);
  void note_done(const springnet_sweep& sweep) noexcept;
  // Records why results of an evaluation are not finite. Returns true if they are finite.
  bool check_finite(bool forces, std::uint32_t bad_neuron, double time, const layers::NodeArrays& nodes);

  Model& model_;
  SweepPairs pairs_;
  Done done_;
  const double *left_position_ = nullptr, *left_velocity_ = nullptr;  // finite outputs of the last sweep
  bool in_sets_ = false;                                              // several threads update the nodes of a set,
  bool in_tiles_ = false;                                             // or of tiles
  OrderCheck order_check_;
  SweepPlans plans_;
  layers::EnclosureVolumes swept_volumes_;      // of enclosures within a sweep in an order
  layers::EnclosureVolumes evaluated_volumes_;  // in evaluate_nodes outside of sweeps
  std::vector<std::uint8_t> cluster_done_;      // [cluster] within a sweep in an order
  std::vector<std::uint32_t> run_of_;           // [node] the run that it was in last
  std::uint32_t run_ = 0;
};

}  // namespace springnet
