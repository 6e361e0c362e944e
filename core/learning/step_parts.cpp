#include "learning/step_parts.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "constraints/vectors.hpp"
#include "learning/node_vectors.hpp"

namespace springnet::learning {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using EventKind = LocatedEvent::Kind;

EventKind kind_of(ContactEvents::Source::Kind kind) {
  using Source = ContactEvents::Source::Kind;
  switch (kind) {
    case Source::touch:
      return EventKind::touch;
    case Source::release:
      return EventKind::release;
    case Source::slip:
      return EventKind::slip;
    case Source::rest:
      return EventKind::rest;
    case Source::slow:
      return EventKind::slow;
    case Source::quick:
      return EventKind::quick;
    case Source::stall:
      return EventKind::stall;
    default:
      return EventKind::seam;
  }
}

void copy_state(const springnet_state& from, std::uint32_t nodes, VectorXd& p, VectorXd& v) {
  p.resize(3 * Index{nodes});
  v.resize(3 * Index{nodes});
  const springnet_vectors* const arrays[] = {&from.position, &from.velocity};
  VectorXd* const to[] = {&p, &v};
  for (std::size_t half = 0; half < 2; ++half) {
    double* next = to[half]->data();
    for (const double* component : {arrays[half]->x, arrays[half]->y, arrays[half]->z})
      next = std::copy_n(component, nodes, next);
  }
}

}  // namespace

void PartRecorder::step(Simulation& simulation, bool told) {
  parts_.clear();
  if (!divides_) {
    simulation.step();
    return;
  }
  fired_ = false;
  tells_ = told;
  const StepWatch::Scope scope(*this);
  simulation.step();
  if (parts_.size() == 1 && parts_.front().events.empty()) parts_.clear();
  if (!parts_.empty())
    for (VectorXd* each : {&parts_.back().p, &parts_.back().v, &parts_.back().z}) each->resize(0);
}

void PartRecorder::fires(Engine& engine, double, const State& state, const std::int32_t* fired) {
  const Model& model = engine.model();
  fired_ = true;
  events_before_ = model.journal.events().size();
  within_ = contacts_of(model.contact, model.node_count());
  copy_state(state.view, model.node_count(), p_, v_);
  by_sources_.clear();
  ruptures_.clear();
  const std::vector<ContactEvents::Source>& sources = engine.contact_events().sources();
  for (std::size_t e = 0; e < sources.size(); ++e) {
    if (fired[e] == 0) continue;
    LocatedEvent event;
    event.kind = kind_of(sources[e].kind);
    event.index = sources[e].index;
    event.surface = static_cast<std::int32_t>(sources[e].surface);
    by_sources_.push_back(event);
  }
  const Topology::Rupturing& breaking = engine.topology().rupturing();
  const auto add_rupture = [&](EventKind kind, std::uint32_t index) {
    LocatedEvent event;
    event.kind = kind;
    event.index = index;
    ruptures_.push_back(event);
  };
  const std::int32_t* next = fired + sources.size();
  for (const std::uint32_t spring : breaking.springs)
    if (*next++ != 0) add_rupture(EventKind::spring_rupture, spring);
  for (const std::uint32_t element : breaking.elements)
    if (*next++ != 0) add_rupture(EventKind::element_rupture, element);
  slips_.assign(within_.empty() ? 0 : model.node_count(), Vector3::Zero());
  braced_.clear();
  for (const auto& [node, touch] : within_) {
    slips_[node] = model.contact.slip(node);
    if (model.contact.braced(node)) braced_.push_back(node);
  }
}

std::map<std::uint32_t, PartRecorder::Outcome> PartRecorder::outcomes(const Engine& engine) const {
  std::map<std::uint32_t, Outcome> result;
  const Model& model = engine.model();
  const std::vector<Event>& events = model.journal.events();
  for (std::size_t e = events_before_; e < events.size(); ++e) {
    const Event& event = events[e];
    if (event.surface < 0 || event.kind == Event::Kind::jammed) continue;
    Outcome& own = result[model.layout.ordering().engine[event.index]];
    if (event.kind == Event::Kind::touched) own.touched.push_back(event.surface);
    if (event.kind == Event::Kind::released) own.released.push_back(event.surface);
    own.slipped = own.slipped || event.kind == Event::Kind::slipped;
    own.stuck = own.stuck || event.kind == Event::Kind::stuck;
  }
  return result;
}

NodeChange PartRecorder::change_of(const Engine& engine, std::uint32_t node) const {
  const Model& model = engine.model();
  const springnet_state& now = model.state.view;
  NodeChange result;
  result.node = node;
  result.before = touch_of(within_, node);
  result.after = model.contact.committed(node);
  result.p = node_of(p_, node);
  result.v = node_of(v_, node);
  result.next_p = vector_at(now.position, node);
  result.next_v = vector_at(now.velocity, node);
  if (!slips_.empty()) result.slip = slips_[node];
  result.braced = model.contact.braced(node) || std::binary_search(braced_.begin(), braced_.end(), node);
  return result;
}

