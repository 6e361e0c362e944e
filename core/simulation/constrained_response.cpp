#include "simulation/constrained_response.hpp"

#include <algorithm>

#include "constraints/friction.hpp"
#include "constraints/least_squares.hpp"

namespace springnet {
namespace {

bool is_lone(const Model& model, std::uint32_t node) {
  const std::uint32_t* const clusters = model.rigid.cluster_of();
  return clusters == nullptr || clusters[node] == ConstraintRow::no_node;
}

double friction_of(const Model& model, std::int32_t surface) {
  return sliding_coefficient_of(model.contact.obstacles()[static_cast<std::size_t>(surface)].friction());
}

Vector3 vector_of(const double* values, std::size_t n, std::uint32_t k) {
  return {values[k], values[n + k], values[2 * n + k]};
}
void add(double* values, std::size_t n, std::uint32_t k, const Vector3& change) {
  for (std::size_t c = 0; c < 3; ++c) values[c * n + k] += change[static_cast<Eigen::Index>(c)];
}

}  // namespace

// A node on one or more surfaces: normals, forces of unit normal reactions, and how these turn with its position.
class ConstrainedResponse::OnSurfaces {
 public:
  // free: its acceleration without constraints, m/s^2. Of a node with rigid connections the direction of a slip that
  // begins is held.
  OnSurfaces(const Model& model, const ReactionsAt& reactions, std::uint32_t node, const Vector3& free, bool lone)
      : contact_(model.contact),
        at_(reactions.placement()),
        node_(node),
        p_(reactions.position(node)),
        v_(reactions.velocity(node)) {
    const std::vector<Vector3> all = contact_.normals(at_, node, p_);
    normals.resize(3, static_cast<Eigen::Index>(all.size()));
    for (std::size_t i = 0; i < all.size(); ++i) normals.col(static_cast<Eigen::Index>(i)) = all[i];
    directions = normals;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto j = static_cast<std::size_t>(surface(i));
      const Pose& pose = at_.poses[j];
      const Matrix3 h = contact_.obstacles()[j].curvature(pose, p_);
      direction_gradients.push_back(h);
      const double mu = friction_of(model, surface(i));
      // Of the holding ones, a lone node only bounces off.
      const bool holds = lone && contact_.obstacles()[j].friction().kind == Friction::Kind::held;
      if (mu == 0.0 || holds) continue;
      Vector3 against = contact_.slip_direction(at_, node, j, p_, v_);
      // The direction of the edge of two surfaces counts as constant.
      const Vector3 slip = contact_.slip_vector(at_, node, j, p_, v_);
      const bool is_single = all.size() == 1;
      const bool follows = contact_.slip_phase(node) == Contact::Slip::ongoing &&
                           slip.norm() > 0.5 * contact_.rest_speed();  // as in Contact::slip_direction
      if (is_single && lone && contact_.slip_phase(node) == Contact::Slip::starting) {
        const Vector3 pushed = free - Contact::acceleration(at_, j, p_);
        const Vector3 along = pushed - all[i] * all[i].dot(pushed);
        if (along.norm() > 0.0) {
          against = along.normalized();
          by_free = -mu * (Matrix3::Identity() - against * against.transpose()) *
                    (Matrix3::Identity() - all[i] * all[i].transpose()) / along.norm();
          direction_gradients.back() -= mu * direction_by_position(all[i], h, pushed, -acceleration_by_position(pose));
        }
      } else if (is_single && follows) {
        direction_gradients.back() -=
            mu * direction_by_position(all[i], h, v_ - Contact::velocity(at_, j, p_), -velocity_by_position(pose));
      } else if (is_single) {
        direction_gradients.back() -= mu * direction_by_position(all[i], h, contact_.slip(node), Matrix3::Zero());
      }
      directions.col(static_cast<Eigen::Index>(i)) -= mu * against;
    }
  }
  // Surfaces that pull exert no friction.
  void drop_friction() {
    directions = normals;
    by_free.setZero();
    for (std::size_t i = 0; i < direction_gradients.size(); ++i) {
      const auto j = static_cast<std::size_t>(surface(i));
      direction_gradients[i] = contact_.obstacles()[j].curvature(at_.poses[j], p_);
    }
  }
  // Multipliers of the surfaces for a reaction, in its unit.
  [[nodiscard]] Eigen::VectorXd multipliers(const Vector3& reaction) const {
    return least_squares(normals.transpose() * directions, normals.transpose() * reaction);
  }
  // Of forces at these multipliers, by the position.
  [[nodiscard]] Matrix3 by_position(const Eigen::VectorXd& multipliers) const {
    Matrix3 sum = Matrix3::Zero();
    for (std::size_t i = 0; i < direction_gradients.size(); ++i)
      sum += multipliers[static_cast<Eigen::Index>(i)] * direction_gradients[i];
    return sum;
  }
  [[nodiscard]] AccelerationGradient rates(std::size_t i, const Vector3& acceleration) const {
    return gap_acceleration_gradient(contact_, at_, static_cast<std::size_t>(surface(i)), p_, v_, acceleration);
  }
  [[nodiscard]] std::int32_t surface(std::size_t i) const { return contact_.now(node_).surfaces()[i]; }

