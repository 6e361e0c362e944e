// Whether a step that is reported as settled satisfies its equation of motion when it is evaluated again by other code:
//   m (U - v) / h = (1 - theta) m a_start + theta F(P, U, Z),
// with the forces and internal states of plain.hpp, and contact with a floor and rigid connections.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/simulation.hpp>

#include "nets.hpp"
#include "plain.hpp"

namespace springnet::testing {

inline PlainState state_of(const Simulation& simulation) {
  PlainState state;
  for (NodeIndex k = 0; k < simulation.node_count(); ++k) {
    state.position.push_back(simulation.position(k));
    state.velocity.push_back(simulation.velocity(k));
  }
  const auto first_of = [](const std::vector<double>& states) { return states.empty() ? 0.0 : states[0]; };
  for (SpringIndex s = 0; s < simulation.spring_count(); ++s)
    state.spring_memory.push_back(first_of(simulation.internal_states(s)));
  for (ElementIndex e = 0; e < simulation.element_count(); ++e)
    state.element_memory.push_back(first_of(simulation.element_internal_states(e)));
  return state;
}

inline std::vector<bool> live_elements(const Simulation& simulation) {
  std::vector<bool> alive;
  for (ElementIndex e = 0; e < simulation.element_count(); ++e) alive.push_back(simulation.element_alive(e));
  return alive;
}

inline std::vector<bool> live_springs(const Simulation& simulation) {
  std::vector<bool> alive;
  for (SpringIndex s = 0; s < simulation.spring_count(); ++s) alive.push_back(simulation.alive(s));
  return alive;
}

// The scale of forces that the tolerance is relative to, as the SDK defines it: greatest weight, load, net force at the
// start or m v^2 / l, N.
inline double force_scale(const Network& network) {
  PlainState start;
  double mean_length = 0.0;
  for (const Node& node : network.nodes()) {
    start.position.push_back(node.position);
    start.velocity.push_back(node.fixed ? Vector3(Vector3::Zero()) : node.velocity);
  }
  for (const Spring& spring : network.springs()) mean_length += spring.rest_length;
  mean_length /= static_cast<double>(network.springs().size());
  double scale = 0.0;
  for (const Vector3& force : plain_forces(network, start, std::vector<bool>(network.springs().size(), true),
                                           std::vector<bool>(network.elements().size(), true))) {
    scale = std::max(scale, force.norm());
  }
  for (const Load& load : network.loads()) scale = std::max(scale, load.force.norm());
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    const double mass = network.nodes()[k].mass;
    scale = std::max(scale, mass * std::max(network.gravity().norm(), start.velocity[k].squaredNorm() / mean_length));
  }
  return scale;
}

enum class Kind { free, prescribed, touching };

// For each node the lowest one that rigid connections join it to, directly or through others.
inline std::vector<NodeIndex> clusters_of(const Network& network) {
  std::vector<NodeIndex> lowest(network.nodes().size());
  std::iota(lowest.begin(), lowest.end(), NodeIndex{0});
  for (std::size_t round = 0; round < network.rigids().size(); ++round)
    for (const Rigid& rigid : network.rigids())
      lowest[rigid.first] = lowest[rigid.second] = std::min(lowest[rigid.first], lowest[rigid.second]);
  return lowest;
}

// The error of a step reported as settled: the greatest residual over its bound; above 1 the step is wrong.
class Judge {
 public:
  Judge(const Network& network, double tolerance, double time_step, double theta = 1.0)
      : network_(network), tolerance_(tolerance), time_step_(time_step), theta_(theta) {
    rigid_.resize(network.nodes().size());
    cluster_ = clusters_of(network);
    for (const Rigid& rigid : network.rigids()) rigid_[rigid.first] = rigid_[rigid.second] = true;
    for (const Move& move : network.moves()) moved_.insert(moved_.end(), move.nodes.begin(), move.nodes.end());
  }

  void begin(const Simulation& simulation) {
    start_ = state_of(simulation);
    alive_ = live_springs(simulation);
    elements_alive_ = live_elements(simulation);
    start_forces_ = plain_forces(network_, start_, alive_, elements_alive_);
    held_.resize(network_.nodes().size());
    touched_.resize(network_.nodes().size());
    for (NodeIndex k = 0; k < held_.size(); ++k) {
      held_[k] = simulation.held(k);
      touched_[k] = simulation.touching(k);
    }
    if (theta_ < 1.0) find_start_acceleration(simulation);
  }

