// The table of core/docs/material.md: errors of nets of springs against their material, on a bar in
// tension, a cantilever and a block in shear. Prints Markdown. With the name of that page it checks instead that the
// page has the same rows.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <springnet/error.hpp>
#include <springnet/material.hpp>
#include <springnet/simulation.hpp>

#include "material/sharing.hpp"
#include "nets.hpp"

namespace {

using namespace springnet;
using material::Sharing;

constexpr double modulus = 1.0;          // Pa
constexpr double thickness = 0.5;        // m, of sheets
constexpr double length = 5.0;           // m, of bar and cantilever; height and depth are 1 m
constexpr double side_tolerance = 1e-9;  // m, to recognise points on a side

// Small enough for a linear response. Sheets, which have no stiffness across their plane, are kept from buckling by
// the inertia of the time step alone.
constexpr double strain = 1e-7;
// m / t^2 over the stiffness of a spring: above the compressive strains, so that the steps stay definite, and far below
// the lowest mode of the cantilever, some 1e-5 of it, so that each step leaves a tenth of the way to rest or less.
constexpr double inertia = 1e-6;
constexpr int step_count = 10;
constexpr double at_rest = 1e-5;  // greatest net force on a free node over the greatest force in a spring

enum class Kind { lattice, flat_2, flat_5, space_lattice, tetrahedra, gmsh, quadrilaterals, triangles };

bool is_sheet(Kind kind) { return kind == Kind::quadrilaterals || kind == Kind::triangles; }

struct Net {
  Mesh mesh;
  std::vector<Edge> edges;
  int dimension;
  Vector3 size;                        // m; from the origin
  std::array<std::uint32_t, 3> nodes;  // of a lattice
  Vector3 spacing;                     // m; of other nets about that of nodes
  std::vector<double> parts;           // [point] of an end's force; of lattices from their numbers

  [[nodiscard]] double depth() const { return dimension == 3 ? size.z() : thickness; }
  // Of point k in the lattice, by axis.
  [[nodiscard]] std::array<std::uint32_t, 3> place(std::size_t k) const {
    const auto index = static_cast<std::uint32_t>(k);
    return {index % nodes[0], index / nodes[0] % nodes[1], index / nodes[0] / nodes[1]};
  }
  [[nodiscard]] bool at_side(std::size_t k, std::size_t axis) const {
    const auto a = static_cast<Eigen::Index>(axis);
    const double coordinate = mesh.points[k][a];
    return size[a] > 0 && (coordinate < side_tolerance || coordinate > size[a] - side_tolerance);
  }
  [[nodiscard]] bool at_start(std::size_t k) const { return mesh.points[k].x() < side_tolerance; }
  [[nodiscard]] bool at_end(std::size_t k) const { return mesh.points[k].x() > size.x() - side_tolerance; }
  [[nodiscard]] bool on_boundary(std::size_t k) const { return at_side(k, 0) || at_side(k, 1) || at_side(k, 2); }
  // The part of an end's force at a point of it.
  [[nodiscard]] double part(std::size_t k) const {
    if (!parts.empty()) return parts[k];
    double result = 1.0;
    for (const std::size_t axis : {std::size_t{1}, std::size_t{2}}) {
      if (nodes[axis] > 1) result *= (at_side(k, axis) ? 0.5 : 1.0) / (nodes[axis] - 1.0);
    }
    return result;
  }
};

// Points inside and on the sides, but not those of the ends, are moved at random, within the sides that they are on, by
// up to this fraction of the spacing.
constexpr double scatter = 0.2;

void scatter_points(Net& net) {
  std::mt19937 random(1);
  for (std::size_t k = 0; k < net.mesh.points.size(); ++k) {
    // Every other row of a sheet is half a triangle back, so that triangles are about as regular as a mesher's.
    if (net.dimension == 2 && net.place(k)[1] % 2 == 1 && !net.at_side(k, 0))
      net.mesh.points[k].x() -= 0.5 * net.spacing.x();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double shift = 2.0 * scatter * (static_cast<double>(random()) * 0x1p-32 - 0.5) * net.spacing.x();
      if (net.nodes[axis] == 1 || net.at_side(k, axis) || net.at_side(k, 0)) continue;
      net.mesh.points[k][static_cast<Eigen::Index>(axis)] += shift;
    }
  }
}

