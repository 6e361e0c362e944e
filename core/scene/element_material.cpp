// Bodies of elements: [body.material] with a law over several scalars, such as `solid` or `membrane`.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <springnet/material.hpp>
#include <springnet/mesh.hpp>

#include "scene/component.hpp"
#include "scene/material.hpp"

namespace springnet::scene {
namespace {

// The law named by body.material.law, if it reads several scalars. Not of a formula.
std::shared_ptr<const Component> element_law(const Table& material, const PluginHost& plugins) {
  const auto law = material.find("law");
  if (!law || (!law->is_text() && is_formula_of(law->open_table("body.material.law")))) return nullptr;
  const std::string id = law->is_text() ? law->text() : law->open_table("body.material.law").need("type").text();
  std::shared_ptr<const Component> component;
  try {
    component = plugins.require(ComponentKind::spring_function, id);
  } catch (const Error&) {
    return nullptr;  // whoever reads it as a law of springs says what is wrong
  }
  return component->law().invariant == SPRINGNET_SEVERAL ? component : nullptr;
}

bool has_parameter(const Component& law, std::string_view name) {
  const springnet_component& description = *law.description;
  return std::any_of(description.parameters, description.parameters + description.parameter_count,
                     [&](const springnet_parameter* each) { return name == each->name; });
}

struct MaterialReader {
  const Table& body;
  const Table& table;
  const PluginHost& plugins;
  const Files& files;

  double number(const Table& of, const char* key, const char* unit) const { return of.need(key).number_above_0(unit); }

