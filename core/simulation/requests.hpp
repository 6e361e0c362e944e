// Checks requests of an integrator before the engine reads them, so that no mistake of an integrator ends the process.
// All functions throw Error(plugin) with the mistake.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/sdk/plugin.h>

#include "layers/layout.hpp"

namespace springnet {

void require_array(const void* array, const char* name);
void require_size(std::uint32_t size, const char* name, std::size_t min_size);
void require_finite(double value, const char* name);
void require_vectors(const springnet_vectors& vectors, const char* name);
void require_vectors(const springnet_const_vectors& vectors, const char* name);

// An evaluation: at least as large as in ABI 2.0, with positions, velocities and a time; each output has all three of
// its arrays, or none.
const springnet_evaluation& checked(const springnet_evaluation* evaluation);
// The same for the end of a sweep by itself.
const springnet_sweep& checked_end(const springnet_sweep* sweep);
// A search for touches within a step.
springnet_impact_search& checked(springnet_impact_search* search);
// A sweep of a network of `node_count` nodes, except for its order.
const springnet_sweep& checked(const springnet_sweep* sweep, std::uint32_t node_count);

// The request in this host's version of the struct, whatever version the integrator was compiled against.
[[nodiscard]] springnet_sweep complete(const springnet_sweep& request);
// A sweep of the linearised network.
const springnet_sweep& checked_linear(const springnet_sweep* sweep, std::uint32_t node_count);
// Sets of parameters, with weights or a place for the answer.
const springnet_parameter_product& checked(const springnet_parameter_product* product);
void check_sets(const springnet_parameter_set* const* sets, std::uint32_t count);
// A search for an eigenvalue.
springnet_eigenvalue_search& checked(springnet_eigenvalue_search* search);

// A linear system, and its solution.
const springnet_linear_system& checked(const springnet_linear_system* system);
springnet_linear_solve& checked(springnet_linear_solve* solve);

// Nodes of an evaluation.
void check_nodes(const std::uint32_t* nodes, std::uint32_t count, std::uint32_t node_count);

// Checks the order of sweeps. Many sweeps have the same order: one that was found valid is kept for comparison.
class OrderCheck {
 public:
  // `network.revision` shows changes of the network's connections.
  void check(const springnet_sweep& sweep, const springnet_network& network, const layers::Layout& layout);

 private:
  void check_order(const springnet_sweep& sweep, const springnet_network& network);
  void check_sets(const springnet_sweep& sweep, const springnet_network& network, const layers::Layout& layout);

  std::vector<std::uint32_t> order_, set_start_;  // found valid
  std::vector<std::uint32_t> set_of_;             // [node] its place in the order, then its set
  std::uint64_t revision_ = 0;
};

}  // namespace springnet