  Eigen::Matrix<double, 3, Eigen::Dynamic> normals, directions;
  Matrix3 by_free = Matrix3::Zero();         // d(direction)/d(free acceleration)
  std::vector<Matrix3> direction_gradients;  // d(direction)/dp, 1/m

 private:
  const Contact& contact_;
  const Placement& at_;
  std::uint32_t node_;
  Vector3 p_, v_;
};

springnet_status ConstrainedResponse::find(Model& model, ReactionsAt& reactions) {
  known_ = has_friction_ = false;
  model_ = &model;
  lone_.clear();
  own_forces_.clear();
  rows_.clear();
  added_.assign(model.node_count(), Vector3::Zero());
  // Friction of surfaces on nodes that other bodies push follows the sweeps, as that of these bodies does.
  paired_.clear();
  for (const ConstraintRow& row : model.constraints.rows())
    if (row.is_pair) row.for_each_end([this](std::size_t, std::uint32_t node, double) { paired_.insert(node); });
  std::vector<std::uint32_t> sliding;  // lone nodes, ascending
  for (const ConstraintRow& row : model.constraints.rows()) {
    if (row.surface < 0 || !is_lone(model, row.first) || paired_.contains(row.first))
      rows_.push_back(row);
    else if (sliding.empty() || sliding.back() != row.first)
      sliding.push_back(row.first);
  }
  for (const std::uint32_t k : sliding) {
    Vector3 free, constrained;
    springnet_status status = reactions.unsupported(k, free);
    if (status == SPRINGNET_OK) status = reactions.constrained(k, constrained);
    if (status != SPRINGNET_OK) return status;
    added_[k] = constrained - free;
    find_lone(reactions, k, free, constrained);
  }
  for (std::uint32_t c = 0; c < model.rigid.cluster_count(); ++c) {
    if (const springnet_status status = reactions.know(c); status != SPRINGNET_OK) return status;
    for (const std::uint32_t k : model.rigid.nodes_of(c)) added_[k] = reactions.constrained(k) - reactions.free(k);
  }
  find_clusters(reactions);
  find_rates(reactions);
  known_ = true;
  return SPRINGNET_OK;
}

// As Contact::sliding_acceleration.
void ConstrainedResponse::find_lone(const ReactionsAt& reactions, std::uint32_t k, const Vector3& free,
                                    const Vector3& constrained) {
  OnSurfaces on(*model_, reactions, k, free, true);
  if (on.normals.cols() == 1 && !(on.normals.col(0).dot(added_[k]) > 0.0)) on.drop_friction();
  has_friction_ = has_friction_ || on.directions != on.normals;
  const Eigen::VectorXd x = on.multipliers(added_[k]);  // m/s^2
  const Eigen::MatrixXd square = on.normals.transpose() * on.directions;
  // D (G D)^-1
  Eigen::Matrix<double, 3, Eigen::Dynamic> answer(3, on.normals.cols());
  for (Eigen::Index i = 0; i < answer.cols(); ++i)
    answer.col(i) = on.directions * least_squares(square, Eigen::VectorXd::Unit(answer.cols(), i));
  const Matrix3 straight = Matrix3::Identity() - answer * on.normals.transpose();
  Lone lone{k, straight, straight, Matrix3::Zero(), Matrix3::Zero()};
  lone.by_position = lone.response * on.by_position(x);
  for (std::size_t i = 0; i < on.direction_gradients.size(); ++i) {
    const AccelerationGradient rate = on.rates(i, constrained);
    lone.by_position -= answer.col(static_cast<Eigen::Index>(i)) * rate.by_position.transpose();
    lone.by_velocity -= answer.col(static_cast<Eigen::Index>(i)) * rate.by_velocity.transpose();
  }
  // The direction of a beginning slip turns along the surface: n by_free = 0.
  if (on.normals.cols() == 1) lone.response += x[0] * on.by_free;
  lone_.push_back(lone);
}

