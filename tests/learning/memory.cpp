// Motions whose states do not fit the memory that they are given: the same bits, in that memory, and no more steps than
// the best plan makes.

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/motion_derivatives.hpp>

#include "motion_loss.hpp"
#include "refusal.hpp"

using namespace springnet;
using namespace springnet::testing;
using Eigen::VectorXd;
using Kind = LearnedValues::Kind;

namespace {

// A block that hangs from one of its corners and swings.
std::shared_ptr<const Network> swinging_net() {
  Network net;
  Lattice lattice;
  lattice.nodes = {2, 2, 3};
  lattice.diagonals = Diagonals::face;
  net.add_lattice("block", lattice, {}, net.add_material(damped(200.0, 0.5)));
  const MaterialIndex relaxing =
      net.add_material({LawUse{"maxwell", {{"stiffness", 50.0}, {"relaxation_time", 0.3}}}, std::nullopt});
  net.add_spring(0, 11, relaxing);
  net.add_spring(1, 10, relaxing);
  net.fix(0);
  net.set_gravity({0, 2, -9.0});
  return std::make_shared<const Network>(std::move(net));
}

// The fewest parts that are passed on the way back through `parts` of them with so many places: all plans are tried.
std::size_t fewest_passed(std::size_t parts, std::size_t places) {
  static std::map<std::pair<std::size_t, std::size_t>, std::size_t> known;
  if (parts < 2) return 0;
  if (places == 1) return parts * (parts - 1) / 2;
  std::size_t& result = known[{parts, places}];
  if (result > 0) return result;
  std::size_t best = parts * parts;
  for (std::size_t kept = 1; kept < parts; ++kept)
    best = std::min(best, kept + fewest_passed(kept, places) + fewest_passed(parts - kept, places - 1));
  return known[{parts, places}] = best;
}

struct Found {
  VectorXd gradient, along;
  double loss;
  MotionDerivatives::Kept after_adjoint, at_end;
};
Found find(std::size_t memory) {
  const auto net = swinging_net();
  const std::size_t springs = net->springs().size();
  MotionDerivatives motion(net, plugins(), method(0.5, newton, 0.01), 6.47,
                           {{Kind::spring_parameter, false, "stiffness", all(springs)},
                            {Kind::spring_parameter, false, "relaxation_time", {static_cast<SpringIndex>(springs - 1)}},
                            {Kind::mass, false, "", {3}},
                            {Kind::initial_velocity, false, "", {5}}});
  if (memory > 0) motion.set_memory(memory);
  const VectorXd values = motion.values_of_network();
  motion.run(values);
  REQUIRE(motion.step_count() == 647);
  const Loss loss(648, net->nodes().size());
  Found found;
  found.gradient = loss.gradient(motion);
  found.after_adjoint = motion.kept();
  found.loss = loss.of(motion);
  Eigen::MatrixXd changes = Eigen::MatrixXd::Ones(values.size(), 2);
  changes.col(1).head(4).setZero();
  found.along = loss.along(motion, changes);
  CHECK(loss.gradient(motion) == found.gradient);
  found.at_end = motion.kept();
  return found;
}

}  // namespace

