// Contact of bodies in the sweeps of the recurrent network, inside the fixed point of a step:
//
//   U = U_free + W sum w J,   P = p* + theta h U,   gaps(P) >= 0,   J >= 0 only where the gap is 0,
//
// with W the inverse of the inertia of the update rule, and of each pair the weights w of its nodes and the direction
// at P. The impulses J are kept from sweep to sweep: nodes have them when others read their outputs, and the end of a
// sweep changes them by what its outputs still overlap. So the fixed point does not depend on W, and every rule has the
// same. Friction lies in Coulomb's cone and ends the slip of U. At the commit pairs that touch approach no more
// (PairEnding): within the step a node that arrives has the velocity that takes it there.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "constraints/pair_rows.hpp"
#include "simulation/model.hpp"
#include "simulation/pair_ending.hpp"

namespace springnet {

class SweepPairs {
 public:
  explicit SweepPairs(Model& model) : model_(model) {}

  // With the pairs that touch at the committed state.
  void begin_step();
  // Around a sweep that may leave constraint forces as the one before left them: takes out those of bodies, and puts
  // them back.
  void take_out(const springnet_sweep& sweep);
  void put_back(const springnet_sweep& sweep);
  // Keeps bodies apart in the outputs of a sweep, which all other constraints have been applied to.
  // of_newton: a sweep that solved for all nodes at once.
  void constrain(const springnet_sweep& sweep, bool of_newton);
  // Before these outputs of the last sweep are committed (m): SPRINGNET_RECOVERABLE, with a message, if bodies overlap.
  springnet_status check(const springnet_vectors& position);
  // At the committed outputs of the last sweep. before: the state at the start of the step.
  springnet_status commit(const State& before);

 private:
  using Key = std::pair<proximity::PairKind, proximity::Pair>;
  struct Known {
    proximity::Separation at;  // when they met, or at the start of the step
    double thickness;          // m
    double came;               // m/s, at the start of the step; 0 of a pair that touched then
  };
  void add(proximity::PairKind kind, proximity::Pair pair, const proximity::Separation& met);
  void add(const springnet_sweep& sweep, proximity::PairKind kind, proximity::Pair pair,
           const proximity::Separation& met);
  // Adds rows of pairs that overlap in the outputs, or meet on the way there. Returns whether there were any.
  bool find(const springnet_sweep& sweep);
  // The gap of a row, m, which takes directions and weights from these positions.
  [[nodiscard]] double renew(std::size_t row, const springnet_vectors& position);
  // Its speed after the step, m/s, at which it flies apart; from its velocities at the end.
  [[nodiscard]] double rebound(std::size_t row, const springnet_vectors& velocity) const;
  void know_inertia(const springnet_sweep& sweep, const PairRow& row);
  void know_clusters(const springnet_sweep& sweep, const Placement& at);
  void keep_lengths(const springnet_sweep& sweep, const Placement& at);
  [[nodiscard]] MovedNodes moved(const springnet_sweep& sweep) const;
  // Gives nodes the impulses that the rows have now.
  void push(const springnet_sweep& sweep);
  void store_pushes();
  // For linear systems. velocity: of the outputs; weight: theta h, s.
  void store_rows(const springnet_vectors& velocity, double weight);
  [[nodiscard]] bool is_finite(const springnet_sweep& sweep) const;
  void find_impulses(const MovedNodes& nodes, double weight, const PairAccuracy& accuracy);
  void add_obstacles(const springnet_sweep& sweep, const Placement& at);
  void note_slips();
  springnet_status fail(const std::string& why, const char* or_else = "") const;
  bool loosen(const PairRow& row);
  bool renew_row(std::size_t row, const springnet_sweep& sweep, const Placement& at, const MovedNodes& nodes,
                 const PairTolerances& tolerance);

  Model& model_;
  struct Reaction {
    std::size_t surface;
    Vector3 before;  // N s, as its own constraint found it
  };
  std::vector<PairRow> rows_;                         // of pairs; within a sweep then of reactions_
  std::vector<Known> contacts_;                       // [pair]
  std::vector<Reaction> reactions_;                   // of obstacles
  std::map<std::uint32_t, OnObstacle> on_obstacles_;  // that are not among these
  std::set<Key> known_;
  std::vector<double> mobility_;  // [node] 1/kg; empty before the first pair
  std::vector<Matrix3> blocks_;   // likewise, of rules whose effective masses have directions
  ClusterResponses clusters_;     // of nodes with rigid connections
  // Clusters that answer as if no obstacles held them, because these would not let a pair come apart.
  std::set<std::uint32_t> loose_;
  std::vector<Vector3> added_;  // [node] N, to constraint forces
  std::vector<proximity::NearPair> near_;
  std::vector<proximity::MeetingPair> met_;
  int sweeps_ = 0;               // of the step
  double friction_share_ = 1.0;  // by which friction follows
  std::size_t kept_ = 0;         // pairs whose directions and weights stay in this sweep
  std::string no_list_;          // why there is no list of neighbours for the outputs; empty: there is
  double length_ = 0.0;          // s, of the last sweep's step
};

}  // namespace springnet
