// What acts on a network from outside: surfaces, motions, cuts, gravity.
#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "network/checks.hpp"

namespace springnet {
namespace {

using namespace checks;

void check_table(const Motion& motion, std::string_view what) {
  check_times(motion.times, motion.displacements.size(), "displacements", what);
  for (std::size_t k = 0; k < motion.displacements.size(); ++k) {
    if (!motion.displacements[k].allFinite()) {
      fail(fmt::format("{}: a displacement must be finite, entry {} of its table has {}", what, k,
                       text(motion.displacements[k])));
    }
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
  if (!std::isfinite(motion.from)) fail(fmt::format("{}: its start must be finite, is {}", what, seconds(motion.from)));
  if (!(motion.from < motion.until)) {
    fail(fmt::format("{} goes from {} until {}, which is never: `from` must be less than `until`", what,
                     seconds(motion.from), seconds(motion.until)));
  }
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
  // Newell's normal, of twice the area's length, also right for polygons that are not convex.
  Vector3 normal = Vector3::Zero();
  double extent = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3 a = polygon[i] - polygon[0];
    normal += a.cross(Vector3(polygon[(i + 1) % polygon.size()] - polygon[0]));
    extent = std::max(extent, a.norm());
  }
  constexpr double flatness = 1e-6;  // of the extent: far above rounding, far below what a user could mean
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

void Network::check_surface(std::string_view what, const std::string& name, const Friction& friction,
                            const std::optional<Motion>& motion) const {
  const auto same = [&](const auto& other) { return !name.empty() && name == other.name; };
  const bool plane = std::any_of(planes_.begin(), planes_.end(), same);
  const bool instrument = std::any_of(instruments_.begin(), instruments_.end(), same);
  if (plane || instrument) {
    const std::string_view other = plane ? "plane" : "instrument";
    fail(what == other ? fmt::format("there are two {}s '{}': rename one", what, name)
                       : fmt::format("there is a plane '{0}' and an instrument '{0}': rename one", name));
  }
  check_friction(friction, named(what, name));
  if (motion) check_motion(*motion, "the motion of " + named(what, name));
}

void Network::add_plane(const Plane& plane) {
  check_finite(plane.point, "a plane's point");
  check_finite(plane.normal, "a plane's normal");
  const Vector3 normal = plane.normal.stableNormalized();
  if (normal.isZero(0)) fail("a plane's normal must not be zero");
  check_surface("plane", plane.name, plane.friction, plane.motion);
  planes_.push_back(plane);
  planes_.back().normal = normal;
}

void Network::add_instrument(const Instrument& instrument) {
  check_finite(instrument.first, "an end of an instrument");
  check_finite(instrument.second, "an end of an instrument");
  if (!(std::isfinite(instrument.radius) && instrument.radius > 0)) {
    fail(fmt::format("{}: its radius must be a finite number above 0 m, is {}", named("instrument", instrument.name),
                     instrument.radius));
  }
  check_surface("instrument", instrument.name, instrument.friction, instrument.motion);
  instruments_.push_back(instrument);
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

void Network::set_gravity(const Vector3& acceleration) {
  check_finite(acceleration, "gravity");
  gravity_ = acceleration;
}

}  // namespace springnet
