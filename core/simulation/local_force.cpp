#include "simulation/local_force.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "constraints/friction.hpp"
#include "constraints/vectors.hpp"
#include "plugin_host/call.hpp"

namespace springnet {
namespace {

// Of the linear systems: first ones, later ones for changes of friction, and what may be taken if there is no better.
constexpr double accuracy_of_first = 1e-5, accuracy_of_corrections = 1e-3, enough = 1e-4;
// Central differences: of positions, over the network's length scale; of the slip of a node with friction, over its
// speed; and never so little, over the extent of the positions, that their rounding shows.
constexpr double difference = 1e-8, slip_difference = 1e-3, rounding_difference = 1e-11;
constexpr double friction_settles = 1e-4;  // change from iteration to iteration, relative
constexpr int max_friction_rounds = 20;    // for friction
constexpr double slow = 0.7;               // of which a change may be of the one before

Vector3 vector_of(const std::vector<double>& values, std::uint32_t node) {
  const std::size_t n = values.size() / 3;
  return {values[node], values[n + node], values[2 * n + node]};
}
void put(std::vector<double>& values, std::uint32_t node, const Vector3& v) {
  const std::size_t n = values.size() / 3;
  for (std::size_t c = 0; c < 3; ++c) values[c * n + node] = v[static_cast<Eigen::Index>(c)];
}
springnet_const_vectors columns(const std::vector<double>& values) {
  const std::size_t n = values.size() / 3;
  return {values.data(), values.data() + n, values.data() + 2 * n};
}

}  // namespace

Matrix3 LocalForceModel::stiffness_of_node(std::uint32_t node, double step) { return stiffness({node, -1}, step); }

Matrix3 LocalForceModel::stiffness_of_surface(std::size_t surface, double step) {
  return stiffness({ConstraintRow::no_node, static_cast<std::int32_t>(surface)}, step);
}

void LocalForceModel::check(springnet_status status) const {
  if (status != SPRINGNET_OK)
    throw Error(ErrorKind::simulation, "local force model: " + text_of(model_.journal.message));
}

bool LocalForceModel::carries(const Handle& handle, std::uint32_t node) const {
  if (!handle.is_surface()) return node == handle.node;
  const Contact& contact = model_.contact;
  return contact.fixed()[node] == 0 && contact.held()[node] != 0 && contact.committed(node).surface == handle.surface;
}

Matrix3 LocalForceModel::stiffness(const Handle& handle, double step) {
  const auto touches = [&](std::uint32_t k) {
    return carries(handle, k) || (handle.is_surface() && model_.contact.committed(k).has(handle.surface));
  };
  bool any = false;
  for (std::uint32_t k = 0; k < model_.node_count() && !any; ++k) any = touches(k);
  if (!any) return Matrix3::Zero();

  // The integrator may keep constraint rows of its own from step to step.
  struct Aside {
    ConstraintSet& constraints;
    ConstraintSet::Linearised rows{};
    explicit Aside(ConstraintSet& set) : constraints(set) { constraints.exchange(rows); }
    Aside(const Aside&) = delete;
    Aside& operator=(const Aside&) = delete;
    ~Aside() { constraints.exchange(rows); }
  } const aside(model_.constraints);
  linearise(handle);
  springnet_linear_system system{};
  system.struct_size = sizeof system;
  system.exact = 1;
  system.velocity_weight = step;
  system.position_weight = step * step;
  check(linear_.prepare(system));

  Matrix3 result, at_present_pressure;
  bool follows = true;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Vector3 speed = Vector3::Unit(axis) / step;  // for a displacement of 1 m
    const Change change = change_along(handle, step, speed);
    follows = follows && change.friction_follows;
    result.col(axis) = -change.force;
    at_present_pressure.col(axis) = -change.at_present_pressure;
  }
  if (!follows) result = at_present_pressure;  // a contact is about to jam
  if (!result.allFinite())
    throw Error(ErrorKind::simulation, "local force model: a force near the state is not finite");
  return result;
}

