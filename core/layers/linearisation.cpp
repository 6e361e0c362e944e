#include "layers/linearisation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "layers/elements.hpp"
#include "layers/message.hpp"

namespace springnet::layers {
Linearisation::Linearisation(const Layout& layout, const Evaluator& evaluator,
                             const std::vector<std::uint8_t>& constrained)
    : layout_(layout), evaluator_(evaluator), constrained_(constrained) {}

springnet_status Linearisation::update(double time, const NodeArrays& nodes, const ExternalForces& external,
                                       springnet_message& message) {
  const std::size_t n = layout_.node_count();
  known_ = false;
  stiffness_.resize(9 * layout_.spring_count());
  damping_.resize(9 * layout_.spring_count());
  const auto geometry = std::make_unique<SegmentGeometry>();
  double q[2][max_segment], by_q[2][max_segment], by_rate[2][max_segment];
  for (std::size_t g = 0; g < layout_.laws().groups.size(); ++g) {
    const Group& group = layout_.laws().groups[g];
    LawOutputs out[2];
    const Law* laws[2] = {&group.spring, &group.viscosity};
    for (int i = 0; i < 2; ++i) {
      if (*laws[i] && !laws[i]->can(SPRINGNET_HAS_DERIVATIVES)) {
        set_message(message, fmt::format("{} '{}' offers no derivatives, which implicit methods need; write it with "
                                         "springnet/sdk/law.hpp, or choose an explicit method",
                                         name_of(laws[i]->component->kind()), laws[i]->component->id()));
        return SPRINGNET_FAILED;
      }
      out[i].force = q[i];
      out[i].force_by_q = by_q[i];
      if (laws[i]->reads_rate) out[i].force_by_rate = by_rate[i];
    }
    const std::vector<std::uint32_t>& springs = layout_.springs_of(g);
    for (std::size_t begin = 0; begin < springs.size(); begin += max_segment) {
      const std::size_t count = std::min(max_segment, springs.size() - begin);
      const springnet_status status =
          evaluate_elements(layout_, evaluator_.instruction_set(), time, nodes, g, springs.data() + begin, count,
                            *geometry, out[0], out[1], message);
      if (status != SPRINGNET_OK) return status;
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t s = springs[begin + i];
        const Vector3 normal(geometry->nx[i], geometry->ny[i], geometry->nz[i]);
        const Vector3 along(geometry->sx[i], geometry->sy[i], geometry->sz[i]);
        const double length = geometry->length[i], speed = geometry->speed[i];
        double tension = 0.0, by_length = 0.0, by_u = 0.0;
        Block damping = Block::Zero();
        for (int j = 0; j < 2; ++j) {
          if (!*laws[j]) continue;
          if (laws[j]->relative) {
            if (speed > 0.0)
              damping += by_q[j][i] * along * along.transpose() +
                         (q[j][i] / speed) * (Block::Identity() - along * along.transpose());
            else
              damping += by_q[j][i] * Block::Identity();
          } else {
            tension += q[j][i];
            by_length += by_q[j][i];
            if (laws[j]->reads_rate) by_u += by_rate[j][i];
          }
        }
        const Block projector = normal * normal.transpose();
        damping += by_u * projector;
        Block stiffness = by_length * projector;
        if (length > 0.0) {
          stiffness += (tension / length) * (Block::Identity() - projector);
          const Vector3 across = (speed * along - geometry->rate[i] * normal) / length;
          stiffness += by_u * normal * across.transpose();
        }
        Eigen::Map<Block>(stiffness_.data() + 9 * std::size_t{s}) = stiffness;
        Eigen::Map<Block>(damping_.data() + 9 * std::size_t{s}) = damping;
      }
    }
  }
  for (const NeuronKind& neuron : layout_.laws().neurons) {
    if ((neuron.component->description->capabilities & SPRINGNET_HAS_DERIVATIVES) == 0) {
      set_message(message, fmt::format("neuron '{}' offers no derivatives, which implicit methods need; write it with "
                                       "springnet/sdk/neuron.hpp, or choose an explicit method",
                                       neuron.component->id()));
      return SPRINGNET_FAILED;
    }
  }
  for (int c = 0; c < 3; ++c) {
    force_[c].resize(n);
    acceleration_[c].resize(n);
  }
  by_force_.assign(9 * n, 0.0);
  by_position_.assign(9 * n, 0.0);
  by_velocity_.assign(9 * n, 0.0);
  const springnet_status status =
      evaluator_.evaluate(time, nodes, external, {force_[0].data(), force_[1].data(), force_[2].data()}, {}, message);
  if (status != SPRINGNET_OK) return status;
  const double* force[3] = {force_[0].data(), force_[1].data(), force_[2].data()};
  double* acceleration[3] = {acceleration_[0].data(), acceleration_[1].data(), acceleration_[2].data()};
  const springnet_status neurons =
      evaluator_.accelerations(0, static_cast<std::uint32_t>(n), time, nodes, force, acceleration, by_force_.data(),
                               by_position_.data(), by_velocity_.data(), message);
  known_ = neurons == SPRINGNET_OK;
  return neurons;
}

