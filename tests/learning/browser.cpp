// learning.html in a headless Chromium: colours, values and motions against the result of the command that wrote it.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <springnet/scene.hpp>

#include "browser.hpp"
#include "nets.hpp"
#include "tool.hpp"

using namespace springnet;
using testing::TemporaryFolder;

namespace {

// A chain between two fixed nodes and a free end: the spring between the fixed ones is not determined.
std::string chain(double stiffness, double bending) {
  return fmt::format(R"(title = "a <b>chain</b>"
[simulation]
duration = 0.4
time_step = 0.02
integrator = {{ name = "recurrent", theta = 0.5, force_tolerance = 1e-9 }}
[gravity]
acceleration = [0, 1, -9.81]
[[body]]
name = "chain"
nodes = [[0, 0, 0], [1, 0, 0], [2, 0, 0.1], [3, 0.2, 0], [4, 0, 0], [5, 0, 0]]
springs = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]]
neuron = {{ type = "point_mass", mass = 2.0 }}
spring = {{ type = "linear", stiffness = {} }}
viscosity = {{ type = "linear", damping = 1.0 }}
[[element]]
name = "bends"
invariant = "angle"
body = "chain"
nodes = [[1, 2, 3], [2, 3, 4]]
spring = {{ type = "linear", stiffness = {} }}
[[fix]]
select = {{ body = "chain", nodes = [0, 1] }}
[output]
interval = 0.02
)",
                     stiffness, bending);
}

// Positions of free nodes, off by some hundredths of a millimetre; node 3 has none in each third record, and once x
// alone.
struct Seen {
  std::string table = "time,node,x,y,z\n";
  std::map<std::pair<int, int>, Vector3> places;  // by record and node: those that are complete
};
Seen observe(const Scene& real) {
  Seen seen;
  Simulation simulation(real.network, testing::plugins(), real.options);
  for (int record = 1; record <= 20; ++record) {
    simulation.step();
    for (int node = 2; node < 6; ++node) {
      if (node == 3 && record % 3 == 0) continue;
      const Vector3 off(std::sin(7.0 * record + node), std::cos(5.0 * record - node), std::sin(3.0 * record * node));
      const Vector3 place = simulation.position(static_cast<NodeIndex>(node)) + 3e-5 * off;
      const bool partly = node == 3 && record == 4;
      seen.table += fmt::format("{},{},{},{},{}\n", simulation.time(), node, place.x(),
                                partly ? "" : fmt::format("{}", place.y()), partly ? "" : fmt::format("{}", place.z()));
      if (!partly) seen.places[{record, node}] = place;
    }
  }
  return seen;
}

// Tables of what else can be observed: two velocities and a force at one time; and what is held out, node 3 at records
// that `observe` leaves out.
struct Beside {
  std::string velocities = "time,node,vx,vy,vz\n", forces = "time,node,rx,ry,rz,weight\n0.2,1,3,0,4,1e-12\n";
  std::string held_out = "time,node,x,y,z\n";
  Vector3 velocity, held;  // of node 4 after 10 records; of node 3 after 18
};
Beside observe_beside(const Scene& real) {
  Beside beside;
  Simulation simulation(real.network, testing::plugins(), real.options);
  for (int record = 1; record <= 18; ++record) {
    simulation.step();
    if (record == 10) {
      beside.velocity = simulation.velocity(4);
      for (int node = 4; node < 6; ++node) {
        const Vector3 v = simulation.velocity(static_cast<NodeIndex>(node));
        beside.velocities += fmt::format("{},{},{},{},{}\n", simulation.time(), node, v.x(), v.y(), v.z());
      }
    }
    if (record != 10 && record != 18) continue;
    beside.held = simulation.position(record == 18 ? 3 : 2);
    if (record == 18)
      beside.held_out +=
          fmt::format("{},3,{},{},{}\n", simulation.time(), beside.held.x(), beside.held.y(), beside.held.z());
  }
  return beside;
}

using Colour = std::array<double, 3>;
const std::vector<Colour> of_values{{68, 1, 84},    {62, 74, 137},  {38, 130, 142},
                                    {53, 183, 121}, {160, 218, 57}, {253, 221, 30}};
const std::vector<Colour> of_ratios{{24, 60, 160}, {40, 150, 220}, {232, 216, 130}, {240, 120, 50}, {150, 10, 40}};
Colour colour_at(const std::vector<Colour>& stops, double share) {
  const double place = share * static_cast<double>(stops.size() - 1);
  const auto lower = std::min(static_cast<std::size_t>(place), stops.size() - 2);
  Colour result{};
  for (std::size_t c = 0; c < 3; ++c)
    result[c] = stops[lower][c] + (place - static_cast<double>(lower)) * (stops[lower + 1][c] - stops[lower][c]);
  return result;
}

