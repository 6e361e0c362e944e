#include "inspection/hints.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "constraints/body_contacts.hpp"
#include "constraints/obstacle.hpp"
#include "network/kinks.hpp"
#include "text/counted.hpp"

namespace springnet {

namespace {

// Beyond these bounds, a mistake is more likely than intent.
constexpr double large = 10.0;            // m, of a soft body
constexpr double small = 1e-3;            // m
constexpr double soft = 1e7;              // N/m^2: stiffness over length of a spring; tissue and rubber are below
constexpr double heavy = 1e6;             // kg
constexpr double dense = 3e4;             // kg/m^3; osmium has 22,600
constexpr double strong_gravity = 100.0;  // m/s^2

struct Box {
  Vector3 lower = Vector3::Constant(std::numeric_limits<double>::infinity());
  Vector3 upper = Vector3::Constant(-std::numeric_limits<double>::infinity());
  double mass = 0.0;  // kg

  void add(const Node& node) {
    lower = lower.cwiseMin(node.position);
    upper = upper.cwiseMax(node.position);
    mass += node.mass;
  }
  [[nodiscard]] Vector3 sides() const { return upper - lower; }
  [[nodiscard]] double size() const { return sides().maxCoeff(); }
};

// Nodes [first, first + nodes), springs likewise.
struct Piece {
  std::string name;
  std::size_t first_node, nodes, first_spring, springs;
};

// Bodies; the network as a whole where there are none.
std::vector<Piece> pieces_of(const Network& network) {
  std::vector<Piece> pieces;
  for (const Body& body : network.bodies()) {
    pieces.push_back(
        {fmt::format("Body '{}'", body.name), body.first_node, body.node_count, body.first_spring, body.spring_count});
  }
  if (pieces.empty()) pieces.push_back({"The network", 0, network.nodes().size(), 0, network.springs().size()});
  return pieces;
}

// Median of stiffness over length, about Young's modulus over the number of springs in a cross-section, N/m^2; 0 if
// unknown.
double softness_of(const StartingNetwork& start, const Piece& piece) {
  std::vector<double> values;
  for (std::size_t s = piece.first_spring; s < piece.first_spring + piece.springs; ++s) {
    const double value = std::abs(start.springs()[s].stiffness) / start.springs()[s].length;
    if (std::isfinite(value)) values.push_back(value);
  }
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void hint_at_sizes(const StartingNetwork& start, std::vector<Hint>& hints) {
  const Network& network = start.network();
  for (const Piece& piece : pieces_of(network)) {
    Box box;
    for (std::size_t k = piece.first_node; k < piece.first_node + piece.nodes; ++k) box.add(network.nodes()[k]);
    if (piece.nodes < 2 || piece.springs == 0) continue;
    const bool is_soft = softness_of(start, piece) < soft;
    if (box.size() > large && is_soft) {
      hints.push_back(
          {Hint::Kind::size,
           fmt::format("{} is {:.3g} m large and soft. If its coordinates are in millimetres, set mesh.scale = 0.001.",
                       piece.name, box.size())});
    }
    if (box.size() > 0.0 && box.size() < small) {
      hints.push_back(
          {Hint::Kind::size,
           fmt::format("{} is {:.3g} mm large. Coordinates are in metres here: check the unit of its mesh, and "
                       "mesh.scale.",
                       piece.name, 1e3 * box.size())});
    }
    if (box.mass > heavy && is_soft) {
      hints.push_back(
          {Hint::Kind::mass,
           fmt::format("{} has a mass of {:.3g} kg. Check its density (in kg/m^3; water has 1000) or its masses, and "
                       "its size, {:.3g} m.",
                       piece.name, box.mass, box.size())});
    }
    // The box of a sheet or chain has hardly any volume.
    const Vector3 sides = box.sides();
    if (sides.minCoeff() > 0.01 * box.size() && box.mass > dense * sides.prod()) {
      hints.push_back(
          {Hint::Kind::density,
           fmt::format("{} has a mass of {:.3g} kg in a box of {:.3g} x {:.3g} x {:.3g} m: {:.3g} kg/m^3, more "
                       "than any material. Check its masses (in kg) and its size.",
                       piece.name, box.mass, sides.x(), sides.y(), sides.z(), box.mass / sides.prod())});
    }
  }
}

void hint_at_gravity(const Network& network, std::vector<Hint>& hints) {
  const double strength = network.gravity().norm();
  if (strength <= strong_gravity) return;
  hints.push_back({Hint::Kind::gravity, fmt::format("Gravity is {:.4g} m/s^2; on earth it is 9.81.", strength)});
}

std::vector<Obstacle> surfaces_of(const Network& network) {
  std::vector<Obstacle> surfaces;
  for (const Plane& plane : network.planes()) surfaces.emplace_back(plane);
  for (const Instrument& instrument : network.instruments()) surfaces.emplace_back(instrument);
  return surfaces;
}

void hint_at_starts(const StartingNetwork& start, std::vector<Hint>& hints) {
  const Network& network = start.network();
  const std::vector<Obstacle> surfaces = surfaces_of(network);
  const double size = size_of(network);
  for (std::size_t j = 0; j < surfaces.size(); ++j) {
    const Obstacle& surface = surfaces[j];
    const Pose pose = surface.at(just_after(0.0));
    std::size_t count = 0;
    NodeIndex worst = 0;
    double deepest = 0.0;
    for (NodeIndex k = 0; k < network.nodes().size(); ++k) {
      if (!start.is_free(k)) continue;
      const Vector3& place = network.nodes()[k].position;
      const double depth = starting_depth(surface, pose, place, size);
      if (depth == 0.0) continue;
      ++count;
      if (depth <= deepest) continue;
      deepest = depth;
      worst = k;
    }
    if (count == 0) continue;
    const bool plane = surface.is_plane();
    const std::string name = surface.description(plane ? j : j - network.planes().size());
    hints.push_back(
        {Hint::Kind::start,
         fmt::format("{} {} {} at the start, node {} by {:.3g} m: a run is refused. Move the body or the {}.",
                     counted(count, "node is", "nodes are"), plane ? "behind" : "inside", name, worst, deepest,
                     plane ? "plane, or turn the plane's normal towards the body" : "instrument")});
  }
}

void hint_at_overlaps(const Network& network, std::vector<Hint>& hints) {
  constexpr std::size_t most = 10;
  const std::vector<StartingOverlap> found = starting_overlaps(network, most);
  if (found.empty()) return;
  std::string text;
  for (const StartingOverlap& each : found)
    text += fmt::format("{}{} by {:.3g} m", text.empty() ? "" : "; ", each.pair, each.depth);
  hints.push_back(
      {Hint::Kind::start,
       fmt::format("Bodies begin in each other: a run is refused. Nearer than their thickness are {}{}. Move "
                   "the bodies apart, or make them thinner.",
                   found.size() < most ? "" : "most of all ", text)});
}

// Whether something may stop a fall: a plane facing against gravity, or any instrument.
bool something_is_below(const Network& network) {
  const Vector3& g = network.gravity();
  return !network.instruments().empty() || !network.contacts().empty() ||
         std::any_of(network.planes().begin(), network.planes().end(),
                     [&](const Plane& plane) { return plane.normal.dot(g) < 0.0; });
}

void hint_at_falls(const Network& network, const std::vector<std::uint32_t>& part, const Inspection& found,
                   std::vector<Hint>& hints) {
  const double strength = network.gravity().norm();
  if (strength == 0.0 || something_is_below(network)) return;
  const auto is_held = [](const Part& each) { return each.fixed_nodes > 0; };
  const auto parts = static_cast<std::size_t>(
      std::count_if(found.parts.begin(), found.parts.end(), [&](const Part& each) { return !is_held(each); }));
  if (parts == 0) return;
  std::string distance;
  if (found.options.duration) {
    Box box;
    for (std::size_t k = 0; k < part.size(); ++k) {
      if (!is_held(found.parts[part[k]])) box.add(network.nodes()[k]);
    }
    const double fall = 0.5 * strength * *found.options.duration * *found.options.duration;
    if (fall <= box.size()) return;  // a short flight
    distance = fmt::format(", {:.3g} m in {:g} s", fall, *found.options.duration);
  }
  const auto first = std::find_if_not(found.parts.begin(), found.parts.end(), is_held);
  hints.push_back(
      {Hint::Kind::fall,
       fmt::format("{} (the largest from node {}, {}){}: there is gravity, nothing fixes {}, and no plane is "
                   "below. Add [[fix]] or [[plane]], or leave out [gravity].",
                   counted(parts, "part falls freely", "parts fall freely"), first->first_node,
                   counted(first->nodes, "node"), distance, parts == 1 ? "it" : "them")});
}

void hint_at_time_step(const Inspection& found, std::vector<Hint>& hints) {
  if (!found.slowest || !found.options.time_step || found.options.adaptive_steps) return;
  const double steps = found.slowest->period / *found.options.time_step;
  if (steps >= steps_a_period || found.slowest->damping_ratio >= damped_out) return;
  hints.push_back(
      {Hint::Kind::time_step,
       fmt::format("The slowest vibration has a period of {:.3g} s, {:.2g} time steps: too few to resolve it. "
                   "Set a time_step of {:.1g} s (20 per period) if its course matters, or check stiffness and "
                   "masses.",
                   found.slowest->period, steps, found.slowest->period / 20.0)});
}

// For a motion (m/s) or a turn (rad/s).
void hint_at_kinks(const Kinks& kinks, const char* what, const std::string& whose, const char* unit,
                   std::vector<Hint>& hints) {
  if (!kinks.look_sampled()) return;
  hints.push_back(
      {Hint::Kind::kinks,
       fmt::format(
           "The {} of {} is a linear table: its velocity jumps at {} of its {} entries, by up to {:.3g} {}. "
           "Nodes that touch it then are struck, or separate from it. Set interpolation = \"smooth\" if the table was "
           "sampled from a smooth motion.",
           what, whose, kinks.count, kinks.entries, kinks.greatest, unit)});
}

template <class Surface>
void hint_at_kinks(const Surface& surface, std::size_t number, std::vector<Hint>& hints) {
  const std::string whose = Obstacle(surface).description(number);
  if (surface.motion) hint_at_kinks(kinks_of(*surface.motion), "motion", whose, "m/s", hints);
  if (surface.turn) hint_at_kinks(kinks_of(*surface.turn), "turn", whose, "rad/s", hints);
}

void hint_at_kinks(const Network& network, std::vector<Hint>& hints) {
  for (std::size_t k = 0; k < network.moves().size(); ++k)
    hint_at_kinks(kinks_of(network.moves()[k].motion), "motion", fmt::format("the nodes of move {}", k), "m/s", hints);
  for (std::size_t k = 0; k < network.planes().size(); ++k) hint_at_kinks(network.planes()[k], k, hints);
  for (std::size_t k = 0; k < network.instruments().size(); ++k) hint_at_kinks(network.instruments()[k], k, hints);
}

}  // namespace

std::string_view name_of(Hint::Kind kind) noexcept {
  switch (kind) {
    case Hint::Kind::size:
      return "size";
    case Hint::Kind::mass:
      return "mass";
    case Hint::Kind::density:
      return "density";
    case Hint::Kind::gravity:
      return "gravity";
    case Hint::Kind::start:
      return "start";
    case Hint::Kind::fall:
      return "fall";
    case Hint::Kind::kinks:
      return "kinks";
    default:
      return "time step";
  }
}

std::vector<Hint> find_hints(const StartingNetwork& start, const std::vector<std::uint32_t>& part,
                             const Inspection& found) {
  const Network& network = start.network();
  std::vector<Hint> hints;
  hint_at_sizes(start, hints);
  hint_at_gravity(network, hints);
  hint_at_starts(start, hints);
  hint_at_overlaps(start.network(), hints);
  hint_at_falls(network, part, found, hints);
  hint_at_time_step(found, hints);
  hint_at_kinks(network, hints);
  return hints;
}

}  // namespace springnet
