// A scene to start from, for a mesh.
#pragma once

#include <string>

#include <springnet/mesh.hpp>
#include <springnet/mesh_summary.hpp>

namespace springnet::tool {

struct MeshScene {
  std::string body;   // [[body]]
  std::string scene;  // the whole file; it runs as it is
};
// `file`: the mesh as the scene names it; its stem becomes the name of the body. The body hangs from its uppermost
// nodes under gravity and is stiff enough to sag by about 2 % of its size. The mesh must have an extent.
[[nodiscard]] MeshScene scene_of(const std::string& file, const Mesh& mesh, const MeshSummary& summary);

}  // namespace springnet::tool
