#include "simulation/start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "simulation/contact_changes.hpp"

namespace springnet {
namespace {

// Friction keeps its direction for slower slips, in units of the velocity scale: their path until they end is far below
// any integration error.
constexpr double slow_slip = 1e-6;
// Smaller rates of lengths, likewise, are rounding.
constexpr double no_rate = 1e-9;

// Mean rest length of springs; without any, the length of an element's first edge; m.
double mean_length(const Model& model) {
  const layers::Layout& layout = model.layout;
  double length = 0.0;
  std::size_t count = 0;
  for (std::uint32_t s = 0; s < layout.spring_count(); ++s) {
    const double rest = layout.group_of(s).columns[0][layout.laws().row[s]];
    if (rest > 0.0) {
      length += rest;
      ++count;
    }
  }
  for (std::uint32_t e = 0; length == 0.0 && e < layout.elements().count(); ++e) {
    const std::span<const std::uint32_t> nodes = layout.elements().nodes(e);
    const springnet_vectors& position = model.state.view.position;
    length = (vector_at(position, nodes[1]) - vector_at(position, nodes[0])).norm();
    count = length > 0.0 ? 1 : 0;
  }
  return count > 0 ? length / static_cast<double>(count) : 1.0;
}

}  // namespace

void check_places(const Model& model, double size, const std::function<bool(std::uint32_t, std::size_t)>& is_checked) {
  const Contact& contact = model.contact;
  const std::shared_ptr<const Placement> start = model.placement(model.time);
  for (std::uint32_t k = 0; k < model.node_count(); ++k) {
    if (contact.fixed()[k] != 0) continue;
    for (std::size_t j = 0; j < contact.obstacles().size(); ++j) {
      if (is_checked && !is_checked(k, j)) continue;
      const Obstacle& obstacle = contact.obstacles()[j];
      const double depth = starting_depth(obstacle, start->poses[j], vector_at(model.state.view.position, k), size);
      if (depth == 0.0) continue;
      throw Error(ErrorKind::input, misplaced(model.user_number(k), depth, obstacle.is_plane(), contact.name_of(j)));
    }
  }
}

Scales find_scales(Model& model) {
  const double length = mean_length(model);
  double speed = 0.0, acceleration = 0.0, force = 0.0, mass = 0.0;
  const springnet_state& s = model.with_forces().view;
  const double load = model.loads.greatest();
  for (std::uint32_t k = 0; k < model.node_count(); ++k) {
    const double v = vector_at(s.velocity, k).norm();
    const double f = std::max(load, vector_at(s.force, k).norm());
    speed = std::max(speed, v);
    mass = std::max(mass, model.mass[k]);
    acceleration = std::max(acceleration, f / model.mass[k]);
    force = std::max({force, f, model.mass[k] * model.loads.gravity().norm(), model.mass[k] * v * v / length});
  }
  // A network at rest that obstacles or moved nodes will set in motion has only forces of rounding yet.
  double driven = model.contact.prescribed().typical_speed();
  for (const Obstacle& obstacle : model.contact.obstacles()) driven = std::max(driven, obstacle.typical_speed(length));
  speed = std::max(speed, driven);
  force = std::max(force, mass * driven * driven / length);
  const auto positive_or = [](double value, double fallback) {
    return std::isfinite(value) && value > 0.0 ? value : fallback;
  };
  return {length, positive_or(std::max(speed, std::sqrt(acceleration * length)), length),
          positive_or(force, positive_or(mass * length, 1.0))};
}

void start_constraints(Model& model, double size) {
  model.contact.set_rest_speed(slow_slip * model.scales.velocity);
  check_places(model, size, {});
  const State& state = model.state;
  if (model.rigid.any()) {
    const double rate = model.rigid.max_length_rate(read_only(state.view.position), read_only(state.view.velocity));
    if (rate > no_rate * model.scales.velocity)
      model.journal.note(
          fmt::format("the initial velocities change the length of rigid connections by up to {:.3g} m/s; they are "
                      "replaced by the nearest velocities that keep the lengths",
                      rate));
  }
  const std::shared_ptr<const Placement> start = model.placement(model.time);
  const auto project = [&] {
    if (model.constraints.project(*start, state.view.position, state.view.velocity, model.journal.message) !=
        SPRINGNET_OK)
      throw Error(ErrorKind::input, model.journal.message.text);
  };
  project();
  if (settle_contacts(model) != SPRINGNET_OK) throw Error(ErrorKind::simulation, model.journal.message.text);
  project();  // a node that an obstacle stopped stops what is rigidly connected to it
}

}  // namespace springnet
