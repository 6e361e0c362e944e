// Springs of a material against the elasticity tensor that they stand for.
#include <array>
#include <cmath>
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <springnet/error.hpp>
#include <springnet/material.hpp>

using namespace springnet;

namespace {

constexpr double modulus = 5.0;  // Pa

// sum k l^2 n n n n of all springs over the volume: twice the energy of homogeneous strains.
struct Tensor {
  double c[3][3][3][3] = {};

  Tensor(const Mesh& mesh, const std::vector<Edge>& edges, const std::vector<double>& stiffness, double volume) {
    for (std::size_t s = 0; s < edges.size(); ++s) {
      const Vector3 d = mesh.points[edges[s].second] - mesh.points[edges[s].first];
      const Vector3 n = d.normalized();
      for (int i = 0; i < 81; ++i) {
        c[i / 27][i / 9 % 3][i / 3 % 3][i % 3] +=
            stiffness[s] * d.squaredNorm() / volume * n[i / 27] * n[i / 9 % 3] * n[i / 3 % 3] * n[i % 3];
      }
    }
  }

  // Greatest difference from lambda (d_ij d_kl + d_ik d_jl + d_il d_jk) in the first `dimension` coordinates, over
  // lambda.
  [[nodiscard]] double difference(double lambda, int dimension) const {
    double greatest = 0;
    for (int i = 0; i < 81; ++i) {
      const int a = i / 27, b = i / 9 % 3, e = i / 3 % 3, f = i % 3;
      const bool inside = std::max(std::max(a, b), std::max(e, f)) < dimension;
      const double wanted = inside ? lambda * ((a == b) * (e == f) + (a == e) * (b == f) + (a == f) * (b == e)) : 0.0;
      greatest = std::max(greatest, std::abs(c[a][b][e][f] - wanted));
    }
    return greatest / lambda;
  }
};

constexpr double lambda_solid = 2.0 / 5.0 * modulus;  // E nu / ((1 + nu) (1 - 2 nu)) at nu = 1/4
constexpr double lambda_sheet = 3.0 / 8.0 * modulus;  // E nu / (1 - nu^2) at nu = 1/3

// The shares of a cell are regularised by 1e-10.
constexpr double exact = 1e-8;

Lattice lattice(std::array<std::uint32_t, 3> nodes, const Vector3& spacing) {
  Lattice result;
  result.nodes = nodes;
  result.spacing = spacing;
  return result;
}

Mesh single(CellType type, const std::vector<Vector3>& points) {
  Mesh mesh;
  mesh.points = points;
  std::vector<std::uint32_t> corners(points.size());
  for (std::uint32_t k = 0; k < corners.size(); ++k) corners[k] = k;
  mesh.add_cell(type, corners);
  return mesh;
}

double trace_over_modulus(const Mesh& mesh, const std::vector<Edge>& edges, const std::vector<double>& stiffness) {
  double sum = 0;
  for (std::size_t s = 0; s < edges.size(); ++s) {
    sum += stiffness[s] * (mesh.points[edges[s].second] - mesh.points[edges[s].first]).squaredNorm();
  }
  return sum / modulus;
}

}  // namespace

TEST_CASE("the Poisson ratio of a net follows from the symmetry of its elasticity") {
  // C_xxyy / (C_xxxx + C_xxyy) of a solid, C_xxyy / C_xxxx of a sheet, with C_xxxx = 3 C_xxyy.
  CHECK(poisson_ratio_of_net(3) == 1.0 / (3 + 1));
  CHECK(poisson_ratio_of_net(2) == 1.0 / 3);
}

