// What inspection finds suspicious in networks that are as they should be but for one thing.
#include <cmath>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <springnet/inspection.hpp>

#include "nets.hpp"

using namespace springnet;
using testing::plugins;

namespace {

Network chain() { return testing::chain(10, Vector3::Zero(), Vector3::UnitX(), testing::damped(5.0, 0.5), 2.0); }

Suspicions suspicions_of(const Network& network) { return inspect(network, *plugins()).suspicions; }

}  // namespace

TEST_CASE("a network without flaws raises no suspicion") {
  const Suspicions found = suspicions_of(chain());
  for (const UnusualSprings* springs :
       {&found.stiffness, &found.damping, &found.elastic_rate, &found.viscous_rate, &found.strain}) {
    CHECK(springs->count == 0);
    CHECK(springs->worst.empty());
  }
  CHECK(found.springs_without_direction == 0);
  CHECK(found.springs_that_soften == 0);
  CHECK(found.nodes_without_springs.empty());
  CHECK_FALSE(found.lightest);
}

TEST_CASE("springs over a hundred times the median are listed, worst first, in the user's numbers") {
  Network net = chain();
  net.set_spring_material(3, net.add_material(testing::damped(505.0, 0.5)));
  net.set_spring_material(7, net.add_material(testing::damped(600.0, 60.0)));
  net.set_spring_material(8, net.add_material(testing::damped(500.0, 0.5)));  // not more than 100 times
  const Suspicions found = suspicions_of(net);
  CHECK(found.stiffness.median == 5.0);
  CHECK(found.stiffness.bound == 500.0);
  CHECK(found.stiffness.count == 2);
  REQUIRE(found.stiffness.worst.size() == 2);
  CHECK(found.stiffness.worst[0].spring == 7);
  CHECK(found.stiffness.worst[0].first == 7);
  CHECK(found.stiffness.worst[0].second == 8);
  CHECK(found.stiffness.worst[0].value == 600.0);
  CHECK(found.stiffness.worst[1].spring == 3);
  CHECK(found.damping.count == 1);
  CHECK(found.damping.worst[0].value == 60.0);
  CHECK(found.elastic_rate.median == 5.0);  // 5 (1/2 + 1/2)
  CHECK(found.elastic_rate.count == 2);
  CHECK(found.viscous_rate.count == 1);
}

TEST_CASE("a light node makes its springs fast without making them stiff") {
  Network net = chain();
  Node node = net.nodes()[4];
  node.mass = 1e-4;
  net.set_node(4, node);
  const Suspicions found = suspicions_of(net);
  CHECK(found.stiffness.count == 0);
  CHECK(found.elastic_rate.count == 2);
  CHECK(found.elastic_rate.worst[0].spring == 3);
  CHECK(found.lightest == 4u);
  CHECK(found.heaviest == 0u);
  net.fix(4);  // moves no more
  CHECK(suspicions_of(net).elastic_rate.count == 0);
  CHECK_FALSE(suspicions_of(net).lightest);
}

TEST_CASE("only the worst are listed") {
  Network net = testing::chain(40, Vector3::Zero(), Vector3::UnitX(), testing::damped(5.0, 0.0));
  for (SpringIndex s = 10; s < 20; ++s) net.set_spring_material(s, net.add_material(testing::damped(1000.0 + s, 0.0)));
  const Suspicions found = suspicions_of(net);
  CHECK(found.stiffness.count == 10);
  REQUIRE(found.stiffness.worst.size() == listed_at_most);
  CHECK(found.stiffness.worst.back().spring == 15);
}

TEST_CASE("great strain, springs without direction and springs that soften") {
  Network net = chain();
  net.set_rest_length(2, 0.5);
  net.set_rest_length(5, 1.1);
  net.set_spring_material(6,
                          net.add_material({LawUse{"nonlinear", {{"stiffness", -1.0}, {"cubic", 3.0}}}, std::nullopt}));
  Node node = net.nodes()[9];
  node.position = net.nodes()[8].position;
  net.set_node(9, node);
  const Suspicions found = suspicions_of(net);
  CHECK(found.strain.count == 2);  // spring 8 as well
  CHECK(found.strain.worst[0].spring == 2);
  CHECK(found.strain.worst[0].value == 1.0);
  CHECK(found.springs_without_direction == 1);
  CHECK(found.springs_that_soften == 1);
}

TEST_CASE("parts by size, with what fixes them; rigid connections join as springs do") {
  Network net = chain();
  net.add_node(testing::point({0, 5, 0}));
  net.add_node(testing::point({1, 5, 0}));
  net.add_node(testing::point({2, 5, 0}));
  net.add_rigid(11, 12);
  net.fix(3);
  const Inspection found = inspect(net, *plugins());
  REQUIRE(found.parts.size() == 3);
  CHECK(found.parts[0].first_node == 0);
  CHECK(found.parts[0].nodes == 10);
  CHECK(found.parts[0].springs == 9);
  CHECK(found.parts[0].fixed_nodes == 1);
  CHECK(found.parts[1].first_node == 11);
  CHECK(found.parts[1].nodes == 2);
  CHECK(found.parts[1].springs == 0);
  CHECK(found.parts[1].fixed_nodes == 0);
  CHECK(found.parts[2].nodes == 1);
  CHECK(found.nodes_without_springs == 1);
  CHECK(found.suspicions.nodes_without_springs == std::vector<NodeIndex>{10});
}

TEST_CASE("all of it is in the JSON") {
  Network net = chain();
  net.set_spring_material(7, net.add_material(testing::damped(600.0, 0.5)));
  net.add_node(testing::point({0, 5, 0}));
  InspectionOptions options;
  options.time_step = 0.01;
  const Inspection found = inspect(net, *plugins(), options);
  const auto json = nlohmann::json::parse(to_json(found));
  const auto& synchronous = json["time_constants"]["synchronous"];
  CHECK(synchronous["limit"] == "known");
  const double limit = found.limit("synchronous").time_constant;
  CHECK(synchronous["time_constant_s"] == limit);
  CHECK(synchronous["time_step_over_limit"] == 0.01 / limit);
  CHECK(synchronous["set_by"]["spring"] == 7);
  CHECK(synchronous["set_by"]["stiffness_n_per_m"] == 600.0);
  CHECK(json["time_constants"]["newton"]["limit"] == "none");
  CHECK(json["time_constants"]["newton"]["time_constant_s"].is_null());
  CHECK(json["suspicions"]["stiffness_n_per_m"]["worst"][0]["nodes"] == nlohmann::json::array({7, 8}));
  CHECK(json["suspicions"]["nodes_without_springs"] == nlohmann::json::array({10}));
  CHECK(json["mobility"]["mechanisms"] == 16);  // a straight chain of ten: 30 - 9 - 5
  CHECK(json["parts"][1]["nodes"] == 1);
  CHECK(json["part_count"] == 2);
}
