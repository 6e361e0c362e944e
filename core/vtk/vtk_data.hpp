// A record as the arrays of VTK files.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <springnet/network.hpp>
#include <springnet/scene.hpp>

#include "record/record.hpp"
#include "vtk/surface_shapes.hpp"
#include "vtk/vtk_file.hpp"

namespace springnet {

// Nodes, springs, rigid connections and faces.
struct VtkNet {
  // law_states: laws whose internal states are written.
  explicit VtkNet(const Network& network, const std::vector<LawStates>& law_states = {});
  void take(const Record& record);
  // The last record; valid as long as that record, to whose arrays it refers. Before the first record it has sizes
  // only.
  [[nodiscard]] VtkFile file(OutputOptions::Precision precision) const;

  // Points: nodes.
  std::size_t nodes, springs, rigids, faces;
  double time = 0.0;                                                         // s
  const double *places = nullptr, *velocities = nullptr, *forces = nullptr;  // x, y, z of each
  std::vector<std::uint8_t> contact, fixed;
  std::vector<std::int64_t> surface, node;  // surface: the (first) one that the node is in contact with; -1: none
  // Cells: springs, rigid connections, faces. A face is broken once a spring along one of its edges is.
  std::vector<std::int64_t> connectivity, offsets, number;
  std::vector<std::uint8_t> types, kind, broken;
  std::vector<double> tension, energy, strain;
  struct InternalStateArray {
    std::string name;  // "plastic flow"
    std::vector<double> values;
  };
  std::vector<InternalStateArray> states;

 private:
  // Of a spring of each material: numbers in `states`, in the order of Simulation::internal_states().
  std::vector<std::vector<std::size_t>> states_of_material_;
  std::vector<std::pair<SpringIndex, MaterialIndex>> springs_with_states_;
  std::vector<double> rest_lengths_;  // m
  // Springs along the edges of all faces, face by face, and where those of each face end.
  std::vector<SpringIndex> edge_springs_;
  std::vector<std::size_t> edge_springs_end_;
};

// Planes and instruments.
struct VtkSurfaces {
  explicit VtkSurfaces(const Network& network);
  void take(const Record& record);
  [[nodiscard]] VtkFile file(OutputOptions::Precision precision) const;
  [[nodiscard]] bool empty() const noexcept { return shapes.triangles.empty(); }

  SurfaceShapes shapes;
  double time = 0.0;  // s
  std::vector<double> places, forces;
  std::vector<std::int64_t> connectivity, offsets, surface, touching;

 private:
  std::vector<Vector3> starts_;  // m, surface_position at the start
};

}  // namespace springnet
