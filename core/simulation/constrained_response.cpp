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

bool ConstrainedResponse::has_friction(const Model& model) {
  const std::vector<ConstraintRow>& rows = model.constraints.rows();
  return std::any_of(rows.begin(), rows.end(), [&](const ConstraintRow& row) {
    return row.surface >= 0 && friction_of(model, row.surface) > 0.0;
  });
}

springnet_status ConstrainedResponse::find(Model& model, ReactionsAt& reactions) {
  known_ = false;
  model_ = &model;
  lone_.clear();
  added_.assign(model.node_count(), Vector3::Zero());
  rows_.clear();
  std::vector<std::uint32_t> sliding;  // lone nodes, ascending
  for (const ConstraintRow& row : model.constraints.rows()) {
    if (row.surface < 0 || !is_lone(model, row.first))
      rows_.push_back(row);
    else if (sliding.empty() || sliding.back() != row.first)
      sliding.push_back(row.first);
  }
  for (const std::uint32_t k : sliding) {
    Vector3 free, bound;
    springnet_status status = reactions.unsupported(k, free);
    if (status == SPRINGNET_OK) status = reactions.bound(k, bound);
    if (status != SPRINGNET_OK) return status;
    added_[k] = bound - free;
    lone_.push_back({k, response_of(model, reactions, k, free)});
  }
  for (std::uint32_t c = 0; c < model.rigid.cluster_count(); ++c) {
    if (const springnet_status status = reactions.know(c); status != SPRINGNET_OK) return status;
    for (const std::uint32_t k : model.rigid.nodes_of(c)) added_[k] = reactions.bound(k) - reactions.free(k);
  }
  find_clusters(reactions);
  known_ = true;
  return SPRINGNET_OK;
}

// As Contact::sliding_acceleration.
Matrix3 ConstrainedResponse::response_of(const Model& model, const ReactionsAt& reactions, std::uint32_t k,
                                         const Vector3& free) const {
  const Contact& contact = model.contact;
  const Placement& at = reactions.placement();
  const Touch& touch = contact.now(k);
  const Vector3 p = reactions.position(k), v = reactions.velocity(k);
  const std::vector<Vector3> all = contact.normals(at, k, p);
  const auto count = static_cast<Eigen::Index>(all.size());
  Eigen::Matrix<double, 3, Eigen::Dynamic> normals(3, count), directions(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::int32_t surface = touch.surfaces()[static_cast<std::size_t>(i)];
    const auto j = static_cast<std::size_t>(surface);
    const double mu = friction_of(model, surface);
    const Vector3& n = all[static_cast<std::size_t>(i)];
    normals.col(i) = directions.col(i) = n;
    if (mu == 0.0) continue;
    if (count > 1) {
      directions.col(i) -= mu * contact.slip_direction(at, k, j, p, v);
      continue;
    }
    const double pressing = n.dot(added_[k]);  // m/s^2
    if (!(pressing > 0.0)) break;
    Vector3 against = contact.slip_direction(at, k, j, p, v);
    Matrix3 turning = Matrix3::Zero();  // d(against)/d(free)
    if (contact.slip_phase(k) == Contact::Slip::starting) {
      const Vector3 pushed = free - Contact::acceleration(at, j, p);
      const Vector3 along = pushed - n * n.dot(pushed);
      if (along.norm() > 0.0) {
        against = along.normalized();
        turning = (Matrix3::Identity() - against * against.transpose()) * (Matrix3::Identity() - n * n.transpose()) /
                  along.norm();
      }
    }
    return Matrix3::Identity() - (n - mu * against) * n.transpose() - mu * pressing * turning;
  }
  if (count == 1) return Matrix3::Identity() - normals.col(0) * normals.col(0).transpose();
  const Eigen::MatrixXd square = normals.transpose() * directions;
  Matrix3 result = Matrix3::Identity();
  for (Eigen::Index c = 0; c < 3; ++c)
    result.col(c) -= directions * least_squares(square, Eigen::VectorXd(normals.row(c).transpose()));
  return result;
}

