#include "constraints/constraint_set.hpp"

#include <algorithm>
#include <memory>

#include "constraints/island.hpp"
#include "constraints/vectors.hpp"
#include "plugin_host/call.hpp"
#include "plugin_host/message.hpp"

namespace springnet {
namespace {

// From this many clusters on threads pay off.
constexpr std::size_t clusters_worth_threads = 256;

}  // namespace

ConstraintSet::ConstraintSet(const Network& network, const std::vector<std::uint32_t>& user_number,
                             const std::vector<std::uint32_t>& engine_number, const std::vector<double>& mass)
    : mass_(mass),
      contact_(network, user_number, engine_number, mass),
      rigid_(network, user_number, engine_number, mass, contact_),
      bodies_(network, user_number, engine_number) {
  if (bodies_.any()) pushes_.resize(mass.size());
}

bool ConstraintSet::is_lone(std::uint32_t node) const noexcept {
  const std::uint32_t* const clusters = rigid_.cluster_of();
  return clusters == nullptr || clusters[node] == ConstraintRow::no_node;
}

void ConstraintSet::place_fixed(const Placement& at, std::uint32_t node, const springnet_const_vectors& start,
                                const springnet_vectors& position, const springnet_vectors& velocity) const {
  const Prescribed& prescribed = contact_.prescribed();
  const bool moves = prescribed.moves(node);
  put_vector(position, node, moves ? prescribed.position(at.motions, node) : vector_at(start, node));
  put_vector(velocity, node, moves ? prescribed.velocity(at.motions, node) : Vector3::Zero());
}

void ConstraintSet::place(const Placement& at, const springnet_const_vectors& start, const springnet_vectors& position,
                          const springnet_vectors& velocity) const {
  for (std::uint32_t k = 0; k < mass_.size(); ++k) {
    if (contact_.constrained()[k] == 0) continue;
    if (contact_.fixed()[k] != 0) {
      place_fixed(at, k, start, position, velocity);
      continue;
    }
    const std::int32_t surface = contact_.now(k).surface;
    const Vector3 place = contact_.carried(at, vector_at(start, k), surface);
    put_vector(position, k, place);
    put_vector(velocity, k, Contact::velocity(at, static_cast<std::size_t>(surface), place));
  }
}

void ConstraintSet::correct(const Placement& at, const springnet_const_vectors& start,
                            const springnet_vectors& position, const springnet_vectors& velocity) const {
  for (std::uint32_t k = 0; k < mass_.size(); ++k) {
    if (contact_.constrained()[k] == 0) continue;
    if (contact_.fixed()[k] != 0) {
      place_fixed(at, k, start, position, velocity);
      continue;
    }
    const auto j = static_cast<std::size_t>(contact_.committed(k).surface);
    if (contact_.obstacles()[j].moves()) put_vector(position, k, contact_.onto(at, j, vector_at(position, k)));
    put_vector(velocity, k, Contact::velocity(at, j, vector_at(position, k)));
  }
}

springnet_status ConstraintSet::project(const Placement& at, const springnet_vectors& position,
                                        const springnet_vectors& velocity, springnet_message& message,
                                        const std::vector<std::uint32_t>& stopped, const Rebounds& rebounds) const {
  for (std::size_t c = 0; c < rigid_.cluster_count(); ++c) {
    const springnet_status status = rigid_.project(at, c, position, velocity, message, stopped, rebounds);
    if (status != SPRINGNET_OK) return status;
  }
  for (std::uint32_t k = 0; !contact_.obstacles().empty() && k < mass_.size(); ++k)
    if (contact_.now(k).slides && is_lone(k)) contact_.project_sliding(at, k, position, velocity);
  project_pairs(at, position, velocity);
  return SPRINGNET_OK;
}

void ConstraintSet::accelerate(const Placement& at, std::uint32_t first, std::uint32_t count,
                               const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                               double* const acceleration[3]) const {
  contact_.accelerate(at, first, count, position, velocity, acceleration, rigid_.cluster_of());
}

void ConstraintSet::accelerate_clusters(const Placement& at, const springnet_const_vectors& position,
                                        const springnet_const_vectors& velocity,
                                        const springnet_vectors& acceleration) const {
  for (std::size_t c = 0; c < rigid_.cluster_count(); ++c)
    rigid_.accelerate(at, c, position, velocity, acceleration, nullptr);
}

Vector3 ConstraintSet::reaction(std::uint32_t node, const Vector3& free, const Vector3& bound,
                                const springnet_const_vectors& position, const double* tension) const {
  const Vector3 all = mass_[node] * (bound - free);
  return is_lone(node) ? all : Vector3(all - rigid_.connection_force(node, position, tension));
}

Vector3 ConstraintSet::share_of(const Placement& at, std::uint32_t node, std::size_t surface, const Vector3& position,
                                const Vector3& reaction) const {
  const Touch touch = contact_.committed(node);
  if (touch.second < 0) return reaction;
  const std::vector<Vector3> normals = contact_.normals(at, node, position);
  std::vector<double> coefficients;
  std::size_t place = normals.size();
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const auto j = static_cast<std::size_t>(touch.surfaces()[i]);
    if (j == surface) place = i;
    coefficients.push_back(sliding_coefficient_of(contact_.obstacles()[j].friction()));
  }
  return place < normals.size() ? share_reaction(normals, coefficients, reaction)[place] : Vector3(Vector3::Zero());
}

