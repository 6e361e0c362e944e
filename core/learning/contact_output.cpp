#include "learning/contact_output.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "constraints/acceleration_gradients.hpp"
#include "constraints/friction.hpp"
#include "learning/surface_numbers.hpp"

namespace springnet::learning {

namespace {

struct Output {
  Vector position, velocity;
};

[[nodiscard]] std::size_t index(std::int32_t surface) { return static_cast<std::size_t>(surface); }

class NodeOnSurfaces {
 public:
  NodeOnSurfaces(const Contact& contact, const StepPlacement& step, const StepContact& how, const NodeOverStep& node)
      : contact_(contact),
        step_(step),
        how_(how),
        node_(node),
        at_start_(contact, step.start, by_start_time),
        at_end_(contact, step.end, by_end_time),
        h_(step.h),
        p_(variable(node.p, by_p)),
        v_(variable(node.v, by_v)),
        free_(variable(node.free, by_free)),
        end_(variable(node.P, by_end)) {
    h_.derivatives[by_start_time] = -1.0;
    h_.derivatives[by_end_time] = 1.0;
  }

  [[nodiscard]] std::optional<OutputDerivative> derivative() const {
    const Touch& touch = how_.touch;
    if (how_.kept && !touch.slides) return matched(carried_by(touch.surface));
    if (touch.third >= 0) return at_vertex();
    if (touch.second >= 0) {
      if (const auto found = matched(along_edge())) return found;
      return touch.slides ? std::nullopt : matched(carried_by(rougher()));
    }
    const bool stayed = !how_.before.slides && how_.before.surface == touch.surface && !touch.slides;
    const bool holds = friction(touch.surface).kind == Friction::Kind::held;
    if (holds && stayed) return matched(carried_by(touch.surface));
    if (holds && !how_.bounces) return matched(where_it_touched());
    if (const auto found = matched(nearer_along_surface())) return found;
    return touch.slides ? std::nullopt : matched(carried_by(touch.surface));
  }

 private:
  // ---- a surface at a place, at the end of the step ----
  [[nodiscard]] const Friction& friction(std::int32_t surface) const {
    return contact_.obstacles()[index(surface)].friction();
  }
  // Its coefficient as a variable, of one of the first two surfaces that the node touches.
  [[nodiscard]] Number coefficient(std::int32_t surface) const {
    return Number::variable(coefficient_of(friction(surface)),
                            surface == how_.touch.surface ? by_first_friction : by_second_friction);
  }
  [[nodiscard]] Number gap(std::int32_t j, const Vector& x) const { return at_end_.gap(j, x); }
  [[nodiscard]] Vector normal(std::int32_t j, const Vector& x) const { return at_end_.normal(j, x); }
  [[nodiscard]] Vector onto(std::int32_t j, const Vector& x) const { return at_end_.onto(j, x); }
  [[nodiscard]] Matrix3 turned(std::int32_t j) const {
    const Pose &before = step_.start.poses[index(j)], &after = step_.end.poses[index(j)];
    return after.turns ? Matrix3(after.rotation * before.rotation.transpose()) : Matrix3(Matrix3::Identity());
  }
  // A vector at a node, turned with the surface over the step.
  [[nodiscard]] Vector turned(std::int32_t j, const Vector& x) const {
    const Pose &before = step_.start.poses[index(j)], &after = step_.end.poses[index(j)];
    if (!after.turns) return x;
    const Matrix3 turn = turned(j);
    const Vector3 start = value_of(x), end = turn * start;
    Changes changes = turn * changes_of(x);
    changes.col(by_end_time) += after.spin.cross(end);
    changes.col(by_start_time) -= turn * before.spin.cross(start);
    return vector_of(end, changes);
  }
  // See Contact::carried.
  [[nodiscard]] Vector carried(std::int32_t j, const Vector& x) const {
    const Pose &before = step_.start.poses[index(j)], &after = step_.end.poses[index(j)];
    if (!contact_.obstacles()[index(j)].moves()) return x;
    const Vector3 start = value_of(x), end = after.turns ? after.from_start(before.to_start(start))
                                                         : start + (after.displacement - before.displacement);
    const Matrix3 turn = turned(j);
    Changes changes = turn * changes_of(x);
    changes.col(by_end_time) += after.velocity_at(end);
    changes.col(by_start_time) -= turn * before.velocity_at(start);
    return vector_of(end, changes);
  }
  [[nodiscard]] std::int32_t rougher() const {
    const Touch& touch = how_.touch;
    return coefficient_of(friction(touch.second)) > coefficient_of(friction(touch.surface)) ? touch.second
                                                                                            : touch.surface;
  }
  // The slip at the start with respect to a surface that carries the node.
  [[nodiscard]] Vector slipped(std::int32_t carrier) const {
    return turned(carrier, v_ - at_start_.velocity(carrier, p_));
  }
  [[nodiscard]] Vector moved(const Vector& from, const Vector& rate_before, const Vector& rate) const {
    return from + ((1.0 - step_.theta) * h_) * rate_before + (step_.theta * h_) * rate;
  }