void ConstrainedResponse::find_clusters(const ReactionsAt& reactions) {
  friction_.clear();
  factorised_ = false;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (rows_[r].surface < 0) continue;
    const double mu = friction_of(*model_, rows_[r].surface);
    if (mu == 0.0) continue;
    const std::uint32_t k = rows_[r].first;
    const Vector3 slip =
        model_->contact.slip_direction(reactions.placement(), k, static_cast<std::size_t>(rows_[r].surface),
                                       reactions.position(k), reactions.velocity(k));
    friction_.push_back({static_cast<Eigen::Index>(r), k, mu * slip});
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
    solved_.col(i) = system_.solve(system_.rates(
        [&](std::uint32_t node) { return node == column.node ? moved : Vector3(Vector3::Zero()); }));
  }
  for (Eigen::Index i = 0; i < size; ++i) small.row(i) -= solved_.row(friction_[static_cast<std::size_t>(i)].row);
  if (size > 0) small_.compute(small);
  factorised_ = true;
}

void ConstrainedResponse::apply(bool transposed, double* values) {
  const std::size_t n = added_.size();
  const auto hold = [&] {
    for (std::size_t k = 0; k < n; ++k)
      if (model_->contact.constrained()[k] != 0)
        for (std::size_t c = 0; c < 3; ++c) values[c * n + k] = 0.0;
  };
  hold();
  for (const Lone& each : lone_) {
    const Vector3 before = vector_of(values, n, each.node);
    const Vector3 after = transposed ? Vector3(each.response.transpose() * before) : Vector3(each.response * before);
    add(values, n, each.node, after - before);
  }
  if (rows_.empty()) return;
  factorise();
  apply_clusters(transposed, values);
  hold();
}

void ConstrainedResponse::apply_clusters(bool transposed, double* values) const {
  const std::size_t n = added_.size();
  const auto size = static_cast<Eigen::Index>(friction_.size());
  const auto mobility = [&](std::uint32_t node) { return model_->rigid.mobility(node); };
  Eigen::VectorXd small(size);
  if (!transposed) {
    // x = -(G W D)^-1 G v
    Eigen::VectorXd x = system_.solve(-system_.rates([&](std::uint32_t k) { return vector_of(values, n, k); }));
    for (Eigen::Index i = 0; i < size; ++i) small[i] = x[friction_[static_cast<std::size_t>(i)].row];
    if (size > 0) small = small_.solve(small).eval();
    x += solved_ * small;
    system_.for_each_change(x, [&](std::uint32_t k, const Vector3& change) { add(values, n, k, change); });
    for (const FrictionColumn& column : friction_)
      add(values, n, column.node, -x[column.row] * (mobility(column.node) * column.force));
    return;
  }
  // z = (G W D)^-T D^T W v; with g = B^T W v, y = (G W G^T)^-1 G W v and h = (I - U^T (G W G^T)^-1 E)^-1 (U^T y - g),
  // z = y + (G W G^T)^-1 E h.
  const auto moved = [&](std::uint32_t k) -> Vector3 { return mobility(k) * vector_of(values, n, k); };
  Eigen::VectorXd z = system_.solve(system_.rates(moved));
  if (size > 0) {
    Eigen::VectorXd of_rows = Eigen::VectorXd::Zero(z.size());
    const Eigen::VectorXd rates = system_.rates(moved);
    for (Eigen::Index i = 0; i < size; ++i) {
      const FrictionColumn& column = friction_[static_cast<std::size_t>(i)];
      small[i] = solved_.col(i).dot(rates) - column.force.dot(moved(column.node));
    }
    small = small_.transpose().solve(small).eval();
    for (Eigen::Index i = 0; i < size; ++i) of_rows[friction_[static_cast<std::size_t>(i)].row] += small[i];
    z += system_.solve(of_rows);
  }
  system_.for_each_impulse(-z, [&](std::uint32_t k, const Vector3& impulse) { add(values, n, k, impulse); });
}

}  // namespace springnet
