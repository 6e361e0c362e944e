// VTK's XML files of unstructured grids and polygons ("VTK File Formats", section "XML File Formats").
#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <pugixml.hpp>

#include "mesh/builder.hpp"
#include "mesh/formats.hpp"
#include "mesh/vtk_arrays.hpp"
#include "mesh/vtk_cells.hpp"

namespace springnet::meshes {
namespace {

class VtkXmlReader {
 public:
  explicit VtkXmlReader(const Source& source) : source_(source), builder_(source) {}

  Mesh read() {
    parse();
    const pugi::xml_node file = document_.child("VTKFile");
    if (!file) source_.fail({0, false}, "this is XML without <VTKFile>, so not a VTK file; give it its own extension");
    set_encoding(file);
    arrays_.emplace(source_, encoding_);
    const std::string_view type = file.attribute("type").value();
    if (type != "UnstructuredGrid" && type != "PolyData") {
      arrays_->fail(file,
                    fmt::format("a VTK file of this type is not read; save it as UnstructuredGrid (.vtu) or PolyData "
                                "(.vtp){}",
                                type.starts_with('P') ? ", or name the file of one of its pieces" : ""));
    }
    const pugi::xml_node grid = file.child(type.data());
    std::size_t pieces = 0;
    for (const pugi::xml_node piece : grid.children("Piece")) {
      read_piece(piece, type == "PolyData");
      ++pieces;
    }
    if (pieces == 0) arrays_->fail(file, fmt::format("there is no <Piece> in <{}>; export the mesh again", type));
    if (pieces > 1) {
      builder_.note(
          fmt::format("the file has {} pieces, which are not joined: points on their borders are duplicated", pieces));
    }
    return std::move(builder_).finish();
  }

 private:
  // Appended data may be arbitrary bytes, not valid XML: they are removed before parsing.
  void parse() {
    const std::string_view text = source_.text();
    std::string_view xml = text;
    std::string without_data;
    const std::size_t appended = text.find("<AppendedData");
    if (appended != std::string_view::npos) {
      const std::size_t tag_end = text.find('>', appended);
      const std::size_t underscore = text.find('_', std::min(tag_end, text.size()));
      if (tag_end == std::string_view::npos || underscore == std::string_view::npos) {
        source_.fail({appended, false}, "<AppendedData> has no data after '_'; the file is cut off, export it again");
      }
      const std::string_view tag = text.substr(appended, tag_end - appended);
      encoding_.appended_raw = tag.find("raw") != std::string_view::npos;
      encoding_.appended = text.substr(underscore + 1);
      without_data = std::string(text.substr(0, appended)) + "</VTKFile>";
      xml = without_data;
    }
    // Keep line ends, so that offsets match the file.
    const auto options = pugi::parse_default & ~pugi::parse_eol;
    const pugi::xml_parse_result result = document_.load_buffer(xml.data(), xml.size(), options, pugi::encoding_utf8);
    if (!result) {
      source_.fail({static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0)), false},
                   fmt::format("{}; this is not valid XML, or cut off: export the mesh again", result.description()));
    }
  }

  void set_encoding(pugi::xml_node file) {
    const auto check = [&](const char* attribute, std::string_view value,
                           std::initializer_list<std::string_view> known) {
      if (std::find(known.begin(), known.end(), value) != known.end()) return;
      source_.fail(ArrayReader::place(file),
                   fmt::format("{} should be '{}'; save the mesh with that", attribute, fmt::join(known, "' or '")));
    };
    const std::string_view order = file.attribute("byte_order").as_string("LittleEndian");
    check("byte_order", order, {"LittleEndian", "BigEndian"});
    encoding_.swap = (order == "LittleEndian") != (std::endian::native == std::endian::little);
    const std::string_view header = file.attribute("header_type").as_string("UInt32");
    check("header_type", header, {"UInt32", "UInt64"});
    encoding_.wide_header = header == "UInt64";
    const std::string_view compressor = file.attribute("compressor").value();
    check("compressor", compressor, {"", "vtkZLibDataCompressor"});
    encoding_.compressed = !compressor.empty();
  }

