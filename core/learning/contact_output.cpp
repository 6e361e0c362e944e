#include "learning/contact_output.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <springnet/sdk/dual.hpp>

#include "constraints/friction.hpp"
#include "network/invariant_values.hpp"

namespace springnet::learning {

namespace {

// By p, v, V, and by P, on which normals depend.
constexpr std::size_t variables = 12;
using Number = sdk::Dual<variables>;
using Vector = invariants::Triple<Number>;
using Changes = Eigen::Matrix<double, 3, variables>;

[[nodiscard]] Vector3 value_of(const Vector& x) { return {x.x.value, x.y.value, x.z.value}; }
[[nodiscard]] Changes changes_of(const Vector& x) {
  Changes result;
  for (std::size_t k = 0; k < variables; ++k)
    result.col(static_cast<Eigen::Index>(k)) << x.x.derivatives[k], x.y.derivatives[k], x.z.derivatives[k];
  return result;
}
[[nodiscard]] Number number_of(double value, const Eigen::Matrix<double, 1, variables>& changes) {
  Number result(value);
  for (std::size_t k = 0; k < variables; ++k) result.derivatives[k] = changes[static_cast<Eigen::Index>(k)];
  return result;
}
[[nodiscard]] Vector vector_of(const Vector3& value, const Changes& changes) {
  return {number_of(value[0], changes.row(0)), number_of(value[1], changes.row(1)),
          number_of(value[2], changes.row(2))};
}
[[nodiscard]] Vector variable(const Vector3& value, std::size_t first) {
  return {Number::variable(value[0], first), Number::variable(value[1], first + 1),
          Number::variable(value[2], first + 2)};
}
[[nodiscard]] Vector times(double factor, const Vector& x) { return Number(factor) * x; }
[[nodiscard]] Vector times(const Matrix3& matrix, const Vector& x) {
  return vector_of(matrix * value_of(x), matrix * changes_of(x));
}
[[nodiscard]] Number length(const Vector& x) { return sqrt(dot(x, x)); }

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
        p_(variable(node.p, 0)),
        v_(variable(node.v, 3)),
        free_(variable(node.free, 6)),
        end_(variable(node.P, 9)) {}

  [[nodiscard]] std::optional<OutputDerivative> derivative() const {
    const Touch& touch = how_.touch;
    if (touch.third >= 0) return at_vertex();
    if (touch.second >= 0) {
      if (const auto found = matched(along_edge())) return found;
      return touch.slides ? std::nullopt : matched(carried_by(rougher()));
    }
    const bool stayed = !how_.before.slides && how_.before.surface == touch.surface && !touch.slides;
    const bool holds = friction(touch.surface).kind == Friction::Kind::held;
    if (holds && stayed) return matched(carried_by(touch.surface));
    if (holds && !how_.bounces) return matched(where_it_touched());
    if (const auto found = matched(along_surface())) return found;
    return touch.slides ? std::nullopt : matched(carried_by(touch.surface));
  }

