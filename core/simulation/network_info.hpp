// springnet_network, the network as integrators see it, kept up to date with the model.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/contact_events.hpp"
#include "simulation/model.hpp"

namespace springnet {

class NetworkInfo {
 public:
  NetworkInfo(Model& model, ContactEvents& events) : model_(model), events_(events) {}
  // The present network. The address of the struct does not change.
  [[nodiscard]] const springnet_network& now();
  [[nodiscard]] const springnet_network& with_neighbours();

 private:
  void add_neighbours();

  Model& model_;
  ContactEvents& events_;
  springnet_network info_{};
  std::uint64_t revision_ = 0;
  std::vector<const springnet_internal_range*> internal_ranges_;
  std::vector<std::uint32_t> no_cluster_;  // [node] if there are no rigid connections
};

}  // namespace springnet
