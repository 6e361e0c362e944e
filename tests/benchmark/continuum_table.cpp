// The table of elements in core/docs/material.md: errors of `solid` and `membrane` against closed forms and published
// results, by the number of elements across, for Poisson ratios up to nearly 1/2. Prints Markdown. With the name of
// that page it checks instead that the page has the same rows.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <Eigen/SparseCholesky>

#include "layers/layout.hpp"
#include "layers/linear/linearisation.hpp"
#include "nets.hpp"

namespace {

using namespace springnet;

constexpr double modulus = 1.0;  // Pa

// Simplices of three or four corners, of which each has a volume above 0.
struct Simplices {
  std::vector<Vector3> points;
  std::vector<std::vector<NodeIndex>> cells;

  void add_tetrahedron(std::array<NodeIndex, 4> c) {
    const Vector3& a = points[c[0]];
    if ((points[c[1]] - a).cross(points[c[2]] - a).dot(points[c[3]] - a) < 0.0) std::swap(c[2], c[3]);
    cells.push_back({c.begin(), c.end()});
  }
};

// A problem of linear statics: the laws' stiffness at rest.
class Statics {
 public:
  Statics(const Simplices& mesh, const Material& material)
      : mesh_(mesh), held_(3 * mesh.points.size(), false), load_(Eigen::VectorXd::Zero(size())), x_(load_) {
    Network net;
    for (const Vector3& p : mesh.points) net.add_node(testing::point(p));
    const MaterialIndex index = net.add_material(material);
    for (const auto& cell : mesh.cells)
      net.add_element(cell.size() == 4 ? Invariant::tetrahedron : Invariant::triangle, cell, index);
    const std::size_t n = mesh.points.size();
    const layers::Layout layout(net, *testing::plugins(), false);
    const std::vector<double> mass(n, 1.0);
    const layers::Evaluator evaluator(layout, mass, InstructionSet::best, 1);
    const std::vector<std::uint8_t> constrained(n, 0);
    layers::Linearisation linearisation(layout, evaluator, constrained);
    std::vector<double> p[3];
    const std::vector<double> zero(n, 0.0);
    for (Eigen::Index c = 0; c < 3; ++c)
      for (const Vector3& point : mesh.points) p[c].push_back(point[c]);
    springnet_message message{};
    const layers::NodeArrays nodes{p[0].data(), p[1].data(), p[2].data(), zero.data(), zero.data(), zero.data()};
    if (linearisation.update(0.0, nodes, {}, message) != SPRINGNET_OK) throw std::runtime_error(message.text);
    // I - da/dp, with masses of 1 kg.
    linearisation.for_each_entry(0.0, 1.0, [&](int row, int column, double value) {
      stiffness_.emplace_back(row, column, row == column ? value - 1.0 : value);
    });
  }
  // A coordinate of a node, with a displacement, m; a force, N.
  void hold(std::size_t node, Eigen::Index axis, double displacement = 0.0) {
    held_[3 * node + static_cast<std::size_t>(axis)] = true;
    x_[3 * static_cast<Eigen::Index>(node) + axis] = displacement;
  }
  void add_force(std::size_t node, const Vector3& force) {
    load_.segment<3>(3 * static_cast<Eigen::Index>(node)) += force;
  }
  void solve() {
    std::vector<int> number(held_.size(), -1);
    int count = 0;
    for (std::size_t i = 0; i < held_.size(); ++i)
      if (!held_[i]) number[i] = count++;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
    std::vector<Eigen::Triplet<double>> own;
    for (Eigen::Index i = 0; i < size(); ++i)
      if (number[static_cast<std::size_t>(i)] >= 0) right[number[static_cast<std::size_t>(i)]] = load_[i];
    for (const auto& entry : stiffness_) {
      const int row = number[static_cast<std::size_t>(entry.row())],
                column = number[static_cast<std::size_t>(entry.col())];
      if (row < 0) continue;
      if (column >= 0)
        own.emplace_back(row, column, entry.value());
      else
        right[row] -= entry.value() * x_[entry.col()];
    }
    Eigen::SparseMatrix<double> matrix(count, count);
    matrix.setFromTriplets(own.begin(), own.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(matrix);
    if (solver.info() != Eigen::Success) throw std::runtime_error("a stiffness matrix is singular");
    const Eigen::VectorXd solution = solver.solve(right);
    for (Eigen::Index i = 0; i < size(); ++i)
      if (number[static_cast<std::size_t>(i)] >= 0) x_[i] = solution[number[static_cast<std::size_t>(i)]];
  }
  [[nodiscard]] Vector3 displacement(std::size_t node) const {
    return x_.segment<3>(3 * static_cast<Eigen::Index>(node));
  }
  // Twice the energy of the displacements, J.
  [[nodiscard]] double work() const {
    double sum = 0.0;
    for (const auto& entry : stiffness_) sum += x_[entry.row()] * entry.value() * x_[entry.col()];
    return sum;
  }

 private:
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(3 * mesh_.points.size()); }