// Whatever else happens to nodes of the cluster follows from the event of one of them.
void PartRecorder::add_event_of_cluster(const Engine& engine, std::size_t cluster,
                                        const std::map<std::uint32_t, Outcome>& all, StepPart& part) const {
  const std::vector<std::uint32_t>& nodes = engine.model().rigid.nodes_of(cluster);
  const auto is_own = [&](std::uint32_t node) { return std::binary_search(nodes.begin(), nodes.end(), node); };
  std::vector<LocatedEvent> causes;
  std::copy_if(by_sources_.begin(), by_sources_.end(), std::back_inserter(causes),
               [&](const LocatedEvent& each) { return is_own(each.index); });
  for (const auto& [node, own] : all) {
    if (!is_own(node)) continue;
    if (causes.empty() && own.touched.empty()) causes.push_back({EventKind::several, node});
    for (const std::int32_t surface : own.touched) {  // within the contact tolerance perhaps, which no source tells
      const auto known = std::find_if(causes.begin(), causes.end(), [&](const LocatedEvent& each) {
        return each.kind == EventKind::touch && each.index == node && each.surface == surface;
      });
      if (known == causes.end()) causes.push_back({EventKind::touch, node, surface});
    }
  }
  LocatedEvent event = causes.front();
  if (causes.size() > 1) event.kind = EventKind::several;
  for (const std::uint32_t node : nodes) event.cluster.push_back(change_of(engine, node));
  event.own = change_of(engine, event.index);
  if (event.surface < 0) event.surface = std::max(event.own.before.surface, event.own.after.surface);
  part.events.push_back(std::move(event));
}

// A touch may have others of these as its consequence, and a release that of friction.
void PartRecorder::add_events_of_nodes(Engine& engine, StepPart& part) {
  const std::map<std::uint32_t, Outcome> all = outcomes(engine);
  const std::uint32_t* const cluster_of = engine.model().rigid.cluster_of();
  std::set<std::uint32_t> clusters;
  const auto is_alone = [&](std::uint32_t node) {
    if (cluster_of == nullptr || cluster_of[node] == 0xffffffffu) return true;
    clusters.insert(cluster_of[node]);
    return false;
  };
  const auto add = [&](EventKind kind, std::uint32_t node, std::int32_t surface) {
    LocatedEvent event;
    event.kind = kind;
    event.index = node;
    event.surface = surface;
    event.own = change_of(engine, node);
    part.events.push_back(std::move(event));
  };
  for (const auto& [node, own] : all) {
    if (!is_alone(node)) continue;
    if (!own.touched.empty()) {
      add(own.touched.size() > 1 ? EventKind::several : EventKind::touch, node, own.touched.front());
    } else if (!own.released.empty()) {
      const auto fired = std::find_if(by_sources_.begin(), by_sources_.end(), [k = node](const LocatedEvent& each) {
        return each.kind == EventKind::release && each.index == k;
      });
      add(own.released.size() > 1 ? EventKind::several : EventKind::release, node,
          fired == by_sources_.end() ? own.released.front() : fired->surface);
    } else if (own.slipped || own.stuck) {
      add(own.slipped ? EventKind::slip : EventKind::rest, node, touch_of(within_, node).surface);
    }
  }
  // Those without a consequence for the contact divide the step, too.
  for (std::size_t i = 0; i < by_sources_.size(); ++i) {
    const LocatedEvent& own = by_sources_[i];
    if (is_alone(own.index) && all.find(own.index) == all.end() && (i == 0 || by_sources_[i - 1].index != own.index))
      add(own.kind, own.index, own.surface);
  }
  for (const std::uint32_t cluster : clusters) add_event_of_cluster(engine, cluster, all, part);
}

void PartRecorder::committed(Engine& engine, bool decided) {
  const Model& model = engine.model();
  StepPart& part = parts_.emplace_back();
  part.time = model.time;
  copy_state(model.state.view, model.node_count(), part.p, part.v);
  part.z = Eigen::Map<const VectorXd>(model.state.view.internal, static_cast<Index>(model.state.internal_count));
  if (fired_) {
    if (!model.contact.obstacles().empty()) add_events_of_nodes(engine, part);
    part.events.insert(part.events.end(), ruptures_.begin(), ruptures_.end());
  } else if (!model.contact.obstacles().empty()) {
    within_ = contacts_of(model.contact, model.node_count());
  } else {
    within_.clear();
  }
  fired_ = false;
  if (tells_) told_({engine, part, within_, decided});
}

}  // namespace springnet::learning
