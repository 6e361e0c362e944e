// A sheet that is pulled, cut, and tears: springs are removed by the hundred while it runs.

#include <numeric>

#include "course.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

struct SheetCourse {
  std::size_t cut = 0, torn = 0;
  double first_tear = 1e9, last_tear = 0.0;  // s
  bool in_two = false;
};

// Whether springs that are left join the upper edge to the lower one.
bool hangs_together(const Network& net, const Simulation& simulation) {
  std::vector<NodeIndex> parent(net.nodes().size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](NodeIndex k) {
    while (parent[k] != k) k = parent[k] = parent[parent[k]];
    return k;
  };
  for (SpringIndex s = 0; s < net.springs().size(); ++s)
    if (simulation.alive(s)) parent[root(net.springs()[s].first)] = root(net.springs()[s].second);
  return root(0) == root(static_cast<NodeIndex>(net.nodes().size() - 1));
}

SheetCourse sheet_course(const Scene& scene) {
  const Simulation simulation = run(scene, [](const Simulation&) {});
  SheetCourse course;
  for (const Event& event : simulation.events()) {
    if (event.kind == Event::Kind::cut) ++course.cut;
    if (event.kind != Event::Kind::ruptured) continue;
    ++course.torn;
    course.first_tear = std::min(course.first_tear, event.time);
    course.last_tear = std::max(course.last_tear, event.time);
  }
  course.in_two = !hangs_together(scene.network, simulation);
  return course;
}

}  // namespace

TEST_CASE("the sheet is cut for the third part of its width, and tears from there to the other side") {
  const SheetCourse course = sheet_course(example("sheet/sheet.toml", {"simulation.duration=1.6"}));
  CHECK(course.cut == 71);  // 24 upright springs, and two diagonals in each of the 23 cells and a half that it crosses
  CHECK(course.first_tear >= 1.0);
  CHECK(course.last_tear < 1.6);
  CHECK(course.torn > 150);  // 57 columns are left: the upright spring and two diagonals of each, and little else
  CHECK(course.torn < 250);
  CHECK(course.in_two);
}

TEST_CASE("a coarser sheet tears through in the reference too, at about the same time") {
  const std::vector<std::string> coarse = {"body.0.mesh.lattice=[41,1,21]", "body.0.mesh.spacing=0.01",
                                           "simulation.duration=1.95",      "body.0.neuron.mass=8e-4",
                                           "body.0.neuron.drag=16e-4",      "body.0.spring.strength=0.18"};
  std::vector<std::string> reference = coarse;
  reference.push_back(in_cvode);
  reference.push_back("simulation.time_step=0.01");
  const SheetCourse a = sheet_course(example("sheet/sheet.toml", coarse)),
                    b = sheet_course(example("sheet/sheet.toml", reference));
  CHECK(a.cut == b.cut);
  CHECK(a.in_two);
  CHECK(b.in_two);
  // Which spring is next is decided by the last digits where the load is shared; how many and how fast is not.
  CHECK(static_cast<double>(a.torn) == doctest::Approx(static_cast<double>(b.torn)).epsilon(0.1));
  CHECK(a.first_tear == doctest::Approx(b.first_tear).epsilon(0.02));
  CHECK(a.last_tear == doctest::Approx(b.last_tear).epsilon(0.1));
}
