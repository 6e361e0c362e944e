// The constraint set by itself, against closed forms and differences: states, accelerations, forces and small changes
// of nodes that are fixed, prescribed, in contact and joined by rods.
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include <doctest/doctest.h>

#include <Eigen/Geometry>

#include "constraints/constraint_set.hpp"
#include "constraints/vectors.hpp"
#include "nets.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

constexpr double g = 9.81;  // m/s^2
// Arrays of vectors as integrators have them.
class Arrays {
 public:
  explicit Arrays(std::size_t count) : count_(count), values_(3 * count, 0.0) {}
  [[nodiscard]] springnet_vectors out() {
    return {values_.data(), values_.data() + count_, values_.data() + 2 * count_};
  }
  [[nodiscard]] springnet_const_vectors in() {
    return {values_.data(), values_.data() + count_, values_.data() + 2 * count_};
  }
  [[nodiscard]] double* data() { return values_.data(); }
  [[nodiscard]] Vector3 at(std::uint32_t k) { return vector_at(out(), k); }
  void put(std::uint32_t k, const Vector3& value) { put_vector(out(), k, value); }

 private:
  std::size_t count_;
  std::vector<double> values_;
};

// The constraints and the state of a network, with the user's numbers of nodes.
struct ConstrainedState {
  explicit ConstrainedState(const Network& net)
      : numbers(net.nodes().size()), position(numbers.size()), velocity(numbers.size()) {
    std::iota(numbers.begin(), numbers.end(), 0u);
    for (const Node& node : net.nodes()) mass.push_back(node.mass);
    set = std::make_unique<ConstraintSet>(net, numbers, numbers, mass);
    for (std::uint32_t k = 0; k < numbers.size(); ++k) {
      position.put(k, net.nodes()[k].position);
      velocity.put(k, net.nodes()[k].velocity);
    }
  }
  [[nodiscard]] const Placement& at(double time) {
    placement = set->contact().at(just_after(time));
    return *placement;
  }
  void touch(std::uint32_t node, const Touch& touch, const Vector3& slip = Vector3::Zero()) {
    set->contact().touch(node, touch, Vector3::Zero());
    set->contact().set_slip(node, slip);
  }
  // Accelerations of all nodes under the constraints, from those without.
  Arrays accelerated(double time, const std::vector<Vector3>& free) {
    Arrays a(free.size());
    for (std::uint32_t k = 0; k < free.size(); ++k) a.put(k, free[k]);
    double* const arrays[3] = {a.out().x, a.out().y, a.out().z};
    const auto count = static_cast<std::uint32_t>(free.size());
    set->accelerate(at(time), 0, count, position.in(), velocity.in(), arrays);
    set->accelerate_clusters(*placement, position.in(), velocity.in(), a.out());
    return a;
  }

  std::vector<std::uint32_t> numbers;
  std::vector<double> mass;
  std::unique_ptr<ConstraintSet> set;
  std::shared_ptr<const Placement> placement;
  Arrays position, velocity;
  springnet_message message{};
};

Plane floor_of(const Friction& friction, const Vector3& normal = Vector3::UnitZ()) {
  Plane plane;
  plane.normal = normal;
  plane.friction = friction;
  return plane;
}

Network pair(double first, double second, double length) {
  Network net;
  net.add_node(point({0, 0, 0}, first));
  net.add_node(point({length, 0, 0}, second));
  net.add_rigid(0, 1, length);
  return net;
}

}  // namespace

