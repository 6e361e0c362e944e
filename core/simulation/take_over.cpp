// What the parts of an engine keep where their network is extended: all that has happened since the start, by the
// user's numbers, which stay. Springs, elements, loads, cuts and inputs are added behind those that are there; in the
// engine, nodes may have other places, and instruments come behind all planes.
#include <algorithm>
#include <cmath>
#include <limits>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "simulation/engine.hpp"
#include "simulation/start.hpp"

namespace springnet {

layers::NumbersBefore Model::numbers_in(const Model& before) const {
  layers::NumbersBefore numbers;
  const layers::Ordering& old = before.layout.ordering();
  for (const std::uint32_t user : layout.ordering().user)
    numbers.node.push_back(user < old.engine.size() ? old.engine[user] : layers::NumbersBefore::none);
  const auto planes = [](const Contact& of) {
    return static_cast<std::size_t>(std::count_if(of.obstacles().begin(), of.obstacles().end(),
                                                  [](const Obstacle& each) { return each.is_plane(); }));
  };
  const std::size_t planes_before = planes(before.contact), added = planes(contact) - planes_before;
  for (std::size_t j = 0; j < before.contact.obstacles().size(); ++j)
    numbers.surface_now.push_back(j < planes_before ? j : j + added);
  return numbers;
}

void Model::take_over(const Model& before, const Network& network) {
  const layers::NumbersBefore numbers = numbers_in(before);
  time = time_before = before.time;
  interval = before.interval;
  jumps_due = before.jumps_due;
  time_before = before.time_before;
  scales = before.scales;
  revision = before.revision;
  load_revision = before.load_revision + 1;
  layout.take_over(before.layout, numbers);
  numbers.for_each_node([&](std::uint32_t k, std::uint32_t old) {
    if (before.mass[old] != mass[k]) set_mass(k, before.mass[old]);
  });
  layout.signals().take_over(before.layout.signals(), before.layout.laws().inputs.size(), time);
  contact.take_over(before.contact, numbers);
  journal.take_over(before.journal, numbers);
  recent_touches.take_over(before.recent_touches, numbers);
  recent_slips.take_over(before.recent_slips, numbers);
  constraints.bodies().take_over(before.constraints.bodies(), numbers);

  const std::shared_ptr<const Placement> at = placement_now();
  const Prescribed& prescribed = contact.prescribed();
  for (std::uint32_t k = 0; k < node_count(); ++k) {
    Vector3 position, velocity;
    if (const std::uint32_t old = numbers.node[k]; old != layers::NumbersBefore::none) {
      position = vector_at(before.state.view.position, old);
      velocity = vector_at(before.state.view.velocity, old);
    } else {
      const Node& node = network.nodes()[user_number(k)];
      const bool moves = prescribed.moves(k);
      position = moves ? prescribed.position(at->motions, k) : node.position;
      velocity = moves ? prescribed.velocity(at->motions, k) : node.fixed ? Vector3(Vector3::Zero()) : node.velocity;
    }
    put_vector(state.view.position, k, position);
    put_vector(state.view.velocity, k, velocity);
  }
  loads.take_over(before.loads, numbers);
  static_cast<void>(loads.set_interval(time, std::numeric_limits<double>::infinity()));
  start_internal();
  take_over_internal(before);
  changed();
  // Where nothing was added nothing touches or breaks that did not.
  const bool is_longer = layout.node_count() > before.layout.node_count() ||
                         layout.spring_count() > before.layout.spring_count() ||
                         layout.elements().count() > before.layout.elements().count() ||
                         rigid.rods().size() > before.rigid.rods().size() ||
                         contact.obstacles().size() > before.contact.obstacles().size();
  stale.contacts = before.stale.contacts || is_longer;
}

// Of springs and elements that were there, each state of the laws.
void Model::take_over_internal(const Model& before) {
  if (!before.layout.internal().any()) return;
  const auto copy = [&](std::uint32_t group, std::uint32_t group_before, std::uint32_t place,
                        std::uint32_t place_before) {
    const layers::InternalLayout::OfGroup& own = layout.internal().group(group);
    const layers::InternalLayout::OfGroup& old = before.layout.internal().group(group_before);
    for (std::size_t j = 0; j < layout.laws().groups[group].state_count(); ++j)
      state.view.internal[own.first + j * own.count + place] =
          before.state.view.internal[old.first + j * old.count + place_before];
  };
  for (std::uint32_t s = 0; s < before.layout.spring_count(); ++s)
    if (layout.internal().has(layout.laws().group[s]))
      copy(layout.laws().group[s], before.layout.laws().group[s], layout.internal().of_spring(s),
           before.layout.internal().of_spring(s));
  for (std::uint32_t e = 0; e < before.layout.elements().count(); ++e)
    if (layout.internal().has(layout.elements().group(e)))
      copy(layout.elements().group(e), before.layout.elements().group(e), layout.internal().of_element(e),
           before.layout.internal().of_element(e));
}

void Engine::take_over(const Engine& before, const Network& network) {
  const layers::NumbersBefore numbers = model_.numbers_in(before.model_);
  topology_.take_over(before.topology_);
  changes_.take_over(before.changes_);
  ledger_.take_over(before.ledger_, numbers);
  if (dissipation_ && before.dissipation_) dissipation_->take_over(*before.dissipation_);
  energy_noted_ = before.energy_noted_;
  committed_events_ = before.committed_events_;
  for (const std::size_t surface : before.left_behind_) left_behind_.insert(numbers.surface_now[surface]);
  check_places(model_, size_of(network), [&](std::uint32_t node, std::size_t surface) {
    const auto is_old = std::find(numbers.surface_now.begin(), numbers.surface_now.end(), surface);
    return numbers.node[node] == layers::NumbersBefore::none || is_old == numbers.surface_now.end();
  });
  // Magnitudes stay, and with them tolerances, unless what was added is of another size.
  constexpr double other_size = 10.0;
  const Scales found = find_scales(model_);
  if (found.velocity > other_size * model_.scales.velocity) model_.scales.velocity = found.velocity;
  if (found.force > other_size * model_.scales.force) model_.scales.force = found.force;
  topology_.perform_due_cuts();
  changes_.perform_due();
  sweep_.pairs().begin_step();
}

}  // namespace springnet
