// Loads, cuts, motions, planes, instruments, inputs.
#include <cmath>

#include <fmt/format.h>

#include "scene/writing.hpp"

namespace springnet::scene {
namespace {

using namespace toml_text;

std::string interpolation_text(Motion::Interpolation interpolation) {
  return in_quotes(interpolation == Motion::Interpolation::linear ? "linear" : "smooth");
}

// Calls add(key, value) for the keys of a motion.
template <class Add>
void add_motion(const Motion& motion, const Add& add) {
  if (!motion.displacements.empty()) {
    add("table", list(motion.times.size(), [&](std::size_t k) {
          const Vector3& d = motion.displacements[k];
          return fmt::format("[{}, {}, {}, {}]", number(motion.times[k]), number(d[0]), number(d[1]), number(d[2]));
        }));
    add("interpolation", interpolation_text(motion.interpolation));
    return;
  }
  add("sinusoid", Inline()
                      .add("amplitude", vector(motion.amplitude))
                      .add("frequency", number(motion.frequency))
                      .add("phase", number(motion.phase))
                      .text());
  add("from", number(motion.from));
  if (std::isfinite(motion.until)) add("until", number(motion.until));
}

std::string turn_text(const Turn& turn) {
  Inline table;
  table.add("axis", vector(turn.axis));
  if (turn.through) table.add("through", vector(*turn.through));
  if (!turn.angles.empty()) {
    table.add("table", list(turn.times.size(), [&](std::size_t k) {
                return fmt::format("[{}, {}]", number(turn.times[k]), number(turn.angles[k]));
              }));
    table.add("interpolation", interpolation_text(turn.interpolation));
    return table.text();
  }
  table.add("rate", number(turn.rate)).add("from", number(turn.from));
  if (std::isfinite(turn.until)) table.add("until", number(turn.until));
  return table.text();
}

std::string friction_text(const Friction& friction) {
  if (friction.kind == Friction::Kind::coulomb) return number(friction.coefficient);
  return in_quotes(friction.kind == Friction::Kind::held ? "held" : "none");
}

template <class PlaneOrInstrument>
void write_obstacle(const PlaneOrInstrument& obstacle, Document& out) {
  if (!obstacle.name.empty()) out.add("name", in_quotes(obstacle.name));
  out.add("friction", friction_text(obstacle.friction));
  out.add("restitution", number(obstacle.restitution));
  if (obstacle.motion) {
    Inline motion;
    add_motion(*obstacle.motion, [&](const char* key, const std::string& value) { motion.add(key, value); });
    out.add("motion", motion.text());
  }
  if (obstacle.turn) out.add("turn", turn_text(*obstacle.turn));
}

void write_shape(const Instrument& instrument, Document& out) {
  Inline shape;
  if (instrument.box) {
    const BoxShape& box = *instrument.box;
    shape.add("center", vector(instrument.first)).add("size", vector(box.size));
    if (!box.axes.isIdentity(0.0))
      shape.add("axes", list(3, [&](std::size_t k) { return vector(box.axes.col(static_cast<Eigen::Index>(k))); }));
    shape.add("radius", number(box.radius));
    out.add("box", shape.text());
  } else if (same_bits(instrument.first, instrument.second)) {
    shape.add("center", vector(instrument.first)).add("radius", number(instrument.radius));
    out.add("sphere", shape.text());
  } else {
    shape.add("from", vector(instrument.first)).add("to", vector(instrument.second));
    shape.add("radius", number(instrument.radius));
    out.add("capsule", shape.text());
  }
}

void write_course(const Load& load, Document& out) {
  const Course& course = load.course;
  if (std::isfinite(load.from)) out.add("from", number(load.from));
  if (std::isfinite(load.until)) out.add("until", number(load.until));
  if (!course.factors.empty()) {
    out.add("table", list(course.times.size(), [&](std::size_t k) {
              return fmt::format("[{}, {}]", number(course.times[k]), number(course.factors[k]));
            }));
    out.add("interpolation", interpolation_text(course.interpolation));
  } else if (course.frequency > 0.0) {
    out.add("sinusoid", Inline()
                            .add("frequency", number(course.frequency))
                            .add("phase", number(course.phase))
                            .add("amplitude", number(course.amplitude))
                            .add("mean", number(course.mean))
                            .text());
  } else if (course.ramp > 0.0) {
    out.add("ramp", number(course.ramp));
  }
}

}  // namespace

void write_loads(const Network& network, Document& out) {
  const auto write = [&](const Load& load, const char* kind, const std::string& value) {
    out.begin("[[force]]");
    if (std::string_view(kind) == "force") {
      out.add("select", Inline().add("nodes", whole_numbers(load.nodes)).text());
    } else {
      out.add("faces", list(load.faces.size(), [&](std::size_t k) {
                return fmt::format("[{}, {}, {}]", load.faces[k][0], load.faces[k][1], load.faces[k][2]);
              }));
      bool own_areas = false;
      for (std::size_t k = 0; k < load.faces.size(); ++k)
        own_areas = own_areas || !same_bits(load.areas[k], network.area_of(load.faces[k]));
      if (own_areas) out.add("areas", vectors(load.areas));
    }
    out.add(kind, value);
    if (std::string_view(kind) == "pressure" && load.follow) out.add("follow", "true");
    write_course(load, out);
  };
  for (const Load& load : network.loads()) {
    if (!load.nodes.empty()) write(load, "force", vector(load.force));
    if (load.faces.empty()) continue;
    if (!load.traction.isZero(0.0)) write(load, "traction", vector(load.traction));
    if (load.pressure != 0.0 || load.traction.isZero(0.0)) write(load, "pressure", number(load.pressure));
  }
}

void write_surroundings(const Network& network, Document& out) {
  for (const Cut& cut : network.cuts()) {
    if (cut.springs.empty() && cut.polygon.empty()) continue;
    out.begin("[[cut]]");
    out.add("time", number(cut.time));
    if (!cut.springs.empty()) out.add("select", Inline().add("springs", whole_numbers(cut.springs)).text());
    if (!cut.polygon.empty()) out.add("polygon", vectors(cut.polygon));
  }
  for (const Move& move : network.moves()) {
    if (move.nodes.empty()) continue;
    out.begin("[[move]]");
    out.add("select", Inline().add("nodes", whole_numbers(move.nodes)).text());
    add_motion(move.motion, [&](const char* key, const std::string& value) { out.add(key, value); });
  }
  for (const BodyContact& contact : network.contacts()) {
    out.begin("[[contact]]");
    if (!contact.name.empty()) out.add("name", in_quotes(contact.name));
    const auto selection = [](const std::vector<NodeIndex>& nodes) {
      return Inline().add("nodes", whole_numbers(nodes)).text();
    };
    out.add("between", contact.second.empty()
                           ? fmt::format("[{}]", selection(contact.first))
                           : fmt::format("[{}, {}]", selection(contact.first), selection(contact.second)));
    out.add("friction", friction_text(contact.friction));
    out.add("restitution", number(contact.restitution));
  }
  for (const Plane& plane : network.planes()) {
    out.begin("[[plane]]");
    out.add("point", vector(plane.point));
    out.add("normal", vector(plane.normal));
    write_obstacle(plane, out);
  }
  for (const Instrument& instrument : network.instruments()) {
    out.begin("[[instrument]]");
    write_shape(instrument, out);
    write_obstacle(instrument, out);
  }
}

void write_inputs(const Network& network, const WrittenElements& elements, Document& out) {
  for (std::size_t i = 0; i < network.inputs().size(); ++i) {
    const Input& input = network.inputs()[i];
    const Signal& signal = input.signal;
    out.begin("[[input]]");
    out.add("input", in_quotes(input.input));
    if (!input.name.empty()) out.add("name", in_quotes(input.name));
    if (!input.springs.empty()) out.add("select", Inline().add("springs", whole_numbers(input.springs)).text());
    if (!input.elements.empty())
      out.add("elements", elements.names_of(input.elements, fmt::format("input signal {}", i)));
    if (signal.values.size() > 1) {
      out.add("times", numbers(signal.times));
      out.add("values", numbers(signal.values));
      const char* const names[] = {"hold", "linear", "cubic"};
      out.add("interpolation", in_quotes(names[static_cast<std::size_t>(signal.interpolation)]));
    } else if (signal.values.empty() && signal.frequency > 0.0) {
      out.add("sinusoid", Inline()
                              .add("frequency", number(signal.frequency))
                              .add("amplitude", number(signal.amplitude))
                              .add("mean", number(signal.mean))
                              .add("phase", number(signal.phase))
                              .text());
    } else {
      out.add("value", number(signal.values.empty() ? signal.mean : signal.values.front()));
    }
  }
}

}  // namespace springnet::scene
