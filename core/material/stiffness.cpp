#include <algorithm>

#include "material/bearing.hpp"
#include "material/sharing.hpp"
#include "material/tensor_fit.hpp"

namespace springnet {
namespace {

using Places = std::span<const std::array<std::uint8_t, 2>>;

std::size_t find_edge(std::span<const Edge> edges, std::uint32_t a, std::uint32_t b) {
  const Edge edge = std::minmax(a, b);
  const auto found = std::lower_bound(edges.begin(), edges.end(), edge);
  return found != edges.end() && *found == edge ? static_cast<std::size_t>(found - edges.begin()) : edges.size();
}

// The springs of one cell: those of its edges and diagonals that are among the springs.
struct CellSprings {
  CellType type = CellType::vertex;
  std::vector<std::size_t> edges;
  std::vector<Vector3> vectors;  // m, from end to end

  // Throws Error(input) if an edge is missing: without it the springs do not determine the cell's shape.
  void collect(const Mesh& mesh, std::size_t index, std::span<const Edge> all) {
    edges.clear();
    vectors.clear();
    const auto cell = mesh.cell(index);
    type = mesh.types[index];
    for (const Places& places : {edge_places(type), face_diagonal_places(type), space_diagonal_places(type)}) {
      for (const auto& [first, second] : places) {
        const std::size_t edge = find_edge(all, cell[first], cell[second]);
        if (edge < all.size()) {
          edges.push_back(edge);
          vectors.emplace_back(mesh.points[cell[second]] - mesh.points[cell[first]]);
        } else if (places.data() == edge_places(type).data()) {
          material::fail(
              fmt::format("the edge from point {} to point {} of {} {} is missing: give all that edges_of finds, in "
                          "ascending order",
                          cell[first], cell[second], name_of(type), index));
        }
      }
    }
  }
};

// Two coincident corners leave a spring without a direction, even if the cell has a volume.
void check_corners(const Mesh& mesh, std::size_t index, const CellSprings& springs) {
  const bool fine = std::none_of(springs.vectors.begin(), springs.vectors.end(),
                                 [](const Vector3& vector) { return vector.squaredNorm() == 0.0; });
  if (fine) return;
  const auto cell = mesh.cell(index);
  for (std::size_t i = 0; i < cell.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (mesh.points[cell[i]] != mesh.points[cell[j]]) continue;
      material::fail(fmt::format(
          "{} {}: its corners {} and {}, points {} and {}, are both at {}, so that the spring between them gets no "
          "stiffness: merge the points or repair the cell",
          name_of(springs.type), index, j + 1, i + 1, cell[j], cell[i], meshes::text(mesh.points[cell[i]])));
    }
  }
}

bool is_simplex(CellType type) {
  return type == CellType::line || type == CellType::triangle || type == CellType::tetrahedron;
}

// A cell's contribution to its springs, cached for further cells of the same shape: cells of a lattice are equal up to
// rounding and so get bitwise equal springs.
struct CellShare {
  CellType type = CellType::vertex;
  std::vector<Vector3> vectors;   // m
  std::vector<double> stiffness;  // N/m
  double volume = 0.0;            // m^3
  double squared_misfit = 0.0;

