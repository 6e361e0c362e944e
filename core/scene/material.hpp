// Masses and laws of a body from density and Young's modulus.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <springnet/mesh.hpp>
#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

#include "scene/files.hpp"
#include "scene/reader.hpp"

namespace springnet::scene {

// Cells of the body, computed when needed.
using Cells = std::function<const Mesh&()>;

// Whether its mesh is a cloud of points, which have no volume.
[[nodiscard]] bool is_cloud(const Table& body);

// Masses of the points by body.density or body.mass; empty without them. A cloud's are equal.
[[nodiscard]] std::vector<double> read_masses(const Table& body, const Cells& cells);

// Materials of springs along `edges`: one for all from body.spring and body.viscosity, none if both are missing, or one
// each from body.material. `edges` are sorted and unique. Notes name the body.
[[nodiscard]] std::vector<MaterialIndex> read_materials(const Table& body, const Cells& cells,
                                                        const std::function<const std::vector<Edge>&()>& edges,
                                                        const PluginHost& plugins, const Files& files, Network& network,
                                                        std::vector<std::string>& notes);

// What a body is made of if its material has a law over several scalars: elements in its cells in place of springs.
struct ElementMaterial {
  Invariant shape;  // tetrahedron, or triangle
  MaterialIndex material;
  std::optional<MaterialIndex> bending;  // of hinges between triangles
  Vector3 direction = Vector3::Zero();
};
// None if the body has no such material.
[[nodiscard]] std::optional<ElementMaterial> read_element_material(const Table& body, const PluginHost& plugins,
                                                                   const Files& files, Network& network);
// Adds them to the body added last, which has the cells of the mesh.
void add_body_elements(const Table& body, const ElementMaterial& material, const Mesh& mesh, const PluginHost& plugins,
                       Scene& scene);

}  // namespace springnet::scene
