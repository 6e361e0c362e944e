// Derivatives of forces and of constrained accelerations by parameters of the network: springnet_host's
// parameter_tangent and parameter_cotangent.
#pragma once

#include <vector>

#include "layers/parameters/products.hpp"
#include "simulation/constrained_response.hpp"
#include "simulation/model.hpp"

namespace springnet {

// The sets of a request; throws as ParameterModel does.
[[nodiscard]] layers::ResolvedSets resolve_sets(const layers::Layout& layout,
                                                const springnet_parameter_set* const* sets, std::uint32_t count,
                                                bool with_states);

class ParameterModel {
 public:
  explicit ParameterModel(Model& model) : model_(model), products_(model.layout, model.evaluator) {}

  // Statuses and messages as in springnet_host; throws Error(plugin) for sets that the network does not have, and laws
  // without the derivatives.
  springnet_status tangent(const springnet_parameter_product& request);
  springnet_status cotangent(const springnet_parameter_product& request);

 private:
  struct At;  // the state of a request
  // What constraints make of free accelerations at a state; with masses, what they add to accelerations as well.
  springnet_status find_response(const At& at);
  springnet_status find_forces(const At& at);

  Model& model_;
  layers::ParameterProducts products_;
  ConstrainedResponse response_;
  std::vector<double> force_, force_change_, weights_, force_weights_;  // [3 node]
};

}  // namespace springnet