// Hexahedra as five tetrahedra, mirrored from cell to cell so that neighbours fit; quadrilaterals as two triangles, by
// the shorter diagonal.
Mesh divided(const Net& net) {
  using Simplex = std::vector<std::uint32_t>;
  static const std::array<std::vector<Simplex>, 2> solid{
      {{{0, 1, 2, 5}, {0, 2, 3, 7}, {0, 5, 7, 4}, {2, 7, 5, 6}, {0, 2, 7, 5}},
       {{1, 0, 4, 3}, {1, 2, 3, 6}, {1, 4, 5, 6}, {3, 6, 4, 7}, {1, 3, 4, 6}}}};
  static const std::array<std::vector<Simplex>, 2> sheet{{{{0, 1, 2}, {0, 2, 3}}, {{0, 1, 3}, {1, 2, 3}}}};
  Mesh mesh;
  mesh.points = net.mesh.points;
  for (std::size_t c = 0; c < net.mesh.cell_count(); ++c) {
    const auto cell = net.mesh.cell(c);
    const auto place = net.place(cell[0]);
    const std::size_t odd = (net.dimension == 3 ? place[0] + place[1] + place[2] : place[1]) % 2;
    for (const Simplex& simplex : net.dimension == 3 ? solid[odd] : sheet[odd]) {
      std::vector<std::uint32_t> corners;
      for (const std::uint32_t k : simplex) corners.push_back(cell[k]);
      mesh.add_cell(net.dimension == 3 ? CellType::tetrahedron : CellType::triangle, corners);
    }
  }
  return mesh;
}

// bar.msh and block.msh, by gmsh 4.8 -3 -format msh41 from
//   SetFactory("OpenCASCADE"); Box(1) = {0, 0, 0, 5, 1, 1}; Physical Volume("tissue") = {1};
//   Mesh.MeshSizeMin = 0.25; Mesh.MeshSizeMax = 0.25;
// and with a length of 1 instead of 5.
Net read_net(double extent) {
  Net net{};
  net.dimension = 3;
  net.size = {extent, 1.0, 1.0};
  net.spacing.setConstant(0.25);
  const std::filesystem::path folder = MESH_FOLDER;
  net.mesh = read_mesh(folder / (extent > 1.0 ? "bar.msh" : "block.msh"));
  net.edges = edges_of(net.mesh);
  // Even traction: a third of each triangle of the end at its corners.
  net.parts.assign(net.mesh.points.size(), 0.0);
  for (const Face& face : surface_of(net.mesh)) {
    if (!std::all_of(face.begin(), face.end(), [&](std::uint32_t k) { return net.at_end(k); })) continue;
    const auto& p = net.mesh.points;
    const double area = 0.5 * (p[face[1]] - p[face[0]]).cross(p[face[2]] - p[face[0]]).norm();
    for (const std::uint32_t k : face) net.parts[k] += area / 3.0;
  }
  return net;
}

Net make_net(Kind kind, double extent, std::uint32_t cells) {
  if (kind == Kind::gmsh) return read_net(extent);
  Net net;
  net.dimension = is_sheet(kind) ? 2 : 3;
  const std::uint32_t flat = kind == Kind::flat_2 ? 2 : kind == Kind::flat_5 ? 5 : 1;  // in z
  net.spacing = Vector3::Constant(1.0 / cells);
  net.spacing.z() /= flat;
  const auto along = static_cast<std::uint32_t>(extent) * cells;
  net.nodes = {along + 1, cells + 1, net.dimension == 3 ? flat * cells + 1 : 1};
  net.size = {extent, 1.0, net.dimension == 3 ? 1.0 : 0.0};
  Lattice lattice;
  lattice.nodes = net.nodes;
  lattice.spacing = net.spacing;
  net.mesh = mesh_of(lattice);
  EdgeOptions options;
  if (kind == Kind::tetrahedra || kind == Kind::triangles) {
    scatter_points(net);
    net.mesh = divided(net);
  } else {
    options = {.face_diagonals = kind != Kind::space_lattice, .space_diagonals = net.dimension == 3};
  }
  net.edges = edges_of(net.mesh, options);
  return net;
}

Network network_of(const Net& net, Sharing sharing) {
  const NetStiffness springs = material::stiffness_of(net.mesh, net.edges, modulus, {.thickness = thickness}, sharing);
  Network network;
  for (const Vector3& point : net.mesh.points) network.add_node(testing::point(point));
  for (std::size_t s = 0; s < net.edges.size(); ++s) {
    network.add_spring(net.edges[s].first, net.edges[s].second,
                       network.add_material(testing::damped(springs.stiffness[s], 0.0)));
  }
  return network;
}