LocalForceModel::Change LocalForceModel::change_along(const Handle& handle, double step, const Vector3& speed) {
  Values velocity = carried(handle, speed), right_side = right_side_of(step, speed, velocity);
  std::vector<Vector3> extra(friction_.size(), Vector3::Zero()), friction = extra;
  // Friction follows the slip relative to the surface. The system has the node's part of that at the present pressure;
  // the rest follows by iteration.
  for (std::size_t f = 0; f < friction_.size(); ++f) {
    if (friction_[f].surface != handle.surface) continue;
    extra[f] = -friction_[f].by_velocity * speed;
    add_force(right_side, friction_[f].node, extra[f], step);
  }
  add_solution(right_side, accuracy_of_first, step, velocity);
  Vector3 change = this->change(handle, step, speed, velocity, friction);
  const Vector3 at_present_pressure = change;
  if (friction_.empty()) return {change, at_present_pressure, true};
  double share = 1.0, distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < max_friction_rounds; ++i) {
    std::fill(right_side.begin(), right_side.end(), 0.0);
    for (std::size_t f = 0; f < friction_.size(); ++f) {
      const Vector3 wanted = friction[f] + friction_[f].without_reaction(vector_of(velocity, friction_[f].node), step);
      const Vector3 more = share * (wanted - extra[f]);
      add_force(right_side, friction_[f].node, more, step);
      extra[f] += more;
    }
    add_solution(right_side, accuracy_of_corrections, step, velocity);
    const Vector3 before = change;
    change = this->change(handle, step, speed, velocity, friction);
    const double moved = (change - before).norm() / share;
    if (moved <= friction_settles * change.norm()) return {change, at_present_pressure, true};
    if (moved > slow * distance) share *= 0.5;
    distance = moved;
  }
  return {change, at_present_pressure, false};
}

void LocalForceModel::add_force(Values& right_side, std::uint32_t node, const Vector3& force, double step) const {
  put(right_side, node, vector_of(right_side, node) + step / model_.mass[node] * force);
}

void LocalForceModel::linearise(const Handle& handle) {
  const layers::LoadedFaces& faces = model_.layout.loaded_faces();
  Parts parts{model_.layout.live_count(), model_.layout.elements().live_count(), 0};
  for (std::size_t f = 0; f < faces.count(); ++f) parts[2] += faces.alive(f) ? 1 : 0;
  if (parts != parts_) linear_.topology_changed();
  parts_ = parts;
  const springnet_state& state = model_.state.view;
  springnet_evaluation at{};
  at.struct_size = sizeof at;
  at.time = model_.time;
  at.position = read_only(state.position);
  at.velocity = read_only(state.velocity);
  {
    // The forces of bodies on each other stay: their rows are no part of the system.
    BodyPushes& pushes = model_.constraints.pushes();
    struct Aside {
      BodyPushes& of;
      std::vector<ConstraintRow> rows;
      std::vector<BodyPushes::Drag> drags;
      ~Aside() { of.set_rows(std::move(rows), std::move(drags)); }
    } const aside{pushes, pushes.rows(), pushes.drags()};
    pushes.set_rows({});
    check(linear_.linearise(at, 0.0));
  }
  friction_.clear();
  curved_.clear();
  curvature_.clear();
  ReactionsAt reactions(model_, at.time, at.position, at.velocity);
  const Placement& placement = reactions.placement();
  for (const ConstraintRow& row : model_.constraints.rows()) {
    if (row.surface < 0) continue;
    Vector3 reaction;
    check(reactions.of(row.first, reaction));
    if (model_.contact.committed(row.first).count() == 1) {
      // The normals turn where a node moves along a curved surface.
      const Obstacle& obstacle = model_.contact.obstacles()[static_cast<std::size_t>(row.surface)];
      const Matrix3 curvature =
          row.direction.dot(reaction) *
          obstacle.curvature(placement.poses[static_cast<std::size_t>(row.surface)], vector_at(at.position, row.first));
      linear_.matrices().add_to_position_block(row.first, curvature / model_.mass[row.first]);
      if (row.surface == handle.surface) {
        curved_.push_back(row.first);
        curvature_.push_back(curvature);
      }
    }
    if (!model_.constraints.friction_follows_slip(row)) continue;
    const double mass = model_.mass[row.first], pressing = row.direction.dot(reaction);
    const Matrix3 by_velocity =
        mass * model_.constraints.friction_derivative(placement, row, at.position, at.velocity, reaction);
    const Vector3 share = pressing > 0.0 ? Vector3(reaction / pressing - row.direction) : Vector3(Vector3::Zero());
    friction_.push_back({row.first, row.surface, mass, by_velocity, row.direction, share});
  }
}

LocalForceModel::Values LocalForceModel::carried(const Handle& handle, const Vector3& speed) {
  Values values(3 * std::size_t{model_.node_count()}, 0.0);
  for (std::uint32_t k = 0; k < model_.node_count(); ++k)
    if (carries(handle, k)) put(values, k, speed);
  if (model_.constraints.rows().empty()) return values;
  model_.constraints.add_rates(
      [&](const ConstraintRow& row) {
        return handle.is_surface() && row.surface == handle.surface ? row.direction.dot(speed) : 0.0;
      },
      values.data());
  return values;
}

