#include "constraints/prescribed.hpp"

#include <algorithm>
#include <limits>
#include <map>

namespace springnet {

Prescribed::Prescribed(const Network& network, const std::vector<std::uint32_t>& engine_number)
    : node_count_(engine_number.size()) {
  for (const Move& move : network.moves()) {
    now_.trajectories.emplace_back(move.motion);
    for (const NodeIndex user : move.nodes) {
      now_.motion_of.resize(node_count_, none);
      now_.start.resize(node_count_, Vector3::Zero());
      const std::uint32_t k = engine_number[user];
      now_.motion_of[k] = static_cast<std::uint32_t>(now_.trajectories.size() - 1);
      now_.start[k] = network.nodes()[user].position;
    }
  }
  if (now_.motion_of.empty()) now_.trajectories.clear();  // no motion has a node
  now_.told.assign(now_.trajectories.size(), 0);
}

Prescribed::Samples Prescribed::at(const SampleTime& time) const {
  Samples samples;
  samples.reserve(now_.trajectories.size());
  for (const Trajectory& trajectory : now_.trajectories) samples.push_back(sample(trajectory, time));
  return samples;
}

double Prescribed::typical_speed() const noexcept {
  double speed = 0.0;
  for (const Trajectory& trajectory : now_.trajectories) speed = std::max(speed, trajectory.typical_speed());
  return speed;
}

double Prescribed::next_change(double time) const {
  double next = std::numeric_limits<double>::infinity();
  for (const Trajectory& trajectory : now_.trajectories) next = std::min(next, trajectory.next_change(time));
  return next;
}

double Prescribed::next_change_of_scene(double time) const {
  double next = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < now_.trajectories.size(); ++i)
    if (now_.told[i] == 0) next = std::min(next, now_.trajectories[i].next_change(time));
  return next;
}

void Prescribed::set(std::uint32_t node, const Vector3& start, Trajectory trajectory) {
  change();
  now_.motion_of.resize(node_count_, none);
  now_.start.resize(node_count_, Vector3::Zero());
  // Reuse the slot of the node's last motion: a host may move a node at every frame.
  const std::uint32_t old = now_.motion_of[node];
  const bool alone = old != none && std::count(now_.motion_of.begin(), now_.motion_of.end(), old) == 1;
  if (!alone) {
    now_.motion_of[node] = static_cast<std::uint32_t>(now_.trajectories.size());
    now_.trajectories.emplace_back();
    now_.told.push_back(1);
  }
  now_.told[now_.motion_of[node]] = 1;
  now_.trajectories[now_.motion_of[node]] = std::move(trajectory);
  now_.start[node] = start;
}

void Prescribed::change() {
  if (!of_scene_) of_scene_ = std::make_unique<const Motions>(now_);
}

void Prescribed::take_over(const Prescribed& before, const layers::NumbersBefore& numbers) {
  const Motions& told = before.now_;
  const Motions& scene = before.of_scene_ ? *before.of_scene_ : before.now_;
  const auto motion_of = [](const Motions& motions, std::uint32_t node) {
    return motions.motion_of.empty() ? none : motions.motion_of[node];
  };
  const auto is_new = [&](std::uint32_t k) {
    const std::uint32_t motion = motion_of(now_, k);
    return motion != none && motion >= scene.trajectories.size();
  };
  // The network has the places that nodes have now; other starts belong to what has changed since.
  numbers.for_each_node([&](std::uint32_t k, std::uint32_t old) {
    if (motion_of(now_, k) == none || is_new(k) || now_.start[k] == scene.start[old]) return;
    change();
    now_.start[k] = scene.start[old];
  });
  if (!before.of_scene_) return;
  change();
  now_.motion_of.resize(node_count_, none);
  now_.start.resize(node_count_);
  std::map<std::uint32_t, std::uint32_t> taken;  // [motion before] told ones
  numbers.for_each_node([&](std::uint32_t k, std::uint32_t old) {
    if (is_new(k)) return;
    const std::uint32_t motion = motion_of(told, old);
    now_.motion_of[k] = motion;
    if (motion == none) return;
    now_.start[k] = told.start[old];
    if (told.told[motion] == 0) return;
    const auto [known, is_first] = taken.try_emplace(motion, static_cast<std::uint32_t>(now_.trajectories.size()));
    if (is_first) {
      now_.trajectories.push_back(told.trajectories[motion]);
      now_.told.push_back(1);
    }
    now_.motion_of[k] = known->second;
  });
}

void Prescribed::archive(Archive& archive) {
  bool changed = of_scene_ != nullptr;
  archive.flag(changed);
  if (!changed) {
    if (of_scene_) now_ = *of_scene_;
    of_scene_.reset();
    return;
  }
  if (archive.reads()) {
    change();
    now_ = *of_scene_;
  }
  const std::size_t of_scene = of_scene_->told.size();
  const std::size_t count = archive.count(now_.told.size(), 1, "motions of nodes");
  if (count < of_scene) Archive::refuse("motions of nodes are missing");
  now_.told.resize(count, 1);
  now_.trajectories.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    bool told = now_.told[k] != 0;
    archive.flag(told);
    if (!told && k >= of_scene) Archive::refuse("a motion of a node is not of the scene");
    now_.told[k] = told ? 1 : 0;
    if (told) now_.trajectories[k].archive(archive);
  }
  now_.motion_of.resize(node_count_, none);
  now_.start.resize(node_count_, Vector3::Zero());
  for (std::uint32_t& motion : now_.motion_of) {
    archive.number(motion);
    if (motion != none && motion >= count) Archive::refuse("the motion of a node does not exist");
  }
  for (Vector3& each : now_.start) archive.vector(each);
}

void Prescribed::stop(std::uint32_t node) {
  if (!moves(node)) return;
  change();
  now_.motion_of[node] = none;
}

}  // namespace springnet
