// Nodes that hang together by rigid connections, seen from where they touch: what impulses and forces of surfaces do to
// all of them goes through their effective mass. A lone node is an island of one.
//
// With D the effective mobility (the matrix G W G^T of the contacts once rigid connections are eliminated), velocities
// and accelerations of the contact nodes answer impulses p and forces f by
//
//   v' = v + D p,   a = a_free + D f,
//
// and each surface asks for 0 <= gap rate, 0 <= normal force, one of them zero, with Coulomb's friction. Moreau,
// Unilateral contact and dry friction in finite freedom dynamics, CISM 302 (1988); Painlevé, C. R. Acad. Sci. 121
// (1895) for cases in which no finite force exists.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include <Eigen/Core>

#include <springnet/network.hpp>

#include "constraints/bracing.hpp"
#include "constraints/obstacle.hpp"

namespace springnet {

// A surface that a node touches, or may touch: its distance is zero.
struct ContactSide {
  std::int32_t surface = -1;
  Vector3 normal = Vector3::UnitZ();  // unit, to the free side
  Friction friction{};
  double restitution = 0.0;                        // 1
  Vector3 velocity = Vector3::Zero();              // m/s, of the node against the surface
  Vector3 surface_acceleration = Vector3::Zero();  // m/s^2, that the node has where it sticks
  double needed = 0.0;                             // m/s^2: normal acceleration that keeps the gap at zero
  bool touches = true;                             // it acts: a normal force, or none
  bool leaves = false;                             // the gap grows already: it cannot act
  bool stays = false;                              // it acts whatever the sign of its force
};

struct ContactNode {
  std::uint32_t node = 0;
  std::vector<ContactSide> sides;          // one to three
  Vector3 acceleration = Vector3::Zero();  // m/s^2, without surfaces
  bool sticks = false;                     // friction stops it, as far as it touches
  bool braced = false;             // it sticks, pressed on by forces that nodes that stick brace themselves with
  Vector3 slip = Vector3::Zero();  // unit: where it slides, or begins to
  bool moves = false;              // its slip has a speed, so that `slip` is given
  bool begins = false;             // its slip is so young that it goes where it is accelerated to
  bool rests = false;              // its slip has come to an end: what is left of it is stopped
  // results
  Vector3 force = Vector3::Zero();     // N, of all its surfaces
  std::vector<double> normal_force{};  // N, [side]
  std::vector<Vector3> impulse{};      // N s, [side]
};

// Whether the surfaces that a node touches move alike, to `negligible` m/s: others cannot take it along together.
[[nodiscard]] bool surfaces_move_alike(const ContactNode& node, double negligible);

// Of a force R on a node that touches surfaces with these normals (one to three): normal forces that make up its part
// across the directions in which the node can slide, and what is left along those.
struct SplitReaction {
  std::vector<double> normal;       // N
  Vector3 along = Vector3::Zero();  // N
};
[[nodiscard]] SplitReaction split_reaction(const std::vector<Vector3>& normals, const Vector3& reaction);

// Which of these surfaces make up R (N) such that none pulls: all if they do, else those that leave the least of it
// along them; none if all pull.
[[nodiscard]] std::vector<std::size_t> pressing_of(const std::vector<Vector3>& normals, const Vector3& reaction);

// What of R is each surface's, N, with these coefficients of friction: along all of them as their cones are.
[[nodiscard]] std::vector<Vector3> share_reaction(const std::vector<Vector3>& normals,
                                                  const std::vector<double>& coefficients, const Vector3& reaction);

class Island {
 public:
  // mobility: D, 1/kg, three rows and columns a node, symmetric positive semidefinite.
  Island(std::vector<ContactNode> nodes, Eigen::MatrixXd mobility);

  [[nodiscard]] std::vector<ContactNode>& nodes() noexcept { return nodes_; }
  [[nodiscard]] const std::vector<ContactNode>& nodes() const noexcept { return nodes_; }

