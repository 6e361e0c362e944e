// The node layer of a sweep: velocity and position neurons, and the record of forces.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <springnet/sdk/host.hpp>
#include <springnet/sdk/kernel.hpp>

namespace springnet::recurrent {

inline constexpr std::uint32_t no_node = 0xffffffffu;

// One component of the nodes of a batch.
struct Component {
  std::uint32_t instruction_set, count;
  double weight;  // s
  const double *acceleration, *position, *velocity;
  double *next_position, *next_velocity;
  bool* finite;  // cleared if a new position is not (which includes a velocity that is not)
};
struct Integration {
  // An exponent of all ones overflows into the sign bit: in integers, so that the loop vectorises.
  SPRINGNET_INLINE static void run(const Component& component) {
    constexpr std::uint64_t magnitude = ~std::uint64_t{0} >> 1, least_exponent = std::uint64_t{1} << 52;
    const double* __restrict a = component.acceleration;
    const double* __restrict p = component.position;
    const double* __restrict v = component.velocity;
    double* __restrict next_p = component.next_position;
    double* __restrict next_v = component.next_velocity;
    const double weight = component.weight;
    const std::size_t count = component.count;
    std::uint64_t top = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double u = v[i] + weight * a[i];
      const double next = p[i] + weight * u;
      next_v[i] = u;
      next_p[i] = next;
      top |= (std::bit_cast<std::uint64_t>(next) & magnitude) + least_exponent;
    }
    if ((top >> 63) != 0) *component.finite = false;
  }
};

// U' = v* + w a and P' = p* + w U' (v*, p* of the step; a from the net force at the newest outputs) for the nodes of
// batches.
class NodeUpdate {
 public:
  // `next` takes the new outputs. weight: w, s. relaxation: share of the way from the velocities in `next` to the new
  // ones; the effective mass of the update is that of the node over it.
  NodeUpdate(double weight, const springnet_const_vectors& free_position, const springnet_const_vectors& free_velocity,
             const springnet_state& next, double relaxation = 1.0) noexcept
      : weight_(weight),
        relaxation_(relaxation),
        position_(free_position),
        velocity_(free_velocity),
        next_position_(next.position),
        next_velocity_(next.velocity) {}

  // Returns whether all new outputs are finite.
  bool operator()(const springnet_node_batch& batch) const noexcept {
    const std::uint32_t k = batch.first;
    const std::uint32_t* list = batch.nodes;
    if (relaxation_ != 1.0) return relax(batch, list);
    if (list != nullptr) return step(batch, list);
    if (batch.count == 1) return step(k, batch);
    bool finite = true;
    const auto go = [&](const double* a, const double* p, const double* v, double* next_p, double* next_v) {
      const Component component{
          batch.instruction_set, batch.count, weight_, a, p + k, v + k, next_p + k, next_v + k, &finite};
      sdk::detail::run<Integration>(component);
    };
    go(batch.acceleration.x, position_.x, velocity_.x, next_position_.x, next_velocity_.x);
    go(batch.acceleration.y, position_.y, velocity_.y, next_position_.y, next_velocity_.y);
    go(batch.acceleration.z, position_.z, velocity_.z, next_position_.z, next_velocity_.z);
    return finite;
  }

 private:
  bool relax(const springnet_node_batch& batch, const std::uint32_t* list) const noexcept {
    bool finite = true;
    for (std::uint32_t i = 0; i < batch.count; ++i) {
      const std::uint32_t k = list != nullptr ? list[i] : batch.first + i;
      const auto go = [&](double a, double p, double v, double& next_p, double& next_u) {
        next_u += relaxation_ * (v + weight_ * a - next_u);
        next_p = p + weight_ * next_u;
        finite = finite && std::isfinite(next_p);
      };
      go(batch.acceleration.x[i], position_.x[k], velocity_.x[k], next_position_.x[k], next_velocity_.x[k]);
      go(batch.acceleration.y[i], position_.y[k], velocity_.y[k], next_position_.y[k], next_velocity_.y[k]);
      go(batch.acceleration.z[i], position_.z[k], velocity_.z[k], next_position_.z[k], next_velocity_.z[k]);
    }
    return finite;
  }

