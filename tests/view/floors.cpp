// Numbers below rounding are 0 on the page.
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include "scenes.hpp"
#include "view/content.hpp"
#include "view/floors.hpp"

using namespace springnet;
using testing::plugins;

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

// Two nodes 1 m apart, 1000 m from the origin; a spring of 1e6 N/m between them, a soft one beside it.
Scene far_out() {
  Scene scene;
  const MaterialIndex stiff = scene.network.add_material({LawUse{"linear", {{"stiffness", 1e6}}}, std::nullopt});
  const MaterialIndex soft = scene.network.add_material({LawUse{"linear", {{"stiffness", 1.0}}}, std::nullopt});
  for (const double x : {1000.0, 1001.0, 1002.0}) {
    Node node;
    node.position = Vector3(x, 0.0, 0.0);
    scene.network.add_node(node);
  }
  scene.network.add_spring(0, 1, stiff);
  scene.network.add_spring(1, 2, soft);
  scene.options.time_step = 0.01;
  return scene;
}

view::Frames one_frame(float position, float speed, float tension, float other_tension) {
  view::Frames frames({view::fixed_scalars, 3, 2, 0}, 10, 10);
  frames.begin();
  frames.positions.last()[0] = 1000.0F;
  frames.positions.last()[1] = position;
  frames.speeds.last()[0] = speed;
  frames.tensions.last()[0] = tension;
  frames.tensions.last()[1] = other_tension;
  return frames;
}

}  // namespace

TEST_CASE("the floor of a tension is the spring's stiffness times the rounding of its ends' coordinates") {
  const Scene scene = far_out();
  const view::Selection selection = view::select(scene.network, 10.0, 1e6);
  const view::Floors floors = view::floors_of(scene, selection, plugins().get());
  REQUIRE(floors.tension.size() == 2);
  // One rounding of 1002 m is 2^-44 m: the stiff spring cannot know its tension better than to 1e6 of these.
  CHECK(floors.tension[0] >= 1e6F * static_cast<float>(eps * 1002.0));
  CHECK(floors.tension[0] <= 16e6F * static_cast<float>(eps * 1002.0));
  CHECK(floors.tension[1] == doctest::Approx(1e-6 * static_cast<double>(floors.tension[0])));
  CHECK(floors.speed == doctest::Approx(100.0 * floors.position));
  // Without plugins nothing is known of stiffness.
  CHECK(view::floors_of(scene, selection, nullptr).tension == std::vector<float>{0.0F, 0.0F});
}

TEST_CASE("values below their floor, or within rounding of the largest in the frame, become 0; others are kept") {
  const Scene scene = far_out();
  const view::Floors floors = view::floors_of(scene, view::select(scene.network, 10.0, 1e6), plugins().get());
  view::Frames small = one_frame(1e-13F, 1e-12F, 1e-7F, 1e-7F);
  view::drop_rounding(floors, small);
  CHECK(small.positions.last()[0] == 1000.0F);
  CHECK(small.positions.last()[1] == 0.0F);
  CHECK(small.speeds.last()[0] == 0.0F);
  CHECK(small.tensions.last()[0] == 0.0F);
  CHECK(small.tensions.last()[1] == 1e-7F);  // of the soft spring that is a force

  view::Frames beside = one_frame(1e-9F, 1e-5F, 10.0F, 1.2e-17F);
  view::Floors none;
  none.tension = {0.0F, 0.0F};
  view::drop_rounding(none, beside);
  CHECK(beside.positions.last()[1] == 1e-9F);
  CHECK(beside.speeds.last()[0] == 1e-5F);
  CHECK(beside.tensions.last()[0] == 10.0F);
  CHECK(beside.tensions.last()[1] == 0.0F);
}

TEST_CASE("a frame that diverges takes no digits from those before it") {
  view::Frames frames({view::fixed_scalars, 3, 2, 0}, 10, 10);
  for (const float tension : {1.0F, 1e30F}) {
    frames.begin();
    frames.tensions.last()[0] = tension;
    frames.tensions.last()[1] = 1e-3F * tension;
  }
  view::Floors floors;
  floors.tension = {0.0F, 0.0F};
  view::drop_rounding(floors, frames);
  CHECK(frames.tensions.numbers() == std::vector<float>{1.0F, 1e-3F, 1e30F, 1e-3F * 1e30F});
}

TEST_CASE("a network at rest far from the origin shows no tension and no energy in its springs") {
  const Scene scene = far_out();
  Simulation simulation(scene.network, plugins(), scene.options);
  view::Frames frames({view::fixed_scalars, 3, 2, 0}, 10, 10);
  frames.begin();
  std::vector<double> tensions;
  simulation.set_position(1, Vector3(1001.0 + 1e-13, 0.0, 0.0));  // within a rounding
  simulation.tensions(tensions);
  for (std::size_t k = 0; k < 2; ++k) frames.tensions.last()[k] = static_cast<float>(tensions[k]);
  REQUIRE(tensions[0] != 0.0);
  frames.scalars.last()[view::potential] = simulation.potential_energy();
  REQUIRE(simulation.potential_energy() > 0.0);
  view::drop_rounding(view::floors_of(scene, view::select(scene.network, 10.0, 1e6), plugins().get()), frames);
  CHECK(frames.tensions.numbers() == std::vector<float>{0.0F, 0.0F});
  CHECK(frames.scalars.numbers()[view::potential] == 0.0);
}