  // The material's constants that the law has.
  [[nodiscard]] ParameterValues constants(const Component& law) const {
    ParameterValues values;
    for (const MaterialParameter& each : parameters())
      if (has_parameter(law, each.name)) values.emplace(each.name, each.value());
    refuse_others(law);
    return values;
  }
  [[nodiscard]] std::vector<MaterialParameter> parameters() const {
    return {{"youngs_modulus", "Pa", [this] { return number(table, "youngs_modulus", "Pa"); }},
            {"poisson_ratio", "1", [this] { return poisson_ratio(); }},
            {"thickness", "m", [this] { return number(body, "thickness", "m"); }}};
  }
  void refuse_others(const Component& law) const {
    for (const char* key : {"youngs_modulus", "poisson_ratio"})
      if (!has_parameter(law, key) && table.has(key) && !table.has("damping_time"))
        table.need(key).fail(fmt::format("has no meaning for '{}', which has no such parameter; remove it", law.id()));
  }
  // If the law is a formula over several scalars.
  [[nodiscard]] std::optional<LawUse> formula() const {
    const auto value = table.find("law");
    if (!value || !value->is_table()) return std::nullopt;
    const Table own = value->open_table("body.material.law");
    const std::optional<Invariant> shape = is_formula_of(own) ? shape_of_formula(own) : std::nullopt;
    if (!shape) return std::nullopt;
    LawUse use = read_formula(own, ComponentKind::spring_function, files, shape, parameters());
    refuse_others(*use.component);
    return use;
  }
  [[nodiscard]] double poisson_ratio() const {
    const Value value = table.need("poisson_ratio");
    const double ratio = value.number();
    if (!(ratio > -1.0 && ratio < 0.5)) value.fail(fmt::format("must lie between -1 and 0.5, is {}", ratio));
    return ratio;
  }
  [[nodiscard]] LawUse law(const Component& component) const {
    const Value value = table.need("law");
    const ParameterValues supplied = constants(component);
    if (value.is_text()) return read_component_name(value, ComponentKind::spring_function, plugins, supplied);
    return read_component(value.open_table("body.material.law"), "type", ComponentKind::spring_function, plugins, files,
                          supplied);
  }
  // Kelvin and Voigt's viscosity: the stresses of Hooke's law for the rate of strain, times the damping time.
  [[nodiscard]] std::optional<LawUse> viscosity(Invariant shape) const {
    const auto own = body.find("viscosity");
    const auto time = table.find("damping_time");
    const double damping_time = time ? time->number_from_0("s") : 0.0;
    if (own && time)
      time->fail("cannot be combined with 'viscosity', which says what damps the body; remove one of them");
    if (own) return read_material(body, plugins, files, shape).viscosity;
    if (!(damping_time > 0.0)) return std::nullopt;
    const double modulus = number(table, "youngs_modulus", "Pa"), nu = poisson_ratio();
    const double shear = modulus / (2.0 * (1.0 + nu));
    if (!std::isfinite(damping_time * modulus / (1.0 - 2.0 * nu)))
      time->fail(
          fmt::format("is {:g} s, too long for a modulus of {:g} Pa: their product overflows", damping_time, modulus));
    if (shape == Invariant::tetrahedron) {
      const double bulk = modulus / (3.0 * (1.0 - 2.0 * nu));
      return LawUse{
          "viscous_solid", {{"shear_viscosity", damping_time * shear}, {"bulk_viscosity", damping_time * bulk}}, {}};
    }
    const double thickness = number(body, "thickness", "m"), of_area = modulus * nu / (1.0 - nu * nu) + shear;
    return LawUse{
        "viscous_membrane",
        {{"shear_viscosity", damping_time * thickness * shear}, {"area_viscosity", damping_time * thickness * of_area}},
        {}};
  }
};

}  // namespace

std::optional<ElementMaterial> read_element_material(const Table& body, const PluginHost& plugins, const Files& files,
                                                     Network& network) {
  const auto value = body.find("material");
  if (!value) return std::nullopt;
  const Table table = value->table("body.material");
  const MaterialReader reader{body, table, plugins, files};
  const std::optional<LawUse> formula = reader.formula();
  const std::shared_ptr<const Component> component = formula ? formula->component : element_law(table, plugins);
  if (component == nullptr) {
    for (const char* key : {"direction", "bending"})
      if (const auto own = table.find(key))
        own->fail("has no meaning for a material of springs; set 'law' to one for triangles or tetrahedra");
    return std::nullopt;
  }
  const Value law = table.need("law");
  const springnet_law& description = component->law();
  ElementMaterial result{Invariant::tetrahedron, 0, std::nullopt};
  if (description.shape == SPRINGNET_TRIANGLE) result.shape = Invariant::triangle;
  if (description.shape != SPRINGNET_TRIANGLE && description.shape != SPRINGNET_TETRAHEDRON)
    law.fail(fmt::format("'{}' is for neither triangles nor tetrahedra; give it elements of its own with [[element]]",
                         component->id()));
  if (const auto spring = body.find("spring"))
    spring->fail("cannot be combined with 'material', which says what the body is made of; remove one");
  if (const auto scale = body.find("rest_length_scale"))
    scale->fail("has no meaning for a body of elements; use an [[element]] with reference_scale");
  const auto direction = table.find("direction");
  if (direction) {
    result.direction = direction->vector();
    if (description.reads_direction == 0)
      direction->fail(
          fmt::format("has no meaning for '{}', which is the same in all directions; remove it", component->id()));
    if (result.direction == Vector3::Zero()) direction->fail("is 0; give one of any length");
  } else if (description.reads_direction != 0) {
    table.fail(fmt::format("has no 'direction', which '{}' reads; add direction = [x, y, z]", component->id()));
  }
  result.material = network.add_material({formula ? *formula : reader.law(*component), reader.viscosity(result.shape)});
  const auto bending = table.find("bending");
  if (bending && bending->boolean()) {
    if (result.shape != Invariant::triangle) bending->fail("has no meaning for solids; remove it");
    const auto shell = plugins.require(ComponentKind::spring_function, "shell");
    result.bending = network.add_material({LawUse{"shell", reader.constants(*shell), {}}, std::nullopt});
  }
  return result;
}

void add_body_elements(const Table& body, const ElementMaterial& material, const Mesh& mesh, const PluginHost& plugins,
                       Scene& scene) {
  Network& network = scene.network;
  const Body& added = network.bodies().back();
  const NodeIndex first = added.first_node;
  const auto begin = static_cast<ElementIndex>(network.elements().size());
  const Value place = body.need("material");
  const ElementCheck check(network.materials()[material.material], plugins);
  const auto add = [&](Invariant shape, std::vector<NodeIndex> nodes, MaterialIndex index, const Vector3& direction) {
    const auto number = static_cast<ElementIndex>(network.elements().size());
    place.at_this_place([&] { network.add_element(shape, std::move(nodes), index, {}, direction); });
    if (index == material.material) check(place, network, number);
  };
  if (material.shape == Invariant::tetrahedron) {
    for (std::size_t cell = 0; cell < mesh.cell_count(); ++cell)
      for (const auto& nodes : conforming_tetrahedra_of(mesh, cell))
        add(Invariant::tetrahedron, {first + nodes[0], first + nodes[1], first + nodes[2], first + nodes[3]},
            material.material, material.direction);
    if (network.elements().size() == begin)
      place.fail(
          "is for tetrahedra, and the mesh of the body has no solid cell; use a law for triangles, or a mesh with "
          "solid cells");
  } else {
    const std::vector<std::size_t> bearing = bearing_cells(mesh);
    if (std::any_of(bearing.begin(), bearing.end(),
                    [&](std::size_t cell) { return dimension_of(mesh.types[cell]) == 3; }))
      place.fail("is for triangles, and the mesh of the body has solid cells; use a law for tetrahedra");
    std::vector<Face> faces(network.faces().begin() + static_cast<std::ptrdiff_t>(added.first_face),
                            network.faces().begin() + static_cast<std::ptrdiff_t>(added.first_face + added.face_count));
    for (const Face& face : faces)
      add(Invariant::triangle, {face[0], face[1], face[2]}, material.material, material.direction);
    if (network.elements().size() == begin)
      place.fail("is for triangles, and the mesh of the body has none; use a mesh with triangles or quadrilaterals");
    if (material.bending)
      for (const auto& hinge : hinges_of(faces))
        add(Invariant::hinge, {hinge.begin(), hinge.end()}, *material.bending, Vector3::Zero());
  }
  scene.elements.push_back({body.need("name").text(), begin,
                            static_cast<ElementIndex>(network.elements().size()) - begin, ElementSet::Of::body});
}

}  // namespace springnet::scene
