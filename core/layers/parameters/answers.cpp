#include "layers/parameters/answers.hpp"

#include <algorithm>

#include "layers/elements/kernels.hpp"
#include "layers/springs/queries.hpp"

namespace springnet::layers {

LawAnswers::LawAnswers(const Layout& layout, const Evaluator& evaluator)
    : layout_(layout), evaluator_(evaluator), segment_(std::make_unique<SegmentGeometry>()) {}

PairOutputs LawAnswers::outputs(const InternalView* view) {
  const std::array<const Law*, 2> laws = group_->laws();
  derivatives_.resize((wanted_->laws[0].slots.size() + wanted_->laws[1].slots.size()) * max_segment);
  PairOutputs out{};
  double* next = derivatives_.data();
  for (std::size_t k = 0; k < 2; ++k) {
    const Law& law = *laws[k];
    std::fill_n(by_parameters_[k], max_parameters, nullptr);
    if (!law) continue;
    const sdk::JacobianLayout jacobian = jacobian_of(law);
    const std::size_t columns = jacobian.columns(steps_states(law, view));
    jacobian_[k].assign(jacobian.rows() * columns, nullptr);
    for (const SetsOfGroup::Slot& slot : wanted_->laws[k].slots) {
      (slot.is_parameter ? by_parameters_[k][slot.column] : jacobian_[k][slot.row * columns + slot.column]) = next;
      (slot.is_parameter ? out[k].by_parameters : out[k].derivatives) =
          slot.is_parameter ? by_parameters_[k] : jacobian_[k].data();
      next += max_segment;
    }
  }
  return out;
}

springnet_status LawAnswers::find(const ParameterPiece& piece, const ResolvedSets& sets, const HeldState& at,
                                  springnet_message& message) {
  piece_ = piece;
  sets_ = &sets;
  group_ = &layout_.laws().groups[piece.group];
  wanted_ = &sets.of(piece.group, piece.of != ParameterPiece::Of::springs);
  return piece.of == ParameterPiece::Of::springs ? find_springs(at, message) : find_elements(at, message);
}

springnet_status LawAnswers::find_springs(const HeldState& at, springnet_message& message) {
  const std::uint32_t* const springs = layout_.springs_of(piece_.group).data() + piece_.begin;
  for (std::size_t i = 0; i < piece_.count; ++i) {
    members_[i] = springs[i];
    rows_[i] = layout_.laws().row[springs[i]];
  }
  return evaluate_springs(layout_, evaluator_.instruction_set(), at.time, at.nodes, piece_.group, members_,
                          piece_.count, *segment_, outputs(at.nodes.internal), message, false);
}

springnet_status LawAnswers::find_elements(const HeldState& at, springnet_message& message) {
  const ElementLayout& elements = layout_.elements();
  const InternalLayout& internal = layout_.internal();
  double q[element_batch], rate[element_batch];
  std::uint32_t places[element_batch];
  if (piece_.of == ParameterPiece::Of::enclosure) {
    const ElementLayout::EnclosureElement& enclosure = elements.enclosures()[piece_.begin];
    members_[0] = enclosure.element;
    const Enclosure::Values values = enclosure.shape.values(at.nodes);
    q[0] = values.volume;
    rate[0] = values.rate;
  } else {
    const ElementBatch& batch = elements.batches()[piece_.begin];
    if (reads_several(batch.invariant)) return find_several(at, message);
    elements_.resize(element_batch);
    Corners corners;
    for (std::size_t i = 0; i < batch.count; ++i) {
      const std::uint32_t e = members_[i] = elements.batched()[batch.begin + i];
      const std::span<const std::uint32_t> own = elements.nodes(e);
      gather(own.data(), own.size(), at.nodes, corners);
      first_order(batch.invariant, corners, elements_[i]);
      q[i] = nearest_turn(batch.invariant, elements_[i].value, elements.reference(e));
      rate[i] = elements_[i].rate;
    }
  }
  for (std::size_t i = 0; i < piece_.count; ++i) {
    rows_[i] = elements.row(members_[i]);
    if (internal.has(piece_.group)) places[i] = internal.of_element(members_[i]);
  }
  const LawBatch laws{*group_,
                      piece_.count,
                      {rows_, 0},
                      q,
                      rate,
                      nullptr,
                      {internal, piece_.group, at.nodes, places},
                      nullptr,
                      {CalledMembers::Are::elements, static_cast<std::uint32_t>(piece_.count), 1, members_}};
  return evaluate_laws(laws, evaluator_.instruction_set(), at.time, outputs(at.nodes.internal), message);
}

springnet_status LawAnswers::find_several(const HeldState& at, springnet_message& message) {
  const ElementLayout& elements = layout_.elements();
  const ElementBatch& batch = elements.batches()[piece_.begin];
  const InstructionSet set = evaluator_.instruction_set();
  if (!several_) several_ = std::make_unique<SeveralGeometry>();
  several_members_ = members_of(elements, batch);
  several_weight_.resize(max_scalars);
  for (std::size_t i = 0; i < batch.count; ++i) {
    members_[i] = elements.batched()[batch.begin + i];
    rows_[i] = elements.row(members_[i]);
  }
  kernels_for(set).several.geometry(group_->scalars, several_members_.corners, several_members_.reference, at.nodes,
                                    group_->reads_rate(), *several_);
  const SeveralInputs inputs = inputs_of(several_members_, *several_);
  LawBatch laws{*group_, batch.count, several_members_.rows, nullptr, nullptr};
  laws.several = &inputs;
  laws.members = {CalledMembers::Are::elements, static_cast<std::uint32_t>(batch.count), 1, members_};
  return evaluate_laws(laws, set, at.time, outputs(nullptr), message);
}

void LawAnswers::forces_of_several(const double (*changes)[several_batch], const CornerForces& out) const {
  const double* q[2][max_scalars] = {};
  for (std::size_t s = 0; s < group_->scalars.count; ++s)
    if (!group_->scalars.scalar[s].reference_only) q[0][s] = changes[s];
  kernels_for(evaluator_.instruction_set()).several.forces(group_->scalars, *several_, piece_.count, q, out);
}

void LawAnswers::weigh(const double* weights, const NodeArrays& nodes) {
  const std::size_t n = layout_.node_count();
  const auto weight_at = [&](std::size_t k) { return Vector3(weights[k], weights[n + k], weights[2 * n + k]); };
  const bool several = piece_.of == ParameterPiece::Of::elements && group_->scalars.count > 0;
  for (std::size_t s = 0; several && s < group_->scalars.count; ++s) {
    const ElementScalar& scalar = group_->scalars.scalar[s];
    if (scalar.reference_only) continue;
    for (std::size_t i = 0; i < piece_.count; ++i) {
      const std::span<const std::uint32_t> own = layout_.elements().nodes(members_[i]);
      double& weight = several_weight_[s][i] = 0.0;
      for (std::size_t c = 0; c < scalar.corner_count(); ++c)
        weight -= weight_at(own[scalar.corner[c]]).dot(gradient_of(scalar, several_->gradient[s], c, i));
    }
  }
  if (several) return;
  if (piece_.of == ParameterPiece::Of::springs) {
    const SegmentGeometry& g = *segment_;
    const bool relative = group_->spring.relative || group_->viscosity.relative;
    for (std::size_t i = 0; i < piece_.count; ++i) {
      const Vector3 between = weight_at(layout_.first(members_[i])) - weight_at(layout_.second(members_[i]));
      weight_[0][i] = -between.dot(Vector3(g.nx[i], g.ny[i], g.nz[i]));
      if (relative) weight_[1][i] = -between.dot(Vector3(g.sx[i], g.sy[i], g.sz[i]));
    }
    return;
  }
  for (std::size_t i = 0; i < piece_.count; ++i) {
    const std::uint32_t member = members_[i];
    double& weight = weight_[0][i];
    switch (piece_.of) {
      case ParameterPiece::Of::enclosure: {
        const Enclosure& shape = layout_.elements().enclosures()[piece_.begin].shape;
        weight = 0.0;
        for (std::size_t place = 0; place < shape.size(); ++place)
          weight -= weight_at(shape.nodes()[place]).dot(shape.gradient(place, nodes));
        break;
      }
      default: {
        const std::span<const std::uint32_t> own = layout_.elements().nodes(member);
        weight = 0.0;
        for (std::size_t c = 0; c < own.size(); ++c) weight -= weight_at(own[c]).dot(elements_[i].gradient[c]);
      }
    }
  }
}

springnet_status NeuronAnswers::find(const ParameterPiece& piece, const ResolvedSets& sets, const HeldState& at,
                                     const double* force, springnet_message& message) {
  using By = ResolvedSets::NeuronEntry::By;
  wanted_ = &sets.of_neuron(piece.group);
  const std::size_t n = layout_.node_count(), count = piece.count;
  by_force_.resize(9 * count);
  acceleration_.resize(3 * count);
  scalars_.resize(2 + max_parameters);
  double* by_parameters[max_parameters] = {};
  NeuronScalars scalars{nullptr, nullptr, by_parameters};
  for (const ResolvedSets::NeuronEntry& entry : *wanted_) {
    std::vector<double>& values = scalars_[entry.by == By::mass ? 0 : entry.by == By::time ? 1 : 2 + entry.parameter];
    values.resize(3 * count);
    (entry.by == By::mass   ? scalars.by_mass
     : entry.by == By::time ? scalars.by_time
                            : by_parameters[entry.parameter]) = values.data();
  }
  const double* const forces[3] = {force + piece.begin, force + n + piece.begin, force + 2 * n + piece.begin};
  double* const accelerations[3] = {acceleration_.data(), acceleration_.data() + count,
                                    acceleration_.data() + 2 * count};
  return evaluator_.accelerations(static_cast<std::uint32_t>(piece.begin), static_cast<std::uint32_t>(count), at.time,
                                  at.nodes, forces, accelerations, by_force_.data(), nullptr, nullptr, scalars,
                                  message);
}

}  // namespace springnet::layers
