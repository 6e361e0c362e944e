// Forces between bodies in contact as the page stores them.
#include <algorithm>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/run.hpp>
#include <springnet/view.hpp>

#include "../bodies/bodies.hpp"
#include "record/record.hpp"
#include "temporary_folder.hpp"
#include "text/archive.hpp"
#include "view/frames.hpp"
#include "view/page_writer.hpp"
#include "view/touches.hpp"

using namespace springnet;
using springnet::testing::plugins;
using springnet::testing::TemporaryFolder;

namespace {

// Of node `node` and the next.
BodyTouch touch_of(NodeIndex node, const Vector3& force) {
  BodyTouch touch;
  touch.nodes = {node, node + 1};
  touch.first = 1;
  touch.count = 2;
  touch.weights = {1.0, -1.0};
  touch.position = Vector3(node, 0.5, 0.25);
  touch.force = force;
  return touch;
}

// All of `nodes` nodes are shown.
view::Selection all_of(NodeIndex nodes) {
  view::Selection selection;
  for (NodeIndex k = 0; k < nodes; ++k) {
    selection.nodes.push_back(k);
    selection.node_place.push_back(k);
  }
  return selection;
}

// Numbers of what take_touches() writes: those of the nodes, with room for so many.
std::vector<float> nodes_kept(const std::vector<BodyTouch>& touches, std::size_t capacity) {
  std::vector<float> row(view::touch_numbers * capacity, 9.0F), nodes;
  view::take_touches(touches, all_of(100), row);
  for (std::size_t k = 0; k < capacity; ++k) {
    if (row[view::touch_numbers * k + 6] != 0.0F) nodes.push_back(row[view::touch_numbers * k]);
  }
  return nodes;
}

// So many balls, each on a fixed one, each pair far from the others.
Network pairs_of_balls(int count) {
  Network net;
  for (int k = 0; k < count; ++k) {
    testing::add_ball(net, "ground " + std::to_string(k), {1.0 * k, 0, 0}, testing::at_rest, 1.0, 0.1, true);
    testing::add_ball(net, "ball " + std::to_string(k), {1.0 * k, 0, 0.2}, testing::at_rest, 0.1 + 0.01 * k, 0.1);
  }
  testing::touch_all(net, testing::frictionless);
  net.set_gravity({0, 0, -10});
  return net;
}

Scene scene_of(const Network& network, double duration) {
  Scene scene;
  scene.network = network;
  scene.duration = duration;
  scene.options.time_step = 0.01;
  scene.options.integrator = testing::verlet;
  return scene;
}

}  // namespace

TEST_CASE("a touch is stored with its node, place and force; the rest of the row has no forces") {
  std::vector<float> row(2 * view::touch_numbers, 9.0F);
  CHECK(view::take_touches({touch_of(3, {1, 2, 3})}, all_of(5), row) == 1);
  CHECK(row == std::vector<float>{3, 3, 0.5F, 0.25F, 1, 2, 3, 0, 0, 0, 0, 0, 0, 0});
}

TEST_CASE("the node of a touch is the one of greatest weight that is shown, or none") {
  BodyTouch touch;
  touch.nodes = {7, 2, 4, 9};
  touch.first = 1;
  touch.count = 4;
  touch.weights = {1.0, -0.25, -0.5, -0.25};
  touch.force = {0, 0, 1};
  view::Selection selection = all_of(10);
  std::vector<float> row(view::touch_numbers);
  const auto node = [&] {
    view::take_touches({touch}, selection, row);
    return row[0];
  };
  CHECK(node() == 7.0F);
  selection.node_place[7] = view::not_shown;
  selection.node_place[4] = 1;  // a place in the selection, not the user's number
  CHECK(node() == 1.0F);
  for (const NodeIndex each : {2, 4, 9}) selection.node_place[each] = view::not_shown;
  CHECK(node() == -1.0F);
  CHECK(row[6] == 1.0F);
}

