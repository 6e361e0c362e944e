#include "constraints/pair_newton.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SparseLU>

#include "constraints/row_groups.hpp"
#include "constraints/vectors.hpp"

namespace springnet {
namespace {

// Weights of the proximal term, in units of the mobility of a row.
constexpr double first_share = 1e-3, least_share = 1e-12, most_share = 1.0, growth = 10.0;
// Proximal points of a step, steps of Newton's method for each, and points in turn none of which is `noticeable` times
// as far from a solution as the best one before.
constexpr int most_points = 40, most_steps = 12, patience = 4;
constexpr double noticeable = 0.5;
// How exact a proximal point is, in units of its distance from a solution.
constexpr double inexact = 0.01;
constexpr int most_failures = 3;
// A group that is given up keeps what was found only if its distance from a solution is this share of that before.
constexpr double much_nearer = 1e-2;
// Groups with more unknowns, or more ends of rows on the same nodes and clusters, are left to the iteration, and all
// after so many unknowns of factorisations: these take longer than it needs.
constexpr int most_unknowns = 3000;
constexpr std::size_t most_shared_ends = 2000, most_work = 100000;  // the first for each row
// Factors of so many unknowns are dense.
constexpr int dense = 240;

Matrix3 axes_of(const PairRow& row) {
  Matrix3 axes;
  const Vector3 across = row.normal.unitOrthogonal();
  axes << row.normal, across, row.normal.cross(across);
  return axes;
}

}  // namespace

PairNewton::PairNewton(std::vector<PairRow>& rows, const MovedNodes& nodes, double length)
    : rows_(rows), nodes_(nodes), length_(length) {
  find_groups();
}

void PairNewton::find_groups() {
  RowGroups groups(rows_.size());
  for (std::uint32_t r = 0; r < rows_.size(); ++r) {
    const PairRow& row = rows_[r];
    if (row.is_done || row.is_blocked) continue;
    for (int i = 0; i < row.count; ++i) {
      const std::uint32_t node = row.nodes[static_cast<std::size_t>(i)];
      if ((*nodes_.mobility)[node] == 0.0) continue;
      const ClusterResponses::Place* const place = nodes_.in_cluster(node);
      groups.connect(r, place != nullptr ? RowGroups::Part(true, place->cluster) : RowGroups::Part(false, node));
    }
  }
  for (std::vector<std::uint32_t>& rows : groups.groups()) groups_.emplace_back().rows = std::move(rows);
}

// 1/kg, of one of its nodes that moves alone, to the impulse that the row gives it.
Matrix3 PairNewton::response_of(const PairRow& row, std::size_t place) const {
  const std::uint32_t node = row.nodes[place];
  const double own = (*nodes_.mobility)[node];
  const Matrix3 free =
      nodes_.blocks == nullptr || own == 0.0 ? Matrix3(own * Matrix3::Identity()) : Matrix3((*nodes_.blocks)[node]);
  const OnObstacle* const on = held_back(row, place, nodes_);
  if (on == nullptr) return free;
  if (on->sticks) return Matrix3::Zero();
  return free - on->normal * (on->normal.transpose() * free);
}

void PairNewton::couple(Group& group) const {
  struct End {
    std::uint32_t row;  // of the group
    std::size_t place;  // of the node
    Matrix3 response;
  };
  std::map<std::uint32_t, std::vector<End>> alone, in_cluster;  // by node, by cluster
  std::vector<Matrix3>& axes = group.axes;
  for (std::uint32_t g = 0; g < group.rows.size(); ++g) {
    const PairRow& row = rows_[group.rows[g]];
    axes.push_back(axes_of(row));
    for (int i = 0; i < row.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (row.weights[k] * (*nodes_.mobility)[row.nodes[k]] == 0.0) continue;
      if (const ClusterResponses::Place* const place = nodes_.in_cluster(row.nodes[k]))
        in_cluster[place->cluster].push_back({g, k, Matrix3::Zero()});
      else
        alone[row.nodes[k]].push_back({g, k, response_of(row, k)});
    }
  }
  std::size_t shared_ends = 0;
  for (const auto* parts : {&alone, &in_cluster})
    for (const auto& [part, ends] : *parts) shared_ends += ends.size() * ends.size();
  group.is_given_up = shared_ends > most_shared_ends * group.rows.size();
  if (group.is_given_up) return;
  std::vector<std::vector<Coupling>> of_row(group.rows.size());
  const auto add = [&](const End& to, const End& from, const Matrix3& response) {
    std::vector<Coupling>& known = of_row[to.row];
    auto found = std::find_if(known.begin(), known.end(), [&](const Coupling& each) { return each.from == from.row; });
    if (found == known.end()) found = known.insert(found, {to.row, from.row, Matrix3::Zero()});
    const double weight = rows_[group.rows[to.row]].weights[to.place] * rows_[group.rows[from.row]].weights[from.place];
    found->response += weight * response;
  };
  for (const auto& [node, ends] : alone)
    for (const End& to : ends)
      for (const End& from : ends) add(to, from, from.response);
  for (const auto& [number, ends] : in_cluster)
    for (const End& to : ends)
      for (const End& from : ends)
        add(to, from,
            nodes_.clusters->between(*nodes_.in_cluster(rows_[group.rows[to.row]].nodes[to.place]),
                                     *nodes_.in_cluster(rows_[group.rows[from.row]].nodes[from.place])));
  for (std::vector<Coupling>& known : of_row)
    for (Coupling& each : known) {
      const PairRow &moved = rows_[group.rows[each.to]], &pushed = rows_[group.rows[each.from]];
      each.response = (axes[each.to].transpose() * each.response * axes[each.from]).eval();
      if (!moved.by_rate) each.response.row(0) *= pushed.lever / moved.lever;
      group.couplings.push_back(each);
    }
}

PairNewton::Point PairNewton::point_of(const Group& group) const {
  const auto count = static_cast<Eigen::Index>(group.rows.size());
  Point at{Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count)};
  for (Eigen::Index g = 0; g < count; ++g) {
    const PairRow& row = rows_[group.rows[static_cast<std::size_t>(g)]];
    const Matrix3& axes = group.axes[static_cast<std::size_t>(g)];
    at.impulses.col(g) = axes.transpose() * row.impulse;
    at.rates.col(g) = axes.transpose() * (relative(row, nodes_.velocity) - row.ground);
    at.rates(0, g) = row.by_rate ? row.value + at.rates(0, g)
                                 : (row.value + row.normal.dot(relative(row, nodes_.position))) / row.lever;
  }
  return at;
}

