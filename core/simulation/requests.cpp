#include "simulation/requests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string>

#include <springnet/error.hpp>

#include "constraints/cluster.hpp"

namespace springnet {
namespace {

constexpr std::uint32_t in_no_set = 0xffffffffu;

// Sizes of the structs in ABI 2.0; an integrator compiled against it gives no more.
constexpr std::size_t evaluation_size = SPRINGNET_SIZE_TO(springnet_evaluation, free_acceleration);
constexpr std::size_t internal_size = SPRINGNET_SIZE_TO(springnet_internal, rates);
constexpr std::size_t sweep_size = SPRINGNET_SIZE_TO(springnet_sweep, internal);
constexpr std::size_t impact_search_size = SPRINGNET_SIZE_TO(springnet_impact_search, time);
constexpr std::size_t linear_system_size = SPRINGNET_SIZE_TO(springnet_linear_system, at);
constexpr std::size_t linear_solve_size = SPRINGNET_SIZE_TO(springnet_linear_solve, iterations);
constexpr std::size_t parameter_product_size = SPRINGNET_SIZE_TO(springnet_parameter_product, internal);
constexpr std::size_t parameter_set_size = SPRINGNET_SIZE_TO(springnet_parameter_set, values);
constexpr std::size_t eigenvalue_size = SPRINGNET_SIZE_TO(springnet_eigenvalue_search, applications);

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorKind::plugin, what); }

template <class Request>
const Request& sized(const Request* request, const char* name, std::size_t min_size) {
  if (request == nullptr) refuse(fmt::format("the {} is a null pointer", name));
  require_size(request->struct_size, name, min_size);
  return *request;
}

void check_internal(const springnet_internal* internal) {
  if (internal != nullptr) static_cast<void>(sized(internal, "springnet_internal", internal_size));
}

template <class Vectors>
void require_all(const Vectors& vectors, const char* name) {
  if (vectors.x == nullptr || vectors.y == nullptr || vectors.z == nullptr)
    refuse(fmt::format("{} has a null pointer", name));
}

// Outputs: all three arrays, or none.
void require_all_or_none(const springnet_vectors& vectors, const char* name) {
  const bool none = vectors.x == nullptr && vectors.y == nullptr && vectors.z == nullptr;
  if (!none) require_all(vectors, name);
}

bool same(const double* a, const double* b) { return a == b; }

bool any_same(const springnet_const_vectors& a, const springnet_vectors& b) {
  return same(a.x, b.x) || same(a.y, b.y) || same(a.z, b.z);
}
bool all_same(const springnet_const_vectors& a, const springnet_vectors& b) {
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}

void check_ends(const springnet_sweep& sweep) {
  require_vectors(sweep.start_position, "start_position");
  require_vectors(sweep.start_velocity, "start_velocity");
  require_vectors(sweep.position, "position");
  require_vectors(sweep.velocity, "velocity");
  require_vectors(sweep.next_position, "next_position");
  require_vectors(sweep.next_velocity, "next_velocity");
  if (sweep.order == nullptr)
    require_all_or_none(sweep.force, "force");
  else
    require_vectors(sweep.force, "force");
  require_finite(sweep.time, "time");
  const springnet_sweep later = complete(sweep);
  require_finite(later.time_constant, "time_constant");
  require_finite(later.theta, "theta");
  require_all_or_none(later.constraint_force, "constraint_force");
  check_internal(later.internal);
}

}  // namespace

springnet_sweep complete(const springnet_sweep& given) {
  springnet_sweep sweep{};
  std::memcpy(&sweep, &given, std::min<std::size_t>(sizeof sweep, given.struct_size));
  sweep.struct_size = sizeof sweep;
  return sweep;
}

void require_size(std::uint32_t size, const char* name, std::size_t min_size) {
  if (size >= min_size) return;
  refuse(fmt::format("the {} has {} bytes, and must have at least {}; set its struct_size", name, size, min_size));
}
void require_array(const void* array, const char* name) {
  if (array == nullptr) refuse(fmt::format("{} is a null pointer", name));
}
void require_finite(double value, const char* name) {
  if (!std::isfinite(value)) refuse(fmt::format("{} is {}, not a finite number", name, value));
}
void require_vectors(const springnet_vectors& vectors, const char* name) { require_all(vectors, name); }
void require_vectors(const springnet_const_vectors& vectors, const char* name) { require_all(vectors, name); }

const springnet_evaluation& checked(const springnet_evaluation* evaluation) {
  const springnet_evaluation& request = sized(evaluation, "springnet_evaluation", evaluation_size);
  require_finite(request.time, "time");
  require_vectors(request.position, "position");
  require_vectors(request.velocity, "velocity");
  require_all_or_none(request.force, "force");
  require_all_or_none(request.acceleration, "acceleration");
  require_all_or_none(request.free_acceleration, "free_acceleration");
  if (request.free_acceleration.x != nullptr) require_all(request.acceleration, "acceleration");
  check_internal(request.internal);
  return request;
}

