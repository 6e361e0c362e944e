// What of a motion with located events has no derivative: refused with the event, and what to do.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/motion_derivatives.hpp>

#include "facts.hpp"
#include "motion_loss.hpp"
#include "touching_nets.hpp"

using namespace springnet;
using namespace springnet::testing;
using Kind = LearnedValues::Kind;

namespace {

// What is said of a motion whose first mass is learned, or of its derivatives.
std::string refusal_of_motion(const Network& net, double duration, double theta = 0.5) {
  const auto shared = std::make_shared<const Network>(net);
  std::uint32_t free = 0;
  while (net.nodes()[free].fixed) ++free;
  MotionDerivatives motion(shared, plugins(), located(theta, 0.01), duration, {{Kind::mass, false, "", {free}}});
  try {
    motion.run(motion.values_of_network());
    static_cast<void>(gradient_of_end(motion, free, 0));
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::simulation);
    return error.what();
  }
  return {};
}

Plane wall_with(const Friction& friction) {
  Plane wall = floor_with(friction, -Vector3::UnitX());
  wall.name = "wall";
  wall.point = {0.5, 0, 0};
  return wall;
}

}  // namespace

TEST_CASE(
    "of rigidly connected nodes only one event at a time is differentiated, and no start of a slip below theta 1") {
  Network flat;
  flat.add_node(point({0, 0, 0.1}));
  flat.add_node(point({0.3, 0, 0.1}));
  flat.add_rigid(0, 1);
  flat.set_gravity({0, 0, -9.81});
  flat.add_plane(floor_with(smooth));
  std::string said = refusal_of_motion(flat, 0.3);
  CAPTURE(said);
  CHECK(has(said, "the coincidence of events of node 0 with plane 'floor' (number 0) at 0.14"));
  CHECK(has(said, "as rigid connections join the nodes; set events = \"stepwise\""));

  // Friction holds the lower node until the rod has turned.
  Network leaning;
  leaning.add_node(point({0, 0, 0}));
  leaning.add_node(point({0.1, 0, 0.3}, 1.0, {0.5, 0, 0}));
  leaning.add_rigid(0, 1);
  leaning.set_gravity({0, 0, -9.81});
  leaning.add_plane(floor_with(rough));
  said = refusal_of_motion(leaning, 0.3, 0.5);
  CHECK(has(said, "the slip of node 0 with plane 'floor'"));
  CHECK(has(said, "as node 0, which is rigidly connected, begins to slip there, and theta is below 1"));
  CHECK(refusal_of_motion(leaning, 0.2, 1.0).empty());
}

TEST_CASE("an impact with friction on the edge of two surfaces is refused with its node and surface") {
  Network net;
  net.add_node(point({0, 5, 0}));
  net.add_node(point({0.2, 0, 0}, 1.0, {2.0, 1.0, 0}));  // slides on the floor into the wall
  net.set_gravity({0, 0, -9.81});
  net.add_plane(floor_with(rough));
  net.add_plane(wall_with(rough));
  const std::string said = refusal_of_motion(net, 0.3);
  CAPTURE(said);
  CHECK(has(said, "the contact of node 1 with plane 'floor' (number 0) at 0."));
  CHECK(has(said, "is not differentiated; learn from the time before it"));
}
