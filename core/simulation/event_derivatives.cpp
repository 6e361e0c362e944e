#include "simulation/event_derivatives.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"
#include "plugin_host/call.hpp"
#include "simulation/parameter_model.hpp"

namespace springnet {
namespace {

using layers::Law;
using layers::LawOutputs;
using layers::PairOutputs;

// The margin of one law of a spring or element and its derivatives; a law that cannot rupture has an infinite one.
class Margin {
 public:
  Margin(const Law& law, const layers::SetsOfGroup::OfLaw& sets, const layers::InternalView& internal)
      : law_(law), sets_(sets), by_slots_(sets.slots.size(), 0.0) {
    if (!law.can(SPRINGNET_HAS_RUPTURE)) return;
    if (!law.can(SPRINGNET_HAS_ALL_DERIVATIVES))
      throw Error(ErrorKind::plugin,
                  fmt::format("{} does not give the derivatives of its rupture margin; build it with an SDK of ABI 2.1 "
                              "or newer",
                              full_name(*law.component)));
    const sdk::JacobianLayout jacobian = layers::jacobian_of(law);
    const std::size_t columns = jacobian.columns(layers::steps_states(law, &internal));
    pointers_.assign(jacobian.rows() * columns, nullptr);
    double** const row = pointers_.data() + jacobian.margin() * columns;
    for (std::size_t i = 0; i < jacobian.invariants; ++i) {
      if (law.scalar_count > 0 && !law.reads[i]) continue;
      const std::size_t s = law.scalar_count > 0 ? law.scalar[i] : 0;
      row[jacobian.value(i)] = &by_value[s];
      if (law.reads_rate) row[jacobian.rate(i)] = &by_rates[s];
    }
    if (law.can(SPRINGNET_READS_TIME)) row[jacobian.time()] = &by_time;
    states_ = law.state_count;
    for (std::size_t i = 0; i < states_; ++i) row[jacobian.state(i)] = &by_states_[i];
    for (std::size_t i = 0; i < by_slots_.size(); ++i) {
      double*& place = row[sets.slots[i].column];
      if (place == nullptr) place = &by_slots_[i];
    }
  }
  [[nodiscard]] LawOutputs outputs() {
    LawOutputs out{};
    if (pointers_.empty()) return out;
    out.margin = &value;
    out.derivatives = pointers_.data();
    return out;
  }
  [[nodiscard]] bool is_relative() const noexcept { return law_.relative; }
  // Adds its derivatives by sets, of a member of the group in this row.
  // growth: of the references of laws over several scalars, [scalar of the group], then of the direction's components.
  void add_to(const layers::ResolvedSets& all, const layers::Group& group, std::uint32_t row, std::uint32_t member,
              const double* growth = nullptr) const {
    for (const layers::SetsOfGroup::Entry& entry : sets_.entries) {
      const layers::ParameterSet& set = all.sets()[entry.set];
      if (set.kind == layers::ParameterSet::Kind::input &&
          static_cast<std::uint32_t>(group.columns[entry.signal_column][row]) != set.input)
        continue;
      const bool is_time = set.kind == layers::ParameterSet::Kind::time;  // asked for in any case
      const bool grows = law_.scalar_count > 0 && set.kind == layers::ParameterSet::Kind::reference;
      const std::uint32_t n = law_.scalar_count;
      const double factor = !grows             ? 1.0
                            : entry.scalar < n ? growth[law_.scalar[entry.scalar]]
                                               : growth[layers::max_scalars + entry.scalar - n];
      set.values[set.is_one() ? 0 : member] += is_time ? by_time : factor * by_slots_[entry.slot];
    }
  }

  // Adds those by the internal states of a member of this group, in its place.
  void add_states_to(double* by_internal, const layers::InternalLayout& layout, std::size_t group,
                     std::uint32_t place) const {
    if (by_internal == nullptr || states_ == 0) return;
    const layers::InternalLayout::OfGroup& own = layout.group(group);
    for (std::size_t i = 0; i < states_; ++i)
      by_internal[own.first + (law_.first_state + i) * own.count + place] += by_states_[i];
  }

  double value = std::numeric_limits<double>::infinity();
  // By the scalars of the group's list; of laws with one invariant the first ones.
  double by_value[layers::max_scalars] = {}, by_rates[layers::max_scalars] = {};
  double &by_q = by_value[0], &by_rate = by_rates[0];
  double by_time = 0.0;

 private:
  const Law& law_;
  const layers::SetsOfGroup::OfLaw& sets_;
  std::vector<double> by_slots_;
  std::size_t states_ = 0;
  double by_states_[layers::max_states] = {};
  std::vector<double*> pointers_;
};

// Writes the answer, node by node.
class EventAnswer {
 public:
  EventAnswer(springnet_event_derivative& request, std::size_t n, double* by_internal)
      : request_(request), by_internal_(by_internal), n_(n) {
    request.by_time = 0.0;
    for (double* const array : {request.by_position, request.by_velocity})
      if (array != nullptr) std::fill_n(array, 3 * n, 0.0);
  }
  void add(std::uint32_t node, const Vector3& by_position, const Vector3& by_velocity) {
    add(request_.by_position, node, by_position);
    add(request_.by_velocity, node, by_velocity);
  }
  void set_time(double by_time) { request_.by_time = by_time; }
  [[nodiscard]] double* by_internal() const noexcept { return by_internal_; }

