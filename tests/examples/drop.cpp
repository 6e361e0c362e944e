// A cloth that falls onto a soft block: bodies that touch each other.

#include "course.hpp"

using namespace springnet;
using namespace springnet::testing;

TEST_CASE("the cloth comes to rest on the block, and the floor carries both") {
  const Scene scene = example("drop/drop.toml");
  const Network& net = scene.network;
  double energy = 1e9, lowest = 0.0;
  const Simulation s = run(scene, [&](const Simulation& now) {
    const double total = now.kinetic_energy() + now.potential_energy();
    CHECK(total < energy + 1e-4);  // of 2 J; what overlaps by a thousandth is pushed apart
    energy = total;
    lowest = std::min(lowest, positions_of(now).row(2).minCoeff());
  });
  CHECK(lowest > -1e-6);
  double weight = 0.0, cloth = 0.0;  // N
  const Body &block = net.bodies()[0], &sheet = net.bodies()[1];
  for (NodeIndex k = 0; k < net.nodes().size(); ++k) {
    const double own = 9.81 * net.nodes()[k].mass;
    weight += own;
    if (k >= sheet.first_node) cloth += own;
  }
  CHECK(-s.surface_force(0)[2] == doctest::Approx(weight).epsilon(0.05));
  // The block bears what of the cloth does not lie on the floor.
  double on_block = 0.0;
  for (const BodyTouch& each : s.body_touches())
    if (const bool first = each.nodes[0] >= sheet.first_node, second = each.nodes[each.first] >= sheet.first_node;
        first != second)
      on_block += (first ? 1.0 : -1.0) * each.force[2];
  CHECK(on_block > 0.2 * cloth);
  CHECK(on_block < cloth);
  // Its middle lies on the block: a thickness above the node below, or on a face beside it.
  const Positions x = positions_of(s);
  const double top = x.row(2).leftCols(block.node_count).maxCoeff();
  CHECK(x(2, sheet.first_node + 9 + 18 * 9) > top - 0.01);
  CHECK(s.kinetic_energy() < 2e-3);
}
