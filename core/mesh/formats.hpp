// One reader a format. Each throws Error(input) for what it cannot read.
#pragma once

#include <springnet/mesh.hpp>

#include "mesh/source.hpp"

namespace springnet::meshes {

[[nodiscard]] Mesh read_gmsh(const Source& source);
[[nodiscard]] Mesh read_vtk_legacy(const Source& source);
[[nodiscard]] Mesh read_vtk_xml(const Source& source);
[[nodiscard]] Mesh read_obj(const Source& source);
[[nodiscard]] Mesh read_stl(const Source& source);
[[nodiscard]] Mesh read_ply(const Source& source);

}  // namespace springnet::meshes