  // One node, in an order: the same without the loops' preparations.
  bool step(std::uint32_t k, const springnet_node_batch& batch) const noexcept {
    const double x = velocity_.x[k] + weight_ * *batch.acceleration.x;
    const double y = velocity_.y[k] + weight_ * *batch.acceleration.y;
    const double z = velocity_.z[k] + weight_ * *batch.acceleration.z;
    next_velocity_.x[k] = x;
    next_velocity_.y[k] = y;
    next_velocity_.z[k] = z;
    next_position_.x[k] = position_.x[k] + weight_ * x;
    next_position_.y[k] = position_.y[k] + weight_ * y;
    next_position_.z[k] = position_.z[k] + weight_ * z;
    return std::isfinite(next_position_.x[k]) && std::isfinite(next_position_.y[k]) &&
           std::isfinite(next_position_.z[k]);
  }
  bool step(const springnet_node_batch& batch, const std::uint32_t* list) const noexcept {
    double zero_if_finite = 0.0;  // vectors would gain nothing: places are any
    for (std::uint32_t i = 0; i < batch.count; ++i) {
      const std::uint32_t k = list[i];
      const double x = velocity_.x[k] + weight_ * batch.acceleration.x[i];
      const double y = velocity_.y[k] + weight_ * batch.acceleration.y[i];
      const double z = velocity_.z[k] + weight_ * batch.acceleration.z[i];
      const double px = position_.x[k] + weight_ * x;
      const double py = position_.y[k] + weight_ * y;
      const double pz = position_.z[k] + weight_ * z;
      next_velocity_.x[k] = x;
      next_velocity_.y[k] = y;
      next_velocity_.z[k] = z;
      next_position_.x[k] = px;
      next_position_.y[k] = py;
      next_position_.z[k] = pz;
      zero_if_finite += 0.0 * px + 0.0 * py + 0.0 * pz;
    }
    return zero_if_finite == 0.0;
  }
  double weight_;  // s
  double relaxation_;
  springnet_const_vectors position_, velocity_;
  springnet_vectors next_position_, next_velocity_;
};

// The node with the greatest magnitude; among equals the one with the lowest user's number. Infinity exceeds every
// finite magnitude, and nan counts as infinity.
struct Greatest {
  double square = 0.0;
  std::uint32_t node = no_node;

  void offer(double other_square, std::uint32_t other, const std::uint32_t* user_number) noexcept {
    if (other_square < square) return;
    if (std::isnan(other_square)) other_square = std::numeric_limits<double>::infinity();
    if (node == no_node || other_square > square ||
        (other_square == square && user_number[other] < user_number[node])) {
      square = other_square;
      node = other;
    }
  }
};

// The accelerating force m a of each node: for a mass point the net force; for other neurons it includes their own
// terms, such as drag. Comparing m a instead of the net force makes a neuron that feeds back its own velocity settle as
// well. Differences are recorded by unit, in separate memory, so that threads do not wait for each other and the result
// does not depend on their number.
class ForceRecord {
 public:
  struct Differences {
    double greatest = 0.0;              // N, over all nodes
    std::uint32_t node = no_node;       // where
    std::uint32_t free_node = no_node;  // where it is greatest among nodes that are neither fixed nor held
  };

  void resize(const springnet_network& network) {
    node_count_ = network.node_count;
    if (!x_.empty()) make_room();
    units_.resize(network.unit_count);
  }

  // Sets the forces that those of the first sweep are compared with. For fixed and held nodes, whose `acceleration` is
  // zero, the net force replaces m a.
  void begin(const springnet_network& network, const springnet_const_vectors& force,
             const springnet_const_vectors& acceleration) {
    make_room();
    for (std::uint32_t k = 0; k < network.node_count; ++k) {
      const bool is_pinned = network.fixed[k] != 0 || network.held[k] != 0;
      const double m = network.mass[k];
      x_[k] = is_pinned ? force.x[k] : m * acceleration.x[k];
      y_[k] = is_pinned ? force.y[k] : m * acceleration.y[k];
      z_[k] = is_pinned ? force.z[k] : m * acceleration.z[k];
    }
  }

  // Without forces to compare with: the first sweep then records the forces themselves.
  void begin() {
    make_room();
    for (auto* component : {&x_, &y_, &z_}) std::fill(component->begin(), component->end(), 0.0);
  }

  void begin_sweep() noexcept { std::fill(units_.begin(), units_.end(), Unit{}); }

