// The values that a trajectory is differentiated by: set in a simulation, and as sets of the host's products.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <springnet/motion_derivatives.hpp>
#include <springnet/sdk/host.hpp>

#include "simulation/engine.hpp"

namespace springnet::learning {

class LearnedSets {
 public:
  // Throws Error(input) for members that the network does not have, or that are listed twice; attach(): for laws and
  // neurons without the parameter.
  LearnedSets(const Network& network, std::vector<LearnedValues> learned);
  void attach(Engine& engine);

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] Eigen::VectorXd values_of(const Engine& engine) const;
  // Throws Error(input) if the number of values is another one, or one is not finite.
  void check(const Eigen::VectorXd& values) const;
  // At the start. Throws Error(input) for values that laws, neurons or masses cannot have.
  void set(Simulation& simulation, const Eigen::VectorXd& values) const;
  // Of a motion on its way, whose start is over.
  void set_without_start(Simulation& simulation, const Eigen::VectorXd& values) const;
  void set(Engine& engine, const Eigen::VectorXd& values) const;

  // A change of the network has been made, after those before: what it sets no longer depends on what is learned, and
  // what it scales does so by its factor. Of the tangents, cotangents and settings to come, until it is undone: the
  // last one first.
  void follow_change(const Change& change);
  void undo_change();

  // A change of the values as sets of the host; `values` holds those of the sets.
  [[nodiscard]] std::vector<springnet_parameter_set> sets_along(const Eigen::VectorXd& change,
                                                                std::vector<std::vector<double>>& values) const;
  // Changes of accelerations, [3 node], for those of the values: a column for each. internal(j): where those of
  // internal states at the end of a step are written for column j; null: not wanted.
  void tangents(Engine& engine, const sdk::Host& host, const springnet_evaluation& at, const Eigen::MatrixXd& changes,
                Eigen::MatrixXd& accelerations, const std::function<double*(Eigen::Index)>& internal = nullptr);
  // Adds (da/d(values))^T weights, to zeros at first; of internal states likewise. The host has been linearised there.
  void begin_cotangent();
  void add_cotangent(Engine& engine, const sdk::Host& host, const springnet_evaluation& at, double* weights,
                     double* internal_weights = nullptr);
  // Derivatives by the values of the value of an event; of springs and elements that may break. See
  // sdk::Host::event_derivative for the others.
  [[nodiscard]] Eigen::VectorXd event_gradient(const sdk::Host& host, const springnet_evaluation& at,
                                               std::uint32_t event, double* by_position, double* by_velocity,
                                               double& by_time);
  // Adds derivatives by the values, but for start velocities, to the sums.
  void add_gradient(const Eigen::VectorXd& by_values);
  // The sums, with derivatives by the start velocities (the engine's order, x of all nodes first).
  [[nodiscard]] Eigen::VectorXd cotangent(const Eigen::VectorXd& by_velocity) const;
  // Of masses, [node] kg; and adds derivatives by masses ([node]) to the sums.
  [[nodiscard]] Eigen::VectorXd mass_changes(const Eigen::VectorXd& change, std::size_t nodes) const;
  void add_to_masses(const Eigen::VectorXd& by_mass);
  // The same of coefficients of friction, [surface].
  [[nodiscard]] Eigen::VectorXd friction_changes(const Eigen::VectorXd& change) const;
  void add_to_friction(const Eigen::VectorXd& by_friction);
  // Derivatives by the values of what has this one by a surface's friction.
  [[nodiscard]] Eigen::VectorXd friction_gradient(std::int32_t surface, double by_friction) const;
  // The same by masses, [node].
  [[nodiscard]] Eigen::VectorXd mass_gradient(const Eigen::VectorXd& by_mass) const;
  [[nodiscard]] bool has_friction() const noexcept;
  [[nodiscard]] bool has_friction_of(std::int32_t surface) const noexcept;
  [[nodiscard]] Eigen::Index surface_count() const noexcept { return static_cast<Eigen::Index>(frictions_.size()); }
  // The user's numbers of nodes.
  [[nodiscard]] std::vector<std::uint32_t> with_start_velocities() const;
  // Adds the change of start velocities.
  void start_velocity(const Eigen::VectorXd& change, Eigen::VectorXd& velocities) const;

 private:
  // One LearnedValues; `values` has a number for each spring, element, node, load, axis or surface, or none for start
  // velocities.
  struct Set {
    LearnedValues what;
    std::size_t first = 0;              // of its values
    std::vector<std::uint32_t> places;  // [member] in `values`; of start velocities: the engine's nodes
    std::vector<double> values;
    std::vector<double> factors;  // [member] of what is learned, by changes of the network; empty: 1
    std::vector<double> sums;     // [member] of cotangents with other factors; empty: none
    struct Factor {
      std::size_t member;
      double before;
    };
    std::vector<std::vector<Factor>> replaced;                     // [change made] factors before it
    std::vector<std::pair<std::uint32_t, std::size_t>> places_of;  // numbers of members with their places in the list
    [[nodiscard]] double factor(std::size_t member) const { return factors.empty() ? 1.0 : factors[member]; }
    [[nodiscard]] double sum(std::size_t member) const {
      return (sums.empty() ? 0.0 : sums[member]) + factor(member) * values[places[member]];
    }
    [[nodiscard]] bool is_velocity() const noexcept { return what.kind == LearnedValues::Kind::initial_velocity; }
    // Of the surroundings: the host has no derivatives by it.
    [[nodiscard]] bool is_of_surroundings() const noexcept {
      return what.kind == LearnedValues::Kind::load || what.kind == LearnedValues::Kind::gravity || is_friction();
    }
    [[nodiscard]] bool is_friction() const noexcept { return what.kind == LearnedValues::Kind::friction; }
    [[nodiscard]] std::size_t size() const noexcept { return (is_velocity() ? 3 : 1) * what.members.size(); }
  };
  // What has been summed so far of this member is by its present factor.
  static void set_factor(Set& set, std::size_t member, double factor);
  template <class Target>
  void set_laws_and_masses(const Target& target, const Eigen::VectorXd& values) const;
  [[nodiscard]] std::vector<double> values_of(const Set& set, const Eigen::VectorXd& values) const;
  // The set without what the network's changes have set.
  [[nodiscard]] std::pair<LearnedValues, std::vector<double>> present(const Set& set,
                                                                      const Eigen::VectorXd& values) const;
  [[nodiscard]] std::vector<sdk::Host::ParameterSet> host_sets();
  // Changes of accelerations for one of a load's factor, of a component of gravity, or of friction.
  [[nodiscard]] static Eigen::VectorXd by_surroundings(Engine& engine, const sdk::Host& host,
                                                       const springnet_evaluation& at, const Set& set,
                                                       std::uint32_t place);

  Vector3 gravity_;                // of the network
  std::vector<double> frictions_;  // [surface], likewise
  std::vector<Set> sets_;
  std::size_t count_ = 0;
  std::vector<double> force_weights_;  // [3 node]
};

}  // namespace springnet::learning
