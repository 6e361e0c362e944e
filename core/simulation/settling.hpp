// Decides contacts at one time: which nodes touch, separate, slip or come to rest. Works island by island: a node, or
// all nodes that rigid connections join; where events are located, also all pairs of bodies that share nodes or
// clusters.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "constraints/island.hpp"
#include "simulation/body_groups.hpp"
#include "simulation/model.hpp"
#include "simulation/reactions_at.hpp"
#include "simulation/struck_clusters.hpp"

namespace springnet {

// Findings of an integrator about a node.
struct Finding {
  std::vector<std::int32_t> touched, released;  // surfaces
  bool slips = false;                           // friction can no longer hold it
  bool slip_ended = false;
};

// The same about a pair of bodies.
struct PairFinding {
  bool released = false, slips = false, slip_ended = false;
  bool at_border = false;  // of the features between which it touches
};

struct Findings {
  std::map<std::uint32_t, Finding> nodes;
  std::map<std::pair<proximity::PairKind, proximity::Pair>, PairFinding> pairs;
};

// Decides the contacts of these nodes and pairs, and of all that is connected to them, at `time` (s), and changes
// `state` accordingly.
springnet_status settle(Model& model, double time, State& state, const Findings& findings);

class Settling {
 public:
  Settling(Model& model, double time, State& state, const Findings& findings);
  // Settles the island of a node, unless that was done already.
  springnet_status settle(std::uint32_t node);
  // Those of pairs.
  springnet_status settle_pairs();
  // Makes velocities and lengths satisfy the constraints again if anything changed.
  springnet_status finish();
  // The slip of a node is about to end: friction keeps its direction from now on.
  void keep_direction(std::uint32_t node);

 private:
  // Uncertainty of positions in the reference, at least, in units of the length scale.
  static constexpr double uncertain = 1e-8, shallow = 1e-7;
  [[nodiscard]] const Finding& finding(std::uint32_t node) const;
  void restore_sticking();
  [[nodiscard]] std::vector<ContactNode> gather() const;
  // Adds the obstacles that a node touches, or may touch now.
  void add_sides(ContactNode& node) const;
  // Separating, or comes to rest within the position tolerance: an impact would take away the motion that the node has.
  [[nodiscard]] bool turns_round(std::uint32_t node, const ContactSide& side) const;
  // Accelerations without obstacles, at the present velocities.
  springnet_status accelerate(Island& island);
  // True once a node has touched too often in a short time; counts the touches.
  [[nodiscard]] bool chatters(const Island& island);
  // True once a pair of the group has begun to slip and stuck too often in a short time; counts that.
  [[nodiscard]] bool flutters();
  // Speed that nodes gain towards obstacles in a few of the user's steps, m/s; 0 if the integrator chooses its own
  // steps.
  [[nodiscard]] double fall_in_step(Island& island);
  // Twice the speed that nodes gain in a fall of this depth (m), m/s; slower motions are not resolved where this is the
  // contact tolerance or, of bodies, whose touches only positions tell, the uncertainty of these.
  [[nodiscard]] double fall_through(Island& island, double depth);
  [[nodiscard]] double uncertainty() const noexcept;  // m
  // Approach speed above which nodes rebound, m/s.
  [[nodiscard]] double rebound_of(Island& island);
  bool stop_held(Island& island, double slow) const;
  // Applies the impulses of the island to velocities.
  void apply_impulses(const Island& island);
  void spread(const std::map<std::uint32_t, Vector3>& impulses);  // [node] N s
  // If no forces satisfy the contacts: slips with friction that are no faster than integration errors, or rocking, come
  // to rest and stick. A contact that holds too much takes energy; friction of a pulling contact would add some.
  // slow: m/s, of slips that come to rest.
  springnet_status stop_and_stick(Island& island, double negligible, double slow,
                                  std::vector<std::vector<Vector3>>& impulses);
  // Finds which nodes slip, and in which direction, from their velocities.
  void find_slips(Island& island) const;
  void begin_slips(Island& island) const;
  // came: m/s, its velocity before the impulses.
  void commit_contact(const ContactNode& node, const Vector3& came);
  void part(std::uint32_t node, const ContactSide& side);
  void set_slip(std::uint32_t node, const Vector3& direction, Contact::Slip phase);
  // acceleration, and its rounding: m/s^2.
  void find_phase(const ContactNode& node, const Vector3& acceleration, double negligible);

  // ---- pairs of bodies, in settling_pairs.cpp ----
  // A pair that touches, or may touch now.
  struct Candidate {
    PairMotion motion;
    PairTouch touch;          // as it is, or will be
    bool was = false;         // it touched before
    bool stays = false;       // it touches
    bool ends = false;        // its slip, soon
    bool takes_over = false;  // from another one
    PairFinding found;
  };
  void gather_candidates();
  // Finds between which features pairs touch, and leaves those out that others say. In settling_borders.cpp.
  void find_features();
  void join_grooves();
  void leave_out_said();
  void take_over(Candidate& pair, const Candidate& from);
  [[nodiscard]] PairMotion motion_of(const Candidate& candidate) const;  // at the present state
  void add_pairs(std::vector<ContactNode>& nodes) const;
  // Of a pair: what an impulse changes of velocities, m/s, or in its place a push, N s^2, of positions, m.
  void apply_impulse(const Candidate& pair, const Vector3& impulse);
  void displace(const Candidate& pair, const Vector3& push);
  void move(const std::map<std::uint32_t, Vector3>& pushes);  // [node] kg m
  // Ends the overlaps of pairs of an island that touch; they keep the gaps that this leaves. response: D.
  void push_apart(const Island& island, const Eigen::MatrixXd& response);
  void commit_pair(const ContactNode& node, const Vector3& came);
  void keep_slip_of_pair(ContactNode& node, double friction) const;
  void find_phase_of_pair(const ContactNode& node, const Vector3& acceleration, double negligible);
  [[nodiscard]] bool is_known(const ContactNode& node, const ContactSide& side) const;  // in contact before
  // Whether a pair that parted a moment ago only seems to approach: see turns_round.
  [[nodiscard]] bool comes_back(const Candidate& pair, double speed) const;
  void put_pairs();
  [[nodiscard]] Eigen::MatrixXd mobility(const std::vector<ContactNode>& nodes) const;

  Model& model_;
  double time_;
  State& state_;
  const Findings& findings_;
  std::shared_ptr<const Placement> at_;
  double depth_;                    // m
  double no_speed_;                 // m/s
  double jump_;                     // m/s: smaller velocity differences are integration errors
  double creep_;                    // m/s: slower slips of pairs are rounding of impulses that ended them
  std::vector<std::uint8_t> done_;  // [cluster]
  std::vector<std::uint32_t> members_;
  StruckClusters clusters_;  // of the members
  std::vector<std::uint32_t> stopped_;
  Rebounds rebounds_;
  bool struck_ = false;
  bool holds_ = false;  // friction of pairs of the island, whatever their cones
  bool gathered_ = false;
  std::vector<Candidate> candidates_;
  std::vector<BodyGroup> groups_;
  std::vector<std::uint8_t> group_done_;
  std::map<std::uint32_t, std::size_t> group_of_;  // [node]
  const BodyGroup* group_ = nullptr;               // of the island; null: it is none of bodies
};

}  // namespace springnet
