// External influences on a network: obstacles, motions, cuts, gravity.
#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "network/checks.hpp"

namespace springnet {
namespace {

using namespace checks;

void check_table(const Motion& motion, std::string_view what) {
  check_interpolation(motion.interpolation, what);
  check_times(motion.times, motion.displacements.size(), "displacements", what);
  for (std::size_t k = 0; k < motion.displacements.size(); ++k) {
    if (!motion.displacements[k].allFinite()) {
      fail(fmt::format("{}: a displacement must be finite, entry {} of its table has {}", what, k,
                       text(motion.displacements[k])));
    }
  }
}

// Window of motions and turns: active while from <= t < until.
void check_window(double from, double until, std::string_view what) {
  if (!std::isfinite(from)) fail(fmt::format("{}: its start must be finite, is {}", what, seconds(from)));
  if (!(from < until)) {
    fail(fmt::format("{} goes from {} until {}, which is never: `from` must be less than `until`", what, seconds(from),
                     seconds(until)));
  }
}

void check_sinusoid(const Motion& motion, std::string_view what) {
  if (!motion.amplitude.allFinite()) {
    fail(fmt::format("{}: its amplitude must be finite, is {}", what, text(motion.amplitude)));
  }
  if (!(std::isfinite(motion.frequency) && motion.frequency > 0)) {
    fail(fmt::format("{}: its frequency must be a finite number above 0 Hz, is {}", what, motion.frequency));
  }
  if (!std::isfinite(motion.phase)) fail(fmt::format("{}: its phase must be finite, is {}", what, motion.phase));
  check_window(motion.from, motion.until, what);
}

void check_motion(const Motion& motion, std::string_view what) {
  const bool table = !motion.times.empty() || !motion.displacements.empty();
  const bool sinusoid = !motion.amplitude.isZero(0) || motion.frequency != 0;
  if (table && sinusoid) fail(fmt::format("{} has a table and a sinusoid: give one of them", what));
  if (!table && motion.amplitude.isZero(0)) {
    fail(fmt::format("{} has neither a table nor a sinusoid with an amplitude: give one of them", what));
  }
  table ? check_table(motion, what) : check_sinusoid(motion, what);
}

void check_turn(const Turn& turn, std::string_view what) {
  if (!turn.axis.allFinite() || turn.axis.stableNormalized().isZero(0)) {
    fail(fmt::format("{}: its axis must be finite and not zero, is {}", what, text(turn.axis)));
  }
  if (turn.through && !turn.through->allFinite()) {
    fail(fmt::format("{}: the point that its axis goes through must be finite, is {}", what, text(*turn.through)));
  }
  const bool table = !turn.times.empty() || !turn.angles.empty();
  if (table == (turn.rate != 0)) {
    fail(fmt::format("{} has {}: give one of them", what,
                     table ? "a table and a rate" : "neither a table nor a rate other than 0"));
  }
  if (!table) {
    if (!std::isfinite(turn.rate)) fail(fmt::format("{}: its rate must be finite, is {} rad/s", what, turn.rate));
    check_window(turn.from, turn.until, what);
    return;
  }
  check_interpolation(turn.interpolation, what);
  check_times(turn.times, turn.angles.size(), "angles", what);
  for (std::size_t k = 0; k < turn.angles.size(); ++k) {
    if (!std::isfinite(turn.angles[k])) {
      fail(fmt::format("{}: an angle must be finite, entry {} of its table has {}", what, k, turn.angles[k]));
    }
  }
}

void check_box(const BoxShape& box, std::string_view what) {
  if (!(box.size.allFinite() && box.size.minCoeff() > 0)) {
    fail(fmt::format("{}: the size of its box must be finite and above 0 m, is {}", what, text(box.size)));
  }
  // Far above the rounding of a product of rotations, far below an intended deviation.
  constexpr double exactness = 1e-9;
  const Eigen::Matrix3d& axes = box.axes;
  if (!axes.allFinite() || !(axes.transpose() * axes).isIdentity(exactness) || axes.determinant() < 0) {
    fail(fmt::format("{}: the axes of its box must be a rotation: perpendicular columns of length 1, right-handed",
                     what));
  }
  if (!(box.radius >= 0 && box.radius <= box.size.minCoeff() / 2)) {
    fail(fmt::format("{}: the radius of its box's edges must be 0 to {:g} m, half its smallest size, is {} m", what,
                     box.size.minCoeff() / 2, box.radius));
  }
}

void check_friction(const Friction& friction, std::string_view what) {
  if (!(std::isfinite(friction.coefficient) && friction.coefficient >= 0)) {
    fail(fmt::format("{}: its coefficient of friction must be a finite number of at least 0, is {}", what,
                     friction.coefficient));
  }
}

// "plane 'floor'", or "a plane" where it has no name.
std::string named(std::string_view what, const std::string& name) {
  if (!name.empty()) return fmt::format("{} '{}'", what, name);
  return fmt::format("{} {}", what == "instrument" ? "an" : "a", what);
}

void check_polygon(const std::vector<Vector3>& polygon) {
  if (polygon.size() < 3) {
    fail(fmt::format("a cutting polygon needs three corners or more, has {}", polygon.size()));
  }
  for (const Vector3& corner : polygon) check_finite(corner, "a corner of a cutting polygon");
  // Newell's normal, of length twice the area; valid for polygons that are not convex, too.
  Vector3 normal = Vector3::Zero();
  double extent = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3 a = polygon[i] - polygon[0];
    normal += a.cross(Vector3(polygon[(i + 1) % polygon.size()] - polygon[0]));
    extent = std::max(extent, a.norm());
  }
  constexpr double flatness = 1e-6;  // relative to the extent: far above rounding, far below an intended deviation
  if (!(normal.norm() > flatness * extent * extent)) {
    fail("the corners of a cutting polygon lie on a line: give corners that span an area");
  }
  normal.normalize();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const double height = normal.dot(polygon[i] - polygon[0]);
    if (std::abs(height) > flatness * extent) {
      fail(fmt::format(
          "a cutting polygon must be planar; corner {} lies {:.3g} m off the plane: move it, or use triangles", i,
          std::abs(height)));
    }
  }
}

}  // namespace

