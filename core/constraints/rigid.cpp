#include "constraints/rigid.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <map>
#include <numeric>

#include "constraints/cluster.hpp"
#include "constraints/vectors.hpp"
#include "plugin_host/message.hpp"

namespace springnet {
namespace {

// Relative accuracy of a corrected length: far below the guaranteed 1e-8, above rounding.
constexpr double length_accuracy = 1e-12;
constexpr int max_corrections = 30;

// From a rod's second end to its first.
Vector3 direction(const Vector3& first, const Vector3& second) {
  const Vector3 d = first - second;
  const double length = d.norm();
  return length > 0.0 ? Vector3(d / length) : Vector3::UnitX();
}

ConstraintRow row_along(const RigidConnections::Rod& rod, const springnet_const_vectors& position) {
  return {rod.first, rod.second, direction(vector_at(position, rod.first), vector_at(position, rod.second))};
}

}  // namespace

RigidConnections::RigidConnections(const Network& network, const std::vector<std::uint32_t>& user_number,
                                   const std::vector<std::uint32_t>& engine_number, const std::vector<double>& mass,
                                   Contact& contact)
    : mass_(mass), contact_(contact), user_number_(user_number) {
  if (network.rigids().empty()) return;
  const std::size_t nodes = engine_number.size();
  std::vector<std::uint32_t> rank(nodes), parent(nodes);
  boost::disjoint_sets<std::uint32_t*, std::uint32_t*> sets(rank.data(), parent.data());
  for (std::uint32_t k = 0; k < nodes; ++k) sets.make_set(k);
  for (const Rigid& rigid : network.rigids()) {
    rods_.push_back({engine_number[rigid.first], engine_number[rigid.second], rigid.length});
    sets.union_set(rods_.back().first, rods_.back().second);
  }
  cluster_of_.assign(nodes, no_cluster);
  member_of_.assign(nodes, 0);
  std::vector<std::uint8_t> joined(nodes, 0);
  for (const Rod& rod : rods_) joined[rod.first] = joined[rod.second] = 1;
  std::map<std::uint32_t, std::uint32_t> number;
  for (std::uint32_t k = 0; k < nodes; ++k) {
    if (joined[k] == 0) continue;
    const auto [found, is_new] = number.emplace(sets.find_set(k), static_cast<std::uint32_t>(clusters_.size()));
    if (is_new) clusters_.emplace_back();
    Cluster& cluster = clusters_[found->second];
    cluster_of_[k] = found->second;
    member_of_[k] = static_cast<std::uint32_t>(cluster.nodes.size());
    cluster.nodes.push_back(k);
  }
  for (std::uint32_t r = 0; r < rods_.size(); ++r) clusters_[cluster_of_[rods_[r].first]].rods.push_back(r);
}

Eigen::Matrix3d RigidConnections::mobility(std::uint32_t node) const {
  if (contact_.constrained()[node] != 0) return Eigen::Matrix3d::Zero();
  return Eigen::Matrix3d::Identity() / mass_[node];
}

std::vector<ConstraintRow> RigidConnections::rods_of(const Cluster& cluster,
                                                     const std::vector<Vector3>& positions) const {
  std::vector<ConstraintRow> rows;
  rows.reserve(cluster.rods.size());
  for (const std::uint32_t r : cluster.rods) {
    const Rod& rod = rods_[r];
    rows.push_back(
        {rod.first, rod.second, direction(positions[member_of_[rod.first]], positions[member_of_[rod.second]])});
  }
  return rows;
}

std::vector<ConstraintRow> RigidConnections::rows_of(const Placement& at, const Cluster& cluster,
                                                     const std::vector<Touch>& touches,
                                                     const std::vector<Vector3>& positions) const {
  std::vector<ConstraintRow> rows = rods_of(cluster, positions);
  for (std::size_t i = 0; i < cluster.nodes.size(); ++i) {
    if (!touches[i].slides) continue;
    for (const std::int32_t surface : touches[i].surfaces())
      if (surface >= 0)
        rows.push_back({cluster.nodes[i], ConstraintRow::no_node,
                        contact_.normal(at, static_cast<std::size_t>(surface), positions[i]), surface});
  }
  return rows;
}

bool RigidConnections::correct_positions(const Placement& at, const Cluster& cluster, const std::vector<Touch>& touches,
                                         std::vector<Vector3>& positions,
                                         const std::vector<std::uint8_t>& movable) const {
  double scale = 0.0;
  for (const std::uint32_t r : cluster.rods) scale = std::max(scale, rods_[r].length);
  const auto mobility = [&](std::uint32_t node) -> Eigen::Matrix3d {
    if (movable[member_of_[node]] == 0) return Eigen::Matrix3d::Zero();
    return Eigen::Matrix3d::Identity() / mass_[node];
  };
  ConstraintSystem system;
  double last = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < max_corrections; ++iteration) {
    std::vector<ConstraintRow> rows = rows_of(at, cluster, touches, positions);
    Eigen::VectorXd gap(static_cast<Eigen::Index>(rows.size()));
    double worst = 0.0;  // relative to the length, for surfaces to the longest one
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      if (r < cluster.rods.size()) {
        const Rod& rod = rods_[cluster.rods[r]];
        gap[row] = (positions[member_of_[rod.first]] - positions[member_of_[rod.second]]).norm() - rod.length;
        worst = std::max(worst, std::abs(gap[row]) / rod.length);
      } else {
        const std::uint32_t i = member_of_[rows[r].first];
        gap[row] = contact_.gap(at, static_cast<std::size_t>(rows[r].surface), positions[i]);
        worst = std::max(worst, std::abs(gap[row]) / scale);
      }
    }
    if (!std::isfinite(worst)) return false;
    if (worst <= length_accuracy) return true;
    // Far from the origin only rounding is left.
    if (worst <= 1e-10 && worst >= 0.5 * last) return true;
    last = worst;
    system.set(std::move(rows), mobility);
    system.for_each_change(system.solve(-gap),
                           [&](std::uint32_t node, const Vector3& change) { positions[member_of_[node]] += change; });
  }
  return last <= 1e-9;
}