LocalForceModel::Values LocalForceModel::right_side_of(double step, const Vector3& speed, const Values& carried) {
  Values positions = carried, right_side(carried.size());
  for (double& value : positions) value *= step;
  linear_.matrices().times(positions.data(), carried.data(), right_side.data());
  for (std::size_t i = 0; i < right_side.size(); ++i) right_side[i] = step * right_side[i] - carried[i];
  // The surface moves away from under its nodes, and its normals with it.
  for (std::size_t i = 0; i < curved_.size(); ++i)
    add_force(right_side, curved_[i], -curvature_[i] * (step * speed), step);
  return right_side;
}

void LocalForceModel::add_solution(const Values& right_side, double wanted, double step, Values& velocity) {
  Values result(right_side.size(), 0.0);
  springnet_linear_solve solve{};
  solve.struct_size = sizeof solve;
  solve.right_side = right_side.data();
  solve.accuracy = wanted;
  solve.x = result.data();
  check(linear_.solve_prepared(solve));
  if (solve.outcome != SPRINGNET_SOLVED && !(solve.residual <= std::max(enough, wanted)))
    throw Error(
        ErrorKind::simulation,
        fmt::format("local force model: its linear system was not solved (residual {:.1e}): the network is about "
                    "to buckle, or far stiffer than its masses over {:.3g} s; ask for a shorter time",
                    solve.residual, step));
  for (std::size_t i = 0; i < result.size(); ++i) velocity[i] += result[i];
}

// Of a displacement of 1 m.
double LocalForceModel::difference_along(const Handle& handle, const Vector3& speed, const Values& velocity) const {
  double share = difference * model_.scales.length, extent = model_.scales.length;
  const springnet_state& state = model_.state.view;
  for (const Friction& friction : friction_) {
    const auto surface = static_cast<std::size_t>(friction.surface);
    const double slip =
        model_.contact
            .slip_vector(*model_.placement(model_.time), friction.node, surface,
                         vector_at(state.position, friction.node), vector_at(state.velocity, friction.node))
            .norm();
    Vector3 more = vector_of(velocity, friction.node);
    if (friction.surface == handle.surface) more -= speed;
    if (slip > 0.0 && more.norm() > 0.0) share = std::min(share, slip_difference * slip / more.norm());
  }
  for (std::uint32_t k = 0; k < model_.node_count(); ++k)
    extent = std::max(extent, vector_at(state.position, k).cwiseAbs().maxCoeff());
  return std::max(share, rounding_difference * extent);
}

Vector3 LocalForceModel::change(const Handle& handle, double step, const Vector3& speed, const Values& velocity,
                                std::vector<Vector3>& friction) {
  const springnet_state& state = model_.state.view;
  const double share = difference_along(handle, speed, velocity);
  std::array<Vector3, 2> forces;
  std::array<std::vector<Vector3>, 2> frictions{friction, friction};
  for (const int side : {0, 1}) {
    const double s = side == 0 ? share : -share;
    Values p(velocity.size()), v(velocity.size());
    for (std::uint32_t k = 0; k < model_.node_count(); ++k) {
      const Vector3 u = vector_of(velocity, k);
      put(p, k, vector_at(state.position, k) + s * step * u);
      put(v, k, vector_at(state.velocity, k) + s * u);
    }
    const auto placement = std::make_shared<Placement>(*model_.placement(model_.time));
    if (handle.is_surface()) {
      Pose& pose = placement->poses[static_cast<std::size_t>(handle.surface)];
      pose.displacement += s * step * speed;
      pose.velocity += s * speed;
    }
    ReactionsAt at(model_, model_.time, columns(p), columns(v), model_.state.internal, placement);
    const auto i = static_cast<std::size_t>(side);
    forces[i] = force(handle, at, frictions[i]);
  }
  for (std::size_t f = 0; f < friction.size(); ++f) friction[f] = (frictions[0][f] - frictions[1][f]) / (2.0 * share);
  return (forces[0] - forces[1]) / (2.0 * share);
}

Vector3 LocalForceModel::force(const Handle& handle, ReactionsAt& at, std::vector<Vector3>& friction) const {
  for (std::size_t f = 0; f < friction_.size(); ++f) {
    const std::uint32_t node = friction_[f].node;
    Vector3 reaction;
    check(at.of(node, reaction));
    const Vector3 n =
        model_.contact.normal(at.placement(), static_cast<std::size_t>(friction_[f].surface), at.position(node));
    friction[f] = reaction - n.dot(reaction) * n;
  }
  Vector3 sum = Vector3::Zero(), reaction;
  if (!handle.is_surface()) {
    check(at.of(handle.node, reaction));
    return -reaction;
  }
  for (std::uint32_t k = 0; k < model_.node_count(); ++k) {
    if (!model_.contact.committed(k).has(handle.surface)) continue;
    check(at.reported(k, reaction));
    sum -= model_.constraints.share_of(at.placement(), k, static_cast<std::size_t>(handle.surface), at.position(k),
                                       reaction);
  }
  return sum;
}

}  // namespace springnet
