#include "learning/event_condition.hpp"

#include <algorithm>
#include <type_traits>

#include "constraints/acceleration_gradients.hpp"
#include "constraints/friction.hpp"
#include "learning/surface_numbers.hpp"

namespace springnet::learning {
namespace {

using EventKind = LocatedEvent::Kind;

class OfNode {
 public:
  OfNode(const Contact& contact, const PlacedTime& at, const LocatedEvent& event, const Vector3& acceleration)
      : contact_(contact), at_(at), event_(event), a_(acceleration), now_(at.placed(at.time)) {}

  [[nodiscard]] std::optional<NodeCondition> found() const {
    const bool on_edge = event_.own.before.second >= 0;
    switch (event_.kind) {
      case EventKind::touch:
        return of_number(surfaces().gap(event_.surface, place()));
      case EventKind::release:
        return of_release();
      case EventKind::slip:
        return on_edge ? std::nullopt : std::optional(of_number(beyond_friction()));
      case EventKind::rest:
        return on_edge ? std::nullopt : std::optional(of_number(dot(constant(event_.own.slip), slip())));
      case EventKind::slow:
      case EventKind::quick:
        return on_edge ? std::nullopt : std::optional(of_number(length(slip())));
      case EventKind::seam:
        return of_seam();
      default:
        return std::nullopt;
    }
  }

 private:
  [[nodiscard]] const Obstacle& surface() const {
    return contact_.obstacles()[static_cast<std::size_t>(event_.surface)];
  }
  [[nodiscard]] SurfaceNumbers surfaces() const { return {contact_, *now_, by_end_time}; }
  // The acceleration has the variables of V.
  [[nodiscard]] Vector place() const { return variable(event_.own.p, by_p); }
  [[nodiscard]] Vector velocity() const { return variable(event_.own.v, by_v); }
  [[nodiscard]] static NodeCondition of_number(const Number& value) {
    NodeCondition result;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      result.by_position[row] = value.derivatives[by_p + i];
      result.by_velocity[row] = value.derivatives[by_v + i];
      result.by_acceleration[row] = value.derivatives[by_free + i];
    }
    result.by_time = value.derivatives[by_end_time];
    result.by_friction = value.derivatives[by_first_friction];
    return result;
  }
  // Of a motion, by time, which has no formula: a central difference, whose error is that of its third derivative.
  template <class Value>
  [[nodiscard]] std::invoke_result_t<Value, const Placement&> by_time(const Value& value) const {
    const double d = at_.shortest;
    const std::shared_ptr<const Placement> after = at_.placed(at_.time + d), before = at_.placed(at_.time - d);
    return (value(*after) - value(*before)) / (2.0 * d);
  }

  // What the surface would have to give a node that sticks, m/s^2: its acceleration without that of the node.
  [[nodiscard]] Vector missing(std::int32_t j) const {
    const auto index = static_cast<std::size_t>(j);
    Changes changes =
        acceleration_by_position(now_->poses[index]) * changes_of(place()) - changes_of(variable(a_, by_free));
    if (contact_.obstacles()[index].moves())
      changes.col(by_end_time) +=
          by_time([&](const Placement& at) { return Vector3(Contact::acceleration(at, index, event_.own.p)); });
    return vector_of(Contact::acceleration(*now_, index, event_.own.p) - a_, changes);
  }
  [[nodiscard]] Number beyond_friction() const {
    const Vector r = missing(event_.surface), n = surfaces().normal(event_.surface, place());
    const Number pressed = dot(n, r);
    return Number::variable(surface().friction().coefficient, by_first_friction) * pressed - length(r - pressed * n);
  }
  [[nodiscard]] Vector slip() const {
    const Vector n = surfaces().normal(event_.surface, place());
    const Vector relative = velocity() - surfaces().velocity(event_.surface, place());
    return relative - dot(n, relative) * n;
  }

