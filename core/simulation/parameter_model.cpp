#include "simulation/parameter_model.hpp"

#include <algorithm>

#include <springnet/error.hpp>

#include "simulation/reactions_at.hpp"
#include "simulation/rows_aside.hpp"

namespace springnet {
namespace {

using layers::ParameterSet;

ParameterSet set_of(const springnet_parameter_set& given) {
  ParameterSet set;
  switch (given.kind) {
    case SPRINGNET_BY_REFERENCE:
      set.kind = ParameterSet::Kind::reference;
      break;
    case SPRINGNET_BY_SPRING_PARAMETER:
      set.kind = ParameterSet::Kind::spring;
      break;
    case SPRINGNET_BY_VISCOSITY_PARAMETER:
      set.kind = ParameterSet::Kind::viscosity;
      break;
    case SPRINGNET_BY_MASS:
      set.kind = ParameterSet::Kind::mass;
      break;
    case SPRINGNET_BY_NEURON_PARAMETER:
      set.kind = ParameterSet::Kind::neuron;
      break;
    case SPRINGNET_BY_INPUT:
      set.kind = ParameterSet::Kind::input;
      break;
    default:
      set.kind = ParameterSet::Kind::time;
      break;
  }
  set.of_elements = given.of_elements != 0;
  set.input = given.input;
  if (given.component != nullptr) set.component = given.component;
  if (given.parameter != nullptr) set.parameter = given.parameter;
  set.values = given.values;
  return set;
}

// Calls what(set) for every set of masses.
template <class What>
void for_each_mass(const layers::ResolvedSets& sets, const What& what) {
  for (const ParameterSet& set : sets.sets())
    if (set.kind == ParameterSet::Kind::mass) what(set.values);
}

Vector3 vector_of(const std::vector<double>& values, std::size_t k) {
  const std::size_t n = values.size() / 3;
  return {values[k], values[n + k], values[2 * n + k]};
}
void add(double* values, std::size_t n, std::size_t k, const Vector3& change) {
  for (std::size_t c = 0; c < 3; ++c) values[c * n + k] += change[static_cast<Eigen::Index>(c)];
}

}  // namespace

layers::ResolvedSets resolve_sets(const layers::Layout& layout, const springnet_parameter_set* const* given,
                                  std::uint32_t count, bool with_states) {
  std::vector<ParameterSet> sets;
  for (std::uint32_t i = 0; i < count; ++i) sets.push_back(set_of(*given[i]));
  return {layout, sets, with_states};
}

struct ParameterModel::At {
  At(Model& model, const springnet_evaluation& given) : request(given), internal(model.internal_for(given.internal)) {
    internal.next = internal.rates = nullptr;
  }
  At(const At&) = delete;
  At& operator=(const At&) = delete;

  const springnet_evaluation& request;
  layers::InternalView internal;
  layers::NodeArrays nodes = node_arrays(request.position, request.velocity, internal);
  layers::HeldState held{request.time, nodes};
};

springnet_status ParameterModel::find_response(const At& at) {
  const RowsAside aside(model_.constraints);
  const springnet_evaluation& request = at.request;
  model_.constraints.linearise(*model_.placement(request.time), request.position);
  ReactionsAt reactions(model_, request.time, request.position, request.velocity, at.internal);
  return response_.find(model_, reactions);
}

springnet_status ParameterModel::find_forces(const At& at) {
  const std::size_t n = model_.node_count();
  force_.resize(3 * n);
  return model_.evaluator.evaluate(at.request.time, at.nodes, model_.external_at(at.request.time),
                                   {force_.data(), force_.data() + n, force_.data() + 2 * n}, {},
                                   model_.journal.message);
}

springnet_status ParameterModel::tangent(const springnet_parameter_product& request) {
  const std::size_t n = model_.node_count();
  const layers::ResolvedSets sets =
      resolve_sets(model_.layout, request.sets, request.set_count, request.internal != nullptr);
  const At at(model_, *request.at);
  force_change_.resize(3 * n);
  springnet_status status =
      products_.force_change(sets, at.held, force_change_.data(), request.internal, model_.journal.message);
  if (status != SPRINGNET_OK) return status;
  const Vector3 gravity = model_.external_at(request.at->time).gravity;
  for_each_mass(sets, [&](const double* change) {
    for (std::size_t k = 0; k < n; ++k) add(force_change_.data(), n, k, change[k] * gravity);
  });
  if (request.force != nullptr) std::copy(force_change_.begin(), force_change_.end(), request.force);
  if (request.acceleration == nullptr) return SPRINGNET_OK;
  if (status = find_response(at); status != SPRINGNET_OK) return status;
  if (status = find_forces(at); status != SPRINGNET_OK) return status;
  status = products_.acceleration_change(sets, at.held, force_.data(), force_change_.data(), request.acceleration,
                                         model_.journal.message);
  if (status != SPRINGNET_OK) return status;
  // Forces of constraints, m (a - a_free), accelerate a mass that is greater less.
  for_each_mass(sets, [&](const double* change) {
    for (std::uint32_t k = 0; k < n; ++k)
      add(request.acceleration, n, k, -change[k] / model_.mass[k] * response_.added(k));
  });
  response_.apply(false, request.acceleration);
  return SPRINGNET_OK;
}

springnet_status ParameterModel::cotangent(const springnet_parameter_product& request) {
  const std::size_t n = model_.node_count();
  const layers::ResolvedSets sets =
      resolve_sets(model_.layout, request.sets, request.set_count, request.internal != nullptr);
  const At at(model_, *request.at);
  force_weights_.assign(3 * n, 0.0);
  if (request.force != nullptr) std::copy_n(request.force, 3 * n, force_weights_.data());
  if (request.acceleration != nullptr) {
    if (const springnet_status status = find_response(at); status != SPRINGNET_OK) return status;
    if (const springnet_status status = find_forces(at); status != SPRINGNET_OK) return status;
    weights_.assign(request.acceleration, request.acceleration + 3 * n);
    response_.apply(true, weights_.data());
    for_each_mass(sets, [&](double* values) {
      for (std::uint32_t k = 0; k < n; ++k)
        values[k] -= vector_of(weights_, k).dot(response_.added(k)) / model_.mass[k];
    });
    const springnet_status status = products_.weigh_accelerations(sets, at.held, force_.data(), weights_.data(),
                                                                  force_weights_.data(), model_.journal.message);
    if (status != SPRINGNET_OK) return status;
  }
  const Vector3 gravity = model_.external_at(request.at->time).gravity;
  for_each_mass(sets, [&](double* values) {
    for (std::size_t k = 0; k < n; ++k) values[k] += gravity.dot(vector_of(force_weights_, k));
  });
  return products_.weigh_forces(sets, at.held, force_weights_.data(), request.internal, model_.journal.message);
}

}  // namespace springnet
