// How contacts change, and what impulses and forces of surfaces do to nodes that hang together, each against a closed
// form.
#include <cmath>
#include <limits>
#include <numbers>

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "constraints/contact_state.hpp"
#include "constraints/friction.hpp"
#include "constraints/island.hpp"

using namespace springnet;

namespace {

// Closed forms with a few operations on numbers of order 1.
constexpr double rounding = 1e-13;

ContactNode on_floor(const Vector3& velocity, const Friction& friction) {
  ContactNode node;
  ContactSide side;
  side.surface = 0;
  side.friction = friction;
  side.velocity = velocity;
  node.sides.push_back(side);
  node.acceleration = {0, 0, -1};
  return node;
}
constexpr Friction held{Friction::Kind::held, 0.0};
Friction coulomb(double coefficient) { return {Friction::Kind::coulomb, coefficient}; }

// The lower end of two equal masses (1 kg) on a rod that rises by `angle` towards +x: D = I - d d^T / 2.
Eigen::MatrixXd end_of_rod(double angle) {
  const Vector3 d(std::cos(angle), 0, std::sin(angle));
  return Matrix3(Matrix3::Identity() - 0.5 * d * d.transpose());
}

}  // namespace

TEST_CASE("a contact continues with the obstacles that remain") {
  using Kind = ContactCause::Kind;
  Touch touch;
  CHECK(status_of(touch) == ContactStatus::free);
  touch = after(touch, {Kind::touch, 4, false});
  CHECK(touch == Touch{4, true});
  CHECK(status_of(touch) == ContactStatus::sliding);
  touch = after(touch, {Kind::touch, 4, true});  // a second time
  CHECK(touch == Touch{4, true});
  touch = after(touch, {Kind::stick});
  CHECK(status_of(touch) == ContactStatus::sticking);
  touch = after(touch, {Kind::touch, 2, false});
  touch = after(touch, {Kind::touch, 7, false});
  CHECK(touch == Touch{4, true, 2, 7});
  CHECK(status_of(touch) == ContactStatus::cornered);
  CHECK(after(touch, {Kind::touch, 9, false}) == touch);
  CHECK(after(touch, {Kind::release, 9}) == touch);
  CHECK(after(touch, {Kind::release, 4}) == Touch{2, true, 7});
  CHECK(after(touch, {Kind::release, 2}) == Touch{4, true, 7});
  CHECK(after(touch, {Kind::release, 7}) == Touch{4, true, 2});
  CHECK(after(after(touch, {Kind::release, 4}), {Kind::release, 2}) == Touch{7, true});
  CHECK(after(Touch{3, true}, {Kind::release, 3}) == Touch{});
  CHECK(after(Touch{}, {Kind::slip}) == Touch{});
  CHECK(after(Touch{}, {Kind::stick}) == Touch{});
}

TEST_CASE("a reaction is split into normal forces and a part tangential to all obstacles") {
  const SplitReaction one = split_reaction({Vector3::UnitZ()}, {1, 2, 3});
  CHECK(one.normal[0] == 3.0);
  CHECK(one.tangential == Vector3(1, 2, 0));
  // Two walls at 60 degrees: 2 and 5 N and 7 N along their edge.
  const Vector3 a(0, 0, 1), b(std::sqrt(0.75), 0, 0.5);
  const SplitReaction two = split_reaction({a, b}, 2 * a + 5 * b + 7 * Vector3::UnitY());
  CHECK(two.normal[0] == doctest::Approx(2).epsilon(rounding));
  CHECK(two.normal[1] == doctest::Approx(5).epsilon(rounding));
  CHECK((two.tangential - 7 * Vector3::UnitY()).norm() <= rounding);
}

TEST_CASE("the cone of friction has one edge") {
  CHECK(cone_margin(0.5, 10, 5) == 0.0);
  CHECK(cone_margin(0.5, 10, 5.1) < 0.0);  // 2 % beyond
  CHECK(cone_margin(0.5, 10, 4.9) > 0.0);
  CHECK(cone_margin(std::numeric_limits<double>::infinity(), 0.0, 1e9) > 0.0);
  CHECK(cone_margin(std::numeric_limits<double>::infinity(), -1e-9, 1.0) < 0.0);
}

