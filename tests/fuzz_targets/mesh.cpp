// A mesh of one format: refused, or sound.
#include <springnet/mesh.hpp>

#include "mesh/soundness.hpp"
#include "target.hpp"

using namespace springnet;

extern const char* const mesh_file;  // "mesh.msh": its ending is the format

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path& file = testing::file_of(data, size, mesh_file);
  testing::read_or_refuse(file.native(), [&] {
    const Mesh mesh = read_mesh(file);
    testing::require(testing::is_sound(mesh), "the mesh is sound");
    // What a scene makes of it.
    const std::vector<Edge> edges = edges_of(mesh, {.face_diagonals = true, .space_diagonals = true});
    const std::vector<Face> surface = surface_of(mesh);
    testing::require(hinges_of(surface).size() <= edges.size(), "hinges are edges");
    for (const auto& corners : tetrahedra_of(mesh)) {
      for (const std::uint32_t corner : corners) testing::require(corner < mesh.points.size(), "a corner is a point");
    }
    for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
      testing::require(measure_of(mesh, cell) >= 0.0, "a measure is not below 0");
    }
  });
  return 0;
}
