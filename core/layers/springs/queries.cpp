#include "layers/springs/queries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "layers/elements/queries.hpp"
#include "plugin_host/call.hpp"

namespace springnet::layers {

namespace {

springnet_status evaluate_group(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                const Group& group, const std::uint32_t* springs, std::size_t count,
                                SegmentGeometry& geometry, const LawOutputs& spring, const LawOutputs& viscosity,
                                springnet_message& message) {
  std::uint32_t first[max_segment], second[max_segment], rows[max_segment];
  for (std::size_t i = 0; i < count; ++i) {
    first[i] = layout.first(springs[i]);
    second[i] = layout.second(springs[i]);
    rows[i] = layout.laws().row[springs[i]];
  }
  const SegmentSprings segment{nullptr, 0, 0, static_cast<std::uint32_t>(count), first, second};
  const Kernels& kernels = kernels_for(set);
  kernels.lengths_and_rates(segment, nodes, geometry);
  kernels.relative_speeds(segment, nodes, geometry);
  const auto call = [&](const Law& law, const LawOutputs& out) -> springnet_status {
    if (!law) return SPRINGNET_OK;
    return call_law(group, law, abi_number(set), time, count, {rows, 0},
                    law.relative ? geometry.speed : geometry.length, geometry.rate, out, &message);
  };
  const springnet_status status = call(group.spring, spring);
  return status != SPRINGNET_OK ? status : call(group.viscosity, viscosity);
}

}  // namespace

springnet_status evaluate_springs(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                  std::size_t group, const std::uint32_t* springs, std::size_t count,
                                  SegmentGeometry& geometry, const LawOutputs& spring, const LawOutputs& viscosity,
                                  springnet_message& message) {
  return evaluate_group(layout, set, time, nodes, layout.laws().groups[group], springs, count, geometry, spring,
                        viscosity, message);
}

double spring_tension(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                      std::uint32_t spring) {
  const auto geometry = std::make_unique<SegmentGeometry>();
  const std::size_t group_index = layout.laws().group[spring];
  const Group& group = layout.laws().groups[group_index];
  double values[2] = {0.0, 0.0};
  LawOutputs out[2];
  out[0].force = &values[0];
  out[1].force = &values[1];
  springnet_message message{};
  static_cast<void>(
      evaluate_springs(layout, set, time, nodes, group_index, &spring, 1, *geometry, out[0], out[1], message));
  return (group.spring.relative ? 0.0 : values[0]) + (group.viscosity.relative ? 0.0 : values[1]);
}

namespace {

// Live springs a batch of one group at a time: what(springs, count, group, outputs of the two laws).
template <class What>
void for_each_batch(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, bool energy,
                    const What& what) {
  const auto geometry = std::make_unique<SegmentGeometry>();
  double force[2][max_segment], stored[max_segment];
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    const Group& group = layout.laws().groups[g];
    const std::vector<std::uint32_t>& springs = layout.springs_of(g);
    for (std::size_t begin = 0; begin < springs.size(); begin += max_segment) {
      const std::size_t count = std::min(max_segment, springs.size() - begin);
      LawOutputs out[2];
      out[0].force = force[0];
      out[1].force = force[1];
      const bool has_energy = group.spring.can(SPRINGNET_HAS_ENERGY);
      if (energy && has_energy) out[0].energy = stored;
      springnet_message message{};
      if (evaluate_springs(layout, set, time, nodes, g, springs.data() + begin, count, *geometry, out[0], out[1],
                           message) != SPRINGNET_OK) {
        for (auto* values : {force[0], force[1], stored}) std::fill_n(values, count, std::nan(""));
      } else if (energy && !has_energy) {
        std::fill_n(stored, count, group.spring ? std::nan("") : 0.0);
      }
      for (std::size_t i = 0; i < count; ++i) what(springs[begin + i], group, force[0][i], force[1][i], stored[i]);
    }
  }
}

}  // namespace

void spring_tensions(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, double* out) {
  std::fill_n(out, layout.spring_count(), 0.0);
  for_each_batch(layout, set, time, nodes, false,
                 [&](std::uint32_t s, const Group& group, double spring, double viscous, double) {
                   if (group.spring && !group.spring.relative) out[s] += spring;
                   if (group.viscosity && !group.viscosity.relative) out[s] += viscous;
                 });
}

