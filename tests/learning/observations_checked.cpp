// Observations against the net and the motion that they are of.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "facts.hpp"
#include "observation_tables.hpp"

namespace springnet::testing {
namespace {

using Place = Observations::Place;

TEST_CASE("what the net and the motion do not have is refused with the place of the row") {
  const std::string vectors = "time,node,x,y,z,vx\n0,9,1,1,1,1\n";
  CHECK(objection(read(vectors)).empty());
  CHECK(has_facts(objection(read(vectors + "1,10,1,1,1,1\n")), "a.csv:3: | node 10 | 10 nodes | correct"));
  CHECK(has_facts(objection(read(vectors + "1,10,,,,\n")), "a.csv:3: | node 10"));
  CHECK(has_facts(objection(read(vectors + "-0.5,1,1,1,1,1\n")), "a.csv:3: | -0.5 s | start at 0 s"));
  CHECK(has_facts(objection(read(vectors + "2.001,1,1,1,1,1\n")), "a.csv:3: | 2.001 s | end at 2 s"));
  CHECK(has_facts(objection(read(vectors + "2.001,1,,,,1\n")), "a.csv:3: | 2.001 s"));
  CHECK(objection(read(vectors + "2.000000001,1,1,1,1,1\n")).empty());
  CHECK(objection(read(vectors + "2.001,1,,,,\n")).empty());  // not observed
  CHECK(has_facts(objection(read("time,node,x\n5,1,1\n9,1,1\n7,3,1\n")),
                  "a.csv: | nothing is observed during the motion | 5 s | 9 s | 0 s | 2 s"));
  CHECK(has_facts(objection(read("time,node,x\n1,1,\n2,1,nan\n")), "a.csv: nothing is observed"));
  CHECK(has_facts(objection(read("time,node,x,weight\n1,1,1,0\n")), "a.csv: nothing is observed"));
  CHECK(has_facts(objection(Observations()), "nothing is observed"));

  const std::string distances = "time,node,other,distance\n0,1,2,1\n";
  CHECK(objection(read(distances)).empty());
  CHECK(has_facts(objection(read(distances + "1,10,1,1\n")), "a.csv:3: | node 10"));
  CHECK(has_facts(objection(read(distances + "1,1,11,1\n")), "a.csv:3: | node 11"));
  CHECK(has_facts(objection(read(distances + "1,3,3,1\n")), "a.csv:3: | node 3 to itself"));
  CHECK(has_facts(objection(read(distances + "3,1,3,1\n")), "a.csv:3: | 3 s"));
  CHECK(has_facts(objection(read("time,x,y,z\n1,1,1,1\n3,1,1,1\n")), "a.csv:3: | 3 s"));
}

TEST_CASE("values that are observed twice are refused with both places") {
  CHECK(has_facts(objection(read("time,node,x,vx\n1,1,1,\n1,2,1,\n1,1,2,1\n")),
                  "a.csv:4: | positions of node 1 | 1 s | a.csv:2"));
  CHECK(has_facts(objection(read("time,node,vx\n1,1,1\n1,2,1\n1,1,2\n")), "a.csv:4: | velocities of node 1"));
  CHECK(has_facts(objection(read("time,node,rx\n-0,1,1\n0,1,2\n")), "a.csv:3: | reactions of node 1"));
  const char* const distances = "time,node,other,distance\n1,1,2,1\n1,1,3,1\n";
  CHECK(objection(read(distances)).empty());
  CHECK(has_facts(objection(read(distances + std::string("1,2,1,1\n"))), "a.csv:4: | nodes 2 and 1 | a.csv:2"));
  // Not twice: other times, other nodes, other components, other quantities, missing values, points of a surface.
  CHECK(objection(read("time,node,x\n1,1,1\n0,1,1\n1,2,1\n0,2,1\n")).empty());
  CHECK(objection(read("time,node,x,y\n1,1,1,\n1,1,,1\n1,1,,\n")).empty());
  CHECK(objection(read("time,node,x,vx\n1,1,1,\n1,1,,1\n")).empty());
  CHECK(objection(read("time,x,y,z\n1,1,1,1\n1,1,1,1\n")).empty());
  CHECK(has_facts(objection(read("time,node,x,y\n1,1,1,\n1,1,,1\n1,1,,1\n")), "a.csv:4: | after | a.csv:3"));
  // Many rows that are out of order: the one that is wrong is found.
  std::string text = "time,node,x\n";
  for (int node = 0; node < 10; ++node)
    for (int step = 0; step < 200; ++step) text += std::to_string(0.01 * step) + "," + std::to_string(node) + ",1\n";
  CHECK(objection(read(text)).empty());
  CHECK(has_facts(objection(read(text + "0.5,7,1\n")), "a.csv:2002: | node 7 | 0.5 s | a.csv:1452"));
}

TEST_CASE("rows that a program makes are checked likewise") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const Observations good = [] {
    Observations result;
    result.positions = {{0.5, {1, 2, 3}, {1, 1, 1}, 0}, {1.0, {1, 2, 3}, {1, 1, 1}, 0}};
    result.distances = {{0.5, 0.1, 1.0, 0, 1}};
    result.surface_points = {{0.5, {1, 2, 3}, 1.0}};
    return result;
  }();
  CHECK(objection(good).empty());
  CHECK(good.text_of(good.positions[0].place).empty());
  const auto changed = [&](const auto& change) {
    Observations observations = good;
    change(observations);
    return objection(observations);
  };
  using O = Observations;
  CHECK(has_facts(changed([](O& o) { o.positions[1].node = 10; }), "positions[1]: | node 10"));
  CHECK(has_facts(changed([](O& o) { o.positions[1].time = 0.5; }), "positions[1]: | positions[0]"));
  CHECK(has_facts(changed([&](O& o) { o.positions[1].time = nan; }), "positions[1]: | time is nan"));
  CHECK(has_facts(changed([&](O& o) { o.positions[1].value[2] = nan; }), "positions[1]: | value is nan"));
  CHECK(has_facts(changed([&](O& o) { o.positions[1].value[2] = -infinity; }), "positions[1]: | value is -inf"));
  CHECK(has_facts(changed([](O& o) { o.positions[1].weight[0] = -1.0; }), "positions[1]: | weight is -1"));
  CHECK(has_facts(changed([&](O& o) { o.positions[1].weight[1] = nan; }), "positions[1]: | weight is nan"));
  CHECK(has_facts(changed([&](O& o) { o.positions[1].weight[1] = infinity; }), "positions[1]: | weight is inf"));
  CHECK(has_facts(changed([](O& o) { o.distances[0].distance = -0.5; }), "distances[0]: | -0.5 m"));
  CHECK(has_facts(changed([](O& o) { o.distances[0].weight = -0.5; }), "distances[0]: | weight is -0.5"));
  CHECK(has_facts(changed([](O& o) { o.distances[0].node = 1; }), "distances[0]: | itself"));
  CHECK(has_facts(changed([&](O& o) { o.surface_points[0].point[1] = nan; }), "surface_points[0]: | value is nan"));
  CHECK(has_facts(changed([](O& o) { o.surface_points[0].weight = -2.0; }), "surface_points[0]: | weight is -2"));
  CHECK(has_facts(changed([](O& o) { o.surface_points[0].time = 2.5; }), "surface_points[0]: | 2.5 s"));
}

TEST_CASE("tables of one experiment are put together, and rows keep their places") {
  const Tables tables;
  Observations all = tables.read("time,node,x\n1,0,1\n0,1,1\n", "a.csv");
  all.append(tables.read("time,x,y,z\n0.5,0,1,1\n2,1,1,1\n", "b.csv"));
  all.append(tables.read("# two\ntime,node,x,vx\n1,2,1,1\n1.5,2,,\n", "c.csv"));
  CHECK(all.times() == std::vector<double>{0, 0.5, 1, 2});
  CHECK(all.value_count() == 6);
  REQUIRE(all.positions.size() == 4);
  const auto place = [&](const Place& of) { return std::filesystem::path(all.text_of(of)).filename().string(); };
  CHECK(place(all.positions[1].place) == "a.csv:3");
  CHECK(place(all.positions[2].place) == "c.csv:3");
  CHECK(place(all.velocities.at(0).place) == "c.csv:3");
  CHECK(place(all.surface_points.at(1).place) == "b.csv:3");
  CHECK(objection(all).empty());
  all.append(tables.read("time,node,x\n0.5,0,1\n1,0,2\n", "d.csv"));
  CHECK(has_facts(objection(all), "d.csv:3: | node 0 | a.csv:2"));
  // A message about all of them names some.
  Observations none;
  for (const char* name : {"a.csv", "b.csv", "c.csv", "d.csv", "e.csv"})
    none.append(tables.read("time,node,x\n", name));
  CHECK(has_facts(objection(none), "a.csv, | c.csv and 2 other files: nothing"));
}

}  // namespace
}  // namespace springnet::testing
