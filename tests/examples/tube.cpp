// The paper's Fallopian tube (figure 7): 160 nodes, 610 springs, manipulated by two instruments at 40 steps a second.

#include "course.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

struct TubeCourse {
  std::vector<Positions> positions;  // m
  double greatest_pull = 0.0;        // N, of the grasper
  double greatest_push = 0.0;        // N, on the probe
  double pushed_from = -1.0;         // s
  std::size_t most_touching = 0;
  double sweeps_per_step = 0.0;
};

TubeCourse tube_course(const Scene& scene) {
  TubeCourse course;
  const std::vector<NodeIndex> grasped = scene.network.moves().at(0).nodes;
  static_cast<void>(run(scene, [&](const Simulation& s) {
    course.positions.push_back(positions_of(s));
    Vector3 pull = Vector3::Zero();
    for (const NodeIndex node : grasped) pull += s.reaction(node);
    course.greatest_pull = std::max(course.greatest_pull, pull.norm());
    course.greatest_push = std::max(course.greatest_push, s.surface_force(0).norm());
    course.most_touching = std::max(course.most_touching, s.nodes_touching(0));
    course.sweeps_per_step = static_cast<double>(s.sweeps()) * scene.options.time_step / std::max(s.time(), 1e-9);
    if (course.pushed_from < 0.0 && s.nodes_touching(0) > 0) course.pushed_from = s.time();
  }));
  return course;
}

}  // namespace

TEST_CASE("the tube has the paper's numbers of nodes and springs, and steps of 1/40 s") {
  const Scene scene = example("tube/tube.toml");
  CHECK(scene.network.nodes().size() == 160);
  CHECK(scene.network.springs().size() == 610);
  CHECK(scene.options.time_step == 1.0 / 40.0);
}

TEST_CASE("a grasper draws the tube and a probe presses it; both feel it, alike in both integrators") {
  const TubeCourse network = tube_course(example("tube/tube.toml"));
  const TubeCourse reference = tube_course(example("tube/tube.toml", {in_cvode}));
  for (const TubeCourse* course : {&network, &reference}) {
    CHECK(course->greatest_pull > 1e-3);
    CHECK(course->greatest_push > 1e-3);
    CHECK(course->most_touching >= 2);
    CHECK(course->pushed_from > 1.0);  // the probe starts to move then
    CHECK(course->pushed_from < 3.0);
    double farthest = 0.0;
    for (const Positions& p : course->positions) farthest = std::max(farthest, greatest(p, course->positions.front()));
    CHECK(farthest > 0.01);
    // Let go, it comes back.
    CHECK(greatest(course->positions.back(), course->positions.front()) < 0.05 * farthest);
  }
  // Newton settles every step: 4.1 were measured; 39.8 where `block` takes over, as a node that reaches the probe
  // counted as leaving it.
  CHECK(network.sweeps_per_step > 1.0);
  CHECK(network.sweeps_per_step < 6.0);
  double apart = 0.0;
  for (std::size_t i = 0; i < network.positions.size(); ++i)
    apart = std::max(apart, greatest(network.positions[i], reference.positions[i]));
  CHECK(apart < 3e-4);  // 0.03 mm were seen; nodes are caught at the end of steps in which the probe goes 0.3 mm
  CHECK(network.greatest_pull == doctest::Approx(reference.greatest_pull).epsilon(0.01));
  CHECK(network.greatest_push == doctest::Approx(reference.greatest_push).epsilon(0.05));
}
