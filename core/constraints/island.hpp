// An island: the contact nodes of one cluster of rigidly connected nodes, which contact impulses and forces couple
// through their effective mass. A node without rigid connections is an island of one.
//
// With D the effective mobility (the matrix G W G^T of the contacts after elimination of the rigid connections),
// velocities and accelerations of the contact nodes respond to impulses p and forces f by
//
//   v' = v + D p,   a = a_free + D f,
//
// and each contact requires 0 <= gap rate, 0 <= normal force, one of them zero, with Coulomb friction. Moreau,
// Unilateral contact and dry friction in finite freedom dynamics, CISM 302 (1988); for cases without a finite force,
// Painlevé, C. R. Acad. Sci. 121 (1895).
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

// One contact of a node with a surface, active or not; its gap is zero.
struct ContactSide {
  std::int32_t surface = -1;
  Vector3 normal = Vector3::UnitZ();  // unit, to the free side
  Friction friction{};
  double restitution = 0.0;                        // 1
  Vector3 velocity = Vector3::Zero();              // m/s, of the node relative to the surface
  Vector3 surface_acceleration = Vector3::Zero();  // m/s^2, of the node if it sticks
  double target_acceleration = 0.0;                // m/s^2, along the normal: keeps the gap zero
  bool active = true;                              // in the active set: may exert a force
  bool separating = false;                         // cannot become active
  bool pinned = false;                             // active whatever the sign of its normal force
};

struct ContactNode {
  std::uint32_t node = 0;
  std::vector<ContactSide> sides;          // one to three
  Vector3 acceleration = Vector3::Zero();  // m/s^2, without contact forces
  bool sticks = false;                     // on all active sides
  bool braced = false;                     // sticks, pressed on by internal forces between sticking nodes
  Vector3 slip = Vector3::Zero();          // unit: direction in which it slides or begins to slide
  bool slipping = false;                   // at a speed: `slip` is the direction of its slip velocity
  bool slip_starting = false;              // without speed yet: the slip follows the acceleration
  bool slid = false;                       // before the impulses of this moment
  bool slip_ended = false;                 // end_slip() removes what is left of its slip velocity
  std::int32_t pair = -1;                  // of a pair of bodies, which is as a node on one side, its place
  // results
  Vector3 force = Vector3::Zero();     // N, sum over its surfaces
  std::vector<double> normal_force{};  // N, [side]
  std::vector<Vector3> impulse{};      // N s, [side]
};

// Whether the surfaces of a node's active sides have the same velocity, to `negligible` m/s. Only then can the node
// stick to all.
[[nodiscard]] bool surfaces_move_alike(const ContactNode& node, double negligible);

// Splits the reaction (N) of surfaces with these normals (one to three): normal forces, and the rest along the
// directions in which the node can slide.
struct SplitReaction {
  std::vector<double> normal;            // N
  Vector3 tangential = Vector3::Zero();  // N
};
[[nodiscard]] SplitReaction split_reaction(const std::vector<Vector3>& normals, const Vector3& reaction);

// The surfaces whose normal forces make up the reaction (N) without any pulling: all of them if possible, else the
// subset with the smallest tangential rest; empty if all pull.
[[nodiscard]] std::vector<std::size_t> pressing_surfaces(const std::vector<Vector3>& normals, const Vector3& reaction);

// Each surface's share of the reaction, N; the tangential part is divided in proportion to the friction limits.
[[nodiscard]] std::vector<Vector3> share_reaction(const std::vector<Vector3>& normals,
                                                  const std::vector<double>& coefficients, const Vector3& reaction);

class Island {
 public:
  // mobility: D, 1/kg, three rows and columns a node, symmetric positive semidefinite.
  Island(std::vector<ContactNode> nodes, Eigen::MatrixXd mobility);

  [[nodiscard]] std::vector<ContactNode>& nodes() noexcept { return nodes_; }
  [[nodiscard]] const std::vector<ContactNode>& nodes() const noexcept { return nodes_; }

