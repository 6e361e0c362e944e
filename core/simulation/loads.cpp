#include "simulation/loads.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace springnet {

Loads::Loads(const Network& network, const layers::Layout& layout)
    : layout_(layout), gravity_(network.gravity()), node_count_(network.nodes().size()) {
  const std::vector<std::uint32_t>& engine = layout.ordering().engine;
  for (const Load& load : network.loads()) {
    Entry entry{{}, load.force, {}, {}, 0.0, LoadCourse(load), load.from, load.until, 0.0, 0.0};
    for (const NodeIndex node : load.nodes) entry.nodes.push_back(engine[node]);
    if (load.follow) entry.pressure = load.pressure;
    for (const Vector3& area : load.areas) {
      Vector3 third = area.norm() / 3.0 * load.traction;
      if (!load.follow) third -= load.pressure / 3.0 * area;
      entry.face_third.push_back(third);
    }
    entries_.push_back(std::move(entry));
    sum_faces(entries_.size() - 1);

    double greatest = load.nodes.empty() && !load.faces.empty() ? 0.0 : load.force.norm();
    if (!load.faces.empty()) {
      std::map<NodeIndex, Vector3> on_node;
      for (const auto& [node, force] : forces_of(load))
        on_node.try_emplace(node, Vector3::Zero()).first->second += force;
      for (const auto& [node, force] : on_node) greatest = std::max(greatest, force.norm());
    }
    greatest_ = std::max(greatest_, entries_.back().course.greatest() * greatest);
  }
  pressure_.assign(entries_.size(), 0.0);
}

void Loads::sum_faces(std::size_t load) {
  Entry& entry = entries_[load];
  const layers::LoadedFaces& faces = layout_.loaded_faces();
  std::map<std::uint32_t, Vector3> on_node;
  for (std::size_t f = 0; f < entry.face_third.size(); ++f) {
    const std::size_t face = faces.first_of(load) + f;
    if (!faces.alive(face)) continue;
    for (const std::uint32_t node : faces.corners(face))
      on_node.try_emplace(node, Vector3::Zero()).first->second += entry.face_third[f];
  }
  entry.on_faces.assign(on_node.begin(), on_node.end());
}

void Loads::faces_changed() {
  for (std::size_t load = 0; load < entries_.size(); ++load) sum_faces(load);
  gather();
}

Loads::Change Loads::weigh(Entry& entry, double share, double weight) noexcept {
  const Change change = share != entry.share     ? Change::switched
                        : weight != entry.weight ? Change::varied
                                                 : Change::none;
  entry.share = share;
  entry.weight = weight;
  return change;
}

Loads::Change Loads::set_interval(double from, double until) {
  follows_ = false;
  from_ = from;
  until_ = until;
  if (!(std::isfinite(until) && until > from)) return set_time(from);
  Change change = Change::none;
  for (Entry& entry : entries_) {
    const double begin = std::max(from, entry.from), end = std::min(until, entry.until);
    // Steps end where loads switch, up to the rounding of times.
    double share = (end - begin) / (until - from);
    share = share < 1e-9 ? 0.0 : share > 1.0 - 1e-9 ? 1.0 : share;
    const bool varies = share > 0.0 && !entry.course.is_constant();
    change = std::max(change, weigh(entry, share, varies ? share * entry.course.mean(begin, end) : share));
  }
  if (change != Change::none) gather();
  return change;
}

// Left limits at the end, right limits at the start: means over a far shorter time there.
Loads::Instant::Instant(Loads& loads, double time) : loads_(loads) {
  constexpr double shorter = 1e-6;
  const double length = loads.until_ - loads.from_;
  if (loads.follows_ || !(length > 0.0) || !std::isfinite(length)) return;
  const double begin = std::max(loads.from_, time - shorter * length), end = begin + shorter * length;
  for (std::size_t k = 0; k < loads.entries_.size(); ++k) {
    Entry& entry = loads.entries_[k];
    if (!(entry.share > 0.0) || entry.course.is_constant()) continue;
    means_.emplace_back(k, entry.weight);
    entry.weight = entry.share * entry.course.mean(begin, end);
  }
  if (!means_.empty()) loads.gather();
}

