// Gravity and forces on nodes: the scene's, which switch at known times, and those of the embedding program.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/network.hpp>

#include "layers/evaluator.hpp"

namespace springnet {

class Loads {
 public:
  Loads(const Network& network, const std::vector<std::uint32_t>& engine_number);

  // Averages the scene's loads over [from, until], so that their impulse is exact whatever the step; until infinite or
  // not above from: as they are right after `from`. True if anything changed.
  bool set_interval(double from, double until);
  // The next time after `time` at which a load is switched; infinity if none.
  [[nodiscard]] double next_switch(double time) const noexcept;

  void set_host_force(std::uint32_t node, const Vector3& force);
  void set_gravity(const Vector3& acceleration) noexcept { gravity_ = acceleration; }
  [[nodiscard]] const Vector3& gravity() const noexcept { return gravity_; }
  // Valid until the next change.
  [[nodiscard]] layers::ExternalForces external() noexcept;
  // Greatest force of one load, N.
  [[nodiscard]] double greatest() const noexcept;

 private:
  struct Entry {
    std::vector<std::uint32_t> nodes;  // engine's
    Vector3 force;
    double from, until;
    double weight;
  };
  void gather();

  Vector3 gravity_;
  std::vector<Entry> entries_;
  std::vector<double> host_[3];   // empty: none set
  std::vector<double> total_[3];  // empty: no loads at all
  std::size_t node_count_;
};

}  // namespace springnet
