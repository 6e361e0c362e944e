#include "vtk/vtk_data.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace springnet {

namespace {

using Place = VtkArray::Place;
using Type = VtkArray::Type;

constexpr std::uint8_t line_type = 3, triangle_type = 5;  // VTK_LINE, VTK_TRIANGLE
constexpr std::uint8_t spring_kind = 0, face_kind = 1, rigid_kind = 2;
constexpr double none = std::numeric_limits<double>::quiet_NaN();  // for cells without the quantity

Type real_of(OutputOptions::Precision precision) {
  return precision == OutputOptions::Precision::float64 ? Type::float64 : Type::float32;
}

using Ends = std::pair<NodeIndex, NodeIndex>;  // the lower one first
Ends ends_of(NodeIndex a, NodeIndex b) { return std::minmax({a, b}); }

// Springs by their ends. There may be several between the same nodes.
class SpringsByEnds {
 public:
  explicit SpringsByEnds(const Network& network) {
    springs_.reserve(network.springs().size());
    for (const Spring& spring : network.springs()) {
      springs_.emplace_back(ends_of(spring.first, spring.second), static_cast<SpringIndex>(springs_.size()));
    }
    std::sort(springs_.begin(), springs_.end());
  }

  void append_between(NodeIndex a, NodeIndex b, std::vector<SpringIndex>& springs) const {
    const Ends ends = ends_of(a, b);
    for (auto spring = std::lower_bound(springs_.begin(), springs_.end(), std::pair(ends, SpringIndex{0}));
         spring != springs_.end() && spring->first == ends; ++spring) {
      springs.push_back(spring->second);
    }
  }

 private:
  std::vector<std::pair<Ends, SpringIndex>> springs_;  // ascending
};

}  // namespace