springnet_impact_search& checked(springnet_impact_search* search) {
  static_cast<void>(sized(search, "springnet_impact_search", impact_search_size));
  springnet_impact_search& request = *search;
  require_finite(request.step_from, "step_from");
  require_finite(request.step_until, "step_until");
  if (!(request.step_until > request.step_from)) refuse("the step ends no later than it begins");
  require_finite(request.from, "from");
  require_finite(request.until, "until");
  if (request.until < request.from) refuse("the part that is searched ends before it begins");
  if (!(request.depth >= 0.0 && std::isfinite(request.depth)))
    refuse(fmt::format("depth is {} m, must be at least 0", request.depth));
  if (request.state_at == nullptr) refuse("state_at is a null pointer");
  return request;
}

const springnet_sweep& checked_end(const springnet_sweep* sweep) {
  const springnet_sweep& request = sized(sweep, "springnet_sweep", sweep_size);
  check_ends(request);
  return request;
}

const springnet_sweep& checked(const springnet_sweep* sweep, std::uint32_t node_count) {
  const springnet_sweep& request = checked_end(sweep);
  if (request.update == nullptr) refuse("update is a null pointer");
  if (request.order == nullptr) {
    if (any_same(request.position, request.next_position) || any_same(request.velocity, request.next_velocity))
      refuse(
          "without an order, outputs that springs still read would be replaced: next_position and next_velocity "
          "must be other arrays than position and velocity");
    return request;
  }
  if (!all_same(request.position, request.next_position) || !all_same(request.velocity, request.next_velocity))
    refuse(
        "with an order each node reads the newest outputs: next_position and next_velocity must be the arrays of "
        "position and velocity");
  if (request.order_count > node_count)
    refuse(fmt::format("the order has {} nodes, the network {}", request.order_count, node_count));
  return request;
}

const springnet_parameter_product& checked(const springnet_parameter_product* product) {
  const springnet_parameter_product& request = sized(product, "springnet_parameter_product", parameter_product_size);
  static_cast<void>(checked(request.at));
  if (request.force == nullptr && request.acceleration == nullptr && request.internal == nullptr)
    refuse("force, acceleration and internal are all null pointers");
  check_sets(request.sets, request.set_count);
  return request;
}

void check_sets(const springnet_parameter_set* const* sets, std::uint32_t count) {
  if (count > 0) require_array(sets, "sets");
  for (std::uint32_t i = 0; i < count; ++i) {
    const springnet_parameter_set& set = sized(sets[i], "springnet_parameter_set", parameter_set_size);
    if (set.kind < SPRINGNET_BY_REFERENCE || set.kind > SPRINGNET_BY_TIME)
      refuse(fmt::format("the kind of parameter set {} is {}, must be {} to {}", i, set.kind, SPRINGNET_BY_REFERENCE,
                         SPRINGNET_BY_TIME));
    const bool is_named = set.kind == SPRINGNET_BY_SPRING_PARAMETER || set.kind == SPRINGNET_BY_VISCOSITY_PARAMETER ||
                          set.kind == SPRINGNET_BY_NEURON_PARAMETER;
    if (is_named) require_array(set.parameter, "the name of a parameter");
    require_array(set.values, "values");
  }
}

springnet_eigenvalue_search& checked(springnet_eigenvalue_search* search) {
  static_cast<void>(sized(search, "springnet_eigenvalue_search", eigenvalue_size));
  if (search->wanted > SPRINGNET_LARGEST_REAL_PART) refuse(fmt::format("wanted is {}, must be 0 or 1", search->wanted));
  require_array(reinterpret_cast<const void*>(search->map), "map");
  if (search->size == 0) return *search;
  require_array(search->start, "start");
  if (search->most_vectors == 0) refuse("most_vectors is 0");
  if (!(search->tolerance > 0.0)) refuse(fmt::format("tolerance is {}, must be above 0", search->tolerance));
  const double* const end = search->start + search->size;
  if (std::any_of(static_cast<const double*>(search->start), end, [](double x) { return !std::isfinite(x); }))
    refuse("start is not finite");
  return *search;
}

const springnet_linear_system& checked(const springnet_linear_system* system) {
  const springnet_linear_system& request = sized(system, "springnet_linear_system", linear_system_size);
  require_finite(request.velocity_weight, "velocity_weight");
  require_finite(request.position_weight, "position_weight");
  if (!(request.shift >= 0.0 && std::isfinite(request.shift)))
    refuse(fmt::format("shift is {}, must be at least 0", request.shift));
  if (request.at != nullptr) static_cast<void>(checked(request.at));
  return request;
}

springnet_linear_solve& checked(springnet_linear_solve* solve) {
  static_cast<void>(sized(solve, "springnet_linear_solve", linear_solve_size));
  require_array(solve->right_side, "right_side");
  require_array(solve->x, "x");
  if (!(solve->accuracy > 0.0)) refuse(fmt::format("accuracy is {}, must be above 0", solve->accuracy));
  return *solve;
}