TEST_CASE("a motion in little memory has the same derivatives, bit by bit, for the fewest steps that are made again") {
  const Found all_kept = find(0);
  CHECK(all_kept.at_end.states == 648);
  CHECK(all_kept.at_end.places == 0);
  CHECK(all_kept.at_end.steps_again == 0);
  std::size_t places_before = 1000;
  for (const std::size_t memory : {200'000U, 120'000U, 60'000U, 50'000U}) {
    CAPTURE(memory);
    const Found found = find(memory);
    CHECK(found.gradient == all_kept.gradient);
    CHECK(found.along == all_kept.along);
    CHECK(found.loss == all_kept.loss);
    const MotionDerivatives::Kept& kept = found.after_adjoint;
    CHECK(kept.part == 64);
    REQUIRE(kept.places >= 1);
    CHECK(kept.places < places_before);
    places_before = kept.places;
    CHECK(found.at_end.states == kept.part + 1);
    CHECK(found.at_end.saved <= kept.places);
    CHECK(found.at_end.states * (12 * 48 + 2 * 8) < memory);
    // The last part is at hand after the run, which passes all parts but that, and each other one is made once more
    // with its states, from the first of them on.
    const std::size_t parts = (648 + kept.part - 1) / kept.part;
    const std::size_t again =
        (fewest_passed(parts, kept.places) - (parts - 1)) * kept.part + (parts - 1) * (kept.part - 1);
    CHECK(kept.steps_again == again);
    // Two ways forwards, and another one back.
    CHECK(found.at_end.steps_again <= 2 * again + 2 * 647);
  }
  CHECK(places_before <= 3);
  const std::string said = refusal_of([] { static_cast<void>(find(20'000)); });
  CHECK(said.find("too few for the states of 64 steps in a row") != std::string::npos);
}

TEST_CASE("states of a motion in little memory are found in any order") {
  const auto net = swinging_net();
  MotionDerivatives motion(net, plugins(), method(1.0, newton, 0.01), 3.0, {{Kind::mass, false, "", {3}}});
  motion.run(motion.values_of_network());
  std::vector<Eigen::Matrix3Xd> positions;
  for (std::size_t k = 0; k <= 300; ++k) positions.push_back(motion.positions(k));
  motion.set_memory(60'000);
  motion.run(motion.values_of_network());
  Dice dice(4);
  for (int i = 0; i < 60; ++i) {
    const auto k = static_cast<std::size_t>(dice.between(0.0, 300.999));
    CAPTURE(k);
    CHECK(motion.positions(k) == positions[k]);
  }
  CHECK(motion.kept().saved <= motion.kept().places);
  CHECK_THROWS_AS(static_cast<void>(motion.positions(301)), Error);
}

namespace {

// Balls on soft springs that bounce in turn, with steps that are divided at each touch.
std::shared_ptr<const Network> bouncing() {
  Network net;
  const MaterialIndex soft = net.add_material(damped(2.0, 0.01));
  constexpr NodeIndex balls = 6;
  for (NodeIndex k = 0; k < balls; ++k) net.add_node(point({0.5 * k, 0, 0.3 + 0.17 * k}));
  for (NodeIndex k = 1; k < balls; ++k) net.add_spring(k - 1, k, soft);
  net.set_gravity({0, 0, -9.81});
  Plane floor;
  floor.friction = {Friction::Kind::none, 0.0};
  floor.restitution = 0.97;
  net.add_plane(floor);
  return std::make_shared<const Network>(std::move(net));
}

struct Bounced {
  VectorXd gradient;
  std::size_t touches;
  MotionDerivatives::Kept kept;
};
Bounced bounce_in(std::size_t memory) {
  SimulationOptions options = method(0.5, newton, 0.02);
  options.integrator.parameters["events"] = 1.0;
  const auto net = bouncing();
  MotionDerivatives motion(
      net, plugins(), options, 6.0,
      {{Kind::spring_parameter, false, "stiffness", all(net->springs().size())}, {Kind::mass, false, "", {0, 4}}});
  motion.set_memory(memory);
  motion.run(motion.values_of_network());
  const std::vector<Event> events = motion.events();
  const auto touches =
      std::count_if(events.begin(), events.end(), [](const Event& each) { return each.kind == Event::Kind::touched; });
  const Loss loss(motion.step_count() + 1, net->nodes().size());
  Bounced result{loss.gradient(motion), static_cast<std::size_t>(touches), {}};
  CHECK(loss.gradient(motion) == result.gradient);
  result.kept = motion.kept();
  return result;
}

}  // namespace

TEST_CASE("states within divided steps count in the memory that a motion is given") {
  const Bounced all_kept = bounce_in(std::size_t{1} << 30);
  REQUIRE(all_kept.touches > 40);
  CHECK(all_kept.kept.places == 0);
  CHECK(all_kept.kept.steps_again == 0);
  // Positions and velocities of six nodes.
  CHECK(all_kept.kept.bytes > (301 + all_kept.touches) * 48 * 6);
  const std::size_t whole = all_kept.kept.bytes;
  for (const std::size_t memory : {whole - 1, whole * 3 / 4, whole / 2}) {
    CAPTURE(memory);
    const Bounced found = bounce_in(memory);
    CHECK(found.gradient == all_kept.gradient);
    CHECK(found.kept.places >= 1);
    CHECK(found.kept.steps_again > 0);
    CHECK(found.kept.bytes <= memory);
  }
  // Enough for 64 states, and not for what the events in them add.
  const std::string said = refusal_of([&] { static_cast<void>(bounce_in(whole / 4)); });
  CAPTURE(said);
  CHECK(said.find("too few for the states of 64 steps in a row, with events until ") != std::string::npos);
  CHECK(said.find(" MiB, and more for later events") != std::string::npos);
}
