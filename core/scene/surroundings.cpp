#include <algorithm>

#include <fmt/format.h>

#include "network/checks.hpp"
#include "scene/parts.hpp"
#include "scene/select.hpp"
#include "scene/shape.hpp"
#include "scene/time_table.hpp"
#include "text/grouped.hpp"

namespace springnet::scene {
namespace {

void read_sinusoid(const Table& table, Motion& motion) {
  const Value amplitude = table.need("amplitude");
  motion.amplitude = amplitude.vector();
  if (motion.amplitude.isZero(0)) amplitude.fail("must not be zero in all directions; nothing would move");
  motion.frequency = table.need("frequency").number_above_0("Hz");
  if (const auto phase = table.find("phase")) motion.phase = phase->number();
}

void read_window(const Table& table, double& from, double& until) {
  if (const auto given = table.find("from")) from = given->number();
  if (const auto given = table.find("until")) {
    until = given->number();
    if (!(from < until)) {
      given->fail(fmt::format("must be above 'from', {}, is {}", checks::seconds(from), checks::seconds(until)));
    }
  }
}

// The keys of a motion, those of [[move]] or of a table `motion`.
Motion read_motion(const Table& table) {
  Motion motion;
  if (const auto rows = table.find("table")) {
    refuse_beside(table, {"sinusoid", "from", "until"}, "table");
    read_time_table(*rows, "[t, x, y, z]", 4, [&](double time, const std::vector<Value>& numbers) {
      motion.times.push_back(time);
      motion.displacements.emplace_back(numbers[1].number(), numbers[2].number(), numbers[3].number());
    });
    motion.interpolation = read_interpolation(table);
    return motion;
  }
  const auto sinusoid = table.find("sinusoid");
  if (!sinusoid) {
    table.fail(
        "does not say how it moves; add table = [[t, x, y, z], …], or sinusoid = { amplitude = …, frequency = … }");
  }
  refuse_beside(table, {"interpolation"}, "sinusoid");
  read_sinusoid(sinusoid->table(fmt::format("{}.sinusoid", table.schema())), motion);
  read_window(table, motion.from, motion.until);
  return motion;
}

Turn read_turn(const Table& table) {
  Turn turn;
  turn.axis = table.need("axis").direction();
  if (const auto through = table.find("through")) turn.through = through->vector();
  const auto rows = table.find("table"), rate = table.find("rate");
  if (rows) {
    refuse_beside(table, {"rate", "from", "until"}, "table");
    read_time_table(*rows, "[t, angle]", 2, [&](double time, const std::vector<Value>& numbers) {
      turn.times.push_back(time);
      turn.angles.push_back(numbers[1].number());
    });
    turn.interpolation = read_interpolation(table);
    return turn;
  }
  if (!rate) table.fail("does not say how it turns; add rate = …, in rad/s, or table = [[t, angle], …], in rad");
  refuse_beside(table, {"interpolation"}, "rate");
  turn.rate = rate->number();
  if (turn.rate == 0) rate->fail("must not be 0 rad/s; nothing would turn");
  read_window(table, turn.from, turn.until);
  return turn;
}

Friction read_friction(const Value& value) {
  if (value.is_number()) return {Friction::Kind::coulomb, value.number_from_0("")};
  if (!value.is_text()) value.wrong_type("'held', 'none' or a coefficient of friction");
  return {
      value.choice({"held", "none"}, "a coefficient of friction") == 0 ? Friction::Kind::held : Friction::Kind::none,
      0.0};
}

// The keys common to planes, instruments and contacts of bodies.
template <class Contact>
void read_touch(const Table& table, Contact& contact) {
  if (const auto name = table.find("name")) contact.name = name->text();
  if (const auto friction = table.find("friction")) contact.friction = read_friction(*friction);
  if (const auto restitution = table.find("restitution")) {
    contact.restitution = restitution->number_from_0("");
    if (contact.restitution > 1) {
      restitution->fail(
          fmt::format("must be at most 1, is {}; 1 gives a node all of its speed back", contact.restitution));
    }
  }
}

template <class PlaneOrInstrument>
void read_obstacle(const Table& table, PlaneOrInstrument& obstacle) {
  read_touch(table, obstacle);
  if (const auto motion = table.find("motion")) obstacle.motion = read_motion(motion->table("motion"));
  if (const auto turn = table.find("turn")) obstacle.turn = read_turn(turn->table("turn"));
}

void read_move(const Table& table, Network& network) {
  if (table.has("tracks")) return;
  if (const auto body = table.find("body")) body->fail("is for 'tracks'; name the body in 'select'");
  const Value selection = table.need("select");
  const Move move{select_nodes(selection, network), read_motion(table)};
  selection.at_this_place([&] { network.add_move(move); });
}

void read_contact(const Table& table, Network& network) {
  BodyContact contact;
  const Value between = table.need("between");
  const std::vector<Value> sides = between.elements();
  if (sides.empty() || sides.size() > 2) {
    between.fail(
        fmt::format("must have one or two selections of nodes, has {}; one: of nodes with each other", sides.size()));
  }
  contact.first = select_nodes(sides[0], network);
  if (sides.size() == 2) contact.second = select_nodes(sides[1], network);
  read_touch(table, contact);
  table.value().at_this_place([&] { network.add_contact(contact); });
}

void read_plane(const Table& table, Network& network) {
  Plane plane;
  plane.point = table.need("point").vector();
  const Value normal = table.need("normal");
  plane.normal = normal.vector();
  if (plane.normal.isZero(0)) normal.fail("must not be zero; it points to the free side");
  read_obstacle(table, plane);
  table.value().at_this_place([&] { network.add_plane(plane); });
}

void read_box(const Table& table, Instrument& instrument) {
  BoxShape& box = instrument.box.emplace();
  instrument.first = instrument.second = table.need("center").vector();
  const std::vector<Value> sides = table.need("size").elements(3);
  for (std::size_t k = 0; k < 3; ++k) box.size[static_cast<Eigen::Index>(k)] = sides[k].number_above_0("m");
  if (const auto rotation = table.find("rotation")) {
    refuse_beside(table, {"axes"}, "rotation");
    box.axes = read_rotation(rotation->table("instrument.box.rotation"));
  }
  if (const auto axes = table.find("axes")) {
    const std::vector<Value> columns = axes->elements(3);
    for (std::size_t k = 0; k < 3; ++k) box.axes.col(static_cast<Eigen::Index>(k)) = columns[k].vector();
  }
  if (const auto radius = table.find("radius")) {
    box.radius = radius->number_from_0("m");
    if (const double most = box.size.minCoeff() / 2; box.radius > most) {
      radius->fail(fmt::format("must be at most {:g} m, half the smallest size, is {} m", most, box.radius));
    }
  }
}

void read_instrument(const Table& table, Network& network) {
  Instrument instrument;
  const auto sphere = table.find("sphere"), capsule = table.find("capsule"), box = table.find("box");
  if (sphere.has_value() + capsule.has_value() + box.has_value() != 1) {
    table.fail(
        "needs one of sphere = { center = [x, y, z], radius = … }, capsule = { from = [x, y, z], to = [x, y, z], "
        "radius = … } and box = { center = [x, y, z], size = [x, y, z] }");
  }
  if (sphere) {
    const Table shape = sphere->table("instrument.sphere");
    instrument.first = instrument.second = shape.need("center").vector();
    instrument.radius = shape.need("radius").number_above_0("m");
  } else if (capsule) {
    const Table shape = capsule->table("instrument.capsule");
    instrument.first = shape.need("from").vector();
    instrument.second = shape.need("to").vector();
    instrument.radius = shape.need("radius").number_above_0("m");
  } else {
    read_box(box->table("instrument.box"), instrument);
  }
  read_obstacle(table, instrument);
  table.value().at_this_place([&] { network.add_instrument(instrument); });
}

// Every node is compared with every plane and instrument, in each sweep.
void check_count(const std::vector<Value>& planes, const std::vector<Value>& instruments, std::size_t nodes) {
  constexpr std::size_t most = 10'000, max_comparisons = 100'000'000;
  const std::size_t count = planes.size() + instruments.size();
  const std::size_t allowed = std::min(most, max_comparisons / std::max<std::size_t>(nodes, 1));
  if (count <= allowed) return;
  const Value& first = allowed < planes.size() ? planes[allowed] : instruments[allowed - planes.size()];
  first.fail(
      fmt::format("{} planes and instruments; with {} nodes there are at most {}, as each node is compared with each "
                  "of them: leave out those that no node can reach",
                  grouped(count), grouped(nodes), grouped(allowed)));
}

}  // namespace

void read_surroundings(const Table& root, Scene& scene) {
  Network& network = scene.network;
  check_count(root.tables("plane"), root.tables("instrument"), network.nodes().size());
  for (const Value& value : root.tables("move")) read_move(value.table("move"), network);
  for (const Value& value : root.tables("contact")) {
    read_contact(value.table("contact"), network);
    scene.contacts.push_back(value.where());
  }
  for (const Value& value : root.tables("plane")) {
    read_plane(value.table("plane"), network);
    scene.surfaces.push_back(value.where());
  }
  for (const Value& value : root.tables("instrument")) {
    read_instrument(value.table("instrument"), network);
    scene.surfaces.push_back(value.where());
  }
}

}  // namespace springnet::scene
