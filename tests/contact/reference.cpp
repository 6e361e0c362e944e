#include "reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace springnet::testing {
namespace {

constexpr double at_rest = 1e-13;    // m/s: less is rounding
constexpr double young_slip = 1e-8;  // m/s: below, slip that starts has the direction of the sliding acceleration
constexpr double max_step = 0.01;    // s

Shift shift_of(const Motion* motion, double time) {
  Shift shift;
  if (motion == nullptr) return shift;
  if (motion->times.empty()) {
    const double w = 2.0 * std::numbers::pi * motion->frequency;
    const double angle = w * (std::clamp(time, motion->from, motion->until) - motion->from) + motion->phase;
    shift.place = motion->amplitude * (std::sin(angle) - std::sin(motion->phase));
    if (time < motion->from || time >= motion->until) return shift;
    shift.velocity = motion->amplitude * w * std::cos(angle);
    shift.acceleration = -motion->amplitude * w * w * std::sin(angle);
    return shift;
  }
  const auto& times = motion->times;
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  if (next == times.begin()) {
    shift.place = motion->displacements.front();
  } else if (next == times.end()) {
    shift.place = motion->displacements.back();
  } else {
    const auto i = static_cast<std::size_t>(next - times.begin());
    shift.velocity = (motion->displacements[i] - motion->displacements[i - 1]) / (times[i] - times[i - 1]);
    shift.place = motion->displacements[i - 1] + (time - times[i - 1]) * shift.velocity;
  }
  return shift;
}

double factor_of(const Load& load, double time) {
  const double start = std::isfinite(load.from) ? load.from : 0.0;
  const Course& course = load.course;
  if (course.ramp > 0.0) return std::clamp((time - start) / course.ramp, 0.0, 1.0);
  if (course.frequency > 0.0)
    return course.mean +
           course.amplitude * std::sin(2.0 * std::numbers::pi * course.frequency * (time - start) + course.phase);
  return 1.0;
}

double parameter(const std::optional<LawUse>& law, const char* name) {
  if (!law) return 0.0;
  const auto found = law->parameters.find(name);
  return found == law->parameters.end() ? 0.0 : found->second;
}

}  // namespace

Reference::Reference(const Network& net, double tolerance)
    : net_(net), tolerance_(tolerance), slip_ends_(100.0 * tolerance) {
  const auto stops_of = [&](const Motion* motion) {
    if (motion == nullptr) return;
    stops_.insert(stops_.end(), motion->times.begin(), motion->times.end());
    for (const double t : {motion->from, motion->until})
      if (motion->times.empty() && std::isfinite(t)) stops_.push_back(t);
  };
  for (const Plane& plane : net_.planes()) {
    const Motion* motion = plane.motion ? &*plane.motion : nullptr;
    surfaces_.push_back({true, plane.point, plane.point, plane.normal.normalized(), 0.0, plane.friction, motion});
    stops_of(motion);
  }
  for (const Instrument& round : net_.instruments()) {
    const Motion* motion = round.motion ? &*round.motion : nullptr;
    surfaces_.push_back({false, round.first, round.second, Vector3::Zero(), round.radius, round.friction, motion});
    stops_of(motion);
  }
  for (const Load& load : net_.loads())
    for (const double t : {load.from, load.until, load.from + load.course.ramp})
      if (std::isfinite(t)) stops_.push_back(t);
  std::sort(stops_.begin(), stops_.end());
  for (const Node& node : net_.nodes()) now_.push_back({node.position, node.velocity, Vector3::Zero()});
  contacts_.resize(now_.size());
  for (NodeIndex k = 0; k < now_.size(); ++k) respond(k);
}