TEST_CASE("hexahedra with diagonals are exactly isotropic") {
  for (const Vector3& spacing : {Vector3(1, 1, 1), Vector3(1, 1.1, 0.9)}) {
    const Mesh mesh = mesh_of(lattice({3, 4, 5}, spacing));
    const double volume = 2 * 3 * 4 * spacing.prod();
    for (const bool space : {false, true}) {
      CAPTURE(space);
      const std::vector<Edge> edges = edges_of(mesh, {.face_diagonals = true, .space_diagonals = space});
      const NetStiffness net = stiffness_of(mesh, edges, modulus, {});
      CHECK(net.dimension == 3);
      CHECK(net.misfit < 1e-7);  // the root of a difference of rounded squares
      CHECK_FALSE(net.lacks_shear);
      CHECK(Tensor(mesh, edges, net.stiffness, volume).difference(lambda_solid, 3) < exact);
    }
  }
  // Through the cells alone: four directions have one strength, which is enough in a cube.
  const Mesh cubes = mesh_of(lattice({3, 3, 3}, Vector3::Ones()));
  const std::vector<Edge> edges = edges_of(cubes, {.space_diagonals = true});
  const NetStiffness net = stiffness_of(cubes, edges, modulus, {});
  CHECK(Tensor(cubes, edges, net.stiffness, 8.0).difference(lambda_solid, 3) < exact);
}

TEST_CASE("the springs within a lattice whose coordinates are rounded have few stiffnesses") {
  Lattice rounded = lattice({6, 6, 6}, {0.1, 0.1, 0.1});
  rounded.origin = {0.7, 0.3, -5.1};
  const Mesh mesh = mesh_of(rounded);
  const NetStiffness net =
      stiffness_of(mesh, edges_of(mesh, {.face_diagonals = true, .space_diagonals = true}), modulus, {});
  // Axial springs have 1, 2 or 4 cells, face diagonals 1 or 2, space diagonals 1; their shares differ by rounding
  // between the places in a cell, 28 at most.
  CHECK(std::set<double>(net.stiffness.begin(), net.stiffness.end()).size() < 6 * 28);
}

TEST_CASE("quadrilaterals with diagonals are exactly isotropic in their plane") {
  const Mesh mesh = mesh_of(lattice({4, 3, 1}, {0.5, 0.4, 1}));
  const std::vector<Edge> edges = edges_of(mesh, {.face_diagonals = true});
  const NetStiffness net = stiffness_of(mesh, edges, modulus, {.thickness = 0.1});
  CHECK(Tensor(mesh, edges, net.stiffness, 1.5 * 0.8 * 0.1).difference(lambda_sheet, 2) < exact);
  CHECK_FALSE(net.lacks_shear);
}

TEST_CASE("regular triangles and tetrahedra are isotropic as far as their symmetry goes") {
  const Mesh triangle = single(CellType::triangle, {{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}});
  const NetStiffness net = stiffness_of(triangle, edges_of(triangle), modulus, {.thickness = 2.0});
  CHECK(Tensor(triangle, edges_of(triangle), net.stiffness, std::sqrt(0.75)).difference(lambda_sheet, 2) < 1e-14);
  // The known k = sqrt(3) / 4 E t of a triangle's own springs: that of a net of two triangles a spring is twice it.
  for (const double k : net.stiffness) CHECK(k == doctest::Approx(std::sqrt(3.0) / 4 * modulus * 2.0).epsilon(1e-14));
}

TEST_CASE("every net whose nodes move evenly has the bulk modulus of its material") {
  // sum k l^2 = 9 K V with K = 2 E / 3 in a solid, 4 K A t with K = 3 E / 4 in a sheet, for any shape of the cells.
  const auto check = [](const Mesh& mesh, const Section& section, double expected) {
    const std::vector<Edge> edges = edges_of(mesh);
    const NetStiffness net = stiffness_of(mesh, edges, modulus, section);
    CHECK(trace_over_modulus(mesh, edges, net.stiffness) == doctest::Approx(expected).epsilon(1e-13));
    for (const double k : net.stiffness) CHECK(k >= 0);
  };
  check(single(CellType::tetrahedron, {{0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}, {0.2, 0.1, 3}}), {}, 6 * 0.5);
  check(single(CellType::wedge, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}, {1, 0, 2}, {0, 1, 2}}), {}, 6 * 1.0);
  check(single(CellType::pyramid, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 3}}), {}, 6 * 1.0);
  check(single(CellType::triangle, {{0, 0, 5}, {2, 0, 5}, {0.1, 1, 5}}), {.thickness = 0.1}, 3 * 0.1);
  check(single(CellType::line, {{0, 0, 0}, {0, 3, 4}}), {.cross_section = 0.2}, 5 * 0.2);
}