void Linearisation::times(const double* dp, const double* dv, double* out) const {
  const std::size_t n = layout_.node_count();
  const auto at = [n](const double* values, std::size_t k) {
    return Vector3(values[k], values[n + k], values[2 * n + k]);
  };
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(evaluator_.threads()))
  for (std::int64_t node = 0; node < static_cast<std::int64_t>(n); ++node) {
    const auto k = static_cast<std::uint32_t>(node);
    Vector3 result = Vector3::Zero();
    if (constrained_[k] == 0) {
      const Vector3 p = at(dp, k), v = at(dv, k);
      Vector3 force = Vector3::Zero();
      for (const Incident* i = layout_.incident_begin(k); i != layout_.incident_end(k); ++i)
        force -=
            block(stiffness_, i->spring) * (p - at(dp, i->other)) + block(damping_, i->spring) * (v - at(dv, i->other));
      result = block(by_force_, k) * force + block(by_position_, k) * p + block(by_velocity_, k) * v;
    }
    out[k] = result[0];
    out[n + k] = result[1];
    out[2 * n + k] = result[2];
  }
}

void Linearisation::diagonal_blocks(double velocity_weight, double position_weight, double* out) const {
  for (std::uint32_t k = 0; k < layout_.node_count(); ++k) {
    Block sum = Block::Zero();
    for (const Incident* i = layout_.incident_begin(k); i != layout_.incident_end(k); ++i)
      sum += velocity_weight * block(damping_, i->spring) + position_weight * block(stiffness_, i->spring);
    Eigen::Map<Block> result(out + 9 * std::size_t{k});
    result.setIdentity();
    if (constrained_[k] == 0)
      result += block(by_force_, k) * sum - velocity_weight * block(by_velocity_, k) -
                position_weight * block(by_position_, k);
  }
}

// Column 3 j + c has rows 3 i + r for i = j and all neighbours i of j, r = 0, 1, 2, by rising engine's number.
void Linearisation::make_pattern() {
  const std::uint32_t n = layout_.node_count();
  const std::vector<std::uint32_t>& start = layout_.neighbour_start();
  const std::vector<std::uint32_t>& neighbours = layout_.neighbours();
  matrix_.resize(3 * static_cast<Eigen::Index>(n), 3 * static_cast<Eigen::Index>(n));
  matrix_.resizeNonZeros(9 * (static_cast<Eigen::Index>(neighbours.size()) + static_cast<Eigen::Index>(n)));
  std::vector<std::uint32_t> rows;
  int at = 0;
  for (std::uint32_t j = 0; j < n; ++j) {
    rows.assign(neighbours.begin() + start[j], neighbours.begin() + start[j + 1]);
    rows.push_back(j);
    std::sort(rows.begin(), rows.end());
    for (int c = 0; c < 3; ++c) {
      matrix_.outerIndexPtr()[3 * j + static_cast<std::uint32_t>(c)] = at;
      for (const std::uint32_t i : rows)
        for (int r = 0; r < 3; ++r) matrix_.innerIndexPtr()[at++] = static_cast<int>(3 * i) + r;
    }
  }
  matrix_.outerIndexPtr()[3 * n] = at;
  std::fill_n(matrix_.valuePtr(), at, 0.0);
  factors_.analyzePattern(matrix_);
  pattern_known_ = true;
}

springnet_status Linearisation::factorise(double velocity_weight, double position_weight, springnet_message& message) {
  if (!known_) {
    set_message(message, "factorise was called before linearise");
    return SPRINGNET_FAILED;
  }
  if (!pattern_known_) make_pattern();
  const std::uint32_t n = layout_.node_count();
  double* values = matrix_.valuePtr();
  std::fill_n(values, matrix_.nonZeros(), 0.0);
  std::vector<double> diagonal(9 * std::size_t{n});
  diagonal_blocks(velocity_weight, position_weight, diagonal.data());
  for (std::uint32_t j = 0; j < n; ++j) {
    const int column = matrix_.outerIndexPtr()[3 * j];
    const int height = matrix_.outerIndexPtr()[3 * j + 1] - column;
    const int* rows = matrix_.innerIndexPtr() + column;
    const auto add = [&](std::uint32_t i, const Block& value) {
      const auto place = static_cast<int>(std::lower_bound(rows, rows + height, static_cast<int>(3 * i)) - rows);
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) values[column + c * height + place + r] += value(r, c);
    };
    add(j, block(diagonal, j));
    for (const Incident* i = layout_.incident_begin(j); i != layout_.incident_end(j); ++i) {
      if (constrained_[i->other] != 0) continue;
      add(i->other, -(block(by_force_, i->other) *
                      (velocity_weight * block(damping_, i->spring) + position_weight * block(stiffness_, i->spring))));
    }
  }
  factors_.factorize(matrix_);
  if (factors_.info() != Eigen::Success) {
    set_message(message, fmt::format("the linear system of the step is singular: {}", factors_.lastErrorMessage()));
    return SPRINGNET_RECOVERABLE;
  }
  return SPRINGNET_OK;
}

springnet_status Linearisation::solve(bool transposed, const double* right_side, double* x,
                                      springnet_message& message) {
  const std::size_t n = layout_.node_count();
  work_.resize(static_cast<Eigen::Index>(3 * n));
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t c = 0; c < 3; ++c) work_[static_cast<Eigen::Index>(3 * k + c)] = right_side[c * n + k];
  if (factors_.info() != Eigen::Success || static_cast<std::size_t>(factors_.rows()) != 3 * n) {
    set_message(message, "solve was called without a factorisation");
    return SPRINGNET_FAILED;
  }
  const Eigen::VectorXd solution =
      transposed ? Eigen::VectorXd(factors_.transpose().solve(work_)) : Eigen::VectorXd(factors_.solve(work_));
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t c = 0; c < 3; ++c) x[c * n + k] = solution[static_cast<Eigen::Index>(3 * k + c)];
  return SPRINGNET_OK;
}

}  // namespace springnet::layers
