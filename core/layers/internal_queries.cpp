#include "layers/internal_queries.hpp"

#include <algorithm>
#include <memory>

#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"

namespace springnet::layers {
namespace {

// Calls take(group, springs, count) for the live springs of groups with internal state, some at a time.
template <class Take>
springnet_status for_springs(const Layout& layout, const Take& take) {
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    if (!layout.internal().has(g)) continue;
    const std::vector<std::uint32_t>& springs = layout.springs_of(g);
    for (std::size_t begin = 0; begin < springs.size(); begin += max_segment) {
      const std::size_t count = std::min(max_segment, springs.size() - begin);
      if (const springnet_status status = take(g, springs.data() + begin, count); status != SPRINGNET_OK) return status;
    }
  }
  return SPRINGNET_OK;
}

template <class Take>
springnet_status for_elements(const Layout& layout, const Take& take) {
  const ElementLayout& elements = layout.elements();
  for (std::uint32_t e = 0; e < elements.count(); ++e) {
    if (!elements.alive(e) || !layout.internal().has(elements.group(e))) continue;
    if (const springnet_status status = take(elements.group(e), e); status != SPRINGNET_OK) return status;
  }
  return SPRINGNET_OK;
}

}  // namespace

springnet_status start_states(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                              double* out, springnet_message& message) {
  InternalView view;
  view.start = out;
  NodeArrays starting = nodes;
  starting.internal = &view;
  const auto geometry = std::make_unique<SegmentGeometry>();
  double force[2][max_segment];  // asks for an evaluation; not written
  const PairOutputs wanted{LawOutputs{force[0]}, LawOutputs{force[1]}};
  const springnet_status status =
      for_springs(layout, [&](std::size_t group, const std::uint32_t* springs, std::size_t count) {
        return evaluate_springs(layout, set, time, starting, group, springs, count, *geometry, wanted, message);
      });
  if (status != SPRINGNET_OK) return status;
  return for_elements(layout, [&](std::size_t, std::uint32_t element) {
    return evaluate_element(layout, set, time, starting, element, element_state(layout, nodes, element), wanted,
                            message);
  });
}

void invariants_of_states(const Layout& layout, InstructionSet set, const NodeArrays& nodes, double* q, double* rate) {
  const InternalLayout& internal = layout.internal();
  const auto put = [&](std::size_t group, std::uint32_t place, const double(&values)[2], const double(&rates)[2]) {
    const InternalLayout::OfGroup& own = internal.group(group);
    const std::array<const Law*, 2> laws = layout.laws().groups[group].laws();
    for (std::size_t k = 0; k < laws.size(); ++k) {
      if (laws[k]->state_count == 0) continue;
      const std::uint64_t at = own.first + laws[k]->first_state * own.count + place;
      q[at] = values[k];
      rate[at] = rates[k];
    }
  };
  const Kernels& kernels = kernels_for(set);
  const auto geometry = std::make_unique<SegmentGeometry>();
  static_cast<void>(for_springs(layout, [&](std::size_t group, const std::uint32_t* springs, std::size_t count) {
    std::uint32_t first[max_segment], second[max_segment];
    for (std::size_t i = 0; i < count; ++i) {
      first[i] = layout.first(springs[i]);
      second[i] = layout.second(springs[i]);
    }
    const SegmentSprings segment{nullptr, nullptr, static_cast<std::uint32_t>(count), first, second};
    kernels.lengths_and_rates(segment, nodes, *geometry);
    kernels.relative_speeds(segment, nodes, *geometry);
    const std::array<const Law*, 2> laws = layout.laws().groups[group].laws();
    for (std::size_t i = 0; i < count; ++i) {
      double values[2], rates[2];
      for (std::size_t k = 0; k < laws.size(); ++k) {
        values[k] = laws[k]->relative ? geometry->speed[i] : geometry->length[i];
        rates[k] = laws[k]->relative ? 0.0 : geometry->rate[i];
      }
      put(group, internal.of_spring(springs[i]), values, rates);
    }
    return springnet_status{SPRINGNET_OK};
  }));
  static_cast<void>(for_elements(layout, [&](std::size_t group, std::uint32_t element) {
    const ElementState state = element_state(layout, nodes, element);
    put(group, internal.of_element(element), {state.value, state.value}, {state.rate, state.rate});
    return springnet_status{SPRINGNET_OK};
  }));
}

}  // namespace springnet::layers
