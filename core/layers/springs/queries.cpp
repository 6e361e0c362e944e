#include "layers/springs/queries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "profile/stage.hpp"

namespace springnet::layers {

springnet_status evaluate_springs(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                  std::size_t group, const std::uint32_t* springs, std::size_t count,
                                  SegmentGeometry& geometry, const PairOutputs& out, springnet_message& message,
                                  bool directions) {
  const profile::Tile measured;
  const profile::Part part("springs");
  std::uint32_t first[max_segment], second[max_segment], rows[max_segment], places[max_segment];
  for (std::size_t i = 0; i < count; ++i) {
    first[i] = layout.first(springs[i]);
    second[i] = layout.second(springs[i]);
    rows[i] = layout.laws().row[springs[i]];
    if (layout.internal().has(group)) places[i] = layout.internal().of_spring(springs[i]);
  }
  const SegmentSprings segment{nullptr, nullptr, static_cast<std::uint32_t>(count), first, second};
  const Kernels& kernels = kernels_for(set);
  kernels.lengths_and_rates(segment, nodes, geometry);
  const Group& laws = layout.laws().groups[group];
  if (directions || laws.spring.relative || laws.viscosity.relative) kernels.relative_speeds(segment, nodes, geometry);
  const LawBatch batch{laws,
                       count,
                       {rows, 0},
                       geometry.length,
                       geometry.rate,
                       geometry.speed,
                       {layout.internal(), group, nodes, places},
                       nullptr,
                       {CalledMembers::Are::springs, static_cast<std::uint32_t>(count), 1, springs}};
  return evaluate_laws(batch, set, time, out, message);
}

namespace {

// Evaluates the live springs of a group, calling what(springs, count, status of evaluate_springs) after each batch.
template <class What>
void for_each_batch(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, std::size_t group,
                    const PairOutputs& out, const What& what) {
  const auto geometry = std::make_unique<SegmentGeometry>();
  const std::vector<std::uint32_t>& springs = layout.springs_of(group);
  for (std::size_t begin = 0; begin < springs.size(); begin += max_segment) {
    const std::size_t count = std::min(max_segment, springs.size() - begin);
    springnet_message message{};
    const springnet_status status =
        evaluate_springs(layout, set, time, nodes, group, springs.data() + begin, count, *geometry, out, message);
    what(springs.data() + begin, count, status);
  }
}

// Energies of the laws that have one: what(spring, J), nan where a law fails.
template <class What>
void for_each_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, const What& what) {
  double force[max_segment], energy[2][max_segment];
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    const Group& group = layout.laws().groups[g];
    if (!group.can(SPRINGNET_HAS_ENERGY)) continue;
    PairOutputs out{};  // of these laws alone
    for (std::size_t k = 0; k < out.size(); ++k) {
      std::fill_n(energy[k], max_segment, 0.0);
      if (!group.laws()[k]->can(SPRINGNET_HAS_ENERGY)) continue;
      out[k].force = force;
      out[k].energy = energy[k];
    }
    for_each_batch(layout, set, time, nodes, g, out,
                   [&](const std::uint32_t* springs, std::size_t count, springnet_status status) {
                     for (std::size_t i = 0; i < count; ++i)
                       what(springs[i], status == SPRINGNET_OK ? energy[0][i] + energy[1][i] : std::nan(""));
                   });
  }
}

}  // namespace

double spring_tension(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                      std::uint32_t spring) {
  const auto geometry = std::make_unique<SegmentGeometry>();
  const std::size_t group = layout.laws().group[spring];
  double force[2] = {0.0, 0.0};
  springnet_message message{};
  static_cast<void>(evaluate_springs(layout, set, time, nodes, group, &spring, 1, *geometry,
                                     {LawOutputs{&force[0]}, LawOutputs{&force[1]}}, message));
  const Group& laws = layout.laws().groups[group];
  return (laws.spring.relative ? 0.0 : force[0]) + (laws.viscosity.relative ? 0.0 : force[1]);
}

