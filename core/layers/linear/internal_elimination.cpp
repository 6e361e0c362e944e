#include "layers/linear/internal_elimination.hpp"

#include <algorithm>
#include <cmath>

#include "layers/elements/invariant.hpp"
#include "layers/internal_members.hpp"
#include "layers/internal_queries.hpp"

namespace springnet::layers {
void InternalElimination::begin(const NodeArrays& nodes, double weight, InternalView& view) {
  const std::size_t n = layout_.node_count(), count = layout_.internal().count();
  weight_ = weight;
  state_.resize(6 * n);
  const double* const from[] = {nodes.px, nodes.py, nodes.pz, nodes.vx, nodes.vy, nodes.vz};
  for (std::size_t c = 0; c < 6; ++c) std::copy_n(from[c], n, state_.data() + c * n);
  for (std::vector<double>* values : {&record_.force_by_state, &record_.rate_by_q, &record_.rate_by_rate})
    values->assign(count, 0.0);
  record_.inverse.assign(count * max_states, 0.0);
  view.elimination = weight;
  view.record = &record_;
}

NodeArrays InternalElimination::nodes_at(const std::vector<double>& state) const noexcept {
  const std::size_t n = layout_.node_count();
  const double* const x = state.data();
  return {x, x + n, x + 2 * n, x + 3 * n, x + 4 * n, x + 5 * n};
}

// Central differences: errors of 1e-10 of the change are far below those of an inexact Newton method.
void InternalElimination::differentiate(const double* dp, const double* dv) {
  constexpr double relative = 1e-6;
  const std::size_t n = layout_.node_count(), count = layout_.internal().count();
  for (auto* values : {&q_[0], &q_[1], &rate_[0], &rate_[1]}) values->assign(count, 0.0);
  if (dp == nullptr || dv == nullptr) return;
  const auto greatest = [](const double* values, std::size_t size) {
    double result = 0.0;
    for (std::size_t i = 0; i < size; ++i) result = std::max(result, std::abs(values[i]));
    return result;
  };
  double length = 0.0;
  for_each_spring_with_states(layout_, [&](std::uint32_t s, std::size_t, std::uint32_t) {
    for (std::size_t c = 0; c < 3; ++c)
      length = std::max(length, std::abs(state_[c * n + layout_.first(s)] - state_[c * n + layout_.second(s)]));
  });
  for_each_element_with_states(layout_, [&](std::uint32_t e, std::size_t, std::uint32_t) {
    for (const std::uint32_t k : layout_.elements().nodes(e))
      for (std::size_t c = 0; c < 3; ++c)
        length = std::max(length, std::abs(state_[c * n + k] - state_[c * n + layout_.elements().nodes(e)[0]]));
  });
  const double moves = greatest(dp, 3 * n), turns = greatest(dv, 3 * n);
  if (moves == 0.0 && turns == 0.0) return;
  const double speed = std::max(greatest(state_.data() + 3 * n, 3 * n), length);
  const double h = relative / std::max(length > 0.0 ? moves / length : 0.0, speed > 0.0 ? turns / speed : 0.0);
  if (!std::isfinite(h)) return;
  shifted_.resize(6 * n);
  for (std::size_t side = 0; side < 2; ++side) {
    const double step = side == 0 ? -h : h;
    for (std::size_t i = 0; i < 3 * n; ++i) {
      shifted_[i] = state_[i] + step * dp[i];
      shifted_[3 * n + i] = state_[3 * n + i] + step * dv[i];
    }
    invariants_of_states(layout_, set_, nodes_at(shifted_), q_[side].data(), rate_[side].data());
  }
  for (std::size_t i = 0; i < count; ++i) {
    q_[0][i] = (q_[1][i] - q_[0][i]) / (2.0 * h);
    rate_[0][i] = (rate_[1][i] - rate_[0][i]) / (2.0 * h);
  }
}

void InternalElimination::change(const double* right_side, const double* dp, const double* dv, double* change) {
  const std::size_t count = layout_.internal().count();
  differentiate(dp, dv);
  std::copy_n(right_side, count, change);  // of removed elements: their states stay
  const auto solve = [&](std::uint32_t, std::size_t group, std::uint32_t place) {
    for_each_law_with_states(layout_, group, place, [&](const Law& law, std::uint64_t first, std::uint64_t pitch) {
      double b[max_states];
      for (std::size_t j = 0; j < law.state_count; ++j) {
        const std::uint64_t at = first + j * pitch;
        b[j] = right_side[at] +
               weight_ * (record_.rate_by_q[at] * q_[0][first] + record_.rate_by_rate[at] * rate_[0][first]);
      }
      for (std::size_t j = 0; j < law.state_count; ++j) {
        double sum = 0.0;
        for (std::size_t k = 0; k < law.state_count; ++k)
          sum += record_.inverse[(first + j * pitch) * max_states + k] * b[k];
        change[first + j * pitch] = sum;
      }
    });
  };
  for_each_spring_with_states(layout_, solve);
  for_each_element_with_states(layout_, solve);
}

void InternalElimination::add_forces(const double* change, double* force) const {
  const std::size_t n = layout_.node_count();
  const NodeArrays nodes = nodes_at(state_);
  const auto tension = [&](const Law& law, std::uint64_t first, std::uint64_t pitch) {
    double sum = 0.0;
    for (std::size_t j = 0; j < law.state_count; ++j)
      sum += record_.force_by_state[first + j * pitch] * change[first + j * pitch];
    return sum;
  };
  const auto add = [&](std::uint32_t node, const Vector3& value) {
    for (std::size_t c = 0; c < 3; ++c) force[c * n + node] += value[static_cast<Eigen::Index>(c)];
  };
  const auto vector = [&](std::size_t component, std::uint32_t k) {
    return Vector3(state_[component * n + k], state_[(component + 1) * n + k], state_[(component + 2) * n + k]);
  };
  for_each_spring_with_states(layout_, [&](std::uint32_t s, std::size_t group, std::uint32_t place) {
    const std::uint32_t a = layout_.first(s), b = layout_.second(s);
    for_each_law_with_states(layout_, group, place, [&](const Law& law, std::uint64_t first, std::uint64_t pitch) {
      const std::size_t component = law.relative ? 3 : 0;
      const Vector3 along = vector(component, a) - vector(component, b);
      const double length = along.norm();
      if (!(length > 0.0)) return;
      const Vector3 push = tension(law, first, pitch) / length * along;
      add(a, -push);
      add(b, push);
    });
  });
  for_each_element_with_states(layout_, [&](std::uint32_t e, std::size_t group, std::uint32_t place) {
    double sum = 0.0;
    for_each_law_with_states(layout_, group, place, [&](const Law& law, std::uint64_t first, std::uint64_t pitch) {
      sum += tension(law, first, pitch);
    });
    const ElementLayout& elements = layout_.elements();
    const std::span<const std::uint32_t> own = elements.nodes(e);
    if (elements.invariant(e) == Invariant::enclosed_volume) {
      for (const ElementLayout::EnclosureElement& enclosure : elements.enclosures())
        for (std::size_t i = 0; enclosure.element == e && i < own.size(); ++i)
          add(own[i], -sum * enclosure.shape.gradient(i, nodes));
      return;
    }
    Corners corners;
    FirstOrder geometry;
    gather(own.data(), own.size(), nodes, corners);
    first_order(elements.invariant(e), corners, geometry);
    for (std::size_t i = 0; i < own.size(); ++i) add(own[i], -sum * geometry.gradient[i]);
  });
}

}  // namespace springnet::layers