  // The acceleration with which the gap to one of the surfaces would open, m/s^2.
  [[nodiscard]] Number opening(std::int32_t j) const {
    if (!event_.own.before.slides) return -dot(surfaces().normal(j, place()), missing(j));
    const auto index = static_cast<std::size_t>(j);
    const AccelerationGradient gradient =
        gap_acceleration_gradient(contact_, *now_, index, event_.own.p, event_.own.v, a_);
    const auto value = [&](const Placement& at) {
      return contact_.normal(at, index, event_.own.p).dot(a_ - Contact::acceleration(at, index, event_.own.p)) +
             contact_.bias_acceleration(at, index, event_.own.p,
                                        event_.own.v - Contact::velocity(at, index, event_.own.p));
    };
    Number result(value(*now_));
    const Vector3 n = contact_.normal(*now_, index, event_.own.p);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      result.derivatives[by_p + i] = gradient.by_position[row];
      result.derivatives[by_v + i] = gradient.by_velocity[row];
      result.derivatives[by_free + i] = n[row];
    }
    if (contact_.obstacles()[index].moves()) result.derivatives[by_end_time] = by_time(value);
    return result;
  }
  [[nodiscard]] std::optional<NodeCondition> of_release() const {
    const Touch& touch = event_.own.before;
    if (touch.second < 0) return of_number(opening(event_.surface));
    if (touch.third >= 0) return std::nullopt;
    // Of two surfaces: forces x with N'N x = -(openings) as if there were no friction.
    for (const std::int32_t j : {touch.surface, touch.second})
      if (touch.slides && coefficient_of(contact_.obstacles()[static_cast<std::size_t>(j)].friction()) > 0.0)
        return std::nullopt;
    const std::int32_t other = touch.surface == event_.surface ? touch.second : touch.surface;
    const Number ab = dot(surfaces().normal(event_.surface, place()), surfaces().normal(other, place()));
    return of_number(opening(event_.surface) - ab * opening(other));
  }

  // Central differences along the axes: the function is smooth on a far greater length.
  [[nodiscard]] NodeCondition of_seam() const {
    constexpr double share = 1e-5;
    const auto index = static_cast<std::size_t>(event_.surface);
    const double d = share * std::min(1.0, surface().inscribed_radius());
    const auto seam = [&](const Placement& at, const Vector3& p) { return surface().seam(at.poses[index], p); };
    NodeCondition result;
    for (Eigen::Index i = 0; i < 3; ++i) {
      const Vector3 way = d * Vector3::Unit(i);
      result.by_position[i] = (seam(*now_, event_.own.p + way) - seam(*now_, event_.own.p - way)) / (2.0 * d);
    }
    if (surface().moves()) result.by_time = by_time([&](const Placement& at) { return seam(at, event_.own.p); });
    return result;
  }

  const Contact& contact_;
  const PlacedTime& at_;
  const LocatedEvent& event_;
  Vector3 a_;
  std::shared_ptr<const Placement> now_;
};

}  // namespace

StartGradient direction_gradient(const Contact& contact, const Placement& start, const LocatedEvent& event,
                                 const Vector3& p, const Vector3& v, const Vector3& slip_at_end) {
  const SurfaceNumbers surfaces(contact, start, by_start_time);
  const Vector place = variable(p, by_p), n = surfaces.normal(event.surface, place);
  const Vector relative = variable(v, by_v) - surfaces.velocity(event.surface, place);
  const Vector slip = relative - dot(n, relative) * n;
  StartGradient result;
  // A slip that begins, or has been about to end before, keeps another direction.
  constexpr double rounding = 1e-9;
  const double speed = value_of(slip).norm();
  if (!(speed > 0.0) || !((value_of(slip) / speed - event.own.slip).norm() <= rounding)) return result;
  const Number value = dot(constant(slip_at_end), slip) / length(slip);
  for (std::size_t i = 0; i < 3; ++i) {
    result.by_position[static_cast<Eigen::Index>(i)] = value.derivatives[by_p + i];
    result.by_velocity[static_cast<Eigen::Index>(i)] = value.derivatives[by_v + i];
  }
  result.by_time = value.derivatives[by_start_time];
  return result;
}

Vector3 slip_of(const Contact& contact, const Placement& at, const LocatedEvent& event) {
  const auto surface = static_cast<std::size_t>(event.surface);
  const Vector3 n = contact.normal(at, surface, event.own.p);
  const Vector3 relative = event.own.v - Contact::velocity(at, surface, event.own.p);
  return relative - n.dot(relative) * n;
}

std::optional<NodeCondition> condition_of(const Contact& contact, const PlacedTime& at, const LocatedEvent& event,
                                          const Vector3& acceleration) {
  return OfNode(contact, at, event, acceleration).found();
}

}  // namespace springnet::learning