springnet_status RigidConnections::fail_lengths(const Cluster& cluster, springnet_message& message) const {
  const Rod& rod = rods_[cluster.rods.front()];
  std::vector<std::int32_t> touched;
  for (const std::uint32_t k : cluster.nodes)
    for (const std::int32_t surface : contact_.now(k).surfaces())
      if (surface >= 0 && std::find(touched.begin(), touched.end(), surface) == touched.end())
        touched.push_back(surface);
  std::sort(touched.begin(), touched.end());
  set_message(
      message,
      fmt::format("the rigid connections of the {} nodes in the cluster of connection {} (nodes {} and "
                  "{}) cannot keep their lengths: fixed nodes, prescribed motions or contacts pull them apart{}; "
                  "check the motions there, or use a smaller time step",
                  cluster.nodes.size(), cluster.rods.front(), user_number_[rod.first], user_number_[rod.second],
                  touched.size() < 2
                      ? ""
                      : fmt::format(", or there is no room left for them between {}", contact_.names_of(touched))));
  return SPRINGNET_RECOVERABLE;
}

void RigidConnections::accelerate(const Placement& at, std::size_t number, const springnet_const_vectors& position,
                                  const springnet_const_vectors& velocity, const springnet_vectors& acceleration,
                                  double* force, std::uint32_t without) const {
  const Cluster& cluster = clusters_[number];
  const std::size_t count = cluster.nodes.size();
  std::vector<Vector3> p(count), free(count), a(count);
  std::vector<Touch> touches(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t k = cluster.nodes[i];
    p[i] = vector_at(position, k);
    free[i] = vector_at(acceleration, k);
    if (k != without) touches[i] = contact_.now(k);
  }
  ConstraintSystem system;
  system.set(rows_of(at, cluster, touches, p), [&](std::uint32_t node) {
    return node == without ? Matrix3(Matrix3::Identity() / mass_[node]) : Matrix3(mobility(node));
  });
  const std::vector<ConstraintRow>& rows = system.rows();
  const std::size_t rods = cluster.rods.size();
  // d^2 g / dt^2 = G a + bias; for a rod of length l: (|dv|^2 - (n dv)^2) / l.
  Eigen::VectorXd bias(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto row = static_cast<Eigen::Index>(r);
    const Vector3 n = rows[r].direction;
    if (r < rods) {
      const Vector3 dv = vector_at(velocity, rows[r].first) - vector_at(velocity, rows[r].second);
      const double length = (p[member_of_[rows[r].first]] - p[member_of_[rows[r].second]]).norm();
      bias[row] = (dv.squaredNorm() - n.dot(dv) * n.dot(dv)) / length;
    } else {
      const std::uint32_t i = member_of_[rows[r].first];
      const auto j = static_cast<std::size_t>(rows[r].surface);
      bias[row] =
          contact_.bias_acceleration(at, j, p[i], vector_at(velocity, rows[r].first) - Contact::velocity(at, j, p[i])) -
          n.dot(Contact::acceleration(at, j, p[i]));
    }
  }
  const auto rates_of = [&](const std::vector<Vector3>& of) {
    return system.rates([&](std::uint32_t node) -> const Vector3& { return of[member_of_[node]]; });
  };
  const Eigen::VectorXd without_friction = system.solve(-bias - rates_of(free));
  Eigen::VectorXd multipliers = without_friction;
  // Friction is proportional to normal forces N and changes them: N = N_0 + Y N, with N_0 without friction and Y the
  // response of normal forces to the friction of unit normal forces.
  struct FrictionRow {
    Eigen::Index row;
    std::uint32_t member;
    double share;                       // m/s^2, at a normal force of 1 N
    Vector3 against = Vector3::Zero();  // unit
    Eigen::VectorXd response{};         // of the multipliers to the friction of a normal force of 1 N
  };
  std::vector<FrictionRow> friction_rows;
  const auto set_direction = [&](FrictionRow& each, const Vector3& against) {
    std::vector<Vector3> changes(count, Vector3::Zero());
    changes[each.member] = -each.share * against;
    each.against = against;
    each.response = system.solve(-rates_of(changes));
  };
  for (std::size_t r = rods; r < rows.size(); ++r) {
    const std::uint32_t i = member_of_[rows[r].first];
    const auto j = static_cast<std::size_t>(rows[r].surface);
    const double mu = sliding_coefficient_of(contact_.obstacles()[j].friction());
    if (mu == 0.0) continue;
    friction_rows.push_back({static_cast<Eigen::Index>(r), i, mu / mass_[rows[r].first]});
    set_direction(friction_rows.back(),
                  contact_.slip_direction(at, rows[r].first, j, p[i], vector_at(velocity, rows[r].first)));
  }
  const auto finish = [&] {
    a = free;
    multipliers = without_friction;
    const auto size = static_cast<Eigen::Index>(friction_rows.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(size, size);
    Eigen::VectorXd pressing(size);
    for (Eigen::Index r = 0; r < size; ++r) {
      const Eigen::Index row = friction_rows[static_cast<std::size_t>(r)].row;
      pressing[r] = without_friction[row];
      for (Eigen::Index c = 0; c < size; ++c) matrix(r, c) -= friction_rows[static_cast<std::size_t>(c)].response[row];
    }
    pressing = matrix.partialPivLu().solve(pressing).eval();
    for (Eigen::Index r = 0; r < size; ++r) {
      const FrictionRow& each = friction_rows[static_cast<std::size_t>(r)];
      a[each.member] -= pressing[r] * each.share * each.against;
      multipliers += pressing[r] * each.response;
    }
    system.for_each_change(multipliers,
                           [&](std::uint32_t node, const Vector3& change) { a[member_of_[node]] += change; });
  };
  finish();
  // Beginning slip is parallel to the sliding acceleration, which friction opposes.
  for (FrictionRow& each : friction_rows) {
    const ConstraintRow& row = rows[static_cast<std::size_t>(each.row)];
    if (contact_.slip_phase(row.first) != Contact::Slip::starting || contact_.now(row.first).second >= 0) continue;
    const auto j = static_cast<std::size_t>(row.surface);
    if (sliding_coefficient_of(contact_.obstacles()[j].friction()) >= friction_of_held) continue;
    const Vector3 n = row.direction, kept = each.against;
    const auto found = find_direction(n, kept, [&](const Vector3& against) {
      set_direction(each, against);
      finish();
      return n.dot(against.cross(a[each.member] - Contact::acceleration(at, j, p[each.member])));
    });
    set_direction(each, found && found->dot(kept) > 0.5 ? *found : kept);
    finish();
  }
  for (std::size_t i = 0; i < count; ++i) put_vector(acceleration, cluster.nodes[i], a[i]);
  // A multiplier above 0 pushes the ends apart.
  for (std::size_t r = 0; force != nullptr && r < rods; ++r)
    force[cluster.rods[r]] = -multipliers[static_cast<Eigen::Index>(r)];
}

Vector3 RigidConnections::connection_force(std::uint32_t node, const springnet_const_vectors& position,
                                           const double* force) const {
  Vector3 sum = Vector3::Zero();
  for (const std::uint32_t r : clusters_[cluster_of_[node]].rods) {
    const Rod& rod = rods_[r];
    if (rod.first != node && rod.second != node) continue;
    const std::uint32_t other = rod.first == node ? rod.second : rod.first;
    sum += force[r] * (vector_at(position, other) - vector_at(position, node)).normalized();
  }
  return sum;
}

void RigidConnections::find_fixed_impulses(std::size_t cluster, const springnet_const_vectors& position,
                                           std::vector<Vector3>& impulses) const {
  const std::vector<std::uint32_t>& nodes = clusters_[cluster].nodes;
  std::vector<Vector3> p;
  for (const std::uint32_t k : nodes) p.push_back(vector_at(position, k));
  ConstraintSystem system;
  system.set(rods_of(clusters_[cluster], p), [this](std::uint32_t node) {
    return contact_.fixed()[node] != 0 ? Matrix3(Matrix3::Zero()) : Matrix3(Matrix3::Identity() / mass_[node]);
  });
  const auto given = [&](std::uint32_t node) {
    return contact_.fixed()[node] != 0 ? Vector3(Vector3::Zero()) : Vector3(impulses[member_of_[node]] / mass_[node]);
  };
  const Eigen::VectorXd multipliers = system.solve(system.rates(given));
  for (const std::uint32_t k : nodes)
    if (contact_.fixed()[k] != 0) impulses[member_of_[k]].setZero();
  system.for_each_impulse(multipliers, [&](std::uint32_t node, const Vector3& impulse) {
    if (contact_.fixed()[node] != 0) impulses[member_of_[node]] += impulse;
  });
}

springnet_status RigidConnections::project(const Placement& at, std::size_t number, const springnet_vectors& position,
                                           const springnet_vectors& velocity, springnet_message& message,
                                           const std::vector<std::uint32_t>& stopped, const Rebounds& rebounds) const {
  const Cluster& cluster = clusters_[number];
  const std::size_t count = cluster.nodes.size();
  std::vector<Vector3> p(count);
  std::vector<Touch> touches(count), sliding(count);
  std::vector<std::uint8_t> movable(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t k = cluster.nodes[i];
    p[i] = vector_at(position, k);
    touches[i] = sliding[i] = contact_.now(k);
    movable[i] = contact_.constrained()[k] == 0 ? 1 : 0;
    if (contact_.fixed()[k] != 0 || std::find(stopped.begin(), stopped.end(), k) == stopped.end()) continue;
    sliding[i].slides = true;
    movable[i] = 1;
  }
  // Rebounding nodes start on their surfaces if the lengths allow.
  std::vector<Touch> rebounding = sliding;
  for (std::size_t i = 0; i < count; ++i) {
    const auto found = rebounds.find(cluster.nodes[i]);
    if (found == rebounds.end() || movable[i] == 0) continue;
    for (const std::int32_t surface : found->second)
      rebounding[i] = after(rebounding[i], {ContactCause::Kind::touch, surface});
  }
  const std::vector<Vector3> before = p;
  if (rebounding == sliding || !correct_positions(at, cluster, rebounding, p, movable)) {
    p = before;
    if (!correct_positions(at, cluster, sliding, p, movable)) return fail_lengths(cluster, message);
  }
  for (std::size_t i = 0; i < count; ++i) put_vector(position, cluster.nodes[i], p[i]);
  ConstraintSystem system;
  system.set(rows_of(at, cluster, touches, p), [this](std::uint32_t node) { return mobility(node); });
  const Eigen::VectorXd rates =
      system.rates([&](std::uint32_t node) { return vector_at(velocity, node); },
                   [&](const ConstraintRow& row) {
                     return Contact::velocity(at, static_cast<std::size_t>(row.surface), p[member_of_[row.first]]);
                   });
  system.for_each_change(system.solve(-rates), [&](std::uint32_t node, const Vector3& change) {
    put_vector(velocity, node, vector_at(velocity, node) + change);
  });
  return SPRINGNET_OK;
}

RigidConnections::WithoutContact::WithoutContact(const RigidConnections& rigid, std::size_t cluster,
                                                 const springnet_const_vectors& position)
    : rigid_(rigid), nodes_(rigid.clusters_[cluster].nodes), rods_(rigid.clusters_[cluster].rods) {
  std::vector<Vector3> p;
  p.reserve(nodes_.size());
  for (const std::uint32_t k : nodes_) p.push_back(vector_at(position, k));
  system_.set(rigid.rods_of(rigid.clusters_[cluster], p), [this](std::uint32_t node) { return own_mobility(node); });
}

Matrix3 RigidConnections::WithoutContact::own_mobility(std::uint32_t node) const {
  return rigid_.contact_.fixed()[node] != 0 ? Matrix3(Matrix3::Zero())
                                            : Matrix3(Matrix3::Identity() / rigid_.mass_[node]);
}

void RigidConnections::WithoutContact::project(const springnet_vectors& velocity) const {
  ConstraintSystem system;
  system.set(system_.rows(), [this](std::uint32_t node) { return rigid_.mobility(node); });
  const Eigen::VectorXd rates = system.rates([&](std::uint32_t node) { return vector_at(velocity, node); });
  system.for_each_change(system.solve(-rates), [&](std::uint32_t node, const Vector3& change) {
    put_vector(velocity, node, vector_at(velocity, node) + change);
  });
}

void RigidConnections::WithoutContact::accelerate(const springnet_const_vectors& position,
                                                  const springnet_const_vectors& velocity,
                                                  std::vector<Vector3>& acceleration) const {
  const std::vector<ConstraintRow>& rows = system_.rows();
  Eigen::VectorXd rate(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::uint32_t a = rows[r].first, b = rows[r].second;
    const Vector3 n = rows[r].direction, dv = vector_at(velocity, a) - vector_at(velocity, b);
    const double length = (vector_at(position, a) - vector_at(position, b)).norm();
    const Vector3 da = acceleration[rigid_.member_of_[a]] - acceleration[rigid_.member_of_[b]];
    rate[static_cast<Eigen::Index>(r)] = n.dot(da) + (dv.squaredNorm() - n.dot(dv) * n.dot(dv)) / length;
  }
  system_.for_each_change(system_.solve(-rate), [&](std::uint32_t node, const Vector3& change) {
    acceleration[rigid_.member_of_[node]] += change;
  });
}

Eigen::MatrixXd RigidConnections::WithoutContact::mobility(const std::vector<std::uint32_t>& nodes) const {
  return system_.effective_mobility(nodes, [this](std::uint32_t node) { return own_mobility(node); });
}

double RigidConnections::max_length_rate(const springnet_const_vectors& position,
                                         const springnet_const_vectors& velocity) const {
  double greatest = 0.0;
  for (const Rod& rod : rods_) {
    const Vector3 d = vector_at(position, rod.first) - vector_at(position, rod.second);
    const Vector3 dv = vector_at(velocity, rod.first) - vector_at(velocity, rod.second);
    greatest = std::max(greatest, std::abs(d.dot(dv)) / d.norm());
  }
  return greatest;
}

// W - W G^T (G W G^T)^-1 G W, the columns of some nodes.
Eigen::MatrixXd RigidConnections::response(const Placement& at, std::size_t number,
                                           const springnet_const_vectors& position,
                                           const std::vector<std::uint32_t>& struck,
                                           const ConstraintSystem::Mobility& free, bool with_obstacles) const {
  const Cluster& cluster = clusters_[number];
  std::vector<Vector3> positions;
  std::vector<Touch> touches;
  for (const std::uint32_t k : cluster.nodes) {
    positions.push_back(vector_at(position, k));
    touches.push_back(with_obstacles ? contact_.now(k) : Touch());
  }
  const auto mobility = [&](std::uint32_t node) {
    const Touch& touch = touches[member_of_[node]];
    const bool stays = contact_.fixed()[node] != 0 || (touch.surface >= 0 && !touch.slides);
    return stays ? Matrix3(Matrix3::Zero()) : Matrix3(free(node));
  };
  ConstraintSystem system;
  system.set(rows_of(at, cluster, touches, positions), mobility);
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(3 * cluster.nodes.size()),
                                                 static_cast<Eigen::Index>(3 * struck.size()));
  for (std::size_t j = 0; j < struck.size(); ++j) {
    const Matrix3 own = mobility(struck[j]);
    for (Eigen::Index c = 0; c < 3; ++c) {
      const Eigen::Index column = static_cast<Eigen::Index>(3 * j) + c;
      const auto add = [&](std::uint32_t node, const Vector3& change) {
        result.block<3, 1>(3 * static_cast<Eigen::Index>(member_of_[node]), column) += change;
      };
      add(struck[j], own.col(c));
      const auto velocity = [&](std::uint32_t node) {
        return node == struck[j] ? Vector3(own.col(c)) : Vector3(Vector3::Zero());
      };
      system.for_each_change(system.solve(-system.rates(velocity)), add);
    }
  }
  return result;
}

void RigidConnections::add_rows(std::size_t cluster, const springnet_const_vectors& position,
                                std::vector<ConstraintRow>& rows) const {
  for (const std::uint32_t r : clusters_[cluster].rods) rows.push_back(row_along(rods_[r], position));
}

std::vector<ConstraintRow> RigidConnections::rows(const springnet_const_vectors& position) const {
  std::vector<ConstraintRow> rows;
  rows.reserve(rods_.size());
  for (const Rod& rod : rods_) rows.push_back(row_along(rod, position));
  return rows;
}

}  // namespace springnet
