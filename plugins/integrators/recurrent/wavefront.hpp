// The order in which a wavefront sweep updates the nodes: layer by layer from a start node (breadth first), as in
// section 3.4 of Nürnberger, Radetzky, Kruse, "A Problem Specific Recurrent Neural Network for the Description and
// Simulation of Dynamic Spring Models". Parts of the network that the wave does not reach are appended one by one, each
// from its own node with the greatest force, the part with the greatest such force first.
//
// Start nodes are free nodes if there are any, because a force on a fixed or held node moves nothing. Ties go to the
// lowest of the user's numbers, also among the neighbours within a layer.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <springnet/sdk/plugin.h>

namespace springnet::recurrent {

class Wavefront {
 public:
  // Call after every change of network.revision; finds the connected parts of the network if it is another one.
  void attach(const springnet_network& network);

  // The node with the greatest force (arrays [node_count], N). The network must have a node.
  [[nodiscard]] std::uint32_t strongest(const springnet_network& network, const springnet_const_vectors& force) const;

  // All nodes, once each, in the order of a wave that begins at `start`. Valid until the next call. Does not allocate.
  std::span<const std::uint32_t> order(const springnet_network& network, std::uint32_t start,
                                       const springnet_const_vectors& force);

 private:
  // An order, by the starts of its waves.
  struct Found {
    std::vector<std::uint32_t> starts, order;
  };
  void choose_starts(const springnet_network& network, std::uint32_t start, const springnet_const_vectors& force);
  void spread(const springnet_network& network, std::uint32_t start);

  std::vector<std::uint32_t> part_;    // [node_count] which part a node belongs to
  std::vector<std::uint32_t> starts_;  // [parts] in the order of the wave
  std::vector<std::uint32_t> order_;   // [node_count]; it is the queue of the search as well
  std::vector<std::uint8_t> reached_;  // [node_count]
  std::vector<Found> found_;           // used last first; memory for all is allocated by attach()
  std::size_t found_count_ = 0;
  std::uint64_t revision_ = 0;  // of the connections; 0: not known
};

}  // namespace springnet::recurrent