void spring_tensions(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, double* out) {
  std::fill_n(out, layout.spring_count(), 0.0);
  double force[2][max_segment];
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    const std::array<const Law*, 2> laws = layout.laws().groups[g].laws();
    for_each_batch(layout, set, time, nodes, g, {LawOutputs{force[0]}, LawOutputs{force[1]}},
                   [&](const std::uint32_t* springs, std::size_t count, springnet_status status) {
                     for (std::size_t k = 0; k < laws.size(); ++k) {
                       if (!*laws[k] || laws[k]->relative) continue;
                       for (std::size_t i = 0; i < count; ++i)
                         out[springs[i]] += status == SPRINGNET_OK ? force[k][i] : std::nan("");
                     }
                   });
  }
}

void spring_energies(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, double* out) {
  std::fill_n(out, layout.spring_count(), 0.0);
  for_each_energy(layout, set, time, nodes, [out](std::uint32_t s, double energy) { out[s] = energy; });
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g)
    if (const Law& law = layout.laws().groups[g].spring; law && !law.can(SPRINGNET_HAS_ENERGY))
      for (const std::uint32_t s : layout.springs_of(g)) out[s] = std::nan("");
}

double spring_energy(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes) {
  double sum = 0.0;
  for_each_energy(layout, set, time, nodes, [&sum](std::uint32_t, double energy) { sum += energy; });
  return sum;
}

std::vector<std::uint32_t> rupturing_springs(const Layout& layout) {
  std::vector<std::uint32_t> springs;
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    if (layout.laws().groups[g].can(SPRINGNET_HAS_RUPTURE))
      springs.insert(springs.end(), layout.springs_of(g).begin(), layout.springs_of(g).end());
  }
  return springs;
}

springnet_status spring_margins(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                const std::vector<std::uint32_t>& springs, double* margins,
                                springnet_message& message) {
  const auto geometry = std::make_unique<SegmentGeometry>();
  double force[2][max_segment], viscous[max_segment];
  for (std::size_t begin = 0; begin < springs.size();) {
    const std::uint32_t group = layout.laws().group[springs[begin]];
    std::size_t end = begin;
    while (end < springs.size() && end - begin < max_segment && layout.laws().group[springs[end]] == group) ++end;
    const std::size_t count = end - begin;
    // Absent laws never rupture.
    std::fill_n(margins + begin, count, std::numeric_limits<double>::infinity());
    std::fill_n(viscous, count, std::numeric_limits<double>::infinity());
    PairOutputs out{};
    for (std::size_t k = 0; k < out.size(); ++k) out[k].force = force[k];
    out[0].margin = margins + begin;
    out[1].margin = viscous;
    const springnet_status status =
        evaluate_springs(layout, set, time, nodes, group, springs.data() + begin, count, *geometry, out, message);
    if (status != SPRINGNET_OK) return status;
    for (std::size_t i = 0; i < count; ++i) margins[begin + i] = lesser(margins[begin + i], viscous[i]);
    begin = end;
  }
  return SPRINGNET_OK;
}

std::string explain_spring_failure(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                                   Requested requested) {
  const auto geometry = std::make_unique<SegmentGeometry>();
  for (std::uint32_t s = 0; s < layout.spring_count(); ++s) {
    if (!layout.alive(s)) continue;
    const std::array<const Law*, 2> laws = layout.group_of(s).laws();
    for (std::size_t k = 0; k < laws.size(); ++k) {
      if (!*laws[k]) continue;
      LawAnswer answer;
      PairOutputs out{};  // of this law alone
      out[k] = answer.outputs(*laws[k], requested);
      springnet_message message{};
      const springnet_status status =
          evaluate_springs(layout, set, time, nodes, layout.laws().group[s], &s, 1, *geometry, out, message);
      const std::string what = wrong_answer(*laws[k]->component, status, answer, message);
      if (what.empty()) continue;
      return fmt::format("{} for spring {} (nodes {} and {}, length {:.10g} m, rate {:.10g} m/s)", what, s,
                         layout.ordering().user[layout.first(s)], layout.ordering().user[layout.second(s)],
                         geometry->length[0], geometry->rate[0]);
    }
  }
  return {};
}

}  // namespace springnet::layers
