// The paper's gall bladder (figure 6): 170 nodes, 396 springs, filled; two forces for 5 s, then it wobbles.

#include "course.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

struct Observed {
  std::vector<double> times;         // s
  std::vector<Positions> positions;  // m
  std::vector<double> volumes;       // m^3
  std::vector<double> pressures;     // Pa

  [[nodiscard]] double displacement(std::size_t i) const { return greatest(positions[i], positions.front()); }
};

Observed course_of(const Scene& scene) {
  Observed course;
  static_cast<void>(run(scene, [&](const Simulation& s) {
    course.times.push_back(s.time());
    course.positions.push_back(positions_of(s));
    course.volumes.push_back(s.element_value(0));
    course.pressures.push_back(-s.element_force(0));
  }));
  return course;
}

void check_course(const Observed& course) {
  std::size_t peak = 0;
  for (std::size_t i = 0; i < course.times.size(); ++i)
    if (course.displacement(i) > course.displacement(peak)) peak = i;
  const double greatest_displacement = course.displacement(peak);
  CHECK(course.times[peak] < 6.0);
  CHECK(greatest_displacement > 0.01);  // visible: more than a tenth of its length
  CHECK(greatest_displacement < 0.04);

  // The node that moved farthest: how often its velocity along that displacement changes sign after 6 s.
  Eigen::Index node = 0;
  (course.positions[peak] - course.positions.front()).colwise().norm().maxCoeff(&node);
  const Vector3 direction = (course.positions[peak] - course.positions.front()).col(node).normalized();
  int reversals = 0;
  double last = 0.0;
  for (std::size_t i = 1; i < course.times.size(); ++i) {
    if (course.times[i] < 6.0) continue;
    const double change = direction.dot((course.positions[i] - course.positions[i - 1]).col(node));
    if (change * last < 0.0) ++reversals;
    if (change != 0.0) last = change;
  }
  CHECK(reversals >= 2);
  CHECK(course.displacement(course.times.size() - 1) <= 0.05 * greatest_displacement);

  // Hard to compress, and under pressure all the time.
  const auto [smallest, largest] = std::minmax_element(course.volumes.begin(), course.volumes.end());
  CHECK(*largest / *smallest < 1.02);
  CHECK(*std::min_element(course.pressures.begin(), course.pressures.end()) > 0.0);
}

}  // namespace

TEST_CASE("the gall bladder has the paper's numbers of nodes and springs, and is closed and filled") {
  const Scene scene = example("bladder/bladder.toml");
  CHECK(scene.network.nodes().size() == 170);
  CHECK(scene.network.springs().size() == 396);
  REQUIRE(scene.network.elements().size() > 0);
  CHECK(scene.network.elements()[0].invariant == Invariant::enclosed_volume);
  CHECK(scene.network.elements()[0].nodes.size() == 3 * 336);  // 2 (170 - 2) triangles, by Euler
}

TEST_CASE("without forces the gall bladder rests") {
  Scene scene = example("bladder/bladder.toml", {"force.0.until=1e-9", "force.1.until=1e-9", "simulation.duration=2"});
  const Observed course = course_of(scene);
  // The mesh's coordinates have nine digits; what is left beside is a thousandth of the way that the forces move it.
  CHECK(course.displacement(course.times.size() - 1) < 2e-5);
}

TEST_CASE(
    "the gall bladder gives way to two forces for 5 s, wobbles, and is nearly neutral at 16 s, in both integrators") {
  const Observed network = course_of(example("bladder/bladder.toml"));
  check_course(network);
  const Observed reference = course_of(example("bladder/bladder.toml", {in_cvode}));
  check_course(reference);
  double apart = 0.0;
  for (std::size_t i = 0; i < network.times.size(); ++i)
    apart = std::max(apart, greatest(network.positions[i], reference.positions[i]));
  CHECK(apart < 1e-3);
}