double ConstraintSet::coefficient(std::uint32_t node, std::size_t obstacle) const {
  const Friction& friction = contact_.obstacles()[obstacle].friction();
  return coefficient_of(is_lone(node) ? friction : bounded(friction));
}

void ConstraintSet::constrain(const Placement& end, std::uint32_t first, std::uint32_t count,
                              const springnet_sweep& sweep, const Vector3* read) {
  contact_.constrain(end, first, count, sweep, rigid_.cluster_of(), read);
}

void ConstraintSet::constrain(const Placement& end, std::span<const std::uint32_t> nodes, const springnet_sweep& sweep,
                              const springnet_const_vectors& read) {
  contact_.constrain(end, nodes, sweep, read);
}

springnet_status ConstraintSet::constrain_cluster(const Placement& end, std::size_t cluster,
                                                  const springnet_sweep& sweep, springnet_message& message) const {
  return rigid_.constrain(end, cluster, sweep, message);
}

springnet_status ConstraintSet::constrain_clusters(const Placement& end, const springnet_sweep& sweep,
                                                   unsigned max_threads, springnet_message& message) const {
  const auto count = static_cast<std::int64_t>(rigid_.cluster_count());
  const unsigned threads = rigid_.cluster_count() >= clusters_worth_threads ? max_threads : 1;
  std::int64_t failed_cluster = count;
  springnet_status failure = SPRINGNET_OK;
#pragma omp parallel for schedule(dynamic, 64) num_threads(static_cast <int>(threads)) if (threads > 1)
  for (std::int64_t c = 0; c < count; ++c) {
    springnet_message own{};
    // An exception that left the parallel region would end the process.
    const springnet_status status =
        sdk::detail::guarded(&own, [&] { return constrain_cluster(end, static_cast<std::size_t>(c), sweep, own); });
    if (status == SPRINGNET_OK) continue;
#pragma omp critical(springnet_clusters)
    if (c < failed_cluster) {
      failed_cluster = c;
      failure = status;
      message = own;
    }
  }
  return failure;
}

void ConstraintSet::linearise(const Placement& at, const springnet_const_vectors& position) {
  linearised_.factorised = false;
  linearised_.rows = rigid_.rows(position);
  for (std::uint32_t k = 0; !contact_.obstacles().empty() && k < mass_.size(); ++k) {
    const Touch& touch = contact_.now(k);
    if (!touch.slides || contact_.fixed()[k] != 0) continue;
    for (const std::int32_t surface : touch.surfaces())
      if (surface >= 0)
        linearised_.rows.push_back({k, ConstraintRow::no_node,
                                    contact_.normal(at, static_cast<std::size_t>(surface), vector_at(position, k)),
                                    surface});
  }
  const std::vector<ConstraintRow> of_pairs =
      bodies_.located() ? rows_of(pairs_at(position, position), true) : pushes_.rows();  // velocities do not count
  linearised_.rows.insert(linearised_.rows.end(), of_pairs.begin(), of_pairs.end());
}

Matrix3 ConstraintSet::rod_geometric_stiffness(std::size_t rod, const springnet_const_vectors& position,
                                               double tension) const {
  const auto& [first, second, length] = rigid_.rods()[rod];
  const Vector3 n = (vector_at(position, first) - vector_at(position, second)).normalized();
  return tension / length * (Matrix3::Identity() - n * n.transpose());
}

bool ConstraintSet::friction_follows_slip(const ConstraintRow& row) const {
  return row.surface >= 0 && contact_.slip_phase(row.first) == Contact::Slip::ongoing &&
         contact_.now(row.first).second < 0 &&
         sliding_coefficient_of(contact_.obstacles()[static_cast<std::size_t>(row.surface)].friction()) > 0.0;
}

