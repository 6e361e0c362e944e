// The laws of a scene, with the parameters and references that its springs and elements have.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "check/geometry.hpp"

namespace springnet::check {

// A spring or element of a scene.
struct UsedElement {
  std::size_t parameters = 0;         // its set of these, in SceneLaw::parameters
  double reference = 1.0;             // of a law over one scalar; where that is 0 in the scene, the present value
  Corners rest;                       // of a law over several
  std::array<double, 3> direction{};  // of its material, 0: none
};

// A law as a scene uses it. Materials that differ in parameters alone share one, unless the law prepares tables.
struct SceneLaw {
  ComponentKind kind;
  LawUse use;                                   // of the first material
  std::vector<std::vector<double>> parameters;  // [set][parameter], distinct
  // Distinct ones, at least one if the law is used at all: the median by size, the smallest, the largest, then others.
  std::vector<UsedElement> elements;
};

// Laws of all materials, in their order. Throws Error(plugin) for a law that the host does not have.
[[nodiscard]] std::vector<SceneLaw> laws_of(const Network& network, const PluginHost& host);

}  // namespace springnet::check