TEST_CASE("the derivative of friction is that of its differences") {
  const Vector3 n = Vector3(1, 2, 3).normalized();
  const Vector3 slip = Vector3(0.3, -0.9, 0.5) - n * n.dot(Vector3(0.3, -0.9, 0.5));
  const auto force = [&](const Vector3& v) {
    const Vector3 along = v - n * n.dot(v);
    return Vector3(-4.0 * along.normalized());
  };
  const Matrix3 derivative = friction_by_velocity(4.0, slip, n);
  constexpr double step = 1e-6;  // step^2 and rounding / step
  for (int c = 0; c < 3; ++c) {
    const Vector3 d = step * Vector3::Unit(c);
    CHECK((derivative.col(c) - (force(slip + d) - force(slip - d)) / (2 * step)).norm() <= 1e-9);
  }
}

TEST_CASE("a lone node that strikes: Newton's restitution, Coulomb's impulse") {
  // 2 kg, down at 3 m/s, along at 1 m/s: the normal impulse is m v (1 + e), friction mu times that, or what stops it.
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const double mu : {0.0, 0.1, 0.2}) {
      ContactNode node = on_floor({1, 0, -3}, coulomb(mu));
      node.sides[0].restitution = e;
      Island island({node}, Matrix3(Matrix3::Identity() / 2));
      CHECK(island.apply_impact(1e-6));
      const ContactNode& struck = island.nodes()[0];
      const double normal = 2 * 3 * (1 + e), along = std::min(mu * normal, 2.0);
      CHECK((struck.impulse[0] - Vector3(-along, 0, normal)).norm() <= rounding * normal);
      CHECK((struck.sides[0].velocity - Vector3(1 - along / 2, 0, 3 * e)).norm() <= rounding * 3);
    }
  }
  // Too slow to rebound.
  ContactNode slow = on_floor({0, 0, -1e-7}, frictionless);
  slow.sides[0].restitution = 1.0;
  Island island({slow}, Matrix3::Identity());
  CHECK(island.apply_impact(1e-6));
  CHECK(island.nodes()[0].sides[0].velocity == Vector3::Zero());
  // What moves off is not struck.
  Island leaving({on_floor({1, 0, 0.1}, held)}, Matrix3::Identity());
  CHECK_FALSE(leaving.apply_impact(1e-6));
  // What rounding leaves of a velocity is no impact, and one that strikes with another that does not approach is left
  // alone.
  Island resting({on_floor({1, 0, -1e-17}, frictionless)}, Matrix3::Identity());
  CHECK_FALSE(resting.apply_impact(1e-6, 1e-13));
  Island both({on_floor({1, 0, -1e-17}, frictionless), on_floor({0, 0, -1}, frictionless)},
              Eigen::MatrixXd::Identity(6, 6));
  CHECK(both.apply_impact(1e-6, 1e-13));
  CHECK(both.nodes()[0].impulse[0] == Vector3::Zero());
  CHECK(both.nodes()[1].impulse[0] == Vector3(0, 0, 1));
}

TEST_CASE("a rod that strikes with one end has the impulse of its effective mass") {
  const double angle = 0.6, s = std::sin(angle);
  Island island({on_floor({0, 0, -1}, frictionless)}, end_of_rod(angle));
  CHECK(island.apply_impact(1e-6));
  CHECK(island.nodes()[0].impulse[0].z() == doctest::Approx(1 / (1 - 0.5 * s * s)).epsilon(rounding));
}