void PairNewton::take(const Group& group, const Point& at) {
  for (std::size_t g = 0; g < group.rows.size(); ++g) {
    PairRow& row = rows_[group.rows[g]];
    const Vector3 impulse = group.axes[g] * at.impulses.col(static_cast<Eigen::Index>(g));
    const Vector3 change = impulse - row.impulse;
    row.impulse = impulse;
    if (!change.isZero(0.0)) apply(row, change, nodes_);
  }
}

void PairNewton::move(const Group& group, const Eigen::Matrix3Xd& changes, Point& at) {
  at.impulses += changes;
  for (const Coupling& each : group.couplings) at.rates.col(each.to) += each.response * changes.col(each.from);
}

double PairNewton::distance(const Group& group, const Point& at) const {
  double greatest = 0.0;
  for (std::size_t g = 0; g < group.rows.size(); ++g) {
    const PairRow& row = rows_[group.rows[g]];
    const Vector3 impulse = at.impulses.col(static_cast<Eigen::Index>(g)),
                  rate = at.rates.col(static_cast<Eigen::Index>(g));
    const double along = std::max(row.least, impulse[0] - rate[0] / row.mobility);
    Eigen::Vector2d across = Eigen::Vector2d::Zero();
    if (row.keeps_across && along > 0.0) {
      across = impulse.tail<2>();
    } else if (row.friction > 0.0 && along > 0.0) {
      across = impulse.tail<2>() - rate.tail<2>() / row.across;
      const double size = across.norm(), limit = row.friction * along;
      if (size > limit) across *= limit / size;
    }
    const double change = std::hypot(along - impulse[0], (across - impulse.tail<2>()).norm());
    const double answer = row.coupled.isZero(0.0) ? row.mobility : row.across;
    const double moves = change * answer * (row.by_rate ? length_ : row.lever);
    if (!(moves <= greatest)) greatest = moves;  // not a number, too
  }
  return greatest;
}

