#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <springnet/error.hpp>
#include <springnet/network.hpp>

namespace springnet {
namespace {

// Numbers of nodes and springs have 32 bits; the greatest stands for "none".
constexpr std::size_t largest_count = std::numeric_limits<std::uint32_t>::max();

[[noreturn]] void fail(const std::string& message) { throw Error(ErrorKind::input, message); }

std::string text(const Vector3& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }

double distance(const Vector3& a, const Vector3& b) { return std::hypot(a.x() - b.x(), a.y() - b.y(), a.z() - b.z()); }

// A text that is equal exactly where the uses are.
std::string key_of(const LawUse& use, std::string_view what) {
  if (use.id.empty()) fail(fmt::format("a {} has no id: name a component of a plugin", what));
  std::string key = fmt::format("{}:{};", use.id.size(), use.id);
  for (const auto& [name, value] : use.parameters) {
    if (!std::isfinite(value)) {
      fail(fmt::format("{} '{}': parameter '{}' must be a finite number, is {}", what, use.id, name, value));
    }
    const double positive_zero = value == 0.0 ? 0.0 : value;
    key += fmt::format("{}:{}={:x};", name.size(), name, std::bit_cast<std::uint64_t>(positive_zero));
  }
  return key;
}

void check_rest_length(double length) {
  if (!(std::isfinite(length) && length >= 0)) {
    fail(fmt::format("a rest length must be a finite number of at least 0 m, is {}", length));
  }
}

void check_finite(const Vector3& v, std::string_view what) {
  if (!v.allFinite()) fail(fmt::format("{} must be finite, is {}", what, text(v)));
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
      fail(fmt::format("a cutting polygon must be planar; corner {} lies {} m off the plane: move it, or use triangles",
                       i, std::abs(height)));
    }
  }
}

}  // namespace

Network::Network() { add_neuron({"point_mass", {}}); }

std::uint32_t Network::add_neuron(const LawUse& neuron) {
  const auto [found, is_new] =
      neuron_index_.emplace(key_of(neuron, "neuron"), static_cast<std::uint32_t>(neurons_.size()));
  if (is_new) neurons_.push_back(neuron);
  return found->second;
}

MaterialIndex Network::add_material(const Material& material) {
  if (!material.spring && !material.viscosity) {
    fail("a material needs a spring function, a viscosity function or both");
  }
  const std::string spring = material.spring ? key_of(*material.spring, "spring function") : "";
  const std::string viscosity = material.viscosity ? key_of(*material.viscosity, "viscosity function") : "";
  const auto [found, is_new] = material_index_.emplace(fmt::format("{}\n{}{}", spring.size(), spring, viscosity),
                                                       static_cast<MaterialIndex>(materials_.size()));
  if (is_new) materials_.push_back(material);
  return found->second;
}

void Network::check_node(const Node& node, NodeIndex index) const {
  const std::string what = fmt::format("node {}", index);
  if (!node.position.allFinite())
    fail(fmt::format("{}: its position must be finite, is {}", what, text(node.position)));
  if (!node.velocity.allFinite())
    fail(fmt::format("{}: its velocity must be finite, is {}", what, text(node.velocity)));
  if (!(std::isfinite(node.mass) && node.mass > 0)) {
    fail(fmt::format("{}: its mass must be a finite number above 0 kg, is {}", what, node.mass));
  }
  if (node.neuron >= neurons_.size()) {
    fail(fmt::format("{}: there is no neuron {}, only {}: add it with add_neuron", what, node.neuron, neurons_.size()));
  }
}

NodeIndex Network::add_node(const Node& node) {
  if (nodes_.size() >= largest_count) fail(fmt::format("a network has at most {} nodes", largest_count));
  const auto index = static_cast<NodeIndex>(nodes_.size());
  check_node(node, index);
  nodes_.push_back(node);
  if (node.fixed) nodes_.back().velocity.setZero();
  return index;
}

void Network::set_node(NodeIndex index, const Node& node) {
  if (index >= nodes_.size()) fail(fmt::format("there is no node {}, only {}", index, nodes_.size()));
  check_node(node, index);
  nodes_[index] = node;
  if (node.fixed) nodes_[index].velocity.setZero();
}