  [[nodiscard]] bool fits(const CellSprings& springs) const {
    constexpr double rounding = 1e-10;  // relative; far above that of coordinates, far below a relevant difference
    return springs.type == type && springs.vectors.size() == vectors.size() &&
           std::equal(vectors.begin(), vectors.end(), springs.vectors.begin(), [](const Vector3& x, const Vector3& y) {
             return (x - y).squaredNorm() <= rounding * rounding * x.squaredNorm();
           });
  }
};

material::Shares shares_for(CellType type, std::span<const Vector3> directions, material::Sharing sharing) {
  if (sharing == material::Sharing::fitted || (sharing == material::Sharing::best && !is_simplex(type))) {
    return material::shares_of(directions);
  }
  const auto count = static_cast<Eigen::Index>(directions.size());
  return material::Shares::Constant(count, 1.0 / static_cast<double>(count));
}

CellShare share_of(const CellSprings& springs, int dimension, double youngs_modulus, double volume,
                   material::Sharing sharing) {
  CellShare share{springs.type, springs.vectors, {}, volume};
  if (springs.vectors.empty()) return share;
  std::vector<Vector3> directions;
  for (const Vector3& vector : springs.vectors) directions.emplace_back(vector.normalized());
  const material::Shares shares = shares_for(springs.type, directions, sharing);
  // The trace C_iijj is 15 lambda with lambda = 2 E / 5 in a solid, 8 lambda with lambda = 3 E / 8 in a sheet (plane
  // stress), E along a line: 6 E, 3 E, E, which happens to be E times the number of edges of a simplex.
  const double trace = (dimension == 3 ? 6.0 : dimension == 2 ? 3.0 : 1.0) * youngs_modulus * volume;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    share.stiffness.push_back(trace * shares[static_cast<Eigen::Index>(i)] / springs.vectors[i].squaredNorm());
  }
  if (dimension > 1) share.squared_misfit = material::squared_misfit(directions, shares, dimension);
  return share;
}

bool lacks_shear(CellType type, std::size_t spring_count) {
  return (type == CellType::quadrilateral || type == CellType::hexahedron) && spring_count == edge_places(type).size();
}

}  // namespace

double poisson_ratio_of_net(int dimension) noexcept { return dimension == 3 ? 1.0 / 4.0 : 1.0 / 3.0; }

NetStiffness stiffness_of(const Mesh& mesh, std::span<const Edge> edges, double youngs_modulus,
                          const Section& section) {
  return material::stiffness_of(mesh, edges, youngs_modulus, section, material::Sharing::best);
}

NetStiffness material::stiffness_of(const Mesh& mesh, std::span<const Edge> edges, double youngs_modulus,
                                    const Section& section, Sharing sharing) {
  if (!(std::isfinite(youngs_modulus) && youngs_modulus > 0)) {
    fail(fmt::format("Young's modulus must be a finite number above 0 Pa, is {}", youngs_modulus));
  }
  NetStiffness result;
  result.stiffness.assign(edges.size(), 0.0);
  struct Mean {
    double sum = 0.0, volume = 0.0;
    void add(const CellShare& share) {
      sum += share.volume * share.squared_misfit;
      volume += share.volume;
    }
    [[nodiscard]] double root() const { return volume > 0 ? std::sqrt(sum / volume) : 0.0; }
  } all, fitted;
  CellSprings springs;
  CellShare share;
  for (const std::size_t c : bearing_cells(mesh)) {
    const int dimension = dimension_of(mesh.types[c]);
    springs.collect(mesh, c, edges);
    if (!share.fits(springs)) {
      check_corners(mesh, c, springs);
      const double volume = volume_of(mesh, c, section);
      if (!(volume > 0)) {
        fail(
            fmt::format("{} {} at {} has no volume, so that its springs get no stiffness: repair the mesh, or give a "
                        "stiffness instead",
                        name_of(springs.type), c, meshes::text(mesh.points[mesh.cell(c)[0]])));
      }
      share = share_of(springs, dimension, youngs_modulus, volume, sharing);
    }
    if (springs.edges.empty()) continue;
    for (std::size_t i = 0; i < springs.edges.size(); ++i) result.stiffness[springs.edges[i]] += share.stiffness[i];
    result.dimension = std::max(result.dimension, dimension);
    result.lacks_shear = result.lacks_shear || lacks_shear(springs.type, springs.edges.size());
    if (dimension < 2) continue;
    all.add(share);
    if (!is_simplex(springs.type)) fitted.add(share);
  }
  result.misfit = all.root();
  result.fitted_misfit = fitted.root();
  return result;
}

}  // namespace springnet
