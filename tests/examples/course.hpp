// A scene of examples/, and its course.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <springnet/scene.hpp>

#include "nets.hpp"

namespace springnet::testing {

inline Scene example(const std::string& file, const std::vector<std::string>& overrides = {}) {
  std::vector<SceneOverride> parsed;
  for (const std::string& text : overrides) parsed.push_back(parse_override(text));
  return load_scene(std::filesystem::path(EXAMPLES) / file, *plugins(), parsed);
}

inline const std::string in_cvode = R"(simulation.integrator={ name = "cvode" })";

using Positions = Eigen::Matrix3Xd;  // by the user's node, m

inline Positions positions_of(const Simulation& simulation) {
  return simulation.positions()(Eigen::all, simulation.columns());
}

// Steps to the end of the scene; `look` is called at the start and after every step.
inline Simulation run(const Scene& scene, const std::function<void(const Simulation&)>& look) {
  Simulation simulation(scene.network, plugins(), scene.options);
  look(simulation);
  while (simulation.time() < scene.duration - 0.5 * scene.options.time_step) {
    const StepReport& report = simulation.step();
    REQUIRE(report.outcome == Outcome::settled);
    look(simulation);
  }
  return simulation;
}

// Greatest distance between positions of a node in the two, m.
inline double greatest(const Positions& a, const Positions& b) { return (a - b).colwise().norm().maxCoeff(); }

}  // namespace springnet::testing