  // Impulses that end all approach, with restitution (Newton: the gap grows as fast, times the coefficient, as it fell)
  // where it was faster than `rebound` (m/s). Approach that is slower than `negligible` (m/s) is rounding. Velocities
  // of the sides change. Returns whether there was an impulse. Impulses that depend on each other are sought in this
  // many rounds: of most_rounds what is left is rounding, of fewer a part of the step's own error. `begun`: they are
  // sought from those that the nodes have.
  static constexpr int most_rounds = 10'000;
  bool strike(double rebound, double negligible = 0.0, int rounds = most_rounds, bool begun = false);
  // m/s, of what comes nearest to its surface fastest.
  [[nodiscard]] double approach() const;
  // Impulses that end what is left of the slip of nodes that rest; gaps whose rates are no more than `negligible` (m/s)
  // stay as they are. Returns whether there was one.
  bool stop(double negligible);
  // Impulses, of either sign, that end what is slower than `slow` (m/s) of gaps' rates: bodies that rock from one
  // contact to the other and back do so infinitely often in a finite time, and then lie still.
  void calm(double slow);
  // Impulses that end the slip of the nodes named by the last resolve() that failed, where it is faster than
  // `negligible` (m/s). Returns whether any acts.
  bool jam(double negligible);
  // Finds which sides go on acting and which nodes stick, beginning with what is set, such that nothing pulls, no gap
  // shrinks and friction stays in its cone; forces are results. Forces below `negligible` (N) count as zero. False: no
  // finite forces do that; or, where `thoroughly` is not asked for, no choice of what acts was found that does.
  [[nodiscard]] bool resolve(double negligible, bool thoroughly = true);
  // The same of impulses over a step, that end all approach: nodes' and sides' accelerations are velocities, forces are
  // impulses. With Coulomb's friction such impulses exist; surfaces that hold keep what they touch where there are
  // none.
  [[nodiscard]] bool resolve_impulses(double negligible);
  // Where resolve() found none: what is set stays, whatever the signs of its forces, unless its gap would open without
  // it.
  void hold(double negligible);
  // Forces for what is set, whatever their signs.
  void solve();
  // A node that sticks begins to slip where its friction does not let it go any more, by the forces of solve().
  void begin_slip(std::size_t node);
  // A node on a surface that holds it slips only where the normal force vanishes. It is let go there, if its gap opens
  // without the forces of solve() on it; else false.
  bool let_go(std::size_t node);
  // m/s^2, of a node with the forces of the last solve().
  [[nodiscard]] Vector3 acceleration(std::size_t node) const;

 private:
  struct Violation;
  [[nodiscard]] Violation find_violation(double negligible) const;
  [[nodiscard]] std::uint64_t code() const;
  [[nodiscard]] std::size_t bit_count() const;  // of it
  void set_code(std::uint64_t code);
  [[nodiscard]] std::uint64_t braces() const;
  void solve_once();
  [[nodiscard]] std::optional<Vector3> slip_of(std::size_t node) const;
  // From what is set, one change after another; `changed` are the nodes that did. False: that comes back to where it
  // was.
  bool pivot(double negligible, std::set<std::size_t>& changed);
  bool try_all(double negligible);
  // Forces node by node until they agree, where no choice of what acts was found; `most` is the friction of surfaces
  // that hold, `from` the forces to begin with, if any. Sets what acts and the forces; false: no such forces.
  bool relax(double most, int rounds, const std::vector<Vector3>& from);
  [[nodiscard]] auto block(std::size_t row, std::size_t column) const {
    return mobility_.block<3, 3>(static_cast<Eigen::Index>(3 * row), static_cast<Eigen::Index>(3 * column));
  }
  void push(std::size_t node, const Vector3& impulse);  // changes velocities
  struct Row {
    std::size_t node, side;
    Vector3 direction;  // unit
  };
  void end_rates(const std::vector<Row>& rows);
  void stop_all(const std::vector<ContactNode>& start, double negligible);

  std::vector<ContactNode> nodes_;
  Eigen::MatrixXd mobility_;
  std::vector<std::size_t> jammed_;
  bool directions_fit_ = true;  // slips of the last solve() go where friction against them lets them
};

}  // namespace springnet
