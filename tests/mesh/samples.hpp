// Small meshes in every format and variant, and what must be read from them.
//
// `body_…`: a cube [0, 1]^3, a wedge at x = 1, a pyramid on top and a tetrahedron at the pyramid: volume 1 + 1/2 + 1/3
// + 1/6 = 2, 12 points, a surface of 20 triangles; then the bottom as a quadrilateral, corner 0 as a vertex, and a
// point that nothing uses.
#pragma once

#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/mesh.hpp>

#include "temporary_folder.hpp"

namespace springnet::testing {

struct Sample {
  std::string name;  // with the extension
  std::string bytes;
};

template <class T>
void put(std::string& bytes, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes += raw[big_endian ? sizeof(T) - 1 - i : i];
}

inline std::string replaced(std::string text, std::string_view what, std::string_view by) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::logic_error("not there: " + std::string(what));
  return text.replace(at, what.size(), by);
}

inline Mesh read_text_mesh(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  folder.write(name, bytes);
  return read_mesh(folder.path() / name);
}

// The message of the error, without the folder; empty if there is none.
std::string error_of(const std::string& name, const std::string& bytes);

std::vector<Sample> gmsh_samples();         // body_…: groups "bottom" and "pin"
std::vector<Sample> vtk_legacy_samples();   // body_…: group "material 7" the solids, "material 2" the others
std::vector<Sample> vtk_xml_samples();      // the same
std::vector<Sample> vtk_piece_samples();    // .vtu of two pieces, each the body, the second one 10 m higher in z
std::vector<Sample> vtk_polygon_samples();  // a .vtp and .vtk of vertices, lines, polygons and a strip
std::vector<Sample> grid_samples();         // structured ones, 3 x 2 x 2 points
Sample obj_sample();
std::vector<Sample> stl_samples();  // a tetrahedron with corners at 0 and the unit vectors
// The same, with an edge from the corner at 0 to that on z; the last one is a cloud of three points.
std::vector<Sample> ply_samples();
std::vector<Sample> all_samples();

const std::vector<Vector3>& body_points();  // 13, the last one unused
struct SampleCell {
  CellType type;
  std::vector<std::uint32_t> points;
};
const std::vector<SampleCell>& body_cells();

// Sum over the solid cells.
double volume_of(const Mesh& mesh);
double area_of(const Mesh& mesh, const std::vector<Face>& faces);
double enclosed_volume(const Mesh& mesh, const std::vector<Face>& faces);
// Points - edges + faces of a surface.
long euler_characteristic(const std::vector<Face>& faces);
// Whether one of the notes has these facts.
bool has_note(const Mesh& mesh, std::string_view facts);
const MeshGroup& group_of(const Mesh& mesh, std::string_view name);

}  // namespace springnet::testing