  void read_piece(pugi::xml_node piece, bool polygons) {
    const std::uint64_t points = arrays_->number(piece, "NumberOfPoints");
    const auto first_point = static_cast<std::uint32_t>(builder_.point_count());
    VtkCells cells(builder_, first_point);
    if (points > 0) add_points(piece, points);
    if (polygons) {
      add_polygons(cells, piece, "Verts", "NumberOfVerts",
                   vtk::poly_vertex);  // VTK's numbers of cells are in this order
      add_polygons(cells, piece, "Lines", "NumberOfLines", vtk::poly_line);
      add_polygons(cells, piece, "Polys", "NumberOfPolys", vtk::polygon);
      add_polygons(cells, piece, "Strips", "NumberOfStrips", vtk::triangle_strip);
    } else {
      add_cells(cells, piece);
    }
    for (const pugi::xml_node array : piece.child("CellData").children("DataArray")) {
      if (gives_groups(array)) {
        cells.groups_of_cells(array.attribute("Name").value(), arrays_->integers(array, cells.count()));
      }
    }
    for (const pugi::xml_node array : piece.child("PointData").children("DataArray")) {
      if (gives_groups(array)) {
        cells.groups_of_points(array.attribute("Name").value(), arrays_->integers(array, points));
      }
    }
  }

  bool gives_groups(pugi::xml_node array) {
    const std::string name = array.attribute("Name").value();
    if (!VtkCells::is_group_name(name) || array.attribute("NumberOfComponents").as_int(1) != 1) return false;
    if (is_integer(arrays_->type(array))) return true;
    builder_.note(fmt::format("array '{}' does not have whole numbers and gives no groups", name));
    return false;
  }

  void add_points(pugi::xml_node piece, std::uint64_t count) {
    const pugi::xml_node array = piece.child("Points").child("DataArray");
    if (!array) arrays_->fail(piece, "<Piece> has no <DataArray> in <Points>; export the mesh again");
    const std::vector<double> coordinates = arrays_->reals(array, count, 3);
    builder_.reserve_points(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i + 2 < coordinates.size(); i += 3) {
      builder_.add_point({coordinates[i], coordinates[i + 1], coordinates[i + 2]}, ArrayReader::place(array));
    }
  }

  pugi::xml_node array_of(pugi::xml_node parent, const char* name) {
    const pugi::xml_node array = parent.find_child_by_attribute("DataArray", "Name", name);
    if (!array)
      arrays_->fail(parent, fmt::format("<{}> has no array '{}'; export the mesh again", parent.name(), name));
    return array;
  }

  struct Lists {
    std::vector<std::int64_t> ends;
    std::vector<std::int64_t> points;
    [[nodiscard]] std::span<const std::int64_t> cell(std::size_t i) const {
      const std::int64_t begin = i == 0 ? 0 : ends[i - 1];
      return {points.data() + begin, static_cast<std::size_t>(ends[i] - begin)};
    }
  };
  Lists lists_of(pugi::xml_node parent, std::uint64_t count) {
    Lists lists;
    const pugi::xml_node offsets = array_of(parent, "offsets");
    lists.ends = arrays_->integers(offsets, count);
    if (lists.ends.empty()) return lists;
    if (lists.ends.front() < 0 || !std::is_sorted(lists.ends.begin(), lists.ends.end())) {
      arrays_->fail(offsets, "offsets of cells do not increase; export the mesh again");
    }
    lists.points = arrays_->integers(array_of(parent, "connectivity"), static_cast<std::uint64_t>(lists.ends.back()));
    return lists;
  }

  void add_polygons(VtkCells& cells, pugi::xml_node piece, const char* name, const char* number, int type) {
    if (!piece.attribute(number)) return;
    const std::uint64_t count = arrays_->number(piece, number);
    if (count == 0) return;
    const pugi::xml_node parent = piece.child(name);
    if (!parent) arrays_->fail(piece, fmt::format("<Piece> has no <{}>; export the mesh again", name));
    const Lists lists = lists_of(parent, count);
    for (std::size_t i = 0; i < lists.ends.size(); ++i) cells.add(type, lists.cell(i), ArrayReader::place(parent));
  }

  void add_cells(VtkCells& cells, pugi::xml_node piece) {
    const std::uint64_t count = arrays_->number(piece, "NumberOfCells");
    if (count == 0) return;
    const pugi::xml_node parent = piece.child("Cells");
    if (!parent) arrays_->fail(piece, "<Piece> has no <Cells>; export the mesh again");
    const Lists lists = lists_of(parent, count);
    const std::vector<std::int64_t> types = arrays_->integers(array_of(parent, "types"), count);
    for (std::size_t i = 0; i < lists.ends.size(); ++i) {
      cells.add(static_cast<int>(std::clamp<std::int64_t>(types[i], -1, 1000)), lists.cell(i),
                ArrayReader::place(parent));
    }
  }

  const Source& source_;
  Builder builder_;
  pugi::xml_document document_;
  ArrayEncoding encoding_;
  std::optional<ArrayReader> arrays_;
};

}  // namespace

Mesh read_vtk_xml(const Source& source) { return VtkXmlReader(source).read(); }

}  // namespace springnet::meshes
