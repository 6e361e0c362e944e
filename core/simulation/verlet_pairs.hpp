// Contact of bodies in a step of velocity Verlet, as VerletContact has it for obstacles:
//
//   drift   u = v + W (h/2 F + sum w J),   P = p + h v + … ,   gaps(P) >= 0
//   kick    V = u + W (h/2 F' + sum w K),  rates of gaps >= 0 for pairs that touch at P
//
// The impulses of pairs that touch at p act there; those of pairs that meet within the step act when they meet, so that
// momentum and angular momentum are kept by each, and the rest of the step goes with the velocities after it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "constraints/pair_rows.hpp"
#include "simulation/model.hpp"
#include "simulation/pair_ending.hpp"
#include "simulation/verlet_clusters.hpp"
#include "simulation/verlet_contact.hpp"

namespace springnet {

class VerletPairs {
 public:
  // From the committed state, in a step of this length (s).
  VerletPairs(Model& model, double until, double length);

  // step.next_position, next_velocity: P and u without contact. `constrain_others` has obstacles act on what is there,
  // which has these impulses of bodies already.
  using ConstrainOthers = std::function<springnet_status(const VerletContact::Pushes&)>;
  springnet_status drift(const springnet_sweep& step, const ConstrainOthers& constrain_others);
  // step.next_velocity: V, likewise. Commits the pairs that touch.
  springnet_status kick(const springnet_sweep& step);
  // Whether this is the step between these times (s), and its kick is still to come.
  [[nodiscard]] bool is_of(double from, double until) const noexcept {
    return !kicked_ && from == from_ && until == until_;
  }

 private:
  static constexpr double simultaneous = 1e-9;  // share of the step within which impacts are at the same time
  struct Contact {
    Vector3 side;            // direction of the pair while it has not gone through
    double thickness;        // m
    double time;             // when they met, as a share of the step
    bool is_impact;          // they met within the step
    bool bounces;            // and fly apart
    bool is_fast = false;    // faster than forces are within a step
    bool passes_on = false;  // or they touched before, and pass on an impact of others
    double least = 0.0;      // N s, along the normal: that of the row until its impact is over
  };

  // Adds rows of pairs that touch or overlap on the way to these positions and have none. Returns whether there are
  // any.
  bool find(const springnet_sweep& step);
  void add(const springnet_sweep& step, proximity::PairKind kind, proximity::Pair pair, const proximity::Separation& at,
           double share, bool is_new);
  // Adds rows of pairs that met_ and near_ have: of each node, and of each cluster, the first, if it is due.
  void add_first(const springnet_sweep& step, const proximity::Positions& start, const proximity::Positions& end);
  struct MeetingNodes {
    std::array<std::uint32_t, 4> nodes;
    double time;  // share of the step
  };
  // [meeting] 1: it is to happen now. In the order of time.
  [[nodiscard]] std::vector<std::uint8_t> in_order(const std::vector<MeetingNodes>& meetings) const;
  // Adds rows of pairs that touched before these impacts and pass them on when they happen. Their first rows keep the
  // impulses that they have.
  void pass_on(const springnet_sweep& step, std::size_t first_impact, const proximity::Positions& start,
               const proximity::Positions& end);
  void finish_impacts(const springnet_sweep& step);
  // Obstacles have taken hold of rigid bodies, or let them go: impacts are to be found again.
  void reopen_impacts();
  springnet_status keep_apart(const springnet_sweep& step, const ConstrainOthers& constrain_others);
  [[nodiscard]] MovedNodes moved(const springnet_sweep& step) const;
  void note_obstacles(const springnet_sweep& step, bool of_drift);
  [[nodiscard]] VerletContact::Pushes pushes(const springnet_sweep& step) const;
  // On the side on which it met.
  [[nodiscard]] proximity::Separation separation_at(std::size_t row, const springnet_vectors& position) const;
  [[nodiscard]] double gap(std::size_t row, const springnet_vectors& position) const;
  [[nodiscard]] double own_gap(std::size_t row, const springnet_vectors& position) const;
  // The clusters of a pair's nodes are to answer impulses on them from this share of the step on. Returns whether any
  // did not.
  bool strike(const springnet_sweep& step, proximity::PairKind kind, proximity::Pair pair, double share);
  // What the rows can move, after that changed.
  void renew_mobility(const springnet_sweep& step);
  void set_blocked(const springnet_sweep& step);
  // Obstacles hold the nodes of a pair, yet it overlaps: its clusters are to give way, as far as obstacles then let
  // them. Returns whether any did not.
  bool loosen(const PairRow& row);
  // Impulses until no pair overlaps at the end of the step.
  springnet_status separate(const springnet_sweep& step);
  springnet_status fail() const;
  // SPRINGNET_RECOVERABLE, with a message, if bodies overlap at the end of the step.
  springnet_status check(const springnet_sweep& step) const;

  Model& model_;
  double from_, until_, h_;  // s
  bool kicked_ = false;
  PairTolerances tolerance_;
  std::vector<double> mobility_;  // [node] 1/kg
  VerletClusters clusters_;
  std::vector<PairRow> rows_;
  std::vector<Contact> contacts_;  // [row]
  std::set<std::pair<proximity::PairKind, proximity::Pair>> known_;
  // m, [node]: where straight paths to the end begin; of nodes after an impact not where they were. Empty: no impact.
  std::array<std::vector<double>, 3> start_;
  // m/s, [node]: of half a step of the forces, without contact of bodies. Empty until it is asked for.
  struct {
    std::vector<double> values;
    [[nodiscard]] springnet_vectors vectors() noexcept {
      const std::size_t n = values.size() / 3;
      return {values.data(), values.data() + n, values.data() + 2 * n};
    }
  } gained_;
  std::map<std::uint32_t, OnObstacle> on_obstacles_;
  std::map<std::pair<proximity::PairKind, proximity::Pair>, int> bounces_;  // within the step
  std::map<std::uint32_t, double> struck_;  // [node] share of the step of its last impact
  int rounds_ = 0;                          // of finding pairs
  std::vector<proximity::NearPair> near_;
  std::vector<proximity::MeetingPair> met_;
};

}  // namespace springnet
