// The network as integrators see it: springnet_network, kept up to date with the model.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/contact_events.hpp"
#include "simulation/model.hpp"

namespace springnet {

class NetworkInfo {
 public:
  NetworkInfo(Model& model, ContactEvents& events) : model_(model), events_(events) {}
  // As it is now. The struct stays where it is.
  [[nodiscard]] const springnet_network& now();

 private:
  Model& model_;
  ContactEvents& events_;
  springnet_network info_{};
  std::uint64_t revision_ = 0;
  std::vector<std::uint32_t> no_cluster_;  // [node] without rigid connections
};

}  // namespace springnet