Matrix3 ConstraintSet::friction_derivative(const Placement& at, const ConstraintRow& row,
                                           const springnet_const_vectors& position,
                                           const springnet_const_vectors& velocity, const Vector3& reaction) const {
  const std::uint32_t k = row.first;
  const auto j = static_cast<std::size_t>(row.surface);
  const Vector3 slip = contact_.slip_vector(at, k, j, vector_at(position, k), vector_at(velocity, k));
  const double pressing = std::max(0.0, row.direction.dot(reaction));
  const double strength = sliding_coefficient_of(contact_.obstacles()[j].friction()) * pressing / mass_[k];
  return friction_by_velocity(strength, slip, row.direction);
}

void ConstraintSet::project_change(const double* mobility, double* values, bool transposed) {
  const std::size_t n = mass_.size();
  const auto hold = [&] {
    for (std::size_t k = 0; k < n; ++k) {
      if (contact_.constrained()[k] == 0) continue;
      for (std::size_t c = 0; c < 3; ++c) values[c * n + k] = 0.0;
    }
  };
  hold();
  if (linearised_.rows.empty()) return;
  const std::size_t wanted = mobility == nullptr ? 0 : 9 * n;
  const bool same = linearised_.factorised && linearised_.mobility.size() == wanted &&
                    std::equal(linearised_.mobility.begin(), linearised_.mobility.end(), mobility);
  const auto mobility_of = [&](std::uint32_t node) -> Matrix3 {
    if (mobility == nullptr || contact_.constrained()[node] != 0) return rigid_.mobility(node);
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(mobility + 9 * std::size_t{node});
  };
  ConstraintSystem& system = linearised_.system;
  if (!same) {
    linearised_.mobility.assign(mobility, mobility + wanted);
    system.set(linearised_.rows, mobility_of);
    linearised_.factorised = true;
  }
  const auto at = [&](std::uint32_t k) { return Vector3(values[k], values[n + k], values[2 * n + k]); };
  const auto add = [&](std::uint32_t node, const Vector3& change) {
    for (std::size_t c = 0; c < 3; ++c) values[c * n + node] += change[static_cast<Eigen::Index>(c)];
  };
  if (!transposed) return system.for_each_change(system.solve(-system.rates(at)), add);
  const auto moved = [&](std::uint32_t k) -> Vector3 { return mobility_of(k).transpose() * at(k); };
  system.for_each_impulse(system.solve(-system.rates(moved)), add);
  hold();
}

void ConstraintSet::add_rates(const std::function<double(const ConstraintRow&)>& rate, double* values) {
  const std::size_t n = mass_.size();
  ConstraintSystem system;
  system.set(linearised_.rows, [&](std::uint32_t node) -> Matrix3 {
    return contact_.constrained()[node] != 0 ? Matrix3(Matrix3::Zero()) : rigid_.mobility(node);
  });
  const auto at = [&](std::uint32_t k) { return Vector3(values[k], values[n + k], values[2 * n + k]); };
  Eigen::VectorXd missing = -system.rates(at);
  for (std::size_t r = 0; r < system.rows().size(); ++r)
    missing[static_cast<Eigen::Index>(r)] += rate(system.rows()[r]);
  system.for_each_change(system.solve(missing), [&](std::uint32_t node, const Vector3& change) {
    for (std::size_t c = 0; c < 3; ++c) values[c * n + node] += change[static_cast<Eigen::Index>(c)];
  });
}

layers::Projection ConstraintSet::projection(const std::vector<double>& mobility) const {
  const auto system = std::make_shared<ConstraintSystem>();
  const auto of = [this, &mobility](std::uint32_t node) -> Matrix3 {
    if (contact_.constrained()[node] != 0) return Matrix3::Zero();
    return Eigen::Map<const Matrix3>(mobility.data() + 9 * std::size_t{node});
  };
  system->set(linearised_.rows, of);
  layers::Projection result;
  result.change = [system](double* values) {
    const auto at = [values](std::uint32_t k) { return Eigen::Map<Vector3>(values + 3 * std::size_t{k}); };
    system->for_each_change(system->solve(-system->rates(at)),
                            [&](std::uint32_t node, const Vector3& change) { at(node) += change; });
  };
  result.impulse = [this, system, of](double* values) {
    const auto at = [values](std::uint32_t k) { return Eigen::Map<Vector3>(values + 3 * std::size_t{k}); };
    const auto moved = [&](std::uint32_t k) -> Vector3 { return of(k) * at(k); };
    system->for_each_impulse(system->solve(-system->rates(moved)), [&](std::uint32_t node, const Vector3& impulse) {
      if (contact_.constrained()[node] == 0) at(node) += impulse;
    });
  };
  return result;
}

}  // namespace springnet