  // From where nodes go that nothing accelerates to P.
  [[nodiscard]] Vector way() const { return end_ - p_ - ((1.0 - step_.theta) * h_) * v_; }

  // ---- ways to end a step ----
  [[nodiscard]] Output carried_by(std::int32_t surface) const {
    return {carried(surface, p_), at_end_.velocity(surface, end_)};
  }

  // Held where the path of its start velocity meets the surface, see Contact::meet.
  [[nodiscard]] Output where_it_touched() const {
    const std::int32_t j = how_.touch.surface;
    const Obstacle& obstacle = contact_.obstacles()[index(j)];
    const Pose &before = step_.start.poses[index(j)], &after = step_.end.poses[index(j)];
    const Vector end = p_ + h_ * v_;
    const double share = obstacle.first_touch(before, node_.p, after, value_of(end)).value_or(2.0);
    Output result{{}, at_end_.velocity(j, end_)};
    if (!(share > 0.0)) {
      result.position = onto(j, carried(j, p_));
    } else if (share > 1.0) {
      result.position = onto(j, end);
    } else {
      // In the surface's frame the gap vanishes at a + share (b - a).
      const Matrix3 a_turn = before.turns ? Matrix3(before.rotation.transpose()) : Matrix3(Matrix3::Identity());
      const Matrix3 b_turn = after.turns ? Matrix3(after.rotation.transpose()) : Matrix3(Matrix3::Identity());
      Changes by_a = a_turn * changes_of(p_), by_b = b_turn * changes_of(end);
      by_a.col(by_start_time) -= a_turn * before.velocity_at(node_.p);
      by_b.col(by_end_time) -= b_turn * after.velocity_at(value_of(end));
      const Vector a = vector_of(before.to_start(node_.p), by_a), b = vector_of(after.to_start(value_of(end)), by_b);
      const Vector3 way = value_of(b - a), there = value_of(a) + share * way;
      const Vector3 n = b_turn * obstacle.normal(after, after.from_start(there));
      const Changes changes = changes_of(a) + share * changes_of(b - a);
      const Number at = number_of(share, -(n.transpose() * changes) / n.dot(way));
      if (!obstacle.moves()) {
        result.position = p_ + at * (end - p_);
      } else {
        const Vector place = a + at * (b - a);
        const Vector3 met = after.from_start(value_of(place));
        Changes by_place = b_turn.transpose() * changes_of(place);
        by_place.col(by_end_time) += after.velocity_at(met);
        result.position = onto(j, vector_of(met, by_place));
      }
    }
    return result;
  }

  // See Contact::rebound; the node has approached fast enough, or it would not have bounced.
  [[nodiscard]] Number rebound(std::int32_t j) const {
    if (!how_.bounces || how_.before.has(j)) return {};
    const Vector place = onto(j, p_ + h_ * v_);
    return -contact_.obstacles()[index(j)].restitution() * dot(normal(j, place), v_ - at_end_.velocity(j, place));
  }

