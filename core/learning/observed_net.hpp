// The net of an experiment, as residuals need it beside its motion.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <springnet/reaction_derivatives.hpp>

#include "learning/surface.hpp"

namespace springnet::learning {

class ObservedNet {
 public:
  ObservedNet(std::shared_ptr<const Network> network, std::shared_ptr<const PluginHost> plugins,
              SimulationOptions options, std::vector<LearnedValues> learned)
      : network_(std::move(network)),
        plugins_(std::move(plugins)),
        options_(std::move(options)),
        learned_(std::move(learned)) {}

  // Made where they are first observed, as both take time and memory.
  [[nodiscard]] Surface& surface() {
    if (!surface_) surface_ = std::make_unique<Surface>(*network_);
    return *surface_;
  }
  [[nodiscard]] ReactionDerivatives& reactions() {
    if (!reactions_) reactions_ = std::make_unique<ReactionDerivatives>(network_, plugins_, options_, learned_);
    return *reactions_;
  }

 private:
  std::shared_ptr<const Network> network_;
  std::shared_ptr<const PluginHost> plugins_;
  SimulationOptions options_;
  std::vector<LearnedValues> learned_;
  std::unique_ptr<Surface> surface_;
  std::unique_ptr<ReactionDerivatives> reactions_;
};

}  // namespace springnet::learning