TEST_CASE("if touches do not fit, those with the largest forces are kept, the first of equal ones, in their order") {
  const std::vector<BodyTouch> touches{touch_of(0, {0, 0, 2}), touch_of(1, {0, 0, -5}), touch_of(2, {0, 0, 2}),
                                       touch_of(3, {0, 0, 0}), touch_of(4, {0, 0, 3}),  touch_of(5, {0, 0, 2})};
  CHECK(nodes_kept(touches, 6) == std::vector<float>{0, 1, 2, 4, 5});
  CHECK(nodes_kept(touches, 4) == std::vector<float>{0, 1, 2, 4});
  CHECK(nodes_kept(touches, 3) == std::vector<float>{0, 1, 4});
  CHECK(nodes_kept(touches, 1) == std::vector<float>{1});
  CHECK(nodes_kept(touches, 0).empty());
  std::vector<float> row(view::touch_numbers);
  CHECK(view::take_touches(touches, all_of(10), row) == 5);
}

TEST_CASE("forces that are rounding beside the largest are none") {
  CHECK(nodes_kept({touch_of(0, {0, 0, 1e-14}), touch_of(1, {0, 0, 1})}, 2) == std::vector<float>{1});
  CHECK(nodes_kept({touch_of(0, {0, 0, 1e-10}), touch_of(1, {0, 0, 1})}, 2) == std::vector<float>{0, 1});
  CHECK(nodes_kept({touch_of(0, {0, 0, 1e-14})}, 1) == std::vector<float>{0});
}

TEST_CASE("frames have room for as many touches as there can be, up to a bound, and for none without contact") {
  CHECK(view::touch_capacity(pairs_of_balls(1)) == 1);
  CHECK(view::touch_capacity(testing::pile_of_balls(2, 1.0, 0.1)) == 3);
  CHECK(view::touch_capacity(pairs_of_balls(60)) == view::max_touches);
  CHECK(view::touch_capacity(testing::dropped_blocks(2, 0.1)) == view::max_touches);
  Network without;
  testing::add_ball(without, "a", {0, 0, 0}, testing::at_rest, 1.0, 0.1);
  testing::add_ball(without, "b", {1, 0, 0}, testing::at_rest, 1.0, 0.1);
  CHECK(view::touch_capacity(without) == 0);
}

TEST_CASE("the estimate of a page counts the forces between bodies") {
  const Scene scene = scene_of(pairs_of_balls(20), 2.0);
  const TemporaryFolder folder;
  REQUIRE_FALSE(run_scene(scene, plugins(), {folder.path(), "balls", {}}).failure);
  const auto bytes = static_cast<double>(testing::read_text(folder.path() / "view.html").size());
  CHECK(bytes <= estimate_view(scene));
  CHECK(bytes >= 0.98 * estimate_view(scene));
}

TEST_CASE("a page notes that not all forces between bodies have arrows, also after it resumes without them") {
  const Scene scene = scene_of(pairs_of_balls(101), 0.05);
  const TemporaryFolder folder;
  Simulation simulation(scene.network, plugins(), scene.options);
  Record record(scene.network);
  std::string bytes;
  const std::string note = "of up to 101 pairs in contact at a time, the 100 with the largest forces have arrows";
  const auto has_note = [&](const view::PageWriter& page) {
    return std::count(page.left_out().begin(), page.left_out().end(), note) == 1;
  };
  {
    view::PageWriter page(OutputFile(folder.path() / "first.html"), scene, {});
    record.take(simulation);  // no force is known at the start
    page.record(record);
    view::PageWriter few(OutputFile(folder.path() / "few.html"), scene, {});
    few.record(record);
    few.close();
    CHECK_FALSE(has_note(few));
    simulation.step();
    REQUIRE(simulation.body_touches().size() == 101);
    record.take(simulation);
    page.record(record);
    Archive out(&bytes);
    page.archive(out);
    page.close();
    CHECK(has_note(page));
  }
  view::PageWriter later(OutputFile(folder.path() / "later.html"), scene, {}, true);
  Archive in{std::string_view(bytes)};
  later.archive(in);
  CHECK(in.left() == 0);
  later.go_on();
  later.close();
  CHECK(has_note(later));
  CHECK(testing::read_text(folder.path() / "later.html") == testing::read_text(folder.path() / "first.html"));
}