void spring_energies(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, double* out) {
  std::fill_n(out, layout.spring_count(), 0.0);
  for_each_batch(layout, set, time, nodes, true,
                 [&](std::uint32_t s, const Group&, double, double, double stored) { out[s] = stored; });
}

double spring_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes) {
  const auto geometry = std::make_unique<SegmentGeometry>();
  double sum = 0.0;
  double energy[max_segment], force[max_segment];
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    const Group& group = layout.laws().groups[g];
    if (!group.spring.can(SPRINGNET_HAS_ENERGY)) continue;
    const std::vector<std::uint32_t>& springs = layout.springs_of(g);
    for (std::size_t begin = 0; begin < springs.size(); begin += max_segment) {
      const std::size_t count = std::min(max_segment, springs.size() - begin);
      LawOutputs out;
      out.force = force;
      out.energy = energy;
      springnet_message message{};
      LawOutputs unused;
      double viscous[max_segment];
      unused.force = viscous;
      if (evaluate_springs(layout, set, time, nodes, g, springs.data() + begin, count, *geometry, out, unused,
                           message) != SPRINGNET_OK)
        return std::nan("");
      for (std::size_t i = 0; i < count; ++i) sum += energy[i];
    }
  }
  return sum;
}

std::vector<std::uint32_t> rupturing_springs(const Layout& layout) {
  std::vector<std::uint32_t> springs;
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    const Group& group = layout.laws().groups[g];
    if (group.spring.can(SPRINGNET_HAS_RUPTURE) || group.viscosity.can(SPRINGNET_HAS_RUPTURE))
      springs.insert(springs.end(), layout.springs_of(g).begin(), layout.springs_of(g).end());
  }
  return springs;
}

springnet_status spring_margins(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                const std::vector<std::uint32_t>& springs, double* margins,
                                springnet_message& message) {
  const auto geometry = std::make_unique<SegmentGeometry>();
  double force[2][max_segment], other[max_segment];
  for (std::size_t begin = 0; begin < springs.size();) {
    const std::uint32_t group_index = layout.laws().group[springs[begin]];
    std::size_t end = begin;
    while (end < springs.size() && end - begin < max_segment && layout.laws().group[springs[end]] == group_index) ++end;
    const std::size_t count = end - begin;
    const Group& group = layout.laws().groups[group_index];
    const bool first = group.spring.can(SPRINGNET_HAS_RUPTURE), second = group.viscosity.can(SPRINGNET_HAS_RUPTURE);
    LawOutputs out[2];
    out[0].force = force[0];
    out[1].force = force[1];
    if (first) out[0].margin = margins + begin;
    if (second) out[1].margin = first ? other : margins + begin;
    const springnet_status status = evaluate_springs(layout, set, time, nodes, group_index, springs.data() + begin,
                                                     count, *geometry, out[0], out[1], message);
    if (status != SPRINGNET_OK) return status;
    if (first && second)
      for (std::size_t i = 0; i < count; ++i) margins[begin + i] = lesser(margins[begin + i], other[i]);
    begin = end;
  }
  return SPRINGNET_OK;
}

std::string explain_spring_failure(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                   Asked asked) {
  // Spring by spring: only the first that answers nonsense is of interest, and this is not the hot path.
  const auto geometry = std::make_unique<SegmentGeometry>();
  for (std::uint32_t s = 0; s < layout.spring_count(); ++s) {
    if (!layout.alive(s)) continue;
    const Group& group = layout.group_of(s);
    for (const Law* law : {&group.spring, &group.viscosity}) {
      if (!*law) continue;
      LawAnswer answer;
      const LawOutputs out = answer.outputs(*law, asked);
      springnet_message message{};
      Group alone = group;  // only this law
      (law == &group.spring ? alone.viscosity : alone.spring) = {};
      const springnet_status status =
          evaluate_group(layout, set, time, nodes, alone, &s, 1, *geometry, out, out, message);
      const std::string what = wrong_answer(*law->component, status, answer, message);
      if (what.empty()) continue;
      return fmt::format("{} for spring {} (nodes {} and {}, length {:.10g} m, rate {:.10g} m/s)", what, s,
                         layout.ordering().user[layout.first(s)], layout.ordering().user[layout.second(s)],
                         geometry->length[0], geometry->rate[0]);
    }
  }
  return {};
}

}  // namespace springnet::layers
