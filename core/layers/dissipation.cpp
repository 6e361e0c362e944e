#include "layers/dissipation.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"

namespace springnet::layers {
namespace {

// An energy that is a function of what the law's force acts along, with its derivatives.
bool has_energy(const Law& law) {
  const std::uint64_t derivatives = law.scalar_count > 0 ? SPRINGNET_HAS_ALL_DERIVATIVES : SPRINGNET_HAS_DERIVATIVES;
  return law.can(SPRINGNET_HAS_ENERGY) && law.can(derivatives) && !law.relative;
}

// Of a spring function without an energy, and of a law that has one without derivatives, nobody knows what of its power
// is stored.
bool is_known(const Law& law, std::size_t k) {
  return has_energy(law) || (k == 1 && (law.relative || !law.can(SPRINGNET_HAS_ENERGY)));
}

// Where a law answers for some members, [law][member].
struct Answers {
  double force[2][max_segment];
  double energy_by_q[2][max_segment];

  PairOutputs outputs(const Group& group) {
    PairOutputs out{};
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k].force = force[k];
      if (has_energy(*group.laws()[k])) out[k].energy_by_q = energy_by_q[k];
    }
    return out;
  }
  [[nodiscard]] double without_energy(const Law& law, std::size_t k, std::size_t i) const {
    return has_energy(law) ? force[k][i] - energy_by_q[k][i] : force[k][i];
  }
};

// Calls visit(law, 0 or 1, member, group, place of its internal states) for the laws of live members.
template <class Visit>
void for_each_law(const Layout& layout, bool elements, const Visit& visit) {
  const InternalLayout& internal = layout.internal();
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    const std::array<const Law*, 2> laws = layout.laws().groups[g].laws();
    for (std::size_t k = 0; k < laws.size(); ++k) {
      if (!*laws[k]) continue;
      for (const std::uint32_t s : layout.springs_of(g))
        visit(*laws[k], k, s, g, internal.has(g) ? internal.of_spring(s) : 0);
    }
  }
  for (std::uint32_t e = 0; elements && e < layout.elements().count(); ++e) {
    if (!layout.elements().alive(e)) continue;
    const std::size_t g = layout.elements().group(e);
    const std::array<const Law*, 2> laws = layout.laws().groups[g].laws();
    for (std::size_t k = 0; k < laws.size(); ++k)
      if (*laws[k]) visit(*laws[k], k, layout.spring_count() + e, g, internal.has(g) ? internal.of_element(e) : 0);
  }
}

// Sum of what(place) over the internal states that the law's energy depends on.
template <class What>
double over_states(const Layout& layout, const Law& law, std::size_t group, std::uint32_t place, const What& what) {
  if (!has_energy(law)) return 0.0;
  double sum = 0.0;
  for (std::size_t j = 0; j < law.state_count; ++j) {
    const InternalLayout::OfGroup& own = layout.internal().group(group);
    sum += what(own.first + (law.first_state + j) * own.count + place);
  }
  return sum;
}

// Sum over the scalars of an element on which a law exerts forces.
template <class What>
double over_scalars(const Law& law, const What& what) {
  double sum = 0.0;
  for (std::size_t i = 0; i < law.scalar_count; ++i)
    if (law.reads[i]) sum += what(law.scalar[i]);
  return sum;
}

