#include <algorithm>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/scene.hpp>

#include "simulation/surface.hpp"

namespace springnet {

void check_starts(const Scene& scene) {
  const std::vector<Node>& nodes = scene.network.nodes();
  // Above what the simulation takes for rounding, which refuses the rest.
  double size = 0.0;  // m
  for (const Node& node : nodes) size = std::max(size, node.position.cwiseAbs().maxCoeff());
  const double tolerance = 1e-9 * size;
  std::size_t place = 0;
  const auto check = [&](const Surface& surface, std::size_t number) {
    const Vector3 displacement = surface.trajectory().at(0.0).displacement;
    for (NodeIndex k = 0; k < nodes.size(); ++k) {
      const double distance = surface.distance(nodes[k].position - displacement);
      if (nodes[k].fixed || distance >= -tolerance) continue;
      const std::string what = misplaced(k, -distance, surface.is_plane(), surface.description(number));
      const std::string where = place < scene.surfaces.size() ? scene.surfaces[place] + ": " : "";
      throw Error(ErrorKind::input, where + what);
    }
    ++place;
  };
  for (std::size_t j = 0; j < scene.network.planes().size(); ++j) check(Surface(scene.network.planes()[j]), j);
  for (std::size_t j = 0; j < scene.network.instruments().size(); ++j)
    check(Surface(scene.network.instruments()[j]), j);
}

}  // namespace springnet
