#include "simulation/verlet_contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "plugin_host/message.hpp"
#include "simulation/verlet_pairs.hpp"

namespace springnet {
namespace {

constexpr int max_impact_rounds = 100;  // rounds of impulses that depend on each other

}  // namespace

VerletContact::VerletContact(Model& model, double until, double length, const VerletContact* last)
    : model_(model),
      contact_(model.contact),
      from_(model.time),
      until_(until),
      h_(length),
      from_at_(model.contact.at(just_after(model.time))),
      at_(model.placement(until)) {
  if (last == nullptr) return;
  last_ = last->last_;
  last_h_ = last->last_h_;
}

springnet_status VerletContact::fail_lengths(const Body& body) const {
  set_message(model_.journal.message,
              fmt::format("the rigid connections of the {} nodes in the cluster of node {} cannot keep their "
                          "lengths in a step of {:g} s; use a smaller time step",
                          body.members.size(), model_.layout.ordering().user[body.nodes.front()], h_));
  return SPRINGNET_RECOVERABLE;
}

Eigen::MatrixXd VerletContact::mobility(const Body& body, const std::optional<Rods>& rods) const {
  if (!rods) return Eigen::MatrixXd::Identity(3, 3) / model_.mass[body.nodes.front()];
  std::vector<std::uint32_t> nodes;
  for (const Toucher& toucher : body.touchers) nodes.push_back(body.nodes[toucher.member]);
  return rods->mobility(nodes);
}

double VerletContact::negligible(const Body& body) const {
  // The rounding of positions and velocities, as a force.
  double force = Scales::min_force * model_.scales.force;
  for (const Member& m : body.members) {
    const double place = m.position.cwiseAbs().maxCoeff() / h_, speed = m.velocity.cwiseAbs().maxCoeff();
    force = std::max(force, 16.0 * std::numeric_limits<double>::epsilon() * model_.mass[m.node] * (place + speed) / h_);
  }
  return force;
}

void VerletContact::apply_impulses(Island& island, const Body& body) const {
  for (std::size_t i = 0; i < island.nodes().size(); ++i) {
    ContactNode& node = island.nodes()[i];
    std::size_t s = 0;
    for (const Side& side : body.touchers[i].sides)
      if (s < node.sides.size() && side.surface == node.sides[s].surface) node.impulse[s++] = side.impulse;
  }
  static_cast<void>(island.apply_impact(0.0, 0.0, max_impact_rounds, true));
}

void VerletContact::remember(const Island& island, bool struck, Body& body) const {
  for (std::size_t i = 0; i < island.nodes().size(); ++i) {
    const ContactNode& node = island.nodes()[i];
    std::size_t s = 0;
    for (Side& side : body.touchers[i].sides) {
      const bool acts = s < node.sides.size() && side.surface == node.sides[s].surface;
      side.impulse.setZero();
      if (acts && struck) side.impulse = node.impulse[s];
      if (acts && !struck) side.impulse = 0.5 * h_ * node.normal_force[s] * node.sides[s].normal;
      if (acts && !struck && node.sides.size() == 1) side.impulse = 0.5 * h_ * node.force;
      if (acts) ++s;
    }
  }
}

VerletContact::Body VerletContact::body_of(const springnet_sweep& step, const std::vector<std::uint32_t>& nodes) const {
  Body body;
  body.nodes = nodes;
  const Prescribed& prescribed = contact_.prescribed();
  for (const std::uint32_t k : nodes) {
    Member m{};
    m.node = k;
    m.fixed = contact_.fixed()[k] != 0;
    m.start = vector_at(step.start_position, k);
    m.start_velocity = vector_at(step.start_velocity, k);
    m.position = vector_at(step.next_position, k);
    m.velocity = vector_at(step.next_velocity, k);
    if (m.fixed) {
      const bool moves = prescribed.moves(k);
      m.place = moves ? prescribed.position(at_->motions, k) : m.start;
      m.place_velocity = moves ? prescribed.velocity(at_->motions, k) : Vector3::Zero();
    }
    body.members.push_back(m);
  }
  return body;
}

springnet_status VerletContact::evaluate_forces(Body& body, const springnet_sweep& step, double time,
                                                const springnet_const_vectors& position,
                                                const springnet_const_vectors& velocity) {
  const layers::NodeArrays nodes = node_arrays(position, velocity, model_.state.internal);
  for (Member& m : body.members) {
    const double* const force[3] = {step.force.x + m.node, step.force.y + m.node, step.force.z + m.node};
    Vector3 a;
    double* const acceleration[3] = {&a[0], &a[1], &a[2]};
    const springnet_status status = model_.evaluator.accelerations(m.node, 1, time, nodes, force, acceleration, nullptr,
                                                                   nullptr, nullptr, model_.journal.message);
    if (status != SPRINGNET_OK) return status;
    m.half = 0.5 * h_ * a;
  }
  return SPRINGNET_OK;
}

void VerletContact::push(Body& body, const std::optional<Rods>& rods, const std::vector<Vector3>& impulses) const {
  if (!rods) {
    for (const Vector3& impulse : impulses) body.members[0].velocity += impulse / model_.mass[body.nodes[0]];
    return;
  }
  std::vector<std::uint32_t> nodes;
  for (const Toucher& toucher : body.touchers) nodes.push_back(body.nodes[toucher.member]);
  rods->push(
      nodes, impulses,
      [&](std::uint32_t node, const Vector3& change) {
        const auto place = std::lower_bound(body.nodes.begin(), body.nodes.end(), node) - body.nodes.begin();
        Member& m = body.members[static_cast<std::size_t>(place)];
        if (!m.fixed) m.velocity += change;
      },
      [](std::uint32_t, const Vector3&) {});
}

// A side at the member's present position and velocity, for both halves of the step.
ContactSide VerletContact::side_of(const Body& body, const Toucher& toucher, const Side& of) const {
  const Member& m = body.members[toucher.member];
  const auto j = static_cast<std::size_t>(of.surface);
  const Obstacle& obstacle = contact_.obstacles()[j];
  ContactSide side;
  side.surface = of.surface;
  side.friction = body.cluster ? bounded(obstacle.friction()) : obstacle.friction();
  side.normal = contact_.normal(*at_, j, m.position);
  side.velocity = m.velocity - Contact::velocity(*at_, j, m.position);
  return side;
}

void VerletContact::decide(const Body& body) const {
  for (const Toucher& toucher : body.touchers) {
    const std::uint32_t k = body.nodes[toucher.member];
    Touch touch = contact_.committed(k);
    bool is_new = false;
    for (const Side& side : toucher.sides) {
      if (side.is_new && side.active) {
        touch = after(touch, {ContactCause::Kind::touch, side.surface, false});
        is_new = true;
      } else if (!side.is_new && !side.active) {
        touch = after(touch, {ContactCause::Kind::release, side.surface});
      }
    }
    if (!is_new) touch = after(touch, {toucher.sticks ? ContactCause::Kind::stick : ContactCause::Kind::slip});
    contact_.decide(k, touch, Vector3::Zero());
  }
}

springnet_status constrain_verlet(Model& model, const springnet_sweep& step, std::unique_ptr<VerletStep>& last) {
  constexpr std::uint32_t drift = 2, kick = 3;
  if (step.contacts != drift && step.contacts != kick)
    throw Error(ErrorKind::plugin, fmt::format("contacts is {}, where plugin.h has 0 to 3", step.contacts));
  const bool obstacles = !model.contact.obstacles().empty(), bodies = model.constraints.bodies().any();
  if (!obstacles && !bodies) return SPRINGNET_OK;
  if (step.contacts == kick) {
    const auto belongs = [&](const auto& part) { return part && part->is_of(model.time, step.time); };
    if (!last || (obstacles && !belongs(last->obstacles)) || (bodies && !belongs(last->bodies)))
      throw Error(ErrorKind::plugin, "a kick must follow the drift of the same step, once");
    springnet_status status = obstacles ? last->obstacles->kick(step) : SPRINGNET_OK;
    if (status == SPRINGNET_OK && bodies) status = last->bodies->kick(step);
    return status;
  }
  if (!(step.time > model.time) || !(step.time_constant > 0.0) || !std::isfinite(step.time_constant))
    throw Error(ErrorKind::plugin, "a drift must end after the committed time and have a positive time_constant");
  if (!last) last = std::make_unique<VerletStep>();
  const std::shared_ptr<VerletContact> before = last->obstacles;
  bool is_first = true;
  const auto constrain_obstacles = [&](const VerletContact::Pushes& pushes) -> springnet_status {
    if (!obstacles) return SPRINGNET_OK;
    // Not what obstacles did with other pushes: those that nodes met then they may not meet now.
    if (!std::exchange(is_first, false)) model.contact.discard_sweep();
    last->obstacles = std::make_shared<VerletContact>(model, step.time, step.time_constant, before.get());
    return last->obstacles->drift(step, pushes);
  };
  if (!bodies) return constrain_obstacles({});
  last->bodies = std::make_shared<VerletPairs>(model, step.time, step.time_constant);
  return last->bodies->drift(step, constrain_obstacles);
}

}  // namespace springnet
