// What is wrong, where it is, and what to do.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "samples.hpp"

namespace springnet::testing {
namespace {

void check_error(const std::string& name, const std::string& bytes, const std::string& wanted) {
  const std::string message = error_of(name, bytes);
  CAPTURE(name);
  CAPTURE(message);
  CHECK(message.find(wanted) != std::string::npos);
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

TEST_CASE("files that are none") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH_AS(static_cast<void>(read_mesh(folder.path() / "no.msh")), doctest::Contains("no such mesh file"),
                       Error);
  CHECK_THROWS_WITH_AS(static_cast<void>(read_mesh(folder.path() / "no.step")),
                       doctest::Contains("'.step' is not the extension of a mesh file"), Error);
  std::filesystem::create_directory(folder.path() / "folder.stl");
  CHECK_THROWS_WITH_AS(static_cast<void>(read_mesh(folder.path() / "folder.stl")), doctest::Contains("not a file"),
                       Error);
  check_error("a.obj", "", "a.obj: the file is empty");
  check_error("a.obj", "v 0 0 0\n", "a.obj: it has no usable cell");
  check_error("a.msh", "solid\n", "a.msh:1: a Gmsh file begins with $MeshFormat");
  check_error("a.vtk", "solid\n", "a.vtk:1: a legacy VTK file begins with");
  check_error("a.vtu", "solid\n", "this is not valid XML");
  check_error("a.vtu", "<a/>", "without <VTKFile>");
  check_error("a.stl", std::string(100, 'x'), "a.stl: byte 80: ");
}

TEST_CASE("Gmsh") {
  check_error("a.msh", replaced(gmsh_text(), "4.1 0 8", "2.2 0 8"),
              "a.msh:2: this is version 2.2 of MSH, only 4.0 and 4.1 are supported; save it as version 4: gmsh FILE "
              "-save -format msh41");
  check_error("a.msh", replaced(gmsh_text(), "\n0.5 0.5 2 ", "\n0.5 x 2 "), "this should be a coordinate, a number");
  check_error("a.msh", replaced(gmsh_text(), "\n0.5 0.5 2 ", "\n0.5 nan 2 "), "not finite");
  check_error("a.msh", replaced(gmsh_text(), "\n0.5 0.5 2 ", "\n0.5 1e999 2 "), "not finite");
  check_error("a.msh", replaced(gmsh_text(), "\n0.5 0.5 2 ", "\n0.5 -1e101 2 "),
              "this point is farther away than 1e+100 m");
  check_error("a.msh",
              "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n0 0 0 0\n$EndNodes\n$Elements\n0 0 0 0\n$EndElements\n",
              "a.msh: it has no usable cell");
  check_error("a.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Elements\n0 0 0 0\n$EndElements\n",
              "$Elements comes before $Nodes");
  check_error("a.msh", replaced(gmsh_text(), "4 112 115 124 133 ", "4 112 115 124 134 "),
              "an element has node 134, which $Nodes does not have");
  check_error("a.msh", replaced(gmsh_text(), "4 112 115 124 133 ", "4 112 115 124 112 "),
              "corners 1 and 4 of this tetrahedron are the same point");
  check_error("a.msh", replaced(gmsh_text(), "2 13 100 139 ", "2 14 100 139 "),
              "there are 13 nodes, but 14 were declared");
  check_error("a.msh", replaced(gmsh_text(), "3 1 0 8 ", "3 1 0 88888888888 "),
              "the number of nodes of a block is 88888888888, but the file has only");
  check_error("a.msh", replaced(gmsh_text(), "3 1 4 1 ", "3 1 77 1 "), "elements are of the unknown type 77");
  check_error("a.msh", replaced(gmsh_text(), "103 \n", "100 \n"), "two nodes have the number 100");
  check_error("a.msh", gmsh_text().substr(0, gmsh_text().find("$Elements")), "there is no $Elements section");
  check_error("a.msh", replaced(gmsh_text(), "\n3\n2 5", "\n2\n2 5"), "this should be $EndPhysicalNames");
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
  check_error("a.msh", binary, fmt::format("a.msh: byte {}: a coordinate of this point is not finite", coordinate));
}

TEST_CASE("legacy VTK") {
  check_error("a.vtk", replaced(vtk_text(), "Version 2.0", "Version 7.0"), "this version of legacy VTK is not known");
  check_error("a.vtk", replaced(vtk_text(), "ASCII", "ASCI"), "a.vtk:3: this should be ASCII or BINARY");
  check_error("a.vtk", replaced(vtk_text(), "UNSTRUCTURED_GRID", "TABLE"),
              "a.vtk:4: this kind of data set is not read");
  check_error("a.vtk", replaced(vtk_text(), "POINTS 13", "POINTS 1300000000"), "number of points is 1300000000, but");
  check_error("a.vtk", replaced(vtk_text(), "POINTS 13", "POINTS 12"), "a.vtk:9: this should be a VTK keyword");
  check_error("a.vtk", replaced(vtk_text(), "4 4 5 8 11", "4 4 5 8 13"),
              "cell 3 has point 13, but there are 13 (0 to 12)");
  check_error("a.vtk", replaced(vtk_text(), "4 4 5 8 11", "4 4 5 8 5"), "corners 2 and 4 of this tetrahedron");
  check_error("a.vtk", replaced(vtk_text(), "4 4 5 8 11", "99 4 5 8 11"), "cell 3 has 99 points, but the list");
  check_error("a.vtk", replaced(vtk_text(), "12 13 14", "12 13 13"),
              "cell 2 of VTK's type 13 has 5 points and needs 6");
  check_error("a.vtk", replaced(vtk_text(), "CELL_TYPES 6", "CELL_TYPES 5"), "this should be a VTK keyword");
  check_error("a.vtk", replaced(vtk_text(), "material 1 6", "material 1 5"),
              "array 'material' has 5 values for 6 cells");
  check_error("a.vtk", replaced(grid_samples()[0].bytes, "3 2 2", "300000 200000 20"), "use a coarser grid");
  check_error("a.vtk", replaced(grid_samples()[2].bytes, "3 2 2", "3 3 2"),
              "a.vtk:5: DIMENSIONS are 3 x 3 x 2, but there are 12");
}

TEST_CASE("VTK's XML") {
  check_error("a.vtu", replaced(xml_text(), "</Cells>", "</Cell>"), "this is not valid XML, or cut off");
  check_error("a.vtu", replaced(xml_text(), "NumberOfPoints=\"13\"", "NumberOfPoints=\"14\""),
              "the array of points has 39 values and should have 42");
  check_error("a.vtu", replaced(xml_text(), "NumberOfPoints=\"13\"", "NumberOfPoints=\"99999999999\""),
              "more than the file can hold");
  check_error("a.vtu", replaced(xml_text(), "NumberOfPoints=\"13\"", "NumberOfPoints=\"-1\""),
              "should be a whole number");
  check_error("a.vtu", replaced(xml_text(), " 0.5 0.5 2", " 0.5 one 2"), "a.vtu:16: this should be a number");
  check_error("a.vtu", replaced(xml_text(), " 0.5 0.5 2", " 0.5 inf 2"),
              "a.vtu:15: a coordinate of this point is not finite");
  check_error("a.vtu", replaced(xml_text(), "4 5 8 11", "4 5 8 -11"), "cell 3 has point -11");
  check_error("a.vtu", replaced(xml_text(), "Name=\"types\"", "Name=\"kinds\""), "<Cells> has no array 'types'");
  check_error("a.vtu", replaced(xml_text(), "type=\"UnstructuredGrid\"", "type=\"PUnstructuredGrid\""),
              "one of its pieces");
  check_error("a.vtu", replaced(xml_text(), "header_type", "compressor=\"vtkLZ4DataCompressor\" header_type"),
              "compressor should be '' or 'vtkZLibDataCompressor'");
  for (const Sample& sample : vtk_xml_samples()) {
    if (sample.name.find("zlib_32_little") == std::string::npos || sample.name.find("base64") == std::string::npos)
      continue;
    // A character in the middle of the compressed points, behind their header of three blocks.
    std::string bytes = sample.bytes;
    char& character = bytes[bytes.find("\n  ", bytes.find("Name=\"Points\"")) + 3 + 32 + 20];
    character = character == 'A' ? 'B' : 'A';
    check_error("a.vtu", bytes, "the compressed data of the array of points are damaged");
  }
}

TEST_CASE("OBJ") {
  check_error("a.obj", "v 0 0 0\nv 1 0\n", "a.obj:2: a point needs three coordinates");
  check_error("a.obj", "v 0 0 0\nv 1 0 z\n", "a.obj:2: coordinate 3 of this point is not a number");
  check_error("a.obj", "v 0 0 0\nv 1 0 1e200\n", "a.obj:2: this point is farther away than 1e+100 m");
  check_error("a.obj", "v 0 0 0\nv 1 0 inf\n", "a.obj:2: a coordinate of this point is not finite");
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  check_error("a.obj", points + "f 1 2 4\n\n", "a.obj:4: a point number on this line is greater than 3");
  check_error(
      "a.obj", points + "f 1 2 0\n",
      "a.obj:4: 'f' needs point numbers, 1 or more, or below 0 to count back from the last point: word 3 is neither");
  check_error("a.obj", points + "f 1 2 -4\n",
              "a.obj:4: only 3 points precede this line, and word 3 counts farther back");
  check_error("a.obj", points + "f 1 2 2\n", "a.obj:4: corners 2 and 3 of this triangle are the same point");
  check_error("a.obj", points + "f 1 2\n", "a.obj:4: 'f' has 2 points and needs 3");
  check_error("a.obj", points + "f 1 2 x\n", "a.obj:4: 'f' needs point numbers");
  check_error("a.obj", points + "f 1 2 3\n\x01\n", "a.obj:5: this is not an OBJ statement");
}

TEST_CASE("STL") {
  const std::string text = stl_samples()[0].bytes, binary = stl_samples()[1].bytes;
  check_error("a.stl", replaced(text, "vertex 0 1 0", "vertex 0 1"), "a.stl:6: this should be a coordinate");
  check_error("a.stl", replaced(text, "vertex 0 1 0", "vertex 0 1 -inf"), "not finite");
  check_error("a.stl", replaced(text, "endfacet", "facet"), "a.stl:8: this should be 'endfacet'");
  check_error("a.stl", text.substr(0, text.size() - 21), "where 'endsolid' or 'facet' should be; it is cut off");
  std::string other = binary;
  other[0] = 'S';
  other[1] = 'x';
  check_error("a.stl", other.substr(0, other.size() - 1),
              "the number of triangles does not match the 199 bytes after it, 50 for each");
  check_error("a.stl", other + std::string(50, '\0'), "the number of triangles does not match the 250 bytes");
  std::string infinite;
  put(infinite, std::numeric_limits<float>::infinity());
  check_error("a.stl", std::string(binary).replace(84 + 50 + 12, 4, infinite),
              "a.stl: byte 134: a coordinate of this point is not finite");
}

}  // namespace
}  // namespace springnet::testing
