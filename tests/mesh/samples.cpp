#include "samples.hpp"

#include <array>
#include <set>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <springnet/error.hpp>

#include "facts.hpp"

namespace springnet::testing {
namespace {

const std::vector<int>& gmsh_types() {
  static const std::vector<int> types{5, 6, 7, 4, 3, 15};
  return types;
}
std::string gmsh_head(bool old, bool binary, bool big) {
  std::string text = fmt::format("$MeshFormat\n{} {} 8\n", old ? "4" : "4.1", binary ? 1 : 0);
  if (binary) {
    put<std::int32_t>(text, 1, big);
    text += "\n";
  }
  text += "$EndMeshFormat\n$Comments\nanything\n$EndComments\n";
  text += "$PhysicalNames\n3\n2 5 \"the bottom\"\n0 6 \"pin\"\n2 8 \"pin\"\n$EndPhysicalNames\n";
  return text;
}

struct Writer {
  bool binary;
  bool big;
  std::string text{};
  void end_line() {
    if (!binary) text += "\n";
  }
  template <class T>
  void add(T value) {
    if (binary) {
      put(text, value, big);
    } else {
      text += fmt::format("{} ", value);
    }
  }
  void ints(std::initializer_list<std::int32_t> values) {
    for (const std::int32_t value : values) add(value);
  }
  void sizes(std::initializer_list<std::uint64_t> values) {
    for (const std::uint64_t value : values) add(value);
  }
};

constexpr std::array<int, 8> dimensions{0, 1, 2, 2, 3, 3, 3, 3};  // by CellType

std::string gmsh_body(bool old, bool binary, bool big = false) {
  Writer out{binary, big, gmsh_head(old, binary, big)};
  const auto section = [&](const char* name) { out.text += fmt::format("${}\n", name); };
  const auto end = [&](const char* name) { out.text += fmt::format("{}$End{}\n", binary ? "\n" : "", name); };
  const auto tag = [&](std::uint64_t value) {
    if (old) {
      out.add(static_cast<std::int32_t>(value));
    } else {
      out.add(value);
    }
  };
  const auto entity = [&](int dimension, std::initializer_list<std::int32_t> physicals) {
    out.ints({1});
    for (int k = 0; k < (dimension == 0 && !old ? 3 : 6); ++k) out.add(0.5);
    out.sizes({physicals.size()});
    out.ints(physicals);
    if (dimension > 0) {
      out.sizes({2});
      out.ints({1, -2});
    }
    out.end_line();
  };
  section("Entities");
  out.sizes({1, 0, 1, 1});
  out.end_line();
  entity(0, {6});
  entity(2, {5, -8});
  entity(3, {9});
  end("Entities");

  // Two blocks, the second one parametric; numbers with gaps.
  section("Nodes");
  const auto& points = body_points();
  out.sizes({2, points.size()});
  if (!old) out.sizes({100, 100 + 3 * points.size()});
  out.end_line();
  const auto block = [&](std::size_t begin, std::size_t behind, int dimension, int parametric) {
    out.ints({old ? 1 : dimension, old ? dimension : 1, parametric});
    out.sizes({behind - begin});
    out.end_line();
    for (std::size_t i = begin; i < behind && !old; ++i) {
      tag(100 + 3 * i);
      out.end_line();
    }
    for (std::size_t i = begin; i < behind; ++i) {
      if (old) tag(100 + 3 * i);
      for (const double x : points[i]) out.add(x);
      for (int k = 0; k < parametric * dimension; ++k) out.add(0.25);
      out.end_line();
    }
  };
  block(0, 8, 3, 0);
  block(8, points.size(), 2, 1);
  end("Nodes");

  section("Elements");
  out.sizes({body_cells().size(), body_cells().size()});
  if (!old) out.sizes({1, body_cells().size()});
  out.end_line();
  std::uint64_t number = 1;
  for (std::size_t i = 0; i < body_cells().size(); ++i) {
    const SampleCell& cell = body_cells()[i];
    const int dimension = dimensions[static_cast<std::size_t>(cell.type)];
    out.ints({old ? 1 : dimension, old ? dimension : 1, gmsh_types()[i]});
    out.sizes({1});
    out.end_line();
    tag(number++);
    for (const std::uint32_t point : cell.points) tag(100 + 3 * std::uint64_t{point});
    out.end_line();
  }
  end("Elements");
  return out.text;
}

std::string numbers(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += fmt::format("{} ", value);
  return text;
}

}  // namespace

const std::vector<Vector3>& body_points() {
  static const std::vector<Vector3> points{{0, 0, 0}, {1, 0, 0},    {1, 1, 0}, {0, 1, 0},     {0, 0, 1},
                                           {1, 0, 1}, {1, 1, 1},    {0, 1, 1}, {0.5, 0.5, 2}, {2, 0, 0},
                                           {2, 1, 0}, {0.5, -1, 1}, {9, 9, 9}};
  return points;
}

const std::vector<SampleCell>& body_cells() {
  static const std::vector<SampleCell> cells{{CellType::hexahedron, {0, 1, 2, 3, 4, 5, 6, 7}},
                                             {CellType::wedge, {1, 5, 9, 2, 6, 10}},
                                             {CellType::pyramid, {4, 5, 6, 7, 8}},
                                             {CellType::tetrahedron, {4, 5, 8, 11}},
                                             {CellType::quadrilateral, {0, 3, 2, 1}},
                                             {CellType::vertex, {0}}};
  return cells;
}

std::string error_of(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  folder.write(name, bytes);
  try {
    static_cast<void>(read_mesh(folder.path() / name));
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::input) return "not an error of input";
    const std::string text = error.what();
    const std::string begin = folder.path().string() + "/";
    return text.starts_with(begin) ? text.substr(begin.size()) : "without the file's name: " + text;
  }
  return "";
}

