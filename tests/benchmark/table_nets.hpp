// The nets of the table of steps (steps_table.cpp).
#pragma once

#include <filesystem>
#include <string>

#include <springnet/mesh.hpp>
#include <springnet/network.hpp>
#include <springnet/simulation.hpp>

namespace springnet::benchmark {

struct Case {
  Network network;
  SimulationOptions options{};  // one thread
  double duration = 0.0;        // s, of an example's scene
};

// Damped axial and space-diagonal springs between nodes_a_side^3 masses of 1 kg, 1 m apart; it hangs from its top.
// Steps of 0.02 s with `newton`. stiffness: N/m.
[[nodiscard]] Case hanging_lattice(std::uint32_t nodes_a_side, double stiffness);

// An example's scene as examples/NAME/NAME.toml has it.
[[nodiscard]] Case example(const std::string& name);
// The sheet with `newton` and steps of 0.01 s.
[[nodiscard]] Case sheet();

// A block of 0.125 m of soft tissue (10 kPa, 1000 kg/m^3, damping time 0.01 s) that is held at its base, under gravity;
// steps of 0.01 s with `newton`.
[[nodiscard]] Case tissue(const Mesh& mesh);
// Tetrahedra as irregular as those of a mesher, and as many: 13,824 points with 89,999 edges, numbered at random. Gmsh
// makes 13,869 and 90,688 for edges of 5 mm; a file of them would be the largest of the project.
[[nodiscard]] Mesh tissue_mesh(std::uint32_t points_a_side = 24);

}  // namespace springnet::benchmark
