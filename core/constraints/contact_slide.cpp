// A node at the end of a step that it spends on a surface, along the edge of two, or at the vertex of three.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "constraints/contact_within.hpp"
#include "constraints/edge.hpp"
#include "constraints/vectors.hpp"

namespace springnet {
namespace {

// A node that keeps slipping whatever the forces; the mobility is isotropic. Friction opposes the slip without
// friction: if that is too little to overcome friction, the slip reverses through zero, so that its end can be located.
// If the slip without friction already points against `kept`, friction opposes `kept`.
ContactResponse solve_slipping(const Matrix3& mobility, const Vector3& relative, const Vector3& n, double friction,
                               const Vector3& kept, double more = 0.0) {
  const double impulse = -n.dot(relative) / n.dot(mobility * n);
  Vector3 all = n * impulse;
  if (impulse > 0.0 && impulse + more > 0.0) {  // a pulling impulse causes no friction
    Vector3 t = relative - n * n.dot(relative);
    const Vector3 before = kept - n * n.dot(kept);
    if (!(t.dot(before) > 0.0) && before.norm() > 0.0) t = before;
    if (t.norm() > 0.0) all -= friction * (impulse + more) * t.normalized();
  }
  return {relative + mobility * all, all, impulse, false};
}

}  // namespace

// Arrivals. In the step in which a node reaches a surface, its outputs are P on the surface and U = (P - p*) / w, the
// velocity that takes it there; the commit stops it. If U were the surface's velocity, the damping forces of so sudden
// a stop could push the node off again, which without them would be behind the surface: then no outputs fit. With this
// U the gap and the reaction of the implicit step are complementary, whatever the damping.
//
// A surface with restitution gives a node its rebound within the step, and so stops within the step what does not
// rebound.
bool Contact::arrives(std::uint32_t node, std::int32_t surface) const {
  return !committed(node).has(surface) && !(obstacles_[static_cast<std::size_t>(surface)].restitution() > 0.0);
}

Contact::Slide Contact::slide_along(const Within& within, std::int32_t surface, const Candidate& made,
                                    const Vector3* normal_at, double rebound) const {
  const springnet_sweep& sweep = within.sweep;
  const Placement& at = within.at;
  const auto j = static_cast<std::size_t>(surface);
  const Obstacle& obstacle = obstacles_[j];
  const Friction& friction = obstacle.friction();
  const double h = sweep.time_constant, theta = theta_of(sweep);
  const bool slips = sweep.contacts != 0 && friction.kind != Friction::Kind::none;
  Candidate candidate = slips && !made.is_isotropic() ? made.isotropic() : made;
  // With friction the surface carries the node and slip adds to that, which is continuous at the transition to
  // sticking. Without friction the tangential motion of the surface does not affect the node.
  const bool is_carried = friction.kind != Friction::Kind::none;
  const Vector3 from = is_carried ? carried(at, candidate.start, surface) : candidate.start;
  // The slip at the start, rotated with the surface.
  const Vector3 slipped = is_carried
                              ? rotated_with(at, surface, candidate.start,
                                             candidate.start_velocity - Contact::velocity(*start_, j, candidate.start))
                              : candidate.start_velocity;
  const bool arriving = h > 0.0 && rebound == 0.0 && arrives(candidate.node, surface);
  const Vector3 free_start = candidate.start + (1.0 - theta) * h * candidate.start_velocity;
  Slide result;
  result.position = onto(at, j, candidate.position);
  bool sticks = false;
  constexpr int max_iterations = 30;
  for (int i = 0; i < max_iterations; ++i) {
    const Vector3 place = normal_at != nullptr ? *normal_at : result.position;
    const Vector3 w = Contact::velocity(at, j, place), n = normal(at, j, place);
    const double off = arriving ? n.dot((result.position - free_start) / (h * theta) - w) : rebound;
    // The impulse that stops the node at the end of the step causes friction in it, too.
    const double landing = arriving ? -mass_[candidate.node] * off : 0.0;
    const auto solve = [&] {
      const Vector3 relative = candidate.velocity - w - off * n;
      return sweep.contacts != 0 ? solve_slipping(candidate.mobility(), relative, n, sliding_coefficient_of(friction),
                                                  slip_[candidate.node], landing)
                                 : solve_contact(candidate.mobility(), relative, n, friction, landing);
    };
    ContactResponse reaction = solve();
    const double pressing = n.dot(reaction.impulse);
    if (reaction.sticks && friction.kind == Friction::Kind::coulomb &&
        cone_margin(friction.coefficient, (1.0 + 1e-12) * pressing + landing,
                    (reaction.impulse - pressing * n).norm()) < 0.0) {
      candidate = candidate.isotropic();
      reaction = solve();
    }
    reaction.velocity += off * n;
    result.normal = reaction.normal;
    result.impulse = reaction.impulse;
    result.slip = reaction.velocity;
    result.velocity = w + reaction.velocity;
    sticks = reaction.sticks;
    const Vector3 last = result.position;
    const Vector3 rate = is_carried ? reaction.velocity : result.velocity;
    if (h > 0.0) result.position = onto(at, j, from + h * ((1.0 - theta) * slipped + theta * rate));
    const bool same = obstacle.is_flat() && !obstacle.turns();
    if (same || (result.position - last).norm() <= 1e-14 * result.position.norm()) break;
  }
  if (arriving) {
    const Vector3 w = Contact::velocity(at, j, result.position), n = normal(at, j, result.position);
    result.lands = true;
    result.landing = result.velocity - n * n.dot(result.velocity - w);
    result.landing_impulse = mass_[candidate.node] * (result.landing - result.velocity);
  }
  result.touch = {surface, !sticks || rebound > 0.0};
  result.weakest = surface;
  result.bounces = rebound > 0.0;
  return result;
}

Vector3 Contact::onto_both(const Placement& at, std::int32_t first, std::int32_t second,
                           const Vector3& position) const {
  const auto a = static_cast<std::size_t>(first), b = static_cast<std::size_t>(second);
  Vector3 p = position;
  constexpr int max_iterations = 20;
  for (int i = 0; i < max_iterations; ++i) {
    Eigen::Matrix<double, 3, 2> n;
    n << normal(at, a, p), normal(at, b, p);
    const Eigen::Matrix2d square = n.transpose() * n;
    if (!(square.determinant() > 1e-12)) break;
    const Vector3 change = n * (square.inverse() * Eigen::Vector2d(gap(at, a, p), gap(at, b, p)));
    p -= change;
    if (change.norm() <= 1e-15 * p.norm()) break;
  }
  return p;
}

Contact::Slide Contact::slide_along_edge(const Within& within, std::int32_t first, std::int32_t second,
                                         const Candidate& made, double rebound) const {
  const springnet_sweep& sweep = within.sweep;
  const Placement& at = within.at;
  const auto a = static_cast<std::size_t>(first), b = static_cast<std::size_t>(second);
  const double h = sweep.time_constant, theta = theta_of(sweep);
  const double rough_a = coefficient_of(obstacles_[a].friction()), rough_b = coefficient_of(obstacles_[b].friction());
  Candidate candidate = made;
  // Along the edge the rougher surface carries the node.
  const std::int32_t rougher = rough_b > rough_a ? second : first;
  const bool is_carried = rough_a > 0.0 || rough_b > 0.0;
  const Vector3 from = is_carried ? carried(at, candidate.start, rougher) : candidate.start;
  const Vector3 slipped =
      is_carried ? rotated_with(at, rougher, candidate.start,
                                candidate.start_velocity -
                                    Contact::velocity(*start_, static_cast<std::size_t>(rougher), candidate.start))
                 : candidate.start_velocity;
  Slide result;
  result.position = onto_both(at, first, second, candidate.position);
  bool sticks = false;
  constexpr int max_iterations = 30;
  for (int i = 0; i < max_iterations; ++i) {
    const Vector3 p = result.position;
    Matrix3 directions;
    directions.row(0) = normal(at, a, p);
    directions.row(1) = normal(at, b, p);
    directions.row(2) = Vector3(directions.row(0)).cross(Vector3(directions.row(1)));
    // Velocity of the edge.
    const Vector3 with = Contact::velocity(at, static_cast<std::size_t>(rougher), p);
    const Vector3 rates(directions.row(0).dot(Contact::velocity(at, a, p)),
                        directions.row(1).dot(Contact::velocity(at, b, p)) + rebound, directions.row(2).dot(with));
    const Vector3 w = directions.row(2).norm() > 1e-6 ? Vector3(directions.inverse() * rates) : with;
    const auto solve = [&] {
      const Vector3* kept = sweep.contacts != 0 ? &slip_[candidate.node] : nullptr;
      return solve_edge(candidate.mobility(), candidate.velocity - w, directions.row(0), directions.row(1), rough_a,
                        rough_b, kept);
    };
    EdgeResponse reaction = solve();
    if (!reaction.fits) {
      candidate = candidate.isotropic();
      reaction = solve();
    }
    result.normal = std::min(reaction.first, reaction.second);
    result.weakest = reaction.first < reaction.second ? first : second;
    result.impulse = reaction.impulse;
    result.slip = reaction.velocity;
    result.velocity = w + reaction.velocity;
    sticks = reaction.sticks;
    const Vector3 rate = is_carried ? reaction.velocity : result.velocity;
    if (h > 0.0) result.position = onto_both(at, first, second, from + h * ((1.0 - theta) * slipped + theta * rate));
    if ((result.position - p).norm() <= 1e-14 * result.position.norm()) break;
  }
  // A node that stays stuck between two surfaces must not drift by rounding.
  if (sticks && committed(made.node).has(first) && committed(made.node).has(second)) result.position = from;
  result.touch = {first, !sticks || rebound > 0.0, second};
  result.bounces = rebound > 0.0;
  return result;
}

Contact::Slide Contact::at_vertex(const Within& within, const Touch& touch, const Candidate& candidate) const {
  const Placement& at = within.at;
  Slide result;
  result.position = candidate.position;
  result.normal = -1.0;
  result.weakest = touch.third;
  result.touch = touch;
  result.slip.setZero();
  Matrix3 normals;
  constexpr int max_iterations = 20;
  for (int i = 0; i < max_iterations; ++i) {
    Vector3 gaps, rates;
    for (Eigen::Index r = 0; r < 3; ++r) {
      const auto j = static_cast<std::size_t>(touch.surfaces()[static_cast<std::size_t>(r)]);
      const Vector3 n = normal(at, j, result.position);
      normals.row(r) = n.transpose();
      gaps[r] = gap(at, j, result.position);
      rates[r] = n.dot(Contact::velocity(at, j, result.position));
    }
    if (!(std::abs(normals.determinant()) > 1e-6)) return result;  // the normals are linearly dependent
    const Vector3 change = normals.inverse() * gaps;
    result.position -= change;
    result.velocity = normals.inverse() * rates;
    if (change.norm() <= 1e-15 * result.position.norm()) break;
  }
  result.impulse = candidate.inertia * (result.velocity - candidate.velocity);
  Eigen::Index least = 0;
  result.normal = Vector3(normals.transpose().inverse() * result.impulse).minCoeff(&least);
  result.weakest = touch.surfaces()[static_cast<std::size_t>(least)];
  return result;
}

Contact::Slide Contact::leave_vertex(const Within& within, const Slide& vertex, const Candidate& candidate) const {
  std::array<std::int32_t, 2> rest{};
  std::size_t count = 0;
  for (const std::int32_t surface : vertex.touch.surfaces())
    if (surface != vertex.weakest && count < 2) rest[count++] = surface;
  return slide_along_edge(within, rest[0], rest[1], candidate);
}

}  // namespace springnet