void ConstrainedResponse::find_clusters(const ReactionsAt& reactions) {
  friction_.clear();
  factorised_ = false;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (rows_[r].surface < 0 || paired_.contains(rows_[r].first)) continue;
    const double mu = friction_of(*model_, rows_[r].surface);
    if (mu == 0.0) continue;
    const std::uint32_t k = rows_[r].first;
    const Vector3 slip =
        model_->contact.slip_direction(reactions.placement(), k, static_cast<std::size_t>(rows_[r].surface),
                                       reactions.position(k), reactions.velocity(k));
    friction_.push_back({static_cast<Eigen::Index>(r), k, mu * slip});
  }
}

void ConstrainedResponse::find_rates(const ReactionsAt& reactions) {
  rates_.clear();
  std::uint32_t last = ConstraintRow::no_node;
  for (const ConstraintRow& row : rows_) {
    const std::uint32_t k = row.first, o = row.second;
    if (row.is_pair || (row.surface >= 0 && paired_.contains(k))) {
      rates_.push_back({Vector3::Zero(), Vector3::Zero()});  // directions of pairs count as constant
      continue;
    }
    if (row.surface < 0) {
      rates_.push_back(length_acceleration_gradient(reactions.position(k) - reactions.position(o),
                                                    reactions.velocity(k) - reactions.velocity(o),
                                                    reactions.constrained(k) - reactions.constrained(o)));
      continue;
    }
    if (k == last) continue;  // the surfaces of a node come one after another
    last = k;
    const OnSurfaces on(*model_, reactions, k, reactions.free(k), false);
    for (std::size_t i = 0; i < on.direction_gradients.size(); ++i)
      rates_.push_back(on.rates(i, reactions.constrained(k)));
    // What is left of the force on the node is that of its surfaces.
    const Vector3 of_rods = model_->rigid.connection_force(k, reactions.all_positions(), reactions.tensions().data());
    own_forces_.push_back({k, on.by_position(on.multipliers(added_[k] - of_rods / model_->mass[k]))});
  }
}

void ConstrainedResponse::factorise() {
  if (factorised_) return;
  system_.set(rows_, [&](std::uint32_t node) { return model_->rigid.mobility(node); });
  const auto size = static_cast<Eigen::Index>(friction_.size());
  solved_.resize(static_cast<Eigen::Index>(rows_.size()), size);
  Eigen::MatrixXd small = Eigen::MatrixXd::Identity(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const FrictionColumn& column = friction_[static_cast<std::size_t>(i)];
    const Vector3 moved = model_->rigid.mobility(column.node) * column.force;
    solved_.col(i) = system_.solve(
        system_.rates([&](std::uint32_t node) { return node == column.node ? moved : Vector3(Vector3::Zero()); }));
  }
  for (Eigen::Index i = 0; i < size; ++i) small.row(i) -= solved_.row(friction_[static_cast<std::size_t>(i)].row);
  if (size > 0) small_.compute(small);
  factorised_ = true;
}

void ConstrainedResponse::apply(bool transposed, double* values) {
  const std::size_t n = added_.size();
  const auto clear_held = [&] {
    for (std::size_t k = 0; k < n; ++k)
      if (model_->contact.constrained()[k] != 0)
        for (std::size_t c = 0; c < 3; ++c) values[c * n + k] = 0.0;
  };
  clear_held();
  for (const Lone& each : lone_) {
    const Vector3 before = vector_of(values, n, each.node);
    const Vector3 after = transposed ? Vector3(each.response.transpose() * before) : Vector3(each.response * before);
    add(values, n, each.node, after - before);
  }
  if (rows_.empty()) return;
  factorise();
  apply_clusters(transposed, values);
  clear_held();
}

void ConstrainedResponse::take_reactions(double* forces) const {
  // Forces and accelerations of a node without rigid connections are parallel.
  for (const Lone& each : lone_) {
    Eigen::Map<Vector3> force(forces + 3 * std::size_t{each.node});
    force = (each.response * force).eval();
  }
}

// G W D x = G W G^T x - U E^T x.
Eigen::VectorXd ConstrainedResponse::solve(const Eigen::VectorXd& right_side) const {
  Eigen::VectorXd x = system_.solve(right_side);
  const auto size = static_cast<Eigen::Index>(friction_.size());
  if (size == 0) return x;
  Eigen::VectorXd small(size);
  for (Eigen::Index i = 0; i < size; ++i) small[i] = x[friction_[static_cast<std::size_t>(i)].row];
  return x + solved_ * small_.solve(small);
}