TEST_CASE("a rod that stands on one end: normal force, and the friction that it takes to stick") {
  // Both masses fall at 1 m/s^2 if nothing supports them. Frictionless N = 1 / D_zz; stuck f = D^-1 (0, 0, 1), which is
  // (c s, 0, 1 + s^2).
  const double angle = 0.6, s = std::sin(angle), c = std::cos(angle);
  Island smooth_rod({on_floor(Vector3::Zero(), frictionless)}, end_of_rod(angle));
  CHECK(smooth_rod.resolve(1e-12));
  CHECK(smooth_rod.nodes()[0].normal_force[0] == doctest::Approx(1 / (1 - 0.5 * s * s)).epsilon(rounding));
  const double needed = c * s / (1 + s * s);
  for (const double mu : {1.001 * needed, 0.999 * needed}) {
    ContactNode node = on_floor(Vector3::Zero(), coulomb(mu));
    node.sticks = true;
    Island rod({node}, end_of_rod(angle));
    CHECK(rod.resolve(1e-12));
    CHECK(rod.nodes()[0].sticks == (mu > needed));
    if (mu > needed) {
      CHECK((rod.nodes()[0].force - Vector3(c * s, 0, 1 + s * s)).norm() <= rounding);
    } else {
      // It slips against its friction, away from where it leans to.
      CHECK((rod.nodes()[0].slip + Vector3::UnitX()).norm() <= rounding);
      CHECK(rod.acceleration(0).x() < 0.0);
      CHECK(std::abs(rod.acceleration(0).z()) <= rounding);
    }
  }
}

TEST_CASE("where no finite force exists a rod jams") {
  // D_zz - mu |D_xz| < 0: sliding so that friction presses it in (Painlevé). mu > (2 - s^2) / (c s) = 3 at 45 degrees.
  for (const double mu : {2.9, 3.1}) {
    ContactNode node = on_floor({-1, 0, 0}, coulomb(mu));
    node.slipping = true;
    node.slip = -Vector3::UnitX();
    Island rod({node}, end_of_rod(std::numbers::pi / 4));
    const bool finite = rod.resolve(1e-12);
    // In which direction friction presses in is a matter of the angle's sign.
    ContactNode mirrored = on_floor({1, 0, 0}, coulomb(mu));
    mirrored.slipping = true;
    mirrored.slip = Vector3::UnitX();
    Island other({mirrored}, end_of_rod(std::numbers::pi / 4));
    const bool other_finite = other.resolve(1e-12);
    CHECK((finite && other_finite) == (mu < 3.0));
    Island& jammed = finite ? other : rod;
    if (mu < 3.0) continue;
    CHECK(jammed.jam(1e-9));
    CHECK(jammed.nodes()[0].sides[0].velocity == Vector3::Zero());
    const Vector3 impulse = jammed.nodes()[0].impulse[0];
    CHECK(impulse.z() > 0.0);
    CHECK(std::hypot(impulse.x(), impulse.y()) <= mu * impulse.z());
    CHECK(jammed.resolve(1e-12));
    CHECK(jammed.nodes()[0].sticks);
  }
}

TEST_CASE("a node between two planes: each bears its share, and the edge is free") {
  // A V of 90 degrees, its edge inclined so that gravity has 1 across and 0.25 along.
  const Vector3 a = Vector3(1, 0, 1).normalized(), b = Vector3(-1, 0, 1).normalized();
  for (const double mu : {0.0, 0.1, 0.5}) {
    ContactNode node;
    for (const Vector3& n : {a, b}) {
      ContactSide side;
      side.surface = n == a ? 0 : 1;
      side.normal = n;
      side.friction = coulomb(mu);
      node.sides.push_back(side);
    }
    node.acceleration = {0, 0.25, -1};
    node.sticks = mu > 0.0;
    Island island({node}, Matrix3::Identity());
    CHECK(island.resolve(1e-12));
    const double pressing = std::sqrt(0.5);
    CHECK(island.nodes()[0].normal_force[0] == doctest::Approx(pressing).epsilon(rounding));
    CHECK(island.nodes()[0].normal_force[1] == doctest::Approx(pressing).epsilon(rounding));
    const double limit = mu * 2 * pressing;
    CHECK((island.acceleration(0) - Vector3(0, std::max(0.0, 0.25 - limit), 0)).norm() <= rounding);
    CHECK(island.nodes()[0].sticks == (limit > 0.25));
  }
}