  [[nodiscard]] double end(const Simulation& simulation) const {
    const double tolerance = reached(simulation);
    PlainState state = state_of(simulation);
    const PlainState within = within_step(simulation, state);
    double worst = memory(state, within);
    advance_memory(network_, start_, state, time_step_, theta_ < 1.0 ? 2 : 1);
    PlainState moved = within;
    advance_memory(network_, start_, moved, time_step_, theta_ < 1.0 ? 2 : 1);
    const std::vector<Vector3> forces = plain_forces(network_, moved, alive_, elements_alive_);
    std::vector<Vector3> residual(forces.size());
    std::vector<Kind> kinds;
    for (NodeIndex k = 0; k < forces.size(); ++k) {
      const Node& node = network_.nodes()[k];
      residual[k] = node.mass * (state.velocity[k] - start_.velocity[k]) / time_step_ - theta_ * forces[k];
      if (theta_ < 1.0) residual[k] -= (1.0 - theta_) * node.mass * start_acceleration_[k];
      kinds.push_back(is_prescribed(k) ? Kind::prescribed : simulation.touching(k) ? Kind::touching : Kind::free);
    }
    std::vector<bool> counts;
    for (const Kind kind : kinds) counts.push_back(kind == Kind::free);
    residual = without_tensions(network_, state, counts, residual);
    worst = std::max({worst, lengths(state), placing(simulation, state, kinds)});
    for (NodeIndex k = 0; k < residual.size(); ++k) {
      if (theta_ < 1.0 && !knows_start_[k]) continue;
      // The tensions found here minimise the sum of squares over the (at most three) connected nodes, not the greatest
      // residual.
      const double bound = (rigid_[k] ? std::sqrt(3.0) : 1.0) * 2.0 * tolerance + rounding(k, state);
      if (counts[k]) worst = std::max(worst, residual[k].norm() / bound);
      if (kinds[k] != Kind::touching || rigid_[k]) continue;
      worst = std::max(worst, against_floor(residual[k]) / bound);
      if (theta_ == 1.0) worst = std::max(worst, against_slip(simulation, k, residual[k], state) / bound);
      worst = std::max(worst, jump(k, state.position[k], forces[k]));
    }
    if (theta_ == 1.0) worst = std::max(worst, bodies_on_floor(state, forces, kinds));
    return std::max(worst, reported_contact(simulation, state, kinds));
  }

