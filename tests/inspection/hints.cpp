// Likely mistakes are told of, and scenes without them raise no hint.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/inspection.hpp>

#include "nets.hpp"

using namespace springnet;
using testing::plugins;

namespace {

using HintKind = Hint::Kind;

// 4 x 4 x 4 nodes of 0.1 m in all, 1 kg, as soft as flesh.
struct Block {
  double size = 0.1;     // m
  double mass = 1.0;     // kg
  double modulus = 1e4;  // N/m^2

  [[nodiscard]] Network net() const {
    Network net;
    const double spacing = size / 3.0;
    net.add_lattice("block", {.nodes = {4, 4, 4}, .spacing = Vector3::Constant(spacing), .diagonals = Diagonals::all},
                    {.mass = mass / 64.0}, net.add_material(testing::damped(modulus * spacing, 0.0)));
    return net;
  }
};

std::vector<Hint> hints_of(const Network& net, const InspectionOptions& options = {}) {
  return inspect(net, *plugins(), options).hints;
}

// The text of the only hint, if it is of that kind.
std::string only(const std::vector<Hint>& hints, HintKind kind) {
  return hints.size() == 1 && hints.front().kind == kind ? hints.front().text : fmt::format("{} hints", hints.size());
}

bool has(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return true;
  MESSAGE(text);
  return false;
}

}  // namespace

TEST_CASE("an ordinary block raises no hint, in its right size from 2 mm to 8 m") {
  CHECK(hints_of(Block().net()).empty());
  CHECK(hints_of(Block{0.002, 8e-6}.net()).empty());
  CHECK(hints_of(Block{8.0, 5e5}.net()).empty());
  CHECK(hints_of(Block{200.0, 5e5, 1e9}.net()).empty());  // a bridge
}

TEST_CASE("a size in millimetres, taken as metres, and the mass that follows from it") {
  const auto hints = hints_of(Block{200.0, 8e9}.net());
  REQUIRE(hints.size() == 2);
  CHECK(hints[0].kind == HintKind::size);
  CHECK(has(hints[0].text, "'block'"));
  CHECK(has(hints[0].text, "200 m"));
  CHECK(has(hints[0].text, "mesh.scale = 0.001"));
  CHECK(hints[1].kind == HintKind::mass);
  CHECK(has(hints[1].text, "8e+09 kg"));
}

TEST_CASE("a size below a millimetre") {
  CHECK(has(only(hints_of(Block{2e-4, 8e-9}.net()), HintKind::size), "is 0.2 mm large"));
}

TEST_CASE("masses that no material has in so little room") {
  CHECK(has(only(hints_of(Block{0.01, 64.0}.net()), HintKind::density), "6.4e+07 kg/m^3"));
  // A sheet and a chain have no volume to compare with.
  Network sheet;
  sheet.add_lattice("sheet", {.nodes = {5, 5, 1}, .spacing = Vector3::Constant(0.01)}, {.mass = 1.0},
                    sheet.add_material(testing::damped(10.0, 0.0)));
  CHECK(hints_of(sheet).empty());
}

TEST_CASE("gravity in millimetres") {
  Network net = Block().net();
  net.fix(0);
  net.set_gravity({0, 0, -9.81});
  CHECK(hints_of(net).empty());
  net.set_gravity({0, 0, -9810});
  CHECK(has(only(hints_of(net), HintKind::gravity), "9810 m/s^2"));
}

TEST_CASE("nodes behind planes and inside instruments at the start, where they are at that time") {
  Network net = Block().net();
  const auto plane = [](double height) {
    Plane result;
    result.name = "floor";
    result.point = {0, 0, height};
    return result;
  };
  Network above = net;
  above.add_plane(plane(0.0));  // on it: touching is allowed
  CHECK(hints_of(above).empty());
  Network behind = net;
  behind.add_plane(plane(0.04));
  CHECK(has(only(hints_of(behind), HintKind::start),
            "32 nodes are behind plane 'floor' (number 0) at the start, node 0 by 0.04 m"));
  for (NodeIndex k = 0; k < 32; ++k) behind.fix(k);  // a surface does not see them
  CHECK(hints_of(behind).empty());

  Instrument ball;
  ball.first = ball.second = {0.0, 0.0, 0.2};
  ball.radius = 0.01;
  ball.motion = Motion{};
  ball.motion->times = {0.0, 1.0};
  ball.motion->displacements = {Vector3(0, 0, -0.105), Vector3::Zero()};  // at the start in the upper corner
  net.add_instrument(ball);
  CHECK(has(only(hints_of(net), HintKind::start), "1 node is inside instrument 0 at the start, node 48 by 0.005 m"));
}

TEST_CASE("what falls for ever, and what does not") {
  InspectionOptions options;
  options.duration = 2.0;
  Network falling = Block().net();
  falling.set_gravity({0, 0, -9.81});
  const std::string text = only(hints_of(falling, options), HintKind::fall);
  CHECK(has(text, "1 part falls freely (the largest from node 0, 64 nodes), 19.6 m in 2 s"));
  CHECK_FALSE(hints_of(falling).empty());
  options.duration = 0.1;  // 5 cm of its 10: a moment's flight
  CHECK(hints_of(falling, options).empty());
  options.duration = 2.0;

  Network held = falling;
  held.fix(0);
  CHECK(hints_of(held, options).empty());
  Network landing = falling;
  landing.add_plane({.name = "floor", .point = {0, 0, -1}});
  CHECK(hints_of(landing, options).empty());
  Network beside = falling;
  beside.add_plane({.name = "wall", .point = {-1, 0, 0}, .normal = {1, 0, 0}});
  CHECK(only(hints_of(beside, options), HintKind::fall) == text);
  Network in_space = Block().net();
  CHECK(hints_of(in_space, options).empty());
}

