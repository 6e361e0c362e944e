// A run of the engine against the exact solution: the distance between them, and violations of contact at every step.
#pragma once

#include <algorithm>
#include <exception>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "../constraints/schemes.hpp"
#include "reference.hpp"

namespace springnet::testing {

// Where nodes are at even times, by the tests' own reference.
struct Truth {
  Truth(const Network& network, double duration, int count = 30) : net(network), until(duration), reference(network) {
    for (int i = 1; i <= count; ++i) {
      reference.advance_to(until * i / count);
      auto& at = positions.emplace_back();
      for (NodeIndex k = 0; k < net.nodes().size(); ++k) at.push_back(reference.position(k));
    }
  }
  Network net;
  double until;  // s
  Reference reference;
  std::vector<std::vector<Vector3>> positions;  // m, [time][node]
};

struct Run {
  double error = 0.0;          // m, greatest distance from the truth
  double pull = 0.0;           // N, the greatest pull of a surface on a node
  double sink = 0.0;           // m, the greatest depth of a node in an obstacle
  double stretch = 0.0;        // relative error of a rigid connection's length
  double impulse_error = 0.0;  // N s, of the sum of the impulses of touches
  std::size_t touched = 0, released = 0, slipped = 0, stuck = 0;
  double sweeps_per_step = 0.0;
  std::vector<std::vector<Vector3>> positions;  // m, at the times of the truth
  std::vector<Event> events;

  [[nodiscard]] double time_of(Event::Kind kind, std::size_t n = 0) const {
    for (const Event& event : events)
      if (event.kind == kind && n-- == 0) return event.time;
    return std::numeric_limits<double>::quiet_NaN();
  }
};

// Adds the present state's violations of the conditions of contact to a run.
inline void record_violations(const Network& net, const Reference& shapes, const Simulation& s, Run& run) {
  run.stretch = std::max(run.stretch, worst_length(net, s));
  for (NodeIndex k = 0; k < s.node_count(); ++k) {
    if (net.nodes()[k].fixed) continue;
    double nearest = std::numeric_limits<double>::infinity();
    Vector3 normal = Vector3::Zero();
    for (int j = 0; j < shapes.surface_count(); ++j) {
      const Reference::Gap gap = shapes.gap(j, s.time(), s.position(k), s.velocity(k));
      run.sink = std::max(run.sink, -gap.distance);
      if (std::abs(gap.distance) >= nearest) continue;
      nearest = std::abs(gap.distance);
      normal = gap.normal;
    }
    if (s.touching(k)) run.pull = std::max(run.pull, -normal.dot(s.reaction(k)));
  }
}

// Advance to a time or by a step; false and a failed check where that throws.
inline bool reaches(Simulation& s, double time) {
  try {
    s.advance_to(time);
    return true;
  } catch (const std::exception& error) {
    FAIL_CHECK(std::string(error.what()));
    return false;
  }
}
inline bool steps_on(Simulation& s) {
  try {
    s.step();
    return true;
  } catch (const std::exception& error) {
    FAIL_CHECK(std::string(error.what()));
    return false;
  }
}

inline double greatest_distance(const std::vector<std::vector<Vector3>>& a,
                                const std::vector<std::vector<Vector3>>& b) {
  double greatest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t k = 0; k < a[i].size(); ++k) greatest = std::max(greatest, (a[i][k] - b[i][k]).norm());
  return greatest;
}

inline Run follow(const Truth& truth, const LawUse& integrator, double time_step) {
  Run run;
  Simulation s = simulate(truth.net, integrator, time_step);
  const std::size_t count = truth.positions.size();
  for (std::size_t i = 1; i <= count; ++i) {
    const double next = truth.until * static_cast<double>(i) / static_cast<double>(count);
    while (s.time() < next) {
      if (s.time() + 1.000001 * time_step >= next)
        s.advance_to(next);
      else
        s.step();
      record_violations(truth.net, truth.reference, s, run);
    }
    auto& at = run.positions.emplace_back();
    for (NodeIndex k = 0; k < s.node_count(); ++k) at.push_back(s.position(k));
  }
  run.sweeps_per_step = static_cast<double>(s.sweeps()) / static_cast<double>(s.steps());
  run.error = greatest_distance(run.positions, truth.positions);
  for (NodeIndex k = 0; k < s.node_count(); ++k)
    run.impulse_error = std::max(run.impulse_error, (s.contact_impulse(k) - truth.reference.impulse(k)).norm());
  run.events = s.events();
  for (const Event& event : run.events) {
    run.touched += event.kind == Event::Kind::touched ? 1u : 0u;
    run.released += event.kind == Event::Kind::released ? 1u : 0u;
    run.slipped += event.kind == Event::Kind::slipped ? 1u : 0u;
    run.stuck += event.kind == Event::Kind::stuck ? 1u : 0u;
  }
  return run;
}

}  // namespace springnet::testing
