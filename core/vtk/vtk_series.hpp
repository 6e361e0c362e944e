// What VtkWriter writes, and how much of it.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

#include "files/checked_file.hpp"
#include "vtk/surface_shapes.hpp"
#include "vtk/vtk_file.hpp"

namespace springnet {

inline constexpr const char* vtk_folder = "vtk";
[[nodiscard]] std::string vtk_index_name();  // run.pvd in that folder

// The names of files of an earlier series, and of nothing else that may be in the folder.
[[nodiscard]] std::vector<std::string> vtk_series_files(const OutputFolder& folder);

// Bytes of one record, and of the index at most.
[[nodiscard]] double vtk_record_bytes(const Network& network, const OutputOptions& options);
[[nodiscard]] double vtk_index_bytes(const Network& network, double records);

// Data that belongs to a simulation's state, in arrays that stay.
struct VtkNet {
  explicit VtkNet(const Network& network);
  void take(const Simulation& simulation);
  // Without data where the state has not been taken.
  [[nodiscard]] VtkFile file(const OutputOptions& options) const;

  // Points: nodes.
  std::size_t nodes, springs, rigids, faces;
  std::vector<double> time, places, velocities, forces;
  std::vector<std::uint8_t> contact, fixed;
  std::vector<std::int64_t> surface, node;  // surface: that the node is in contact with, the first of several; -1: none
  // Cells: springs, rigid connections, faces. A face is broken where a spring along one of its edges is.
  std::vector<std::int64_t> connectivity, offsets, number;
  std::vector<std::uint8_t> types, kind, broken;
  std::vector<double> tension, energy, strain;

 private:
  std::vector<double> rest_lengths_;  // m
  // Of all faces one after another: springs along their edges, and where those of each end.
  std::vector<SpringIndex> edge_springs_;
  std::vector<std::size_t> edge_springs_end_;
  std::vector<double> tensions_, energies_;
};

struct VtkSurfaces {
  explicit VtkSurfaces(const Network& network);
  void take(const Simulation& simulation);
  [[nodiscard]] VtkFile file(const OutputOptions& options) const;
  [[nodiscard]] bool empty() const noexcept { return shapes.triangles.empty(); }

  SurfaceShapes shapes;
  std::vector<double> time, places, forces;
  std::vector<std::int64_t> connectivity, offsets, surface, touching;

 private:
  std::vector<Vector3> starts_;  // m, where surface_position is when the surface is where the scene puts it
};

class VtkSeries {
 public:
  VtkSeries(const OutputFile& folder, const Network& network, const OutputOptions& options);
  // Where a picture cannot be written, the series ends with the one before.
  void record(const Simulation& simulation);
  void close() { index_.close(); }
  [[nodiscard]] std::uintmax_t bytes() const noexcept { return bytes_; }

 private:
  void write_pictures(const Simulation& simulation);
  void drop_last();

  OutputFolder::Pointer folder_;
  OutputOptions options_;
  VtkNet net_;
  VtkSurfaces surfaces_;
  CheckedFile index_;
  std::uint64_t index_end_ = 0;  // where the next entry goes
  std::uintmax_t bytes_ = 0;
  std::size_t records_ = 0;
  double last_ = std::numeric_limits<double>::quiet_NaN();  // s, of the last picture
};

}  // namespace springnet