  const Simplices& mesh_;
  std::vector<bool> held_;
  Eigen::VectorXd load_, x_;
  std::vector<Eigen::Triplet<double>> stiffness_;
};

Material solid(double nu) {
  return {LawUse{"solid", {{"youngs_modulus", modulus}, {"poisson_ratio", nu}}}, std::nullopt};
}
Material membrane(double nu, double thickness) {
  return {LawUse{"membrane", {{"youngs_modulus", modulus}, {"poisson_ratio", nu}, {"thickness", thickness}}},
          std::nullopt};
}

// A box of cubes with a side of 1 / cells m, `length` m long, each in five tetrahedra, mirrored from cube to cube.
// Points inside are moved at random by up to 0.2 of the spacing.
Simplices box(double length, std::uint32_t cells) {
  Simplices mesh;
  const auto along = static_cast<std::uint32_t>(std::lround(length)) * cells;
  const auto at = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    return static_cast<NodeIndex>(i + (along + 1) * (j + (cells + 1) * k));
  };
  std::mt19937 random(1);
  const auto shift = [&] { return 0.4 * (static_cast<double>(random()) * 0x1p-32 - 0.5); };
  for (std::uint32_t k = 0; k <= cells; ++k)
    for (std::uint32_t j = 0; j <= cells; ++j)
      for (std::uint32_t i = 0; i <= along; ++i) {
        Vector3 p(i, j, k);
        if (i > 0 && j > 0 && k > 0 && i < along && j < cells && k < cells)
          for (Eigen::Index c = 0; c < 3; ++c) p[c] += shift();
        mesh.points.push_back(p / cells);
      }
  static constexpr std::array<std::array<std::array<std::uint32_t, 4>, 5>, 2> parts{
      {{{{0, 1, 2, 4}, {3, 1, 2, 7}, {5, 1, 4, 7}, {6, 2, 4, 7}, {1, 2, 4, 7}}},
       {{{1, 0, 3, 5}, {2, 0, 3, 6}, {4, 0, 5, 6}, {7, 3, 5, 6}, {0, 3, 5, 6}}}}};
  for (std::uint32_t k = 0; k < cells; ++k)
    for (std::uint32_t j = 0; j < cells; ++j)
      for (std::uint32_t i = 0; i < along; ++i)
        for (const auto& part : parts[(i + j + k) % 2]) {
          std::array<NodeIndex, 4> corners{};
          for (std::size_t c = 0; c < 4; ++c)
            corners[c] = at(i + (part[c] & 1U), j + (part[c] >> 1U & 1U), k + (part[c] >> 2U));
          mesh.add_tetrahedron(corners);
        }
  return mesh;
}

bool is(double a, double b) { return std::abs(a - b) < 1e-9; }