VtkNet::VtkNet(const Network& network, const std::vector<LawStates>& law_states)
    : nodes(network.nodes().size()),
      springs(network.springs().size()),
      rigids(network.rigids().size()),
      faces(network.faces().size()),
      contact(nodes),
      surface(nodes),
      tension(springs, 0.0),
      energy(springs, 0.0),
      strain(springs, 0.0) {
  for (std::size_t k = 0; k < nodes; ++k) {
    node.push_back(static_cast<std::int64_t>(k));
    fixed.push_back(network.nodes()[k].fixed ? 1 : 0);
  }
  const auto add = [&](std::uint8_t type, std::uint8_t what, std::size_t index, std::initializer_list<NodeIndex> ends) {
    connectivity.insert(connectivity.end(), ends.begin(), ends.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    types.push_back(type);
    kind.push_back(what);
    number.push_back(static_cast<std::int64_t>(index));
  };
  for (std::size_t k = 0; k < springs; ++k) {
    const Spring& spring = network.springs()[k];
    add(line_type, spring_kind, k, {spring.first, spring.second});
    rest_lengths_.push_back(spring.rest_length);
  }
  for (std::size_t k = 0; k < rigids; ++k) {
    add(line_type, rigid_kind, k, {network.rigids()[k].first, network.rigids()[k].second});
  }
  if (faces > 0) {
    const SpringsByEnds springs_by_ends(network);
    for (std::size_t k = 0; k < faces; ++k) {
      const Face& face = network.faces()[k];
      add(triangle_type, face_kind, k, {face[0], face[1], face[2]});
      for (std::size_t edge = 0; edge < 3; ++edge) {
        springs_by_ends.append_between(face[edge], face[(edge + 1) % 3], edge_springs_);
      }
      edge_springs_end_.push_back(edge_springs_.size());
    }
  }
  tension.resize(types.size(), none);
  energy.resize(types.size(), none);
  strain.resize(types.size(), none);
  broken.resize(types.size());
  states_of_material_.resize(network.materials().size());
  for (const ComponentKind function : {ComponentKind::spring_function, ComponentKind::viscosity_function}) {
    const bool viscosity = function == ComponentKind::viscosity_function;
    for (const LawStates& law : law_states) {
      if (law.kind != function) continue;
      for (MaterialIndex m = 0; m < network.materials().size(); ++m) {
        const std::optional<LawUse>& use = viscosity ? network.materials()[m].viscosity : network.materials()[m].spring;
        for (std::size_t j = 0; use && use->id == law.law && j < law.states.size(); ++j)
          states_of_material_[m].push_back(states.size() + j);
      }
      for (const InternalState& state : law.states)
        states.push_back(
            {(viscosity ? "viscosity " : "") + law.law + ' ' + state.name, std::vector<double>(types.size(), none)});
    }
  }
  for (SpringIndex k = 0; !states.empty() && k < springs; ++k)
    if (const MaterialIndex m = network.springs().materials()[k]; !states_of_material_[m].empty())
      springs_with_states_.emplace_back(k, m);
}

void VtkNet::take(const Record& record) {
  const Simulation& simulation = record.simulation();
  time = record.time();
  places = record.positions().data();
  velocities = record.velocities().data();
  forces = record.forces().data();
  for (NodeIndex k = 0; k < nodes; ++k) {
    contact[k] = simulation.held(k) ? 2 : simulation.touching(k) ? 1 : 0;
    surface[k] = -1;
  }
  for (const BodyTouch& touch : simulation.body_touches())
    for (std::size_t i = 0; i < touch.count; ++i)
      if (contact[touch.nodes[i]] == 0) contact[touch.nodes[i]] = 1;
  for (NodeIndex k = 0; k < nodes; ++k) {
    if (contact[k] == 0) continue;
    if (const auto touched = simulation.surfaces_of(k); !touched.empty()) {
      surface[k] = static_cast<std::int64_t>(touched.front());
    }
  }

  std::copy(record.tensions().begin(), record.tensions().end(), tension.begin());
  std::copy(record.energies().begin(), record.energies().end(), energy.begin());
  const std::vector<double>& lengths = record.lengths();
  for (SpringIndex k = 0; k < springs; ++k) {
    broken[k] = simulation.alive(k) ? 0 : 1;
    strain[k] = rest_lengths_[k] > 0.0 ? lengths[k] / rest_lengths_[k] - 1.0 : none;
  }
  for (const auto& [spring, material] : springs_with_states_) {
    const std::vector<double> values = simulation.internal_states(spring);
    for (std::size_t j = 0; j < values.size(); ++j) states[states_of_material_[material][j]].values[spring] = values[j];
  }
  for (RigidIndex k = 0; k < rigids; ++k) tension[springs + k] = simulation.rigid_force(k);
  auto spring = edge_springs_.begin();
  for (std::size_t k = 0; k < faces; ++k) {
    const auto end = edge_springs_.begin() + static_cast<std::ptrdiff_t>(edge_springs_end_[k]);
    const bool torn = std::any_of(spring, end, [&](SpringIndex edge) { return broken[edge] != 0; });
    broken[springs + rigids + k] = torn ? 1 : 0;
    spring = end;
  }
}

VtkFile VtkNet::file(OutputOptions::Precision precision) const {
  const Type real = real_of(precision);
  const std::size_t cells = types.size();
  VtkFile file{VtkKind::unstructured,
               nodes,
               cells,
               {{Place::field, "TimeValue", Type::float64, 1, 1, &time},
                {Place::points, "Points", real, 3, nodes, places},
                {Place::cells, "connectivity", Type::int64, 1, connectivity.size(), connectivity.data()},
                {Place::cells, "offsets", Type::int64, 1, cells, offsets.data()},
                {Place::cells, "types", Type::uint8, 1, cells, types.data()},
                {Place::point_data, "velocity", real, 3, nodes, velocities},
                {Place::point_data, "force", real, 3, nodes, forces},
                {Place::point_data, "contact", Type::uint8, 1, nodes, contact.data()},
                {Place::point_data, "surface", Type::int64, 1, nodes, surface.data()},
                {Place::point_data, "fixed", Type::uint8, 1, nodes, fixed.data()},
                {Place::point_data, "node", Type::int64, 1, nodes, node.data()},
                {Place::cell_data, "tension", real, 1, cells, tension.data()},
                {Place::cell_data, "energy", real, 1, cells, energy.data()},
                {Place::cell_data, "strain", real, 1, cells, strain.data()},
                {Place::cell_data, "broken", Type::uint8, 1, cells, broken.data()},
                {Place::cell_data, "kind", Type::uint8, 1, cells, kind.data()},
                {Place::cell_data, "number", Type::int64, 1, cells, number.data()}}};
  for (const InternalStateArray& state : states)
    file.arrays.push_back({Place::cell_data, state.name, real, 1, cells, state.values.data()});
  return file;
}

VtkSurfaces::VtkSurfaces(const Network& network)
    : shapes(shapes_of(network)),
      places(3 * shapes.points.size()),
      forces(3 * shapes.triangles.size()),
      touching(shapes.triangles.size()) {
  for (const Plane& plane : network.planes()) starts_.push_back(plane.point);
  for (const Instrument& instrument : network.instruments()) starts_.push_back(instrument.first);
  for (std::size_t k = 0; k < shapes.triangles.size(); ++k) {
    connectivity.insert(connectivity.end(), shapes.triangles[k].begin(), shapes.triangles[k].end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    surface.push_back(shapes.triangle_surface[k]);
  }
}

void VtkSurfaces::take(const Record& record) {
  time = record.time();
  std::vector<Vector3> position;
  std::vector<Eigen::Matrix3d> rotation;
  for (std::size_t k = 0; k < starts_.size(); ++k) {
    position.push_back(record.simulation().surface_position(k));
    rotation.push_back(record.simulation().surface_rotation(k));
  }
  for (std::size_t k = 0; k < shapes.points.size(); ++k) {
    const std::uint32_t which = shapes.point_surface[k];
    Eigen::Map<Vector3> place(&places[3 * k]);
    place = position[which] + rotation[which] * (shapes.points[k] - starts_[which]);
  }
  for (std::size_t k = 0; k < shapes.triangles.size(); ++k) {
    const Record::SurfaceLoad& load = record.surface_loads()[shapes.triangle_surface[k]];
    Eigen::Map<Vector3> force(&forces[3 * k]);
    force = load.force;
    touching[k] = static_cast<std::int64_t>(load.nodes);
  }
}

VtkFile VtkSurfaces::file(OutputOptions::Precision precision) const {
  const Type real = real_of(precision);
  const std::size_t cells = shapes.triangles.size();
  return {VtkKind::polygons,
          shapes.points.size(),
          cells,
          {{Place::field, "TimeValue", Type::float64, 1, 1, &time},
           {Place::points, "Points", real, 3, shapes.points.size(), places.data()},
           {Place::cells, "connectivity", Type::int64, 1, connectivity.size(), connectivity.data()},
           {Place::cells, "offsets", Type::int64, 1, cells, offsets.data()},
           {Place::cell_data, "surface", Type::int64, 1, cells, surface.data()},
           {Place::cell_data, "force", real, 3, cells, forces.data()},
           {Place::cell_data, "nodes", Type::int64, 1, cells, touching.data()}}};
}

}  // namespace springnet
