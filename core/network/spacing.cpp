#include "network/spacing.hpp"

#include <algorithm>
#include <limits>

#include "network/checks.hpp"

namespace springnet {
namespace {

// Relative accuracy that a length needs: three digits for springs, the kept accuracy for rigid connections.
constexpr double spring_accuracy = 1e-3, rigid_accuracy = 1e-8;

double greatest_coordinate(const Node& a, const Node& b) {
  return std::max(a.position.cwiseAbs().maxCoeff(), b.position.cwiseAbs().maxCoeff());
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

}  // namespace

void check_spacing(const Network& network, const Checked& checked) {
  const std::vector<Node>& nodes = network.nodes();
  const auto apart = [&](NodeIndex a, NodeIndex b) { return checks::distance(nodes[a].position, nodes[b].position); };
  for (std::size_t s = checked.springs; s < network.springs().size(); ++s) {
    const auto& [first, second, material, rest_length] = network.springs()[s];
    const double far = greatest_coordinate(nodes[first], nodes[second]);
    const double length = rest_length > 0.0 ? rest_length : apart(first, second);
    if (is_lost(far, length, spring_accuracy))
      refuse(fmt::format("spring {} from node {} to node {}", s, first, second), length, far);
  }
  for (std::size_t e = checked.elements; e < network.elements().size(); ++e) {
    const Element& element = network.elements()[e];
    for (std::size_t i = 1; i < element.nodes.size(); ++i) {
      const NodeIndex first = element.nodes[i - 1], second = element.nodes[i];
      const double far = greatest_coordinate(nodes[first], nodes[second]), length = apart(first, second);
      if (is_lost(far, length, spring_accuracy))
        refuse(fmt::format("element {} between node {} and node {}", e, first, second), length, far);
    }
  }
  for (std::size_t r = checked.rigids; r < network.rigids().size(); ++r) {
    const auto& [first, second, length] = network.rigids()[r];
    const double far = greatest_coordinate(nodes[first], nodes[second]);
    if (is_lost(far, length, rigid_accuracy))
      refuse(fmt::format("the rigid connection from node {} to node {}", first, second), length, far);
  }
}

}  // namespace springnet
