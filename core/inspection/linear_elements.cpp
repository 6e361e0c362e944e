#include "inspection/linear_elements.hpp"

#include <algorithm>
#include <cmath>

#include "layers/loaded_faces.hpp"

namespace springnet {
namespace {

// What rounding leaves of the load on an element at its reference is none.
constexpr double no_load = 1e-12;

// Positions of all nodes as arrays, at rest.
struct RestArrays {
  explicit RestArrays(const Network& network, const std::vector<NodeIndex>& nodes) {
    std::size_t end = 0;
    for (const NodeIndex node : nodes) end = std::max<std::size_t>(end, node + std::size_t{1});
    for (auto& c : coordinates) c.resize(end);
    zero.resize(end);
    for (const NodeIndex node : nodes)
      for (std::size_t c = 0; c < 3; ++c)
        coordinates[c][node] = network.nodes()[node].position[static_cast<Eigen::Index>(c)];
  }
  [[nodiscard]] layers::NodeArrays view() const {
    return {coordinates[0].data(), coordinates[1].data(), coordinates[2].data(), zero.data(), zero.data(), zero.data()};
  }
  std::vector<double> coordinates[3], zero;
};

layers::Corners corners_of(const Network& network, const std::vector<NodeIndex>& nodes) {
  layers::Corners corners;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    corners.position[i] = network.nodes()[nodes[i]].position;
    corners.velocity[i].setZero();
  }
  return corners;
}

}  // namespace

LinearElement element_at_rest(const Network& network, const Element& element, double& value) {
  LinearElement linear{};
  value = layers::nearest_turn(element.invariant, network.value_of(element), element.reference);
  const bool is_angle = element.invariant == Invariant::angle || element.invariant == Invariant::dihedral;
  linear.scale = is_angle ? 1.0 : std::abs(value);
  if (element.invariant != Invariant::enclosed_volume) {
    linear.nodes = element.nodes;
    layers::FirstOrder geometry;
    layers::first_order(element.invariant, corners_of(network, linear.nodes), geometry);
    linear.gradient.assign(geometry.gradient, geometry.gradient + linear.nodes.size());
    return linear;
  }
  linear.enclosure.emplace_back(element.nodes);
  linear.nodes = linear.enclosure[0].nodes();
  const RestArrays arrays(network, linear.nodes);
  for (std::size_t i = 0; i < linear.nodes.size(); ++i)
    linear.gradient.push_back(linear.enclosure[0].gradient(i, arrays.view()));
  return linear;
}

LinearElement pressed_face(const Network& network, const Face& face, double pressure) {
  LinearElement linear{};
  linear.nodes.assign(face.begin(), face.end());
  linear.scale = 1.0;
  linear.force = pressure;  // so that it does not count as harmless; it acts along no gradient
  linear.gradient.assign(3, Vector3::Zero());
  for (auto& row : linear.blocks.row)
    for (Vector3& part : row) part.setZero();  // no damping
  linear.blocks.damping = 0.0;
  const RestArrays arrays(network, linear.nodes);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3, last = (i + 2) % 3;
    const auto blocks = layers::LoadedFaces::blocks(face[i], {face[next], face[last], 0}, arrays.view(), pressure);
    linear.blocks.stiffness[i][i] = blocks[0];
    linear.blocks.stiffness[i][next] = blocks[1];
    linear.blocks.stiffness[i][last] = blocks[2];
  }
  return linear;
}

void linearise_element(const Network& network, const Element& element, LinearElement& linear) {
  if (!linear.is_enclosure()) {
    const layers::Corners corners = corners_of(network, linear.nodes);
    layers::FirstOrder geometry;
    layers::first_order(element.invariant, corners, geometry);
    layers::linearise(element.invariant, corners, geometry, {linear.force, linear.stiffness, linear.damping},
                      linear.blocks);
    return;
  }
  const RestArrays arrays(network, linear.nodes);
  linear.across.resize(linear.nodes.size());
  for (std::size_t i = 0; i < linear.nodes.size(); ++i)
    for (const layers::Enclosure::Spoke& spoke : linear.enclosure[0].spokes(i))
      linear.across[i].push_back(linear.force * layers::Enclosure::across(spoke, arrays.view()));
}

LinearElements::LinearElements(const Network& network, std::vector<LinearElement> elements)
    : elements_(std::move(elements)), start_(elements_.empty() ? 0 : network.nodes().size() + 1) {
  if (elements_.empty()) return;
  for (const LinearElement& e : elements_)
    for (const NodeIndex node : e.nodes) ++start_[node + 1];
  for (std::size_t k = 0; k + 1 < start_.size(); ++k) start_[k + 1] += start_[k];
  shares_.resize(start_.back());
  std::vector<std::size_t> at(start_.begin(), start_.end() - 1);
  for (ElementIndex e = 0; e < elements_.size(); ++e)
    for (std::uint32_t i = 0; i < elements_[e].nodes.size(); ++i) shares_[at[elements_[e].nodes[i]]++] = {e, i};
}

layers::Block LinearElements::diagonal(NodeIndex node, double stiffness_weight, double damping_weight) const {
  layers::Block sum = layers::Block::Zero();
  for (const LinearShare& share : of(node)) {
    const LinearElement& e = elements_[share.element];
    if (e.is_enclosure()) {
      const Vector3& g = e.gradient[share.place];
      sum += (stiffness_weight * e.stiffness + damping_weight * e.damping) * g * g.transpose();
    } else {
      sum += stiffness_weight * e.blocks.stiffness[share.place][share.place] +
             damping_weight * e.blocks.damping_block(share.place, share.place);
    }
  }
  return sum;
}

layers::Block LinearElements::diagonal(NodeIndex node, double t) const { return diagonal(node, t * t, t); }

bool LinearElements::plainly_definite() const {
  return std::all_of(elements_.begin(), elements_.end(), [](const LinearElement& e) {
    return e.stiffness >= 0.0 && e.damping >= 0.0 && std::abs(e.force) <= no_load * e.stiffness * e.scale;
  });
}

}  // namespace springnet
