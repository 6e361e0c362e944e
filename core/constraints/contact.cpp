#include "constraints/contact.hpp"

#include <algorithm>

#include "constraints/island.hpp"
#include "constraints/least_squares.hpp"
#include "constraints/vectors.hpp"

namespace springnet {

Contact::Contact(const Network& network, const std::vector<std::uint32_t>& user_number,
                 const std::vector<std::uint32_t>& engine_number, const std::vector<double>& mass)
    : mass_(mass), prescribed_(network, engine_number) {
  for (const Plane& plane : network.planes()) obstacles_.emplace_back(plane);
  for (const Instrument& instrument : network.instruments()) obstacles_.emplace_back(instrument);
  const std::size_t nodes = user_number.size();
  fixed_.resize(nodes);
  for (std::size_t k = 0; k < nodes; ++k) fixed_[k] = network.nodes()[user_number[k]].fixed ? 1 : 0;
  constrained_ = status_ = fixed_;  // SPRINGNET_PRESCRIBED is 1
  any_fixed_ = std::find(fixed_.begin(), fixed_.end(), 1) != fixed_.end();
  held_.assign(nodes, 0);
  touching_.assign(nodes, 0);
  if (obstacles_.empty()) return;
  committed_.assign(nodes, {});
  now_.assign(nodes, {});
  surface_impulse_.assign(obstacles_.size(), Vector3::Zero());
  changes_.assign(nodes, 0);
  was_in_contact_.assign(nodes, 0);
  slide_changes_.assign(nodes, 0);
  lands_.assign(nodes, 0);
  limited_changes_.assign(nodes, 0);
  landing_.assign(nodes, Vector3::Zero());
  met_.assign(nodes, {});
  bounces_.assign(nodes, 0);
  braced_.assign(nodes, 0);
  slip_phase_.assign(nodes, Slip::ongoing);
  start_gap_.assign(nodes, StartGap{});
  last_surface_.assign(nodes, -1);
  for (auto* vectors : {&slip_, &impulse_, &sweep_impulse_}) vectors->assign(nodes, Vector3::Zero());
}

std::string Contact::name_of(std::size_t surface) const {
  const auto planes = static_cast<std::size_t>(
      std::count_if(obstacles_.begin(), obstacles_.end(), [](const Obstacle& s) { return s.is_plane(); }));
  return obstacles_[surface].description(surface < planes ? surface : surface - planes);
}

std::string Contact::names_of(const std::vector<std::int32_t>& surfaces) const {
  std::string result;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (i > 0) result += i + 1 < surfaces.size() ? ", " : " and ";
    result += name_of(static_cast<std::size_t>(surfaces[i]));
  }
  return result;
}

void Contact::set_trajectory(std::size_t surface, Trajectory trajectory) {
  obstacles_[surface].set_trajectory(std::move(trajectory));
  start_gap_.assign(mass_.size(), StartGap{});
  cached_placement_.reset();
}

void Contact::set_friction(std::size_t surface, double coefficient) {
  obstacles_[surface].set_friction_coefficient(coefficient);
}

void Contact::set_motion(std::uint32_t node, const Vector3& start, Trajectory trajectory) {
  prescribed_.set(node, start, std::move(trajectory));
  cached_placement_.reset();
}

void Contact::stop_motion(std::uint32_t node) {
  prescribed_.stop(node);
  cached_placement_.reset();
}

const std::shared_ptr<const Placement>& Contact::at(const SampleTime& time) const {
  const bool still = obstacles_.empty() && !prescribed_.any();
  if (cached_placement_ && (still || cached_placement_->time == time)) return cached_placement_;
  auto placement = std::make_shared<Placement>();
  placement->time = time;
  placement->poses.reserve(obstacles_.size());
  for (const Obstacle& surface : obstacles_) placement->poses.push_back(surface.at(time));
  placement->motions = prescribed_.at(time);
  cached_placement_ = std::move(placement);
  return cached_placement_;
}

double Contact::next_change(double time) const {
  double next = prescribed_.next_change(time);
  for (const Obstacle& surface : obstacles_) next = std::min(next, surface.next_change(time));
  return next;
}

double Contact::next_change_of_scene(double time) const {
  double next = prescribed_.next_change_of_scene(time);
  for (const Obstacle& surface : obstacles_)
    next = std::min(next, surface.told() ? surface.next_change_of_turn(time) : surface.next_change(time));
  return next;
}

Vector3 Contact::impulse(std::uint32_t node) const { return impulse_.empty() ? Vector3::Zero() : impulse_[node]; }

void Contact::refresh(std::uint32_t node) {
  const Touch& touch = committed(node);
  held_[node] = touch.surface >= 0 && !touch.slides ? 1 : 0;
  touching_[node] = touch.surface >= 0 ? 1 : 0;
  update_status(node);
}