// Calls force(node, part): of the triangles of cells in the plane x = `end` each corner has a third of its area.
void for_each_part_of_end(const Simplices& mesh, double end, const std::function<void(NodeIndex, double)>& force) {
  for (const auto& cell : mesh.cells) {
    std::vector<NodeIndex> face;
    for (const NodeIndex k : cell)
      if (is(mesh.points[k].x(), end)) face.push_back(k);
    if (face.size() != 3) continue;
    const auto& p = mesh.points;
    const double area = 0.5 * (p[face[1]] - p[face[0]]).cross(p[face[2]] - p[face[0]]).norm();
    for (const NodeIndex k : face) force(k, area / 3.0);
  }
}

// Errors, relative.
struct Tension {
  double modulus, poisson_ratio;
};
// A bar of 3 x 1 x 1 m between planes of symmetry, pulled.
Tension tension(double nu, std::uint32_t cells) {
  const Simplices mesh = box(3.0, cells);
  Statics statics(mesh, solid(nu));
  for (std::size_t k = 0; k < mesh.points.size(); ++k)
    for (Eigen::Index c = 0; c < 3; ++c)
      if (is(mesh.points[k][c], 0.0)) statics.hold(k, c);
  for_each_part_of_end(mesh, 3.0, [&](NodeIndex k, double part) { statics.add_force(k, {part, 0, 0}); });
  statics.solve();
  Tension worst{0.0, 0.0};
  for (std::size_t k = 0; k < mesh.points.size(); ++k) {
    const Vector3 &p = mesh.points[k], u = statics.displacement(k);
    worst.modulus = std::max(worst.modulus, std::abs(u.x() * modulus - p.x()) / 3.0);
    worst.poisson_ratio = std::max(worst.poisson_ratio, std::abs(u.y() * modulus + nu * p.y()) / nu);
  }
  return worst;
}

// A block whose boundary is sheared evenly: its energy against G / 2.
double shear(double nu, std::uint32_t cells) {
  const Simplices mesh = box(1.0, cells);
  Statics statics(mesh, solid(nu));
  for (std::size_t k = 0; k < mesh.points.size(); ++k) {
    const Vector3& p = mesh.points[k];
    bool inside = true;
    for (Eigen::Index c = 0; c < 3; ++c) inside = inside && !is(p[c], 0.0) && !is(p[c], 1.0);
    for (Eigen::Index c = 0; c < 3 && !inside; ++c) statics.hold(k, c, c == 0 ? p.y() : 0.0);
  }
  statics.solve();
  return statics.work() * 2.0 * (1.0 + nu) / modulus - 1.0;
}

// A cantilever of 5 x 1 x 1 m against Timoshenko's beam, with Cowper's shear coefficient.
double cantilever(double nu, std::uint32_t cells) {
  constexpr double length = 5.0;
  const Simplices mesh = box(length, cells);
  Statics statics(mesh, solid(nu));
  for (std::size_t k = 0; k < mesh.points.size(); ++k)
    for (Eigen::Index c = 0; c < 3 && is(mesh.points[k].x(), 0.0); ++c) statics.hold(k, c);
  for_each_part_of_end(mesh, length, [&](NodeIndex k, double part) { statics.add_force(k, {0, part, 0}); });
  statics.solve();
  double deflection = 0.0;
  for_each_part_of_end(mesh, length,
                       [&](NodeIndex k, double part) { deflection += part * statics.displacement(k).y(); });
  const double shear_modulus = modulus / (2.0 * (1.0 + nu)), kappa = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
  return deflection / (4.0 * length * length * length / modulus + length / (kappa * shear_modulus)) - 1.0;
}