TEST_CASE("fixed, moved and sticking nodes are placed by fixation, motions and obstacles") {
  Network net;
  net.add_node(point({0, 0, 1}));
  net.fix(0);
  net.add_node(point({1, 0, 1}));
  net.add_node(point({0.5, 0, 0}));
  net.add_node(point({3, 0, 1}));
  Move move;
  move.nodes = {1};
  move.motion.times = {0, 1};
  move.motion.displacements = {Vector3::Zero(), {0, 2, 0}};
  move.motion.interpolation = Motion::Interpolation::linear;
  net.add_move(move);
  Plane table = floor_of({Friction::Kind::held, 0.0});
  table.turn.emplace();
  table.turn->rate = 2.0;
  table.turn->through = Vector3::Zero();
  net.add_plane(table);
  ConstrainedState state(net);
  state.set->contact().begin_step(state.set->contact().at(just_after(0.0)));
  state.touch(2, {0, false});
  Arrays position(4), velocity(4);
  for (std::uint32_t k = 0; k < 4; ++k) {
    position.put(k, {7, 7, 7});
    velocity.put(k, {7, 7, 7});
  }
  state.set->place(state.at(0.25), state.position.in(), position.out(), velocity.out());
  CHECK(position.at(0) == Vector3(0, 0, 1));
  CHECK(velocity.at(0) == Vector3::Zero());
  CHECK(position.at(1).isApprox(Vector3(1, 0.5, 1), 1e-15));
  CHECK(velocity.at(1).isApprox(Vector3(0, 2, 0), 1e-15));
  const double angle = 0.5;
  CHECK(position.at(2).isApprox(0.5 * Vector3(std::cos(angle), std::sin(angle), 0), 1e-15));
  CHECK(velocity.at(2).isApprox(Vector3(-std::sin(angle), std::cos(angle), 0), 1e-15));
  CHECK(position.at(3) == Vector3(7, 7, 7));  // what moves by itself is not touched
  // Of a state that a solver arrived at a sticking node keeps its place, along the surface.
  position.put(2, {0.4, 0.3, 1e-9});
  state.set->correct(state.at(0.25), state.position.in(), position.out(), velocity.out());
  CHECK(position.at(2).isApprox(Vector3(0.4, 0.3, 0), 1e-15));
  CHECK(velocity.at(2).isApprox(Vector3(-0.6, 0.8, 0), 1e-15));
}

TEST_CASE("a lone sliding node is projected onto the nearest point of its surface, and its velocity onto the tangent") {
  Network net;
  net.add_node(point({0, 0, 1}));
  Instrument sphere;
  sphere.first = sphere.second = Vector3::Zero();
  sphere.radius = 1.0;
  sphere.friction = frictionless;
  net.add_instrument(sphere);
  ConstrainedState state(net);
  state.touch(0, {0, true});
  const Vector3 out = Vector3(0.3, -0.2, 0.9).normalized();
  state.position.put(0, 1.01 * out);
  state.velocity.put(0, {1, 2, 3});
  REQUIRE(state.set->project(state.at(0), state.position.out(), state.velocity.out(), state.message) == SPRINGNET_OK);
  CHECK((state.position.at(0) - out).norm() <= 1e-15);
  CHECK((state.velocity.at(0) - (Vector3(1, 2, 3) - out * out.dot(Vector3(1, 2, 3)))).norm() <= 1e-14);
}

TEST_CASE("a rod takes the momentum along it from both ends, and its length back, weighted with the masses") {
  ConstrainedState state(pair(1.0, 3.0, 2.0));
  state.position.put(1, {2.004, 0, 0});
  state.velocity.put(0, {1, 5, 0});
  state.velocity.put(1, {-2, 0, 7});
  REQUIRE(state.set->project(state.at(0), state.position.out(), state.velocity.out(), state.message) == SPRINGNET_OK);
  const double common = (1.0 * 1 + 3.0 * -2) / 4.0;
  CHECK(state.velocity.at(0).isApprox(Vector3(common, 5, 0), 1e-14));
  CHECK(state.velocity.at(1).isApprox(Vector3(common, 0, 7), 1e-14));
  CHECK(state.position.at(0).isApprox(Vector3(0.003, 0, 0), 1e-12));
  CHECK(state.position.at(1).isApprox(Vector3(2.003, 0, 0), 1e-12));
}

