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

// Masses of the points by body.density; empty without it.
[[nodiscard]] std::vector<double> read_masses(const Table& body, const Cells& cells);

// Materials of springs along `edges`: one for all from body.spring and body.viscosity, none if both are missing, or one
// each from body.material. `edges` are sorted and unique. Notes name the body.
[[nodiscard]] std::vector<MaterialIndex> read_materials(const Table& body, const Cells& cells,
                                                        const std::function<const std::vector<Edge>&()>& edges,
                                                        const PluginHost& plugins, const Files& files, Network& network,
                                                        std::vector<std::string>& notes);

}  // namespace springnet::scene
