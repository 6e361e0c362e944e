// Products of the transposed derivatives, for weights of accelerations.
#include <algorithm>

#include "layers/linear/axial_springs.hpp"
#include "layers/linear/linearisation.hpp"
#include "layers/linear/spring_kernels.hpp"

namespace springnet::layers {

void Linearisation::force_weights(const double* weights, double* out) const {
  const std::size_t n = layout_.node_count();
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t node = 0; node < static_cast<std::int64_t>(n); ++node) {
    const auto k = static_cast<std::size_t>(node);
    Vector3 own = Vector3::Zero();
    if (constrained_[k] == 0) {
      const Vector3 weight(weights[k], weights[n + k], weights[2 * n + k]);
      own = scales_.empty() ? Vector3(block(by_force_, k).transpose() * weight) : Vector3(scales_[3 * k] * weight);
    }
    for (std::size_t c = 0; c < 3; ++c) out[c * n + k] = own[static_cast<Eigen::Index>(c)];
  }
}

template <class Add>
void Linearisation::add_transposed_beside_springs(const double* weights, const Add& add) {
  const std::size_t n = layout_.node_count();
  const double* const f = force_weights_.data();
  const bool elements = elements_.any();
  if (elements) elements_.prepare_transposed(f);
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t node = 0; node < static_cast<std::int64_t>(n); ++node) {
    const auto k = static_cast<std::uint32_t>(node);
    Vector3 p = Vector3::Zero(), v = Vector3::Zero();
    if (constrained_[k] == 0) {
      const Vector3 weight(weights[k], weights[n + k], weights[2 * n + k]);
      p = scales_.empty() ? Vector3(block(by_position_, k).transpose() * weight)
                          : Vector3(scales_[3 * std::size_t{k} + 1] * weight);
      v = scales_.empty() ? Vector3(block(by_velocity_, k).transpose() * weight)
                          : Vector3(scales_[3 * std::size_t{k} + 2] * weight);
    }
    if (elements) elements_.add_transposed(k, f, p, v);
    add(k, p, v);
  }
  for (const Bond& bond : bonds_) {
    const auto at = [&](std::size_t k) { return Vector3(f[k], f[n + k], f[2 * n + k]); };
    const Vector3 change = bond.stiffness.transpose() * (at(bond.first) - at(bond.second));
    add(bond.first, -change, Vector3::Zero());
    add(bond.second, change, Vector3::Zero());
  }
  for (const Drag& drag : drags_) {
    double rate = 0.0;
    for_each_dragged(drag, [&](std::uint32_t k, double weight) {
      rate += weight * drag.row.direction.dot(Vector3(f[k], f[n + k], f[2 * n + k]));
    });
    for_each_dragged(drag, [&](std::uint32_t k, double weight) {
      add(k, Vector3::Zero(), Vector3(-drag.damping * rate * weight * drag.row.direction));
    });
  }
}

void Linearisation::spread_force_weights() {
  const std::size_t n = layout_.node_count();
  four_.resize(12 * n);
  const double* const f = force_weights_.data();
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t c = 0; c < 3; ++c) four_[4 * k + c] = f[c * n + k];
    four_[4 * k + 3] = 0.0;
  }
}

// The blocks of a spring are the same seen from either end, and those of elements have a symmetric pattern: each node
// sums over its own springs and blocks.
void Linearisation::transposed_times(const double* weights, double* by_position, double* by_velocity) {
  layout_.need_incidence();  // before threads do
  const std::size_t n = layout_.node_count();
  force_weights_.resize(3 * n);
  force_weights(weights, force_weights_.data());
  std::fill_n(by_position, 3 * n, 0.0);
  std::fill_n(by_velocity, 3 * n, 0.0);
  add_transposed_beside_springs(weights, [&](std::uint32_t k, const Vector3& p, const Vector3& v) {
    for (std::size_t c = 0; c < 3; ++c) {
      by_position[c * n + k] += p[static_cast<Eigen::Index>(c)];
      by_velocity[c * n + k] += v[static_cast<Eigen::Index>(c)];
    }
  });
  if (are_axial_) {
    spread_force_weights();
    double* const sums = four_.data() + 4 * n;
    for (double* const out : {by_position, by_velocity}) {
      std::fill_n(sums, 4 * n, 0.0);
      axial_->subtract_transposed(out == by_velocity ? 1.0 : 0.0, out == by_position ? 1.0 : 0.0, four_.data(), sums);
      for (std::size_t k = 0; k < n; ++k)
        for (std::size_t c = 0; c < 3; ++c) out[c * n + k] += sums[4 * k + c];
    }
    return;
  }
  const double* const f = force_weights_.data();
  const auto at = [f, n](std::size_t k) { return Vector3(f[k], f[n + k], f[2 * n + k]); };
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t node = 0; node < static_cast<std::int64_t>(n); ++node) {
    const auto k = static_cast<std::uint32_t>(node);
    Vector3 p = Vector3::Zero(), v = Vector3::Zero();
    for (const Incident* i = layout_.incident_begin(k); i != layout_.incident_end(k); ++i) {
      const Vector3 between = at(k) - at(i->other);
      p -= block(stiffness_, i->spring).transpose() * between;
      v -= block(damping_, i->spring).transpose() * between;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      by_position[c * n + k] += p[static_cast<Eigen::Index>(c)];
      by_velocity[c * n + k] += v[static_cast<Eigen::Index>(c)];
    }
  }
}

void Linearisation::weighted_transposed_times(double velocity_weight, double position_weight, const double* weights,
                                              double* out) {
  const std::size_t n = layout_.node_count();
  if (!are_axial_) {
    work_.resize(static_cast<Eigen::Index>(6 * n));
    transposed_times(weights, work_.data(), work_.data() + 3 * n);
    for (std::size_t i = 0; i < 3 * n; ++i)
      out[i] = position_weight * work_[static_cast<Eigen::Index>(i)] +
               velocity_weight * work_[static_cast<Eigen::Index>(3 * n + i)];
    return;
  }
  four_.resize(12 * n);
  const SpringKernels& kernels = spring_kernels_for(evaluator_.instruction_set());
  double* const sums = four_.data() + 4 * n;
  if (!scales_.empty() && !elements_.any() && bonds_.empty() && drags_.empty()) {
    kernels.spread(scales_.data(), position_weight, velocity_weight, n, weights, four_.data(), sums);
    for (std::size_t k = 0; k < n; ++k) {
      if (constrained_[k] == 0) continue;
      std::fill_n(four_.data() + 4 * k, 4, 0.0);
      std::fill_n(sums + 4 * k, 4, 0.0);
    }
  } else {
    force_weights_.resize(3 * n);
    force_weights(weights, force_weights_.data());
    spread_force_weights();
    std::fill_n(sums, 4 * n, 0.0);
    add_transposed_beside_springs(weights, [&](std::uint32_t k, const Vector3& p, const Vector3& v) {
      const Vector3 own = position_weight * p + velocity_weight * v;
      for (std::size_t c = 0; c < 3; ++c) sums[4 * std::size_t{k} + c] += own[static_cast<Eigen::Index>(c)];
    });
  }
  axial_->subtract_transposed(velocity_weight, position_weight, four_.data(), sums);
  kernels.gather(sums, n, out);
}

}  // namespace springnet::layers
