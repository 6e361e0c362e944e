// A block with a stiff inclusion that is seen from outside: motions of its surface under three loads, with noise.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "learning_nets.hpp"

namespace springnet::testing {

struct Inclusion {
  std::vector<Experiment> experiments;  // whose networks do not know of it
  std::vector<bool> is_stiff;           // [spring]
  double deviation = 0.0;               // of the noise, m
};

struct InclusionOptions {
  std::uint32_t nodes = 10;  // a side, at distances of 1 m
  double contrast = 5.0;
  double noise = 0.01;  // of the rms displacement of the surface
  double duration = 3.0, step = 0.05;
  int every = 1;  // steps between observations
  std::uint64_t seed = 1;
};

inline constexpr double stiffness_around = 20.0;  // N/m, with masses of 1 kg

inline Network block_of(const InclusionOptions& options) {
  Network net;
  Lattice lattice;
  lattice.nodes = {options.nodes, options.nodes, options.nodes};
  lattice.diagonals = Diagonals::space;
  net.add_lattice("block", lattice, Node{}, net.add_material(damped(stiffness_around, 0.1)));
  for (NodeIndex k = 0; k < options.nodes * options.nodes; ++k) net.fix(k);  // it stands
  return net;
}

// A pulse on a part of a face. axis: of the face; the force pushes inwards, or across.
inline Load pulse_on(const Network& net, std::uint32_t nodes, int axis, const Vector3& force) {
  Load load;
  const double far = nodes - 1.0;
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    const Vector3& p = net.nodes()[k].position;
    if (p[axis] < far - 0.5 || net.nodes()[k].fixed) continue;
    if (p[(axis + 1) % 3] > 0.6 * far) continue;  // not symmetric
    load.nodes.push_back(k);
  }
  load.force = force;
  load.course.times = {0.0, 0.2, 0.4};
  load.course.factors = {0.0, 1.0, 0.0};
  return load;
}

inline Inclusion inclusion(const InclusionOptions& options) {
  const Network plain = block_of(options);
  Inclusion result;
  // The cell in the middle, or next to it.
  const double far = options.nodes - 1.0, half = 0.5 * (1.0 + 0.125);
  const Vector3 middle = Vector3::Constant(std::floor(0.5 * far) + 0.5);
  std::vector<double> stiffness;
  for (const Spring& each : plain.springs()) {
    const Vector3 at = 0.5 * (plain.nodes()[each.first].position + plain.nodes()[each.second].position);
    result.is_stiff.push_back((at - middle).cwiseAbs().maxCoeff() <= half);
    stiffness.push_back(stiffness_around * (result.is_stiff.back() ? options.contrast : 1.0));
  }
  std::vector<NodeIndex> surface;
  for (NodeIndex k = 0; k < plain.nodes().size(); ++k) {
    const Vector3& p = plain.nodes()[k].position;
    if (!plain.nodes()[k].fixed && (p.minCoeff() < 0.5 || p.maxCoeff() > far - 0.5)) surface.push_back(k);
  }
  const SimulationOptions with = to_learn_with(0.5, options.step);
  const Load loads[] = {pulse_on(plain, options.nodes, 2, {0, 0, -20}), pulse_on(plain, options.nodes, 2, {20, 0, 0}),
                        pulse_on(plain, options.nodes, 0, {-20, 0, 0})};
  double square = 0.0;
  for (const Load& load : loads) {
    Network net = plain;
    net.add_load(load);
    Simulation real(net, plugins(), with);
    real.set_parameter(from_to(0, plain.springs().size()), ComponentKind::spring_function, "stiffness", stiffness);
    Observations seen;
    const int steps = static_cast<int>(std::lround(options.duration / options.step));
    for (int k = 1; k <= steps; ++k) {
      real.step();
      if (k % options.every != 0) continue;
      for (const NodeIndex node : surface) {
        seen.positions.push_back(row(real.time(), node, real.position(node)));
        square += (real.position(node) - plain.nodes()[node].position).squaredNorm();
      }
    }
    result.experiments.push_back(experiment(net, with, std::move(seen)));
  }
  std::size_t values = 0;
  for (const Experiment& each : result.experiments) values += 3 * each.observations.positions.size();
  result.deviation = options.noise * std::sqrt(square / static_cast<double>(values));
  Dice dice(options.seed);
  for (Experiment& each : result.experiments)
    for (Observations::VectorRow& seen : each.observations.positions) {
      seen.value += result.deviation * normal(dice);
      seen.weight = Vector3::Constant(1.0 / (result.deviation * result.deviation));
    }
  return result;
}

// Of the springs that are found to be stiffer than the geometric mean of inside and outside.
inline double dice_of(const Inclusion& real, const std::vector<LearnedParameter>& learned, double contrast) {
  std::size_t both = 0, either = 0;
  for (const LearnedParameter& each : learned) {
    const bool found = each.value > stiffness_around * std::sqrt(contrast), is = real.is_stiff[each.member];
    both += found && is ? 1 : 0;
    either += (found ? 1u : 0u) + (is ? 1u : 0u);
  }
  return 2.0 * static_cast<double>(both) / static_cast<double>(either);
}

}  // namespace springnet::testing