// A table has 256 colours, in whole numbers: one is off by half a step, and what is cut off.
void check_colour(const nlohmann::json& drawn, std::size_t place, const Colour& expected) {
  REQUIRE(drawn.size() >= 3 * place + 3);
  for (std::size_t c = 0; c < 3; ++c) CHECK(std::abs(drawn[3 * place + c].get<double>() - expected[c]) <= 2.0);
}

std::vector<nlohmann::json> values_of(const nlohmann::json& result, const std::string& kind, bool of_elements) {
  std::vector<nlohmann::json> found;
  for (const auto& each : result["parameters"])
    if (each["kind"] == kind && each.contains("element") == of_elements) found.push_back(each);
  return found;
}

bool has(const nlohmann::json& text, const std::string& part) {
  return text.get<std::string>().find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("learning.html shows the values, the intervals and the motions of the result") {
  const TemporaryFolder folder;
  folder.write("real.toml", chain(400, 20));
  folder.write("guess.toml", chain(300, 25));
  const Seen seen = observe(load_scene(folder.path() / "real.toml", *testing::plugins()));
  folder.write("seen.csv", seen.table);
  const testing::Answer answer =
      testing::springnet(folder,
                         "learn guess.toml --observations seen.csv --parameters "
                         "spring.stiffness,mass:together,element.spring.stiffness -o out --json");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  const nlohmann::json result = answer.json();
  const auto stiffnesses = values_of(result, "spring", false), masses = values_of(result, "mass", false);
  const auto bends = values_of(result, "spring", true);
  REQUIRE(stiffnesses.size() == 5);
  REQUIRE(masses.size() == 6);  // of the fixed nodes, too
  REQUIRE(bends.size() == 2);
  REQUIRE(stiffnesses[0]["upper"].is_null());
  for (std::size_t k = 1; k < 5; ++k) REQUIRE(stiffnesses[k]["upper"].is_number());

  const std::string address = "file://" + (folder.path() / "out/learning.html").string() + "#selftest=1";
  const testing::Visit page = testing::visit(folder, address, "--dump-dom");
  CHECK(testing::console(page.log) == "");
  const nlohmann::json found = testing::element(page.dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  CHECK(page.dom.find("<b>chain") == std::string::npos);
  const nlohmann::json& learned = found["learned"];
  CHECK(learned["first"] == "learned0.value");
  CHECK(learned["paints"].size() == 12);
  CHECK(learned["below"].get<int>() >= 8);

  // Stiffnesses: those with an interval in their colours, the others dashed and grey.
  const nlohmann::json& paint = learned["paints"]["spring.stiffness, learned (N/m)"];
  std::vector<double> known;
  for (const auto& each : stiffnesses)
    if (each["upper"].is_number()) known.push_back(each["value"]);
  const double low = *std::min_element(known.begin(), known.end()),
               high = *std::max_element(known.begin(), known.end());
  REQUIRE(low > high / 30.0);  // else the colours are by the logarithm
  REQUIRE(paint["springs"].size() == 3 * known.size());
  CHECK(paint["open"] == 5 - known.size());
  for (std::size_t k = 0; k < known.size(); ++k)
    check_colour(paint["springs"], k, colour_at(of_values, (known[k] - low) / (high - low)));
  CHECK(has(paint["legend"], "spring.stiffness, learned, N/m"));
  CHECK(has(paint["legend"], fmt::format("grey, dashed: {} of 5 not determined", 5 - known.size())));
  CHECK(std::stod(paint["ticks"][0].get<std::string>()) == doctest::Approx(low).epsilon(5e-3));
  CHECK(std::stod(paint["ticks"][2].get<std::string>()) == doctest::Approx(high).epsilon(5e-3));
  CHECK(paint["bar"].get<int>() > 0);
  // By ratio to the start; by the width of the interval; by the share that is determined.
  const nlohmann::json& ratio = learned["paints"]["spring.stiffness, ratio to the start"];
  const double reach = std::max(std::log(high / 300.0), -std::log(low / 300.0));
  for (std::size_t k = 0; k < known.size(); ++k)
    check_colour(ratio["springs"], k, colour_at(of_ratios, 0.5 + 0.5 * std::log(known[k] / 300.0) / reach));
  const nlohmann::json& width = learned["paints"]["spring.stiffness, half width of the interval (% of the value)"];
  std::vector<double> widths;
  for (const auto& each : stiffnesses)
    if (each["upper"].is_number())
      widths.push_back(50.0 * (each["upper"].get<double>() - each["lower"].get<double>()) /
                       each["value"].get<double>());
  const double widest = *std::max_element(widths.begin(), widths.end());
  const double narrowest = *std::min_element(widths.begin(), widths.end());
  for (std::size_t k = 0; k < widths.size(); ++k)
    check_colour(
        width["springs"], k,
        colour_at(of_values, widest > 30.0 * narrowest ? std::log(widths[k] / narrowest) / std::log(widest / narrowest)
                                                       : widths[k] / widest));
  const nlohmann::json& share = learned["paints"]["spring.stiffness, determined by the data (% of the value)"];
  CHECK(share["open"] == 0);
  for (std::size_t k = 0; k < 5; ++k)
    check_colour(share["springs"], k, colour_at(of_values, stiffnesses[k]["determined"].get<double>()));

  // Masses at nodes, and stiffnesses of angles at the middles of their nodes.
  const nlohmann::json& nodes = learned["paints"]["mass, determined by the data (% of the value)"]["nodes"];
  for (const auto& each : masses)
    check_colour(nodes, each["node"].get<std::size_t>(), colour_at(of_values, each["determined"].get<double>()));
  const nlohmann::json& elements =
      learned["paints"]["element.spring.stiffness, determined by the data (% of the value)"]["elements"];
  REQUIRE(elements.size() == 6);
  for (std::size_t k = 0; k < 2; ++k)
    check_colour(elements, k, colour_at(of_values, bends[k]["determined"].get<double>()));

  // The motions, and what was observed.
  const Scene before = load_scene(folder.path() / "guess.toml", *testing::plugins());
  const Scene after = load_scene(folder.path() / "out/learned.toml", *testing::plugins());
  for (std::size_t k = 0; k < 3; ++k) {
    const nlohmann::json& record = learned["records"][k];
    const auto number = static_cast<int>(10 * k);
    CHECK(record["time"].get<double>() == doctest::Approx(0.02 * number));
    for (const bool is_start : {true, false}) {
      const Scene& scene = is_start ? before : after;
      Simulation simulation(scene.network, testing::plugins(), scene.options);
      if (number > 0) simulation.advance_to(0.02 * number);
      const std::vector<double> places = record[is_start ? "start" : "learned"];
      REQUIRE(places.size() == 18);
      for (NodeIndex node = 0; node < 6; ++node)
        for (int axis = 0; axis < 3; ++axis)
          CHECK(std::abs(places[3 * node + static_cast<std::size_t>(axis)] - simulation.position(node)[axis]) < 2e-6);
    }
    std::size_t place = 0;
    for (int node = 0; node < 6; ++node) {
      const auto at = seen.places.find({number, node});
      if (at == seen.places.end()) continue;
      REQUIRE(record["nodes"].size() > place);
      CHECK(record["nodes"][place] == node);
      for (std::size_t axis = 0; axis < 3; ++axis)
        CHECK(std::abs(record["observed"][3 * place + axis].get<double>() -
                       at->second[static_cast<Eigen::Index>(axis)]) < 2e-6);
      ++place;
    }
    CHECK(record["nodes"].size() == place);
  }
  for (const auto& changed : learned["toggled"]) CHECK(changed.get<int>() > 50);

  // What a click tells.
  const std::string about = learned["spring"].dump();
  CHECK(has(learned["spring"].dump(), "none: not determined"));
  CHECK(about.find("\"at the start\",\"300 N/m\"") != std::string::npos);
  CHECK(about.find(fmt::format("\"spring.stiffness\",\"{:.5g} N/m\"", stiffnesses[4]["value"].get<double>())) !=
        std::string::npos);
  CHECK(learned["node"].dump().find(fmt::format("\"mass\",\"{:.5g} kg\"", masses[5]["value"].get<double>())) !=
        std::string::npos);
  CHECK(learned["element"].dump().find(fmt::format("\"element.spring.stiffness\",\"{:.5g}",
                                                   bends[0]["value"].get<double>())) != std::string::npos);
  CHECK(has(found["notes"].dump(), "1 observed positions lack a coordinate"));
}

TEST_CASE("learning.html shows several experiments, velocities, forces, what was held out and the share of the guess") {
  const TemporaryFolder folder;
  folder.write("real.toml", chain(400, 20));
  folder.write("guess.toml", chain(300, 25));
  std::string lifted = chain(300, 25), real_lifted = chain(400, 20);
  for (std::string* const each : {&lifted, &real_lifted}) {
    each->replace(each->find("a <b>chain</b>"), 14, "the chain, lifted");
    each->replace(each->find("[0, 1, -9.81]"), 13, "[0, 1, 6]");
  }
  folder.write("lifted.toml", lifted);
  folder.write("real_lifted.toml", real_lifted);
  const Scene real = load_scene(folder.path() / "real.toml", *testing::plugins());
  const Beside beside = observe_beside(real);
  folder.write("seen.csv", observe(real).table);
  folder.write("velocities.csv", beside.velocities);
  folder.write("forces.csv", beside.forces);
  folder.write("held_out.csv", beside.held_out);
  folder.write("seen_lifted.csv", observe(load_scene(folder.path() / "real_lifted.toml", *testing::plugins())).table);
  const testing::Answer answer = testing::springnet(
      folder,
      "learn guess.toml --observations seen.csv velocities.csv forces.csv --experiment lifted.toml=seen_lifted.csv "
      "--held-out held_out.csv --guess-weight 0.01 --parameters spring.stiffness,viscosity.damping:together -o out "
      "--json");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  const auto stiffnesses = values_of(answer.json(), "spring", false);
  const std::string address = "file://" + (folder.path() / "out/learning.html").string();
  const auto look = [&](const std::string& after) {
    const testing::Visit page = testing::visit(folder, address + "#selftest=1" + after, "--dump-dom");
    CHECK(testing::console(page.log) == "");
    nlohmann::json found = testing::element(page.dom, "selftest");
    CHECK(found["errors"] == nlohmann::json::array());
    return found;
  };
  const nlohmann::json found = look("");
  const nlohmann::json& learned = found["learned"];
  CHECK(learned["experiments"] == nlohmann::json({"1: a <b>chain</b>", "2: the chain, lifted"}));
  CHECK(learned["motions"]["shown"] == 1);

  // The share of the guess: all of the spring between fixed nodes, which nothing that moves depends on.
  const nlohmann::json& paint = learned["paints"]["spring.stiffness, from the guess (% of the value)"];
  CHECK(paint["open"] == 0);
  CHECK_FALSE(has(paint["legend"], "not determined"));
  REQUIRE(paint["springs"].size() == 15);
  for (std::size_t k = 0; k < 5; ++k)
    check_colour(paint["springs"], k, colour_at(of_values, stiffnesses[k]["from_guess"].get<double>()));
  CHECK(stiffnesses[0]["from_guess"].get<double>() > stiffnesses[4]["from_guess"].get<double>());

  // In the middle record, velocities and the force at the nodes; what was held out in the record next to it alone.
  const nlohmann::json& middle = learned["records"][1];
  const auto kinds_in = [](const nlohmann::json& record, int kind) {
    return std::count(record["kinds"].begin(), record["kinds"].end(), kind);
  };
  CHECK(kinds_in(middle, 0) == 4);
  CHECK(kinds_in(middle, 1) == 2);
  CHECK(kinds_in(middle, 2) == 1);
  CHECK(kinds_in(middle, 4) == 0);
  const auto check_arrow = [&](const nlohmann::json& arrow, std::size_t node, const Vector3& vector,
                               const Colour& colour) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto component = static_cast<Eigen::Index>(axis);
      CHECK(std::abs(arrow["direction"][axis].get<double>() - vector.normalized()[component]) < 1e-5);
      CHECK(arrow["place"][axis] == middle["learned"][3 * node + axis]);
      CHECK(arrow["colour"][axis] == colour[axis]);
    }
  };
  REQUIRE(middle["arrows"][0].size() == 2);
  REQUIRE(middle["arrows"][1].size() == 1);
  check_arrow(middle["arrows"][0][0], 4, beside.velocity, {0, 110, 170});
  check_arrow(middle["arrows"][1][0], 1, {3, 0, 4}, {170, 70, 0});
  CHECK(has(found["legend"], "longest observed force 5 N"));
  for (const char* const what : {"held_out", "velocities", "reactions"}) CHECK(learned["toggled_of"].contains(what));
  CHECK(has(found["key"], "held out"));
  CHECK(has(found["notes"].dump(), "1 observed positions lack a coordinate"));

  // The other experiment, by the address: its own motions, and nothing of the first one.
  const nlohmann::json other = look("&experiment=2");
  CHECK(other["learned"]["motions"]["shown"] == 2);
  CHECK(has(other["facts"], "21 records"));
  const nlohmann::json& last = other["learned"]["records"][2];
  CHECK(kinds_in(last, 0) == 4);
  CHECK_FALSE(has(other["key"], "held out"));
  CHECK(other["learned"]["toggled_of"].empty());
  Scene after = load_scene(folder.path() / "lifted.toml", *testing::plugins());
  Simulation before(after.network, testing::plugins(), after.options);
  before.advance_to(0.4);
  for (NodeIndex node = 0; node < 6; ++node)
    for (int axis = 0; axis < 3; ++axis)
      CHECK(std::abs(last["start"][3 * node + static_cast<std::size_t>(axis)].get<double>() -
                     before.position(node)[axis]) < 2e-6);
  CHECK(last["learned"][17].get<double>() > 0.05);  // the end of the chain, upwards
  // What is hidden by the address.
  const nlohmann::json hidden = look("&velocities=0&held_out=0&color=spring.stiffness:from_guess");
  CHECK(hidden["learned"]["records"][1]["arrows"][0].empty());
  CHECK(hidden["learned"]["records"][1]["arrows"][1].size() == 1);
  CHECK(hidden["learned"]["first"] == "learned0.from_guess");
}
