#include "table_nets.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <vector>

#include <springnet/material.hpp>
#include <springnet/scene.hpp>

#include "nets.hpp"

namespace springnet::benchmark {
namespace {

constexpr double standard_gravity = 9.81;  // m/s^2

SimulationOptions newton(double time_step) {
  SimulationOptions options;
  options.time_step = time_step;
  options.integrator = {"recurrent", {{"update", testing::newton}}};
  options.threads = 1;
  return options;
}

}  // namespace

Case hanging_lattice(std::uint32_t nodes_a_side, double stiffness) {
  Case one{.network = {}, .options = newton(0.02)};
  Lattice lattice;
  lattice.nodes = {nodes_a_side, nodes_a_side, nodes_a_side};
  lattice.diagonals = Diagonals::space;
  one.network.add_lattice("lattice", lattice, Node{}, one.network.add_material(testing::damped(stiffness, 1.0)));
  const NodeIndex layer = nodes_a_side * nodes_a_side, count = layer * nodes_a_side;
  for (NodeIndex k = count - layer; k < count; ++k) one.network.fix(k);
  one.network.set_gravity({0, 0, -standard_gravity});
  return one;
}

Case example(const std::string& name) {
  const std::filesystem::path file = std::filesystem::path(EXAMPLES_FOLDER) / name / (name + ".toml");
  Scene scene = load_scene(file, *testing::plugins());
  scene.options.threads = 1;
  return {std::move(scene.network), scene.options, scene.duration};
}

Case sheet() {
  Case one = example("sheet");
  one.options.time_step = 0.01;
  one.options.integrator.parameters["update"] = testing::newton;
  return one;
}

Case tissue(const Mesh& mesh) {
  constexpr double modulus = 1e4, density = 1000.0, damping_time = 0.01;  // Pa, kg/m^3, s
  constexpr double at_base = 1e-9;                                        // m
  Case one{.network = {}, .options = newton(0.01)};
  const std::vector<Edge> edges = edges_of(mesh);
  const std::vector<double> stiffness = stiffness_of(mesh, edges, modulus, {}).stiffness;
  const std::vector<double> masses = masses_of(mesh, density, {});
  for (std::size_t k = 0; k < mesh.points.size(); ++k) {
    Node node = testing::point(mesh.points[k], masses[k]);
    node.fixed = node.position.z() < at_base;
    one.network.add_node(node);
  }
  for (std::size_t s = 0; s < edges.size(); ++s) {
    const Material material{LawUse{"linear", {{"stiffness", stiffness[s]}}},
                            LawUse{"linear", {{"damping", damping_time * stiffness[s]}}}};
    one.network.add_spring(edges[s].first, edges[s].second, one.network.add_material(material));
  }
  one.network.set_gravity({0, 0, -standard_gravity});
  return one;
}

// A lattice whose points inside and on the sides are moved at random, within the sides that they are on, its cells cut
// into six tetrahedra around a diagonal. With cells mirrored and this scatter, steps take as many sweeps and iterations
// as those of Gmsh's mesh.
Mesh tissue_mesh(std::uint32_t points_a_side) {
  constexpr double size = 0.125, scatter = 0.2;  // m; greatest shift over the spacing
  const std::uint32_t n = points_a_side, cells = n - 1;
  const double spacing = size / cells;
  std::mt19937 random(1);
  std::vector<std::uint32_t> number(std::size_t{n} * n * n);
  std::iota(number.begin(), number.end(), 0u);
  // std::shuffle differs between standard libraries.
  for (std::size_t k = number.size(); k > 1; --k) std::swap(number[k - 1], number[random() % k]);
  const auto at = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) { return number[i + n * (j + n * k)]; };

  Mesh mesh;
  mesh.points.resize(number.size());
  for (std::uint32_t k = 0; k < n; ++k) {
    for (std::uint32_t j = 0; j < n; ++j) {
      for (std::uint32_t i = 0; i < n; ++i) {
        Vector3& point = mesh.points[at(i, j, k)];
        const std::array place{i, j, k};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double shift = scatter * (2.0 * static_cast<double>(random()) * 0x1p-32 - 1.0);
          const bool is_at_side = place[axis] == 0 || place[axis] == cells;
          point[static_cast<Eigen::Index>(axis)] = spacing * (place[axis] + (is_at_side ? 0.0 : shift));
        }
      }
    }
  }
  for (std::uint32_t k = 0; k < cells; ++k) {
    for (std::uint32_t j = 0; j < cells; ++j) {
      for (std::uint32_t i = 0; i < cells; ++i) {
        // From corner to opposite corner, an axis after the other, in each of the six orders; mirrored from cell to
        // cell, so that no direction of diagonals is preferred.
        const std::array mirrored{i % 2, j % 2, k % 2};
        std::array<std::uint32_t, 3> axes{0, 1, 2};
        do {
          std::array<std::uint32_t, 3> place{i + mirrored[0], j + mirrored[1], k + mirrored[2]};
          std::array<std::uint32_t, 4> corners{at(place[0], place[1], place[2])};
          for (std::size_t step = 0; step < 3; ++step) {
            const std::uint32_t axis = axes[step];
            place[axis] = mirrored[axis] == 1 ? place[axis] - 1 : place[axis] + 1;
            corners[step + 1] = at(place[0], place[1], place[2]);
          }
          const bool is_odd = (axes[0] > axes[1]) != ((axes[0] > axes[2]) != (axes[1] > axes[2]));
          if (is_odd != ((mirrored[0] + mirrored[1] + mirrored[2]) % 2 == 1)) {
            std::swap(corners[2], corners[3]);  // positive volume
          }
          mesh.add_cell(CellType::tetrahedron, corners);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
    }
  }
  return mesh;
}

}  // namespace springnet::benchmark
