#include "layers/linear/state_step.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <utility>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "layers/elements/queries.hpp"
#include "layers/internal_members.hpp"
#include "layers/node_vectors.hpp"
#include "layers/springs/queries.hpp"
#include "plugin_host/call.hpp"

namespace springnet::layers {
namespace {

// How the invariant q that a law reads, and its rate u, change with a node.
struct Gradient {
  Vector3 q_by_p = Vector3::Zero(), q_by_v = Vector3::Zero(), u_by_p = Vector3::Zero(), u_by_v = Vector3::Zero();
};

// Calls use(node, gradient). Where an invariant has no gradient it is zero.
template <class Use>
void for_each_node(const Layout& layout, const NodeArrays& nodes, bool relative, std::uint32_t spring, const Use& use) {
  const std::uint32_t a = layout.first(spring), b = layout.second(spring);
  const Vector3 dp = position_of(nodes, a) - position_of(nodes, b), dv = velocity_of(nodes, a) - velocity_of(nodes, b);
  const double length = dp.norm(), speed = dv.norm();
  Gradient own;
  if (relative && speed > 0.0) own.q_by_v = dv / speed;
  if (!relative && length > 0.0) {
    own.q_by_p = own.u_by_v = dp / length;
    own.u_by_p = (dv - own.q_by_p.dot(dv) * own.q_by_p) / length;
  }
  use(a, own);
  use(b, Gradient{-own.q_by_p, -own.q_by_v, -own.u_by_p, -own.u_by_v});
}

template <class Use>
void for_each_node_of_element(const Layout& layout, const NodeArrays& nodes, std::uint32_t element, const Use& use) {
  const ElementLayout& elements = layout.elements();
  const auto add = [&](std::uint32_t node, const Vector3& gradient, const Vector3& rate_gradient) {
    use(node, Gradient{gradient, Vector3::Zero(), rate_gradient, gradient});
  };
  if (elements.invariant(element) == Invariant::enclosed_volume) {
    for (const ElementLayout::EnclosureElement& enclosure : elements.enclosures())
      for (std::size_t i = 0; enclosure.element == element && i < enclosure.shape.size(); ++i)
        add(enclosure.shape.nodes()[i], enclosure.shape.gradient(i, nodes), enclosure.shape.rate_gradient(i, nodes));
    return;
  }
  const std::span<const std::uint32_t> own = elements.nodes(element);
  Corners corners;
  FirstOrder first;
  SecondOrder second;
  gather(own.data(), own.size(), nodes, corners);
  first_order(elements.invariant(element), corners, first);
  second_order(elements.invariant(element), corners, second);
  for (std::size_t i = 0; i < own.size(); ++i) add(own[i], first.gradient[i], second.rate_gradient[i]);
}

// Calls use(law, index of its first state, distance of its states, function that calls back for each of its nodes).
template <class Use>
void for_each_member(const Layout& layout, const NodeArrays& nodes, const Use& use) {
  for_each_spring_with_states(layout, [&](std::uint32_t s, std::size_t group, std::uint32_t place) {
    for_each_law_with_states(layout, group, place, [&](const Law& law, std::uint64_t first, std::uint64_t pitch) {
      use(law, first, pitch, [&](const auto& each) { for_each_node(layout, nodes, law.relative, s, each); });
    });
  });
  for_each_element_with_states(layout, [&](std::uint32_t e, std::size_t group, std::uint32_t place) {
    for_each_law_with_states(layout, group, place, [&](const Law& law, std::uint64_t first, std::uint64_t pitch) {
      use(law, first, pitch, [&](const auto& each) { for_each_node_of_element(layout, nodes, e, each); });
    });
  });
}

class OfNodes {
 public:
  explicit OfNodes(std::size_t count) : n_(count) {}
  [[nodiscard]] Vector3 at(const double* values, std::uint32_t k) const {
    return {values[k], values[n_ + k], values[2 * n_ + k]};
  }
  void add(double* values, std::uint32_t k, const Vector3& change) const {
    for (std::size_t c = 0; c < 3; ++c) values[c * n_ + k] += change[static_cast<Eigen::Index>(c)];
  }

