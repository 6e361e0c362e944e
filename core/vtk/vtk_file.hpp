// A file of VTK's XML formats with its data appended as raw bytes. The header depends on sizes only, so the size of the
// file is known before there are data.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/output_folder.hpp>

namespace springnet {

struct VtkArray {
  enum class Place { field, points, cells, point_data, cell_data };  // cells: connectivity, offsets, types
  enum class Type { float64, float32, int64, uint8 };
  Place place;
  std::string_view name;
  Type type;
  int components;              // 1 or 3
  std::size_t count;           // of tuples
  const void* data = nullptr;  // doubles for both kinds of floats, std::int64_t, std::uint8_t; count x components
};

enum class VtkKind { unstructured, polygons };  // .vtu, .vtp

struct VtkFile {
  VtkKind kind;
  std::size_t points;
  std::size_t cells;
  std::vector<VtkArray> arrays;
};

[[nodiscard]] std::uint64_t vtk_bytes(const VtkFile& file);
// Throws Error(input) if the file cannot be created, OutputError if it cannot be written completely.
void write_vtk(const OutputFile& path, const VtkFile& file);

}  // namespace springnet
