// Newton's method on the impulses of pairs that Gauss-Seidel iteration approaches too slowly, as of faces on faces,
// whose pairs are redundant. On the equations of P. Alart and A. Curnier (Comput. Methods Appl. Mech. Engrg. 92 (1991)
// 353), which hold where that iteration ends: J_n = max(least, J_n - gap / W_n), and J_t = the point of the disc of
// radius friction J_n nearest to J_t - slip / W_t. Redundant pairs have no unique impulses, and where their gaps do not
// fit each other exactly the right ones are hard to tell from others: so the equations are solved with gaps and slips
// that grow a little with what impulses change, from where they are, and again from there (proximal points; R. T.
// Rockafellar, SIAM J. Control Optim. 14 (1976) 877), the less the better that goes.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "constraints/pair_rows.hpp"

namespace springnet {

class PairNewton {
 public:
  // Of rows whose directions, weights and mobilities stay as they are. length: of the step, s.
  PairNewton(std::vector<PairRow>& rows, const MovedNodes& nodes, double length);
  // Solves groups of rows that move the same nodes, as far as they have one that the last iteration changed by more
  // than `wanted`, m. changes: [row] m. Those that some steps do not solve are left to the iteration from then on.
  // Returns whether any impulse has changed.
  bool step(const std::vector<double>& changes, double wanted);

 private:
  // What the impulse of one row of a group changes of the velocity of another, 1/kg, in their directions.
  struct Coupling {
    std::uint32_t to, from;
    Matrix3 response;
  };
  struct Group {
    std::vector<std::uint32_t> rows;
    std::vector<Matrix3> axes;        // of rows, columns: their normals, and two across; empty before its first step
    std::vector<Coupling> couplings;  // rows of gaps: over the lever
    Eigen::Matrix3Xd before;          // N s, impulses before its first step, in those directions
    double far = 0.0;                 // m, distance from a solution then
    int failures = 0;                 // steps that left it unsolved
    std::size_t work = 0;             // unknowns of all factorisations
    bool is_given_up = false;
  };
  // Of a row, in its directions.
  struct Local {
    int normal = -1;        // number of the unknown; -1: none
    int across = -1;        // of the first of two
    bool is_fixed = false;  // the first of them is known
    bool slips = false;
    Eigen::Vector2d trial = Eigen::Vector2d::Zero();  // N s, J_t - slip / W_t
  };
  // Impulses of a group, N s, and rates of gaps and slips with them, m/s.
  struct Point {
    Eigen::Matrix3Xd impulses, rates;
  };

  void find_groups();
  void begin(Group& group);
  void couple(Group& group) const;
  [[nodiscard]] Matrix3 response_of(const PairRow& row, std::size_t place) const;
  [[nodiscard]] Point point_of(const Group& group) const;
  void take(const Group& group, const Point& at);
  static void move(const Group& group, const Eigen::Matrix3Xd& changes, Point& at);
  // m, the greatest change of a gap or slip by one more iteration.
  [[nodiscard]] double distance(const Group& group, const Point& at) const;
  // Rates that grow with what impulses have changed from `centre`.
  [[nodiscard]] Point pulled(const Group& group, const Point& at, const Point& centre, double share) const;
  // Moves to the nearest point to a solution that it finds. Returns its distance.
  [[nodiscard]] double improve(Group& group, Point& at, double wanted);
  [[nodiscard]] bool solve_near(Group& group, const Point& centre, double share, double wanted, Point& at);
  // Decides which rows press, stick and slip, and gives those that do not press the impulse that they have then.
  // Returns the number of unknowns.
  int classify(const Group& group, const Point& centre, double share, Point& at);
  [[nodiscard]] bool solve(const Group& group, const Point& centre, double share, int unknowns, Point& at) const;

  std::vector<PairRow>& rows_;
  const MovedNodes& nodes_;
  double length_;
  std::vector<Group> groups_;
  std::vector<Local> locals_;  // [row of a group]
};

}  // namespace springnet