TEST_CASE("a pendulum's rod and its fixed node carry the centripetal force") {
  Network net = pair(1.0, 0.7, 2.0);
  net.fix(0);
  ConstrainedState state(net);
  const double angle = 0.6, speed = 3.0;  // from straight down
  const Vector3 down(std::sin(angle), 0, -std::cos(angle)), along(std::cos(angle), 0, std::sin(angle));
  state.position.put(1, 2.0 * down);
  state.velocity.put(1, speed * along);
  const Vector3 gravity(0, 0, -g);
  Arrays a = state.accelerated(0, {gravity, gravity});
  CHECK(a.at(0).norm() <= 1e-14);
  CHECK((a.at(1) - (-speed * speed / 2.0 * down - g * std::sin(angle) * along)).norm() <= 1e-13);
  Arrays again(2);
  again.put(1, gravity);
  double tension = 0.0;
  state.set->rigid().accelerate(*state.placement, 0, state.position.in(), state.velocity.in(), again.out(), &tension);
  CHECK(tension == doctest::Approx(0.7 * (speed * speed / 2.0 + g * std::cos(angle))).epsilon(1e-13));
  // The free end is held by nothing but the rod; the fixed one carries the rod and its own weight.
  CHECK(state.set->reaction(1, gravity, a.at(1), state.position.in(), &tension).norm() <= 1e-13);
  const Vector3 pivot_force = state.set->reaction(0, gravity, a.at(0), state.position.in(), &tension);
  CHECK((pivot_force - (Vector3(0, 0, g) - tension * down)).norm() <= 1e-13);
}

TEST_CASE("on an incline a sliding node is slowed by its share of the normal force, and one that sticks is at rest") {
  const double slope = 0.5, mu = 0.3;
  const Vector3 normal(-std::sin(slope), 0, std::cos(slope)), up(std::cos(slope), 0, std::sin(slope));
  Network net;
  net.add_node(point({0, 0, 0}, 2.0));
  net.add_plane(floor_of({Friction::Kind::coulomb, mu}, normal));
  ConstrainedState state(net);
  state.velocity.put(0, -1.5 * up);
  const Vector3 gravity(0, 0, -g);
  state.touch(0, {0, true}, -up);
  Arrays a = state.accelerated(0, {gravity});
  CHECK((a.at(0) + g * (std::sin(slope) - mu * std::cos(slope)) * up).norm() <= 1e-14);
  const Vector3 reaction = state.set->reaction(0, gravity, a.at(0), state.position.in(), nullptr);
  CHECK((reaction - 2.0 * g * std::cos(slope) * (normal + mu * up)).norm() <= 1e-13);
  state.velocity.put(0, Vector3::Zero());
  state.touch(0, {0, false});
  CHECK(state.accelerated(0, {gravity}).at(0).norm() == 0.0);
}

TEST_CASE("between two obstacles each carries its normal force, and friction in proportion to its cone") {
  Network net;
  net.add_node(point({0, 0, 0}));
  net.add_plane(floor_of({Friction::Kind::coulomb, 0.2}, {1, 0, 0}));
  net.add_plane(floor_of({Friction::Kind::coulomb, 0.1}, {0, 0, 1}));
  ConstrainedState state(net);
  state.touch(0, {0, true, 1}, Vector3::UnitY());
  const Vector3 reaction(3, -1.1, 5);
  // 0.2 x 3 N and 0.1 x 5 N of friction, against the slip.
  const Vector3 wall = state.set->share_of(state.at(0), 0, 0, Vector3::Zero(), reaction);
  const Vector3 ground = state.set->share_of(state.at(0), 0, 1, Vector3::Zero(), reaction);
  CHECK(wall.isApprox(Vector3(3, -0.6, 0), 1e-14));
  CHECK(ground.isApprox(Vector3(0, -0.5, 5), 1e-14));
}