TEST_CASE("lifted nodes are released, and pressed nodes are held") {
  ContactNode lifted = on_floor(Vector3::Zero(), held);
  lifted.acceleration = {0, 0, 1};
  lifted.sticks = true;
  Island up({lifted}, Matrix3::Identity());
  CHECK(up.resolve(1e-12));
  CHECK_FALSE(up.nodes()[0].sides[0].active);
  ContactNode lying = on_floor(Vector3::Zero(), held);
  lying.sides[0].active = false;
  lying.acceleration = {5, 0, -1};
  Island down({lying}, Matrix3::Identity());
  CHECK(down.resolve(1e-12));
  CHECK(down.nodes()[0].sides[0].active);
  CHECK(down.nodes()[0].sticks);
  CHECK((down.nodes()[0].force - Vector3(-5, 0, 1)).norm() <= rounding);
}

TEST_CASE("a contact that would pull but cannot separate is braced by its rigid body") {
  // A rod along x, its ends held on the two sides of a roof; together they are pulled to -x, and each down. The
  // forces of least norm share the pull equally: more than the load on the left end. Released, it would penetrate.
  const double c = std::sqrt(0.5);
  std::vector<ContactNode> nodes;
  for (const double side : {-1.0, 1.0}) {
    ContactNode node = on_floor(Vector3::Zero(), coulomb(friction_of_held));
    node.sides[0].normal = {side * c, 0, c};
    node.acceleration = {-5, 0, -1};
    node.sticks = true;
    nodes.push_back(node);
  }
  Eigen::MatrixXd mobility = Eigen::MatrixXd::Identity(6, 6);
  mobility(0, 0) = mobility(3, 3) = mobility(0, 3) = mobility(3, 0) = 0.5;
  Island island(nodes, mobility);
  REQUIRE(island.resolve(1e-12));
  CHECK(island.nodes()[0].braced);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(island.nodes()[i].sticks);
    CHECK(island.nodes()[i].normal_force[0] > 0.0);
    CHECK(island.acceleration(i).norm() <= 10.0 * rounding);
  }
  CHECK((island.nodes()[0].force + island.nodes()[1].force - Vector3(10, 0, 2)).norm() <= 100.0 * rounding);
}

TEST_CASE("impulses that end a slip leave gaps as they are") {
  ContactNode node = on_floor({0.3, -0.4, 0}, coulomb(0.5));
  node.slip_ended = true;
  Island island({node}, end_of_rod(0.4));
  CHECK(island.end_slip(1e-12));
  CHECK(island.nodes()[0].sides[0].velocity.norm() <= rounding);
  CHECK((end_of_rod(0.4) * island.nodes()[0].impulse[0] + Vector3(0.3, -0.4, 0)).norm() <= rounding);
}

namespace {

// Two pairs that share a node of 1 kg, whose other nodes weigh 1 kg.
Eigen::MatrixXd sharing() {
  Eigen::MatrixXd result = 2.0 * Eigen::MatrixXd::Identity(6, 6);
  result.topRightCorner(3, 3) = result.bottomLeftCorner(3, 3) = -Matrix3::Identity();
  return result;
}

ContactNode pair_of(std::int32_t place, const Vector3& velocity, const Vector3& acceleration, double friction) {
  ContactNode node;
  node.pair = place;
  node.acceleration = acceleration;
  ContactSide side;
  side.velocity = velocity;
  side.friction = coulomb(friction);
  side.separating = velocity[2] > 0.0;
  side.active = !side.separating;
  node.sides = {side};
  return node;
}

}  // namespace

TEST_CASE("bodies part, and friction of those that part is none, where another pair's slip ends") {
  ContactNode ends = pair_of(0, {1e-3, 0, 0}, Vector3::Zero(), 0.5);
  ends.slip_ended = true;
  for (const double parts : {1.0, 0.0}) {
    CAPTURE(parts);
    Island island({ends, pair_of(1, {0, 0, parts}, Vector3::Zero(), 0.1)}, sharing());
    CHECK(island.end_slip(1e-9));
    CHECK(island.nodes()[0].sides[0].velocity.norm() <= rounding);
    // One that touches sticks: the smallest impulses that keep it there.
    const Vector3& impulse = island.nodes()[1].impulse[0];
    if (parts > 0.0)
      CHECK(impulse.isZero(0.0));
    else
      CHECK(island.nodes()[1].sides[0].velocity.norm() <= rounding);
    CHECK((parts > 0.0) == impulse.isZero(0.0));
  }
}

