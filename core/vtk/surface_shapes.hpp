// Planes and instruments as triangles, for pictures.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/network.hpp>

namespace springnet {

struct SurfaceShapes {
  std::vector<Vector3> points;               // m, where the scene puts the surfaces
  std::vector<std::uint32_t> point_surface;  // surface of each point: planes first, then instruments
  std::vector<Face> triangles;
  std::vector<std::uint32_t> triangle_surface;
};

// A plane becomes a square about the projection of the network's centre, somewhat larger than the network.
[[nodiscard]] SurfaceShapes shapes_of(const Network& network);

}  // namespace springnet
