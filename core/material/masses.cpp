#include "material/bearing.hpp"

namespace springnet {

std::vector<double> masses_of(const Mesh& mesh, double density, const Section& section) {
  if (!(std::isfinite(density) && density > 0)) {
    material::fail(fmt::format("a density must be a finite number above 0 kg/m^3, is {}", density));
  }
  std::vector<double> masses(mesh.points.size(), 0.0);
  for (const std::size_t c : bearing_cells(mesh)) {
    const auto cell = mesh.cell(c);
    const double share = density * material::volume_of(mesh, c, section) / static_cast<double>(cell.size());
    for (const std::uint32_t point : cell) masses[point] += share;
  }
  for (std::size_t k = 0; k < masses.size(); ++k) {
    if (masses[k] > 0) continue;
    material::fail(
        fmt::format("point {} at {} gets no mass from the density: no cell with volume, area or length contains it; "
                    "remove it, or give masses instead",
                    k, meshes::text(mesh.points[k])));
  }
  return masses;
}

}  // namespace springnet