// R. D. Cook's membrane (J. Struct. Div. ASCE 100 (1974) 1851-1863): a tapered and swept panel of thickness 1 in plane
// stress with nu = 1/3, held at one side, a force of 1 along the other; the deflection of the middle of that side.
constexpr double cook_reference = 23.96;
double cook(std::uint32_t cells) {
  Simplices mesh;
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return static_cast<NodeIndex>(i + (cells + 1) * j); };
  for (std::uint32_t j = 0; j <= cells; ++j)
    for (std::uint32_t i = 0; i <= cells; ++i) {
      const double s = static_cast<double>(i) / cells, t = static_cast<double>(j) / cells;
      mesh.points.emplace_back(48.0 * s, 44.0 * s * (1.0 - t) + (44.0 + 16.0 * s) * t, 0.0);
    }
  for (std::uint32_t j = 0; j < cells; ++j)
    for (std::uint32_t i = 0; i < cells; ++i) {
      const NodeIndex a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      if ((mesh.points[a] - mesh.points[c]).norm() < (mesh.points[b] - mesh.points[d]).norm()) {
        mesh.cells.push_back({a, b, c});
        mesh.cells.push_back({a, c, d});
      } else {
        mesh.cells.push_back({a, b, d});
        mesh.cells.push_back({b, c, d});
      }
    }
  Statics statics(mesh, membrane(1.0 / 3.0, 1.0));
  for (std::size_t k = 0; k < mesh.points.size(); ++k) {
    statics.hold(k, 2);
    if (!is(mesh.points[k].x(), 0.0)) continue;
    statics.hold(k, 0);
    statics.hold(k, 1);
  }
  for (std::uint32_t j = 0; j < cells; ++j)
    for (const std::uint32_t end : {j, j + 1}) statics.add_force(at(cells, end), {0.0, 0.5 / cells, 0.0});
  statics.solve();
  return statics.displacement(at(cells, cells / 2)).y() / cook_reference - 1.0;
}

// An eighth of a sphere from radius 1 to 2 m under pressure from inside, against Lame's solution: the radial
// displacement of the inside.
double sphere(double nu, std::uint32_t cells) {
  constexpr double inner = 1.0, outer = 2.0;
  Simplices mesh;
  std::vector<std::vector<NodeIndex>> number(cells + 1, std::vector<NodeIndex>(cells + 1));
  std::vector<Vector3> directions;
  for (std::uint32_t i = 0; i <= cells; ++i)
    for (std::uint32_t j = 0; i + j <= cells; ++j) {
      number[i][j] = static_cast<NodeIndex>(directions.size());
      // On each side the angle is divided evenly.
      const auto angle = [&](std::uint32_t part) { return std::sin(0.5 * std::numbers::pi * part / cells); };
      directions.push_back(Vector3(angle(i), angle(j), angle(cells - i - j)).normalized());
    }
  const auto columns = static_cast<NodeIndex>(directions.size());
  for (std::uint32_t layer = 0; layer <= cells; ++layer)
    for (const Vector3& d : directions) mesh.points.push_back((inner + (outer - inner) * layer / cells) * d);
  std::vector<std::array<NodeIndex, 3>> triangles;
  for (std::uint32_t i = 0; i < cells; ++i)
    for (std::uint32_t j = 0; i + j < cells; ++j) {
      triangles.push_back({number[i][j], number[i + 1][j], number[i][j + 1]});
      if (i + j + 1 < cells) triangles.push_back({number[i + 1][j], number[i + 1][j + 1], number[i][j + 1]});
    }
  for (auto& triangle : triangles) std::sort(triangle.begin(), triangle.end());  // so that neighbours fit
  for (std::uint32_t layer = 0; layer < cells; ++layer)
    for (const auto& [a, b, c] : triangles) {
      const NodeIndex low = layer * columns, high = low + columns;
      mesh.add_tetrahedron({low + a, low + b, low + c, high + c});
      mesh.add_tetrahedron({low + a, low + b, high + b, high + c});
      mesh.add_tetrahedron({low + a, high + a, high + b, high + c});
    }
  Statics statics(mesh, solid(nu));
  for (std::size_t k = 0; k < mesh.points.size(); ++k)
    for (Eigen::Index c = 0; c < 3; ++c)
      if (is(mesh.points[k][c], 0.0)) statics.hold(k, c);
  std::vector<double> area(columns, 0.0);
  double whole = 0.0;
  for (const auto& triangle : triangles) {
    const auto& p = mesh.points;
    Vector3 vector = 0.5 * (p[triangle[1]] - p[triangle[0]]).cross(p[triangle[2]] - p[triangle[0]]);
    if (vector.dot(p[triangle[0]]) < 0.0) vector = -vector;
    for (const NodeIndex k : triangle) {
      statics.add_force(k, vector / 3.0);  // a pressure of 1 Pa
      area[k] += vector.norm() / 3.0;
      whole += vector.norm() / 3.0;
    }
  }
  statics.solve();
  double mean = 0.0;
  for (NodeIndex k = 0; k < columns; ++k) mean += area[k] / whole * statics.displacement(k).dot(directions[k]);
  const double a3 = inner * inner * inner, b3 = outer * outer * outer;
  const double exact =
      a3 / (modulus * (b3 - a3)) * ((1.0 - 2.0 * nu) * inner + 0.5 * (1.0 + nu) * b3 / (inner * inner));
  return mean / exact - 1.0;
}

