// Sweeps in an order, through the host's table: one node after another, several at a time, and by lists in whatever
// order gives the same outputs. All of them have the same bits.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/sdk/host.hpp>

#include "../elements/bodies.hpp"
#include "generator.hpp"
#include "nets.hpp"
#include "simulation/engine.hpp"
#include "simulation/host_table.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

using Order = std::vector<std::uint32_t>;

// How the host calls the update of a sweep in an order.
enum class Calls { by_themselves, one_by_one, by_lists };

constexpr double time_step = 1e-5;  // s; some of the random nets are stiffer, and diverge

// Explicit sweeps of one step: U = v + h a, P = p + h U for each node.
class Sweeper {
 public:
  explicit Sweeper(const Network& net, Calls calls)
      : engine_(net, *plugins(), options()), table_(make_host_table(engine_)), host_(table_), calls_(calls) {
    host_.begin_step(0.0, time_step);
    const springnet_state& start = host_.committed().state;
    const std::size_t n = size();
    for (std::vector<double>* part : {&outputs, &forces, &reactions}) part->assign((part == &outputs ? 6 : 3) * n, 0.0);
    const double* const from[6] = {start.position.x, start.position.y, start.position.z,
                                   start.velocity.x, start.velocity.y, start.velocity.z};
    for (std::size_t c = 0; c < 6; ++c) std::copy_n(from[c], n, outputs.begin() + static_cast<std::ptrdiff_t>(c * n));
  }

  [[nodiscard]] std::size_t size() const { return engine_.model().node_count(); }
  [[nodiscard]] Engine& engine() { return engine_; }

  void sweep(const Order& order) {
    const springnet_state& start = host_.committed().state;
    const std::size_t n = size();
    auto call = sdk::sized<springnet_sweep>();
    call.time = call.time_constant = time_step;
    call.order = order.data();
    call.order_count = static_cast<std::uint32_t>(order.size());
    call.start_position = sdk::view(start.position);
    call.start_velocity = sdk::view(start.velocity);
    call.next_position = part(outputs, 0);
    call.next_velocity = part(outputs, 3);
    call.position = sdk::view(call.next_position);
    call.velocity = sdk::view(call.next_velocity);
    call.force = part(forces, 0);
    call.constraint_force = part(reactions, 0);
    call.want_blocks = calls_ == Calls::by_themselves ? 1 : 0;
    call.lists = calls_ == Calls::by_lists ? 1 : 0;
    const double* const p[3] = {start.position.x, start.position.y, start.position.z};
    const double* const v[3] = {start.velocity.x, start.velocity.y, start.velocity.z};
    most_at_once = 0;
    host_.sweep(call, [&](const springnet_node_batch& batch) {
      const double* const a[3] = {batch.acceleration.x, batch.acceleration.y, batch.acceleration.z};
      most_at_once = std::max(most_at_once, batch.count);
      for (std::uint32_t i = 0; i < batch.count; ++i) {
        const std::uint32_t k = batch.nodes != nullptr ? batch.nodes[i] : batch.first + i;
        for (std::size_t c = 0; c < 3; ++c) {
          const double u = v[c][k] + time_step * a[c][i];
          outputs[(3 + c) * n + k] = u;
          outputs[c * n + k] = p[c][k] + time_step * u;
        }
      }
    });
  }

  std::vector<double> outputs, forces, reactions;  // [component][node]: m and m/s; N; N
  std::uint32_t most_at_once = 0;                  // nodes of a batch of the last sweep

 private:
  springnet_vectors part(std::vector<double>& values, std::size_t first) const {
    double* begin = values.data() + first * size();
    return {begin, begin + size(), begin + 2 * size()};
  }

  static SimulationOptions options() {
    SimulationOptions result;
    result.time_step = time_step;
    result.threads = 1;
    return result;
  }

  Engine engine_;
  springnet_host table_;
  sdk::Host host_;
  Calls calls_;
};

Order shuffled(std::size_t size, std::mt19937& random) {
  Order order(size);
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), random);
  return order;
}

// Every kind of element, an enclosure, rods, a fixed node, and a plane just below the lowest of the nodes that neither
// have rods nor lie on the enclosure.
Network everything(unsigned seed) {
  Network net = all_kinds(seed);
  net.fix(2);
  net.add_rigid(0, 9);
  net.add_rigid(9, 12);
  NodeIndex lowest = 3;
  for (const NodeIndex k : {1u, 4u, 5u, 6u, 7u, 8u, 10u, 11u, 13u})
    if (net.nodes()[k].position.z() < net.nodes()[lowest].position.z()) lowest = k;
  const Vector3 point = net.nodes()[lowest].position;
  // A small one beside the node: the others may be below it.
  Instrument table;
  table.first = table.second = point - Vector3(0.0, 0.0, 1e-3 + 1e-9);
  table.radius = 1e-3;
  net.add_instrument(table);
  net.set_gravity({0.0, 0.0, -1e5});
  return net;
}

bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

// The reason why a sweep failed; empty if it did not.
std::string failure_of(Sweeper& sweeper, const Order& order) {
  try {
    sweeper.sweep(order);
    return {};
  } catch (const sdk::Failure& failure) {
    return failure.what();
  }
}

// Orders that come again at once, later, and never. Returns whether a surface exerted a force.
bool check_all(const Network& net, unsigned seed) {
  Sweeper alone(net, Calls::by_themselves), one(net, Calls::one_by_one), lists(net, Calls::by_lists);
  std::mt19937 random(seed);
  const Order first = shuffled(alone.size(), random), second = shuffled(alone.size(), random);
  for (const Order& order : {first, first, second, first, second, second, shuffled(alone.size(), random), second}) {
    const std::string failure = failure_of(one, order);
    for (Sweeper* other : {&alone, &lists}) {
      CHECK(failure_of(*other, order) == failure);
      if (!failure.empty()) continue;
      CHECK(same(other->outputs, one.outputs));
      CHECK(same(other->forces, one.forces));
      CHECK(same(other->reactions, one.reactions));
    }
    if (!failure.empty()) break;
  }
  return std::any_of(one.reactions.begin(), one.reactions.end(), [](double force) { return force != 0.0; });
}

}  // namespace

TEST_CASE("a sweep by lists has the bits of one that updates one node after another") {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    CAPTURE(seed);
    CHECK(check_all(everything(seed), seed));
  }
  int touching = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    CAPTURE(seed);
    const Network net = RandomNet(seed).network;
    touching += check_all(net, static_cast<unsigned>(seed)) ? 1 : 0;
  }
  CHECK(touching > 5);
}

TEST_CASE("an order is swept in few batches, and after a cut by the springs that are left") {
  const Network net = testing::cube(3.0, 2.0, 0.2, 0.081);
  Sweeper one(net, Calls::one_by_one), lists(net, Calls::by_lists);
  Order order(one.size());
  std::iota(order.begin(), order.end(), 0u);
  for (int sweep = 0; sweep < 3; ++sweep) {
    one.sweep(order);
    lists.sweep(order);
    CHECK(one.most_at_once == 1);
    CHECK(lists.most_at_once > 4);
  }
  for (Sweeper* sweeper : {&one, &lists}) {
    REQUIRE(sweeper->engine().topology().cut(std::vector<std::uint32_t>{0, 7, 100}) == 3);
    sweeper->sweep(order);
    sweeper->sweep(order);
    sweeper->sweep(order);
  }
  CHECK(lists.outputs == one.outputs);
  CHECK(lists.forces == one.forces);
}