PairNewton::Point PairNewton::pulled(const Group& group, const Point& at, const Point& centre, double share) const {
  Point result = at;
  for (std::size_t g = 0; g < group.rows.size(); ++g) {
    const PairRow& row = rows_[group.rows[g]];
    const auto c = static_cast<Eigen::Index>(g);
    const Vector3 change = at.impulses.col(c) - centre.impulses.col(c);
    result.rates.col(c) += share * Vector3(row.mobility * change[0], row.across * change[1], row.across * change[2]);
  }
  return result;
}

int PairNewton::classify(const Group& group, const Point& centre, double share, Point& at) {
  locals_.assign(group.rows.size(), {});
  const Point now = pulled(group, at, centre, share);
  Eigen::Matrix3Xd changes = Eigen::Matrix3Xd::Zero(3, now.impulses.cols());
  int unknowns = 0;
  for (std::size_t g = 0; g < group.rows.size(); ++g) {
    const PairRow& row = rows_[group.rows[g]];
    Local& local = locals_[g];
    const auto c = static_cast<Eigen::Index>(g);
    const Vector3 impulse = now.impulses.col(c), rate = now.rates.col(c);
    const bool presses = impulse[0] - rate[0] / row.mobility > row.least;
    if (!presses && !(row.least > 0.0)) {
      changes.col(c) = Vector3(row.least, 0.0, 0.0) - impulse;
      continue;
    }
    const double along = presses ? impulse[0] : row.least;
    const bool has_friction = row.friction > 0.0 && !(row.least < 0.0 && along <= 0.0);
    local.is_fixed = !presses;
    changes(0, c) = along - impulse[0];
    local.normal = unknowns++;
    if (row.keeps_across && (along > 0.0 || row.least >= 0.0)) continue;
    if (!has_friction) {
      changes.col(c).tail<2>() = -impulse.tail<2>();
      continue;
    }
    local.across = unknowns;
    unknowns += 2;
    local.trial = impulse.tail<2>() - rate.tail<2>() / row.across;
    local.slips = std::isfinite(row.friction) && local.trial.norm() > row.friction * std::max(0.0, along);
  }
  move(group, changes, at);
  return unknowns;
}

bool PairNewton::solve(const Group& group, const Point& centre, double share, int unknowns, Point& at) const {
  const Point now = pulled(group, at, centre, share);
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right_side = Eigen::VectorXd::Zero(unknowns);
  std::vector<Eigen::Matrix2d> turns(group.rows.size(), Eigen::Matrix2d::Identity());  // of what slips
  for (std::size_t g = 0; g < group.rows.size(); ++g) {
    const PairRow& row = rows_[group.rows[g]];
    const Local& local = locals_[g];
    if (local.normal < 0) continue;
    const auto c = static_cast<Eigen::Index>(g);
    const Vector3 impulse = now.impulses.col(c), rate = now.rates.col(c);
    entries.emplace_back(local.normal, local.normal, local.is_fixed ? 1.0 : share);
    if (!local.is_fixed) right_side[local.normal] = -rate[0] / row.mobility;
    if (local.across < 0) continue;
    Eigen::Matrix2d own = share * Eigen::Matrix2d::Identity();
    if (local.slips) {
      const double size = local.trial.norm(), limit = row.friction * std::max(0.0, impulse[0]);
      const Eigen::Vector2d direction = local.trial / size;
      turns[g] = limit / size * (Eigen::Matrix2d::Identity() - direction * direction.transpose());
      own = Eigen::Matrix2d::Identity() - (1.0 - share) * turns[g];
      right_side.segment<2>(local.across) = limit * direction - impulse.tail<2>();
      for (int i = 0; i < 2; ++i) entries.emplace_back(local.across + i, local.normal, -row.friction * direction[i]);
    } else {
      right_side.segment<2>(local.across) = -rate.tail<2>() / row.across;
    }
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) entries.emplace_back(local.across + i, local.across + j, own(i, j));
  }
  for (const Coupling& each : group.couplings) {
    const Local &to = locals_[each.to], &from = locals_[each.from];
    if (to.normal < 0 || from.normal < 0) continue;
    const PairRow& moved = rows_[group.rows[each.to]];
    Matrix3 part = each.response;
    part.row(0) /= moved.mobility;
    part.bottomRows<2>() = (turns[each.to] * part.bottomRows<2>() / moved.across).eval();
    for (int i = 0; i < 3; ++i) {
      if (i == 0 ? to.is_fixed : to.across < 0) continue;
      for (int j = 0; j < 3; ++j)
        if (j == 0 || from.across >= 0)
          entries.emplace_back(i == 0 ? to.normal : to.across + i - 1, j == 0 ? from.normal : from.across + j - 1,
                               part(i, j));
    }
  }
  Eigen::VectorXd solution;
  if (unknowns <= dense) {
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(unknowns, unknowns);
    for (const Eigen::Triplet<double>& each : entries) matrix(each.row(), each.col()) += each.value();
    solution = matrix.partialPivLu().solve(right_side);
  } else {
    Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> factors(matrix);
    if (factors.info() != Eigen::Success) return false;
    solution = factors.solve(right_side);
  }
  if (!solution.allFinite()) return false;
  Eigen::Matrix3Xd changes = Eigen::Matrix3Xd::Zero(3, now.impulses.cols());
  for (std::size_t g = 0; g < group.rows.size(); ++g) {
    const Local& local = locals_[g];
    const auto c = static_cast<Eigen::Index>(g);
    if (local.normal >= 0) changes(0, c) = solution[local.normal];
    if (local.across >= 0) changes.col(c).tail<2>() = solution.segment<2>(local.across);
  }
  move(group, changes, at);
  return true;
}

