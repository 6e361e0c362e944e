// Forces and derivatives of tetrahedra and triangles beside those of the springs on their edges: rows of the benchmark
// program.
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include <springnet/network.hpp>
#include <springnet/plugin_host.hpp>

// internal: there is no public way to evaluate without a step
#include "layers/linear/linearisation.hpp"
#include "simulation/sweep.hpp"

namespace {

using springnet::LawUse;
using springnet::Vector3;

std::shared_ptr<const springnet::PluginHost> plugins() {
  static const auto host = std::make_shared<const springnet::PluginHost>(springnet::PluginHost::with_default_search());
  return host;
}

// A block of cubes in six tetrahedra each, or a sheet of squares in two triangles each, with nodes out of place and in
// motion: of elements with a law and a viscosity, or of springs on the edges.
springnet::Network simplices(int cells, bool solid, const springnet::Material& law, bool springs) {
  springnet::Network network;
  const auto material = network.add_material(law);
  const int side = cells + 1, depth = solid ? side : 1;
  std::uint64_t random = 1;
  const auto shift = [&random] {
    random = random * 6364136223846793005U + 1442695040888963407U;
    return 0.2 * (static_cast<double>(random >> 11) * 0x1p-53 - 0.5);
  };
  const auto at = [side](int i, int j, int k) { return static_cast<springnet::NodeIndex>(i + side * (j + side * k)); };
  std::vector<Vector3> rest;
  for (int k = 0; k < depth; ++k)
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) {
        rest.emplace_back(i, j, k);
        springnet::Node node;
        node.position = rest.back() + Vector3(shift(), shift(), shift());
        node.velocity = {shift(), shift(), shift()};
        network.add_node(node);
      }
  std::set<std::pair<springnet::NodeIndex, springnet::NodeIndex>> edges;
  const auto add = [&](std::vector<springnet::NodeIndex> nodes) {
    std::vector<Vector3> own;
    for (const auto node : nodes) own.push_back(rest[node]);
    if (nodes.size() == 4 && (own[1] - own[0]).cross(own[2] - own[0]).dot(own[3] - own[0]) < 0.0) {
      std::swap(nodes[2], nodes[3]);
      std::swap(own[2], own[3]);
    }
    if (!springs) {
      network.add_element(solid ? springnet::Invariant::tetrahedron : springnet::Invariant::triangle, nodes, material,
                          own);
      return;
    }
    for (const auto a : nodes)
      for (const auto b : nodes)
        if (a < b && edges.emplace(a, b).second) network.add_spring(a, b, material, (rest[a] - rest[b]).norm());
  };
  for (int k = 0; k < (solid ? cells : 1); ++k)
    for (int j = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i) {
        if (!solid) {
          add({at(i, j, 0), at(i + 1, j, 0), at(i + 1, j + 1, 0)});
          add({at(i, j, 0), at(i + 1, j + 1, 0), at(i, j + 1, 0)});
          continue;
        }
        std::array<std::size_t, 3> axes{0, 1, 2};
        do {
          std::array<int, 3> place{i, j, k};
          std::vector<springnet::NodeIndex> nodes{at(i, j, k)};
          for (const std::size_t axis : axes) {
            ++place[axis];
            nodes.push_back(at(place[0], place[1], place[2]));
          }
          add(nodes);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  return network;
}

// Net forces of such a net, or all its derivatives; items_per_second counts elements or springs, and an
// element compares with its six or three edges as springs.
void simplices_of(benchmark::State& state, bool solid, const springnet::Material& law, bool springs, bool tangent) {
  const springnet::Network network = simplices(solid ? 15 : 80, solid, law, springs);
  springnet::Model model(network, *plugins(), {.threads = 1});
  springnet::Sweep sweep(model);
  springnet_evaluation request{};
  request.struct_size = sizeof request;
  request.position = springnet::read_only(model.state.view.position);
  request.velocity = springnet::read_only(model.state.view.velocity);
  const springnet_state& at = model.state.view;
  const springnet::layers::NodeArrays nodes{at.position.x, at.position.y, at.position.z,
                                            at.velocity.x, at.velocity.y, at.velocity.z};
  const std::vector<double> mass(network.nodes().size(), 1.0);
  const springnet::layers::Evaluator evaluator(model.layout, mass, springnet::InstructionSet::best, 1);
  const std::vector<std::uint8_t> constrained(network.nodes().size(), 0);
  springnet::layers::Linearisation linearisation(model.layout, evaluator, constrained);
  springnet_message message{};
  for ([[maybe_unused]] auto iteration : state) {
    const springnet_status status = tangent ? linearisation.update(0.0, nodes, {}, message) : sweep.evaluate(request);
    if (status != SPRINGNET_OK) state.SkipWithError("a law failed");
  }
  const std::size_t items = springs ? network.springs().size() : network.elements().size();
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(items));
}
const springnet::Material damped_spring{LawUse{"linear", {{"stiffness", 1.0}}}, LawUse{"linear", {{"damping", 0.1}}}};
const springnet::Material plain_spring{LawUse{"linear", {{"stiffness", 1.0}}}, std::nullopt};
const LawUse solid_law{"solid", {{"youngs_modulus", 1.0}, {"poisson_ratio", 0.4}}};
const LawUse membrane_law{"membrane", {{"youngs_modulus", 1.0}, {"poisson_ratio", 0.4}, {"thickness", 0.1}}};
const springnet::Material damped_solid{solid_law, LawUse{"viscous_solid", {{"shear_viscosity", 0.1}}}};
const springnet::Material damped_membrane{membrane_law, LawUse{"viscous_membrane", {{"shear_viscosity", 0.1}}}};
#define SPRINGNET_SIMPLICES(name, solid, elements, springs)                                                     \
  BENCHMARK_CAPTURE(simplices_of, name##_forces, solid, elements, false, false)->Unit(benchmark::kMicrosecond); \
  BENCHMARK_CAPTURE(simplices_of, name##_forces_of_springs, solid, springs, true, false)                        \
      ->Unit(benchmark::kMicrosecond);                                                                          \
  BENCHMARK_CAPTURE(simplices_of, name##_tangent, solid, elements, false, true)->Unit(benchmark::kMicrosecond); \
  BENCHMARK_CAPTURE(simplices_of, name##_tangent_of_springs, solid, springs, true, true)->Unit(benchmark::kMicrosecond)
SPRINGNET_SIMPLICES(solid, true, (springnet::Material{solid_law, std::nullopt}), plain_spring);
SPRINGNET_SIMPLICES(damped_solid, true, damped_solid, damped_spring);
SPRINGNET_SIMPLICES(membrane, false, (springnet::Material{membrane_law, std::nullopt}), plain_spring);
SPRINGNET_SIMPLICES(damped_membrane, false, damped_membrane, damped_spring);
#undef SPRINGNET_SIMPLICES

}  // namespace
