// What acts on the network as it is at present: loads, motions, planes, instruments, cuts.
#include <map>

#include "simulation/later.hpp"
#include "simulation/present_network.hpp"

namespace springnet {
namespace {

void add_loads(const Network& network, Engine& engine, Network& result) {
  const Model& model = engine.model();
  const layers::LoadedFaces& faces = model.layout.loaded_faces();
  for (std::size_t k = 0; k < network.loads().size(); ++k) {
    std::optional<Load> load = later(network.loads()[k], model.time);
    if (!load) continue;
    load->force *= model.loads.factor(k);
    load->traction *= model.loads.factor(k);
    load->pressure *= model.loads.factor(k);
    const std::vector<Face> all = std::exchange(load->faces, {});
    const std::vector<Vector3> areas = std::exchange(load->areas, {});
    for (std::size_t f = 0; f < all.size(); ++f) {
      if (!faces.alive(faces.first_of(k) + f)) continue;
      load->faces.push_back(all[f]);
      load->areas.push_back(areas[f]);
    }
    if (load->faces.empty() && !all.empty() && load->nodes.empty()) continue;
    if (load->faces.empty()) {
      load->traction.setZero();
      load->pressure = 0.0;
    }
    result.add_load(*load);
  }
  for (NodeIndex k = 0; k < model.node_count(); ++k) {
    const Vector3 force = model.loads.host_force(model.layout.ordering().engine[k]);
    if (!force.isZero(0.0)) result.add_load({.nodes = {k}, .force = force});
  }
}

// Nodes are where they are now, so that their motions begin with a displacement of 0.
void add_moves(Engine& engine, Network& result) {
  const Model& model = engine.model();
  const Prescribed& prescribed = model.contact.prescribed();
  std::map<std::uint32_t, Move> moves;
  for (NodeIndex k = 0; k < model.node_count(); ++k) {
    const std::uint32_t node = model.layout.ordering().engine[k];
    if (prescribed.moves(node)) moves[prescribed.number_of(node)].nodes.push_back(k);
  }
  for (auto& [number, move] : moves) {
    const std::optional<Motion> motion = later(prescribed.trajectory(number).motion(), model.time);
    if (!motion) continue;
    move.motion = *motion;
    result.add_move(move);
  }
}

template <class PlaneOrInstrument>
void place_motion(PlaneOrInstrument& surface, const Obstacle& obstacle, const Pose& pose, double time) {
  surface.motion = obstacle.trajectory().moves() ? later(obstacle.trajectory().motion(), time) : std::nullopt;
  if (!surface.turn) return;
  if (surface.turn->through) *surface.turn->through = pose.from_start(*surface.turn->through);
  surface.turn = later(*surface.turn, time);
}

void add_obstacles(const Network& network, Engine& engine, Network& result) {
  const Model& model = engine.model();
  const std::shared_ptr<const Placement> now = model.placement_now();
  std::size_t number = 0;
  for (Plane plane : network.planes()) {
    const Obstacle& obstacle = model.contact.obstacles()[number];
    const Pose& pose = now->poses[number++];
    // The pivot of a turn without `through` is where the plane's point is.
    plane.point = pose.from_start(plane.point);
    if (pose.turns) plane.normal = pose.rotation * plane.normal;
    place_motion(plane, obstacle, pose, model.time);
    plane.friction = obstacle.friction();
    result.add_plane(plane);
  }
  for (Instrument instrument : network.instruments()) {
    const Obstacle& obstacle = model.contact.obstacles()[number];
    const Pose& pose = now->poses[number++];
    const bool is_sphere = instrument.first == instrument.second;
    instrument.first = pose.from_start(instrument.first);
    instrument.second = is_sphere ? instrument.first : pose.from_start(instrument.second);
    if (instrument.box && pose.turns) instrument.box->axes = pose.rotation * instrument.box->axes;
    place_motion(instrument, obstacle, pose, model.time);
    instrument.friction = obstacle.friction();
    result.add_instrument(instrument);
  }
}

// Those that are still to come. One of springs and elements that are all removed is none.
void add_changes(const Network& network, Engine& engine, const NewNumbers& numbers, Network& result) {
  const auto renumbered = [](std::vector<std::uint32_t>& list, const std::vector<std::uint32_t>& now) {
    const std::vector<std::uint32_t> before = std::exchange(list, {});
    for (const std::uint32_t each : before)
      if (now[each] != NewNumbers::removed) list.push_back(now[each]);
  };
  for (std::size_t k = 0; k < network.changes().size(); ++k) {
    Change change = network.changes()[k];
    if (engine.changes().is_exchanged(k)) change.integrator.reset();
    const bool is_due = !engine.changes().is_done(k);
    if (!is_due) {
      change.springs.clear();
      change.elements.clear();
      change.nodes.clear();
    }
    change.time = std::max(0.0, change.time - engine.model().time);
    renumbered(change.springs, numbers.spring);
    renumbered(change.elements, numbers.element);
    const bool of_laws = !change.springs.empty() || !change.elements.empty();
    if (!of_laws) {
      for (ParameterValues* each : {&change.spring, &change.viscosity, &change.spring_inputs, &change.viscosity_inputs})
        each->clear();
      change.reference.reset();
      change.reference_scale.reset();
    }
    if (change.nodes.empty()) {
      change.neuron.clear();
      change.mass.reset();
    }
    if (of_laws || !change.nodes.empty() || change.integrator) result.add_change(change);
  }
}

}  // namespace

void add_surroundings(const Network& network, Engine& engine, const NewNumbers& numbers, Network& result) {
  result.set_gravity(engine.model().loads.gravity());
  add_loads(network, engine, result);
  add_moves(engine, result);
  add_obstacles(network, engine, result);
  for (const BodyContact& contact : network.contacts()) result.add_contact(contact);
  for (std::size_t k = 0; k < network.cuts().size(); ++k) {
    if (engine.topology().is_done(k)) continue;
    Cut cut = network.cuts()[k];
    cut.time = std::max(0.0, cut.time - engine.model().time);
    const std::vector<SpringIndex> springs = std::exchange(cut.springs, {});
    for (const SpringIndex each : springs)
      if (numbers.spring[each] != NewNumbers::removed) cut.springs.push_back(numbers.spring[each]);
    if (!cut.springs.empty() || !cut.polygon.empty()) result.add_cut(cut);
  }
  add_changes(network, engine, numbers, result);
}

}  // namespace springnet
