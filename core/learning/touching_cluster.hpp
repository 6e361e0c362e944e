// What rigid connections and surfaces together make of the outputs of a cluster at the end of a step, differentiated.
// Contacts, friction and connections are solved at once there, a node that touches is put where its path met the
// surface: no formula gives all of that, so the derivative is that of differences of the sweep itself.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "learning/contact_output.hpp"
#include "learning/rigid_output.hpp"
#include "simulation/model.hpp"

namespace springnet::learning {

// The contacts are those of the cluster's nodes over the step. Changes the contacts of the model; its masses are as
// they were. None if the sweep does not give (P, U), or if contacts change however small the differences.
[[nodiscard]] std::optional<ClusterDerivative> output_differences(Model& model, std::size_t cluster,
                                                                  const std::shared_ptr<const Placement>& start,
                                                                  const StepPlacement& step, double until,
                                                                  const std::vector<StepContact>& contacts,
                                                                  const ClusterOverStep& given);

}  // namespace springnet::learning
