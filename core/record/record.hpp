// The state that outputs record. Each quantity is computed on first use, once per record, and shared by tables,
// pictures, page and summary.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

namespace springnet {

class Record {
 public:
  using Vectors = Eigen::Matrix3Xd;  // a column per node, by the user's numbers

  // The load of nodes on a plane or an instrument.
  struct SurfaceLoad {
    Vector3 force;      // N
    std::size_t nodes;  // in contact with it
  };

  explicit Record(const Network& network);

  // Refers to the present state of a simulation of that network, until the next call. Quantities are computed on first
  // use, so the simulation must not be advanced or changed in between.
  void take(const Simulation& simulation);

  // For quantities that the simulation itself stores.
  [[nodiscard]] const Simulation& simulation() const noexcept { return *simulation_; }
  [[nodiscard]] double time() const noexcept { return simulation_->time(); }  // s

  [[nodiscard]] const Vectors& positions() const;   // m
  [[nodiscard]] const Vectors& velocities() const;  // m/s
  [[nodiscard]] const Vectors& forces() const;      // N, as Simulation::forces(), and throws as that does

  // By the user's number of the spring, removed ones included; tensions and energies as those of Simulation.
  [[nodiscard]] const std::vector<double>& lengths() const;   // m, distance of the ends
  [[nodiscard]] const std::vector<double>& tensions() const;  // N
  [[nodiscard]] const std::vector<double>& energies() const;  // J

  [[nodiscard]] double element_value(ElementIndex element) const;  // in the unit of its invariant

  [[nodiscard]] const std::vector<SurfaceLoad>& surface_loads() const;  // planes, then instruments

  [[nodiscard]] double kinetic_energy() const;    // J
  [[nodiscard]] double potential_energy() const;  // J

 private:
  // Keeps its memory from record to record.
  template <class Value>
  struct Once {
    Value value{};
    bool known = false;
  };
  template <class Value, class Compute>
  static const Value& once(Once<Value>& quantity, const Compute& compute) {
    if (!quantity.known) compute(quantity.value);
    quantity.known = true;
    return quantity.value;
  }
  void by_user(const ConstNodeMap& from, Vectors& to) const;

  const std::vector<SpringList::Ends>& springs_;
  const Simulation* simulation_ = nullptr;
  mutable Once<Vectors> positions_, velocities_, forces_;
  mutable Once<std::vector<double>> lengths_, tensions_, energies_;
  mutable Once<std::vector<std::optional<double>>> elements_;
  mutable Once<std::vector<SurfaceLoad>> surface_loads_;
  mutable Once<double> kinetic_, potential_;
};

}  // namespace springnet