std::vector<Sample> gmsh_samples() {
  return {{"body_41.msh", gmsh_body(false, false)},          {"body_41_binary.msh", gmsh_body(false, true)},
          {"body_41_big.msh", gmsh_body(false, true, true)}, {"body_40.msh", gmsh_body(true, false)},
          {"body_40_binary.msh", gmsh_body(true, true)},     {"body_40_big.msh", gmsh_body(true, true, true)}};
}

Sample obj_sample() {
  return {"sheet.obj",
          "# comment\nmtllib a.mtl\no sheet one\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\n"
          "g left both\ns off\nusemtl grey\nf 1/1/1 2//1 3/1 4\nv 2 0 0 \\\n\nv 3 0.5 0\nv 2 1 0\n"
          "g right both\nf -6 -3 -2 \\\n  -1 -5\ng\nf 8 5 6\nl 1 2 3\np 7\nv 3 -1 0\nv 7 7 7\ncurv 0 1 1 2\n"};
}

std::vector<Sample> stl_samples() {
  const std::array<std::array<float, 9>, 4> triangles{{{0, 0, 0, 0, 1, 0, 1, 0, 0},
                                                       {-0.0F, 0, 0, 1, 0, 0, 0, 0, 1},
                                                       {0, 0, 0, 0, 0, 1, 0, 1, 0},
                                                       {1, 0, 0, 0, 1, 0, 0, 0, 1}}};
  std::string text, binary = "solid but binary";
  binary.resize(80, ' ');
  put<std::uint32_t>(binary, 4);
  for (std::size_t t = 0; t < 4; ++t) {
    if (t % 2 == 0) text += fmt::format("{}solid {} part\n", t == 0 ? "" : "ENDSOLID\n", t == 0 ? "first" : "second");
    text += " facet normal nan 0 1e0\n  outer loop\n";
    for (int k = 0; k < 3; ++k) put<float>(binary, 0.0F);
    for (std::size_t k = 0; k < 9; ++k) {
      put<float>(binary, triangles[t][k]);
      text += fmt::format("{}{}{}", k % 3 == 0 ? "   vertex " : " ", triangles[t][k], k % 3 == 2 ? "\n" : "");
    }
    put<std::uint16_t>(binary, 0);
    text += "  endloop\n endfacet\n";
  }
  text += "endsolid second part\n";
  return {{"two.stl", text}, {"binary.stl", binary}};
}

std::vector<Sample> grid_samples() {
  const std::string head = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET ";
  std::vector<double> coordinates;
  for (double z : {0.0, 4.0}) {
    for (double y : {0.0, 3.0}) {
      for (double x : {0.0, 0.5, 2.0}) coordinates.insert(coordinates.end(), {x, y, z});
    }
  }
  return {
      {"points.vtk", head + "STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 1 1 1\nSPACING 1 3 4\n"
                            "CELL_DATA 2\nSCALARS Material unsigned_char\nLOOKUP_TABLE default\n1 3\n"},
      {"rectilinear.vtk", head + "RECTILINEAR_GRID\nDIMENSIONS 3 2 2\nX_COORDINATES 3 float\n0 0.5 2\n"
                                 "Y_COORDINATES 2 double\n0 3\nZ_COORDINATES 2 int\n0 4\n"},
      {"structured.vtk", head + "STRUCTURED_GRID\nDIMENSIONS 3 2 2\nPOINTS 12 double\n" + numbers(coordinates) + "\n"}};
}