 private:
  std::size_t n_;
};

}  // namespace

// Which entries of the Jacobians of the laws of some springs or elements are asked for, and where they go.
class StateStep::Wanted {
 public:
  Wanted(const Group& group, bool steps, std::size_t members) : group_(group), steps_(steps), members_(members) {
    const std::array<const Law*, 2> laws = group.laws();
    for (std::size_t k = 0; k < 2; ++k) {
      const Law& law = *laws[k];
      if (law.state_count == 0) continue;
      if (!law.can(SPRINGNET_HAS_ALL_DERIVATIVES))
        throw Error(ErrorKind::plugin,
                    fmt::format("{} does not give the derivatives of its internal states; build it with an SDK of ABI "
                                "2.1 or newer",
                                full_name(*law.component)));
      const sdk::JacobianLayout jacobian = jacobian_of(law);
      columns_[k] = jacobian.columns(steps);
      matrix_[k].assign(jacobian.rows() * columns_[k], nullptr);
      values_[k].resize(jacobian.rows() * (law.state_count + 4) * members);
      std::size_t used = 0;
      const auto want = [&](std::size_t row, std::size_t column) {
        matrix_[k][row * columns_[k] + column] = values_[k].data() + members * used++;
      };
      for (std::size_t j = 0; j < law.state_count; ++j) want(jacobian.force(), jacobian.state(j));
      if (!steps) continue;
      want(jacobian.force(), jacobian.start_value());
      want(jacobian.force(), jacobian.start_rate());
      for (std::size_t i = 0; i < law.state_count; ++i) {
        for (std::size_t j = 0; j < law.state_count; ++j) want(jacobian.state_row(i), jacobian.state(j));
        want(jacobian.state_row(i), jacobian.value());
        want(jacobian.state_row(i), jacobian.rate());
        want(jacobian.state_row(i), jacobian.start_value());
        want(jacobian.state_row(i), jacobian.start_rate());
      }
    }
  }
  [[nodiscard]] PairOutputs outputs() {
    PairOutputs out{};
    for (std::size_t k = 0; k < 2; ++k)
      if (!matrix_[k].empty()) out[k].derivatives = matrix_[k].data();
    return out;
  }
  // Of the i-th member, whose states are at this place.
  void store(std::size_t i, const InternalLayout::OfGroup& own, std::uint32_t place, StateStep& to) const {
    const std::array<const Law*, 2> laws = group_.laws();
    for (std::size_t k = 0; k < 2; ++k) {
      const Law& law = *laws[k];
      if (law.state_count == 0) continue;
      const sdk::JacobianLayout jacobian = jacobian_of(law);
      const auto value = [&](std::size_t row, std::size_t column) { return matrix_[k][row * columns_[k] + column][i]; };
      const std::uint64_t first = own.first + law.first_state * own.count + place;
      for (std::size_t j = 0; j < law.state_count; ++j)
        to.force_by_state_[first + j * own.count] = value(jacobian.force(), jacobian.state(j));
      if (!steps_) continue;
      to.force_by_start_q_[first] = value(jacobian.force(), jacobian.start_value());
      to.force_by_start_u_[first] = value(jacobian.force(), jacobian.start_rate());
      for (std::size_t row = 0; row < law.state_count; ++row) {
        const std::uint64_t at = first + row * own.count;
        const std::size_t from = jacobian.state_row(row);
        for (std::size_t j = 0; j < law.state_count; ++j)
          to.next_by_state_[at * max_states + j] = value(from, jacobian.state(j));
        to.next_by_q_[at] = value(from, jacobian.value());
        to.next_by_u_[at] = value(from, jacobian.rate());
        to.next_by_start_q_[at] = value(from, jacobian.start_value());
        to.next_by_start_u_[at] = value(from, jacobian.start_rate());
      }
    }
  }

