// What is read from each format and variant.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include <fmt/format.h>
#include <zlib.h>

#include "samples.hpp"

namespace springnet::testing {
namespace {

using Numbers = std::vector<std::uint32_t>;

void check_body(const Mesh& mesh) {
  REQUIRE(mesh.points.size() == 12);
  for (std::size_t i = 0; i < 12; ++i) CHECK(mesh.points[i] == body_points()[i]);
  REQUIRE(mesh.cell_count() == body_cells().size());
  for (std::size_t i = 0; i < mesh.cell_count(); ++i) {
    CHECK(mesh.types[i] == body_cells()[i].type);
    const auto corners = mesh.cell(i);
    CHECK(Numbers(corners.begin(), corners.end()) == body_cells()[i].points);
  }
  CHECK(has_note(mesh, "1 point | no cell | left out"));
}

std::size_t count_of(const Mesh& mesh, CellType type) {
  return static_cast<std::size_t>(std::count(mesh.types.begin(), mesh.types.end(), type));
}

TEST_CASE("the same body in Gmsh's variants") {
  for (const Sample& sample : gmsh_samples()) {
    CAPTURE(sample.name);
    const Mesh mesh = read_text_mesh(sample.name, sample.bytes);
    check_body(mesh);
    REQUIRE(mesh.groups.size() == 3);
    CHECK(group_of(mesh, "volume 9").cells == Numbers{0, 1, 2, 3});
    CHECK(group_of(mesh, "volume 9").points == Numbers{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
    CHECK(group_of(mesh, "the bottom").cells == Numbers{4});
    CHECK(group_of(mesh, "the bottom").points == Numbers{0, 1, 2, 3});
    CHECK(group_of(mesh, "pin").cells == Numbers{4, 5});  // a point's and a surface's
    CHECK(mesh.notes.size() == 1);
  }
}

TEST_CASE("the same body in VTK's variants, text and XML") {
  std::vector<Sample> samples = vtk_legacy_samples();
  CHECK(samples.size() == 4);
  const std::vector<Sample> xml = vtk_xml_samples();
  CHECK(xml.size() == 25);
  samples.insert(samples.end(), xml.begin(), xml.end());
  for (const Sample& sample : samples) {
    CAPTURE(sample.name);
    const Mesh mesh = read_text_mesh(sample.name, sample.bytes);
    check_body(mesh);
    REQUIRE(mesh.groups.size() == 2);
    CHECK(group_of(mesh, "material 7").cells == Numbers{0, 1, 2, 3});
    CHECK(group_of(mesh, "material 2").cells == Numbers{4, 5});
    CHECK(group_of(mesh, "material 2").points == Numbers{0, 1, 2, 3});
    CHECK(mesh.notes.size() == 1);
  }
}

TEST_CASE("pieces of a .vtu are put side by side, with their points, cells and groups") {
  for (const Sample& sample : vtk_piece_samples()) {
    CAPTURE(sample.name);
    const Mesh mesh = read_text_mesh(sample.name, sample.bytes);
    const std::size_t points = body_points().size() - 1, cells = body_cells().size();
    REQUIRE(mesh.points.size() == 2 * points);
    REQUIRE(mesh.cell_count() == 2 * cells);
    for (std::size_t i = 0; i < 2 * points; ++i) {
      CHECK(mesh.points[i] == body_points()[i % points] + Vector3(0, 0, i < points ? 0 : 10));
    }
    for (std::size_t i = 0; i < 2 * cells; ++i) {
      Numbers expected = body_cells()[i % cells].points;
      for (std::uint32_t& point : expected) point += i < cells ? 0 : static_cast<std::uint32_t>(points);
      const auto corners = mesh.cell(i);
      CHECK(mesh.types[i] == body_cells()[i % cells].type);
      CHECK(Numbers(corners.begin(), corners.end()) == expected);
    }
    CHECK(group_of(mesh, "material 7").cells == Numbers{0, 1, 2, 3, 6, 7, 8, 9});
    CHECK(group_of(mesh, "material 2").cells == Numbers{4, 5, 10, 11});
    CHECK(group_of(mesh, "material 2").points == Numbers{0, 1, 2, 3, 12, 13, 14, 15});
    CHECK(has_note(mesh, "2 pieces"));
    CHECK(has_note(mesh, "2 points | no cell"));
  }
}

TEST_CASE("line ends of other systems") {
  for (const Sample& sample :
       {gmsh_samples()[0], vtk_legacy_samples()[0], vtk_xml_samples()[0], vtk_xml_samples()[1]}) {
    CAPTURE(sample.name);
    std::string bytes;
    for (const char c : sample.bytes) bytes += c == '\n' ? std::string("\r\n") : std::string(1, c);
    check_body(read_text_mesh(sample.name, bytes));
  }
  for (const Sample& sample : {obj_sample(), stl_samples()[0]}) {
    CAPTURE(sample.name);
    std::string bytes;
    for (const char c : sample.bytes) bytes += c == '\n' ? std::string("\r\n") : std::string(1, c);
    const Mesh mesh = read_text_mesh(sample.name, sample.bytes), other = read_text_mesh(sample.name, bytes);
    CHECK(other.points == mesh.points);
    CHECK(other.types == mesh.types);
    CHECK(other.corners == mesh.corners);
    CHECK(other.notes == mesh.notes);
    REQUIRE(other.groups.size() == mesh.groups.size());
    for (std::size_t k = 0; k < mesh.groups.size(); ++k) {
      CHECK(other.groups[k].name == mesh.groups[k].name);
      CHECK(other.groups[k].cells == mesh.groups[k].cells);
    }
  }
}

TEST_CASE("a byte order mark before a text is skipped") {
  for (const Sample& sample : {obj_sample(), stl_samples()[0], gmsh_samples()[0], vtk_xml_samples()[0]}) {
    CAPTURE(sample.name);
    const Mesh mesh = read_text_mesh(sample.name, sample.bytes);
    const Mesh marked = read_text_mesh(sample.name, "\xEF\xBB\xBF" + sample.bytes);
    CHECK(marked.points == mesh.points);
    CHECK(marked.corners == mesh.corners);
  }
}

TEST_CASE("polygons, lines, strips and vertices of VTK") {
  for (const Sample& sample : vtk_polygon_samples()) {
    CAPTURE(sample.name);
    const Mesh mesh = read_text_mesh(sample.name, sample.bytes);
    CHECK(mesh.points.size() == 9);  // all
    CHECK(mesh.types == std::vector<CellType>{CellType::vertex, CellType::line, CellType::line, CellType::triangle,
                                              CellType::triangle, CellType::triangle, CellType::triangle,
                                              CellType::triangle});
    CHECK(group_of(mesh, "group 1").cells == Numbers{0});
    CHECK(group_of(mesh, "group 2").cells == Numbers{1, 2});
    CHECK(group_of(mesh, "group 3").cells == Numbers{3, 4, 5});  // the pentagon
    CHECK(group_of(mesh, "group 4").cells == Numbers{6, 7});
    CHECK(has_note(mesh, "1 polygon | four corners"));
    // A square with a gable of base 1 and height 1.
    CHECK(measure_of(mesh, 3) + measure_of(mesh, 4) + measure_of(mesh, 5) == doctest::Approx(1.5));
    // Both triangles of the strip have the same orientation: they run along their common edge in opposite directions.
    const std::vector<Face> strip{{mesh.cell(6)[0], mesh.cell(6)[1], mesh.cell(6)[2]},
                                  {mesh.cell(7)[0], mesh.cell(7)[1], mesh.cell(7)[2]}};
    CHECK(oriented(strip, mesh.points) == strip);
    CHECK(area_of(mesh, strip) == doctest::Approx(1.0));
  }
}

TEST_CASE("structured grids of VTK") {
  for (const Sample& sample : grid_samples()) {
    CAPTURE(sample.name);
    const Mesh mesh = read_text_mesh(sample.name, sample.bytes);
    CHECK(mesh.points.size() == 12);
    CHECK(mesh.types == std::vector<CellType>{CellType::hexahedron, CellType::hexahedron});
    CHECK(volume_of(mesh) == doctest::Approx(24.0));  // 2 x 3 x 4
    const std::vector<Face> surface = surface_of(mesh);
    CHECK(surface.size() == 20);
    CHECK(enclosed_volume(mesh, surface) == doctest::Approx(24.0));
    if (sample.name == "points.vtk") {
      CHECK(mesh.points[11] == Vector3{3, 4, 5});
      CHECK(group_of(mesh, "Material 3").cells == Numbers{1});
    }
  }
  const std::string flat = replaced(grid_samples()[0].bytes, "3 2 2", "3 1 2");
  const Mesh sheet = read_text_mesh("flat.vtk", flat);
  CHECK(count_of(sheet, CellType::quadrilateral) == 2);
  CHECK(area_of(sheet, surface_of(sheet)) == doctest::Approx(8.0));  // 2 x 4
  const Mesh row = read_text_mesh("row.vtk", replaced(grid_samples()[0].bytes, "3 2 2", "3 1 1"));
  CHECK(count_of(row, CellType::line) == 2);
}

TEST_CASE("corners of pixels and voxels are put in the order of quadrilaterals and hexahedra") {
  const Mesh mesh = read_text_mesh("voxel.vtk",
                                   "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n0 "
                                   "0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 "
                                   "0 1 1 1 1 1\nCELLS 2 14\n8 0 1 2 3 4 5 6 7\n4 0 1 2 3\nCELL_TYPES 2\n11 8\n");
  CHECK(measure_of(mesh, 0) == doctest::Approx(1.0));
  CHECK(measure_of(mesh, 1) == doctest::Approx(1.0));
  CHECK(edges_of(mesh).size() == 12);  // those of the pixel are among them
}

TEST_CASE("OBJ") {
  const Mesh mesh = read_text_mesh(obj_sample().name, obj_sample().bytes);
  CHECK(mesh.points.size() == 8);
  CHECK(mesh.types == std::vector<CellType>{CellType::quadrilateral, CellType::triangle, CellType::triangle,
                                            CellType::triangle, CellType::triangle, CellType::line, CellType::line,
                                            CellType::vertex});
  const auto corners = mesh.cell(1);
  CHECK(Numbers(corners.begin(), corners.end()) == Numbers{1, 4, 5});  // -6 -3 -2 of seven
  CHECK(mesh.cell(4)[0] == 7);                                         // a point that comes after the face
  CHECK(group_of(mesh, "left").cells == Numbers{0});
  CHECK(group_of(mesh, "both").cells == Numbers{0, 1, 2, 3});
  CHECK(group_of(mesh, "right").cells == Numbers{1, 2, 3});
  CHECK(group_of(mesh, "sheet one").cells == Numbers{0, 1, 2, 3, 4, 5, 6, 7});
  CHECK(mesh.groups.size() == 4);
  CHECK(has_note(mesh, "1 polygon | four corners"));
  CHECK(has_note(mesh, "1 statement | 'curv'"));
  CHECK(has_note(mesh, "1 point | no cell"));
}

TEST_CASE("STL: equal corners become one point") {
  for (const Sample& sample : stl_samples()) {
    CAPTURE(sample.name);
    const Mesh mesh = read_text_mesh(sample.name, sample.bytes);
    CHECK(mesh.points.size() == 4);
    const std::vector<Face> surface = surface_of(mesh);
    CHECK(is_closed(surface));
    CHECK(enclosed_volume(mesh, surface) == doctest::Approx(1.0 / 6.0));
    CHECK(mesh.groups.size() == (sample.name == "two.stl" ? 2 : 0));
  }
  const Mesh text = read_text_mesh("two.STL", stl_samples()[0].bytes);  // the extension in upper case
  CHECK(group_of(text, "first part").cells == Numbers{0, 1});
  CHECK(group_of(text, "second part").cells == Numbers{2, 3});
  const Mesh thin = read_text_mesh("thin.stl", replaced(stl_samples()[0].bytes, "vertex 0 1 0", "vertex 0 0 0"));
  CHECK(thin.cell_count() == 3);
  CHECK(has_note(thin, "1 triangle | equal corners | left out"));
  // An incomplete triangle at the end of a binary file.
  const Mesh spare = read_text_mesh("spare.stl", stl_samples()[1].bytes + "\n");
  CHECK(spare.cell_count() == 4);
  CHECK(has_note(spare, "1 byte | last triangle"));
}

TEST_CASE("PLY: vertices, faces and edges, and clouds of vertices alone") {
  const std::vector<Sample> samples = ply_samples();
  for (const Sample& sample : {samples[0], samples[1], samples[2]}) {
    CAPTURE(sample.name);
    const Mesh mesh = read_text_mesh(sample.name, sample.bytes);
    CHECK(mesh.points == std::vector<Vector3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    REQUIRE(mesh.cell_count() == 5);
    CHECK(mesh.types[4] == CellType::line);
    const std::vector<Face> surface = surface_of(mesh);
    CHECK(is_closed(surface));
    CHECK(enclosed_volume(mesh, surface) == doctest::Approx(1.0 / 6.0));
    CHECK(has_note(mesh, "1 element | 'scan'"));
    CHECK(mesh.notes.size() == 1);
  }
  const Mesh cloud = read_text_mesh("cloud.ply", samples[3].bytes);
  CHECK(cloud.points == std::vector<Vector3>{{0, 0, 1}, {0.5, 0, 0}, {2, 3, 4}});
  CHECK(count_of(cloud, CellType::vertex) == 3);
  CHECK(has_note(read_text_mesh("more.ply", samples[1].bytes + "x"), "last element is not read"));
  CHECK(has_note(read_text_mesh("more.ply", samples[0].bytes + "\n1"), "last element is not read"));
}

TEST_CASE("parts of a file that are not read are noted once, with the first names") {
  const std::string sections = "$Periodic\n0\n$EndPeriodic\n$NodeData\n1\n$EndNodeData\n$Periodic\n$EndPeriodic\n";
  const Mesh mesh = read_text_mesh("a.msh", gmsh_samples()[0].bytes + sections);
  check_body(mesh);
  CHECK(has_note(mesh, "3 sections | $Periodic, $NodeData"));
  CHECK(mesh.notes.size() == 2);

  std::string many = obj_sample().bytes;
  for (int k = 0; k < 40000; ++k) many += fmt::format("g empty{}\n", k);
  const Mesh groups = read_text_mesh("a.obj", many);
  CHECK(groups.groups.size() == 4);
  CHECK(has_note(groups, "40000 groups | left out | 'empty0', 'empty1', 'empty2', 'empty3', 'empty4' and others"));
  CHECK(groups.notes.size() == 4);
}

// With quadratic loops each of these took seconds, minutes, or gigabytes. The limit is on the processor's time, of
// which they need about a hundredth.
TEST_CASE("small files do not take long") {
  const auto begin = std::clock();
  std::string names = "v 0 0 0\nv 1 0 0\nv 0 1 0\ng";
  for (int k = 0; k < 6000; ++k) names += fmt::format(" a{}", k);
  names += "\nf 1 2 3\n";
  for (int k = 0; k < 6000; ++k) names += "o x\n";
  CHECK(read_text_mesh("names.obj", names).groups.size() == 6000);

  std::string sections = gmsh_samples()[0].bytes;
  for (int k = 0; k < 40000; ++k) sections += fmt::format("$S{0}\n$EndS{0}\n", k);
  CHECK(read_text_mesh("sections.msh", sections).notes.size() == 2);

  // A surface that names the same physical group again and again, each time with all of its triangles.
  const auto triangles = [](const std::string& physicals, int count) {
    std::string text = fmt::format(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 0 {} 0\n$EndEntities\n$Nodes\n"
        "1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n$Elements\n1 {} 1 {}\n2 1 2 {}\n",
        physicals, count, count, count);
    for (int k = 1; k <= count; ++k) text += fmt::format("{} 1 2 3\n", k);
    return text + "$EndElements\n";
  };
  std::string same = "6000", different = "6000";
  for (int k = 1; k <= 6000; ++k) {
    same += " 7";
    different += fmt::format(" {}", k);
  }
  const Mesh mesh = read_text_mesh("same.msh", triangles(same, 6000));
  REQUIRE(mesh.groups.size() == 1);
  CHECK(mesh.groups[0].cells.size() == 6000);
  CHECK(mesh.groups[0].cells.capacity() < 20000);
  CHECK(error_of("different.msh", triangles(different, 6000)).find("groups have ") != std::string::npos);
  CHECK(static_cast<double>(std::clock() - begin) < 20.0 * CLOCKS_PER_SEC);
}

TEST_CASE("pieces that share their data claim no more than the file can hold") {
  // Of 300,000 points at the origin, which zlib makes a thousandth of; each piece alone is fine.
  const auto pieces = [](int count) {
    std::string zeros(3 * 8 * 100'000, '\0'), packed(compressBound(zeros.size()), '\0'), data;
    uLongf size = packed.size();
    compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(zeros.data()),
             zeros.size());
    for (const std::size_t number : {std::size_t{1}, zeros.size(), std::size_t{0}, std::size_t{size}}) {
      put<std::uint32_t>(data, static_cast<std::uint32_t>(number));
    }
    std::string text =
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" compressor=\"vtkZLibDataCompressor\">"
        "<UnstructuredGrid>\n";
    for (int k = 0; k < count; ++k) {
      text +=
          "<Piece NumberOfPoints=\"100000\" NumberOfCells=\"0\"><Points><DataArray type=\"Float64\" Name=\"p\" "
          "NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points></Piece>\n";
    }
    return text + "</UnstructuredGrid><AppendedData encoding=\"raw\">_" + data + packed.substr(0, size) +
           "</AppendedData></VTKFile>";
  };
  CHECK(error_of("one.vtu", pieces(1)).find("it has no usable cell") != std::string::npos);
  CHECK(error_of("many.vtu", pieces(200)).find("more than the file can") != std::string::npos);
}

TEST_CASE("cells of second order are read by their corners; other types are left out") {
  const std::string head = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 11 float\n";
  std::string points = "0 0 0 1 0 0 0 1 0 0 0 1 ";
  for (int k = 0; k < 7; ++k) points += "0.5 0.5 0 ";
  const Mesh mesh = read_text_mesh(
      "second.vtk", head + points + "\nCELLS 2 15\n10 0 1 2 3 4 5 6 7 8 9\n3 0 1 2\nCELL_TYPES 2\n24 69\n");
  CHECK(mesh.points.size() == 4);
  CHECK(mesh.types == std::vector<CellType>{CellType::tetrahedron});
  CHECK(has_note(mesh, "1 cell of second order"));
  CHECK(has_note(mesh, "1 cell | left out | VTK's type 69"));
  CHECK(has_note(mesh, "7 points | no cell"));
}

// The corners of a type of cells, where VTK and Gmsh have them.
std::vector<Vector3> corners_of(CellType type) {
  static const std::vector<Vector3> box{{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 0},
                                        {0, 0, 3}, {1, 0, 3}, {1, 2, 3}, {0, 2, 3}};
  switch (type) {
    case CellType::triangle:
      return {box[0], box[1], box[3]};
    case CellType::tetrahedron:
      return {box[0], box[1], box[3], box[4]};
    case CellType::wedge:
      return {box[0], box[1], box[3], box[4], box[5], box[7]};
    case CellType::pyramid:
      return {box[0], box[1], box[2], box[3], box[4]};
    default:
      return {box.begin(), box.begin() + static_cast<std::ptrdiff_t>(corner_count(type))};
  }
}

TEST_CASE("the corners of every second-order cell of VTK are read") {
  struct Type {
    int number;
    std::size_t points;
    CellType cell;
  };
  // The manual's numbers; the points between the corners are ignored.
  for (const Type& type :
       {Type{21, 3, CellType::line}, Type{22, 6, CellType::triangle}, Type{23, 8, CellType::quadrilateral},
        Type{24, 10, CellType::tetrahedron}, Type{25, 20, CellType::hexahedron}, Type{26, 15, CellType::wedge},
        Type{27, 13, CellType::pyramid}, Type{28, 9, CellType::quadrilateral}, Type{29, 27, CellType::hexahedron},
        Type{30, 6, CellType::quadrilateral}, Type{31, 12, CellType::wedge}, Type{32, 18, CellType::wedge},
        Type{33, 24, CellType::hexahedron}, Type{34, 7, CellType::triangle}, Type{37, 19, CellType::pyramid}}) {
    CAPTURE(type.number);
    const std::vector<Vector3> corners = corners_of(type.cell);
    std::string points, numbers;
    for (std::size_t k = 0; k < type.points; ++k) {
      const Vector3 p = k < corners.size() ? corners[k] : Vector3(0.5, 0.25, 0.125);
      points += fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
      numbers += fmt::format(" {}", k);
    }
    const Mesh mesh = read_text_mesh(
        "second.vtk", fmt::format("# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} "
                                  "double\n{}CELLS 1 {}\n{}{}\nCELL_TYPES 1\n{}\n",
                                  type.points, points, type.points + 1, type.points, numbers, type.number));
    CHECK(mesh.types == std::vector<CellType>{type.cell});
    CHECK(mesh.points == corners);
    CHECK(has_note(mesh, "1 cell of second order"));
  }
}

TEST_CASE("arrays of points give groups of points, reals none") {
  const std::string text = vtk_legacy_samples()[0].bytes;
  std::string values;
  for (int k = 0; k < 13; ++k) values += k < 2 || k == 12 ? "4 " : "5 ";
  const Mesh mesh =
      read_text_mesh("a.vtk", text + "POINT_DATA 13\nSCALARS PhysicalIds long\nLOOKUP_TABLE default\n" + values +
                                  "\nSCALARS group float\nLOOKUP_TABLE default\n" + values + "\nUNHEARD_OF x\n!");
  CHECK(group_of(mesh, "PhysicalIds 4").cells.empty());
  CHECK(group_of(mesh, "PhysicalIds 4").points == Numbers{0, 1});  // and not the one that is left out
  CHECK(group_of(mesh, "PhysicalIds 5").points.size() == 10);
  CHECK(has_note(mesh, "array 'group' | whole numbers"));
  const auto lines = std::count(text.begin(), text.end(), '\n');
  CHECK(has_note(mesh, fmt::format("line {} on | not read", lines + 8)));
}

TEST_CASE("points of a geometry that no cell has are left out, except those in groups") {
  const std::string text = gmsh_samples()[0].bytes;
  // The vertex to the point that nothing else uses; with its group, then without.
  const std::string far_away = replaced(text, "6 100 \n$EndElements", "6 136 \n$EndElements");
  CHECK(read_text_mesh("a.msh", far_away).points.size() == 13);
  const Mesh without = read_text_mesh("b.msh", replaced(far_away, "1 0.5 0.5 0.5 1 6 \n", "1 0.5 0.5 0.5 0 \n"));
  CHECK(without.points.size() == 12);
  CHECK(without.cell_count() == 5);
}

constexpr const char* written_by_vtk =
    R"(<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian" header_type="UInt32" compressor="vtkZLibDataCompressor">
<UnstructuredGrid>
<Piece NumberOfPoints="13" NumberOfCells="6">
<CellData>
<DataArray type="Int32" Name="material" format="binary">
AQAAAACAAAAYAAAAEQAAAA==eF5jZ2BgYEfCTFAMAAIoACE=
</DataArray>
</CellData>
<Points>
<DataArray type="Float32" Name="Points" NumberOfComponents="3" format="binary">
AQAAAACAAACcAAAAKwAAAA==eF5jYEAGDfaobHQ+ulqYGIyNTYwBhh2gGAYckMwEqd0P4Qs4wjAA1EYOIg==
</DataArray>
</Points>
<Cells>
<DataArray type="Int64" Name="connectivity" format="binary">
AQAAAACAAADgAAAAPgAAAA==eF5jYIAARijNBKWZoTQLlGaF0mxQmh1Kw/TB5DmhNMwcmHouKE3IPA4c6mDi3AyoAOZOmH0w98AAADgoAH4=
</DataArray>
<DataArray type="Int64" Name="offsets" format="binary">
AQAAAACAAAAwAAAAGAAAAA==eF7jYIAAPigtDKXFobQ0lJaB0gAK+AB4
</DataArray>
<DataArray type="UInt8" Name="types" format="binary">
AQAAAACAAAAGAAAADgAAAA==eF7j4eXj4mQEAAD4ADw=
</DataArray>
</Cells>
</Piece>
</UnstructuredGrid>
</VTKFile>
)";

constexpr const char* appended_by_vtk = R"(<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64" compressor="vtkZLibDataCompressor">
<UnstructuredGrid>
<Piece NumberOfPoints="13"                   NumberOfCells="6"                   >
<CellData>
<DataArray type="Int32" Name="material" format="appended"                                       offset="140"                 >
</DataArray>
</CellData>
<Points>
<DataArray type="Float32" Name="Points" NumberOfComponents="3" format="appended"                            offset="208"                 >
</DataArray>
</Points>
<Cells>
<DataArray type="Int64" Name="connectivity" format="appended"                                         offset="312"                 />
<DataArray type="Int64" Name="offsets" format="appended"                                         offset="440"                 />
<DataArray type="UInt8" Name="types" format="appended"                                         offset="516"                 >
</DataArray>
</Cells>
</Piece>
</UnstructuredGrid>
<AppendedData encoding="base64">
_AQAAAAAAAAAAgAAAAAAAANAAAAAAAAAARwAAAAAAAAA=eF5jYMAGPthD6AdQmsEBVZwDyv8B5Qs4oKoTgdIsUFoCSsP0yUBpHiitAKVh5ihBaSEorQKlYeaqQWkxKK0BpSUcAPegC0U=AQAAAAAAAAAAgAAAAAAAABgAAAAAAAAAEQAAAAAAAAA=eF5jZ2BgYEfCTFAMAAIoACE=AQAAAAAAAAAAgAAAAAAAAJwAAAAAAAAAKwAAAAAAAAA=eF5jYEAGDfaobHQ+ulqYGIyNTYwBhh2gGAYckMwEqd0P4Qs4wjAA1EYOIg==AQAAAAAAAAAAgAAAAAAAAOAAAAAAAAAAPgAAAAAAAAA=eF5jYIAARijNBKWZoTQLlGaF0mxQmh1Kw/TB5DmhNMwcmHouKE3IPA4c6mDi3AyoAOZOmH0w98AAADgoAH4=AQAAAAAAAAAAgAAAAAAAADAAAAAAAAAAGAAAAAAAAAA=eF7jYIAAPigtDKXFobQ0lJaB0gAK+AB4AQAAAAAAAAAAgAAAAAAAAAYAAAAAAAAADgAAAAAAAAA=eF7j4eXj4mQEAAD4ADw=
</AppendedData>
</VTKFile>
)";

TEST_CASE("files that VTK 9.1 wrote") {
  check_body(read_text_mesh("vtk.vtu", written_by_vtk));
  check_body(read_text_mesh("appended.vtu", appended_by_vtk));
  CHECK(group_of(read_text_mesh("vtk.vtu", written_by_vtk), "material 7").cells.size() == 4);
}

}  // namespace
}  // namespace springnet::testing
