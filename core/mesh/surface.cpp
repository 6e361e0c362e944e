#include <algorithm>
#include <array>
#include <limits>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <springnet/error.hpp>
#include <springnet/mesh.hpp>

#include "mesh/by_point.hpp"
#include "mesh/cells.hpp"

namespace springnet {
namespace {

using meshes::FaceKey;

void divide(const std::array<std::uint32_t, 4>& corners, const std::vector<Vector3>& points, std::vector<Face>& faces) {
  const auto& [a, b, c, d] = corners;
  const double first = (points[c] - points[a]).squaredNorm(), second = (points[d] - points[b]).squaredNorm();
  // Of two equal diagonals the one at the lowest point number, whatever the order of the corners.
  if (first < second || (first == second && std::min(a, c) < std::min(b, d))) {
    faces.insert(faces.end(), {Face{a, b, c}, Face{a, c, d}});
  } else {
    faces.insert(faces.end(), {Face{a, b, d}, Face{b, c, d}});
  }
}

// An edge of a triangle, from corner `side` to the next one.
struct Side {
  std::uint32_t lower;
  std::uint32_t upper;
  std::size_t face;
  std::uint8_t side;
  bool rising;  // runs from lower to upper
};

bool same_edge(const Side& a, const Side& b) { return a.lower == b.lower && a.upper == b.upper; }

// Sides of all triangles, grouped by edge, in the order of the triangles.
std::vector<Side> sides_of(std::span<const Face> faces) {
  std::vector<Side> sides;
  sides.reserve(3 * faces.size());
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t from = faces[face][k], to = faces[face][(k + 1U) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), face, k, from < to});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.lower, a.upper, a.face, a.side) < std::tie(b.lower, b.upper, b.face, b.side);
  });
  return sides;
}

// Calls function(sides) for each edge.
template <class Function>
void for_each_edge(std::span<const Side> sides, const Function& function) {
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && same_edge(sides[begin], sides[end])) ++end;
    function(sides.subspan(begin, end - begin));
  }
}

struct Neighbour {
  std::size_t face = std::numeric_limits<std::size_t>::max();  // the default: none
  bool is_consistent = false;
};

[[noreturn]] void fail(const std::string& message) { throw Error(ErrorKind::input, message); }

std::vector<std::array<Neighbour, 3>> neighbours_of(std::span<const Face> faces) {
  std::vector<std::array<Neighbour, 3>> result(faces.size());
  const std::vector<Side> sides = sides_of(faces);
  for_each_edge(sides, [&](std::span<const Side> edge) {
    if (edge.size() > 2) {
      fail(
          fmt::format("a surface: the edge from point {} to point {} belongs to {} triangles ({}, {}, {}, ...), so it "
                      "is not a manifold: remove the surplus triangles",
                      edge[0].lower, edge[0].upper, edge.size(), edge[0].face, edge[1].face, edge[2].face));
    }
    if (edge.size() < 2) return;
    const bool is_consistent = edge[0].rising != edge[1].rising;
    result[edge[0].face][edge[0].side] = {edge[1].face, is_consistent};
    result[edge[1].face][edge[1].side] = {edge[0].face, is_consistent};
  });
  return result;
}

// A face of a solid cell: its place among face_places, and its key without the lowest point.
struct SolidFace {
  std::array<std::uint32_t, 3> others;
  std::uint32_t cell;
  std::uint8_t face;
};

// Faces of all solid cells by their lowest point, then by the others.
class SolidFaces {
 public:
  explicit SolidFaces(const Mesh& mesh)
      : faces_(mesh.points.size(), [&mesh](const auto& add) {
          for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
            const auto corners = mesh.cell(cell);
            const auto places = meshes::face_places(mesh.types[cell]);
            for (std::uint8_t face = 0; face < places.size(); ++face) {
              const auto [a, b, c, d] = ascending(corners, places[face]);
              add(a, SolidFace{{b, c, d}, static_cast<std::uint32_t>(cell), face});
            }
          }
        }) {
    const auto points = static_cast<std::int64_t>(faces_.points());
#pragma omp parallel if (points > 10000)
    {
      std::vector<SolidFace> outer;
#pragma omp for schedule(dynamic, 4096) nowait
      for (std::int64_t p = 0; p < points; ++p) sort(faces_.of(static_cast<std::size_t>(p)), outer);
#pragma omp critical(springnet_outer_faces)
      outer_.insert(outer_.end(), outer.begin(), outer.end());
    }
    std::sort(outer_.begin(), outer_.end(), [](const SolidFace& a, const SolidFace& b) {
      return std::tie(a.cell, a.face) < std::tie(b.cell, b.face);
    });
  }

  // Those that belong to one cell only, in the order of the cells.
  [[nodiscard]] std::vector<SolidFace> take_outer() { return std::move(outer_); }
  [[nodiscard]] bool has(const FaceKey& key) {
    const std::span<const SolidFace> faces = faces_.of(key[0]);
    const std::array others{key[1], key[2], key[3]};
    const auto found = std::lower_bound(faces.begin(), faces.end(), others,
                                        [](const SolidFace& face, const auto& k) { return face.others < k; });
    return found != faces.end() && found->others == others;
  }

 private:
  // As meshes::face_key: three or four points in ascending order.
  static FaceKey ascending(std::span<const std::uint32_t> cell, const std::array<std::uint8_t, 4>& places) {
    const auto order = [](std::uint32_t& x, std::uint32_t& y) {
      const std::uint32_t lower = std::min(x, y);
      y = std::max(x, y);
      x = lower;
    };
    FaceKey key{cell[places[0]], cell[places[1]], cell[places[2]], meshes::no_point};
    if (places[3] != meshes::no_corner) key[3] = cell[places[3]];
    order(key[0], key[1]);
    order(key[2], key[3]);
    order(key[0], key[2]);
    order(key[1], key[3]);
    order(key[1], key[2]);
    return key;
  }
  // Sorts the faces of a point, and adds those that occur once.
  static void sort(std::span<SolidFace> faces, std::vector<SolidFace>& outer) {
    std::sort(faces.begin(), faces.end(), [](const SolidFace& a, const SolidFace& b) { return a.others < b.others; });
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const bool first = i == 0 || faces[i - 1].others != faces[i].others;
      const bool last = i + 1 == faces.size() || faces[i + 1].others != faces[i].others;
      if (first && last) outer.push_back(faces[i]);
    }
  }

  meshes::ByPoint<SolidFace> faces_;
  std::vector<SolidFace> outer_;
};

}  // namespace