 private:
  // ---- a surface at a place, at the end of the step ----
  [[nodiscard]] const Friction& friction(std::int32_t surface) const {
    return contact_.obstacles()[index(surface)].friction();
  }
  [[nodiscard]] Number gap(std::int32_t j, const Vector& x) const {
    const Vector3 place = value_of(x);
    return number_of(contact_.gap(step_.end, index(j), place),
                     contact_.normal(step_.end, index(j), place).transpose() * changes_of(x));
  }
  [[nodiscard]] Vector normal(std::int32_t j, const Vector& x) const {
    const Obstacle& obstacle = contact_.obstacles()[index(j)];
    const Pose& pose = step_.end.poses[index(j)];
    const Vector3 place = value_of(x);
    return vector_of(obstacle.normal(pose, place), obstacle.curvature(pose, place) * changes_of(x));
  }
  [[nodiscard]] Vector onto(std::int32_t j, const Vector& x) const { return x - gap(j, x) * normal(j, x); }
  [[nodiscard]] static Vector velocity(const Placement& at, std::int32_t j, const Vector& x) {
    const Pose& pose = at.poses[index(j)];
    Changes changes = Changes::Zero();
    const Changes own = changes_of(x);
    for (Eigen::Index k = 0; pose.turns && k < own.cols(); ++k) changes.col(k) = pose.spin.cross(Vector3(own.col(k)));
    return vector_of(pose.velocity_at(value_of(x)), changes);
  }
  [[nodiscard]] Matrix3 turned(std::int32_t j) const {
    const Pose &before = step_.start.poses[index(j)], &after = step_.end.poses[index(j)];
    return after.turns ? Matrix3(after.rotation * before.rotation.transpose()) : Matrix3(Matrix3::Identity());
  }
  // See Contact::carried.
  [[nodiscard]] Vector carried(std::int32_t j, const Vector& x) const {
    const Pose &before = step_.start.poses[index(j)], &after = step_.end.poses[index(j)];
    if (!contact_.obstacles()[index(j)].moves()) return x;
    if (!after.turns) return vector_of(value_of(x) + (after.displacement - before.displacement), changes_of(x));
    return vector_of(after.from_start(before.to_start(value_of(x))), turned(j) * changes_of(x));
  }
  [[nodiscard]] std::int32_t rougher() const {
    const Touch& touch = how_.touch;
    return coefficient_of(friction(touch.second)) > coefficient_of(friction(touch.surface)) ? touch.second
                                                                                            : touch.surface;
  }
  // The slip at the start with respect to a surface that carries the node.
  [[nodiscard]] Vector slipped(std::int32_t carrier) const {
    return times(turned(carrier), v_ - velocity(step_.start, carrier, p_));
  }
  [[nodiscard]] Vector moved(const Vector& from, const Vector& rate_before, const Vector& rate) const {
    return from + times(step_.h * (1.0 - step_.theta), rate_before) + times(step_.h * step_.theta, rate);
  }

  // ---- ways to end a step ----
  [[nodiscard]] Output carried_by(std::int32_t surface) const {
    return {carried(surface, p_), velocity(step_.end, surface, end_)};
  }

  // Held where the path of its start velocity meets the surface, see Contact::meet.
  [[nodiscard]] Output where_it_touched() const {
    const std::int32_t j = how_.touch.surface;
    const Obstacle& obstacle = contact_.obstacles()[index(j)];
    const Pose &before = step_.start.poses[index(j)], &after = step_.end.poses[index(j)];
    const Vector end = p_ + times(step_.h, v_);
    const double share = obstacle.first_touch(before, node_.p, after, value_of(end)).value_or(2.0);
    Output result{{}, velocity(step_.end, j, end_)};
    if (!(share > 0.0)) {
      result.position = onto(j, carried(j, p_));
    } else if (share > 1.0) {
      result.position = onto(j, end);
    } else {
      // In the surface's frame the gap vanishes at a + share (b - a).
      const Matrix3 a_turn = before.turns ? Matrix3(before.rotation.transpose()) : Matrix3(Matrix3::Identity());
      const Matrix3 b_turn = after.turns ? Matrix3(after.rotation.transpose()) : Matrix3(Matrix3::Identity());
      const Vector a = vector_of(before.to_start(node_.p), a_turn * changes_of(p_));
      const Vector b = vector_of(after.to_start(value_of(end)), b_turn * changes_of(end));
      const Vector3 way = value_of(b - a), there = value_of(a) + share * way;
      const Vector3 n = b_turn * obstacle.normal(after, after.from_start(there));
      const Changes changes = changes_of(a) + share * changes_of(b - a);
      const Number at = number_of(share, -(n.transpose() * changes) / n.dot(way));
      if (!obstacle.moves()) {
        result.position = p_ + at * (end - p_);
      } else {
        const Vector place = a + at * (b - a);
        result.position = onto(j, vector_of(after.from_start(value_of(place)), b_turn.transpose() * changes_of(place)));
      }
    }
    return result;
  }

  // See Contact::rebound; the node has approached fast enough, or it would not have bounced.
  [[nodiscard]] Number rebound(std::int32_t j) const {
    if (!how_.bounces || how_.before.has(j)) return {};
    const Vector place = onto(j, p_ + times(step_.h, v_));
    return -contact_.obstacles()[index(j)].restitution() * dot(normal(j, place), v_ - velocity(step_.end, j, place));
  }