  [[nodiscard]] double mismatch(const Output& output) const {
    return (value_of(output.velocity) - node_.U).norm() + (value_of(output.position) - node_.P).norm() / step_.h;
  }
  // Next to the cone of friction a step that is not settled exactly may stick where its V would slip.
  [[nodiscard]] Output nearer_along_surface() const {
    const Output output = along_surface(false);
    if (how_.touch.slides || friction(how_.touch.surface).kind != Friction::Kind::coulomb) return output;
    const Output stuck = along_surface(true);
    return mismatch(stuck) < mismatch(output) ? stuck : output;
  }
  // See Contact::slide_along. sticks: whatever V is.
  [[nodiscard]] Output along_surface(bool sticks) const {
    const std::int32_t j = how_.touch.surface;
    const Friction& own = friction(j);
    const bool is_carried = own.kind != Friction::Kind::none;
    const Vector w = at_end_.velocity(j, end_), n = normal(j, end_);
    const Number off = how_.arrives ? dot(n, (1.0 / (step_.theta * h_)) * way() - w) : rebound(j);
    const Vector bounce = off * n;
    const Vector relative = free_ - w - bounce;
    Vector left;  // relative velocity; none: it sticks
    const Number into = -dot(n, relative);
    // With what stops the node at the end.
    const Number pressing = how_.arrives ? into - off : into;
    if (own.kind == Friction::Kind::none) {
      left = relative + into * n;
    } else if (own.kind == Friction::Kind::coulomb && how_.kept) {
      left = slips_on(relative, n, w);
    } else if (own.kind == Friction::Kind::coulomb && !sticks) {
      const Vector along = relative + into * n;
      const Number slip = length(along);
      if (!(into.value > 0.0 && pressing.value > 0.0)) {
        left = along;
      } else if (cone_margin(own.coefficient, pressing.value, slip.value) < 0.0 && slip.value > 0.0) {
        left = along - (coefficient(j) * pressing / slip) * along;
      }
    }
    const Vector rate = left + bounce;
    const Vector from = is_carried ? carried(j, p_) : p_, before = is_carried ? slipped(j) : v_;
    return {onto(j, moved(from, before, is_carried ? rate : w + rate)), w + rate};
  }

  // A slip that is kept passes through zero: where friction would reverse it, friction has the direction that the slip
  // had, and that the output shows.
  [[nodiscard]] Vector slips_on(const Vector& relative, const Vector& n, const Vector& w) const {
    const Number into = -dot(n, relative), limit = coefficient(how_.touch.surface) * into;
    const Vector along = relative + into * n;
    if (!(into.value > 0.0)) return along;
    const Number slip = length(along);
    const Vector3 takes = value_of(along) - (node_.U - value_of(w));
    const Vector against = slip.value > 0.0 ? (1.0 / slip) * along : Vector{};
    const bool reverses = !(takes.dot(value_of(against)) > 0.5 * takes.norm());
    return along - limit * (reverses && takes.norm() > 0.0 ? constant(takes.normalized()) : against);
  }

  // See Contact::slide_along_edge.
  [[nodiscard]] Output along_edge() const {
    const std::int32_t first = how_.touch.surface, second = how_.touch.second, carrier = rougher();
    const double coefficients[] = {coefficient_of(friction(first)), coefficient_of(friction(second))};
    const Vector a = normal(first, end_), b = normal(second, end_), c = cross(a, b);
    // Velocity of the edge.
    const Number rates[] = {dot(a, at_end_.velocity(first, end_)),
                            dot(b, at_end_.velocity(second, end_)) + rebound(second),
                            dot(c, at_end_.velocity(carrier, end_))};
    const Vector bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
    const Number volume = dot(a, bc);
    const Vector w = (rates[0] / volume) * bc + (rates[1] / volume) * ca + (rates[2] / volume) * ab;
    const Vector relative = free_ - w;
    Vector left;
    if (how_.touch.slides && std::isfinite(coefficients[0]) && std::isfinite(coefficients[1])) {
      const Number sine = length(c);
      const Vector e = (1.0 / sine) * c;
      const double along = value_of(e).dot(node_.U - value_of(w)), sign = along < 0.0 ? -1.0 : 1.0;
      const Vector f = a - (sign * coefficient(first)) * e, g = b - (sign * coefficient(second)) * e;
      // Normal impulses x of both: (a b)^T (f g) x = -(a b)^T relative.
      const Number aa = dot(a, f), ag = dot(a, g), bf = dot(b, f), bg = dot(b, g);
      const Number ra = -dot(a, relative), rb = -dot(b, relative), determinant = aa * bg - ag * bf;
      left = relative + ((ra * bg - rb * ag) / determinant) * f + ((rb * aa - ra * bf) / determinant) * g;
    }
    const bool is_carried = coefficients[0] > 0.0 || coefficients[1] > 0.0;
    const Vector from = is_carried ? carried(carrier, p_) : p_, before = is_carried ? slipped(carrier) : v_;
    return {onto_both(first, second, moved(from, before, is_carried ? left : w + left)), w + left};
  }
  // See Contact::onto_both.
  [[nodiscard]] Vector onto_both(std::int32_t first, std::int32_t second, Vector x) const {
    constexpr int most = 20;
    for (int i = 0; i < most; ++i) {
      const Vector a = normal(first, x), b = normal(second, x);
      const Number ga = gap(first, x), gb = gap(second, x), aa = dot(a, a), ab = dot(a, b), bb = dot(b, b);
      const Number determinant = aa * bb - ab * ab;
      if (!(determinant.value > 1e-12)) break;
      const Vector change = ((ga * bb - gb * ab) / determinant) * a + ((gb * aa - ga * ab) / determinant) * b;
      x = x - change;
      if (value_of(change).norm() <= 1e-15 * value_of(x).norm() && changes_of(change).norm() <= 1e-14) break;
    }
    return x;
  }