 private:
  void add(double* values, std::uint32_t node, const Vector3& change) const {
    for (std::size_t c = 0; values != nullptr && c < 3; ++c)
      values[c * n_ + node] += change[static_cast<Eigen::Index>(c)];
  }
  springnet_event_derivative& request_;
  double* by_internal_;
  std::size_t n_;
};

springnet_status of_spring(Model& model, std::uint32_t spring, double time, const layers::NodeArrays& nodes,
                           const layers::ResolvedSets& sets, EventAnswer& answer) {
  const layers::Group& group = model.layout.group_of(spring);
  const layers::SetsOfGroup& wanted = sets.of(model.layout.laws().group[spring], false);
  Margin margins[2] = {{group.spring, wanted.laws[0], *nodes.internal},
                       {group.viscosity, wanted.laws[1], *nodes.internal}};
  const auto geometry = std::make_unique<layers::SegmentGeometry>();
  const springnet_status status = layers::evaluate_springs(
      model.layout, model.evaluator.instruction_set(), time, nodes, model.layout.laws().group[spring], &spring, 1,
      *geometry, {margins[0].outputs(), margins[1].outputs()}, model.journal.message);
  if (status != SPRINGNET_OK) return status;
  const Margin& least = margins[margins[1].value < margins[0].value ? 1 : 0];
  const Vector3 n(geometry->nx[0], geometry->ny[0], geometry->nz[0]);
  const Vector3 s(geometry->sx[0], geometry->sy[0], geometry->sz[0]);
  Vector3 by_position = Vector3::Zero(), by_velocity = Vector3::Zero();
  if (least.is_relative()) {
    by_velocity = least.by_q * s;
  } else {
    by_position = least.by_q * n;
    if (geometry->length[0] > 0.0)
      by_position += least.by_rate * (geometry->speed[0] * s - geometry->rate[0] * n) / geometry->length[0];
    by_velocity = least.by_rate * n;
  }
  answer.add(model.layout.first(spring), by_position, by_velocity);
  answer.add(model.layout.second(spring), -by_position, -by_velocity);
  answer.set_time(least.by_time);
  least.add_to(sets, group, model.layout.laws().row[spring], spring);
  const layers::InternalLayout& internal = model.layout.internal();
  const std::size_t number = model.layout.laws().group[spring];
  if (internal.has(number)) least.add_states_to(answer.by_internal(), internal, number, internal.of_spring(spring));
  return status;
}

// Whose laws read several scalars.
springnet_status of_several(Model& model, std::uint32_t element, double time, const layers::NodeArrays& nodes,
                            const layers::ResolvedSets& sets, EventAnswer& answer) {
  const layers::ElementLayout& elements = model.layout.elements();
  const layers::Group& group = model.layout.laws().groups[elements.group(element)];
  const layers::SetsOfGroup& wanted = sets.of(elements.group(element), true);
  const InstructionSet set = model.evaluator.instruction_set();
  Margin margins[2] = {{group.spring, wanted.laws[0], *nodes.internal},
                       {group.viscosity, wanted.laws[1], *nodes.internal}};
  const auto geometry = std::make_unique<layers::SeveralGeometry>();
  layers::GatheredMembers gathered;
  const layers::SeveralMembers& members = gathered.gather(elements, 1, [element](std::size_t) { return element; });
  layers::kernels_for(set).several.geometry(group.scalars, members.corners, members.reference, nodes, true, *geometry);
  const layers::SeveralInputs inputs = layers::inputs_of(members, *geometry);
  layers::LawBatch batch{group, 1, members.rows, nullptr, nullptr};
  batch.several = &inputs;
  const springnet_status status =
      layers::evaluate_laws(batch, set, time, {margins[0].outputs(), margins[1].outputs()}, model.journal.message);
  if (status != SPRINGNET_OK) return status;
  const Margin& least = margins[margins[1].value < margins[0].value ? 1 : 0];
  const std::span<const std::uint32_t> own = elements.nodes(element);
  double growth[layers::max_scalars + 3] = {};
  for (std::size_t c = 0; c < 3; ++c) growth[layers::max_scalars + c] = -members.direction[c][0];
  for (std::size_t s = 0; s < group.scalars.count; ++s) {
    const layers::ElementScalar& scalar = group.scalars.scalar[s];
    growth[s] = scalar.dimension() * members.reference[s][0];
    if (scalar.reference_only) continue;
    for (std::size_t c = 0; c < scalar.corner_count(); ++c) {
      const Vector3 gradient = layers::gradient_of(scalar, geometry->gradient[s], c, 0);
      Vector3 by_position = least.by_value[s] * gradient;
      if (least.by_rates[s] != 0.0)
        by_position += least.by_rates[s] * layers::rate_gradient_of(scalar, *geometry, s, c, 0);
      answer.add(own[scalar.corner[c]], by_position, least.by_rates[s] * gradient);
    }
  }
  answer.set_time(least.by_time);
  least.add_to(sets, group, elements.row(element), element, growth);
  return status;
}

springnet_status of_element(Model& model, std::uint32_t element, double time, const layers::NodeArrays& nodes,
                            const layers::ResolvedSets& sets, EventAnswer& answer) {
  const layers::ElementLayout& elements = model.layout.elements();
  const layers::Group& group = model.layout.laws().groups[elements.group(element)];
  const layers::SetsOfGroup& wanted = sets.of(elements.group(element), true);
  if (reads_several(elements.invariant(element))) return of_several(model, element, time, nodes, sets, answer);
  Margin margins[2] = {{group.spring, wanted.laws[0], *nodes.internal},
                       {group.viscosity, wanted.laws[1], *nodes.internal}};
  const springnet_status status =
      layers::evaluate_element(model.layout, model.evaluator.instruction_set(), time, nodes, element,
                               layers::element_state(model.layout, nodes, element),
                               {margins[0].outputs(), margins[1].outputs()}, model.journal.message);
  if (status != SPRINGNET_OK) return status;
  const Margin& least = margins[margins[1].value < margins[0].value ? 1 : 0];
  const auto add = [&](std::uint32_t node, const Vector3& gradient, const Vector3& rate_gradient) {
    answer.add(node, least.by_q * gradient + least.by_rate * rate_gradient, least.by_rate * gradient);
  };
  answer.set_time(least.by_time);
  least.add_to(sets, group, elements.row(element), element);
  const layers::InternalLayout& internal = model.layout.internal();
  const std::size_t number = elements.group(element);
  if (internal.has(number)) least.add_states_to(answer.by_internal(), internal, number, internal.of_element(element));
  if (elements.invariant(element) == Invariant::enclosed_volume) {
    for (const layers::ElementLayout::EnclosureElement& enclosure : elements.enclosures()) {
      if (enclosure.element != element) continue;
      for (std::size_t place = 0; place < enclosure.shape.size(); ++place)
        add(enclosure.shape.nodes()[place], enclosure.shape.gradient(place, nodes),
            enclosure.shape.rate_gradient(place, nodes));
    }
    return status;
  }
  const std::span<const std::uint32_t> own = elements.nodes(element);
  layers::Corners corners;
  layers::FirstOrder first;
  layers::SecondOrder second;
  layers::gather(own.data(), own.size(), nodes, corners);
  layers::first_order(elements.invariant(element), corners, first);
  layers::second_order(elements.invariant(element), corners, second);
  for (std::size_t i = 0; i < own.size(); ++i) add(own[i], first.gradient[i], second.rate_gradient[i]);
  return status;
}

}  // namespace

springnet_status find_event_derivative(Model& model, ContactEvents& events, Topology& topology,
                                       springnet_event_derivative& request, double* by_internal) {
  using Kind = ContactEvents::Source::Kind;
  const springnet_evaluation& at = *request.at;
  const std::vector<ContactEvents::Source>& sources = events.sources();
  const Topology::Rupturing& breaking = topology.rupturing();
  if (request.event >= sources.size() + breaking.count())
    throw Error(ErrorKind::plugin, fmt::format("event {} does not exist: the network has {}", request.event,
                                               sources.size() + breaking.count()));
  EventAnswer answer(request, model.node_count(), by_internal);
  if (request.event < sources.size()) {
    const ContactEvents::Source& source = sources[request.event];
    if (source.kind != Kind::touch)
      throw Error(ErrorKind::plugin,
                  fmt::format("event {} of node {} follows from forces or from the slip; derivatives are given of gaps "
                              "and margins of rupture alone",
                              request.event, model.user_number(source.index)));
    const std::shared_ptr<const Placement> placement = model.placement(at.time);
    const Vector3 p = vector_at(at.position, source.index);
    const Vector3 n = model.contact.normal(*placement, source.surface, p);
    answer.add(source.index, n, Vector3::Zero());
    answer.set_time(-n.dot(Contact::velocity(*placement, source.surface, p)));
    return SPRINGNET_OK;
  }
  layers::InternalView internal = model.internal_for(at.internal);
  internal.next = internal.rates = nullptr;
  const layers::NodeArrays nodes = node_arrays(at.position, at.velocity, internal);
  const std::size_t i = request.event - sources.size();
  const layers::ResolvedSets sets = resolve_sets(model.layout, request.sets, request.set_count, false);
  return i < breaking.springs.size()
             ? of_spring(model, breaking.springs[i], at.time, nodes, sets, answer)
             : of_element(model, breaking.elements[i - breaking.springs.size()], at.time, nodes, sets, answer);
}

}  // namespace springnet