TEST_CASE("an impulse that pulled is not made up for when slow separations end") {
  Island island({pair_of(0, {0, 0, 1e-6}, Vector3::Zero(), 0.0)}, Eigen::MatrixXd::Identity(3, 3));
  island.nodes()[0].impulse[0] = Vector3(0, 0, -1.0);
  island.end_rocking(1e-3, false);
  // It may neither pull more, nor push to make up for what pulled.
  CHECK((island.nodes()[0].impulse[0] - Vector3(0, 0, -1.0)).norm() <= rounding);
  CHECK(std::abs(island.nodes()[0].sides[0].velocity[2]) <= 1e-6 + rounding);
}

TEST_CASE("short slips end, those that were there before only if they creep") {
  // Friction 0.5 of a normal force of 10 N slows 1 kg by 5 m/s^2: 1e-6 m/s ends within 1e-13 m.
  for (const bool slid : {false, true})
    for (const double slow : {1e-9, 1e-5}) {
      ContactNode slips = pair_of(0, {1e-6, 0, 0}, {0, 0, -10}, 0.5);
      slips.slid = slid;
      slips.slipping = true;
      slips.slip = Vector3::UnitX();
      Island island({slips}, Eigen::MatrixXd::Identity(3, 3));
      REQUIRE(island.resolve(rounding));
      const bool ends = !slid || slow > 1e-6;
      CHECK(island.end_short_slips(1e-12, true, slow, 1e-12) == ends);
      CHECK(island.nodes()[0].sides[0].velocity.norm() == doctest::Approx(ends ? 0.0 : 1e-6));
    }
}

TEST_CASE("a separation that comes back at once ends, others do not") {
  const Vector3 falls(0, 0, -10), opens(0, 0, 5);
  const double depth = 1e-8;
  const double least = std::sqrt(2.0 * 10.0 * depth);
  for (const double share : {0.99, 1.01}) {
    Island island({pair_of(0, {0, 0, share * least}, falls, 0.0)}, Eigen::MatrixXd::Identity(3, 3));
    REQUIRE(island.resolve(rounding));
    island.nodes()[0].sides[0].separating = true;
    CHECK(island.end_returns(depth) == (share < 1.0));
    CHECK(island.nodes()[0].sides[0].velocity[2] == doctest::Approx(share < 1.0 ? 0.0 : share * least));
  }
  // One that forces open is not pulled, though it shares a node.
  Island beside({pair_of(0, Vector3::Zero(), opens, 0.0), pair_of(1, {0, 0, 0.5 * least}, falls, 0.0)}, sharing());
  REQUIRE(beside.resolve(rounding));
  REQUIRE(!beside.nodes()[0].sides[0].active);
  CHECK(beside.end_returns(depth));
  CHECK(beside.nodes()[0].impulse[0].isZero(0.0));
  CHECK(std::abs(beside.nodes()[1].sides[0].velocity[2]) <= rounding);
  // Impulses that are lost beside those of much lighter nodes are told.
  Eigen::MatrixXd unequal = Eigen::MatrixXd::Identity(6, 6);
  unequal.topLeftCorner(3, 3) *= 1e10;
  Island lost({pair_of(0, Vector3::Zero(), falls, 0.0), pair_of(1, {0, 0, 0.5 * least}, falls, 0.0)}, unequal);
  REQUIRE(lost.resolve(rounding));
  CHECK(!lost.end_returns(depth));
}