void Contact::update_status(std::uint32_t node) noexcept {
  const Touch& touch = now(node);
  status_[node] = fixed_[node] != 0   ? SPRINGNET_PRESCRIBED
                  : touch.surface < 0 ? SPRINGNET_FREE
                  : touch.slides      ? SPRINGNET_SLIDING
                                      : SPRINGNET_STICKING;
  constrained_[node] = status_[node] == SPRINGNET_PRESCRIBED || status_[node] == SPRINGNET_STICKING ? 1 : 0;
}

void Contact::set_fixed(std::uint32_t node, bool fixed) {
  fixed_[node] = fixed ? 1 : 0;
  any_fixed_ = any_fixed_ || fixed;
  if (fixed) release(node);
  refresh(node);
}

void Contact::touch(std::uint32_t node, const Touch& touch, const Vector3& impulse) {
  committed_[node] = now_[node] = touch;
  impulse_[node] += impulse;
  braced_[node] = 0;
  refresh(node);
}

void Contact::release(std::uint32_t node) {
  if (obstacles_.empty()) return;
  touch(node, {}, Vector3::Zero());
}

void Contact::begin_step(std::shared_ptr<const Placement> start) {
  start_ = std::move(start);
  any_moves_ = std::any_of(obstacles_.begin(), obstacles_.end(), [](const Obstacle& o) { return o.moves(); });
  std::fill(changes_.begin(), changes_.end(), std::uint8_t{0});
  std::fill(slide_changes_.begin(), slide_changes_.end(), std::uint8_t{0});
  std::fill(lands_.begin(), lands_.end(), std::uint8_t{0});
  for (std::vector<std::int32_t>& surfaces : met_) surfaces.clear();
  changed_sweeps_ = 0;
  std::fill(limited_changes_.begin(), limited_changes_.end(), 0);
  for (std::size_t k = 0; k < was_in_contact_.size(); ++k) was_in_contact_[k] = touching_[k];
  discard_sweep();
}

void Contact::discard_sweep() {
  if (obstacles_.empty()) return;
  std::fill(sweep_impulse_.begin(), sweep_impulse_.end(), Vector3::Zero());
  for (std::uint32_t k = 0; k < now_.size(); ++k) {
    if (now(k) == committed(k)) continue;
    now_[k] = committed(k);
    refresh(k);
  }
}

bool Contact::land(const springnet_vectors& velocity) const {
  bool any = false;
  for (std::uint32_t k = 0; k < lands_.size(); ++k) {
    if (lands_[k] == 0 || fixed_[k] != 0 || vector_at(velocity, k) == landing_[k]) continue;
    put_vector(velocity, k, landing_[k]);
    any = true;
  }
  return any;
}

std::vector<ContactChange> Contact::commit_sweep(bool decided) {
  using Kind = ContactChange::Kind;
  std::vector<ContactChange> changes;
  if (obstacles_.empty()) return changes;
  if (decided) std::fill(slip_phase_.begin(), slip_phase_.end(), Slip::ongoing);
  for (std::uint32_t k = 0; k < now_.size() && decided; ++k) {
    const Touch before = committed(k), after = now(k);
    if (fixed_[k] != 0 || before == after) continue;
    bool same = true;
    for (const std::int32_t j : before.surfaces()) {
      if (j < 0 || after.has(j)) continue;
      same = false;
      changes.push_back({Kind::released, k, j});
    }
    for (const std::int32_t j : after.surfaces()) {
      if (j < 0 || before.has(j)) continue;
      changes.push_back({Kind::touched, k, j});
      same = false;
      if (bounces_[k] != 0) changes.push_back({Kind::released, k, j});
    }
    if (same && before.slides != after.slides)
      changes.push_back({after.slides ? Kind::slipped : Kind::stuck, k, after.surface});
    // A bounce releases the new contacts and keeps the old ones.
    Touch kept = after;
    for (const std::int32_t j : after.surfaces())
      if (bounces_[k] != 0 && j >= 0 && !before.has(j)) kept = springnet::after(kept, {ContactCause::Kind::release, j});
    touch(k, kept, Vector3::Zero());
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const ContactChange& a, const ContactChange& b) { return a.kind < b.kind; });
  return changes;
}