// The proximal point of a centre.
bool PairNewton::solve_near(Group& group, const Point& centre, double share, double wanted, Point& at) {
  at = centre;
  for (int i = 0; i < most_steps; ++i) {
    const int unknowns = classify(group, centre, share, at);
    group.work += static_cast<std::size_t>(unknowns);
    if (unknowns > most_unknowns || group.work > most_work) {
      group.is_given_up = true;
      return false;
    }
    if (unknowns > 0 && !solve(group, centre, share, unknowns, at)) return false;
    const double left = distance(group, pulled(group, at, centre, share));
    if (!std::isfinite(left)) return false;
    if (left <= std::max(0.1 * wanted, inexact * distance(group, at))) return true;
  }
  return false;
}

double PairNewton::improve(Group& group, Point& at, double wanted) {
  Point centre = at, next;
  double share = first_share, best = distance(group, at), noted = best;
  int stalled = 0;
  for (int i = 0; i < most_points && best > wanted && stalled < patience; ++i, ++stalled) {
    if (!solve_near(group, centre, share, wanted, next)) {
      if (share >= most_share || group.is_given_up) break;
      share = std::min(most_share, growth * share);
      continue;
    }
    centre = next;
    share = std::max(least_share, share / growth);
    if (const double now = distance(group, centre); now < best) {
      best = now;
      at = centre;
    }
    if (best < noticeable * noted) {
      noted = best;
      stalled = -1;
    }
  }
  return best;
}

void PairNewton::begin(Group& group) {
  couple(group);
  const Point at = point_of(group);
  group.before = at.impulses;
  group.far = distance(group, at);
}

bool PairNewton::step(const std::vector<double>& changes, double wanted) {
  bool any = false;
  for (Group& group : groups_) {
    if (group.is_given_up) continue;
    double greatest = 0.0;
    for (const std::uint32_t r : group.rows) greatest = std::max(greatest, changes[r]);
    if (greatest <= wanted) continue;
    if (group.axes.empty()) begin(group);
    if (group.is_given_up) continue;
    Point at = point_of(group);
    if (distance(group, at) <= wanted) continue;
    const double now = improve(group, at, wanted);
    if (now > wanted && ++group.failures == most_failures) group.is_given_up = true;
    // Where no impulses fit, those that come near may be huge.
    if (group.is_given_up && !(now <= much_nearer * group.far)) at.impulses = group.before;
    take(group, at);
    any = true;
  }
  return any;
}

}  // namespace springnet
