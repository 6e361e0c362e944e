#include "network/spacing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "network/checks.hpp"

namespace springnet {
namespace {

// Relative accuracy that a length needs: three digits for springs, the kept accuracy for rigid connections.
constexpr double spring_accuracy = 1e-3, rigid_accuracy = 1e-8;

double greatest_coordinate(const Vector3& a, const Vector3& b) {
  return std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
}

// Spacing of floating-point numbers at a coordinate, m.
double rounding_at(double coordinate) {
  return std::nextafter(coordinate, std::numeric_limits<double>::infinity()) - coordinate;
}

bool is_lost(double coordinate, double length, double accuracy) {
  return length > 0.0 && rounding_at(coordinate) > accuracy * length;
}

[[noreturn]] void refuse(const std::string& what, double length, double coordinate) {
  checks::fail(
      fmt::format("{} is {:.4g} m long, but at a coordinate of {:.4g} m neighbouring numbers are {:.2g} m apart: its "
                  "length is lost to rounding; move everything nearer to the origin",
                  what, length, coordinate, rounding_at(coordinate)));
}

// Whether the greatest coordinate of all nodes resolves the shortest rest length from spring `first` on, so that none
// is lost. Two passes over arrays, in place of a look at two nodes for each spring.
bool all_resolved(const Network& network, std::size_t first) {
  const SpringList& springs = network.springs();
  const std::vector<Vector3>& positions = network.nodes().positions();
  if (springs.size() == first) return true;
  if (positions.size() > 4 * (springs.size() - first)) return false;  // not worth a pass over the nodes
  double shortest = springs.rest_lengths()[first], farthest = 0.0;
  const auto node_count = static_cast<std::int64_t>(positions.size());
  const auto spring_count = static_cast<std::int64_t>(springs.rest_lengths().is_uniform() ? first : springs.size());
#pragma omp parallel for schedule(static) reduction(max : farthest) if (node_count > 100000)
  for (std::int64_t k = 0; k < node_count; ++k) {
    const Vector3& p = positions[static_cast<std::size_t>(k)];
    farthest = std::max({farthest, std::abs(p.x()), std::abs(p.y()), std::abs(p.z())});
  }
#pragma omp parallel for schedule(static) reduction(min : shortest) if (spring_count > 100000)
  for (std::int64_t s = static_cast<std::int64_t>(first); s < spring_count; ++s)
    shortest = std::min(shortest, springs.rest_lengths()[static_cast<std::size_t>(s)]);
  return shortest > 0.0 && !is_lost(farthest, shortest, spring_accuracy);
}

}  // namespace

void check_spacing(const Network& network, const Checked& checked) {
  const std::vector<Vector3>& positions = network.nodes().positions();
  const auto apart = [&](NodeIndex a, NodeIndex b) { return checks::distance(positions[a], positions[b]); };
  const std::size_t spring_count = all_resolved(network, checked.springs) ? checked.springs : network.springs().size();
  for (std::size_t s = checked.springs; s < spring_count; ++s) {
    const auto [first, second, material, rest_length] = network.springs()[s];
    const double far = greatest_coordinate(positions[first], positions[second]);
    const double length = rest_length > 0.0 ? rest_length : apart(first, second);
    if (is_lost(far, length, spring_accuracy))
      refuse(fmt::format("spring {} from node {} to node {}", s, first, second), length, far);
  }
  for (std::size_t e = checked.elements; e < network.elements().size(); ++e) {
    const Element& element = network.elements()[e];
    for (std::size_t i = 1; i < element.nodes.size(); ++i) {
      const NodeIndex first = element.nodes[i - 1], second = element.nodes[i];
      const double far = greatest_coordinate(positions[first], positions[second]), length = apart(first, second);
      if (is_lost(far, length, spring_accuracy))
        refuse(fmt::format("element {} between node {} and node {}", e, first, second), length, far);
    }
  }
  for (std::size_t r = checked.rigids; r < network.rigids().size(); ++r) {
    const auto& [first, second, length] = network.rigids()[r];
    const double far = greatest_coordinate(positions[first], positions[second]);
    if (is_lost(far, length, rigid_accuracy))
      refuse(fmt::format("the rigid connection from node {} to node {}", first, second), length, far);
  }
}

}  // namespace springnet
