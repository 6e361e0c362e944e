// Errors name the file, the place and the remedy.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "facts.hpp"
#include "samples.hpp"

namespace springnet::testing {
namespace {

void check_error(const std::string& name, const std::string& bytes, const std::string& wanted) {
  const std::string message = error_of(name, bytes);
  CAPTURE(name);
  CAPTURE(message);
  CHECK(has_facts(message, wanted));
}

const std::string& gmsh_text() {
  static const std::string text = gmsh_samples()[0].bytes;
  return text;
}
const std::string& vtk_text() {
  static const std::string text = vtk_legacy_samples()[0].bytes;
  return text;
}
const std::string& xml_text() {
  static const std::string text = vtk_xml_samples()[0].bytes;
  return text;
}

TEST_CASE("missing, empty and unusable files") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH_AS(static_cast<void>(read_mesh(folder.path() / "no.msh")), doctest::Contains("no such mesh file"),
                       Error);
  CHECK_THROWS_WITH_AS(static_cast<void>(read_mesh(folder.path() / "no.step")),
                       doctest::Contains("'.step' is not the extension of a mesh file"), Error);
  std::filesystem::create_directory(folder.path() / "folder.stl");
  CHECK_THROWS_WITH_AS(static_cast<void>(read_mesh(folder.path() / "folder.stl")), doctest::Contains("not a file"),
                       Error);
  check_error("a.obj", "", "a.obj: | empty");
  check_error("a.obj", "v 0 0 0\n", "a.obj: | no usable cell");
  check_error("a.msh", "solid\n", "a.msh:1: | $MeshFormat");
  check_error("a.vtk", "solid\n", "a.vtk:1: | # vtk DataFile Version");
  check_error("a.vtu", "solid\n", "not valid XML");
  check_error("a.vtu", "<a/>", "without <VTKFile>");
  check_error("a.stl", std::string(100, 'x'), "a.stl: byte 80: ");
}

TEST_CASE("Gmsh") {
  check_error("a.msh", replaced(gmsh_text(), "4.1 0 8", "2.2 0 8"),
              "a.msh:2: | version 2.2 | 4.0 | 4.1 | -format msh41");
  check_error("a.msh", replaced(gmsh_text(), "\n0.5 0.5 2 ", "\n0.5 x 2 "), "coordinate | number");
  check_error("a.msh", replaced(gmsh_text(), "\n0.5 0.5 2 ", "\n0.5 nan 2 "), "not finite");
  check_error("a.msh", replaced(gmsh_text(), "\n0.5 0.5 2 ", "\n0.5 1e999 2 "), "not finite");
  check_error("a.msh", replaced(gmsh_text(), "\n0.5 0.5 2 ", "\n0.5 -1e101 2 "), "1e+100 m");
  check_error("a.msh",
              "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n0 0 0 0\n$EndNodes\n$Elements\n0 0 0 0\n$EndElements\n",
              "a.msh: | no usable cell");
  check_error("a.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Elements\n0 0 0 0\n$EndElements\n",
              "$Elements comes before $Nodes");
  check_error("a.msh", replaced(gmsh_text(), "4 112 115 124 133 ", "4 112 115 124 134 "), "node 134 | $Nodes");
  check_error("a.msh", replaced(gmsh_text(), "4 112 115 124 133 ", "4 112 115 124 112 "),
              "corners 1 and 4 | tetrahedron");
  check_error("a.msh", replaced(gmsh_text(), "2 13 100 139 ", "2 14 100 139 "), "13 nodes | 14");
  check_error("a.msh", replaced(gmsh_text(), "3 1 0 8 ", "3 1 0 88888888888 "),
              "number of nodes of a block | 88888888888");
  check_error("a.msh", replaced(gmsh_text(), "3 1 4 1 ", "3 1 77 1 "), "type 77");
  check_error("a.msh", replaced(gmsh_text(), "103 \n", "100 \n"), "number 100");
  check_error("a.msh", gmsh_text().substr(0, gmsh_text().find("$Elements")), "$Elements");
  check_error("a.msh", replaced(gmsh_text(), "\n3\n2 5", "\n2\n2 5"), "$EndPhysicalNames");
  // In the line where it is.
  const std::string bad = replaced(gmsh_text(), "\n0.5 0.5 2 ", "\n0.5 x 2 ");
  const auto line = 1 + std::count(bad.begin(), bad.begin() + static_cast<std::ptrdiff_t>(bad.find("0.5 x 2")), '\n');
  check_error("a.msh", bad, fmt::format("a.msh:{}: ", line));
  // In binary parts the byte: here of the point's first coordinate.
  std::string binary = gmsh_samples()[1].bytes, number;
  put(number, 2.0);
  const std::size_t nodes = binary.find("$Nodes\n") + 7, point = nodes + 32 + (20 + 8 * (8 + 24));
  const std::size_t coordinate = point + 20 + 5 * 8;  // of the second block's first point
  std::string infinity;
  put(infinity, std::numeric_limits<double>::infinity());
  binary.replace(coordinate, 8, infinity);
  check_error("a.msh", binary, fmt::format("a.msh: byte {}: | coordinate | not finite", coordinate));
}

TEST_CASE("legacy VTK") {
  check_error("a.vtk", replaced(vtk_text(), "Version 2.0", "Version 7.0"), "version");
  check_error("a.vtk", replaced(vtk_text(), "ASCII", "ASCI"), "a.vtk:3: | ASCII | BINARY");
  check_error("a.vtk", replaced(vtk_text(), "UNSTRUCTURED_GRID", "TABLE"), "a.vtk:4: | UNSTRUCTURED_GRID");
  check_error("a.vtk", replaced(vtk_text(), "POINTS 13", "POINTS 1300000000"), "number of points | 1300000000");
  check_error("a.vtk", replaced(vtk_text(), "POINTS 13", "POINTS 12"), "a.vtk:9: | VTK keyword");
  check_error("a.vtk", replaced(vtk_text(), "4 4 5 8 11", "4 4 5 8 13"), "cell 3 | point 13 | 0 to 12");
  check_error("a.vtk", replaced(vtk_text(), "4 4 5 8 11", "4 4 5 8 5"), "corners 2 and 4 | tetrahedron");
  check_error("a.vtk", replaced(vtk_text(), "4 4 5 8 11", "99 4 5 8 11"), "cell 3 | 99 points");
  check_error("a.vtk", replaced(vtk_text(), "12 13 14", "12 13 13"), "cell 2 | type 13 | 5 points | needs 6");
  check_error("a.vtk", replaced(vtk_text(), "CELL_TYPES 6", "CELL_TYPES 5"), "VTK keyword");
  check_error("a.vtk", replaced(vtk_text(), "material 1 6", "material 1 5"), "array 'material' | 5 values | 6 cells");
  check_error("a.vtk", replaced(grid_samples()[0].bytes, "3 2 2", "300000 200000 20"), "use a coarser grid");
  check_error("a.vtk", replaced(grid_samples()[2].bytes, "3 2 2", "3 3 2"), "a.vtk:5: | DIMENSIONS | 3 x 3 x 2 | 12");
}

TEST_CASE("VTK's XML") {
  check_error("a.vtu", replaced(xml_text(), "</Cells>", "</Cell>"), "not valid XML");
  check_error("a.vtu", replaced(xml_text(), "NumberOfPoints=\"13\"", "NumberOfPoints=\"14\""),
              "array of points | 39 | 42");
  check_error("a.vtu", replaced(xml_text(), "NumberOfPoints=\"13\"", "NumberOfPoints=\"99999999999\""),
              "more than the file can hold");
  check_error("a.vtu", replaced(xml_text(), "NumberOfPoints=\"13\"", "NumberOfPoints=\"-1\""),
              "NumberOfPoints | whole number");
  check_error("a.vtu", replaced(xml_text(), " 0.5 0.5 2", " 0.5 one 2"), "a.vtu:16: | number");
  check_error("a.vtu", replaced(xml_text(), " 0.5 0.5 2", " 0.5 inf 2"), "a.vtu:15: | coordinate | not finite");
  check_error("a.vtu", replaced(xml_text(), "4 5 8 11", "4 5 8 -11"), "cell 3 has point -11");
  check_error("a.vtu", replaced(xml_text(), "Name=\"types\"", "Name=\"kinds\""), "<Cells> | 'types'");
  check_error("a.vtu", replaced(xml_text(), "type=\"UnstructuredGrid\"", "type=\"PUnstructuredGrid\""),
              "one of its pieces");
  check_error("a.vtu", replaced(xml_text(), "header_type", "compressor=\"vtkLZ4DataCompressor\" header_type"),
              "compressor | 'vtkZLibDataCompressor'");
  for (const Sample& sample : vtk_xml_samples()) {
    if (sample.name.find("zlib_32_little") == std::string::npos || sample.name.find("base64") == std::string::npos)
      continue;
    // A character in the middle of the compressed points, behind their header of three blocks.
    std::string bytes = sample.bytes;
    char& character = bytes[bytes.find("\n  ", bytes.find("Name=\"Points\"")) + 3 + 32 + 20];
    character = character == 'A' ? 'B' : 'A';
    check_error("a.vtu", bytes, "compressed | array of points | damaged");
  }
}

TEST_CASE("OBJ") {
  check_error("a.obj", "v 0 0 0\nv 1 0\n", "a.obj:2: | three coordinates");
  check_error("a.obj", "v 0 0 0\nv 1 0 z\n", "a.obj:2: | coordinate 3");
  check_error("a.obj", "v 0 0 0\nv 1 0 1e200\n", "a.obj:2: | 1e+100 m");
  check_error("a.obj", "v 0 0 0\nv 1 0 inf\n", "a.obj:2: | coordinate | not finite");
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  check_error("a.obj", points + "f 1 2 4\n\n", "a.obj:4: | greater than 3");
  check_error("a.obj", points + "f 1 2 0\n", "a.obj:4: | 'f' | word 3");
  check_error("a.obj", points + "f 1 2 -4\n", "a.obj:4: | 3 points | word 3");
  check_error("a.obj", points + "f 1 2 2\n", "a.obj:4: | corners 2 and 3 | triangle");
  check_error("a.obj", points + "f 1 2\n", "a.obj:4: | 'f' | 2 points | needs 3");
  check_error("a.obj", points + "f 1 2 x\n", "a.obj:4: | 'f' | word 3");
  check_error("a.obj", points + "f 1 2 3\n\x01\n", "a.obj:5: | OBJ");
}

TEST_CASE("PLY") {
  const std::vector<Sample> samples = ply_samples();
  const std::string text = samples[0].bytes, binary = samples[1].bytes;
  check_error("a.ply", "off\n", "a.ply:1: | begins with 'ply'");
  check_error("a.ply", replaced(text, "format ascii 1.0\n", ""), "no 'format' | format ascii 1.0");
  check_error("a.ply", replaced(text, "ascii", "latin1"),
              "a.ply:2: | ascii, binary_little_endian or binary_big_endian");
  check_error("a.ply", replaced(text, "ascii 1.0", "ascii 2.0"), "a.ply:2: | version 1.0");
  check_error("a.ply", replaced(text, "comment", "remark"), "a.ply:3: | not a line of a PLY header");
  check_error("a.ply", replaced(text, "element vertex 4", "element points 4"), "no element 'vertex'");
  check_error("a.ply", replaced(text, "element vertex 4", "element vertex x"), "a.ply:4: | number of elements");
  check_error("a.ply", replaced(text, "property double y", "property real y"), "a.ply:6: | not a type of PLY");
  check_error("a.ply", replaced(text, "property double y", "property double Y"), "a.ply:4: | no property 'y'");
  check_error("a.ply", replaced(text, "list uint8 int", "list float int"), "no whole number");
  check_error("a.ply", replaced(text, "vertex_indices", "corners"), "no list 'vertex_indices'");
  check_error("a.ply", replaced(text, "int vertex1", "int vertex3"), "'vertex1' and 'vertex2'");
  check_error("a.ply", replaced(text, "-3 3 0 2 1", "-3 2 0 2"), "a.ply:23: | has 2 points | 3 or more");
  check_error("a.ply", replaced(text, "-3 3 0 2 1", "-3 3 0 2 4"), "a.ply:23: | no point 4 | has 4, numbered from 0");
  check_error("a.ply", replaced(text, "-3 3 0 2 1", "-3 3 0 2 1.5"), "a.ply:23: | whole number");
  check_error("a.ply", replaced(text, "-3 3 0 2 1", "-3 3 0 2 0"), "a.ply:23: | corners 1 and 3 | same point");
  check_error("a.ply", replaced(text, "1 0.0 200 0e0", "nan 0.0 200 0e0"), "a.ply:19: | coordinate | not finite");
  check_error("a.ply", text.substr(0, text.size() - 1), "cut off");
  check_error("a.ply", binary.substr(0, binary.size() - 1), "byte | cut off");
  // Numbers that promise more than the file has cost nothing.
  check_error("a.ply", replaced(binary, "vertex 4", "vertex 4000000000"), "byte | elements");
  check_error("a.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000000\nend_header\n",
              "a.ply:3: | without properties");
}

TEST_CASE("STL") {
  const std::string text = stl_samples()[0].bytes, binary = stl_samples()[1].bytes;
  check_error("a.stl", replaced(text, "vertex 0 1 0", "vertex 0 1"), "a.stl:6: | coordinate");
  check_error("a.stl", replaced(text, "vertex 0 1 0", "vertex 0 1 -inf"), "not finite");
  check_error("a.stl", replaced(text, "endfacet", "facet"), "a.stl:8: | 'endfacet'");
  check_error("a.stl", text.substr(0, text.size() - 21), "'endsolid' | 'facet' | cut off");
  std::string other = binary;
  other[0] = 'S';
  other[1] = 'x';
  check_error("a.stl", other.substr(0, other.size() - 1), "triangles | 199 bytes | 50");
  check_error("a.stl", other + std::string(50, '\0'), "triangles | 250 bytes");
  std::string infinite;
  put(infinite, std::numeric_limits<float>::infinity());
  check_error("a.stl", std::string(binary).replace(84 + 50 + 12, 4, infinite),
              "a.stl: byte 134: | coordinate | not finite");
}

}  // namespace
}  // namespace springnet::testing