std::vector<Sample> ply_samples() {
  const auto head = [](const std::string& format) {
    return "ply\nformat " + format +
           " 1.0\ncomment of a scanner\nelement vertex 4\nproperty float64 x\nproperty double y\nproperty uchar red\n"
           "property float z\nelement scan 1\nproperty list uchar short lines\nelement face 4\nproperty char of\n"
           "property list uint8 int vertex_indices\nelement edge 1\nproperty int vertex1\nproperty ushort vertex2\n"
           "end_header\n";
  };
  const std::array<std::array<int, 3>, 4> points{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
      faces{{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  std::string text = head("ascii"), little = head("binary_little_endian"), big = head("binary_big_endian");
  for (const auto& [x, y, z] : points) {
    text += fmt::format("{} {}.0 200 {}e0\n", x, y, z);
    for (std::string* bytes : {&little, &big}) {
      put<double>(*bytes, x, bytes == &big);
      put<double>(*bytes, y, bytes == &big);
      put<std::uint8_t>(*bytes, 200);
      put<float>(*bytes, static_cast<float>(z), bytes == &big);
    }
  }
  text += "2 -1 7\n";
  for (std::string* bytes : {&little, &big}) {
    put<std::uint8_t>(*bytes, 2);
    for (const int line : {-1, 7}) put(*bytes, static_cast<std::int16_t>(line), bytes == &big);
  }
  for (const auto& corners : faces) {
    text += fmt::format("-3 3 {} {} {}\n", corners[0], corners[1], corners[2]);
    for (std::string* bytes : {&little, &big}) {
      put<std::int8_t>(*bytes, -3);
      put<std::uint8_t>(*bytes, 3);
      for (const int corner : corners) put<std::int32_t>(*bytes, corner, bytes == &big);
    }
  }
  text += "0 3";
  for (std::string* bytes : {&little, &big}) {
    put<std::int32_t>(*bytes, 0, bytes == &big);
    put<std::uint16_t>(*bytes, 3, bytes == &big);
  }
  return {{"text.ply", text},
          {"little.ply", little},
          {"big.ply", big},
          {"cloud.ply",
           "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "end_header\n0 0 1\n0.5 0 0\n2 3 4\n"}};
}

std::vector<Sample> all_samples() {
  std::vector<Sample> all;
  for (const auto& some : {gmsh_samples(), vtk_legacy_samples(), vtk_xml_samples(), vtk_piece_samples(),
                           vtk_polygon_samples(), grid_samples(), stl_samples(), ply_samples()}) {
    all.insert(all.end(), some.begin(), some.end());
  }
  all.push_back(obj_sample());
  return all;
}

double volume_of(const Mesh& mesh) {
  double sum = 0.0;
  for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
    if (dimension_of(mesh.types[cell]) == 3) sum += measure_of(mesh, cell);
  }
  return sum;
}

double area_of(const Mesh& mesh, const std::vector<Face>& faces) {
  double sum = 0.0;
  for (const auto& [a, b, c] : faces) {
    sum += 0.5 * (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm();
  }
  return sum;
}

double enclosed_volume(const Mesh& mesh, const std::vector<Face>& faces) {
  double sum = 0.0;
  for (const auto& [a, b, c] : faces) sum += mesh.points[a].dot(mesh.points[b].cross(mesh.points[c])) / 6.0;
  return sum;
}

long euler_characteristic(const std::vector<Face>& faces) {
  std::set<std::uint32_t> points;
  std::set<Edge> edges;
  for (const Face& face : faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      points.insert(face[k]);
      edges.insert(std::minmax(face[k], face[(k + 1) % 3]));
    }
  }
  return static_cast<long>(points.size()) - static_cast<long>(edges.size()) + static_cast<long>(faces.size());
}

bool has_note(const Mesh& mesh, std::string_view facts) {
  for (const std::string& note : mesh.notes) {
    if (has_facts(note, facts)) return true;
  }
  return false;
}

const MeshGroup& group_of(const Mesh& mesh, std::string_view name) {
  for (const MeshGroup& group : mesh.groups) {
    if (group.name == name) return group;
  }
  throw std::logic_error("no group " + std::string(name));
}

}  // namespace springnet::testing
