// Loads of a network.
#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "network/checks.hpp"

namespace springnet {
namespace {

using namespace checks;

void check_course(const Course& course) {
  const bool table = !course.times.empty() || !course.factors.empty();
  const bool sinusoid = course.frequency != 0.0, ramp = course.ramp != 0.0;
  if (table + sinusoid + ramp > 1) fail("a load's course has more than one of table, sinusoid and ramp: give one");
  if (table) {
    check_interpolation(course.interpolation, "a load's course");
    check_times(course.times, course.factors.size(), "factors", "a load's course");
    for (std::size_t k = 0; k < course.factors.size(); ++k) {
      if (!std::isfinite(course.factors[k]))
        fail(fmt::format("a load's course: a factor must be finite, entry {} of its table has {}", k,
                         course.factors[k]));
    }
  }
  if (sinusoid && !(std::isfinite(course.frequency) && course.frequency > 0.0))
    fail(fmt::format("a load's course: its frequency must be a finite number above 0 Hz, is {}", course.frequency));
  for (const double value : {course.phase, course.amplitude, course.mean}) {
    if (!std::isfinite(value))
      fail(fmt::format("a load's course: phase, amplitude and mean must be finite, one is {}", value));
  }
  if (ramp && !(std::isfinite(course.ramp) && course.ramp > 0.0))
    fail(fmt::format("a load's course: its ramp must be a finite number of seconds above 0, is {}", course.ramp));
}

void check_faces(const Load& load, std::size_t node_count) {
  for (const Face& face : load.faces) {
    for (const NodeIndex node : face) {
      if (node >= node_count)
        fail(fmt::format("a load on a face with node {}: there are only {} nodes", node, node_count));
    }
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0])
      fail(fmt::format("a load on a face with nodes {}, {} and {}: a face has three different nodes", face[0], face[1],
                       face[2]));
  }
  if (!load.areas.empty() && load.areas.size() != load.faces.size())
    fail(fmt::format("a load on {} faces has {} areas: give as many, or none", load.faces.size(), load.areas.size()));
  for (const Vector3& area : load.areas) check_finite(area, "an area of a load's faces");
  if (load.faces.empty() && (!load.traction.isZero(0) || load.pressure != 0.0))
    fail("a traction or pressure acts on faces, but the load has none: give `faces`");
}

}  // namespace

Vector3 Network::area_of(const Face& face) const {
  const Vector3& a = nodes_[face[0]].position;
  return 0.5 * (nodes_[face[1]].position - a).cross(nodes_[face[2]].position - a);
}

void Network::add_load(const Load& load) {
  check_finite(load.force, "a load's force");
  check_finite(load.traction, "a load's traction");
  if (!std::isfinite(load.pressure)) fail(fmt::format("a load's pressure must be finite, is {} Pa", load.pressure));
  if (!(load.from < load.until)) {
    fail(fmt::format("a load acts from {} until {}, which is never: `from` must be less than `until`",
                     seconds(load.from), seconds(load.until)));
  }
  check_course(load.course);
  check_faces(load, nodes_.size());
  Load added = load;
  sort(added.nodes);
  if (!added.nodes.empty() && added.nodes.back() >= nodes_.size())
    fail(fmt::format("a load on node {}: there are only {} nodes", added.nodes.back(), nodes_.size()));
  if (added.areas.empty()) {
    for (const Face& face : added.faces) added.areas.push_back(area_of(face));
  }
  loads_.push_back(std::move(added));
}

}  // namespace springnet
