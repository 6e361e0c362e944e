#include "scene/material.hpp"

#include <cmath>

#include <fmt/format.h>

#include <springnet/material.hpp>

#include "scene/component.hpp"

namespace springnet::scene {
namespace {

constexpr const char* stiffness = "stiffness";

Section read_section(const Table& body) {
  Section section;
  if (const auto thickness = body.find("thickness")) section.thickness = thickness->number_above_0("m");
  if (const auto area = body.find("cross_section")) section.cross_section = area->number_above_0("m^2");
  return section;
}

// The laws of a body's springs, without the stiffness, which differs between springs.
struct Springs {
  Material material;
  double damping_time = 0.0;  // s

  [[nodiscard]] Material of(double k) const {
    Material result = material;
    result.spring->parameters[stiffness] = k;
    if (damping_time > 0) result.viscosity->parameters["damping"] = damping_time * k;
    return result;
  }
};

Springs read_springs(const Table& body, const Table& table, const PluginHost& plugins, const Files& files) {
  Springs springs{read_material(body, plugins, files)};
  if (springs.material.spring) {
    body.find("spring")->fail("cannot be combined with 'material', which says what springs are made of; remove one");
  }
  const ParameterValues supplied{{stiffness, 1.0}};
  const auto law = table.find("law");
  if (!law) {
    springs.material.spring = LawUse{"linear", supplied};
  } else if (law->is_text()) {
    springs.material.spring = read_component_name(*law, ComponentKind::spring_function, plugins, supplied);
  } else if (const Table own = law->open_table("body.material.law"); is_formula_of(own)) {
    springs.material.spring = read_law(*law, "body.material.law", ComponentKind::spring_function, plugins, files, {},
                                       {{stiffness, "N/m", [] { return 1.0; }}});
    if (!springs.material.spring->parameters.contains(stiffness))
      law->fail(
          "does not read 'stiffness' (N/m), which the material gives to each spring; write it, as in "
          "formula = \"stiffness*e\"");
  } else {
    springs.material.spring = read_component(own, "type", ComponentKind::spring_function, plugins, files, supplied);
  }
  if (const auto time = table.find("damping_time")) {
    springs.damping_time = time->number_from_0("s");
    if (springs.material.viscosity) {
      time->fail("cannot be combined with 'viscosity', which says what damps the springs; remove one of them");
    }
    if (springs.damping_time > 0) springs.material.viscosity = LawUse{"linear", {}};
  }
  return springs;
}

// Relative deviation of the cells' elasticity from isotropy above which a note reports it.
constexpr double noteworthy_misfit = 0.05;

// Notes the actual Poisson ratio if it differs from the requested one.
void check_poisson_ratio(const Table& table, const std::string& body, const NetStiffness& net,
                         std::vector<std::string>& notes) {
  const auto requested = table.find("poisson_ratio");
  const double ratio = requested ? requested->number() : 0.0;
  if (requested && !(ratio > -1.0 && ratio < 0.5))
    requested->fail(fmt::format("must lie between -1 and 0.5, is {}", ratio));
  if (!requested || net.dimension < 2) return;  // lines have none
  const bool solid = net.dimension == 3, is_irregular = net.misfit > noteworthy_misfit;
  const double of_net = poisson_ratio_of_net(net.dimension);
  constexpr double tolerance = 0.005;  // 0.33 means 1/3
  if (std::abs(ratio - of_net) <= tolerance) return;
  notes.push_back(
      fmt::format("Body '{}': {} of springs has a Poisson ratio of {}{}, not {:g} as requested{}. {}.", body,
                  solid ? "a solid" : "a sheet", is_irregular ? "about " : "", solid ? "1/4" : "1/3", ratio,
                  is_irregular ? "; material.md of the documentation has the ratios of irregular meshes" : "",
                  solid ? "An [[element]] on volumes adds resistance to changes of volume"
                        : "An [[element]] on areas adds resistance to changes of area"));
}

// By the sizes of cells; equal where these are points or lines without a cross section, and in a cloud.
std::vector<double> masses_of_whole(const Mesh& mesh, double whole, const Section& section, bool is_cloud) {
  const bool has_size = !is_cloud && std::any_of(mesh.types.begin(), mesh.types.end(), [&](CellType type) {
    return dimension_of(type) > 1 || (dimension_of(type) == 1 && section.cross_section);
  });
  if (!has_size) return std::vector<double>(mesh.points.size(), whole / static_cast<double>(mesh.points.size()));
  // Only the shares count.
  std::vector<double> masses = masses_of(mesh, 1.0, {section.thickness.value_or(1.0), section.cross_section});
  const double sum = std::accumulate(masses.begin(), masses.end(), 0.0);
  for (double& each : masses) each *= whole / sum;
  return masses;
}

}  // namespace

bool is_cloud(const Table& body) {
  const auto mesh = body.find("mesh");
  return mesh && mesh->table("body.mesh").has("points");
}

std::vector<double> read_masses(const Table& body, const Cells& cells) {
  if (const auto mass = body.find("mass")) {
    if (body.has("density"))
      mass->fail("cannot be combined with 'density', which gives the masses; remove one of them");
    const double whole = mass->number_above_0("kg");
    return mass->at_this_place([&] { return masses_of_whole(cells(), whole, read_section(body), is_cloud(body)); });
  }
  const auto density = body.find("density");
  if (!density) return {};
  const double value = density->number_above_0("kg/m^3");
  return density->at_this_place([&] { return masses_of(cells(), value, read_section(body)); });
}

std::vector<MaterialIndex> read_materials(const Table& body, const Cells& cells,
                                          const std::function<const std::vector<Edge>&()>& edges,
                                          const PluginHost& plugins, const Files& files, Network& network,
                                          std::vector<std::string>& notes) {
  const auto value = body.find("material");
  if (!value) {
    for (const char* key : {"thickness", "cross_section"}) {
      if (body.has(key) && !body.has("density")) {
        body.find(key)->fail("has no meaning without 'density' or 'material'; remove it, or add one of them");
      }
      if (body.has(key)) static_cast<void>(body.find(key)->number_above_0(""));
    }
    const Material material = read_material(body, plugins, files);
    if (!material.spring && !material.viscosity) return {};
    return {network.add_material(material)};
  }
  const Table table = value->table("body.material");
  const Springs springs = read_springs(body, table, plugins, files);
  const double modulus = table.need("youngs_modulus").number_above_0("Pa");
  const std::string name = body.need("name").text();
  const NetStiffness net =
      value->at_this_place([&] { return stiffness_of(cells(), edges(), modulus, read_section(body)); });
  check_poisson_ratio(table, name, net, notes);
  if (net.lacks_shear) {
    notes.push_back(
        fmt::format("Body '{}': quadrilaterals or hexahedra without diagonals resist no shear; add diagonals to its "
                    "mesh, best \"all\".",
                    name));
  } else if (net.fitted_misfit > noteworthy_misfit) {
    notes.push_back(
        fmt::format("Body '{}': springs cannot give its cells that are not tetrahedra or triangles the elasticity of "
                    "the material: it is off by {:.2g} % (root mean square), mostly too soft in shear. Make cells less "
                    "flat, long or skewed (hexahedra and quadrilaterals: sides within 1 : 1.7) with diagonals = "
                    "\"all\"; material.md of the documentation has examples.",
                    name, 100.0 * net.fitted_misfit));
  }
  std::vector<MaterialIndex> materials;
  materials.reserve(net.stiffness.size());
  for (const double k : net.stiffness) {
    value->at_this_place([&] { materials.push_back(network.add_material(springs.of(k))); });
  }
  return materials;
}

}  // namespace springnet::scene