// (G W D)^-T D^T W v. With g = B^T W v, y = (G W G^T)^-1 G W v and h = (I - U^T (G W G^T)^-1 E)^-1 (U^T y - g), it is
// y + (G W G^T)^-1 E h.
Eigen::VectorXd ConstrainedResponse::solve_transposed(const double* weights) const {
  const auto moved = [&](std::uint32_t k) -> Vector3 {
    return model_->rigid.mobility(k) * vector_of(weights, added_.size(), k);
  };
  const Eigen::VectorXd rates = system_.rates(moved);
  Eigen::VectorXd z = system_.solve(rates);
  const auto size = static_cast<Eigen::Index>(friction_.size());
  if (size == 0) return z;
  Eigen::VectorXd small(size), of_rows = Eigen::VectorXd::Zero(z.size());
  for (Eigen::Index i = 0; i < size; ++i) {
    const FrictionColumn& column = friction_[static_cast<std::size_t>(i)];
    small[i] = solved_.col(i).dot(rates) - column.force.dot(moved(column.node));
  }
  small = small_.transpose().solve(small).eval();
  for (Eigen::Index i = 0; i < size; ++i) of_rows[friction_[static_cast<std::size_t>(i)].row] += small[i];
  return z + system_.solve(of_rows);
}

// W D x.
template <class Add>
void ConstrainedResponse::for_each_change(const Eigen::VectorXd& multipliers, const Add& add) const {
  system_.for_each_change(multipliers, add);
  for (const FrictionColumn& column : friction_)
    add(column.node, Vector3(-multipliers[column.row] * (model_->rigid.mobility(column.node) * column.force)));
}

void ConstrainedResponse::apply_clusters(bool transposed, double* values) const {
  const std::size_t n = added_.size();
  const auto add_to = [&](std::uint32_t k, const Vector3& change) { add(values, n, k, change); };
  if (transposed)
    system_.for_each_impulse(-solve_transposed(values), add_to);
  else
    for_each_change(solve(-system_.rates([&](std::uint32_t k) { return vector_of(values, n, k); })), add_to);
}

void ConstrainedResponse::add_forces(const double* dp, double* change) const {
  const std::size_t n = added_.size();
  for (const OwnForce& own : own_forces_) add(change, n, own.node, own.by_position * vector_of(dp, n, own.node));
}

void ConstrainedResponse::add_forces_transposed(const double* weights, double* by_position) const {
  const std::size_t n = added_.size();
  for (const OwnForce& own : own_forces_)
    add(by_position, n, own.node, own.by_position.transpose() * vector_of(weights, n, own.node));
}

void ConstrainedResponse::add_rates(const double* dp, const double* dv, double* change) {
  const std::size_t n = added_.size();
  for (const Lone& each : lone_)
    add(change, n, each.node,
        each.by_position * vector_of(dp, n, each.node) + each.by_velocity * vector_of(dv, n, each.node));
  if (rows_.empty()) return;
  factorise();
  const auto between = [&](const double* values, const ConstraintRow& row) {
    Vector3 result = Vector3::Zero();
    row.for_each_end(
        [&](std::size_t, std::uint32_t node, double weight) { result += weight * vector_of(values, n, node); });
    return result;
  };
  Eigen::VectorXd rates(static_cast<Eigen::Index>(rows_.size()));
  for (std::size_t r = 0; r < rows_.size(); ++r)
    rates[static_cast<Eigen::Index>(r)] =
        rates_[r].by_position.dot(between(dp, rows_[r])) + rates_[r].by_velocity.dot(between(dv, rows_[r]));
  for_each_change(solve(-rates), [&](std::uint32_t k, const Vector3& more) { add(change, n, k, more); });
}

void ConstrainedResponse::add_rates_transposed(const double* weights, double* by_position, double* by_velocity) {
  const std::size_t n = added_.size();
  for (const Lone& each : lone_) {
    add(by_position, n, each.node, each.by_position.transpose() * vector_of(weights, n, each.node));
    add(by_velocity, n, each.node, each.by_velocity.transpose() * vector_of(weights, n, each.node));
  }
  if (rows_.empty()) return;
  factorise();
  const Eigen::VectorXd z = solve_transposed(weights);
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const double weight = -z[static_cast<Eigen::Index>(r)];
    rows_[r].for_each_end([&](std::size_t, std::uint32_t node, double of_node) {
      add(by_position, n, node, weight * of_node * rates_[r].by_position);
      add(by_velocity, n, node, weight * of_node * rates_[r].by_velocity);
    });
  }
}

}  // namespace springnet
