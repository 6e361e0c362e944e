// The motion near a state, for implicit methods: derivatives of the accelerations, linear systems, and projections onto
// the constraints.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "layers/linear/block_system.hpp"
#include "layers/linear/internal_elimination.hpp"
#include "layers/linear/iterative_solver.hpp"
#include "layers/linear/linearisation.hpp"
#include "layers/linear/matrix_free.hpp"
#include "simulation/constrained_response.hpp"
#include "simulation/model.hpp"
#include "simulation/requests.hpp"

namespace springnet {

class LinearSweep;

class LinearModel {
 public:
  explicit LinearModel(Model& model);
  ~LinearModel();

  // Computes the derivatives at a state, for the functions below. Statuses and messages as in springnet_host. of_step:
  // s, the weight of accelerations in a step: friction is of the reactions that its sweeps found; 0: of those at the
  // state.
  springnet_status linearise(const springnet_evaluation& at, double elimination, double of_step = 0.0);
  // See springnet_internal_change.
  springnet_status change_internal(const springnet_internal_change& request);
  // Whether there are derivatives: nothing has been removed from the network since.
  [[nodiscard]] bool known() const noexcept { return blocks_.known(); }
  // out = da/dp dp + da/dv dv, 3n numbers each, x of all nodes first. true_friction: see SPRINGNET_TRUE_FRICTION.
  springnet_status times(const double* dp, const double* dv, bool true_friction, double* out);
  // by_position = (da/dp)^T weights, by_velocity = (da/dv)^T weights.
  springnet_status transposed_times(const double* weights, bool true_friction, double* by_position,
                                    double* by_velocity);
  // Systems then have friction as it is, whatever the reactions become.
  void hold_friction() noexcept { holds_friction_ = true; }
  // out = velocity_weight times the one plus position_weight times the other, without true friction; after linearise().
  void weighted_transposed_times(double velocity_weight, double position_weight, const double* weights, double* out);
  // Diagonal blocks of I - velocity_weight da/dv - position_weight da/dp, [node][9].
  void diagonal_blocks(double velocity_weight, double position_weight, double* out);
  springnet_status factorise(double velocity_weight, double position_weight);
  springnet_status solve(bool transposed, const double* right_side, double* x);
  // Assembles a system with the derivatives at hand, which is then kept; and solves it, see springnet_host.
  springnet_status prepare(const springnet_linear_system& request);
  // Prepares the symmetric part of the system at a state, if that can be done without its matrix; the derivatives at
  // hand stay. responses: of nodes on surfaces that are none of the network's; null: none.
  [[nodiscard]] bool prepare_matrix_free(const springnet_evaluation& at, const layers::SystemWeights& weights,
                                         const std::vector<layers::NodeResponse>* responses = nullptr);
  // Whether there is a system to be solved: not after changes of the network.
  [[nodiscard]] bool is_prepared() const noexcept { return prepared_ != Prepared::nothing; }
  springnet_status solve_prepared(springnet_linear_solve& request);
  // The prepared system by rows, see springnet_system_rows.
  springnet_status rows(springnet_system_rows& out);
  // A sweep of the linearised network in an order, see springnet_host::linear_sweep; `network.revision` shows changes
  // of its connections.
  springnet_status sweep(const springnet_sweep& request, const springnet_network& network);
  // The matrices by themselves.
  [[nodiscard]] layers::Linearisation& matrices() noexcept { return blocks_; }
  // Projects velocities onto the constraints, see springnet_host::project.
  springnet_status project(const double* mobility, double* values, bool transposed = false);
  // The same as accelerations answer at the state linearised or prepared last, with friction that follows normal
  // reactions.
  void project_accelerations(bool transposed, double* values);
  // Drops derivatives, the prepared system and patterns.
  void forget() noexcept;
  // Drops what solutions of systems without a matrix keep for the next ones, so that those to come depend on
  // themselves alone.
  void forget_solutions() noexcept {
    matrix_free_.forget();
    assembled_next_ = 0;
    assembled_after_stall_ = least_assembled;
  }
  // To be called after springs or elements were removed.
  void topology_changed() noexcept {
    blocks_.topology_changed();
    system_.topology_changed();
    prepared_ = Prepared::nothing;
    thin_.reset();
    forget_solutions();
    if (factors_.owner == Factors::Owner::system) factors_.owner = Factors::Owner::nobody;
    factors_.current = false;
  }