 private:
  // The outputs that springs read: a node that has reached the floor has the velocity that took it there, which the
  // end of the step then stops. A holding floor stops it within the step.
  [[nodiscard]] PlainState within_step(const Simulation& simulation, PlainState state) const {
    for (NodeIndex k = 0; k < state.velocity.size() && !network_.planes().empty(); ++k) {
      const bool arrives = simulation.touching(k) && !touched_[k] && !rigid_[k] && !is_prescribed(k);
      if (!arrives || network_.planes()[0].friction.kind == Friction::Kind::held) continue;
      const double way = state.position[k].z() - start_.position[k].z();
      state.velocity[k].z() = (way / time_step_ - (1.0 - theta_) * start_.velocity[k].z()) / theta_;
    }
    return state;
  }
  [[nodiscard]] bool is_prescribed(NodeIndex k) const {
    return network_.nodes()[k].fixed || std::find(moved_.begin(), moved_.end(), k) != moved_.end();
  }
  // Those of the constrained motion. Not known, here: of rigid bodies on the floor, and of a node that stands on it
  // with friction but is not held.
  void find_start_acceleration(const Simulation& simulation) {
    const std::size_t count = network_.nodes().size();
    start_acceleration_.assign(count, Vector3::Zero());
    knows_start_.assign(count, true);
    std::vector<bool> body_known(count, true);
    for (NodeIndex k = 0; k < count; ++k) {
      Vector3 force = start_forces_[k];
      if (is_prescribed(k)) {
        start_acceleration_[k] = displacement(k, simulation.time(), 2);
        continue;
      }
      if (simulation.touching(k)) {
        if (rigid_[k]) body_known[cluster_[k]] = false;
        const Friction& friction = network_.planes()[0].friction;
        const double speed = start_.velocity[k].head<2>().norm(), pressing = std::max(0.0, -force.z());
        if (friction.kind == Friction::Kind::coulomb && !held_[k]) {
          knows_start_[k] = speed > 1e-9;
          if (knows_start_[k])
            force.head<2>() -= friction.coefficient * pressing / speed * start_.velocity[k].head<2>();
        }
        force.z() = std::max(0.0, force.z());
        if (held_[k]) force.setZero();
      }
      start_acceleration_[k] = force / network_.nodes()[k].mass;
    }
    for (NodeIndex k = 0; k < count; ++k)
      if (rigid_[k] && !body_known[cluster_[k]]) knows_start_[k] = false;
    add_start_tensions();
  }
  // Tensions with which lengths keep their second derivative 0.
  void add_start_tensions() {
    const auto count = static_cast<Eigen::Index>(network_.rigids().size());
    if (count == 0) return;
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
    Eigen::VectorXd rhs(count);
    const auto direction = [&](const Rigid& rigid) {
      return Vector3((start_.position[rigid.first] - start_.position[rigid.second]).normalized());
    };
    const auto mobility = [&](NodeIndex k) { return is_prescribed(k) ? 0.0 : 1.0 / network_.nodes()[k].mass; };
    for (Eigen::Index i = 0; i < count; ++i) {
      const Rigid& one = network_.rigids()[static_cast<std::size_t>(i)];
      const Vector3 n = direction(one), speed = start_.velocity[one.first] - start_.velocity[one.second];
      const double along = n.dot(speed);
      rhs[i] = -n.dot(start_acceleration_[one.first] - start_acceleration_[one.second]) -
               (speed.squaredNorm() - along * along) / one.length;
      for (Eigen::Index j = 0; j < count; ++j) {
        const Rigid& other = network_.rigids()[static_cast<std::size_t>(j)];
        const auto part = [&](NodeIndex k, double sign) {
          const double own = (k == other.first ? 1.0 : 0.0) - (k == other.second ? 1.0 : 0.0);
          return sign * own * mobility(k) * n.dot(direction(other));
        };
        matrix(i, j) = part(one.first, 1.0) + part(one.second, -1.0);
      }
    }
    const Eigen::VectorXd tensions = matrix.completeOrthogonalDecomposition().solve(rhs);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Rigid& one = network_.rigids()[static_cast<std::size_t>(i)];
      start_acceleration_[one.first] += tensions[i] * mobility(one.first) * direction(one);
      start_acceleration_[one.second] -= tensions[i] * mobility(one.second) * direction(one);
    }
  }
  // Internal states at the end, which their laws determine from those at the start.
  [[nodiscard]] double memory(const PlainState& state, const PlainState& within) const {
    PlainState own = within;
    advance_memory(network_, start_, own, time_step_, theta_ < 1.0 ? 2 : 1);
    double worst = 0.0;
    const auto compare = [&](const std::vector<double>& found, const std::vector<double>& expected,
                             const std::vector<bool>& alive) {
      for (std::size_t i = 0; i < found.size(); ++i)  // lengths of about 1 m
        if (alive[i]) worst = std::max(worst, std::abs(found[i] - expected[i]) / (1e-12 * (1.0 + std::abs(found[i]))));
    };
    compare(state.spring_memory, own.spring_memory, alive_);
    compare(state.element_memory, own.element_memory, elements_alive_);
    return worst;
  }
  // The tolerance, or the rounding error of the forces if a note says that steps settle to that. It may not hide a
  // hundredth of the typical force.
  [[nodiscard]] double reached(const Simulation& simulation) const {
    const std::map<std::string, double>& known = simulation.statistics();
    const auto found = known.find("force_rounding");
    const bool counts = found != known.end() && found->second <= 1e4 * tolerance_;
    return counts ? std::max(tolerance_, found->second) : tolerance_;
  }
  // Rounding of m (U - v) / h, whose velocities are sums of larger terms.
  [[nodiscard]] double rounding(NodeIndex k, const PlainState& state) const {
    return 1e-13 * network_.nodes()[k].mass * (state.velocity[k].norm() + start_.velocity[k].norm()) / time_step_;
  }
  // Distance of the floor's force on a node from the admissible ones, N. Under the paper's rule a node that would touch
  // if it moved on, and move on if it touched, is held for the step: the force may then pull.
  [[nodiscard]] double against_floor(const Vector3& force) const {
    const Friction& friction = network_.planes()[0].friction;
    if (friction.kind == Friction::Kind::held) return 0.0;
    const double pull = std::max(0.0, -force.z()), along = force.head<2>().norm();
    return std::max(pull, along - friction.coefficient * std::max(0.0, force.z()));
  }
  // Distance of the friction on a node that slips from that which Coulomb's law says, N.
  [[nodiscard]] double against_slip(const Simulation& simulation, NodeIndex k, const Vector3& force,
                                    const PlainState& state) const {
    const Friction& friction = network_.planes()[0].friction;
    const Eigen::Vector2d slip = state.velocity[k].head<2>();
    constexpr double certain = 1e-6;  // m/s
    if (friction.kind != Friction::Kind::coulomb || simulation.held(k) || slip.norm() < certain) return 0.0;
    const double limit = friction.coefficient * std::max(0.0, force.z());
    return (force.head<2>() + limit * slip.normalized()).norm();
  }
  // The floor's force on a rigid body as a whole, in which tensions cancel: no pull, and friction within its cone.
  [[nodiscard]] double bodies_on_floor(const PlainState& state, const std::vector<Vector3>& forces,
                                       const std::vector<Kind>& kinds) const {
    double worst = 0.0;
    for (NodeIndex body = 0; body < kinds.size(); ++body) {
      if (cluster_[body] != body || !rigid_[body]) continue;
      Vector3 sum = Vector3::Zero();
      double bound = 0.0;
      bool touches = false, prescribed = false;
      for (NodeIndex k = body; k < kinds.size(); ++k) {
        if (cluster_[k] != body) continue;
        sum += network_.nodes()[k].mass * (state.velocity[k] - start_.velocity[k]) / time_step_ - forces[k];
        bound += 2.0 * tolerance_ + rounding(k, state);
        touches = touches || kinds[k] == Kind::touching;
        prescribed = prescribed || kinds[k] == Kind::prescribed;
      }
      if (touches && !prescribed) worst = std::max(worst, against_floor(sum) / bound);
    }
    return worst;
  }
  // Reported contact: held nodes rest on the floor, and stay where they were held; reactions balance the forces on a
  // node that is not accelerated downward, or not at all.
  [[nodiscard]] double reported_contact(const Simulation& simulation, const PlainState& state,
                                        const std::vector<Kind>& kinds) const {
    const std::vector<Vector3> forces =
        plain_forces(network_, state, live_springs(simulation), live_elements(simulation));
    double worst = 0.0;
    const auto take = [&](double wrong, const char* what, NodeIndex k) {
      if (!(wrong > 1.0)) return;
      worst = std::max(worst, wrong);
      INFO("node " << k << ": " << std::string(what) << " " << wrong);
      CHECK(wrong <= 1.0);
    };
    for (NodeIndex k = 0; k < kinds.size(); ++k) {
      if (kinds[k] != Kind::touching) continue;
      const double length = 1e-12 * (1.0 + state.position[k].norm()), force = 1e-9 * (tolerance_ / 1e-6);
      const Vector3 reaction = simulation.reaction(k);
      take(std::abs(state.position[k].z() - network_.planes()[0].point.z()) / length, "off the floor", k);
      take(-reaction.z() / force, "is pulled", k);
      if (simulation.held(k)) {
        take(state.velocity[k].norm() / 1e-12, "is held, but moves", k);
        if (held_[k]) take((state.position[k] - start_.position[k]).norm() / length, "was held, but was displaced", k);
      }
      if (rigid_[k]) continue;
      // The reported reaction is zero where the surface would have to pull.
      const double pressing = std::max(0.0, -forces[k].z());
      const double rounded = force + 1e-9 * forces[k].norm();
      take(std::abs(reaction.z() - pressing) / rounded, "normal reaction", k);
      const Friction& friction = network_.planes()[0].friction;
      const double max_friction = friction.coefficient * pressing, along = reaction.head<2>().norm();
      if (friction.kind == Friction::Kind::none) take(along / rounded, "friction without any", k);
      if (friction.kind == Friction::Kind::coulomb)
        take((along - max_friction) / rounded, "friction outside its cone", k);
      if (simulation.held(k) && pressing > 0.0 &&
          (friction.kind == Friction::Kind::held || along < 0.99 * max_friction))
        take((reaction + forces[k]).head<2>().norm() / rounded, "friction of a held node", k);
    }
    return worst;
  }
  // A node reached the floor by its velocity and the forces on it, not by spurious contact: its path over twice what
  // both explain.
  [[nodiscard]] double jump(NodeIndex k, const Vector3& position, const Vector3& force) const {
    const double acceleration = std::max(force.norm(), start_forces_[k].norm()) / network_.nodes()[k].mass;
    const double path = time_step_ * (start_.velocity[k].norm() + time_step_ * acceleration);
    return (position - start_.position[k]).norm() / (2.0 * path + 1e-12);
  }
  // Rigid connections keep their lengths to 1e-8.
  [[nodiscard]] double lengths(const PlainState& state) const {
    double worst = 0.0;
    for (const Rigid& rigid : network_.rigids()) {
      const double length = (state.position[rigid.first] - state.position[rigid.second]).norm();
      worst = std::max(worst, std::abs(length / rigid.length - 1.0) / 1e-8);
    }
    return worst;
  }
  // Fixed nodes stay in place, moved ones follow the sinusoid, no node is below the floor, and free nodes follow their
  // velocity.
  [[nodiscard]] double placing(const Simulation& simulation, const PlainState& state,
                               const std::vector<Kind>& kinds) const {
    double worst = 0.0;
    for (NodeIndex k = 0; k < kinds.size(); ++k) {
      const double scale = 1e-12 * (1.0 + state.position[k].norm());  // m, some roundings
      Vector3 off = Vector3::Zero();
      if (kinds[k] == Kind::prescribed) {
        off = state.position[k] - network_.nodes()[k].position - displacement(k, simulation.time());
      } else if (kinds[k] == Kind::free && network_.rigids().empty()) {
        off = state.position[k] - start_.position[k] -
              time_step_ * (theta_ * state.velocity[k] + (1.0 - theta_) * start_.velocity[k]);
      }
      worst = std::max(worst, off.norm() / scale);
      if (network_.planes().empty() || kinds[k] == Kind::prescribed) continue;
      worst = std::max(worst, (network_.planes()[0].point.z() - state.position[k].z()) / scale);
    }
    return worst;
  }
  // Or its second derivative.
  [[nodiscard]] Vector3 displacement(NodeIndex k, double time, int derivative = 0) const {
    if (std::find(moved_.begin(), moved_.end(), k) == moved_.end()) return Vector3::Zero();
    const Motion& motion = network_.moves()[0].motion;
    const double w = 2.0 * std::numbers::pi * motion.frequency;
    return motion.amplitude * std::sin(w * time) * (derivative == 2 ? -w * w : 1.0);
  }

  const Network& network_;
  double tolerance_, time_step_, theta_;
  std::vector<NodeIndex> moved_;
  PlainState start_;
  std::vector<Vector3> start_forces_;
  std::vector<Vector3> start_acceleration_;  // theta below 1
  std::vector<bool> alive_, elements_alive_, rigid_, held_, touched_, knows_start_;
  std::vector<NodeIndex> cluster_;
};

// Some steps, each judged. True if all of them settled.
inline bool settles(const Network& network, const SimulationOptions& options, double tolerance, int steps,
                    Eigen::MatrixXd* course = nullptr) {
  Simulation simulation(network, plugins(), options);
  const auto theta = options.integrator.parameters.find("theta");
  Judge judge(network, tolerance, options.time_step,
              theta == options.integrator.parameters.end() ? 1.0 : theta->second);
  bool settled = true;
  for (int step = 0; step < steps && settled; ++step) {
    CAPTURE(step);
    judge.begin(simulation);
    try {
      settled = simulation.step().outcome == Outcome::settled;
      if (settled) CHECK(judge.end(simulation) <= 1.0);
    } catch (const Error& error) {
      settled = false;
      CHECK(error.kind() == ErrorKind::simulation);
    }
  }
  if (course != nullptr) {
    course->resize(6, simulation.positions().cols());
    *course << simulation.positions(), simulation.velocities();
  }
  return settled;
}

}  // namespace springnet::testing
