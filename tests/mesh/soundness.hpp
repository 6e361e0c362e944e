// Invariants of every mesh that was read, whatever the file contained.
#pragma once

#include <springnet/mesh.hpp>

namespace springnet::testing {

inline bool is_sound(const Mesh& mesh) {
  if (mesh.offsets.size() != mesh.types.size() + 1 || mesh.offsets.front() != 0) return false;
  if (mesh.offsets.back() != mesh.corners.size()) return false;
  bool fine = mesh.cell_count() > 0;
  for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
    fine = fine && mesh.offsets[cell + 1] - mesh.offsets[cell] == corner_count(mesh.types[cell]);
  }
  for (const std::uint32_t corner : mesh.corners) fine = fine && corner < mesh.points.size();
  for (const Vector3& point : mesh.points) fine = fine && point.allFinite();
  for (const MeshGroup& group : mesh.groups) {
    fine = fine && !group.points.empty();
    for (const std::uint32_t point : group.points) fine = fine && point < mesh.points.size();
    for (const std::uint32_t cell : group.cells) fine = fine && cell < mesh.cell_count();
  }
  return fine;
}

}  // namespace springnet::testing