TEST_CASE("where a pair comes back, a node sticks to the surface that it is on, not to one that it leaves") {
  // On a belt, away from a wall that stands still.
  ContactNode node;
  ContactSide wall, belt;
  wall.normal = Vector3::UnitX();
  wall.velocity = Vector3(0.5, 0, 0);
  wall.separating = true;
  wall.active = false;
  belt.normal = Vector3::UnitZ();
  belt.friction = wall.friction = coulomb(0.5);
  node.sides = {wall, belt};
  node.acceleration = Vector3(0, 0, -10);
  node.sticks = true;
  Island island({node, pair_of(0, {0, 0, 1e-6}, {0, 0, -10}, 0.0)}, Eigen::MatrixXd::Identity(6, 6));
  REQUIRE(island.resolve(rounding));
  CHECK(island.end_returns(1e-8));
  CHECK(island.nodes()[0].impulse[0].isZero(0.0));
  CHECK(island.nodes()[0].impulse[1].norm() <= rounding);
  CHECK(island.nodes()[0].sides[0].velocity[0] == 0.5);
}

TEST_CASE("the vector of least norm that makes all components nonnegative") {
  Eigen::MatrixXd matrix(2, 2);
  matrix << 1, 1, 0, -1;
  const auto x = min_norm_nonnegative(Eigen::Vector2d(-2, 0.5), matrix);
  REQUIRE(x.has_value());
  CHECK((*x - Eigen::Vector2d(1.5, 0.5)).norm() <= 1e-11);
  CHECK_FALSE(min_norm_nonnegative(Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, -1)).has_value());
}

// A force of 1 N normal and (2, 0) N tangential to a surface: x times (1, 0, 0) more, until friction of 1/2 holds it.
TEST_CASE("the bracing of least norm puts a force on the boundary of its cone") {
  Eigen::VectorXd base(3);
  base << 1, 2, 0;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(3, 1);
  matrix(0, 0) = 1.0;
  const auto across = min_norm_in_cones(base, matrix, {{0.5, 0.0}});
  REQUIRE(across.has_value());
  CHECK(std::abs((*across)[0] - 3.0) <= 1e-8);  // and a billionth as a margin for rounding
  // Oblique: (1 + x)^2 = 4 ((2 - x)^2 + 1/4) is left where 3 x^2 - 18 x + 16 = 0.
  base << 1, 2, 0.5;
  matrix << 1, -1, 0;
  const auto oblique = min_norm_in_cones(base, matrix, {{0.5, 0.0}});
  REQUIRE(oblique.has_value());
  CHECK(((base + matrix * *oblique).tail<2>().norm() - 0.5 * (base + matrix * *oblique)[0]) <= 1e-8);
  CHECK(std::abs((*oblique)[0] - (18.0 - std::sqrt(132.0)) / 6.0) <= 1e-7);
  matrix << 0, 0, 1;
  CHECK_FALSE(min_norm_in_cones(base, matrix, {{0.5, 0.0}}).has_value());
}

// With friction of 1e4 the surface would have to pull to hold it, and without the surface it penetrates: it slips, with
// hardly any normal force.
TEST_CASE("a contact that can neither stick nor separate slips") {
  Eigen::MatrixXd mobility(3, 3);
  mobility << 1.158093325, -0.2675637631, 1.176231253, -0.2675637631, 0.665681599, -0.6441033705, 1.176231253,
      -0.6441033705, 2.846256427;
  ContactNode node = on_floor(Vector3::Zero(), coulomb(1e4));
  node.acceleration = {-0.524965, 6.35319, -4.37325};
  node.sticks = true;
  Island island({node}, mobility);
  CHECK(island.resolve(1e-9));
  const ContactNode& found = island.nodes()[0];
  CHECK_FALSE(found.sticks);
  CHECK(found.normal_force[0] > 0.0);
  const Vector3 acceleration = island.acceleration(0);
  CHECK(std::abs(acceleration.z()) <= 1e-11);
  CHECK(acceleration.dot(found.slip) > 0.0);
  CHECK(acceleration.cross(found.slip).norm() <= 1e-9);
  CHECK((found.force + 1e4 * found.normal_force[0] * found.slip - found.normal_force[0] * Vector3::UnitZ()).norm() <=
        1e-11);
}