// At the element's state, which `nodes` has.
Losses::Several several_losses(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                               std::uint32_t element) {
  const Group& group = layout.laws().groups[layout.elements().group(element)];
  const auto query = std::make_unique_for_overwrite<SeveralQuery>();
  const auto gradients = std::make_unique_for_overwrite<SeveralEnergyGradients>();
  springnet_message message{};
  springnet_status status =
      evaluate_several_element(layout, set, time, nodes, element, SeveralWanted::forces, *query, message);
  if (status == SPRINGNET_OK) {
    GatheredMembers gathered;
    status = several_energy_gradients(group,
                                      gathered.gather(layout.elements(), 1, [element](std::size_t) { return element; }),
                                      query->geometry, set, time, *gradients, message);
  }
  Losses::Several out{};
  for (std::size_t s = 0; s < group.scalars.count; ++s) {
    if (group.scalars.scalar[s].reference_only) continue;
    out.q[s] = query->geometry.value[s][0];
    out.rate[s] = query->geometry.rate[s][0];
  }
  for (std::size_t k = 0; k < 2; ++k) {
    const Law& law = *group.laws()[k];
    if (!law) continue;
    for (std::size_t i = 0; i < law.scalar_count; ++i) {
      const std::size_t s = law.scalar[i];
      if (!law.reads[i]) continue;
      out.force[k][s] = status != SPRINGNET_OK ? std::nan("")
                        : has_energy(law)      ? query->answers.force[k][s][0] - gradients->value[k][s][0]
                                               : query->answers.force[k][s][0];
    }
  }
  return out;
}

double power(const Layout& layout, const Losses& at, const Law& law, std::size_t k, std::size_t member,
             std::size_t group, std::uint32_t place) {
  if (law.scalar_count > 0) {
    const Losses::Several& own = at.several[member - layout.spring_count()];
    return over_scalars(law, [&](std::size_t s) { return own.force[k][s] * own.rate[s]; });
  }
  return at.force[k][member] * at.rate[k][member] -
         over_states(layout, law, group, place, [&](std::uint64_t z) { return at.energy_by_states[z] * at.rates[z]; });
}

}  // namespace

void evaluate_losses(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes, Losses& out) {
  const std::size_t springs = layout.spring_count(), members = springs + layout.elements().count();
  const std::uint64_t internal = layout.internal().count();
  out.time = time;
  for (std::size_t k = 0; k < 2; ++k) {
    out.force[k].resize(members);
    out.rate[k].resize(members);
  }
  out.q.resize(members);
  out.rates.resize(internal);
  out.energy_by_states.resize(internal);
  InternalView view;
  if (internal > 0) {
    out.states.assign(nodes.internal->values, nodes.internal->values + internal);
    view.values = nodes.internal->values;
    view.rates = out.rates.data();
    view.energy_by_states = out.energy_by_states.data();
  }
  NodeArrays own = nodes;
  own.internal = &view;
  const auto answers = std::make_unique<Answers>();
  const auto geometry = std::make_unique<SegmentGeometry>();
  for (std::size_t g = 0; g < layout.laws().groups.size(); ++g) {
    const Group& group = layout.laws().groups[g];
    const std::vector<std::uint32_t>& numbers = layout.springs_of(g);
    for (std::size_t begin = 0; begin < numbers.size(); begin += max_segment) {
      const std::size_t count = std::min(max_segment, numbers.size() - begin);
      springnet_message message{};
      const springnet_status status = evaluate_springs(layout, set, time, own, g, numbers.data() + begin, count,
                                                       *geometry, answers->outputs(group), message);
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t s = numbers[begin + i];
        out.q[s] = geometry->length[i];
        for (std::size_t k = 0; k < 2; ++k) {
          const Law& law = *group.laws()[k];
          if (!law) continue;
          out.force[k][s] = status == SPRINGNET_OK ? answers->without_energy(law, k, i) : std::nan("");
          out.rate[k][s] = law.relative ? geometry->speed[i] : geometry->rate[i];
        }
      }
    }
  }
  for (std::uint32_t e = 0; e < layout.elements().count(); ++e) {
    if (!layout.elements().alive(e)) continue;
    const Group& group = layout.laws().groups[layout.elements().group(e)];
    if (reads_several(layout.elements().invariant(e))) {
      out.several.resize(layout.elements().count());
      out.several[e] = several_losses(layout, set, time, own, e);
      continue;
    }
    const ElementState state = element_state(layout, nodes, e);
    springnet_message message{};
    const springnet_status status =
        evaluate_element(layout, set, time, own, e, state, answers->outputs(group), message);
    out.q[springs + e] = state.value;
    for (std::size_t k = 0; k < 2; ++k) {
      const Law& law = *group.laws()[k];
      if (!law) continue;
      out.force[k][springs + e] = status == SPRINGNET_OK ? answers->without_energy(law, k, 0) : std::nan("");
      out.rate[k][springs + e] = state.rate;
    }
  }
}