 private:
  // Adds the geometric stiffness of rods under tension, and the derivative of friction by the slip. Implicit methods
  // need both: they are stiff where tensions are great or slips slow.
  springnet_status add_drags(ReactionsAt& reactions);
  springnet_status add_constraints(const springnet_evaluation& at, double of_step);
  // How surfaces answer at a state that the constraints follow, and use(row, derivative) with that of friction by the
  // velocity of nodes that slip.
  template <class Use>
  springnet_status find_response(const springnet_evaluation& at, double of_step, ReactionsAt& reactions,
                                 ConstrainedResponse& response, const Use& use);
  // Lets the constraints follow the state, if it comes to that; and finds what they make of single nodes.
  [[nodiscard]] bool may_be_matrix_free(const springnet_evaluation& at, const layers::SystemWeights& weights);
  // Whether the preconditioner of the matrix-free solver is good enough for the net.
  [[nodiscard]] bool suits_matrix_free();
  [[nodiscard]] bool is_thin();
  void clear_held(double* values) const;
  // The state at which a matrix-free system was prepared, in case that its solution stalls and it has to be assembled.
  void keep_state(const springnet_evaluation& at);
  springnet_status assemble_kept();
  // Whether systems have friction that follows the reactions of surfaces. With rigid connections it follows from sweep
  // to sweep.
  [[nodiscard]] bool has_friction() const noexcept {
    return response_.known() && response_.has_friction() && !model_.rigid.any() && !holds_friction_;
  }
  void begin_system(const layers::SystemWeights& weights);
  void assemble();  // with the derivatives at hand
  // There is room for one factorisation: the integrator's or, where iterations give up, that of the prepared system.
  struct Factors {
    enum class Owner : std::uint8_t { nobody, integrator, system };
    Owner owner = Owner::nobody;
    double velocity_weight = 0.0, position_weight = 0.0;  // of the integrator's last one
    bool current = false;                                 // which was of the derivatives at hand
  };
  springnet_status factorise_for(Factors::Owner owner, double velocity_weight, double position_weight);
  // By factorisation of the prepared system; only while its derivatives are those at hand.
  springnet_status solve_directly(springnet_linear_solve& request, const double* right_side);

  Model& model_;
  layers::Linearisation blocks_;
  bool holds_friction_ = false;
  ConstrainedResponse response_;  // known where there are constraint rows
  ConstrainedResponse matrix_free_response_;
  ConstrainedResponse* last_response_ = &response_;   // of what was linearised or prepared last
  std::vector<layers::NodeResponse> node_responses_;  // of the matrix-free system
  layers::InternalElimination elimination_;           // of blocks_
  // What is prepared: a matrix, or springs.
  enum class Prepared : std::uint8_t { nothing, assembled, matrix_free };
  Prepared prepared_ = Prepared::nothing;
  layers::SystemWeights weights_;
  layers::BlockSystem system_;
  layers::IterativeSolver solver_;
  layers::MatrixFree matrix_free_;
  // Systems that are still to be assembled after a solution without a matrix has stalled; and how many after the next.
  static constexpr std::uint32_t least_assembled = 16, most_assembled = 1024;
  std::uint32_t assembled_next_ = 0, assembled_after_stall_ = least_assembled;
  std::vector<double> linearised_at_;  // [3 node] m
  double kept_time_ = 0.0;
  springnet_internal kept_internal_{};                // no size: the evaluation had none
  std::vector<double> kept_state_, kept_right_side_;  // [6 node], [3 node]
  std::optional<bool> thin_;                          // of the springs and elements that are left
  Factors factors_;
  bool at_hand_ = false;                       // blocks_ are the derivatives that the system was assembled from
  bool indefinite_ = false;                    // conjugate gradients met negative curvature in it
  std::vector<double> right_side_, solution_;  // [node][3] and one more
  std::unique_ptr<LinearSweep> sweep_;         // of blocks_; null: not made since linearise()
  OrderCheck order_check_;
  std::vector<double> weights_of_free_;                   // of transposed_times
  std::vector<double> internal_change_, internal_force_;  // of change_internal
  // Rank-one terms of `rows`, one after another.
  std::vector<std::uint64_t> low_rank_start_;
  std::vector<std::uint32_t> low_rank_nodes_;
  std::vector<double> low_rank_g_, low_rank_w_;
};

}  // namespace springnet