const springnet_sweep& checked_linear(const springnet_sweep* sweep, std::uint32_t node_count) {
  const springnet_sweep& request = sized(sweep, "springnet_sweep", sweep_size);
  require_array(request.order, "order");
  require_array(reinterpret_cast<const void*>(request.update), "update");
  require_vectors(request.position, "position");
  require_vectors(request.velocity, "velocity");
  if (!all_same(request.position, request.next_position) || !all_same(request.velocity, request.next_velocity))
    refuse("next_position and next_velocity must be the arrays of position and velocity");
  if (request.order_count > node_count)
    refuse(fmt::format("the order has {} nodes, the network {}", request.order_count, node_count));
  require_finite(request.theta, "theta");
  if (!(request.time_constant > 0.0 && std::isfinite(request.time_constant)))
    refuse(fmt::format("time_constant is {} s, must be above 0", request.time_constant));
  return request;
}

void check_nodes(const std::uint32_t* nodes, std::uint32_t count, std::uint32_t node_count) {
  if (count == 0) return;
  require_array(nodes, "nodes");
  if (count > node_count) refuse(fmt::format("{} nodes were asked for, the network has {}", count, node_count));
  for (std::uint32_t i = 0; i < count; ++i)
    if (nodes[i] >= node_count)
      refuse(fmt::format("nodes[{}] is {}, the network has nodes 0 to {}", i, nodes[i], node_count - 1));
}

void OrderCheck::check(const springnet_sweep& sweep, const springnet_network& network, const layers::Layout& layout) {
  const std::uint32_t set_ends = sweep.set_start == nullptr ? 0 : sweep.set_count + 1;
  if (sweep.set_start != nullptr && sweep.set_count > sweep.order_count)
    refuse(fmt::format("there are {} sets for {} nodes", sweep.set_count, sweep.order_count));
  const bool known = (revision_ == network.revision || sweep.set_start == nullptr) &&
                     order_.size() == sweep.order_count && set_start_.size() == set_ends &&
                     std::equal(order_.begin(), order_.end(), sweep.order) &&
                     std::equal(set_start_.begin(), set_start_.end(), sweep.set_start);
  if (known) return;
  order_.clear();
  set_start_.clear();
  check_order(sweep, network);
  if (sweep.set_start != nullptr) check_sets(sweep, network, layout);
  order_.assign(sweep.order, sweep.order + sweep.order_count);
  set_start_.assign(sweep.set_start, sweep.set_start + set_ends);
  revision_ = network.revision;
}

void OrderCheck::check_order(const springnet_sweep& sweep, const springnet_network& network) {
  set_of_.assign(network.node_count, in_no_set);
  for (std::uint32_t i = 0; i < sweep.order_count; ++i) {
    const std::uint32_t k = sweep.order[i];
    if (k >= network.node_count)
      refuse(fmt::format("order[{}] is {}, the network has nodes 0 to {}", i, k, network.node_count - 1));
    if (set_of_[k] != in_no_set) refuse(fmt::format("node {} is in the order twice, at {} and {}", k, set_of_[k], i));
    set_of_[k] = i;
  }
}

// Several threads update the nodes of a set: no node may read what another one writes.
void OrderCheck::check_sets(const springnet_sweep& sweep, const springnet_network& network,
                            const layers::Layout& layout) {
  if (sweep.set_start[0] != 0 || sweep.set_start[sweep.set_count] != sweep.order_count)
    refuse(fmt::format("set_start begins with {} and ends with {}, must begin with 0 and end with {}",
                       sweep.set_start[0], sweep.set_start[sweep.set_count], sweep.order_count));
  for (std::uint32_t set = 0; set < sweep.set_count; ++set) {
    const std::uint32_t begin = sweep.set_start[set], end = sweep.set_start[set + 1];
    if (begin > end || end > sweep.order_count)
      refuse(fmt::format("set_start[{}] is {} and set_start[{}] is {}: they must ascend to {}", set, begin, set + 1,
                         end, sweep.order_count));
    for (std::uint32_t i = begin; i < end; ++i) {
      if (i > begin && sweep.order[i] < sweep.order[i - 1])
        refuse(fmt::format("order[{}] is {}, less than the node before it in set {}", i, sweep.order[i], set));
      set_of_[sweep.order[i]] = set;
    }
  }
  const std::vector<std::uint32_t>&start = layout.neighbour_start(), &neighbours = layout.neighbours();
  for (std::uint32_t i = 0; i < sweep.order_count; ++i) {
    const std::uint32_t k = sweep.order[i], cluster = network.cluster[k];
    for (std::uint32_t at = start[k]; at < start[k + 1]; ++at) {
      const std::uint32_t other = neighbours[at];
      if (set_of_[other] != set_of_[k] || (cluster != no_cluster && network.cluster[other] == cluster)) continue;
      refuse(fmt::format("nodes {} and {} of set {} are joined", k, other, set_of_[k]));
    }
  }
}

}  // namespace springnet