TEST_CASE("projection removes the constrained part of a change of velocities and nothing else, for any mobility") {
  Network net = pair(1.0, 3.0, 2.0);
  net.add_node(point({0, 0, 0}, 2.0));
  net.add_plane(floor_of(frictionless));
  ConstrainedState state(net);
  state.touch(2, {0, true});
  state.set->linearise(state.at(0), state.position.in());
  REQUIRE(state.set->rows().size() == 2);
  Arrays mobile(3), changed(3);
  std::vector<double> mobility(27, 0.0);
  Matrix3 w[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const Matrix3 odd = Matrix3::Random();
    w[k] = odd * odd.transpose() + 0.1 * Matrix3::Identity();
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(mobility.data() + 9 * k) = w[k];
  }
  const Vector3 v[3] = {{1, 2, 3}, {-1, 0.5, 2}, {4, 5, 6}};
  const Vector3 x = Vector3::UnitX(), z = Vector3::UnitZ();
  const auto check = [&](const double* given, const Matrix3& first, const Matrix3& second, const Matrix3& third) {
    for (std::uint32_t k = 0; k < 3; ++k) changed.put(k, v[k]);
    state.set->project_change(given, changed.data());
    const double impulse = -x.dot(v[0] - v[1]) / x.dot((first + second) * x);
    CHECK(changed.at(0).isApprox(v[0] + first * x * impulse, 1e-13));
    CHECK(changed.at(1).isApprox(v[1] - second * x * impulse, 1e-13));
    CHECK(changed.at(2).isApprox(v[2] - third * z * z.dot(v[2]) / z.dot(third * z), 1e-13));
  };
  const Matrix3 one = Matrix3::Identity();
  for (int round = 0; round < 2; ++round) {  // factors of the one are not taken for the other
    check(nullptr, one, one / 3.0, one / 2.0);
    check(mobility.data(), w[0], w[1], w[2]);
  }
}

TEST_CASE("derivatives of a rod's force and of friction are those of differences") {
  const double tension = 2.3, mu = 0.4, step = 1e-6;
  ConstrainedState rods(pair(1.0, 3.0, 2.0));
  rods.position.put(1, Vector3(1, -1, 0.5).normalized() * 2.0);
  const Matrix3 stiffness = rods.set->rod_geometric_stiffness(0, rods.position.in(), tension);
  Network net;
  net.add_node(point({0, 0, 0}, 2.0));
  net.add_plane(floor_of({Friction::Kind::coulomb, mu}));
  ConstrainedState sliding(net);
  const Vector3 slip(0.3, -0.2, 0), gravity(0, 0, -g);
  sliding.velocity.put(0, slip);
  sliding.touch(0, {0, true}, slip.normalized());
  sliding.set->linearise(sliding.at(0), sliding.position.in());
  const ConstraintRow& row = sliding.set->rows().front();
  REQUIRE(sliding.set->friction_follows_slip(row));
  const Vector3 reaction =
      sliding.set->reaction(0, gravity, sliding.accelerated(0, {gravity}).at(0), sliding.position.in(), nullptr);
  const Matrix3 friction =
      sliding.set->friction_derivative(*sliding.placement, row, sliding.position.in(), sliding.velocity.in(), reaction);
  for (Eigen::Index c = 0; c < 3; ++c) {
    const Vector3 e = step * Vector3::Unit(c);
    // The first end feels the tension towards the second.
    const auto force = [&](const Vector3& first) {
      return Vector3(tension * (rods.position.at(1) - first).normalized());
    };
    const Vector3 by_place = -(force(e) - force(-e)) / (2.0 * step);
    CHECK((stiffness.col(c) - by_place).norm() <= 1e-9);
    if (c == 2) continue;  // it does not move across the plane
    const auto slowed = [&](const Vector3& v) {
      sliding.velocity.put(0, v);
      return sliding.accelerated(0, {gravity}).at(0);
    };
    const Vector3 by_slip = (slowed(slip + e) - slowed(slip - e)) / (2.0 * step);
    CHECK((friction.col(c) - by_slip).norm() <= 1e-8);
  }
  sliding.set->contact().set_slip(0, slip.normalized(), Contact::Slip::starting);
  CHECK_FALSE(sliding.set->friction_follows_slip(row));  // its direction is kept
}