void Network::fix(NodeIndex node) {
  if (node >= nodes_.size()) fail(fmt::format("there is no node {} to fix, only {}", node, nodes_.size()));
  nodes_[node].fixed = true;
  nodes_[node].velocity.setZero();
}

void Network::check_material(MaterialIndex material) const {
  if (material >= materials_.size()) {
    fail(fmt::format("there is no material {}, only {}: add it with add_material", material, materials_.size()));
  }
}

void Network::check_spring(SpringIndex spring) const {
  if (spring >= springs_.size()) fail(fmt::format("there is no spring {}, only {}", spring, springs_.size()));
}

SpringIndex Network::add_spring(NodeIndex first, NodeIndex second, MaterialIndex material,
                                std::optional<double> rest_length) {
  if (springs_.size() >= largest_count) fail(fmt::format("a network has at most {} springs", largest_count));
  for (const NodeIndex end : {first, second}) {
    if (end >= nodes_.size()) {
      fail(fmt::format("a spring from node {} to node {}: there is no node {}, only {}", first, second, end,
                       nodes_.size()));
    }
  }
  if (first == second) fail(fmt::format("a spring joins node {} to itself: give two different nodes", first));
  check_material(material);
  const double length = rest_length ? *rest_length : distance(nodes_[first].position, nodes_[second].position);
  if (!rest_length && length == 0) {
    fail(fmt::format(
        "the spring from node {} to node {} has length zero: both are at {}; move one, or give the spring a "
        "rest length",
        first, second, text(nodes_[first].position)));
  }
  check_rest_length(length);
  springs_.push_back({first, second, material, length});
  return static_cast<SpringIndex>(springs_.size() - 1);
}

void Network::set_spring_material(SpringIndex spring, MaterialIndex material) {
  check_spring(spring);
  check_material(material);
  springs_[spring].material = material;
}

void Network::set_rest_length(SpringIndex spring, double rest_length) {
  check_spring(spring);
  check_rest_length(rest_length);
  springs_[spring].rest_length = rest_length;
}

void Network::begin_body(const std::string& name) {
  if (in_body_) fail(fmt::format("body '{}' begins before body '{}' has ended", name, bodies_.back().name));
  if (name.empty()) fail("a body needs a name");
  if (!body_names_.insert(name).second) fail(fmt::format("there are two bodies '{}': rename one", name));
  bodies_.push_back({name, static_cast<NodeIndex>(nodes_.size()), 0, static_cast<SpringIndex>(springs_.size()), 0});
  in_body_ = true;
}

void Network::end_body() {
  if (!in_body_) fail("a body ends that has not begun");
  Body& body = bodies_.back();
  body.node_count = static_cast<NodeIndex>(nodes_.size()) - body.first_node;
  body.spring_count = static_cast<SpringIndex>(springs_.size()) - body.first_spring;
  in_body_ = false;
}

void Network::add_load(const Load& load) {
  check_finite(load.force, "a load's force");
  if (!(load.from < load.until)) {
    fail(fmt::format("a load acts from {} s until {} s, which is never: `from` must be less than `until`", load.from,
                     load.until));
  }
  loads_.push_back(load);
  std::vector<NodeIndex>& nodes = loads_.back().nodes;
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  if (!nodes.empty() && nodes.back() >= nodes_.size()) {
    const NodeIndex missing = nodes.back();
    loads_.pop_back();
    fail(fmt::format("a load on node {}: there are only {} nodes", missing, nodes_.size()));
  }
}

void Network::add_plane(const Plane& plane) {
  check_finite(plane.point, "a plane's point");
  check_finite(plane.normal, "a plane's normal");
  const Vector3 normal = plane.normal.stableNormalized();
  if (normal.isZero(0)) fail("a plane's normal must not be zero");
  for (const Plane& other : planes_) {
    if (!plane.name.empty() && plane.name == other.name) {
      fail(fmt::format("there are two planes '{}': rename one", plane.name));
    }
  }
  planes_.push_back({plane.name, plane.point, normal});
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