void add_spring_dissipations(const Layout& layout, const Losses& losses, double* out) {
  for_each_law(layout, false,
               [&](const Law& law, std::size_t k, std::size_t s, std::size_t group, std::uint32_t place) {
                 out[s] += is_known(law, k) ? power(layout, losses, law, k, s, group, place) : std::nan("");
               });
}

double element_dissipation(const Layout& layout, InstructionSet set, double time, const NodeArrays& nodes,
                           std::uint32_t element) {
  const std::size_t g = layout.elements().group(element);
  const Group& group = layout.laws().groups[g];
  if (reads_several(layout.elements().invariant(element))) {
    const Losses::Several own = several_losses(layout, set, time, nodes, element);
    double power = 0.0;
    for (std::size_t k = 0; k < 2; ++k) {
      const Law& law = *group.laws()[k];
      if (!law) continue;
      if (!is_known(law, k)) return std::nan("");
      power += over_scalars(law, [&](std::size_t s) { return own.force[k][s] * own.rate[s]; });
    }
    return power;
  }
  const auto count = static_cast<std::size_t>(layout.internal().count());
  const auto rates = std::make_unique_for_overwrite<double[]>(count);
  const auto energy_by_states = std::make_unique_for_overwrite<double[]>(count);
  InternalView view;
  if (count > 0) view.values = nodes.internal->values;
  view.rates = rates.get();
  view.energy_by_states = energy_by_states.get();
  NodeArrays own = nodes;
  own.internal = &view;
  const auto answers = std::make_unique<Answers>();
  const ElementState state = element_state(layout, nodes, element);
  const std::uint32_t place = layout.internal().has(g) ? layout.internal().of_element(element) : 0;
  springnet_message message{};
  if (evaluate_element(layout, set, time, own, element, state, answers->outputs(group), message) != SPRINGNET_OK)
    return std::nan("");
  double sum = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    const Law& law = *group.laws()[k];
    if (!law) continue;
    if (!is_known(law, k)) return std::nan("");
    sum += answers->without_energy(law, k, 0) * state.rate -
           over_states(layout, law, g, place, [&](std::uint64_t z) { return energy_by_states[z] * rates[z]; });
  }
  return sum;
}

double known_dissipation(const Layout& layout, const Losses& losses) {
  double sum = 0.0;
  for_each_law(layout, true,
               [&](const Law& law, std::size_t k, std::size_t member, std::size_t group, std::uint32_t place) {
                 if (is_known(law, k)) sum += power(layout, losses, law, k, member, group, place);
               });
  return sum;
}

double known_dissipation(const Layout& layout, const Losses& start, const Losses& end) {
  double sum = 0.0;
  for_each_law(
      layout, true, [&](const Law& law, std::size_t k, std::size_t member, std::size_t group, std::uint32_t place) {
        if (!is_known(law, k)) return;
        if (law.scalar_count > 0) {
          const Losses::Several& from = start.several[member - layout.spring_count()];
          const Losses::Several& to = end.several[member - layout.spring_count()];
          sum += 0.5 * over_scalars(law, [&](std::size_t s) {
                   return (from.force[k][s] + to.force[k][s]) * (to.q[s] - from.q[s]);
                 });
          return;
        }
        const double force_0 = start.force[k][member], force_1 = end.force[k][member];
        const double work =
            law.relative ? (force_0 * start.rate[k][member] + force_1 * end.rate[k][member]) * (end.time - start.time)
                         : (force_0 + force_1) * (end.q[member] - start.q[member]);
        const double stored = over_states(layout, law, group, place, [&](std::uint64_t z) {
          return (start.energy_by_states[z] + end.energy_by_states[z]) * (end.states[z] - start.states[z]);
        });
        sum += 0.5 * (work - stored);
      });
  return sum;
}

}  // namespace springnet::layers