// Displacements at rest, by Newton's method with steps so long that little else than the springs counts.
Simulation at_rest_of(const Net& net, const Network& network) {
  const double stiffness = modulus * net.spacing.maxCoeff();  // N/m, about that of a spring
  // Rounding of a position, 1e-15 m, changes a spring's force by a hundredth of this.
  const double tolerance = 1e-13 * stiffness;
  Simulation simulation = testing::simulate(network, testing::recurrent(testing::newton, tolerance),
                                            std::sqrt(1.0 / (inertia * stiffness)));
  for (int step = 0; step < step_count; ++step) simulation.step();
  std::vector<double> tensions;
  simulation.tensions(tensions);
  double tension = 0.0, force = 0.0;
  for (const double t : tensions) tension = std::max(tension, std::abs(t));
  for (NodeIndex k = 0; k < network.nodes().size(); ++k) {
    if (!network.nodes()[k].fixed) force = std::max(force, simulation.force(k).norm());
  }
  if (!(force <= at_rest * tension)) {
    throw std::runtime_error(fmt::format("a net of {} nodes is not at rest: net force {:.2g} of tension {:.2g}",
                                         network.nodes().size(), force, tension));
  }
  return simulation;
}

// Slope of y over x of the pairs by least squares.
double slope(const std::vector<std::pair<double, double>>& pairs) {
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  const auto count = static_cast<double>(pairs.size());
  for (const auto& [a, b] : pairs) x += a / count, y += b / count;
  for (const auto& [a, b] : pairs) xx += (a - x) * (a - x), xy += (a - x) * (b - y);
  return xy / xx;
}

void pull_end(const Net& net, Network& network, const Vector3& force) {
  for (std::size_t k = 0; k < net.mesh.points.size(); ++k) {
    const auto node = static_cast<NodeIndex>(k);
    if (net.at_start(k)) network.fix(node);
    if (net.at_end(k)) network.add_load({{node}, net.part(k) * force});
  }
}

struct Tension {
  double modulus;  // Pa
  double poisson_ratio;
};

// The middle half of the bar, away from the fixed end, which hinders contraction.
Tension tension(const Net& net, Sharing sharing) {
  Network network = network_of(net, sharing);
  pull_end(net, network, {strain * modulus * net.depth(), 0, 0});
  const Simulation simulation = at_rest_of(net, network);
  std::vector<std::pair<double, double>> along, across;
  for (std::size_t k = 0; k < net.mesh.points.size(); ++k) {
    const Vector3& p = net.mesh.points[k];
    if (p.x() < 0.25 * length || p.x() > 0.75 * length) continue;
    const Vector3 u = simulation.position(static_cast<NodeIndex>(k)) - p;
    along.emplace_back(p.x(), u.x());
    across.emplace_back(p.y(), u.y());
  }
  return {strain * modulus / slope(along), -slope(across) / slope(along)};
}

// Deflection of the end over that of Timoshenko's beam, F L^3 / 3 E I + F L / kappa G A, with Cowper's kappa = 10 (1 +
// nu) / (12 + 11 nu) of a rectangle (J. Appl. Mech. 33 (1966) 335-340).
double cantilever(const Net& net, Sharing sharing) {
  const double force = 0.1 * strain * modulus * net.depth();
  Network network = network_of(net, sharing);
  pull_end(net, network, {0, force, 0});
  const Simulation simulation = at_rest_of(net, network);
  double deflection = 0.0;
  for (std::size_t k = 0; k < net.mesh.points.size(); ++k) {
    if (!net.at_end(k)) continue;
    deflection += net.part(k) * (simulation.position(static_cast<NodeIndex>(k)) - net.mesh.points[k]).y();
  }
  const double nu = poisson_ratio_of_net(net.dimension), shear_modulus = modulus / (2.0 * (1.0 + nu));
  const double kappa = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
  const double bending = std::pow(length, 3) / (3.0 * modulus * net.depth() / 12.0);
  return deflection / (force * (bending + length / (kappa * shear_modulus * net.depth())));
}

// Twice the energy of a block for each volume and squared strain, if its whole boundary is displaced by `gradient`
// times the strain and it is at rest within.
double block_stiffness(const Net& net, Sharing sharing, const Eigen::Matrix3d& gradient) {
  Network network = network_of(net, sharing);
  for (NodeIndex k = 0; k < net.mesh.points.size(); ++k) {
    Node node = network.nodes()[k];
    node.position += strain * gradient * net.mesh.points[k];
    node.fixed = net.on_boundary(k);
    network.set_node(k, node);
  }
  const double volume = net.size.x() * net.size.y() * net.depth();
  return 2.0 * at_rest_of(net, network).potential_energy() / (strain * strain * volume);
}