TEST_CASE("a cell flatter than springs can follow gets no spring of negative stiffness") {
  const Mesh mesh = mesh_of(lattice({3, 3, 3}, {1, 1, 0.1}));
  const std::vector<Edge> edges = edges_of(mesh, {.face_diagonals = true, .space_diagonals = true});
  const NetStiffness net = stiffness_of(mesh, edges, modulus, {});
  for (const double k : net.stiffness) CHECK(k >= 0);
  CHECK(trace_over_modulus(mesh, edges, net.stiffness) == doctest::Approx(6 * 0.8).epsilon(1e-13));
  CHECK(net.misfit > 0.01);  // it cannot be isotropic
  CHECK(net.fitted_misfit == net.misfit);
}

TEST_CASE("boxes within 1 : 1.7 are isotropic, flatter ones less and less, and how much is known") {
  const auto misfit = [](double height) {
    const Mesh mesh = mesh_of(lattice({2, 2, 2}, {1, 1, height}));
    return stiffness_of(mesh, edges_of(mesh, {.face_diagonals = true, .space_diagonals = true}), modulus, {})
        .fitted_misfit;
  };
  CHECK(misfit(1 / 1.7) < 1e-7);
  CHECK(misfit(1.7) < 1e-7);
  // Non-negative least squares by Lawson and Hanson's method (NumPy): relative difference of the tensors.
  CHECK(misfit(0.5) == doctest::Approx(0.111).epsilon(0.005));
  CHECK(misfit(0.2) == doctest::Approx(0.507).epsilon(0.001));
  CHECK(misfit(2.0) == doctest::Approx(0.098).epsilon(0.005));
  const Mesh sheet = mesh_of(lattice({2, 2, 1}, {1, 0.5, 1}));
  CHECK(stiffness_of(sheet, edges_of(sheet, {.face_diagonals = true}), modulus, {.thickness = 1.0}).fitted_misfit ==
        doctest::Approx(0.107).epsilon(0.005));
}

TEST_CASE("the misfit of tetrahedra and triangles is not that of fitted cells") {
  const Mesh tetrahedron = single(CellType::tetrahedron, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  const NetStiffness net = stiffness_of(tetrahedron, edges_of(tetrahedron), modulus, {});
  CHECK(net.misfit > 0.1);
  CHECK(net.fitted_misfit == 0.0);
}

TEST_CASE("springs that are not among the edges are found missing") {
  const Mesh mesh = mesh_of(lattice({3, 2, 2}, Vector3::Ones()));
  std::vector<Edge> edges = edges_of(mesh);
  const Edge missing = edges[7];
  edges.erase(edges.begin() + 7);
  std::string message;
  try {
    static_cast<void>(stiffness_of(mesh, edges, modulus, {}));
  } catch (const Error& error) {
    message = error.what();
  }
  CAPTURE(message);
  CHECK(message.starts_with("the edge from point "));
  for (const std::uint32_t point : {missing.first, missing.second}) {
    CHECK(message.find("point " + std::to_string(point) + " ") != std::string::npos);
  }
}

TEST_CASE("cells without diagonals are known to lack shear") {
  const Mesh mesh = mesh_of(lattice({3, 3, 3}, Vector3::Ones()));
  CHECK(stiffness_of(mesh, edges_of(mesh), modulus, {}).lacks_shear);
}

TEST_CASE("what cannot be a material is refused") {
  const auto refusal = [](const Mesh& mesh, double e, const Section& section) -> std::string {
    try {
      static_cast<void>(stiffness_of(mesh, edges_of(mesh), e, section));
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  };
  const Mesh flat = single(CellType::tetrahedron, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
  CHECK(refusal(flat, 1.0, {}).find("tetrahedron 0 at [0, 0, 0] has no volume") != std::string::npos);
  CHECK(refusal(flat, -1.0, {}).find("Young's modulus") != std::string::npos);
  // A quadrilateral with two corners at one place is a triangle, and has an area.
  const Mesh thin = single(CellType::quadrilateral, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 0}});
  CHECK(refusal(thin, 1.0, {.thickness = 1.0})
            .starts_with("quadrilateral 0: its corners 3 and 4, points 2 and 3, are both at [1, 1, 0]"));
  const Mesh sheet = single(CellType::triangle, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  CHECK(refusal(sheet, 1.0, {}).find("thickness") != std::string::npos);
}
