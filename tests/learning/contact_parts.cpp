// Parts of derivatives of motions in contact, each by itself.

#include <cmath>
#include <optional>

#include <doctest/doctest.h>

#include "constraints/contact.hpp"
#include "learning/contact_history.hpp"
#include "learning/event_jump.hpp"
#include "learning/settled_difference.hpp"
#include "nets.hpp"
#include "simulation/engine.hpp"

using namespace springnet;
using namespace springnet::testing;
using namespace springnet::learning;

TEST_CASE("the node whose contact differs is found, whichever side lacks it") {
  const Touch on_first{0}, on_second{1};
  const Touches both{{2, on_first}, {5, on_second}}, one{{2, on_first}}, other{{2, on_first}, {5, on_first}};
  CHECK(differing_node(both, both) == std::nullopt);
  CHECK(differing_node(both, one) == 5u);
  CHECK(differing_node(one, both) == 5u);
  CHECK(differing_node(both, other) == 5u);
  CHECK(differing_node({}, both) == 2u);
}

TEST_CASE("an event has no derivative if its node was put elsewhere than the formula says, or got another velocity") {
  Network net;
  net.add_node(point({0, 0, 1}));
  net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  SimulationOptions options;
  options.time_step = 0.01;
  const Engine engine(net, *plugins(), options);
  const Contact& contact = engine.model().contact;
  LocatedEvent touch;
  touch.surface = 0;
  touch.own.after.surface = 0;
  touch.own.p = touch.own.next_p = {0.3, 0.1, 0.0};
  touch.own.v = {1.0, 0.0, -2.0};  // friction holds it
  const auto found = [&](const LocatedEvent& event) {
    return jump_of(contact, *contact.at(just_before(0.1, options.time_step)), event, options.time_step).has_value();
  };
  CHECK(found(touch));
  LocatedEvent elsewhere = touch;
  elsewhere.own.next_p.z() = 1e-4;
  CHECK_FALSE(found(elsewhere));
  LocatedEvent faster = touch;
  faster.own.next_v.x() = 0.5;
  CHECK_FALSE(found(faster));
}

TEST_CASE("a difference has the slope where it is asked for, not the mean with one that begins beside it") {
  const auto difference = [](const auto& function) {
    const auto at = [&](double h) { return std::optional<Eigen::VectorXd>(Eigen::VectorXd::Constant(1, function(h))); };
    return settled_difference(at, *at(0.0), 1e-3, 1.0);
  };
  const auto smooth = difference([](double h) { return std::sin(2.0 * h); });
  REQUIRE(smooth);
  CHECK((*smooth)[0] == doctest::Approx(2.0).epsilon(1e-9));
  const auto beside = difference([](double h) { return std::abs(h - 1e-5); });
  REQUIRE(beside);
  CHECK((*beside)[0] == doctest::Approx(-1.0).epsilon(1e-9));
  CHECK_FALSE(difference([](double h) { return std::abs(h); }));
}