void Contact::take_over(const Contact& before, const layers::NumbersBefore& numbers) {
  for (std::size_t j = 0; j < before.obstacles_.size(); ++j) {
    obstacles_[numbers.surface_now[j]] = before.obstacles_[j];
    surface_impulse_[numbers.surface_now[j]] = before.surface_impulse_[j];
  }
  prescribed_.take_over(before.prescribed_, numbers);
  rest_speed_ = before.rest_speed_;
  any_fixed_ = any_fixed_ || before.any_fixed_;
  if (!before.impulse_.empty()) impulse_.resize(mass_.size(), Vector3::Zero());
  numbers.for_each_node([&](std::uint32_t k, std::uint32_t old) {
    fixed_[k] = before.fixed_[old] != 0 || prescribed_.moves(k) ? 1 : 0;
    if (!before.impulse_.empty()) impulse_[k] = before.impulse_[old];
    if (before.obstacles_.empty()) return;
    const auto renumbered = [&](Touch touch) {
      for (std::int32_t* const surface : {&touch.surface, &touch.second, &touch.third})
        *surface = numbers.surface(*surface);
      return touch;
    };
    committed_[k] = renumbered(before.committed_[old]);
    now_[k] = renumbered(before.now_[old]);
    braced_[k] = before.braced_[old];
    slip_phase_[k] = before.slip_phase_[old];
    last_surface_[k] = numbers.surface(before.last_surface_[old]);
    slip_[k] = before.slip_[old];
    sweep_impulse_[k] = before.sweep_impulse_[old];
  });
  cached_placement_.reset();
  start_.reset();
  for (std::uint32_t k = 0; k < fixed_.size(); ++k) refresh(k);
}

void Contact::archive(Archive& archive) {
  archive.same(obstacles_.size(), "surfaces");
  for (Obstacle& each : obstacles_) each.archive(archive);
  prescribed_.archive(archive);
  archive.number(rest_speed_);
  archive.flag(any_fixed_);
  for (std::uint8_t& each : fixed_) {
    bool fixed = each != 0;
    archive.flag(fixed);
    each = fixed ? 1 : 0;
  }
  bool any_impulse = !impulse_.empty();  // of nodes held or moved; with surfaces, of all
  archive.flag(any_impulse);
  if (impulse_.empty() && any_impulse) impulse_.resize(mass_.size(), Vector3::Zero());
  if (any_impulse) archive.vectors(impulse_, "impulses");
  if (!obstacles_.empty()) archive_contacts(archive);
  if (!archive.reads()) return;
  cached_placement_.reset();
  start_.reset();
  for (std::uint32_t k = 0; k < fixed_.size(); ++k) refresh(k);
}

void Contact::archive_contacts(Archive& archive) {
  const std::uint64_t surfaces = obstacles_.size() + 1;
  const auto surface = [&](std::int32_t& number) {
    std::int64_t shifted = std::int64_t{number} + 1;
    archive.below(shifted, surfaces, "a surface");
    number = static_cast<std::int32_t>(shifted - 1);
  };
  for (std::vector<Touch>* touches : {&committed_, &now_}) {
    for (Touch& each : *touches) {
      for (std::int32_t* number : {&each.surface, &each.second, &each.third}) surface(*number);
      archive.flag(each.slides);
      if ((each.surface < 0 && each.second >= 0) || (each.second < 0 && each.third >= 0))
        Archive::refuse("a contact is none");
    }
  }
  archive.numbers(braced_, "contacts");
  for (Slip& each : slip_phase_) archive.below(each, 3, "a phase of slip");
  for (std::int32_t& each : last_surface_) surface(each);
  archive.vectors(slip_, "slips");
  archive.vectors(sweep_impulse_, "impulses");
  archive.vectors(surface_impulse_, "impulses of surfaces");
  if (archive.reads()) start_gap_.assign(mass_.size(), StartGap{});
}

std::vector<Vector3> Contact::normals(const Placement& at, std::uint32_t node, const Vector3& position) const {
  std::vector<Vector3> result;
  for (const std::int32_t surface : now(node).surfaces())
    if (surface >= 0) result.push_back(normal(at, static_cast<std::size_t>(surface), position));
  return result;
}

Vector3 Contact::slip_vector(const Placement& at, std::uint32_t node, std::size_t surface, const Vector3& position,
                             const Vector3& velocity) const {
  const Vector3 relative = velocity - Contact::velocity(at, surface, position);
  if (now(node).second < 0) {
    const Vector3 n = normal(at, surface, position);
    return relative - n * n.dot(relative);
  }
  return split_reaction(normals(at, node, position), relative).tangential;
}

Vector3 Contact::slip_direction(const Placement& at, std::uint32_t node, std::size_t surface, const Vector3& position,
                                const Vector3& velocity) const {
  const Vector3 slip = slip_vector(at, node, surface, position, velocity);
  const double speed = slip.norm();
  if (slip_phase_[node] == Slip::ongoing && speed > 0.5 * rest_speed_) return slip / speed;
  const Vector3 kept = split_reaction(normals(at, node, position), slip_[node]).tangential;
  const double length = kept.norm();
  return length > 0.0 ? Vector3(kept / length) : speed > 0.0 ? Vector3(slip / speed) : Vector3::Zero();
}

