#include <springnet/mesh.hpp>

#include <algorithm>
#include <array>
#include <new>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "mesh/formats.hpp"

namespace springnet {
namespace {

struct Format {
  const char* ending;
  Mesh (*read)(const meshes::Source&);
};
constexpr std::array formats{Format{".msh", meshes::read_gmsh},    Format{".vtk", meshes::read_vtk_legacy},
                             Format{".vtu", meshes::read_vtk_xml}, Format{".vtp", meshes::read_vtk_xml},
                             Format{".obj", meshes::read_obj},     Format{".stl", meshes::read_stl},
                             Format{".ply", meshes::read_ply}};

}  // namespace

void Mesh::add_cell(CellType type, std::span<const std::uint32_t> points_of_cell) {
  if (points_of_cell.size() != corner_count(type)) {
    throw Error(ErrorKind::input, fmt::format("a {} has {} corners, {} were given", name_of(type), corner_count(type),
                                              points_of_cell.size()));
  }
  types.push_back(type);
  corners.insert(corners.end(), points_of_cell.begin(), points_of_cell.end());
  offsets.push_back(corners.size());
}

bool has_mesh_ending(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  return std::any_of(formats.begin(), formats.end(),
                     [&](const Format& format) { return meshes::equal_ignoring_case(ending, format.ending); });
}

static Mesh read(const std::filesystem::path& file, const LoadingCallback& loading, bool wants_cells) {
  const std::string ending = file.extension().string();
  for (const Format& format : formats) {
    if (!meshes::equal_ignoring_case(ending, format.ending)) continue;
    try {
      return format.read(meshes::Source(file, loading, wants_cells));
    } catch (const std::bad_alloc&) {
      throw Error(ErrorKind::input,
                  fmt::format("{}: the mesh does not fit into memory; use a coarser one", file.string()));
    }
  }
  throw Error(
      ErrorKind::input,
      fmt::format("{}: '{}' is not the extension of a mesh file; use .msh (Gmsh), .vtk, .vtu, .vtp, .obj, .stl or .ply",
                  file.string(), ending));
}

Mesh read_mesh(const std::filesystem::path& file, const LoadingCallback& loading) { return read(file, loading, true); }

Mesh read_points(const std::filesystem::path& file, const LoadingCallback& loading) {
  return read(file, loading, false);
}

}  // namespace springnet
