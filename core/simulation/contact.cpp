#include "simulation/contact.hpp"

#include <algorithm>

#include "simulation/vectors.hpp"

namespace springnet {

Contact::Contact(const Network& network, const std::vector<std::uint32_t>& user_number,
                 const std::vector<std::uint32_t>& engine_number, const std::vector<double>& mass)
    : mass_(mass), prescribed_(network, engine_number) {
  for (const Plane& plane : network.planes()) surfaces_.emplace_back(plane);
  for (const Instrument& instrument : network.instruments()) surfaces_.emplace_back(instrument);
  placement_.resize(surfaces_.size());
  start_placement_.resize(surfaces_.size());
  const std::size_t nodes = user_number.size();
  fixed_.resize(nodes);
  for (std::size_t k = 0; k < nodes; ++k) fixed_[k] = network.nodes()[user_number[k]].fixed ? 1 : 0;
  constrained_ = fixed_;
  held_.assign(nodes, 0);
  touching_.assign(nodes, 0);
  committed_.assign(nodes, {});
  now_.assign(nodes, {});
  if (surfaces_.empty()) return;
  changes_.assign(nodes, 0);
  stayed_.assign(nodes, 0);
  last_surface_.assign(nodes, -1);
  for (auto* vectors : {&slip_, &impulse_, &sweep_impulse_}) vectors->assign(nodes, Vector3::Zero());
}

bool Contact::any_holds() const noexcept {
  return std::any_of(surfaces_.begin(), surfaces_.end(),
                     [](const Surface& surface) { return surface.friction().kind == Friction::Kind::held; });
}

std::string Contact::name_of(std::size_t surface) const {
  const auto planes = static_cast<std::size_t>(
      std::count_if(surfaces_.begin(), surfaces_.end(), [](const Surface& s) { return s.is_plane(); }));
  return surfaces_[surface].description(surface < planes ? surface : surface - planes);
}

void Contact::set_trajectory(std::size_t surface, Trajectory trajectory) {
  surfaces_[surface].set_trajectory(std::move(trajectory));
  time_.time = std::numeric_limits<double>::quiet_NaN();
}

void Contact::set_time(const SampleTime& time) {
  prescribed_.set_time(time);
  if (time == time_) return;
  time_ = time;
  for (std::size_t j = 0; j < surfaces_.size(); ++j) placement_[j] = sample(surfaces_[j].trajectory(), time);
}

double Contact::next_change(double time) const {
  double next = prescribed_.next_change(time);
  for (const Surface& surface : surfaces_) next = std::min(next, surface.trajectory().next_change(time));
  return next;
}

Vector3 Contact::impulse(std::uint32_t node) const { return impulse_.empty() ? Vector3::Zero() : impulse_[node]; }

double Contact::turning(std::size_t surface, const Vector3& position, const Vector3& relative) const {
  if (surfaces_[surface].is_plane()) return 0.0;
  return relative.dot(surfaces_[surface].curvature(position - placement_[surface].displacement) * relative);
}

Vector3 Contact::onto(std::size_t surface, const Vector3& position) const {
  return position - distance(surface, position) * normal(surface, position);
}

void Contact::refresh(std::uint32_t node) {
  held_[node] = committed_[node].surface >= 0 && !committed_[node].slides ? 1 : 0;
  touching_[node] = committed_[node].surface >= 0 ? 1 : 0;
  constrained_[node] = fixed_[node] | static_cast<std::uint8_t>(now_[node].surface >= 0 && !now_[node].slides ? 1 : 0);
}

void Contact::set_fixed(std::uint32_t node, bool fixed) {
  fixed_[node] = fixed ? 1 : 0;
  if (fixed) release(node);
  refresh(node);
}

void Contact::touch(std::uint32_t node, const Touch& touch, const Vector3& impulse) {
  committed_[node] = now_[node] = touch;
  impulse_[node] += impulse;
  refresh(node);
}

void Contact::release(std::uint32_t node) {
  if (surfaces_.empty()) return;
  touch(node, {}, Vector3::Zero());
}

void Contact::begin_step() {
  start_placement_ = placement_;
  std::fill(changes_.begin(), changes_.end(), std::uint8_t{0});
  for (std::size_t k = 0; k < stayed_.size(); ++k) stayed_[k] = touching_[k];
  forget_sweep();
}

void Contact::forget_sweep() {
  if (surfaces_.empty()) return;
  for (std::uint32_t k = 0; k < now_.size(); ++k) {
    if (now_[k] == committed_[k]) continue;
    now_[k] = committed_[k];
    refresh(k);
  }
}

void Contact::commit_sweep(ContactChanges& changes) {
  if (surfaces_.empty()) return;
  for (std::uint32_t k = 0; k < now_.size(); ++k) {
    const Touch before = committed_[k], after = now_[k];
    if (fixed_[k] != 0 || before == after) continue;
    if (before.surface == after.surface) {
      (after.slides ? changes.slipped : changes.stuck).push_back(k);
    } else {
      if (before.surface >= 0) changes.released.push_back(k);
      if (after.surface >= 0) changes.touched.push_back(k);
    }
    touch(k, after, before.surface != after.surface && after.surface >= 0 ? sweep_impulse_[k] : Vector3::Zero());
  }
}

Vector3 Contact::slip_vector(std::uint32_t node, const Vector3& normal, const Vector3& relative) const {
  // At rest, and from there on until the slip is more than rounding: the direction in which it began.
  const Vector3 kept = slip_[node] - normal * normal.dot(slip_[node]);
  return relative - normal * normal.dot(relative) + 0.1 * rest_speed_ * kept;
}

Vector3 Contact::slip_direction(std::uint32_t node, const Vector3& normal, const Vector3& relative) const {
  const Vector3 slip = slip_vector(node, normal, relative);
  const double length = slip.norm();
  return length > 0.0 ? Vector3(slip / length) : Vector3::Zero();
}

void Contact::note_slips(const springnet_const_vectors& position, const springnet_const_vectors& velocity) {
  for (std::uint32_t k = 0; !surfaces_.empty() && k < committed_.size(); ++k) {
    if (!committed_[k].slides) continue;
    const auto j = static_cast<std::size_t>(committed_[k].surface);
    const Vector3 n = normal(j, vector_at(position, k)), relative = vector_at(velocity, k) - placement_[j].velocity;
    const Vector3 along = relative - n * n.dot(relative);
    if (along.norm() > 2.0 * rest_speed_) slip_[k] = along.normalized();
  }
}

void Contact::accelerate(std::uint32_t first, std::uint32_t count, const springnet_const_vectors& position,
                         const springnet_const_vectors& velocity, double* const acceleration[3],
                         const std::uint32_t* cluster) const {
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t k = first + i;
    const Touch& touch = now_[k];
    if (fixed_[k] == 0 && touch.surface < 0) continue;
    Vector3 result = Vector3::Zero();
    if (fixed_[k] != 0) {
      if (prescribed_.moves(k)) result = prescribed_.acceleration(k);
    } else if (!touch.slides) {
      result = placement_[static_cast<std::size_t>(touch.surface)].acceleration;
    } else {
      if (cluster != nullptr && cluster[k] != 0xffffffffu) continue;
      const auto j = static_cast<std::size_t>(touch.surface);
      const Vector3 p = vector_at(position, k), relative = vector_at(velocity, k) - placement_[j].velocity;
      result = {acceleration[0][i], acceleration[1][i], acceleration[2][i]};
      const Vector3 n = normal(j, p);
      // d^2 (distance) / dt^2 = 0; the force for that is the normal force, and friction a share of it.
      const double pressing = -(n.dot(result - placement_[j].acceleration) + turning(j, p, relative));
      result += pressing * n;
      if (surfaces_[j].friction().kind == Friction::Kind::coulomb && pressing > 0.0)
        result -= surfaces_[j].friction().coefficient * pressing * slip_direction(k, n, relative);
    }
    for (int c = 0; c < 3; ++c) acceleration[c][i] = result[c];
  }
}

}  // namespace springnet
