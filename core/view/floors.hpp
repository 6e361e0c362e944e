// Rounding levels: a page shows 0 for values below them.
#pragma once

#include <vector>

#include <springnet/plugin_host.hpp>
#include <springnet/scene.hpp>

#include "view/frames.hpp"
#include "view/selection.hpp"

namespace springnet::view {

// Each is a few rounding errors of the largest number that enters the value.
struct Floors {
  double position = 0.0;       // m: of the largest coordinate at the start
  double speed = 0.0;          // m/s: that rounding of position within a record
  double kinetic = 0.0;        // J: of all nodes at that speed
  double potential = 0.0;      // J: of the springs' energies at their floors, and of gravity's terms
  std::vector<float> tension;  // N, of each shown spring: its stiffness at rest times the rounding of its length
};

// The floors of tensions are 0 without plugins, and for laws without derivatives.
[[nodiscard]] Floors floors_of(const Scene& scene, const Selection& selection, const PluginHost* plugins);

// Sets values to 0 that are at or below their floor, or within rounding of the largest of their kind in the same frame.
void drop_rounding(const Floors& floors, Frames& frames);

}  // namespace springnet::view
