#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/scene.hpp>

#include "constraints/body_contacts.hpp"
#include "constraints/obstacle.hpp"

namespace springnet {

namespace {

void check_bodies(const Scene& scene) {
  if (scene.network.contacts().empty()) return;
  const std::string where = scene.contacts.empty() ? "" : scene.contacts.front() + ": ";
  try {
    check_apart(scene.network);
  } catch (const Error& error) {
    throw Error(error.kind(), where + error.what());
  }
}

}  // namespace

void check_starts(const Scene& scene) {
  check_bodies(scene);
  const NodeList& nodes = scene.network.nodes();
  const double size = size_of(scene.network);
  std::size_t place = 0;
  const auto check = [&](const Obstacle& surface, std::size_t number) {
    const Pose pose = surface.at(just_after(0.0));
    for (NodeIndex k = 0; k < nodes.size(); ++k) {
      const double depth = nodes[k].fixed ? 0.0 : starting_depth(surface, pose, nodes[k].position, size);
      if (depth == 0.0) continue;
      const std::string what = misplaced(k, depth, surface.is_plane(), surface.description(number));
      const std::string where = place < scene.surfaces.size() ? scene.surfaces[place] + ": " : "";
      throw Error(ErrorKind::input, where + what);
    }
    ++place;
  };
  for (std::size_t j = 0; j < scene.network.planes().size(); ++j) check(Obstacle(scene.network.planes()[j]), j);
  for (std::size_t j = 0; j < scene.network.instruments().size(); ++j)
    check(Obstacle(scene.network.instruments()[j]), j);
}

}  // namespace springnet
