#include "view/touches.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

#include "view/frames.hpp"
#include "view/rounding.hpp"

namespace springnet::view {

namespace {

constexpr double force_rounding = 1e-12;  // relative to the largest force

// Numbers of the touches that have a force.
std::vector<std::size_t> with_force(const std::vector<BodyTouch>& touches) {
  double largest = 0.0;
  for (const BodyTouch& each : touches) largest = std::max(largest, each.force.norm());
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < touches.size(); ++k) {
    if (touches[k].force.norm() > force_rounding * largest) found.push_back(k);
  }
  return found;
}

void keep_largest(const std::vector<BodyTouch>& touches, std::size_t count, std::vector<std::size_t>& chosen) {
  if (chosen.size() <= count) return;
  std::stable_sort(chosen.begin(), chosen.end(),
                   [&](std::size_t a, std::size_t b) { return touches[a].force.norm() > touches[b].force.norm(); });
  chosen.resize(count);
  std::sort(chosen.begin(), chosen.end());
}

// The node with the greatest weight among those that are shown. Exact as a float: a page has no room for 2^24 nodes.
float shown_node(const BodyTouch& touch, const Selection& selection) {
  std::uint32_t found = not_shown;
  double weight = -1.0;
  for (std::size_t i = 0; i < touch.count; ++i) {
    const std::uint32_t place = selection.node_place[touch.nodes[i]];
    if (place == not_shown || std::abs(touch.weights[i]) <= weight) continue;
    found = place;
    weight = std::abs(touch.weights[i]);
  }
  return found == not_shown ? -1.0F : static_cast<float>(found);
}

}  // namespace

std::size_t touch_capacity(const Network& network) {
  if (network.contacts().empty()) return 0;
  std::set<NodeIndex> nodes;
  for (const BodyContact& contact : network.contacts()) {
    nodes.insert(contact.first.begin(), contact.first.end());
    nodes.insert(contact.second.begin(), contact.second.end());
  }
  // Nodes, faces, and three edges of each face.
  const std::size_t parts = nodes.size() + 4 * network.faces().size();
  return parts < 2 ? 0 : std::min(max_touches, parts * (parts - 1) / 2);
}

std::size_t take_touches(const std::vector<BodyTouch>& touches, const Selection& selection, std::span<float> row) {
  std::fill(row.begin(), row.end(), 0.0F);
  std::vector<std::size_t> chosen = with_force(touches);
  const std::size_t count = chosen.size();
  keep_largest(touches, row.size() / touch_numbers, chosen);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const BodyTouch& touch = touches[chosen[k]];
    const std::span<float> entry = row.subspan(touch_numbers * k, touch_numbers);
    entry[0] = shown_node(touch, selection);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto component = static_cast<Eigen::Index>(axis);
      entry[1 + axis] = to_float(touch.position[component]);
      entry[4 + axis] = to_float(touch.force[component]);
    }
  }
  return count;
}

}  // namespace springnet::view
