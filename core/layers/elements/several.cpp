#include "layers/elements/several.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

namespace springnet::layers {
namespace {

Invariant invariant_of(Measure measure) {
  switch (measure) {
    case Measure::angle:
      return Invariant::angle;
    case Measure::dihedral:
      return Invariant::dihedral;
    case Measure::area:
      return Invariant::area;
    default:
      return Invariant::volume;
  }
}

Vector3 triple(const double (*rows)[several_batch], std::size_t i) { return {rows[0][i], rows[1][i], rows[2][i]}; }

// Corners of a scalar of member i, relative to the first corner of the element.
Corners corners_of(const ElementScalar& scalar, const SeveralGeometry& geometry, std::size_t i, bool rates) {
  Corners corners;
  for (std::size_t c = 0; c < scalar.corner_count(); ++c) {
    corners.position[c] = triple(geometry.position + 3 * scalar.corner[c], i);
    corners.velocity[c] = rates ? triple(geometry.velocity + 3 * scalar.corner[c], i) : Vector3::Zero();
  }
  return corners;
}

// Whether kernels know the second derivatives.
bool is_in_kernels(const ElementScalar& scalar) {
  return scalar.measure == Measure::length || scalar.measure == Measure::volume;
}

constexpr std::size_t none = 4;
std::size_t place_of(const ElementScalar& scalar, std::size_t corner) {
  for (std::size_t c = 0; c < scalar.corner_count(); ++c)
    if (scalar.corner[c] == corner) return c;
  return none;
}

}  // namespace

Vector3 gradient_of(const ElementScalar& scalar, const double (*rows)[several_batch], std::size_t c,
                    std::size_t i) noexcept {
  if (scalar.measure != Measure::length) return triple(rows + 3 * c, i);
  return c == 0 ? triple(rows, i) : Vector3(-triple(rows, i));
}

Vector3 rate_gradient_of(const ElementScalar& scalar, const SeveralGeometry& geometry, std::size_t s, std::size_t c,
                         std::size_t i) noexcept {
  if (scalar.measure != Measure::length)
    return own_second_order(invariant_of(scalar.measure), corners_of(scalar, geometry, i, true), c).rate_gradient;
  const double length = geometry.value[s][i];
  if (!(length > 0.0)) return Vector3::Zero();
  const Vector3 n = gradient_of(scalar, geometry.gradient[s], c, i);
  const Vector3 v =
      triple(geometry.velocity + 3 * scalar.corner[c], i) - triple(geometry.velocity + 3 * scalar.corner[1 - c], i);
  return (v - n * n.dot(v)) / length;
}

SeveralInputs inputs_of(const SeveralMembers& members, const SeveralGeometry& geometry) noexcept {
  SeveralInputs inputs;
  for (std::size_t s = 0; s < max_scalars; ++s) {
    inputs.value[s] = geometry.value[s];
    inputs.rate[s] = geometry.rate[s];
    inputs.reference[s] = members.reference[s];
  }
  std::copy_n(members.direction, 3, inputs.direction);
  return inputs;
}

SeveralMembers members_of(const ElementLayout& elements, const ElementBatch& batch) noexcept {
  SeveralMembers members;
  members.corners = elements.corners(batch);
  elements.several_arrays(batch, members.reference, members.direction);
  const std::uint32_t* const rows = elements.rows(batch);
  members.rows = batch.one_row ? RowSelection{nullptr, rows[0]} : RowSelection{rows, 0};
  members.called = called_for(elements, batch);
  return members;
}

void GatheredMembers::put(const ElementLayout& elements, std::size_t i, std::uint32_t element) noexcept {
  element_[i] = element;
  const std::span<const std::uint32_t> own = elements.nodes(element);
  for (std::size_t c = 0; c < max_corners; ++c) corner_[c][i] = own[std::min(c, own.size() - 1)];
  const SeveralRest& rest = elements.rest(element);
  for (std::size_t s = 0; s < max_scalars; ++s) reference_[s][i] = rest.reference[s];
  for (std::size_t c = 0; c < 3; ++c) direction_[c][i] = rest.direction[c];
  row_[i] = elements.row(element);
}

const SeveralMembers& GatheredMembers::finish(std::size_t count) noexcept {
  members_.corners = {{corner_[0], corner_[1], corner_[2], corner_[3]}, nullptr, count};
  for (std::size_t s = 0; s < max_scalars; ++s) members_.reference[s] = reference_[s];
  for (std::size_t c = 0; c < 3; ++c) members_.direction[c] = direction_[c];
  members_.rows = {row_, 0};
  members_.called = {CalledMembers::Are::elements, static_cast<std::uint32_t>(count), 1, element_};
  return members_;
}

springnet_status evaluate_several(const Group& group, const SeveralMembers& members, const SeveralGeometry& geometry,
                                  InstructionSet set, double time, SeveralWanted wanted, SeveralAnswers& answers,
                                  springnet_message& message) {
  const SeveralInputs inputs = inputs_of(members, geometry);
  const bool tangent = wanted == SeveralWanted::tangent;
  SeveralOutputs outputs[2];
  PairOutputs out{};
  for (std::size_t k = 0; k < 2; ++k) {
    const Law& law = *group.laws()[k];
    if (!law) continue;
    for (std::size_t i = 0; i < law.scalar_count; ++i) {
      const std::size_t s = law.scalar[i];
      outputs[k].force[s] = answers.force[k][s];
      for (std::size_t j = 0; tangent && j < law.scalar_count; ++j) {
        const std::size_t to = max_scalars * s + law.scalar[j];
        outputs[k].by_value[to] = answers.by_value[k][to];
        outputs[k].by_rate[to] = answers.by_rate[k][to];
      }
    }
    out[k].several = &outputs[k];
    out[k].several_tangent = tangent;
    if (wanted == SeveralWanted::forces_and_energies) out[k].energy = answers.energy[k];
    if (wanted == SeveralWanted::margins) out[k].margin = answers.margin[k];
  }
  LawBatch batch{group, members.corners.count, members.rows, nullptr, nullptr};
  batch.several = &inputs;
  batch.members = members.called;
  return evaluate_laws(batch, set, time, out, message);
}

springnet_status several_energy_gradients(const Group& group, const SeveralMembers& members,
                                          const SeveralGeometry& geometry, InstructionSet set, double time,
                                          SeveralEnergyGradients& gradients, springnet_message& message) {
  const SeveralInputs inputs = inputs_of(members, geometry);
  std::vector<double*> jacobian[2];
  PairOutputs out{};
  for (std::size_t k = 0; k < 2; ++k) {
    for (double(&of_scalar)[several_batch] : gradients.value[k]) std::fill_n(of_scalar, members.corners.count, 0.0);
    const Law& law = *group.laws()[k];
    if (!law || !law.can(SPRINGNET_HAS_ENERGY) || !law.can(SPRINGNET_HAS_ALL_DERIVATIVES)) continue;
    const sdk::JacobianLayout layout = jacobian_of(law);
    jacobian[k].assign(layout.rows() * layout.columns(false), nullptr);
    for (std::size_t i = 0; i < law.scalar_count; ++i)
      if (law.reads[i])
        jacobian[k][layout.energy() * layout.columns(false) + layout.value(i)] = gradients.value[k][law.scalar[i]];
    out[k].derivatives = jacobian[k].data();
  }
  LawBatch batch{group, members.corners.count, members.rows, nullptr, nullptr};
  batch.several = &inputs;
  batch.members = members.called;
  return evaluate_laws(batch, set, time, out, message);
}

void forces_of(const Group& group, const SeveralAnswers& answers, const double* (&out)[2][max_scalars]) noexcept {
  for (std::size_t k = 0; k < 2; ++k) {
    std::fill_n(out[k], max_scalars, nullptr);
    const Law& law = *group.laws()[k];
    if (!law) continue;
    for (std::size_t i = 0; i < law.scalar_count; ++i)
      if (law.reads[i]) out[k][law.scalar[i]] = answers.force[k][law.scalar[i]];
  }
}

bool tangent_of(const Kernels& kernels, const Group& group, const SeveralAnswers& answers, std::size_t count,
                SeveralTangent& out) noexcept {
  const ScalarList& list = group.scalars;
  // What each law reads, and whether it has rates. What is read at rest alone has no derivatives.
  bool reads[2][max_scalars] = {}, has_rates[2] = {};
  for (std::size_t k = 0; k < 2; ++k) {
    const Law& law = *group.laws()[k];
    has_rates[k] = law.reads_rate;
    for (std::size_t i = 0; law && i < law.scalar_count; ++i) reads[k][law.scalar[i]] = law.reads[i];
  }
  out.has_rates = group.reads_rate();
  bool finite = true;
  for (std::size_t s = 0; s < list.count; ++s) {
    if (list.scalar[s].reference_only) continue;
    const auto add = [&](const auto& rows, std::size_t row, std::size_t j, bool rates, double* to) {
      const double* from[2];
      for (std::size_t k = 0; k < 2; ++k)
        from[k] = reads[k][s] && reads[k][j] && (!rates || has_rates[k]) ? rows[k][row] : nullptr;
      finite = kernels.several.sum(from[0], from[1], count, to) && finite;
    };
    add(answers.force, s, s, false, out.force[s]);
    for (std::size_t j = 0; j < list.count; ++j) {
      if (list.scalar[j].reference_only) continue;
      const std::size_t at = max_scalars * s + j;
      add(answers.by_value, at, j, false, out.by_value[at]);
      if (out.has_rates) add(answers.by_rate, at, j, true, out.by_rate[at]);
    }
  }
  return finite;
}

void several_blocks(const Kernels& kernels, const ScalarList& list, const SeveralGeometry& geometry, std::size_t begin,
                    std::size_t count, const SeveralTangent& tangent, SeveralRateGradients& rate_gradients,
                    SeveralBlocks& out) noexcept {
  // The kernel multiplies by the rate gradients of all scalars, and clears the blocks first: Hessians come after it.
  SecondOrder second;
  for (std::size_t s = 0; tangent.has_rates && s < list.count; ++s) {
    const ElementScalar& scalar = list.scalar[s];
    if (scalar.reference_only || is_in_kernels(scalar)) continue;
    for (std::size_t i = 0; i < count; ++i) {
      second_order(invariant_of(scalar.measure), corners_of(scalar, geometry, begin + i, true), second);
      for (std::size_t c = 0; c < 3 * scalar.corner_count(); ++c)
        rate_gradients.value[s][c][i] = second.rate_gradient[c / 3][static_cast<Eigen::Index>(c % 3)];
    }
    for (std::size_t c = 0; c < 12; ++c)
      std::fill(rate_gradients.value[s][c] + count, std::end(rate_gradients.value[s][c]), 0.0);
  }
  kernels.several.blocks(list, geometry, begin, tangent, rate_gradients, out);
  for (std::size_t s = 0; s < list.count; ++s) {
    const ElementScalar& scalar = list.scalar[s];
    if (scalar.reference_only || is_in_kernels(scalar)) continue;
    for (std::size_t i = 0; i < count; ++i) {
      second_order(invariant_of(scalar.measure), corners_of(scalar, geometry, begin + i, false), second);
      for (std::size_t a = 0; a < scalar.corner_count(); ++a)
        for (std::size_t b = 0; b < scalar.corner_count(); ++b)
          for (std::size_t k = 0; k < 9; ++k)
            out.stiffness[scalar.corner[a]][scalar.corner[b]][k][i] +=
                tangent.force[s][begin + i] *
                second.hessian[a][b](static_cast<Eigen::Index>(k / 3), static_cast<Eigen::Index>(k % 3));
    }
  }
}

void several_own_blocks(const ScalarList& list, const SeveralGeometry& geometry, std::size_t i,
                        const SeveralTangent& tangent, std::size_t corner, Block& stiffness, Block& damping) noexcept {
  stiffness.setZero();
  damping.setZero();
  Vector3 gradient[max_scalars], rate_gradient[max_scalars];
  bool reads[max_scalars];
  for (std::size_t s = 0; s < list.count; ++s) {
    const ElementScalar& scalar = list.scalar[s];
    const std::size_t c = place_of(scalar, corner);
    reads[s] = !scalar.reference_only && c != none;
    if (!reads[s]) continue;
    gradient[s] = gradient_of(scalar, geometry.gradient[s], c, i);
    rate_gradient[s].setZero();
    if (scalar.measure == Measure::length) {
      const double length = geometry.value[s][i];
      if (!(length > 0.0)) continue;
      const Vector3& n = gradient[s];
      stiffness += tangent.force[s][i] / length * (Block::Identity() - n * n.transpose());
      if (tangent.has_rates) rate_gradient[s] = rate_gradient_of(scalar, geometry, s, c, i);
    } else {
      const OwnSecondOrder own =
          own_second_order(invariant_of(scalar.measure), corners_of(scalar, geometry, i, tangent.has_rates), c);
      stiffness += tangent.force[s][i] * own.hessian;
      rate_gradient[s] = own.rate_gradient;
    }
  }
  for (std::size_t s = 0; s < list.count; ++s) {
    if (!reads[s]) continue;
    for (std::size_t j = 0; j < list.count; ++j) {
      if (!reads[j]) continue;
      const std::size_t at = max_scalars * s + j;
      Vector3 change = tangent.by_value[at][i] * gradient[j];
      if (tangent.has_rates) {
        change += tangent.by_rate[at][i] * rate_gradient[j];
        damping += tangent.by_rate[at][i] * gradient[s] * gradient[j].transpose();
      }
      stiffness += gradient[s] * change.transpose();
    }
  }
}

}  // namespace springnet::layers