// Solves d^2 (gap) / dt^2 = 0 of each surface for the normal forces, with friction proportional to them.
Vector3 Contact::sliding_acceleration(const Placement& at, std::uint32_t node, const Vector3& position,
                                      const Vector3& velocity, const Vector3& acceleration) const {
  const Touch& touch = now(node);
  const auto count = static_cast<Eigen::Index>(touch.count());
  Eigen::Matrix<double, 3, 3> directions;  // of each surface's force at unit normal force
  Eigen::Matrix<double, 3, 3> normals;
  Vector3 wanted;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto j = static_cast<std::size_t>(touch.surfaces()[static_cast<std::size_t>(i)]);
    const Vector3 relative = velocity - Contact::velocity(at, j, position), n = normal(at, j, position);
    normals.col(i) = directions.col(i) = n;
    wanted[i] =
        -(n.dot(acceleration - Contact::acceleration(at, j, position)) + bias_acceleration(at, j, position, relative));
    const double mu = sliding_coefficient_of(obstacles_[j].friction());
    if (mu == 0.0) continue;
    Vector3 against = slip_direction(at, node, j, position, velocity);
    if (count == 1 && slip_phase_[node] == Slip::starting) {
      // Friction opposes the sliding acceleration and only reduces it.
      const Vector3 pushed = acceleration - Contact::acceleration(at, j, position);
      const Vector3 along = pushed - n * n.dot(pushed);
      if (along.norm() > 0.0) against = along.normalized();
    }
    directions.col(i) -= mu * against;
  }
  // A pulling force is left for the caller to detect; it causes no friction.
  if (count == 1) return acceleration + wanted[0] * (wanted[0] > 0.0 ? directions : normals).col(0);
  const auto n = normals.leftCols(count), d = directions.leftCols(count);
  return acceleration + d * least_squares(n.transpose() * d, wanted.head(count));
}

void Contact::update_slip_directions(const Placement& at, const springnet_const_vectors& position,
                                     const springnet_const_vectors& velocity) {
  for (std::uint32_t k = 0; !obstacles_.empty() && k < committed_.size(); ++k) {
    if (!committed(k).slides || slip_phase_[k] != Slip::ongoing) continue;
    const Vector3 slip = slip_vector(at, k, static_cast<std::size_t>(committed(k).surface), vector_at(position, k),
                                     vector_at(velocity, k));
    if (slip.norm() > 2.0 * rest_speed_) slip_[k] = slip.normalized();
  }
}

void Contact::project_sliding(const Placement& at, std::uint32_t node, const springnet_vectors& position,
                              const springnet_vectors& velocity) const {
  const Touch& touch = now(node);
  Vector3 p = vector_at(position, node), v = vector_at(velocity, node);
  if (touch.second < 0) {
    const auto j = static_cast<std::size_t>(touch.surface);
    p = onto(at, j, p);
    const Vector3 n = normal(at, j, p);
    v -= n * n.dot(v - Contact::velocity(at, j, p));
  } else {
    const auto count = static_cast<Eigen::Index>(touch.count());
    Eigen::MatrixXd normals(count, 3);
    Eigen::VectorXd gaps(count), rates(count);
    constexpr int max_iterations = 20;  // planes need one
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
      for (Eigen::Index i = 0; i < count; ++i) {
        const auto j = static_cast<std::size_t>(touch.surfaces()[static_cast<std::size_t>(i)]);
        const Vector3 n = normal(at, j, p);
        normals.row(i) = n.transpose();
        gaps[i] = gap(at, j, p);
        rates[i] = n.dot(v - Contact::velocity(at, j, p));
      }
      const Vector3 change = least_squares(normals, gaps);
      p -= change;
      if (change.norm() <= 1e-15 * p.norm()) break;
    }
    v -= Vector3(least_squares(normals, rates));
  }
  put_vector(position, node, p);
  put_vector(velocity, node, v);
}

void Contact::accelerate(const Placement& at, std::uint32_t first, std::uint32_t count,
                         const springnet_const_vectors& position, const springnet_const_vectors& velocity,
                         double* const acceleration[3], const std::uint32_t* cluster) const {
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t k = first + i;
    const Touch& touch = now(k);
    if (fixed_[k] == 0 && touch.surface < 0) continue;
    Vector3 result = Vector3::Zero();
    if (fixed_[k] != 0) {
      if (prescribed_.moves(k)) result = prescribed_.acceleration(at.motions, k);
    } else if (!touch.slides) {
      result = Contact::acceleration(at, static_cast<std::size_t>(touch.surface), vector_at(position, k));
    } else {
      if (cluster != nullptr && cluster[k] != 0xffffffffu) continue;
      result = sliding_acceleration(at, k, vector_at(position, k), vector_at(velocity, k),
                                    {acceleration[0][i], acceleration[1][i], acceleration[2][i]});
    }
    for (int c = 0; c < 3; ++c) acceleration[c][i] = result[c];
  }
}

}  // namespace springnet
