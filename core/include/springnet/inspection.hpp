// What a network is made of, before it moves: counts, ranges, parts, and how large a time step may be.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

namespace springnet {

struct Range {
  double smallest;
  double largest;
};

struct Inspection {
  std::size_t nodes = 0, springs = 0, bodies = 0, fixed_nodes = 0, planes = 0, loads = 0, cuts = 0;
  std::map<std::string, std::size_t> spring_functions;     // springs by id; "none": viscous connections
  std::map<std::string, std::size_t> viscosity_functions;  // springs by id; "none": undamped springs
  std::map<std::string, std::size_t> neurons;              // nodes by id

  double total_mass = 0.0;             // kg
  std::optional<Range> mass;           // kg, one node
  std::optional<Range> length;         // m, at the start
  std::optional<Range> rest_length;    // m
  std::optional<Range> stiffness;      // N/m: dQ/dq at the start, of laws that have derivatives
  std::optional<Range> damping;        // N s/m at rest, likewise
  std::size_t springs_under_load = 0;  // length differs from rest length by more than 1e-9 of it
  Vector3 lower = Vector3::Zero();     // m, corners of the box around all nodes
  Vector3 upper = Vector3::Zero();

  std::size_t parts = 0;                  // sets of nodes that springs connect
  std::size_t nodes_without_springs = 0;  // each is a part
  double memory_bytes = 0.0;              // about what a run in the recurrent integrator takes in all

  // s: above about this time step the synchronous update rule does not settle, below it does: where the spectral radius
  // of t^2 M^-1 K + t M^-1 D, linearised at the start, reaches 1. Empty if there is no such limit, or if a law or
  // neuron cannot be linearised.
  std::optional<double> synchronous_time_constant;
};

// Throws Error(plugin) for a component that `plugins` does not have, Error(input) for parameters it does not take.
[[nodiscard]] Inspection inspect(const Network& network, const PluginHost& plugins);

// As JSON.
[[nodiscard]] std::string to_json(const Inspection& inspection);

}  // namespace springnet