TEST_CASE("the direction is found at which the rate of turning vanishes") {
  const Vector3 n = Vector3::UnitZ(), expected(0.6, 0.8, 0);
  const auto found = find_direction(n, Vector3::UnitX(), [&](const Vector3& t) { return n.dot(t.cross(expected)); });
  REQUIRE(found.has_value());
  CHECK((*found - expected).norm() <= rounding);
  CHECK_FALSE(find_direction(n, Vector3::UnitX(), [](const Vector3&) { return 1.0; }).has_value());
}

TEST_CASE("impulses over a step end approach within the cone, for all contacts at once") {
  // In an island of impulses accelerations stand for velocities. A lone node of 2 kg: as solve_contact has it.
  for (const double mu : {0.1, 0.9}) {
    ContactNode node = on_floor(Vector3::Zero(), coulomb(mu));
    node.acceleration = {0.3, -0.4, -1.0};
    node.sticks = true;
    Island lone({node}, 0.5 * Matrix3::Identity());
    REQUIRE(lone.resolve_impulses(1e-12));
    const ContactResponse answer = solve_contact(0.5 * Matrix3::Identity(), node.acceleration, {0, 0, 1}, coulomb(mu));
    CHECK((lone.nodes()[0].force - answer.impulse).norm() <= rounding);
    CHECK(lone.nodes()[0].sticks == answer.sticks);
  }
  // One that rises is let go, unless it pinned.
  ContactNode rising = on_floor(Vector3::Zero(), frictionless);
  rising.acceleration = {0, 0, 0.7};
  Island released({rising}, Matrix3::Identity());
  REQUIRE(released.resolve_impulses(1e-12));
  CHECK_FALSE(released.nodes()[0].sides[0].active);
  CHECK(released.nodes()[0].force.isZero(0.0));
  rising.sides[0].pinned = true;
  Island pinned({rising}, Matrix3::Identity());
  REQUIRE(pinned.resolve_impulses(1e-12));
  CHECK((pinned.nodes()[0].force + Vector3(0, 0, 0.7)).norm() <= rounding);
  // Two nodes braced between each other by a rod along x: only what differs from its direction moves them.
  std::vector<ContactNode> braced(2, on_floor(Vector3::Zero(), coulomb(0.3)));
  braced[1].node = 1;
  for (ContactNode& node : braced) {
    node.acceleration = {0, 0.1, -1.0};
    node.sticks = true;
  }
  Eigen::MatrixXd mobility = Eigen::MatrixXd::Identity(6, 6);
  mobility(0, 0) = mobility(3, 3) = mobility(0, 3) = mobility(3, 0) = 0.5;
  Island pair(braced, mobility);
  REQUIRE(pair.resolve_impulses(1e-12));
  for (const ContactNode& node : pair.nodes()) CHECK((node.force - Vector3(0, -0.1, 1.0)).norm() <= rounding);
}

TEST_CASE("a reaction is shared by surfaces that press, also between two that face each other") {
  const Vector3 up(0, 0, 1), down(0, 0, -1), side(1, 0, 0);
  const auto share = [](const std::vector<Vector3>& normals, const Vector3& reaction) {
    return share_reaction(normals, std::vector<double>(normals.size(), 0.5), reaction);
  };
  CHECK((share({up, down}, {0, 0, 3})[0] - Vector3(0, 0, 3)).norm() <= 1e-12);
  CHECK(share({up, down}, {0, 0, 3})[1].norm() <= 1e-12);
  CHECK((share({up, side}, {2, 0, 3})[1] - Vector3(2, 0, 0)).norm() <= 1e-12);
  // The side would have to pull: all of it is the floor's, as friction.
  CHECK((share({up, side}, {-2, 0, 3})[0] - Vector3(-2, 0, 3)).norm() <= 1e-12);
  CHECK(share({up, side}, {-2, 0, 3})[1].norm() == 0.0);
  CHECK(pressing_surfaces({up, side}, {-2, 0, -3}).empty());
}
