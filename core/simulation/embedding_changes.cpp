#include "simulation/embedding_changes.hpp"

#include "constraints/vectors.hpp"
#include "simulation/contact_changes.hpp"

namespace springnet {
namespace {

// From `start` now to `end` (m) until a time, s; the velocity until now (m/s) goes on to the next step.
Motion straight(const Model& model, double until, const Vector3& start, const Vector3& end, const Vector3& velocity) {
  Motion motion;
  motion.interpolation = Motion::Interpolation::linear;
  motion.times = {model.time - model.time_step, model.time, until};
  motion.displacements = {start - model.time_step * velocity, start, end};
  return motion;
}

// velocity: m/s, before the change.
void release(Model& model, std::uint32_t node, const Vector3& velocity) {
  const std::shared_ptr<const Placement> now = model.placement_now();
  for (const std::int32_t surface : model.contact.committed(node).surfaces())
    if (surface >= 0)
      model.record(Event::Kind::released, model.time, node, surface,
                   {vector_at(model.state.view.position, node), velocity}, *now);
  model.contact.release(node);
}

void set_velocity(Model& model, std::uint32_t node, const Vector3& velocity) {
  Contact& contact = model.contact;
  const springnet_vectors& velocities = model.state.view.velocity;
  const Vector3 before = vector_at(velocities, node);
  put_vector(velocities, node, velocity);
  const Touch touch = contact.committed(node);
  if (touch.surface < 0) return;
  const auto j = static_cast<std::size_t>(touch.surface);
  const std::shared_ptr<const Placement> now = model.placement_now();
  const Vector3 p = vector_at(model.state.view.position, node);
  const Vector3 n = contact.normal(*now, j, p), w = Contact::velocity(*now, j, p);
  const double separating = n.dot(velocity - w);
  // A node between two obstacles is released; it touches again those that it still approaches.
  if (touch.second >= 0 || separating > 0.0) {
    release(model, node, before);
  } else if (contact.obstacles()[j].friction().kind == Friction::Kind::held) {
    put_vector(velocities, node, w);
  } else {
    put_vector(velocities, node, velocity - n * separating);
    contact.touch(node, after(touch, {ContactCause::Kind::slip}), Vector3::Zero());
    contact.set_slip(node, Vector3::Zero());  // it has a new one
  }
}

}  // namespace

void set_node(Model& model, std::uint32_t node, const std::optional<Vector3>& position,
              const std::optional<Vector3>& velocity) {
  if (position) {
    put_vector(model.state.view.position, node, *position);
    model.contact.release(node);
  }
  if (velocity) set_velocity(model, node, *velocity);
  model.changed();
}

void set_fixed(Model& model, std::uint32_t node, bool fixed) {
  model.contact.stop_motion(node);
  model.contact.set_fixed(node, fixed);
  set_node(model, node, std::nullopt, fixed ? std::optional<Vector3>(Vector3::Zero()) : std::nullopt);
}

void move_surface(Model& model, std::size_t surface, const Vector3& position, double time) {
  const Pose now = model.placement_now()->poses[surface];
  const Vector3 end = model.contact.obstacles()[surface].displacement_to(position, time);
  model.contact.set_trajectory(surface, Trajectory(straight(model, time, now.displacement, end, now.velocity)));
  model.interval = {};
  model.jumps_due = true;
}

void move_node(Model& model, std::uint32_t node, const Vector3& position, double time) {
  const Vector3 now = vector_at(model.state.view.position, node);
  if (model.contact.fixed()[node] == 0) model.changed();
  model.contact.set_fixed(node, true);
  const Vector3 velocity = vector_at(model.state.view.velocity, node);
  model.contact.set_motion(node, now, Trajectory(straight(model, time, Vector3::Zero(), position - now, velocity)));
  model.jumps_due = true;
}

}  // namespace springnet