  // Three surfaces leave nothing that could change.
  [[nodiscard]] std::optional<OutputDerivative> at_vertex() const {
    const auto surfaces = how_.touch.surfaces();
    const bool fits = std::all_of(surfaces.begin(), surfaces.end(), [&](std::int32_t j) {
      return std::abs(contact_.gap(step_.end, index(j), node_.P)) <= tolerance() * step_.h + 1e-10 * node_.P.norm();
    });
    if (!fits) return std::nullopt;
    OutputDerivative result;
    result.has_times = std::none_of(surfaces.begin(), surfaces.end(),
                                    [&](std::int32_t j) { return contact_.obstacles()[index(j)].moves(); });
    return result;
  }

  // m/s: steps have settled to the tolerance of the integrator only.
  [[nodiscard]] double tolerance() const {
    constexpr double share = 1e-4;
    return share * (node_.v.norm() + node_.U.norm() + (node_.free - node_.v).norm()) + node_.unsettled;
  }
  // Positions depend on P by the normals there: dP = change(P) dP + change(p, v, V).
  [[nodiscard]] std::optional<OutputDerivative> matched(const Output& output) const {
    constexpr double rounding = 1e-12;
    const double allowed = tolerance();
    if (!((value_of(output.velocity) - node_.U).norm() <= allowed + rounding) ||
        !((value_of(output.position) - node_.P).norm() <= step_.h * allowed + rounding * node_.P.norm()))
      return std::nullopt;
    const Changes position = changes_of(output.position), velocity = changes_of(output.velocity);
    const Matrix3 own = Matrix3::Identity() - position.middleCols<3>(by_end);
    const Matrix3 by_place = own.inverse(), turns = velocity.middleCols<3>(by_end);
    OutputDerivative result;
    result.by_state.topRows<3>() = by_place * position.leftCols<9>();
    result.by_state.bottomRows<3>() = velocity.leftCols<9>() + turns * result.by_state.topRows<3>();
    result.by_times.topRows<3>() = by_place * position.middleCols<2>(by_start_time);
    result.by_times.bottomRows<3>() = velocity.middleCols<2>(by_start_time) + turns * result.by_times.topRows<3>();
    result.by_friction.topRows<3>() = by_place * position.middleCols<2>(by_first_friction);
    result.by_friction.bottomRows<3>() =
        velocity.middleCols<2>(by_first_friction) + turns * result.by_friction.topRows<3>();
    return result;
  }

  const Contact& contact_;
  const StepPlacement& step_;
  const StepContact& how_;
  const NodeOverStep& node_;
  SurfaceNumbers at_start_, at_end_;
  Number h_;  // s
  Vector p_, v_, free_, end_;
};

}  // namespace

bool arrives(const Contact& contact, const StepContact& how) {
  const Touch& touch = how.touch;
  if (how.kept || touch.count() != 1 || how.before.has(touch.surface)) return false;
  const Obstacle& obstacle = contact.obstacles()[index(touch.surface)];
  return obstacle.friction().kind != Friction::Kind::held && !(obstacle.restitution() > 0.0);
}

// With the surface's velocity w, U = U_in - n (n . (U_in - w)).
Arrival arrival_of(const Contact& contact, const StepPlacement& step, const StepContact& how,
                   const NodeOverStep& node) {
  const std::size_t j = index(how.touch.surface);
  const Pose& pose = step.end.poses[j];
  const Vector3 n = contact.normal(step.end, j, node.P), w = Contact::velocity(step.end, j, node.P);
  const double weight = step.theta * step.h;
  const Vector3 way = node.P - node.p - (1.0 - step.theta) * step.h * node.v;
  const double off = n.dot(way / weight - w);
  const Vector3 velocity = node.U + n * off, relative = velocity - w;
  const Matrix3 turns = contact.obstacles()[j].curvature(pose, node.P), along = n * n.transpose();
  return {how.node, velocity, along * velocity_by_position(pose) - turns * off - n * relative.transpose() * turns,
          Matrix3::Identity() - along};
}

std::optional<OutputDerivative> output_derivative(const Contact& contact, const StepPlacement& step,
                                                  const StepContact& how, const NodeOverStep& node) {
  return NodeOnSurfaces(contact, step, how, node).derivative();
}

}  // namespace springnet::learning