template <class PlaneOrInstrument>
void Network::check_obstacle(std::string_view what, const PlaneOrInstrument& obstacle) const {
  const auto same = [&](const auto& other) { return !obstacle.name.empty() && obstacle.name == other.name; };
  const bool plane = std::any_of(planes_.begin(), planes_.end(), same);
  const bool instrument = std::any_of(instruments_.begin(), instruments_.end(), same);
  if (plane || instrument) {
    const std::string_view other = plane ? "plane" : "instrument";
    fail(what == other ? fmt::format("there are two {}s '{}': rename one", what, obstacle.name)
                       : fmt::format("there is a plane '{0}' and an instrument '{0}': rename one", obstacle.name));
  }
  const std::string who = named(what, obstacle.name);
  check_friction(obstacle.friction, who);
  if (!(obstacle.restitution >= 0 && obstacle.restitution <= 1)) {
    fail(fmt::format("{}: its restitution must be 0 to 1, is {}", who, obstacle.restitution));
  }
  if (obstacle.motion) check_motion(*obstacle.motion, fmt::format("the motion of {}", who));
  if (obstacle.turn) check_turn(*obstacle.turn, fmt::format("the turn of {}", who));
}

void Network::add_plane(const Plane& plane) {
  check_finite(plane.point, "a plane's point");
  check_finite(plane.normal, "a plane's normal");
  const Vector3 normal = to_unit(plane.normal);
  if (normal.isZero(0)) fail("a plane's normal must not be zero");
  check_obstacle("plane", plane);
  Plane& added = planes_.emplace_back(plane);
  added.normal = normal;
  if (added.turn) added.turn->axis = to_unit(added.turn->axis);
}

void Network::add_instrument(const Instrument& instrument) {
  const std::string who = named("instrument", instrument.name);
  if (instrument.box) {
    check_finite(instrument.first, "the middle of a box");
    check_box(*instrument.box, who);
  } else {
    check_finite(instrument.first, "an end of an instrument");
    check_finite(instrument.second, "an end of an instrument");
    if (!(std::isfinite(instrument.radius) && instrument.radius > 0)) {
      fail(fmt::format("{}: its radius must be a finite number above 0 m, is {}", who, instrument.radius));
    }
  }
  check_obstacle("instrument", instrument);
  Instrument& added = instruments_.emplace_back(instrument);
  if (added.box) {  // a rotation up to rounding keeps its bits
    Eigen::Matrix3d& axes = added.box->axes;
    constexpr double rounding = 8.0 * std::numeric_limits<double>::epsilon();
    if (!(axes.transpose() * axes).isIdentity(rounding))
      axes = Eigen::Quaterniond(axes).normalized().toRotationMatrix();
  }
  if (added.turn) added.turn->axis = to_unit(added.turn->axis);
}

void Network::set_extent(std::size_t body, double thickness, double radius) {
  if (body >= bodies_.size()) fail(fmt::format("there is no body {}; there are {}", body, bodies_.size()));
  for (const auto& [value, what] : {std::pair(thickness, "thickness"), std::pair(radius, "radius")}) {
    if (!(std::isfinite(value) && value >= 0)) {
      fail(fmt::format("body '{}': its {} must be a finite number of at least 0 m, is {}", bodies_[body].name, what,
                       value));
    }
  }
  bodies_[body].thickness = thickness;
  bodies_[body].radius = radius;
}

