#include "sample_scene.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "component_text.hpp"

namespace springnet::tool {

namespace {

constexpr const char* simulation_part = R"([simulation]
duration  = 2
time_step = 0.01
{}
[output]
quantities = ["position", "velocity", "force"]
)";

// Node 0 is held, node 2 is pulled and pushed, node 1 is free. Placeholders: neuron, spring, viscosity.
constexpr const char* row_of_nodes = R"(
[[body]]
name    = "row"
nodes   = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]
springs = [[0, 1], [1, 2]]
{}
{}
{}
[[fix]]
select = {{ body = "row", nodes = [0] }}

[[move]]  # time and displacement
select = {{ body = "row", nodes = [2] }}
table  = [[0, 0, 0, 0], [0.5, 0.2, 0, 0], [1.5, -0.2, 0, 0], [2, 0, 0, 0]]
)";

// A body that hangs from its left end. Placeholders: the lattice, its diagonals, invariant, law, further keys of the
// element, distance of the fixed nodes.
constexpr const char* body_of_elements = R"(
[gravity]
acceleration = [0, 0, -0.05]

[[body]]
name   = "net"
mesh   = {{ {} }}
neuron = {{ type = "point_mass", mass = 0.01 }}
spring = {{ type = "linear", stiffness = 1.0 }}

[[element]]
invariant = "{}"
select    = {{ body = "net" }}
{}
{}
[[fix]]
select = {{ body = "net", box = {{ min = [-1, -1, -1], max = [0.01, 2, 2] }} }}
)";

constexpr const char* sheet = "lattice = [4, 4, 1], spacing = 0.25";
constexpr const char* block = "lattice = [4, 3, 3], spacing = 0.25";

// For laws that springs cannot have: the invariant of an [[element]]; empty: springs can have it.
std::string invariant_of_elements(const springnet_law& law) {
  switch (law.invariant) {
    case SPRINGNET_ANGLE:
      return "angle";
    case SPRINGNET_AREA:
      return "area";
    case SPRINGNET_VOLUME:
      return "volume";
    case SPRINGNET_ENCLOSED_VOLUME:
      return "enclosed_volume";
    case SPRINGNET_SEVERAL:
      switch (law.shape) {
        case SPRINGNET_CHAIN:
          return "chain";
        case SPRINGNET_TRIANGLE:
          return "triangle";
        case SPRINGNET_HINGE:
          return "hinge";
        default:
          return "tetrahedron";
      }
    default:
      return {};
  }
}

// A chain for angles: its springs meet at 90 degrees.
constexpr const char* bent_chain = R"(
[gravity]
acceleration = [0, 0, -0.05]

[[body]]
name    = "net"
nodes   = [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
springs = [[0, 1], [1, 2]]
neuron  = {{ type = "point_mass", mass = 0.01 }}
spring  = {{ type = "linear", stiffness = 1.0 }}

[[element]]
invariant = "{}"
select    = {{ body = "net" }}
{}
{}
[[fix]]
select = {{ body = "net", nodes = [0, 1] }}
)";

std::string scene_of_elements(const Component& component, const std::string& invariant, const std::string& law) {
  const bool directed = component.law().invariant == SPRINGNET_SEVERAL && component.law().reads_direction != 0;
  const std::string more = directed ? "direction = [1, 0, 0]\n" : "";
  if (invariant == "angle" || invariant == "chain") return fmt::format(bent_chain, invariant, law, more);
  const bool is_solid = invariant == "volume" || invariant == "tetrahedron" || invariant == "enclosed_volume";
  return fmt::format(body_of_elements, is_solid ? block : sheet, invariant, law, more);
}

// A signal for each input that grows from its preset by its scale, within its bounds.
std::string signals_of(const Component& component) {
  std::string text;
  for (const springnet_parameter* input : inputs_of(component)) {
    const double from = input->default_value, to = std::clamp(from + input->scale, input->smallest, input->largest);
    text += fmt::format("\n[[input]]  # {}\ninput  = \"{}\"\ntimes  = [0, 1]\nvalues = [{:g}, {:g}]\n",
                        shown(input->summary), input->name, from, to);
  }
  return text;
}

}  // namespace

std::string sample_scene(const Component& component, const std::string& name) {
  std::string line = scene_line(component, name, TablesAs::numbers);
  const std::string title =
      fmt::format("# A sample of {} '{}': {}.\n# Values of required parameters are only examples.\n",
                  name_of(component.kind()), component.id(), shown(component.description->summary));
  const std::string mass = "neuron  = { type = \"point_mass\", mass = 0.1 }";
  const std::string linear = "spring  = { type = \"linear\", stiffness = 1.0 }";
  const auto scene = [&](const std::string& integrator, const std::string& rest) {
    return title + fmt::format(simulation_part, integrator.empty() ? integrator : integrator + "\n") + rest +
           signals_of(component);
  };
  switch (component.kind()) {
    case ComponentKind::integrator:
      return scene(line, fmt::format(row_of_nodes, mass, linear, ""));
    case ComponentKind::neuron:
      return scene("", fmt::format(row_of_nodes, line, linear, ""));
    default:
      break;
  }
  const std::string invariant = invariant_of_elements(component.law());
  if (!invariant.empty()) return scene("", scene_of_elements(component, invariant, line));
  const bool is_spring = component.kind() == ComponentKind::spring_function;
  return scene("", fmt::format(row_of_nodes, mass, is_spring ? line : linear, is_spring ? "" : line + "\n"));
}

}  // namespace springnet::tool
