// Newton's method on all nodes at once. With w = theta h, and c the forces of rigid connections, surfaces and friction,
// a sweep solves the linear system of the residual
//
//   r = U - v* - w (a(P, U) + c / m),   (I - w da/dv - w^2 da/dp + mu) delta = -r
//
// and moves to U + s delta, P + s w delta. The share s is 1 unless the slope m r.delta at the end, which is that of the
// potential m |U - v*|^2 / 2 + E(P) where one exists, shows that the step went too far. mu is 0 unless delta is not a
// descent direction, as where springs buckle or laws soften, or no share of it was accepted. Before a step is
// shortened, its second-order error in stiff constraints is corrected: a filling as stiff as water keeps its volume
// along delta to first order only. r and delta are projected onto rigid connections and sliding contacts. The set of
// pinned nodes is fixed during the search; then the host constrains the outputs and decides it anew.
#pragma once

#include <cstdint>
#include <vector>

#include "extrapolation.hpp"
#include "linear_system.hpp"
#include "rule.hpp"

namespace springnet::recurrent {

class Newton final : public Rule {
 public:
  explicit Newton(Workspace& workspace) : work_(workspace), system_(workspace.host) {}
  void attach(const springnet_network& network) override;
  void forget() noexcept override;
  void begin(Step& step) override;
  void sweep(Step& step) override;
  [[nodiscard]] bool has_linear_sweep() const noexcept override { return false; }

 private:
  // Derivatives are kept, from step to step too, while each sweep reduces the residual to this share, but not for more
  // steps than these.
  static constexpr double fast_convergence = 0.3;
  static constexpr int max_age = 10;

  // Residuals of outputs. Arrays of 3 n numbers have x of all nodes first.
  struct Assessment {
    std::vector<double> free;      // [3n] U - v* - w a, m/s
    std::vector<double> residual;  // [3n] r, 0 for pinned nodes, m/s
    double norm = 0.0;             // sqrt(sum m |r|^2); infinite where forces are not finite
    double slope = 0.0;            // sum m r.delta
  };

  // Assesses outputs whose forces have been evaluated.
  void assess(const Step& step, const springnet_state& state, Assessment& result);
  [[nodiscard]] bool start_from_guess(Step& step);
  void start(Step& step);
  void start_again(Step& step);
  // Of a step from a guess: whether it may go on.
  [[nodiscard]] bool is_about_to_settle(const Step& step);
  // Makes a step from the outputs to the candidate, which becomes the outputs. False: the outputs were a guess from
  // which no whole step is good.
  [[nodiscard]] bool advance(Step& step, springnet_state& candidate);
  // Moves prescribed nodes of a network without other constraints to the end of the step.
  void settle_prescribed(Step& step);
  // Constrains the newest outputs, assessed in at_outputs_, and decides contacts. Does not change the state `before`.
  void settle(Step& step, const springnet_state* before);
  [[nodiscard]] bool waits_with_releases(const Step& step, const springnet_state* before) const;
  // After the host moved nodes onto surfaces or off them, from the outputs to `next`, which has been evaluated: whether
  // that has left a greater residual than there was before and at the start of the step, or contacts have changed often
  // in it. Assesses `next` in at_outputs_, and drops the derivatives, which are of other contacts.
  [[nodiscard]] bool needs_to_follow(const Step& step, const springnet_state& next);
  // Lets all others follow, as the derivatives at the outputs and kept_acceleration_ there say, unless the residual is
  // smaller without. Where nodes have moved alone a stiff net is deformed so much that derivatives there lead astray.
  // Evaluates and assesses `next`, and uses the outputs up. Does not change the state `before`.
  void follow(Step& step, springnet_state& next, const springnet_state* before);
  void keep_acceleration(std::size_t nodes);
  [[nodiscard]] bool solve_to_follow(const Step& step, springnet_state& next);
  void swap_plain(springnet_state& next);
  // Sets the constraint forces of nodes without rigid connections to those of these outputs, with the contacts as they
  // are. Does not change the state `before`.
  void refresh_friction(const Step& step, const springnet_state& state, const springnet_state* before);
  // Outputs of nodes on surfaces without constraints, on which the host bases its decisions.
  // keeps: nodes that slide stay where they are.
  void unconstrain_contacts(const Step& step, const springnet_state& outputs, const springnet_state& free, bool keeps);
  bool find_pinned(const Step& step);
  [[nodiscard]] double residual(const Step& step) const;  // N
  // Sets the right side, and the derivatives unless those of an earlier sweep are good enough.
  void set_up(const Step& step);
  void linearise(const Step& step);
  [[nodiscard]] bool keeping_pays(const Step& step) const;
  [[nodiscard]] double accuracy(const Step& step) const;
  void find_direction(const Step& step, double accuracy);
  // Sets the candidate to outputs + share * direction, and assesses it.
  void evaluate_candidate(const Step& step, double share, const springnet_state& candidate);
  // m r.direction at the outputs.
  [[nodiscard]] double slope_along(const Step& step, const std::vector<double>& direction) const;
  // For a whole step that increased the residual many times because of second-order errors in stiff constraints. Adds a
  // correction to the direction that removes them and hardly moves anything else (Levenberg, Marquardt), and evaluates
  // the candidate there. False: it does not help; the direction is unchanged.
  [[nodiscard]] bool restore(const Step& step, const springnet_state& candidate);
  // Greatest force of a residual, N.
  [[nodiscard]] static double greatest_force(const Step& step, const std::vector<double>& residual);
  [[nodiscard]] bool is_good(const Step& step, double slope) const;
  // Makes the candidate a whole step without a shift. False: it is not good enough; with kept derivatives it must
  // reduce the residual, with fresh ones is_good() decides.
  [[nodiscard]] bool try_whole_step(const Step& step, const springnet_state& candidate);
  void search(Step& step, const springnet_state& candidate);
  void relax_shift() noexcept;
  // Outputs with P = p* + w U at the positions where the step's propagation starts.
  void start_at_rest(const Step& step, const springnet_state& candidate);
  void compare_forces(Step& step);
  // Whether a node belongs to rigid connections without contact.
  [[nodiscard]] bool joined_without_contact(const Step& step, std::size_t node) const noexcept;
  // Whether other bodies push a node that is not held: its positions are as of a free one.
  [[nodiscard]] bool is_pushed(const Step& step, std::size_t node) const noexcept {
    return step.is_pushed(node) && pinned_[node] == 0;
  }
  // Whether a node that is not held has rigid connections or is on a surface, now or at the start of the step.
  [[nodiscard]] bool is_partly_constrained(const Step& step, std::size_t node) const noexcept;