Loads::Instant::~Instant() {
  for (const auto& [entry, weight] : means_) loads_.entries_[entry].weight = weight;
  if (!means_.empty()) loads_.gather();
}

Loads::Change Loads::begin_following(double time) {
  follows_ = true;
  return set_time(time);
}

Loads::Change Loads::set_time(double time) {
  time_ = time;
  Change change = Change::none;
  for (Entry& entry : entries_) {
    const double share = entry.from <= time && time < entry.until ? 1.0 : 0.0;
    const bool varies = share > 0.0 && !entry.course.is_constant();
    change = std::max(change, weigh(entry, share, varies ? entry.course.at(time) : share));
  }
  if (change != Change::none) gather();
  return change;
}

double Loads::next_switch(double time) const noexcept {
  double next = std::numeric_limits<double>::infinity();
  for (const Entry& entry : entries_) {
    if (entry.from > time) next = std::min(next, entry.from);
    if (entry.until > time) next = std::min(next, entry.until);
    if (entry.course.is_constant() || time >= entry.until) continue;
    const double kink = entry.course.next_kink(std::max(time, entry.from));
    if (kink < entry.until) next = std::min(next, kink);
  }
  return next;
}

void Loads::set_host_force(std::uint32_t node, const Vector3& force) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (host_[c].empty()) host_[c].assign(node_count_, 0.0);
    host_[c][node] = force[static_cast<Eigen::Index>(c)];
  }
  gather();
}

void Loads::set_factor(std::size_t load, double factor) {
  entries_[load].factor = factor;
  gather();
}

void Loads::gather() {
  for (std::size_t c = 0; c < 3; ++c) {
    if (host_[c].empty())
      total_[c].assign(node_count_, 0.0);
    else
      total_[c] = host_[c];
    const auto row = static_cast<Eigen::Index>(c);
    for (const Entry& entry : entries_) {
      const double weight = entry.factor * entry.weight;
      if (weight == 0.0) continue;
      for (const std::uint32_t node : entry.nodes) total_[c][node] += weight * entry.force[row];
      for (const auto& [node, force] : entry.on_faces) total_[c][node] += weight * force[row];
    }
  }
  any_pressure_ = false;
  for (std::size_t load = 0; load < entries_.size(); ++load) {
    pressure_[load] = entries_[load].factor * entries_[load].weight * entries_[load].pressure;
    any_pressure_ = any_pressure_ || pressure_[load] != 0.0;
  }
}

void Loads::take_over(const Loads& before, const layers::NumbersBefore& numbers) {
  gravity_ = before.gravity_;
  for (std::size_t load = 0; load < before.count(); ++load) entries_[load].factor = before.factor(load);
  for (std::size_t c = 0; c < 3 && !before.host_[c].empty(); ++c) {
    host_[c].assign(node_count_, 0.0);
    numbers.for_each_node([&](std::uint32_t k, std::uint32_t old) { host_[c][k] = before.host_[c][old]; });
  }
  faces_changed();
}

void Loads::archive(Archive& archive) {
  archive.vector(gravity_);
  archive.flag(follows_);
  archive.number(time_);
  archive.same(entries_.size(), "loads");
  for (Entry& entry : entries_) {
    archive.number(entry.share);
    archive.number(entry.weight);
    archive.number(entry.factor);
  }
  bool any = !host_[0].empty(), any_total = !total_[0].empty();
  archive.flag(any);
  archive.flag(any_total);
  for (std::vector<double>& component : host_) {
    component.resize(any ? node_count_ : 0);
    archive.numbers(component, "forces of the program");
  }
  if (!archive.reads()) return;
  if (any_total)
    gather();
  else
    for (std::vector<double>& component : total_) component.clear();
}

layers::ExternalForces Loads::external() noexcept {
  layers::ExternalForces external;
  external.gravity = gravity_;
  if (!total_[0].empty()) external.loads = {total_[0].data(), total_[1].data(), total_[2].data()};
  if (any_pressure_) external.pressure = pressure_.data();
  return external;
}

}  // namespace springnet