std::vector<Face> surface_of(const Mesh& mesh) {
  SolidFaces solid(mesh);
  std::vector<Face> faces;
  for (const SolidFace& face : solid.take_outer()) {
    const auto corners = mesh.cell(face.cell);
    const auto& places = meshes::face_places(mesh.types[face.cell])[face.face];
    const bool inside_out = meshes::solid_volume(mesh, face.cell) < 0.0;
    if (places[3] == meshes::no_corner) {
      Face triangle{corners[places[0]], corners[places[1]], corners[places[2]]};
      if (inside_out) std::swap(triangle[1], triangle[2]);
      faces.push_back(triangle);
    } else {
      std::array four{corners[places[0]], corners[places[1]], corners[places[2]], corners[places[3]]};
      if (inside_out) std::swap(four[1], four[3]);
      divide(four, mesh.points, faces);
    }
  }
  for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell) {
    const auto corners = mesh.cell(cell);
    if (dimension_of(mesh.types[cell]) != 2) continue;
    if (solid.has(meshes::face_key(corners))) continue;
    if (corners.size() == 3) {
      faces.push_back({corners[0], corners[1], corners[2]});
    } else {
      divide({corners[0], corners[1], corners[2], corners[3]}, mesh.points, faces);
    }
  }
  return faces;
}

std::vector<Face> oriented(std::vector<Face> faces, std::span<const Vector3> points) {
  for (std::size_t face = 0; face < faces.size(); ++face) {
    const auto& [a, b, c] = faces[face];
    if (std::max({a, b, c}) >= points.size()) {
      fail(fmt::format("a surface: triangle {} has point {}, there are only {}", face, std::max({a, b, c}),
                       points.size()));
    }
    if (a == b || b == c || c == a) fail(fmt::format("a surface: triangle {} has a point twice: remove it", face));
  }
  const auto neighbours = neighbours_of(faces);
  enum class Winding : std::uint8_t { unknown, kept, reversed };
  std::vector<Winding> windings(faces.size(), Winding::unknown);
  std::vector<std::size_t> part;
  for (std::size_t start = 0; start < faces.size(); ++start) {
    if (windings[start] != Winding::unknown) continue;
    windings[start] = Winding::kept;
    part.assign(1, start);
    bool closed = true;
    for (std::size_t next = 0; next < part.size(); ++next) {
      const std::size_t face = part[next];
      for (const Neighbour& neighbour : neighbours[face]) {
        if (neighbour.face >= faces.size()) {
          closed = false;
          continue;
        }
        const Winding wanted =
            neighbour.is_consistent == (windings[face] == Winding::kept) ? Winding::kept : Winding::reversed;
        Winding& winding = windings[neighbour.face];
        if (winding == Winding::unknown) {
          winding = wanted;
          part.push_back(neighbour.face);
        } else if (winding != wanted) {
          fail(fmt::format(
              "a surface: triangles {} and {} cannot be oriented consistently: the surface has only one side (a "
              "Moebius strip); cut it open",
              face, neighbour.face));
        }
      }
    }
    double volume = 0.0;
    const Vector3& origin = points[faces[start][0]];
    for (const std::size_t face : part) {
      if (windings[face] == Winding::reversed) std::swap(faces[face][1], faces[face][2]);
      const auto& [a, b, c] = faces[face];
      volume += meshes::tetrahedron_volume(origin, points[a], points[b], points[c]);
    }
    if (!closed || volume >= 0.0) continue;
    for (const std::size_t face : part) std::swap(faces[face][1], faces[face][2]);
  }
  return faces;
}

bool is_closed(std::span<const Face> faces) {
  bool closed = !faces.empty();
  const std::vector<Side> sides = sides_of(faces);
  for_each_edge(sides, [&](std::span<const Side> edge) { closed = closed && edge.size() == 2; });
  return closed;
}

std::vector<std::array<std::uint32_t, 4>> hinges_of(std::span<const Face> faces) {
  std::vector<std::array<std::uint32_t, 4>> hinges;
  const std::vector<Side> sides = sides_of(faces);
  for_each_edge(sides, [&](std::span<const Side> edge) {
    if (edge.size() != 2) return;
    const auto tip = [&](const Side& side) { return faces[side.face][(side.side + 2U) % 3]; };
    const auto& [lower, upper, face, side, rising] = edge[0];
    if (tip(edge[0]) == tip(edge[1])) return;  // the same triangle twice
    hinges.push_back({rising ? lower : upper, rising ? upper : lower, tip(edge[0]), tip(edge[1])});
  });
  return hinges;
}

}  // namespace springnet