Reference::Gap Reference::gap(int surface, double time, const Vector3& p, const Vector3& v) const {
  const Surface& s = surfaces_[static_cast<std::size_t>(surface)];
  const Shift shift = shift_of(s.motion, time);
  Gap result{0.0, s.normal, 0, v - shift.velocity, 0.0};
  const Vector3 from = p - s.first - shift.place;
  if (s.plane) {
    result.distance = s.normal.dot(from);
    return result;
  }
  const Vector3 axis = s.second - s.first;
  const double length2 = axis.squaredNorm();
  const double share = length2 > 0.0 ? axis.dot(from) / length2 : 0.0;
  result.piece = share < 0.0 ? -1 : share > 1.0 ? 1 : 0;
  const Vector3 arm = from - std::clamp(share, 0.0, 1.0) * axis;
  const double far = arm.norm();
  result.distance = far - s.radius;
  result.normal = arm / far;
  Vector3 bent = result.relative - result.normal * result.normal.dot(result.relative);
  if (length2 > 0.0 && result.piece == 0) bent -= axis * (axis.dot(bent) / length2);
  result.bending = bent.squaredNorm() / far;
  return result;
}

Vector3 Reference::force(NodeIndex node, double time, const Bodies& bodies) const {
  Vector3 f = net_.nodes()[node].mass * net_.gravity();
  for (const Spring& spring : net_.springs()) {
    if (spring.first != node && spring.second != node) continue;
    const NodeIndex other = spring.first == node ? spring.second : spring.first;
    const Material& material = net_.materials()[spring.material];
    const Vector3 d = bodies[other].p - bodies[node].p;
    const double length = d.norm();
    const double rate = d.dot(bodies[other].v - bodies[node].v) / length;
    f += d / length *
         (parameter(material.spring, "stiffness") * (length - spring.rest_length) +
          parameter(material.viscosity, "damping") * rate);
  }
  for (const Load& load : net_.loads())
    if (time >= load.from && time < load.until)
      for (const NodeIndex k : load.nodes)
        if (k == node) f += factor_of(load, time) * load.force;
  return f;
}

Reference::Push Reference::push(NodeIndex node, double time, const Bodies& bodies) const {
  const Contact& contact = contacts_[node];
  const Surface& surface = surfaces_[static_cast<std::size_t>(contact.surface)];
  const Gap g = gap(contact.surface, time, bodies[node].p, bodies[node].v);
  const double mass = net_.nodes()[node].mass;
  const Vector3 required = mass * shift_of(surface.motion, time).acceleration - force(node, time, bodies);
  const double bending = contact.mode == Mode::sticking ? 0.0 : g.bending;
  Push result{g.normal.dot(required) - mass * bending, Vector3::Zero()};
  const Vector3 holding = required - g.normal * g.normal.dot(required);
  if (contact.mode == Mode::sticking) {
    result.along = holding;
  } else if (surface.friction.kind == Friction::Kind::coulomb) {
    Vector3 slip = g.relative - g.normal * g.normal.dot(g.relative);
    if (contact.starting && slip.norm() < young_slip)
      slip = holding.norm() > 0.0 ? Vector3(-holding) : contact.direction;
    if (slip.norm() > 0.0) result.along = -surface.friction.coefficient * result.normal * slip.normalized();
  }
  return result;
}

Vector3 Reference::reaction_at(NodeIndex node, double time, const Bodies& bodies) const {
  if (contacts_[node].mode == Mode::free) return Vector3::Zero();
  const Push pushed = push(node, time, bodies);
  return pushed.normal * gap(contacts_[node].surface, time, bodies[node].p, bodies[node].v).normal + pushed.along;
}
Vector3 Reference::reaction(NodeIndex node) const { return reaction_at(node, time_, now_); }

Reference::Bodies Reference::rates(double time, const Bodies& bodies) const {
  Bodies result(bodies.size(), {Vector3::Zero(), Vector3::Zero(), Vector3::Zero()});
  for (NodeIndex k = 0; k < bodies.size(); ++k) {
    if (net_.nodes()[k].fixed) continue;
    const Vector3 pushed = reaction_at(k, time, bodies);
    result[k] = {bodies[k].v, (force(k, time, bodies) + pushed) / net_.nodes()[k].mass, pushed};
  }
  return result;
}