// Over that of the material, 2 E / 3 in a solid and 3 E / 4 in a sheet: a block dilated evenly has 9 K, a sheet 4 K.
double bulk(const Net& net, Sharing sharing) {
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();
  if (net.dimension == 2) gradient(2, 2) = 0.0;
  return block_stiffness(net, sharing, gradient) / (net.dimension == 3 ? 6.0 * modulus : 3.0 * modulus);
}

// Shear modulus over E / 2 (1 + nu); the mean over the planes of shear.
double shear(const Net& net, Sharing sharing) {
  const double wanted = modulus / (2.0 * (1.0 + poisson_ratio_of_net(net.dimension)));
  std::vector<std::pair<Eigen::Index, Eigen::Index>> planes{{0, 1}};
  if (net.dimension == 3) planes.insert(planes.end(), {{1, 2}, {2, 0}});
  double mean = 0.0;
  for (const auto& [to, by] : planes) {
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
    gradient(to, by) = 1.0;
    mean += block_stiffness(net, sharing, gradient);
  }
  return mean / static_cast<double>(planes.size()) / wanted;
}

struct Case {
  const char* name;
  Kind kind;
  Sharing sharing;
};
constexpr std::array cases{Case{"hexahedra, all diagonals", Kind::lattice, Sharing::best},
                           Case{"hexahedra 2 : 1, all diagonals", Kind::flat_2, Sharing::best},
                           Case{"hexahedra 5 : 1, all diagonals", Kind::flat_5, Sharing::best},
                           Case{"hexahedra, space diagonals", Kind::space_lattice, Sharing::best},
                           Case{"tetrahedra", Kind::tetrahedra, Sharing::best},
                           Case{"tetrahedra, Gmsh", Kind::gmsh, Sharing::best},
                           Case{"tetrahedra, fitted", Kind::tetrahedra, Sharing::fitted},
                           Case{"quadrilaterals, diagonals", Kind::quadrilaterals, Sharing::best},
                           Case{"triangles", Kind::triangles, Sharing::best},
                           Case{"triangles, fitted", Kind::triangles, Sharing::fitted}};

std::string row_of(const Case& one, std::uint32_t cells) {
  const Net bar = make_net(one.kind, length, cells), block = make_net(one.kind, 1.0, cells);
  const Tension pulled = tension(bar, one.sharing);
  // In per cent; without a sign where rounding would choose it.
  const auto error = [](double ratio) {
    const double percent = 100.0 * (ratio - 1.0);
    return std::abs(percent) < 0.05 ? std::string("0.0") : fmt::format("{:+.1f}", percent);
  };
  return fmt::format("| {} | {} | {} | {} | {} | {:.3f} | {} | {} | {} |", one.name, cells, bar.mesh.points.size(),
                     bar.edges.size(), error(pulled.modulus / modulus), pulled.poisson_ratio,
                     error(bulk(block, one.sharing)), error(shear(block, one.sharing)),
                     error(cantilever(bar, one.sharing)));
}

// Cells across.
std::vector<std::uint32_t> sizes_of(Kind kind) {
  if (kind == Kind::gmsh) return {4};
  if (kind == Kind::flat_2) return {2, 4};
  if (kind == Kind::flat_5) return {2};
  return is_sheet(kind) ? std::vector{2u, 4u, 8u} : std::vector{2u, 3u, 4u};
}

// The rows of the page that begin like rows of the table, each once.
bool page_has(const std::string& page, const std::string& row) {
  std::ifstream stream(page);
  for (std::string line; std::getline(stream, line);) {
    if (line == row) return true;
  }
  fmt::print("{} lacks the row\n{}\n", page, row);
  return false;
}

bool print_table(const std::string& page) {
  bool same = true;
  if (page.empty()) {
    fmt::print("| cells | across | nodes | springs | E, % | Poisson ratio | K, % | G, % | deflection, % |\n");
    fmt::print("|---|---|---|---|---|---|---|---|---|\n");
  }
  for (const Case& one : cases) {
    for (const std::uint32_t cells : sizes_of(one.kind)) {
      const std::string row = row_of(one, cells);
      if (!page.empty()) {
        same = page_has(page, row) && same;
      } else {
        fmt::print("{}\n", row);
        std::fflush(stdout);
      }
    }
  }
  return same;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return print_table(argc > 1 ? argv[1] : "") ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "springnet_material_table: {}\n", error.what());
    return 1;
  }
}
