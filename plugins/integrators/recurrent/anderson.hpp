// Anderson acceleration of the sweeps of a step.
//
// A sweep is a map G of the velocities U to new ones. Plain propagation puts its result back, U <- G(U). Here the last
// sweeps are combined: with x = sqrt(m) U, the residual f = sqrt(m) (G(U) - U), and the differences DX, DF of these
// between successive sweeps,
//
//   x <- x + b f - (DX + b DF) c,   c = argmin |f - DF c|
//
// (Walker and Ni, SIAM J. Numer. Anal. 49, 2011, 1715-1735). The fixed point stays the same. On a linear network, with
// all sweeps kept, this is GMRES, which does not need the spectral radius of G below 1. The damping b keeps what the
// differences do not span from growing: 2 / (1 + L) with L the greatest |DF| / |DX| seen in the step, at most 1.
//
// Nodes that move freely stay at P = p* + w U. Sliding and rigidly connected ones are combined too, but only as what
// the next sweep reads: a step ends with outputs of a sweep, as the host constrained them. Fixed, prescribed and
// sticking nodes keep theirs. A change of contact begins a new history. Nothing lives on from step to step. Sums are in
// one order, so results are the same for every number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "step.hpp"

namespace springnet::recurrent {

class Anderson {
 public:
  static constexpr std::size_t max_depth = 20;
  static constexpr int max_retreats = 8;  // in a step, then plain sweeps

  // depth: differences kept, up to max_depth; 0: none of the calls does anything.
  explicit Anderson(std::size_t depth) noexcept : depth_(depth) {}
  [[nodiscard]] bool is_on() const noexcept { return depth_ > 0; }
  [[nodiscard]] bool can_go_back() const noexcept { return is_on() && !given_up_ && retreats_ < max_retreats; }
  // Whether the last record() went back: the host then knows of contacts that the outputs do not have.
  [[nodiscard]] bool went_back() const noexcept { return went_back_; }

  // After every change of network.revision. Keeps 2 depth + 7 vectors of 3 numbers a node.
  void attach(const springnet_network& network);
  // Before the first sweep of a step, or of a stage of it. relaxes: whether the rule heeds step.relaxation.
  // changes_order: whether its sweeps take another order each, unless step.keeps_order.
  void begin(Step& step, bool relaxes, bool changes_order);
  // After a sweep. If the residual grew too much, or is not finite, the outputs go back to those of the sweep with the
  // smallest residual, or to the start, and step.relaxation is reduced. False: not finite, and that was tried.
  [[nodiscard]] bool record(Step& step);
  // Whether the last sweep found another contact than the one before.
  [[nodiscard]] bool contacts_changed() const noexcept { return contacts_changed_; }
  // Replaces the outputs of the last sweep by the combination, from which the next sweep starts.
  void mix(Step& step);

 private:
  // Nodes that are combined, and how. Returns whether they changed; common_ then has those that were and are.
  bool find_free(const Step& step);
  // Of this sweep and the last one. nodes: root_, or common_ if nodes changed: then only its slope counts.
  void add_difference(const std::vector<double>& nodes);
  // Coefficients c of the differences, newest first. Drops the oldest that the newer ones nearly span.
  void solve() noexcept;
  bool is_slow(double norm) noexcept;
  void keep_best(const springnet_state& outputs, double norm);
  void go_back(Step& step);
  // Free motion at the start's velocity, with prescribed nodes where the sweep put them.
  void go_to_start(Step& step) const;
  [[nodiscard]] std::size_t slot(std::size_t age) const noexcept { return (newest_ + depth_ - age) % depth_; }

  std::size_t depth_;
  std::vector<double> root_, common_;    // [node_count] sqrt(m), kg^1/2; 0: not combined
  std::vector<std::uint8_t> status_;     // [node_count]
  std::vector<double> input_;            // [3n] U that the last sweep read, x of all nodes first, m/s
  std::vector<double> last_input_;       // of the sweep before
  std::vector<double> residual_, next_;  // [3n] f of the last sweep, of this one
  std::vector<double> best_position_, best_velocity_, best_residual_;  // of the sweep with the smallest |f|
  std::vector<std::vector<double>> x_, f_;                             // [depth][3n] differences, in a ring
  std::array<std::array<double, max_depth>, max_depth> gram_{};        // DF^T DF, by slot
  std::array<double, max_depth> coefficients_{};                       // c, by age
  std::size_t count_ = 0, newest_ = 0;                                 // differences
  bool has_last_ = false;   // residual_ and input_ are those of a sweep that a difference can begin from
  bool first_ = true;       // the last sweep began with the outputs of the start, which do not satisfy P = p* + w U
  bool went_back_ = false;  // the outputs are those of the best sweep
  bool contacts_changed_ = false;
  bool given_up_ = false;   // plain sweeps for the rest of the step
  double best_norm_ = 0.0;  // |f|; infinite: there is no best sweep
  double greatest_norm_ = 0.0;
  double start_norm_ = 0.0;      // of the first sweep
  double steepest_ = 0.0;        // L
  double later_steepest_ = 0.0;  // but for the first difference
  std::size_t slopes_ = 0;       // differences that steepest_ is from
  bool relaxes_ = false, changes_order_ = false;
  double milestone_ = 0.0;    // |f|
  int since_milestone_ = 0;   // sweeps
  double damping_ = 1.0;      // b
  double max_damping_ = 1.0;  // halved whenever outputs go back
  int retreats_ = 0, stalls_ = 0, since_best_ = 0;
};

}  // namespace springnet::recurrent
