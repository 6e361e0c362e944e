#include "vtk/vtk_file.hpp"

#include <span>

#include <fmt/format.h>

#include "files/checked_file.hpp"

namespace springnet {

namespace {

using Place = VtkArray::Place;
using Type = VtkArray::Type;

constexpr std::string_view end = "\n  </AppendedData>\n</VTKFile>\n";

std::size_t size_of(Type type) {
  switch (type) {
    case Type::float64:
    case Type::int64:
      return 8;
    case Type::float32:
      return 4;
    case Type::uint8:
      return 1;
  }
  return 0;
}

std::string_view name_of(Type type) {
  switch (type) {
    case Type::float64:
      return "Float64";
    case Type::float32:
      return "Float32";
    case Type::int64:
      return "Int64";
    case Type::uint8:
      return "UInt8";
  }
  return "";
}

std::size_t numbers_in(const VtkArray& array) { return array.count * static_cast<std::size_t>(array.components); }
std::uint64_t bytes_in(const VtkArray& array) { return numbers_in(array) * size_of(array.type); }

// The arrays of a place with the offsets of their bytes, which follow those of earlier arrays; each is preceded by its
// length.
std::string section(const VtkFile& file, Place place, std::string_view element, std::string_view indent) {
  std::string text = fmt::format("{}<{}>\n", indent, element);
  std::uint64_t offset = 0;
  for (const VtkArray& array : file.arrays) {
    if (array.place == place) {
      text += fmt::format("{}  <DataArray type=\"{}\" Name=\"{}\" ", indent, name_of(array.type), array.name);
      text += place == Place::field ? fmt::format("NumberOfTuples=\"{}\" ", array.count)
                                    : fmt::format("NumberOfComponents=\"{}\" ", array.components);
      text += fmt::format("format=\"appended\" offset=\"{}\"/>\n", offset);
    }
    offset += sizeof(std::uint64_t) + bytes_in(array);
  }
  return text + fmt::format("{}</{}>\n", indent, element);
}

std::string header(const VtkFile& file) {
  const bool polygons = file.kind == VtkKind::polygons;
  const std::string_view kind = polygons ? "PolyData" : "UnstructuredGrid";
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <{}>\n",
      kind, kind);
  text += section(file, Place::field, "FieldData", "    ");
  text += polygons ? fmt::format(
                         "    <Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
                         "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
                         file.points, file.cells)
                   : fmt::format("    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", file.points, file.cells);
  text += section(file, Place::point_data, "PointData", "      ");
  text += section(file, Place::cell_data, "CellData", "      ");
  text += section(file, Place::points, "Points", "      ");
  text += section(file, Place::cells, polygons ? "Polys" : "Cells", "      ");
  return text + fmt::format("    </Piece>\n  </{}>\n  <AppendedData encoding=\"raw\">\n_", kind);
}

void write_array(CheckedFile& out, const VtkArray& array) {
  const std::uint64_t bytes = bytes_in(array);
  write_numbers<std::uint64_t>(out, std::span<const std::uint64_t>(&bytes, 1));
  const std::size_t count = numbers_in(array);
  const auto values = [&]<class Value>(Value) {
    return std::span<const Value>(static_cast<const Value*>(array.data), count);
  };
  switch (array.type) {
    case Type::float64:
      write_numbers<double>(out, values(double{}));
      break;
    case Type::float32:
      write_numbers<float>(out, values(double{}));
      break;
    case Type::int64:
      write_numbers<std::int64_t>(out, values(std::int64_t{}));
      break;
    case Type::uint8:
      write_numbers<std::uint8_t>(out, values(std::uint8_t{}));
      break;
  }
}

}  // namespace

std::uint64_t vtk_bytes(const VtkFile& file) {
  std::uint64_t bytes = header(file).size() + end.size();
  for (const VtkArray& array : file.arrays) bytes += sizeof(std::uint64_t) + bytes_in(array);
  return bytes;
}

void write_vtk(const OutputFile& path, const VtkFile& file) {
  CheckedFile out(path);
  const std::string text = header(file);
  out.write(text.data(), text.size());
  for (const VtkArray& array : file.arrays) write_array(out, array);
  out.write(end.data(), end.size());
  out.close();
}

}  // namespace springnet