  // Applies impulses that end all approach, with Newton's restitution (gap rate after = -coefficient times gap rate
  // before) where it was faster than `rebound` (m/s). Approach slower than `negligible` (m/s) counts as rounding.
  // Changes the velocities of the sides; returns whether there was an impulse. Coupled impulses are iterated for up to
  // `rounds` rounds: max_rounds leave rounding, fewer leave a part of the step's own error. `warm_start`: the iteration
  // starts from the nodes' present impulses.
  static constexpr int max_rounds = 10'000;
  bool apply_impact(double rebound, double negligible = 0.0, int rounds = max_rounds, bool warm_start = false);
  // The greatest approach speed, m/s.
  [[nodiscard]] double approach() const;
  // Applies impulses that end the remaining slip of nodes with `slip_ended`. Gap rates up to `negligible` (m/s) become
  // zero, so that no contact opens or closes. Returns whether there was an impulse.
  bool end_slip(double negligible);
  // Applies impulses of either sign that end gap rates below `slow` (m/s). A body that rocks between contacts does so
  // infinitely often in a finite time and then rests.
  // pulls: also by impulses that pull.
  void end_rocking(double slow, bool pulls = true);
  // Of bodies on each other: impulses of either sign that end separations whose contacts the forces of the last
  // resolve() would close again before the gap is `depth` (m) wide. There are infinitely many in a finite time. Other
  // rates of contacts that touch stay zero. Returns whether there was one.
  bool end_returns(double depth);
  // Of bodies on each other: the same of slips that the forces of the last resolve() would end within this distance
  // (m): a small impact leaves some in all pairs around it. began: only of those that were not there before or are no
  // faster than `slow` (m/s). Slower ones than `negligible` (m/s) are none. Returns whether there was one.
  bool end_short_slips(double distance, bool began, double slow, double negligible);
  // Applies jamming impulses: they end slip faster than `negligible` (m/s) of the nodes for which the last resolve()
  // failed. Returns whether there was one.
  bool jam(double negligible);
  // Finds the active set and the sticking nodes, starting from the present ones, and the forces: no side pulls, no gap
  // closes, friction stays in its cone. Forces below `negligible` (N) count as zero. False: no finite forces exist, or
  // (unless `thoroughly`) the search found none.
  [[nodiscard]] bool resolve(double negligible, bool thoroughly = true);
  // The same for impulses over a step that end all approach: accelerations of nodes and sides are velocities, forces
  // are impulses. With Coulomb friction such impulses exist. With holding surfaces they may not; then the present
  // active set stays.
  [[nodiscard]] bool resolve_impulses(double negligible);
  // After resolve() failed: keeps the present active set whatever the signs of the forces; releases a pulling side only
  // if its gap opens without it.
  void hold(double negligible);
  // Solves for the forces of the present active set, whatever their signs. keeps_slips: friction that is great enough
  // to hold a node that slips opposes the force that would, so that its slip passes through zero as a smooth function;
  // unless that is against the direction in which it slips at present.
  void solve(bool keeps_slips = false);
  // Makes a sticking node slip against its tangential force of the last solve().
  void begin_slip(std::size_t node);
  // Releases a node that would slip on a holding surface, which happens only where the normal force vanishes. False,
  // without release, if its gap does not open without its force of the last solve().
  bool release_held(std::size_t node);
  // m/s^2, of a node with the forces of the last solve().
  [[nodiscard]] Vector3 acceleration(std::size_t node) const;

 private:
  struct Violation;
  [[nodiscard]] Violation find_violation(double negligible) const;
  [[nodiscard]] std::uint64_t active_set() const;  // a bit a side, and one a node that sticks
  [[nodiscard]] std::size_t bit_count() const;     // of the active set
  void set_active_set(std::uint64_t bits);
  [[nodiscard]] std::uint64_t braced_set() const;
  static constexpr double singular = 1e-9;  // of pivots, in units of the greatest
  // A force of the active set, of which the acceleration along `row` is to be `target` (m/s^2); it acts along `column`.
  struct Unknown {
    static constexpr std::size_t no_side = 3;
    std::size_t node;
    Vector3 row, column;
    double target;
    std::size_t side;  // of a normal force
  };
  [[nodiscard]] std::vector<Unknown> unknowns(std::optional<std::size_t> without = {}) const;
  // 1/kg, accelerations along rows by forces along columns.
  [[nodiscard]] Eigen::MatrixXd response(const std::vector<Unknown>& unknowns) const;
  void solve_once();
  // A node on a single surface, with the active set of all others: its mobility, to which their forces belong, and its
  // acceleration relative to the one that it has to have, without its own force.
  struct Alone {
    const ContactSide& side;
    Matrix3 mobility;
    Vector3 relative;
  };
  [[nodiscard]] std::optional<Alone> alone(std::size_t node) const;
  [[nodiscard]] bool follow_slips(bool may_reverse, bool by_difference);
  [[nodiscard]] Eigen::MatrixXd by_turns(const std::vector<std::size_t>& turning) const;
  [[nodiscard]] Vector3 slides(std::size_t node) const;
  [[nodiscard]] std::optional<Vector3> slip_of(std::size_t node) const;
  [[nodiscard]] std::optional<Vector3> reversed_slip(std::size_t node) const;
  // Pivots from the present active set, one change at a time; `changed` collects the nodes that change. False: it
  // cycles.
  bool pivot(double negligible, std::set<std::size_t>& changed);
  bool enumerate(double negligible);
  // Block Gauss-Seidel iteration, for cases in which pivoting found no active set. `held_coefficient` replaces that
  // of holding surfaces; `from`: starting forces, if any. Sets the active set and the forces; false if it does not
  // converge.
  bool relax(double held_coefficient, int rounds, const std::vector<Vector3>& from);
  bool solves_as_relaxed();  // after relax()
  void keep_touching(const std::vector<ContactNode>& before, double negligible);
  [[nodiscard]] auto block(std::size_t row, std::size_t column) const {
    return mobility_.block<3, 3>(static_cast<Eigen::Index>(3 * row), static_cast<Eigen::Index>(3 * column));
  }
  void apply_impulse(std::size_t node, const Vector3& impulse);  // changes velocities
  struct Row {
    std::size_t node, side;
    Vector3 direction;  // unit
  };
  [[nodiscard]] std::vector<Row> kept_rows() const;
  void add_across(std::size_t node, std::vector<Row>& rows) const;  // of the directions in which it can slide
  void end_rates(const std::vector<Row>& rows);
  void stop_all(const std::vector<ContactNode>& start, double negligible);

  std::vector<ContactNode> nodes_;
  Eigen::MatrixXd mobility_;
  std::vector<std::size_t> jammed_;
  bool has_pairs_ = false;
  bool directions_fit_ = true;  // slip directions of the last solve() have converged
};

}  // namespace springnet
