// Rigid bodies in contact: the reference goes on, keeps lengths and surfaces, gains no energy, and finds the same
// motion at every tolerance.
#pragma once

#include <algorithm>
#include <cmath>
#include <exception>
#include <string>
#include <vector>

#include "run.hpp"

namespace springnet::testing {

struct Fate {
  Run run;
  double gained = 0.0;  // J, the most that energy grew from its lowest value
  double scale = 0.0;   // J
};

inline Fate tumble(const Network& net, double tolerance, double until) {
  constexpr int count = 60;
  const Reference shapes = surfaces_of(net);
  Simulation s = simulate(net, cvode(tolerance, {{"max_steps", 3000}}), until / count);
  const auto energy = [&] { return s.kinetic_energy() + s.potential_energy(); };
  Fate fate;
  double lowest = energy();
  for (int i = 1; i <= count; ++i) {
    s.advance_to(until * i / count);
    record_violations(net, shapes, s, fate.run);
    auto& at = fate.run.positions.emplace_back();
    for (NodeIndex k = 0; k < s.node_count(); ++k) at.push_back(s.position(k));
    fate.scale = std::max({fate.scale, s.kinetic_energy(), std::abs(energy())});
    fate.gained = std::max(fate.gained, energy() - lowest);
    lowest = std::min(lowest, energy());
  }
  fate.run.events = s.events();
  return fate;
}

inline void check_fate(const Network& net, double until) {
  std::vector<Fate> fates;
  for (const double tolerance : {1e-7, 1e-9}) {
    CAPTURE(tolerance);
    try {
      fates.push_back(tumble(net, tolerance, until));
    } catch (const std::exception& error) {
      FAIL_CHECK(std::string(error.what()));
      return;
    }
    const Fate& fate = fates.back();
    CHECK(fate.gained <= 1e3 * tolerance * fate.scale);  // a thousand steps
    CHECK(fate.run.stretch <= 1.001e-8);
    // A node that was just let go is where integration puts it, and a step may err in one of its components by as much
    // as in all together: the root of their number, positions and velocities, times the tolerance (of 1 m at most).
    const double step = std::sqrt(6.0 * static_cast<double>(net.nodes().size())) * tolerance;
    CHECK(fate.run.sink <= std::max(1e-7, step));
    CHECK(fate.run.pull <= 1e-6);
    CHECK(fate.run.events.size() <= 200);
  }
  // A touch makes errors grow; a body that goes another way is off by centimetres.
  CHECK(greatest_distance(fates[0].run.positions, fates[1].run.positions) <= 1e-3);
}

}  // namespace springnet::testing