  // See Contact::slide_along.
  [[nodiscard]] Output along_surface() const {
    const std::int32_t j = how_.touch.surface;
    const Friction& rough = friction(j);
    const bool is_carried = rough.kind != Friction::Kind::none;
    const Vector w = velocity(step_.end, j, end_), n = normal(j, end_);
    const Vector bounce = rebound(j) * n;
    const Vector relative = free_ - w - bounce;
    Vector left;  // relative velocity; none: it sticks
    const Number into = -dot(n, relative);
    if (rough.kind == Friction::Kind::none) {
      left = relative + into * n;
    } else if (rough.kind == Friction::Kind::coulomb) {
      const Vector along = relative + into * n;
      const Number slip = length(along);
      if (!(into.value > 0.0)) {
        left = along;
      } else if (cone_margin(rough.coefficient, into.value, slip.value) < 0.0 && slip.value > 0.0) {
        left = along - (rough.coefficient * into / slip) * along;
      }
    }
    const Vector rate = left + bounce;
    const Vector from = is_carried ? carried(j, p_) : p_, before = is_carried ? slipped(j) : v_;
    return {onto(j, moved(from, before, is_carried ? rate : w + rate)), w + rate};
  }

  // See Contact::slide_along_edge.
  [[nodiscard]] Output along_edge() const {
    const std::int32_t first = how_.touch.surface, second = how_.touch.second, carrier = rougher();
    const double rough[] = {coefficient_of(friction(first)), coefficient_of(friction(second))};
    const Vector a = normal(first, end_), b = normal(second, end_), c = cross(a, b);
    // Velocity of the edge.
    const Number rates[] = {dot(a, velocity(step_.end, first, end_)),
                            dot(b, velocity(step_.end, second, end_)) + rebound(second),
                            dot(c, velocity(step_.end, carrier, end_))};
    const Vector bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
    const Number volume = dot(a, bc);
    const Vector w = (rates[0] / volume) * bc + (rates[1] / volume) * ca + (rates[2] / volume) * ab;
    const Vector relative = free_ - w;
    Vector left;
    if (how_.touch.slides && std::isfinite(rough[0]) && std::isfinite(rough[1])) {
      const Number sine = length(c);
      const Vector e = (1.0 / sine) * c;
      const double along = value_of(e).dot(node_.U - value_of(w)), sign = along < 0.0 ? -1.0 : 1.0;
      const Vector f = a - times(sign * rough[0], e), g = b - times(sign * rough[1], e);
      // Normal impulses x of both: (a b)^T (f g) x = -(a b)^T relative.
      const Number aa = dot(a, f), ag = dot(a, g), bf = dot(b, f), bg = dot(b, g);
      const Number ra = -dot(a, relative), rb = -dot(b, relative), determinant = aa * bg - ag * bf;
      left = relative + ((ra * bg - rb * ag) / determinant) * f + ((rb * aa - ra * bf) / determinant) * g;
    }
    const bool is_carried = rough[0] > 0.0 || rough[1] > 0.0;
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
    return fits ? std::optional<OutputDerivative>(OutputDerivative::Zero()) : std::nullopt;
  }

  // m/s: steps have settled to the tolerance of the integrator only.
  [[nodiscard]] double tolerance() const {
    constexpr double share = 1e-4;
    return share * (node_.v.norm() + node_.U.norm() + (node_.free - node_.v).norm());
  }
  // Positions depend on P by the normals there: dP = change(P) dP + change(p, v, V).
  [[nodiscard]] std::optional<OutputDerivative> matched(const Output& output) const {
    constexpr double rounding = 1e-12;
    const double allowed = tolerance();
    if (!((value_of(output.velocity) - node_.U).norm() <= allowed + rounding) ||
        !((value_of(output.position) - node_.P).norm() <= step_.h * allowed + rounding * node_.P.norm()))
      return std::nullopt;
    const Changes position = changes_of(output.position), velocity = changes_of(output.velocity);
    const Matrix3 own = Matrix3::Identity() - position.rightCols<3>();
    OutputDerivative result;
    result.topRows<3>() = own.inverse() * position.leftCols<9>();
    result.bottomRows<3>() = velocity.leftCols<9>() + velocity.rightCols<3>() * result.topRows<3>();
    return result;
  }

  const Contact& contact_;
  const StepPlacement& step_;
  const StepContact& how_;
  const NodeOverStep& node_;
  Vector p_, v_, free_, end_;
};

}  // namespace

std::optional<OutputDerivative> output_derivative(const Contact& contact, const StepPlacement& step,
                                                  const StepContact& how, const NodeOverStep& node) {
  return NodeOnSurfaces(contact, step, how, node).derivative();
}

}  // namespace springnet::learning