TEST_CASE("the slowest vibration is that of closed forms") {
  // A mass on a spring; a chain between walls; a block that flies, whose rigid motions are left out.
  const auto mass_on_spring = inspect(testing::oscillator(testing::damped(4.0, 0.4), 1.0, 0.0), *plugins()).slowest;
  REQUIRE(mass_on_spring);
  const double pi = std::acos(-1.0);
  CHECK(mass_on_spring->period == doctest::Approx(2.0 * pi / 2.0).epsilon(1e-3));
  CHECK(mass_on_spring->damping_ratio == doctest::Approx(0.4 / (2.0 * 2.0)).epsilon(1e-3));

  // Ten masses of 2 kg in a row, 5 N/m: the ends free, w = 2 sqrt(k/m) sin(pi / 20). Across nothing resists.
  Network chain = testing::chain(10, Vector3::Zero(), Vector3::UnitX(), testing::damped(5.0, 0.0), 2.0);
  const auto slowest = inspect(chain, *plugins()).slowest;
  REQUIRE(slowest);
  CHECK(slowest->period == doctest::Approx(2.0 * pi / (2.0 * std::sqrt(2.5) * std::sin(pi / 20.0))).epsilon(2e-3));
  CHECK(slowest->damping_ratio == 0.0);
}

TEST_CASE("time steps that are too long for the slowest vibration, unless it is damped out") {
  const auto hints = [](double time_step, double damping, bool own_steps = false) {
    InspectionOptions options;
    options.time_step = time_step;
    options.adaptive_steps = own_steps;
    return hints_of(testing::oscillator(testing::damped(4.0, damping), 1.0, 0.0), options);
  };
  CHECK(hints(0.3, 0.0).empty());  // a period of 3.14 s
  const std::string text = only(hints(0.5, 0.0), HintKind::time_step);
  CHECK(has(text, "a period of 3.14 s, 6.3 time steps"));
  CHECK(has(text, "time_step of 0.2 s"));
  CHECK(hints(0.5, 3.0).empty());        // damping ratio 0.75
  CHECK(hints(0.5, 0.0, true).empty());  // CVODE divides it
}

TEST_CASE("linear tables that look sampled are told of, not those of a few entries or an even pace") {
  // A quarter of a sine in steps of 0.1 s: a smooth motion that was sampled.
  Motion sampled;
  sampled.interpolation = Motion::Interpolation::linear;
  for (int k = 0; k <= 10; ++k) {
    sampled.times.push_back(0.1 * k);
    sampled.displacements.emplace_back(0, 0, std::sin(0.157 * k));
  }
  const auto with_plane = [](const Motion& motion) {
    Network net = Block().net();
    net.add_plane({.name = "plate", .point = {0, 0, -9}, .motion = motion});
    return hints_of(net);
  };
  const std::string text = only(with_plane(sampled), HintKind::kinks);
  CHECK(
      has(text, "The motion of plane 'plate' (number 0) is a linear table: its velocity jumps at 9 of its 11 entries"));
  // sin(0.157 k) bends most at the end: 4 sin^2(0.157 / 2) sin(0.157 * 9) / 0.1 s.
  CHECK(has(text, "by up to 0.243 m/s"));
  CHECK(has(text, "interpolation = \"smooth\""));
  Motion smooth = sampled;
  smooth.interpolation = Motion::Interpolation::smooth;
  CHECK(with_plane(smooth).empty());
  Motion by_hand = sampled;  // up, and down again
  by_hand.times.resize(3);
  by_hand.displacements = {Vector3::Zero(), Vector3::UnitZ(), Vector3::Zero()};
  CHECK(with_plane(by_hand).empty());
  Motion even = sampled;
  for (std::size_t k = 0; k < even.times.size(); ++k) even.displacements[k] = 0.3 * even.times[k] * Vector3::UnitZ();
  CHECK(with_plane(even).empty());

  Network moved = Block().net();
  moved.add_move({{0}, sampled});
  CHECK(has(only(hints_of(moved), HintKind::kinks), "The motion of the nodes of move 0"));
  Network turned = Block().net();
  Instrument ball;
  ball.first = ball.second = {0, 0, -9};
  ball.turn.emplace();
  ball.turn->interpolation = Motion::Interpolation::linear;
  ball.turn->times = {0, 1, 2, 3};
  ball.turn->angles = {0, 1, 0, 1};
  turned.add_instrument(ball);
  CHECK(has(only(hints_of(turned), HintKind::kinks),
            "The turn of instrument 0 is a linear table: its velocity jumps at 2 of"
            " its 4 entries, by up to 2 rad/s"));
}

TEST_CASE("hints and the slowest vibration are in the JSON") {
  InspectionOptions options;
  options.time_step = 0.5;
  const auto json = nlohmann::json::parse(
      to_json(inspect(testing::oscillator(testing::damped(4.0, 0.0), 1.0, 0.0), *plugins(), options)));
  CHECK(json["slowest_vibration"]["time_steps_a_period"].get<double>() == doctest::Approx(6.283).epsilon(1e-3));
  REQUIRE(json["hints"].size() == 1);
  CHECK(json["hints"][0]["kind"] == "time step");
  CHECK(json["hints"][0]["text"].get<std::string>().starts_with("The slowest vibration"));
}