// Dormand and Prince, J. Comput. Appl. Math. 6 (1980). error: the greatest difference to the solution of order 4.
Reference::Bodies Reference::stepped(double h, double& error) const {
  static constexpr double c[7] = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1};
  static constexpr double a[7][6] = {{},
                                     {1.0 / 5},
                                     {3.0 / 40, 9.0 / 40},
                                     {44.0 / 45, -56.0 / 15, 32.0 / 9},
                                     {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                                     {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                                     {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
  static constexpr double e[7] = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                  -17253.0 / 339200, 22.0 / 525, -1.0 / 40.0};
  std::array<Bodies, 7> k;
  Bodies y;
  for (std::size_t stage = 0; stage < 7; ++stage) {
    y = now_;
    for (std::size_t j = 0; j < stage; ++j)
      for (std::size_t i = 0; i < y.size(); ++i) {
        y[i].p += h * a[stage][j] * k[j][i].p;
        y[i].v += h * a[stage][j] * k[j][i].v;
        y[i].pushed += h * a[stage][j] * k[j][i].pushed;
      }
    // A jump at the end of the step belongs to what comes after it.
    k[stage] = rates(std::min(time_ + c[stage] * h, std::nextafter(time_ + h, time_)), y);
  }
  error = 0.0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    Vector3 dp = Vector3::Zero(), dv = Vector3::Zero();
    for (std::size_t j = 0; j < 7; ++j) {
      dp += h * e[j] * k[j][i].p;
      dv += h * e[j] * k[j][i].v;
    }
    error = std::max({error, dp.norm(), dv.norm()});
  }
  return y;
}

bool Reference::event_occurred(NodeIndex node, double time, const Bodies& bodies) const {
  if (net_.nodes()[node].fixed) return false;
  const Contact& contact = contacts_[node];
  for (int s = 0; s < static_cast<int>(surfaces_.size()); ++s) {
    if (s == contact.surface) continue;
    const Gap g = gap(s, time, bodies[node].p, bodies[node].v);
    if (g.distance <= 0.0 && g.normal.dot(g.relative) < -at_rest) return true;
  }
  if (contact.mode == Mode::free) return false;
  const Friction& friction = surfaces_[static_cast<std::size_t>(contact.surface)].friction;
  const Push pushed = push(node, time, bodies);
  if (pushed.normal < 0.0) return true;
  if (contact.mode == Mode::sticking)
    return friction.kind == Friction::Kind::coulomb && pushed.along.norm() > friction.coefficient * pushed.normal;
  const Gap g = gap(contact.surface, time, bodies[node].p, bodies[node].v);
  if (g.piece != contact.piece) return true;
  if (friction.kind != Friction::Kind::coulomb) return false;
  const double slip = g.relative.dot(contact.direction);
  return contact.starting ? slip > young_slip : slip <= slip_ends_;
}

// Projects nodes in contact onto their surface: the error of a step is below the tolerance.
void Reference::commit(double time, Bodies&& bodies) {
  time_ = time;
  now_ = std::move(bodies);
  for (NodeIndex k = 0; k < now_.size(); ++k) {
    Contact& contact = contacts_[k];
    if (contact.mode == Mode::free) continue;
    // At a kink of a table the velocity is still that before it.
    const double before = std::nextafter(time_, 0.0);
    const Shift shift = shift_of(surfaces_[static_cast<std::size_t>(contact.surface)].motion, before);
    if (contact.mode == Mode::sticking) {
      now_[k].p = contact.anchor + shift.place;
      now_[k].v = shift.velocity;
      continue;
    }
    Gap g = gap(contact.surface, before, now_[k].p, now_[k].v);
    now_[k].p -= g.distance * g.normal;
    now_[k].v -= g.normal.dot(g.relative) * g.normal;
    const Vector3 slip = g.relative - g.normal * g.normal.dot(g.relative);
    if (!contact.starting && slip.norm() > at_rest && slip.dot(contact.direction) > 0.0)
      contact.direction = slip.normalized();
  }
}

void Reference::advance_to(double time) {
  while (time_ < time) {
    double end = time;
    for (const double stop : stops_)
      if (stop > time_) {
        end = std::min(end, stop);
        break;
      }
    double h = std::min({h_, max_step, end - time_}), error = 0.0;
    Bodies next = stepped(h, error);
    if (error > tolerance_ && h > 1e-13) {
      h_ = h * std::max(0.1, 0.9 * std::pow(tolerance_ / error, 0.2));
      continue;
    }
    const auto any = [&](double at, const Bodies& bodies) {
      for (NodeIndex k = 0; k < bodies.size(); ++k)
        if (event_occurred(k, at, bodies)) return true;
      return false;
    };
    const bool last = h == end - time_;
    if (any(time_ + h, next)) {
      double below = 0.0, ignored = 0.0;
      for (int i = 0; i < 60 && time_ + below < time_ + h; ++i) {
        const double middle = 0.5 * (below + h);
        Bodies at = stepped(middle, ignored);
        if (any(time_ + middle, at)) {
          h = middle;
          next = std::move(at);
        } else {
          below = middle;
        }
      }
      std::vector<NodeIndex> fired;
      for (NodeIndex k = 0; k < next.size(); ++k)
        if (event_occurred(k, time_ + h, next)) fired.push_back(k);
      commit(time_ + h, std::move(next));
      for (const NodeIndex k : fired) respond(k);
      h_ = std::max(1e-9, 0.1 * h);
    } else {
      commit(last ? end : time_ + h, std::move(next));
      h_ = std::max(h_ > h ? h_ : h * std::clamp(0.9 * std::pow(tolerance_ / std::max(error, 1e-300), 0.2), 0.2, 3.0),
                    1e-13);
    }
    if (std::binary_search(stops_.begin(), stops_.end(), time_)) jump();
  }
}

// Updates the contact of a node at an event: a touch, a release, the end or the reversal of a slip, or the passage from
// a capsule's end to its side.
void Reference::respond(NodeIndex node) {
  if (net_.nodes()[node].fixed) return;
  Contact& contact = contacts_[node];
  const bool in_contact = contact.mode != Mode::free;
  const int previous = contact.surface;
  if (in_contact) settle(node);
  for (int s = 0; s < static_cast<int>(surfaces_.size()); ++s) {
    if (s == (in_contact ? previous : contact.surface)) continue;
    const Gap g = gap(s, time_, now_[node].p, now_[node].v);
    const double apart = g.normal.dot(g.relative);
    if (g.distance > 1e-12 || apart > at_rest) continue;
    if (contact.mode != Mode::free) throw std::logic_error("two surfaces at once are beyond this reference");
    if (apart > -at_rest && !presses(node, s)) continue;
    touch(node, s);
  }
}

bool Reference::presses(NodeIndex node, int surface) {
  Contact& contact = contacts_[node];
  const Contact kept = contact;
  contact.mode = Mode::sliding;
  contact.surface = surface;
  const bool answer = push(node, time_, now_).normal > 0.0;
  contact = kept;
  return answer;
}

void Reference::touch(NodeIndex node, int surface) {
  Contact& contact = contacts_[node];
  const Surface& s = surfaces_[static_cast<std::size_t>(surface)];
  const Gap g = gap(surface, time_, now_[node].p, now_[node].v);
  const double mass = net_.nodes()[node].mass, into = std::max(0.0, -g.normal.dot(g.relative));
  const Vector3 along = g.relative - g.normal * g.normal.dot(g.relative);
  Vector3 stopped = Vector3::Zero();  // of the velocity along the surface
  if (s.friction.kind == Friction::Kind::held) stopped = along;
  if (s.friction.kind == Friction::Kind::coulomb && along.norm() > 0.0)
    stopped = along * std::min(1.0, s.friction.coefficient * into / along.norm());
  contact = {Mode::sliding, surface, g.piece, false, along, contact.impulse, Vector3::Zero()};
  contact.direction = along.norm() > 0.0 ? along.normalized() : along;
  const Vector3 change = into * g.normal - stopped;
  now_[node].v += change;
  now_[node].p -= g.distance * g.normal;
  contact.impulse += mass * change;
  if (s.friction.kind == Friction::Kind::held) {
    contact.mode = Mode::sticking;
    contact.anchor = now_[node].p - shift_of(s.motion, time_).place;
  }
  note(Change::touched, node);
  settle(node, true);
}

void Reference::settle(NodeIndex node, bool touching) {
  Contact& contact = contacts_[node];
  const Surface& s = surfaces_[static_cast<std::size_t>(contact.surface)];
  const Gap g = gap(contact.surface, time_, now_[node].p, now_[node].v);
  contact.piece = g.piece;
  const auto stick = [&] {
    contact.mode = Mode::sticking;
    contact.starting = false;
    now_[node].v = shift_of(s.motion, time_).velocity;
    contact.anchor = now_[node].p - shift_of(s.motion, time_).place;
  };
  const bool coulomb = s.friction.kind == Friction::Kind::coulomb;
  const Vector3 slip = g.relative - g.normal * g.normal.dot(g.relative);
  if (contact.mode == Mode::sliding && coulomb) {
    if (contact.starting && slip.norm() > young_slip) {
      contact.starting = false;
      contact.direction = slip.normalized();
    } else if (!contact.starting && slip.dot(contact.direction) <= slip_ends_) {
      stick();
      if (!touching) note(Change::stuck, node);
    }
  }
  const Push pushed = push(node, time_, now_);
  if (pushed.normal < 0.0) {
    contact.mode = Mode::free;
    contact.surface = -1;
    note(Change::released, node);
  } else if (contact.mode == Mode::sticking && coulomb &&
             pushed.along.norm() > s.friction.coefficient * pushed.normal) {
    contact.mode = Mode::sliding;
    contact.starting = true;
    contact.direction = -pushed.along.normalized();
    note(Change::slipped, node);
  }
}

// Where the velocity of a surface or a load jumps: separating contacts end, approaching ones get an impulse.
void Reference::jump() {
  for (NodeIndex k = 0; k < now_.size(); ++k) {
    Contact& contact = contacts_[k];
    if (contact.mode == Mode::free) {
      respond(k);
      continue;
    }
    const int surface = contact.surface;
    const Gap g = gap(surface, time_, now_[k].p, now_[k].v);
    const double apart = g.normal.dot(g.relative);
    const Surface& s = surfaces_[static_cast<std::size_t>(surface)];
    if (apart > at_rest) {
      contact.mode = Mode::free;
      contact.surface = -1;
      note(Change::released, k);
    } else if (apart < -at_rest || (contact.mode == Mode::sticking && g.relative.norm() > at_rest &&
                                    s.friction.kind != Friction::Kind::held)) {
      contact.mode = Mode::free;
      touch(k, surface);
    } else {
      const Vector3 slip = g.relative - apart * g.normal;
      if (contact.mode == Mode::sliding && slip.norm() > at_rest) contact.direction = slip.normalized();
      settle(k);
    }
  }
}

Reference surfaces_of(const Network& net) {
  Network surfaces;
  for (const Plane& plane : net.planes()) surfaces.add_plane(plane);
  for (const Instrument& instrument : net.instruments()) surfaces.add_instrument(instrument);
  return Reference(surfaces);
}

double Reference::time_of(Change change, std::size_t n) const {
  for (const Event& event : events_)
    if (event.change == change && n-- == 0) return event.time;
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace springnet::testing