  Workspace& work_;
  LinearSystem system_;
  Extrapolation extrapolation_;
  Assessment at_outputs_, at_candidate_;
  std::vector<std::uint8_t> pinned_;            // [n] 1: held, fixed or prescribed
  std::vector<std::uint8_t> was_pinned_;        // [n] pinned_ before the host's last decision
  std::vector<std::uint8_t> status_;            // [n] SPRINGNET_FREE …, likewise
  std::vector<std::uint8_t> pushed_;            // [n] SPRINGNET_NEAR …, likewise; empty without bodies in contact
  std::vector<std::uint8_t> in_contact_;        // [cluster] 1: it has contact, or had in this step; also with bodies
  double shift_ = 0.0;                          // mu
  double kept_rate_ = 1.0;                      // slowest reduction with these derivatives
  double last_accuracy_ = 1.0;                  // of the last linear solve
  double rate_ = 1.0;                           // reduction of the norm in the last sweep; 1 if contacts changed
  bool linearised_ = false;                     // derivatives exist, of this sweep, an earlier one or an earlier step
  bool fresh_ = false;                          // derivatives are at the newest outputs, up to corrections by settle()
  bool at_rejected_ = false;                    // derivatives are at a candidate that restore() rejected
  bool first_ = false;                          // first sweep of a step
  bool guessed_ = false;                        // that step starts from a guess
  int exact_steps_ = 0;                         // in which the linear system is to be exact
  bool switched_ = false;                       // contacts changed in the last settle()
  int slow_sweeps_ = 0;                         // in turn, with derivatives of their own
  int approximate_steps_ = 0;                   // in which it is not to be
  bool is_exact_ = false;                       // the prepared system
  int age_ = 0;                                 // steps since the derivatives were computed
  bool is_solved_ = false;                      // the linear system was solved
  std::vector<double> right_side_, direction_;  // [3n] b, delta
  std::vector<double> uncorrected_, correction_;   // [3n] delta before restore(), and its correction
  std::vector<double> gap_, work_values_;          // [3n] (p* + w U - P) / w
  std::vector<double> plain_;                      // [6n] U, then P, of a state without following
  std::vector<double> kept_acceleration_;          // [3n] without constraints, before the host moved nodes, m/s^2
  std::vector<std::uint32_t> contacts_;            // nodes in contact, held or sliding
  Columns contact_acceleration_;                   // [contacts] without constraints, m/s^2
  std::vector<double> inertia_;                    // [n][3][3] kg, effective mass for the host's corrections
  std::vector<double> by_velocity_, by_position_;  // [n][3][3], of contact_acceleration_
  std::uint64_t last_switch_ = 0;                  // sweep of the step that changed contacts
  double norm_at_half_ = 0.0;                      // some sweeps ago: see is_about_to_settle()
  double norm_at_start_ = 0.0;                     // of the residual where the step started, kg^1/2 m/s
  double norm_at_change_ = 0.0;                    // of the residual, kg^1/2 m/s, after the last of these
  std::uint64_t contact_changes_ = 0;              // sweeps of the step that changed contacts
  std::uint64_t decisions_ = 0;  // settle() that left contacts open, or changed more than what goes on sliding
};

}  // namespace springnet::recurrent
