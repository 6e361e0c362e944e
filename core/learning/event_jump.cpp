#include "learning/event_jump.hpp"

#include <algorithm>
#include <cmath>

#include "constraints/friction.hpp"
#include "learning/surface_numbers.hpp"

namespace springnet::learning {
namespace {

// Speeds after an event follow from those before to rounding, and to what settling takes for errors of integration.
constexpr double tolerance = 1e-5;
// Places do so, too, to this share of them.
constexpr double rounding_of_place = 1e-9;

// With x(t-) the state that a smooth motion has reached at the time t of an event and x(t+) = r(x(t-), t) the one that
// follows, a change of the motion before, dx at a fixed time, and of the time, dt, give
//
//   dx(t+) = r_x (dx + x'(t-) dt) + r_t dt
//
// at the changed time: r_x is `by_state`, r_t `by_time`. The motion after the event begins there and then, which takes
// x'(t+) dt away again: both together are the saltation matrix (P. C. Mueller, Chaos, Solitons & Fractals 5, 1671,
// 1995). The part of dx + x'(t-) dt is made where the step before is passed, that of x'(t+) dt where the one after it
// is (motion_parts.cpp). Here is r: a touch puts the node on the surface, and the impact and friction set its velocity;
// a node that comes to rest, or leaves, keeps its place. r is the formula of Contact in variables; which branch it took
// is known from what it gave, so that a result of another branch is none.
class Jump {
 public:
  Jump(const Contact& contact, const Placement& at, const LocatedEvent& event, double time_step)
      : contact_(contact),
        event_(event),
        time_step_(time_step),
        surfaces_(contact, at, by_end_time),
        p_(variable(event.own.p, by_p)),
        v_(variable(event.own.v, by_v)) {}

  [[nodiscard]] std::optional<EventJump> found() const {
    const bool changes = !(event_.own.before == event_.own.after) || !(event_.own.v == event_.own.next_v);
    if (event_.kind == LocatedEvent::Kind::touch && changes) return of_touch();
    const Touch& after = event_.own.after;
    // Where it slid it lies on the surface already, up to rounding.
    if (after.surface >= 0 && !after.slides) return matched(p_, surfaces_.velocity(after.surface, p_));
    return matched(p_, v_);
  }

 private:
  [[nodiscard]] std::optional<EventJump> of_touch() const {
    const std::int32_t j = event_.surface;
    const Obstacle& surface = contact_.obstacles()[static_cast<std::size_t>(j)];
    const Touch& after = event_.own.after;
    if (after.has(j) && after.second >= 0) return on_edge();
    const Vector place = surfaces_.onto(j, p_);
    if (after.has(j) && !after.slides) return matched(place, surfaces_.velocity(j, place));
    // The impact is that where the node was found, and the velocity is tangential where it is put.
    for (const double rebound : {0.0, surface.restitution()}) {
      const Vector n = surfaces_.normal(j, p_), w = surfaces_.velocity(j, p_), relative = v_ - w;
      const Number into = -dot(n, relative), push = Number(1.0 + rebound) * into;
      const Vector along = relative + into * n;
      const Number slip = length(along);
      const Vector bounce = (Number(rebound) * into) * n;
      const double mu = surface.friction().kind == Friction::Kind::coulomb ? surface.friction().coefficient : 0.0;
      Vector left = along;
      if (surface.friction().kind == Friction::Kind::held)
        left = Vector{};
      else if (mu > 0.0 && slip.value > 0.0)
        left = mu * push.value < slip.value ? along - (Number::variable(mu, by_first_friction) * push / slip) * along
                                            : Vector{};
      Vector velocity = w + left + bounce;
      if (after.has(j)) {
        const Vector there = surfaces_.normal(j, place);
        velocity = velocity - dot(there, velocity - surfaces_.velocity(j, place)) * there;
      }
      if (const auto result = matched(place, velocity)) return result;
    }
    return std::nullopt;
  }

  // Of two surfaces: it sticks to the edge, or slides along it without friction.
  [[nodiscard]] std::optional<EventJump> on_edge() const {
    const Touch& after = event_.own.after;
    if (after.third >= 0) return std::nullopt;
    const Vector a0 = surfaces_.normal(after.surface, p_), b0 = surfaces_.normal(after.second, p_);
    const Vector place = p_ - pulled(a0, b0, surfaces_.gap(after.surface, p_), surfaces_.gap(after.second, p_));
    if (!after.slides) return matched(place, surfaces_.velocity(after.surface, place));
    const Vector a = surfaces_.normal(after.surface, place), b = surfaces_.normal(after.second, place);
    const Number ra = dot(a, v_ - surfaces_.velocity(after.surface, place)),
                 rb = dot(b, v_ - surfaces_.velocity(after.second, place));
    return matched(place, v_ - pulled(a, b, ra, rb));
  }
  // The shortest vector with these components along two normals.
  [[nodiscard]] static Vector pulled(const Vector& a, const Vector& b, const Number& along_a, const Number& along_b) {
    const Number ab = dot(a, b), determinant = Number(1.0) - ab * ab;
    return ((along_a - ab * along_b) / determinant) * a + ((along_b - ab * along_a) / determinant) * b;
  }

  [[nodiscard]] std::optional<EventJump> matched(const Vector& place, const Vector& velocity) const {
    const double speed = event_.own.v.norm() + event_.own.next_v.norm();
    if (!((value_of(velocity) - event_.own.next_v).norm() <= tolerance * speed)) return std::nullopt;
    if (!((value_of(place) - event_.own.next_p).norm() <=
          tolerance * speed * time_step_ + rounding_of_place * event_.own.p.norm()))
      return std::nullopt;
    const Changes by_place = changes_of(place), by_velocity = changes_of(velocity);
    EventJump result{Eigen::MatrixXd(6, 6), Eigen::VectorXd(6), Eigen::VectorXd(6), {}};
    result.by_state << by_place.leftCols<6>(), by_velocity.leftCols<6>();
    result.by_time << by_place.col(by_end_time), by_velocity.col(by_end_time);
    result.by_friction << by_place.col(by_first_friction), by_velocity.col(by_first_friction);
    return result;
  }

  const Contact& contact_;
  const LocatedEvent& event_;
  double time_step_;
  SurfaceNumbers surfaces_;
  Vector p_, v_;
};

}  // namespace

std::optional<EventJump> jump_of(const Contact& contact, const Placement& at, const LocatedEvent& event,
                                 double time_step) {
  return Jump(contact, at, event, time_step).found();
}

}  // namespace springnet::learning
