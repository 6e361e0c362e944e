#include "simulation/topology.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "constraints/vectors.hpp"
#include "layers/elements/queries.hpp"
#include "layers/springs/queries.hpp"
#include "layers/springs/rupture.hpp"
#include "plugin_host/call.hpp"
#include "plugin_host/message.hpp"
#include "simulation/linear_model.hpp"

namespace springnet {
namespace {

Vector3 position_in(const layers::NodeArrays& nodes, std::uint32_t k) {
  return {nodes.px[k], nodes.py[k], nodes.pz[k]};
}

void take_middle(std::span<const std::uint32_t> of, const layers::NodeArrays& nodes, Event& event) {
  for (const std::uint32_t k : of) {
    event.position += position_in(nodes, k);
    event.velocity += Vector3(nodes.vx[k], nodes.vy[k], nodes.vz[k]);
  }
  event.position /= static_cast<double>(of.size());
  event.velocity /= static_cast<double>(of.size());
}

}  // namespace

Topology::Topology(Model& model, LinearModel& linear, const std::vector<Cut>& cuts) : model_(model), linear_(linear) {
  for (const Cut& cut : cuts) {
    ScheduledCut scheduled{cut.time, cut.springs, std::nullopt};
    if (!cut.polygon.empty()) scheduled.polygon.emplace(cut.polygon);
    cuts_.push_back(std::move(scheduled));
  }
}

const Topology::Rupturing& Topology::rupturing() {
  if (!rupturing_) rupturing_ = {layers::rupturing_springs(model_.layout), layers::rupturing_elements(model_.layout)};
  return *rupturing_;
}

std::size_t Topology::rupturing_count() const {
  const layers::Layout& layout = model_.layout;
  std::size_t count = layout.elements().live_count() > 0 ? layers::rupturing_elements(layout).size() : 0;
  if (!layers::can_rupture(layout)) return count;
  const Column<std::uint32_t>& group = layout.laws().group;
  if (group.is_uniform()) return count + (layout.group_of(0).can(SPRINGNET_HAS_RUPTURE) ? layout.live_count() : 0);
  for (std::uint32_t s = 0; s < layout.spring_count(); ++s)
    count += layout.alive(s) && layout.group_of(s).can(SPRINGNET_HAS_RUPTURE) ? 1 : 0;
  return count;
}

springnet_status Topology::margins(double time, const layers::NodeArrays& nodes, double* margins) {
  const Rupturing& some = rupturing();
  const InstructionSet set = model_.evaluator.instruction_set();
  springnet_status status =
      layers::spring_margins(model_.layout, set, time, nodes, some.springs, margins, model_.journal.message);
  if (status == SPRINGNET_OK)
    status = layers::element_margins(model_.layout, set, time, nodes, some.elements, margins + some.springs.size(),
                                     model_.journal.message);
  if (status != SPRINGNET_OK) return status;
  // A margin that is nan says neither that the element holds nor that it breaks.
  const double* const bad = std::find_if(margins, margins + some.count(), [](double m) { return std::isnan(m); });
  if (bad == margins + some.count()) return SPRINGNET_OK;
  const auto i = static_cast<std::size_t>(bad - margins);
  const bool element = i >= some.springs.size();
  const std::uint32_t number = element ? some.elements[i - some.springs.size()] : some.springs[i];
  const layers::Group& group =
      model_.layout.laws()
          .groups[element ? model_.layout.elements().group(number) : model_.layout.laws().group[number]];
  const layers::Law& law = group.spring.can(SPRINGNET_HAS_RUPTURE) ? group.spring : group.viscosity;
  const std::string reason = explain_failure(model_.layout, set, time, nodes);
  set_message(model_.journal.message,
              !reason.empty() ? reason
                              : fmt::format("{} answered a rupture margin that is not a number for {} {}",
                                            full_name(*law.component), element ? "element" : "spring", number));
  return SPRINGNET_RECOVERABLE;
}

Event Topology::event_of_spring(std::uint32_t s, Event::Kind kind, double time, const layers::NodeArrays& nodes) const {
  const layers::Layout& layout = model_.layout;
  Event event{kind, time, s};
  const std::array<std::uint32_t, 2> ends{layout.first(s), layout.second(s)};
  take_middle(ends, nodes, event);
  event.value = (position_in(nodes, ends[1]) - position_in(nodes, ends[0])).norm();
  event.force = layers::spring_tension(layout, model_.evaluator.instruction_set(), time, nodes, s);
  return event;
}

Event Topology::event_of_element(std::uint32_t e, Event::Kind kind, double time,
                                 const layers::NodeArrays& nodes) const {
  const layers::Layout& layout = model_.layout;
  Event event{kind, time, e, true};
  take_middle(layout.elements().nodes(e), nodes, event);
  event.value = layers::element_state(layout, nodes, e).value;
  event.force = layers::element_force(layout, model_.evaluator.instruction_set(), time, nodes, e);
  return event;
}

std::size_t Topology::remove(const Removal& removal, Event::Kind kind, double time, const layers::NodeArrays& nodes) {
  layers::Layout& layout = model_.layout;
  std::vector<Event> events;  // of all that are there, in the order in which they are removed
  for (const std::uint32_t s : removal.springs)
    if (layout.alive(s)) events.push_back(event_of_spring(s, kind, time, nodes));
  const std::vector<std::uint32_t> removed = layout.remove(removal.springs);
  std::size_t next = 0;
  for (const std::uint32_t s : removed) {
    while (events[next].index != s) ++next;  // one that was listed twice
    model_.journal.record(events[next]);
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;
  for (const std::uint32_t s : removed) ends.emplace_back(layout.first(s), layout.second(s));
  std::vector<std::uint32_t> broken;
  if (layout.elements().live_count() > 0) {
    broken = layout.elements().broken_by(ends);
    broken.insert(broken.end(), removal.elements.begin(), removal.elements.end());
    std::sort(broken.begin(), broken.end());
    std::erase_if(broken, [&layout](std::uint32_t e) { return !layout.elements().alive(e); });
    broken.erase(std::unique(broken.begin(), broken.end()), broken.end());
    for (const std::uint32_t e : broken) model_.journal.record(event_of_element(e, kind, time, nodes));
    broken = layout.remove_elements(broken);
  }
  bool faces_removed = false;
  if (layout.loaded_faces().count() > 0) {
    std::vector<std::size_t> lost = layout.loaded_faces().broken_by(ends);
    lost.insert(lost.end(), removal.faces.begin(), removal.faces.end());
    faces_removed = remove_faces(lost, time);
  }
  if (!removed.empty() || !broken.empty() || faces_removed) {
    rupturing_.reset();
    linear_.topology_changed();
    model_.changed();
  }
  return removed.size();
}

bool Topology::remove_faces(const std::vector<std::size_t>& faces, double time) {
  const std::vector<std::size_t> removed = model_.layout.remove_faces(faces);
  if (removed.empty()) return false;
  model_.loads.faces_changed();
  torn_faces_ += removed.size();
  std::set<std::uint32_t> loads;
  for (const std::size_t f : removed) loads.insert(model_.layout.loaded_faces().load_of(f));
  for (const std::uint32_t load : loads) {
    if (!torn_loads_.insert(load).second) continue;
    model_.journal.note(fmt::format(
        "Force {} ended on faces that were torn, first at {:g} s: a face is removed with a spring along one of its "
        "sides.",
        load, time));
  }
  return true;
}

std::size_t Topology::remove_elements(const std::vector<std::uint32_t>& elements) {
  const std::size_t before = model_.layout.elements().live_count();
  remove({{}, elements, {}}, Event::Kind::cut, model_.time, model_.state.nodes());
  return before - model_.layout.elements().live_count();
}

void Topology::remove_nodes(const std::vector<std::uint32_t>& nodes) {
  const layers::Layout& layout = model_.layout;
  Removal removal;
  std::vector<std::uint8_t> goes(layout.node_count(), 0);
  for (const std::uint32_t node : nodes) {
    goes[node] = 1;
    for (const layers::Incident* each = layout.incident_begin(node); each != layout.incident_end(node); ++each)
      removal.springs.push_back(each->spring);
    for (const layers::ElementShare& share : layout.elements().shares(node)) removal.elements.push_back(share.element);
  }
  std::sort(removal.springs.begin(), removal.springs.end());
  const layers::LoadedFaces& faces = layout.loaded_faces();
  for (std::size_t f = 0; f < faces.count(); ++f) {
    const auto& corners = faces.corners(f);
    if (std::any_of(corners.begin(), corners.end(), [&](std::uint32_t corner) { return goes[corner] != 0; }))
      removal.faces.push_back(f);
  }
  remove(removal, Event::Kind::cut, model_.time, model_.state.nodes());
}

std::size_t Topology::cut(const std::vector<std::uint32_t>& springs) {
  return remove({springs, {}, {}}, Event::Kind::cut, model_.time, model_.state.nodes());
}

std::size_t Topology::cut(const CuttingPolygon& polygon) {
  const auto crosses = [&](std::uint32_t a, std::uint32_t b) {
    return polygon.crosses(vector_at(model_.state.view.position, a), vector_at(model_.state.view.position, b));
  };
  std::vector<std::uint32_t> crossed;
  for (std::uint32_t s = 0; s < model_.layout.spring_count(); ++s)
    if (model_.layout.alive(s) && crosses(model_.layout.first(s), model_.layout.second(s))) crossed.push_back(s);
  return remove(
      {crossed, model_.layout.elements().crossed_by(crosses), model_.layout.loaded_faces().crossed_by(crosses)},
      Event::Kind::cut, model_.time, model_.state.nodes());
}

void Topology::perform_due_cuts() {
  // Rounding of times: a cut this close to the committed time is due.
  const double slack = 1e-9 * std::min(model_.time_step, model_.time);
  for (std::size_t k = 0; k < cuts_.size(); ++k) {
    ScheduledCut& scheduled = cuts_[k];
    if (scheduled.done || scheduled.time > model_.time + slack) continue;
    scheduled.done = true;
    const auto removed_so_far = [this] { return model_.journal.events().size() + torn_faces_; };
    const std::size_t before = removed_so_far();
    cut(scheduled.springs);
    if (scheduled.polygon) cut(*scheduled.polygon);
    if (removed_so_far() == before)
      model_.journal.note(fmt::format("Cut {} at {:g} s found nothing left to cut.", k, scheduled.time));
  }
}

springnet_status Topology::perform_due_ruptures() {
  const layers::NodeArrays nodes = model_.state.nodes();
  const InstructionSet set = model_.evaluator.instruction_set();
  springnet_message& message = model_.journal.message;
  broken_.clear();
  springnet_status status = SPRINGNET_OK;
  if (layers::can_rupture(model_.layout))
    status =
        layers::broken_springs(model_.layout, set, model_.evaluator.threads(), model_.time, nodes, broken_, message);
  std::vector<std::uint32_t> elements;
  if (status == SPRINGNET_OK && model_.layout.elements().live_count() > 0) {
    elements = layers::rupturing_elements(model_.layout);
    std::vector<double> margins(elements.size());
    status = layers::element_margins(model_.layout, set, model_.time, nodes, elements, margins.data(), message);
    if (std::any_of(margins.begin(), margins.end(), [](double margin) { return std::isnan(margin); }))
      status = SPRINGNET_RECOVERABLE;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < elements.size(); ++i)
      if (!(margins[i] > 0.0)) elements[kept++] = elements[i];
    elements.resize(kept);
  }
  if (status != SPRINGNET_OK) {
    // Once more one by one, for a message that names what failed.
    std::vector<double> margins(rupturing().count());
    const springnet_status again = this->margins(model_.time, nodes, margins.data());
    return again == SPRINGNET_OK ? status : again;
  }
  if (!broken_.empty() || !elements.empty()) remove({broken_, elements, {}}, Event::Kind::ruptured, model_.time, nodes);
  return SPRINGNET_OK;
}

void Topology::take_over(const Topology& before) {
  for (std::size_t k = 0; k < before.cuts_.size(); ++k) cuts_[k].done = before.cuts_[k].done;
  torn_loads_ = before.torn_loads_;
  torn_faces_ = before.torn_faces_;
}

void Topology::archive(Archive& archive) {
  layers::Layout& layout = model_.layout;
  bool changes = false;
  const auto removed = [&](std::size_t count, const auto& is_alive, const char* what) {
    archive.same(count, what);
    std::vector<std::uint32_t> present;
    for (std::uint32_t i = 0; i < count; ++i)
      if (!is_alive(i)) present.push_back(i);
    std::vector<std::uint32_t> list = present;
    list.resize(archive.count(list.size(), sizeof(std::uint32_t), what));
    for (std::uint32_t& each : list) archive.below(each, count, what);
    changes = changes || list != present;
    return list;
  };
  const auto springs = removed(
      layout.spring_count(), [&](std::uint32_t s) { return layout.alive(s); }, "springs");
  const auto elements = removed(
      layout.elements().count(), [&](std::uint32_t e) { return layout.elements().alive(e); }, "elements");
  const auto faces = removed(
      layout.loaded_faces().count(), [&](std::uint32_t f) { return layout.loaded_faces().alive(f); }, "loaded faces");
  changes = layout.archive_changes(archive) || changes || !layout.is_as_removed_at_once();
  archive.same(cuts_.size(), "cuts");
  for (ScheduledCut& each : cuts_) archive.flag(each.done);
  std::vector<std::uint32_t> torn(torn_loads_.begin(), torn_loads_.end());
  torn.resize(archive.count(torn.size(), sizeof(std::uint32_t), "torn loads"));
  for (std::uint32_t& each : torn) archive.number(each);
  if (!archive.reads()) return;
  torn_loads_ = {torn.begin(), torn.end()};
  torn_faces_ = faces.size();
  if (!changes) {  // as between copies, which share what they have not changed
    model_.loads.faces_changed();
    return;
  }
  lay_out_without({springs, elements, {faces.begin(), faces.end()}});
}

void Topology::lay_out_without(const Removal& removed) {
  layers::Layout& layout = model_.layout;
  layout.put_back_all();
  layout.remove(removed.springs);
  layout.remove_elements(removed.elements);
  layout.remove_faces(removed.faces);
  model_.loads.faces_changed();
  rupturing_.reset();
  linear_.topology_changed();
}

void Topology::put_back_all_but(const Removal& removed) {
  layers::Layout& layout = model_.layout;
  Removal all = removed;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;
  for (const std::uint32_t s : removed.springs) ends.emplace_back(layout.first(s), layout.second(s));
  layout.put_back_all();
  const auto add = [](auto& to, const auto& more) { to.insert(to.end(), more.begin(), more.end()); };
  if (layout.elements().live_count() > 0) add(all.elements, layout.elements().broken_by(ends));
  if (layout.loaded_faces().count() > 0) add(all.faces, layout.loaded_faces().broken_by(ends));
  lay_out_without(all);
  model_.changed();
}

void Topology::keep_states_of_removed(const State& before) {
  const layers::Layout& layout = model_.layout;
  const layers::InternalLayout& internal = layout.internal();
  if (!internal.any()) return;
  if (states_revision_ != layout.revision()) {
    states_revision_ = layout.revision();
    removed_states_.clear();
    const auto add = [&](std::uint32_t group, std::uint32_t place) {
      const layers::InternalLayout::OfGroup& own = internal.group(group);
      for (std::size_t j = 0; j < layout.laws().groups[group].state_count(); ++j)
        removed_states_.push_back(own.first + j * own.count + place);
    };
    for (std::uint32_t s = 0; s < layout.spring_count(); ++s)
      if (!layout.alive(s) && internal.has(layout.laws().group[s])) add(layout.laws().group[s], internal.of_spring(s));
    const layers::ElementLayout& elements = layout.elements();
    for (std::uint32_t e = 0; e < elements.count(); ++e)
      if (!elements.alive(e) && internal.has(elements.group(e))) add(elements.group(e), internal.of_element(e));
  }
  for (const std::uint64_t place : removed_states_) model_.state.view.internal[place] = before.view.internal[place];
}

double Topology::next_cut(double time) const noexcept {
  double next = std::numeric_limits<double>::infinity();
  for (const ScheduledCut& cut : cuts_)
    if (!cut.done && cut.time > time) next = std::min(next, cut.time);
  return next;
}

}  // namespace springnet