 private:
  const Group& group_;
  bool steps_;
  std::size_t members_;
  std::size_t columns_[2] = {};
  std::vector<double*> matrix_[2];
  std::vector<double> values_[2];
};

springnet_status StateStep::find(double time, const NodeArrays& nodes, springnet_message& message) {
  steps_ = nodes.internal->time_step > 0.0;
  const std::size_t count = layout_.internal().count();
  for (std::vector<double>* values : {&force_by_state_, &next_by_q_, &next_by_u_, &next_by_start_q_, &next_by_start_u_,
                                      &force_by_start_q_, &force_by_start_u_})
    values->assign(count, 0.0);
  next_by_state_.assign(count * max_states, 0.0);
  for (std::size_t g = 0; g < layout_.laws().groups.size(); ++g) {
    if (!layout_.internal().has(g)) continue;
    if (const springnet_status status = find_springs(g, time, nodes, message); status != SPRINGNET_OK) return status;
  }
  springnet_status status = SPRINGNET_OK;
  for_each_element_with_states(layout_, [&](std::uint32_t e, std::size_t group, std::uint32_t place) {
    if (status != SPRINGNET_OK) return;
    Wanted wanted(layout_.laws().groups[group], steps_, 1);
    status =
        evaluate_element(layout_, set_, time, nodes, e, element_state(layout_, nodes, e), wanted.outputs(), message);
    if (status == SPRINGNET_OK) wanted.store(0, layout_.internal().group(group), place, *this);
  });
  return status;
}

springnet_status StateStep::find_springs(std::size_t group, double time, const NodeArrays& nodes,
                                         springnet_message& message) {
  const std::vector<std::uint32_t>& springs = layout_.springs_of(group);
  if (springs.empty()) return SPRINGNET_OK;
  const auto geometry = std::make_unique<SegmentGeometry>();
  Wanted wanted(layout_.laws().groups[group], steps_, max_segment);
  for (std::size_t begin = 0; begin < springs.size(); begin += max_segment) {
    const std::size_t count = std::min(max_segment, springs.size() - begin);
    const std::uint32_t* const own = springs.data() + begin;
    const springnet_status status =
        evaluate_springs(layout_, set_, time, nodes, group, own, count, *geometry, wanted.outputs(), message);
    if (status != SPRINGNET_OK) return status;
    for (std::size_t i = 0; i < count; ++i)
      wanted.store(i, layout_.internal().group(group), layout_.internal().of_spring(own[i]), *this);
  }
  return SPRINGNET_OK;
}

void StateStep::invariants(const NodeArrays& nodes, const double* dp, const double* dv, double* q, double* u) const {
  const OfNodes of(layout_.node_count());
  std::fill_n(q, layout_.internal().count(), 0.0);
  std::fill_n(u, layout_.internal().count(), 0.0);
  for_each_member(layout_, nodes, [&](const Law&, std::uint64_t first, std::uint64_t, const auto& for_nodes) {
    for_nodes([&](std::uint32_t k, const Gradient& by) {
      const Vector3 p = of.at(dp, k), v = of.at(dv, k);
      q[first] += by.q_by_p.dot(p) + by.q_by_v.dot(v);
      u[first] += by.u_by_p.dot(p) + by.u_by_v.dot(v);
    });
  });
}

void StateStep::weigh_invariants(const NodeArrays& nodes, const double* q, const double* u, double* by_position,
                                 double* by_velocity) const {
  const OfNodes of(layout_.node_count());
  for_each_member(layout_, nodes, [&](const Law&, std::uint64_t first, std::uint64_t, const auto& for_nodes) {
    if (q[first] == 0.0 && u[first] == 0.0) return;
    for_nodes([&](std::uint32_t k, const Gradient& by) {
      of.add(by_position, k, q[first] * by.q_by_p + u[first] * by.u_by_p);
      of.add(by_velocity, k, q[first] * by.q_by_v + u[first] * by.u_by_v);
    });
  });
}

void StateStep::from_start(const NodeArrays& nodes, const double* z0, const double* q0, const double* u0, double* force,
                           double* next) const {
  const OfNodes of(layout_.node_count());
  if (next != nullptr) std::copy_n(z0, layout_.internal().count(), next);  // of what has been removed
  for_each_member(layout_, nodes, [&](const Law& law, std::uint64_t first, std::uint64_t pitch, const auto& for_nodes) {
    double Q = 0.0;
    for (std::size_t j = 0; j < law.state_count; ++j) Q += force_by_state_[first + j * pitch] * z0[first + j * pitch];
    if (steps_) {
      Q += force_by_start_q_[first] * q0[first] + force_by_start_u_[first] * u0[first];
      for (std::size_t i = 0; i < law.state_count; ++i) {
        const std::uint64_t at = first + i * pitch;
        double sum = next_by_start_q_[at] * q0[first] + next_by_start_u_[at] * u0[first];
        for (std::size_t j = 0; j < law.state_count; ++j)
          sum += next_by_state_[at * max_states + j] * z0[first + j * pitch];
        next[at] = sum;
      }
    }
    if (Q == 0.0) return;
    for_nodes([&](std::uint32_t k, const Gradient& by) { of.add(force, k, -Q * (by.q_by_p + by.q_by_v)); });
  });
}

void StateStep::weigh_start(const NodeArrays& nodes, const double* force, const double* next, double* z0, double* q0,
                            double* u0) const {
  const OfNodes of(layout_.node_count());
  std::vector<double> of_next(layout_.internal().count(), 0.0);  // of what has been removed it stays
  if (next != nullptr) std::copy_n(next, of_next.size(), of_next.begin());
  for_each_member(layout_, nodes, [&](const Law& law, std::uint64_t first, std::uint64_t pitch, const auto& for_nodes) {
    double Q = 0.0;
    for_nodes([&](std::uint32_t k, const Gradient& by) { Q -= of.at(force, k).dot(by.q_by_p + by.q_by_v); });
    double own[max_states];
    for (std::size_t j = 0; j < law.state_count; ++j) own[j] = Q * force_by_state_[first + j * pitch];
    if (steps_) {
      q0[first] += Q * force_by_start_q_[first];
      u0[first] += Q * force_by_start_u_[first];
      for (std::size_t i = 0; i < law.state_count; ++i) {
        const std::uint64_t at = first + i * pitch;
        q0[first] += next[at] * next_by_start_q_[at];
        u0[first] += next[at] * next_by_start_u_[at];
        for (std::size_t j = 0; j < law.state_count; ++j) own[j] += next[at] * next_by_state_[at * max_states + j];
      }
    }
    for (std::size_t j = 0; j < law.state_count; ++j) of_next[first + j * pitch] = own[j];
  });
  for (std::size_t i = 0; i < of_next.size(); ++i) z0[i] += of_next[i];
}

template <class Use>
void StateStep::for_each(const Use& use) const {
  const auto of_member = [&](std::uint32_t, std::size_t group, std::uint32_t place) {
    for_each_law_with_states(layout_, group, place, use);
  };
  for_each_spring_with_states(layout_, of_member);
  for_each_element_with_states(layout_, of_member);
}

void StateStep::from_end(const double* q, const double* u, double* next) const {
  for_each([&](const Law& law, std::uint64_t first, std::uint64_t pitch) {
    for (std::uint64_t at = first; at < first + law.state_count * pitch; at += pitch)
      next[at] += next_by_q_[at] * q[first] + next_by_u_[at] * u[first];
  });
}

void StateStep::weigh_end(const double* next, double* q, double* u) const {
  std::fill_n(q, layout_.internal().count(), 0.0);
  std::fill_n(u, layout_.internal().count(), 0.0);
  for_each([&](const Law& law, std::uint64_t first, std::uint64_t pitch) {
    for (std::uint64_t at = first; at < first + law.state_count * pitch; at += pitch) {
      q[first] += next_by_q_[at] * next[at];
      u[first] += next_by_u_[at] * next[at];
    }
  });
}

}  // namespace springnet::layers
