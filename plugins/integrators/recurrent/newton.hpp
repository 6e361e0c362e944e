// Newton's method on all nodes at once. With w = theta h, and c the forces of rigid connections, surfaces and friction,
// a sweep solves the linear system of the residual
//
//   r = U - v* - w (a(P, U) + c / m),   (I - w da/dv - w^2 da/dp + mu) delta = -r
//
// and goes to U + s delta, P + s w delta. The share s is 1 unless the slope m r.delta at the end, which is that of the
// potential m |U - v*|^2 / 2 + E(P) where one exists, says that the step went too far; mu is 0 unless delta does not
// lead downhill, as where springs buckle or laws soften, or no share of it was good. Before a step is shortened, what
// it did to stiff constraints at second order is put right: a filling as hard as water keeps its volume along delta to
// first order only. What rigid connections and sliding contacts do not allow is projected out of r and delta. Nodes
// stay held, or free, during the search; then the host puts the outputs where they belong and decides anew.
#pragma once

#include <cstdint>
#include <vector>

#include "linear_system.hpp"
#include "rule.hpp"

namespace springnet::recurrent {

class Newton final : public Rule {
 public:
  explicit Newton(Workspace& workspace) : work_(workspace), system_(workspace.host) {}
  void attach(const springnet_network& network) override;
  void begin(Step& step) override;
  void sweep(Step& step) override;
  [[nodiscard]] bool has_linear_sweep() const noexcept override { return false; }

 private:
  // How good outputs are. Arrays of 3 n numbers have x of all nodes first.
  struct Assessment {
    std::vector<double> free;      // [3n] U - v* - w a, m/s
    std::vector<double> residual;  // [3n] r, 0 where a node stays, m/s
    double norm = 0.0;             // sqrt(sum m |r|^2); infinite where forces are not finite
    double slope = 0.0;            // sum m r.delta
  };

  // Of outputs whose forces were evaluated.
  void assess(const Step& step, const springnet_state& state, Assessment& result);
  // From the outputs to the candidate, which becomes the outputs.
  void advance(Step& step, springnet_state& candidate);
  // Puts the newest outputs, whose assessment is here_, where they belong: what constraints do, who is held. Leaves the
  // state `before` alone.
  void settle(Step& step, const springnet_state* before);
  // Where nodes on surfaces would go if nothing held or constrained them, for the host to decide on.
  void free_contacts(const Step& step, const springnet_state& outputs, const springnet_state& free);
  bool find_stays(const Step& step);
  [[nodiscard]] double residual(const Step& step) const;  // N
  // The right side, and the derivatives unless those of an earlier sweep will do.
  void set_up(const Step& step);
  void linearise(const Step& step);
  void find_direction(const Step& step, double accuracy);
  // Outputs + share * direction, and its assessment.
  void go(const Step& step, double share, const springnet_state& candidate);
  // m r.direction at the outputs.
  [[nodiscard]] double slope_along(const Step& step, const std::vector<double>& direction) const;
  // After go() along the whole direction, to where the residual is many times larger: stiff constraints are off there
  // at second order. Adds to the direction what puts them right, and hardly moves anything else (Levenberg, Marquardt),
  // and goes there. False: that does not help; the direction is as it was.
  [[nodiscard]] bool restore(const Step& step, const springnet_state& candidate);
  // Of a residual, N.
  [[nodiscard]] static double greatest_force(const Step& step, const std::vector<double>& residual);
  [[nodiscard]] bool is_good(const Step& step, double slope) const;
  void search(Step& step, const springnet_state& candidate);
  // Outputs that obey P = p* + w U at the positions where the step's propagation starts.
  void start_at_rest(const Step& step, const springnet_state& candidate);
  void compare_forces(Step& step);
  // Of rigid connections that meet no surface.
  [[nodiscard]] bool joined_without_friction(const Step& step, std::size_t node) const noexcept;
  // Of rigid connections, or on a surface, and not held; also where it was on one when the step began.
  [[nodiscard]] bool is_partly_constrained(const Step& step, std::size_t node) const noexcept;

  Workspace& work_;
  LinearSystem system_;
  Assessment here_, there_;                        // at the outputs, at the candidate
  std::vector<std::uint8_t> stays_;                // [n] held, or the scene says where it is
  std::vector<std::uint8_t> was_held_;             // [n] stays_ before the host decided anew
  std::vector<std::uint8_t> status_;               // [n] SPRINGNET_FREE …, likewise
  std::vector<std::uint8_t> has_friction_;         // [cluster] a surface is there, or met in this step
  double shift_ = 0.0;                             // mu
  double rate_ = 1.0;                              // of the norm in the last sweep; 1 where contacts changed
  bool linearised_ = false;                        // there are derivatives, of this sweep or one before
  bool fresh_ = false;                             // they are of the newest outputs, up to what settle() corrects
  bool elsewhere_ = false;                         // they are of a candidate that restore() left
  bool first_ = false;                             // sweep of a step
  bool answered_ = false;                          // the linear system was solved
  std::vector<double> right_side_, direction_;     // [3n] b, delta
  std::vector<double> straight_, correction_;      // [3n] delta before it was corrected, what is added to it
  std::vector<double> gap_, work_values_;          // [3n] (p* + w U - P) / w
  std::vector<std::uint32_t> contacts_;            // nodes that surfaces hold or guide
  Columns contact_acceleration_;                   // of theirs, if nothing held them, m/s^2
  std::vector<double> inertia_;                    // [n][3][3] kg, what the host corrects outputs with
  std::vector<double> by_velocity_, by_position_;  // [n][3][3], of theirs
  int moved_ = 0;                                  // sweeps of the step in which contacts changed
};

}  // namespace springnet::recurrent
