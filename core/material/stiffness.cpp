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

  void collect(const Mesh& mesh, std::size_t index, std::span<const Edge> all) {
    edges.clear();
    vectors.clear();
    const auto cell = mesh.cell(index);
    type = mesh.types[index];
    for (const Places& places : {edge_places(type), face_diagonal_places(type), space_diagonal_places(type)}) {
      for (const auto& [first, second] : places) {
        const std::size_t edge = find_edge(all, cell[first], cell[second]);
        if (edge == all.size()) continue;
        edges.push_back(edge);
        vectors.emplace_back(mesh.points[cell[second]] - mesh.points[cell[first]]);
      }
    }
  }
};

// What a cell gives to its springs, kept for the next cells of its shape: the cells of a lattice are alike but for
// rounding, and so get springs that are alike to the bit.
struct CellShare {
  CellType type = CellType::vertex;
  std::vector<Vector3> vectors;   // m
  std::vector<double> stiffness;  // N/m
  double volume = 0.0;            // m^3
  double squared_misfit = 0.0;

  [[nodiscard]] bool fits(const CellSprings& springs) const {
    constexpr double rounding = 1e-10;  // of a length; far above that of coordinates, far below what matters
    return springs.type == type && springs.vectors.size() == vectors.size() &&
           std::equal(vectors.begin(), vectors.end(), springs.vectors.begin(), [](const Vector3& x, const Vector3& y) {
             return (x - y).squaredNorm() <= rounding * rounding * x.squaredNorm();
           });
  }
};

material::Shares shares_for(CellType type, std::span<const Vector3> directions, material::Sharing sharing) {
  const bool simplex = type == CellType::line || type == CellType::triangle || type == CellType::tetrahedron;
  if (sharing == material::Sharing::fitted || (sharing == material::Sharing::best && !simplex)) {
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
  // stress), E along a line: 6 E, 3 E, E, by chance the number of edges of a simplex times E.
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
  double misfit = 0.0, misfit_volume = 0.0;
  CellSprings springs;
  CellShare share;
  for (const std::size_t c : bearing_cells(mesh)) {
    const int dimension = dimension_of(mesh.types[c]);
    springs.collect(mesh, c, edges);
    if (!share.fits(springs)) {
      const double volume = volume_of(mesh, c, section);
      if (!(volume > 0)) {
        fail(
            fmt::format("{} {} at {} has no volume, so that no stiffness follows for its springs: mend the mesh, or "
                        "give a stiffness instead",
                        name_of(springs.type), c, text(mesh.points[mesh.cell(c)[0]])));
      }
      share = share_of(springs, dimension, youngs_modulus, volume, sharing);
    }
    if (springs.edges.empty()) continue;
    for (std::size_t i = 0; i < springs.edges.size(); ++i) result.stiffness[springs.edges[i]] += share.stiffness[i];
    result.dimension = std::max(result.dimension, dimension);
    result.lacks_shear = result.lacks_shear || lacks_shear(springs.type, springs.edges.size());
    if (dimension < 2) continue;
    misfit += share.volume * share.squared_misfit;
    misfit_volume += share.volume;
  }
  if (misfit_volume > 0) result.misfit = std::sqrt(misfit / misfit_volume);
  return result;
}

}  // namespace springnet