void Network::add_contact(const BodyContact& contact) {
  const std::string who = contact.name.empty() ? "a contact of bodies" : fmt::format("contact '{}'", contact.name);
  constexpr std::size_t most = 200;  // each node knows of each
  if (contacts_.size() >= most) fail(fmt::format("a network has at most {} contacts of bodies", most));
  if (contact.first.empty()) fail(fmt::format("{}: its first side has no nodes", who));
  BodyContact added = contact;
  for (std::vector<NodeIndex>* side : {&added.first, &added.second}) {
    sort(*side);
    for (const NodeIndex node : *side) {
      if (node >= nodes_.size()) fail(fmt::format("{}: there is no node {}; there are {}", who, node, nodes_.size()));
      const auto after = std::upper_bound(bodies_.begin(), bodies_.end(), node,
                                          [](NodeIndex k, const Body& body) { return k < body.first_node; });
      if (after == bodies_.begin() || node - (after - 1)->first_node >= (after - 1)->node_count)
        fail(fmt::format("{}: node {} is of no body, which says how thick it is", who, node));
    }
  }
  const auto same = [&](const BodyContact& other) { return !contact.name.empty() && contact.name == other.name; };
  if (std::any_of(contacts_.begin(), contacts_.end(), same))
    fail(fmt::format("there are two contacts '{}': rename one", contact.name));
  check_friction(contact.friction, who);
  if (!(contact.restitution >= 0 && contact.restitution <= 1))
    fail(fmt::format("{}: its restitution must be 0 to 1, is {}", who, contact.restitution));
  contacts_.push_back(std::move(added));
}

void Network::add_move(const Move& move) {
  check_motion(move.motion, "a motion of nodes");
  Move added = move;
  sort(added.nodes);
  for (const NodeIndex node : added.nodes) {
    if (node >= nodes_.size()) {
      fail(fmt::format("there is no node {} to move, only {}", node, nodes_.size()));
    }
    if (moving_nodes_.contains(node)) {
      fail(
          fmt::format("node {} is moved twice: a node can follow one motion only; put the sum of both into one", node));
    }
  }
  for (const NodeIndex node : added.nodes) {
    moving_nodes_.insert(node);
    fix(node);
  }
  moves_.push_back(std::move(added));
}

void Network::add_cut(const Cut& cut) {
  if (!std::isfinite(cut.time)) fail(fmt::format("a cut's time must be finite, is {}", cut.time));
  if (cut.springs.empty() && cut.polygon.empty()) fail("a cut needs springs or a polygon");
  for (const SpringIndex spring : cut.springs) check_spring(spring);
  if (!cut.polygon.empty()) check_polygon(cut.polygon);
  cuts_.push_back(cut);
}

void Network::add_change(const Change& change) {
  if (!(std::isfinite(change.time) && change.time >= 0.0))
    fail(fmt::format("a change's time must be a finite number from 0 s on, is {}", change.time));
  for (const SpringIndex spring : change.springs) check_spring(spring);
  for (const ElementIndex element : change.elements)
    if (element >= elements_.size())
      fail(fmt::format("a change: there is no element {}, only {}", element, elements_.size()));
  for (const NodeIndex node : change.nodes)
    if (node >= nodes_.size()) fail(fmt::format("a change: there is no node {}, only {}", node, nodes_.size()));
  const bool of_laws = !change.spring.empty() || !change.viscosity.empty() || !change.spring_inputs.empty() ||
                       !change.viscosity_inputs.empty() || change.reference || change.reference_scale;
  const bool of_nodes = !change.neuron.empty() || change.mass;
  if (of_laws && change.springs.empty() && change.elements.empty())
    fail("a change of laws needs springs or elements that it is for");
  if (of_nodes && change.nodes.empty()) fail("a change of neurons or masses needs nodes that it is for");
  if (change.reference && change.reference_scale) fail("a change has a reference and a factor of it: give one of both");
  if (!of_laws && !of_nodes && !change.remove && !change.integrator) fail("a change needs something that changes");
  if (change.remove && change.springs.empty() && change.elements.empty() && change.nodes.empty())
    fail("a change removes nothing: it needs springs, elements or nodes");
  changes_.push_back(change);
}

void Network::set_gravity(const Vector3& acceleration) {
  check_finite(acceleration, "gravity");
  gravity_ = acceleration;
}

Network Network::without_constraints() const {
  Network result(*this);
  result.planes_.clear();
  result.instruments_.clear();
  result.contacts_.clear();
  result.rigids_.clear();
  result.rigid_ends_.clear();
  return result;
}

}  // namespace springnet