// In per cent.
std::string percent(double error) {
  if (std::abs(error) < 1e-10) return "0 (rounding)";
  return std::abs(error) < 5e-5 ? "0.00" : fmt::format("{:+.2f}", 100.0 * error);
}

std::string row_of(const std::string& test, const std::string& nu, const std::vector<std::uint32_t>& sizes,
                   const std::function<double(std::uint32_t)>& error) {
  std::string row = fmt::format("| {} | {} |", test, nu);
  double before = 0.0, last = 0.0;
  for (const std::uint32_t cells : {2U, 4U, 8U, 16U}) {
    if (std::find(sizes.begin(), sizes.end(), cells) == sizes.end()) {
      row += " |";
      continue;
    }
    before = last;
    last = error(cells);
    row += fmt::format(" {} |", percent(last));
  }
  return row +
         (std::abs(last) > 1e-10 && before / last > 0.0 ? fmt::format(" {:.1f} |", std::log2(before / last)) : " |");
}

std::vector<std::function<std::string()>> rows() {
  const std::vector<std::uint32_t> coarse{2, 4}, solids{2, 4, 8}, all{2, 4, 8, 16};
  std::vector<std::function<std::string()>> result{
      [=] { return row_of("bar, E", "0.45", coarse, [](std::uint32_t n) { return tension(0.45, n).modulus; }); },
      [=] {
        return row_of("bar, Poisson ratio", "0.45", coarse,
                      [](std::uint32_t n) { return tension(0.45, n).poisson_ratio; });
      },
      [=] { return row_of("block, G", "0.45", coarse, [](std::uint32_t n) { return shear(0.45, n); }); },
      [=] { return row_of("Cook's membrane", "1/3", all, cook); }};
  for (const double nu : {0.0, 0.3, 0.45, 0.49, 0.499})
    result.emplace_back([=] {
      return row_of("cantilever", fmt::format("{}", nu), solids, [nu](std::uint32_t n) { return cantilever(nu, n); });
    });
  for (const double nu : {0.0, 0.3, 0.45, 0.49, 0.499})
    result.emplace_back(
        [=] { return row_of("sphere", fmt::format("{}", nu), all, [nu](std::uint32_t n) { return sphere(nu, n); }); });
  return result;
}

bool page_has(const std::string& page, const std::string& row) {
  std::ifstream stream(page);
  for (std::string line; std::getline(stream, line);)
    if (line == row) return true;
  fmt::print("{} lacks the row\n{}\n", page, row);
  return false;
}

bool print_table(const std::string& page) {
  bool same = true;
  if (page.empty()) {
    fmt::print("| test | Poisson ratio | 2 across, % | 4 across, % | 8 across, % | 16 across, % | order |\n");
    fmt::print("|---|---|---|---|---|---|---|\n");
  }
  for (const auto& row : rows()) {
    if (!page.empty()) {
      same = page_has(page, row()) && same;
    } else {
      fmt::print("{}\n", row());
      std::fflush(stdout);
    }
  }
  return same;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return print_table(argc > 1 ? argv[1] : "") ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "springnet_continuum_table: {}\n", error.what());
    return 1;
  }
}