  void take_finite(const springnet_node_batch& batch, bool finite) noexcept {
    if (!finite) units_[batch.unit].finite = false;
  }

  void take(const springnet_network& network, const springnet_node_batch& batch) noexcept {
    Unit& unit = units_[batch.unit];
    const std::uint32_t* list = batch.nodes;
    if (batch.count == 1 || list != nullptr) {
      for (std::uint32_t i = 0; i < batch.count; ++i) {
        const std::uint32_t k = list != nullptr ? list[i] : batch.first;
        const double m = network.mass[k];
        const double x = exchange(x_[k], m * batch.acceleration.x[i]);
        const double y = exchange(y_[k], m * batch.acceleration.y[i]);
        const double z = exchange(z_[k], m * batch.acceleration.z[i]);
        offer(unit, network, k, x * x + y * y + z * z);
      }
      return;
    }
    for (std::uint32_t begin = 0; begin < batch.count; begin += block) {
      const std::uint32_t count = std::min(block, batch.count - begin);
      const std::uint32_t first = batch.first + begin;
      double square[block];
      exchange(count, network.mass + first, batch.acceleration.x + begin, x_.data() + first, square, false);
      exchange(count, network.mass + first, batch.acceleration.y + begin, y_.data() + first, square, true);
      exchange(count, network.mass + first, batch.acceleration.z + begin, z_.data() + first, square, true);
      for (std::uint32_t i = 0; i < count; ++i) {
        offer(unit, network, first + i, square[i]);
      }
    }
  }

  // All nodes at once, for a sweep that evaluates them together; is_pinned: [node_count] 1: the net force replaces m a.
  void take_all(const springnet_network& network, const springnet_const_vectors& force,
                const springnet_const_vectors& acceleration, const std::vector<std::uint8_t>& is_pinned) noexcept {
    Unit& unit = units_[0];
    for (std::uint32_t k = 0; k < network.node_count; ++k) {
      const double m = network.mass[k];
      const bool all = is_pinned[k] != 0;
      const double x = exchange(x_[k], all ? force.x[k] : m * acceleration.x[k]);
      const double y = exchange(y_[k], all ? force.y[k] : m * acceleration.y[k]);
      const double z = exchange(z_[k], all ? force.z[k] : m * acceleration.z[k]);
      offer(unit, network, k, x * x + y * y + z * z);
    }
  }

  // Of the sweep just done.
  [[nodiscard]] bool finite() const noexcept {
    return std::all_of(units_.begin(), units_.end(), [](const Unit& unit) { return unit.finite; });
  }
  [[nodiscard]] Differences differences(const springnet_network& network) const noexcept {
    Greatest all, free;
    for (const Unit& unit : units_) {
      if (unit.all.node != no_node) all.offer(unit.all.square, unit.all.node, network.user_number);
      if (unit.free.node != no_node) free.offer(unit.free.square, unit.free.node, network.user_number);
    }
    return {std::sqrt(all.square), all.node, free.node};
  }

 private:
  static constexpr std::uint32_t block = 256;  // nodes, so that the squares stay in the first-level cache
  struct alignas(64) Unit {                    // a cache line each
    Greatest all, free;
    bool finite = true;
  };

  static void offer(Unit& unit, const springnet_network& network, std::uint32_t node, double square) noexcept {
    unit.all.offer(square, node, network.user_number);
    if (network.fixed[node] == 0 && network.held[node] == 0) unit.free.offer(square, node, network.user_number);
  }
  // Returns the difference.
  static double exchange(double& last, double now) noexcept {
    const double difference = now - last;
    last = now;
    return difference;
  }
  static void exchange(std::uint32_t count, const double* mass, const double* acceleration, double* last,
                       double* square, bool add) noexcept {
    for (std::uint32_t i = 0; i < count; ++i) {
      const double now = mass[i] * acceleration[i];
      const double difference = now - last[i];
      last[i] = now;
      square[i] = difference * difference + (add ? square[i] : 0.0);
    }
  }

  // Not before begin(): steps of one sweep compare nothing.
  void make_room() {
    for (auto* component : {&x_, &y_, &z_}) component->resize(node_count_);
  }

  std::size_t node_count_ = 0;
  std::vector<double> x_, y_, z_;  // N, [node_count], m a of the sweep before
  std::vector<Unit> units_;        // [unit_count]
};

}  // namespace springnet::recurrent
