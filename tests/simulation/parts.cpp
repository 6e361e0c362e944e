// The parts of the engine, each on a model of its own, without engine and integrator.

#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <limits>

#include <springnet/error.hpp>

#include "constraints/vectors.hpp"
#include "nets.hpp"
#include "simulation/body_impact_search.hpp"
#include "simulation/contact_changes.hpp"
#include "simulation/contact_events.hpp"
#include "simulation/engine.hpp"
#include "simulation/integrator_calls.hpp"
#include "simulation/linear_model.hpp"
#include "simulation/start.hpp"
#include "simulation/sweep.hpp"
#include "simulation/topology.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

// A model as at the start of the engine.
struct Alone {
  explicit Alone(const Network& net, SimulationOptions options = {.renumber = false})
      : model(net, *plugins(), options), linear(model), topology(model, linear, net.cuts()) {
    model.scales = find_scales(model);
    start_constraints(model, 1.0);
  }
  [[nodiscard]] springnet_evaluation here() const {
    springnet_evaluation at{};
    at.struct_size = sizeof at;
    at.time = model.time;
    at.position = read_only(model.state.view.position);
    at.velocity = read_only(model.state.view.velocity);
    return at;
  }
  Model model;
  LinearModel linear;
  Topology topology;
};

// x of all nodes first.
struct Columns {
  explicit Columns(std::uint32_t nodes) : n(nodes), values(3 * std::size_t{nodes}, 0.0) {}
  [[nodiscard]] springnet_vectors view() { return {values.data(), values.data() + n, values.data() + 2 * n}; }
  [[nodiscard]] Vector3 at(std::uint32_t k) const { return {values[k], values[n + k], values[2 * n + k]}; }
  std::size_t n;
  std::vector<double> values;
};

}  // namespace

TEST_CASE("topology: removal records events, makes derivatives stale and increases the revision") {
  Network net = chain(5, Vector3::Zero(), {1, 0, 0}, damped(10.0, 1.0));
  net.add_cut({0.5, {1, 2}, {}});
  net.add_cut({0.7, {1}, {}});
  Alone alone(net);
  Model& model = alone.model;
  REQUIRE(alone.linear.linearise(alone.here(), 0.0) == SPRINGNET_OK);
  const std::uint64_t before = model.revision;
  CHECK(alone.topology.next_cut(0.0) == 0.5);
  alone.topology.perform_due_cuts();
  CHECK(model.revision == before);
  CHECK(alone.linear.known());
  model.time = 0.5;
  alone.topology.perform_due_cuts();
  CHECK(model.revision > before);
  CHECK_FALSE(alone.linear.known());
  CHECK(model.stale.contacts);
  REQUIRE(model.journal.events().size() == 2);
  CHECK(model.journal.events()[1].kind == Event::Kind::cut);
  CHECK(model.journal.events()[1].index == 2);
  CHECK(alone.topology.next_cut(0.5) == 0.7);
  model.time = 0.7;
  alone.topology.perform_due_cuts();  // spring 1 was removed before
  CHECK(model.journal.events().size() == 2);
  CHECK(model.journal.notes().size() == 1);
  CHECK(alone.topology.next_cut(0.7) == std::numeric_limits<double>::infinity());
}

TEST_CASE("topology: springs whose margin is used up at the committed state break") {
  Network net;
  const MaterialIndex brittle =
      net.add_material({LawUse{"rupturing", {{"stiffness", 4.0}, {"strength", 2.0}}}, std::nullopt});
  for (const double x : {0.0, 1.4, 3.0}) net.add_node(point({x, 0, 0}));
  net.add_spring(0, 1, brittle, 1.0);  // 1.6 N
  net.add_spring(1, 2, brittle, 1.0);  // 2.4 N
  Alone alone(net);
  REQUIRE(alone.topology.rupturing().count() == 2);
  double margins[2];
  REQUIRE(alone.topology.margins(0.0, alone.model.state.nodes(), margins) == SPRINGNET_OK);
  CHECK(margins[0] > 0.0);
  CHECK(margins[1] < 0.0);
  REQUIRE(alone.topology.perform_due_ruptures() == SPRINGNET_OK);
  REQUIRE(alone.model.journal.events().size() == 1);
  CHECK(alone.model.journal.events()[0].kind == Event::Kind::ruptured);
  CHECK(alone.model.journal.events()[0].index == 1);
  CHECK(alone.topology.rupturing().count() == 1);
}

TEST_CASE("sweep: evaluations and sweeps have the forces of the springs, and the commit the weights of the sweep") {
  Network net = oscillator(damped(10.0, 2.0), 0.5, 0.3, 0.7);
  net.set_gravity({0, 0, -1});
  Alone alone(net);
  Model& model = alone.model;
  Sweep sweep(model);
  const std::uint32_t n = model.node_count();
  Columns force(n), acceleration(n);
  springnet_evaluation at = alone.here();
  at.force = force.view();
  at.acceleration = acceleration.view();
  REQUIRE(sweep.evaluate(at) == SPRINGNET_OK);
  std::uint32_t moving = 0;
  while (model.contact.fixed()[moving] != 0) ++moving;
  const Vector3 p = vector_at(model.state.view.position, moving), v = vector_at(model.state.view.velocity, moving);
  const Vector3 d = p - vector_at(model.state.view.position, 1 - moving), direction = d.normalized();
  // k (l - l0) along the spring, l0 = 1; rate of the length times the damping; weight.
  const Vector3 expected = -(10.0 * (d.norm() - 1.0) + 2.0 * direction.dot(v)) * direction + 0.5 * Vector3(0, 0, -1);
  CHECK((force.at(moving) - expected).norm() < 1e-14);
  CHECK((acceleration.at(moving) - expected / 0.5).norm() < 1e-14);
  CHECK(acceleration.at(1 - moving).isZero(0.0));  // fixed

  struct Update {
    Columns position, velocity;
    double h;
  } next{Columns(n), Columns(n), 0.01};
  springnet_sweep request{};
  request.struct_size = sizeof request;
  request.time = 0.01;
  request.time_constant = 0.01;
  request.theta = 0.5;
  request.start_position = request.position = at.position;
  request.start_velocity = request.velocity = at.velocity;
  request.next_position = next.position.view();
  request.next_velocity = next.velocity.view();
  Columns swept(n);
  request.force = swept.view();
  request.user = &next;
  request.update = [](void* user, const springnet_node_batch* batch) -> springnet_status {
    auto& to = *static_cast<Update*>(user);
    for (std::uint32_t i = 0; i < batch->count; ++i)
      to.velocity.values[batch->first + i] = to.h * batch->acceleration.x[i];
    return SPRINGNET_OK;
  };
  CHECK_FALSE(sweep.done().any);
  springnet_network network{};
  REQUIRE(sweep.run(request, network) == SPRINGNET_OK);
  CHECK(swept.values == force.values);
  CHECK(next.velocity.values[moving] == doctest::Approx(0.01 * expected[0] / 0.5).epsilon(1e-14));
  CHECK(sweep.done().any);
  CHECK(sweep.done().decided);
  CHECK(sweep.done().weight == 0.005);
  CHECK(sweep.done().rest == 0.005);
  CHECK_FALSE(model.in_callback);
}

TEST_CASE("contact events: a node that falls onto a plane is found, stopped, and released by the force that lifts it") {
  Network net;
  net.add_node(point({0, 0, 0.2}, 2.0, {0.5, 0, -3}));
  Plane plane;
  plane.normal = {0, 0, 1};
  plane.name = "floor";
  plane.friction.kind = Friction::Kind::none;
  net.add_plane(plane);
  net.set_gravity({0, 0, -10});
  Alone alone(net);
  Model& model = alone.model;
  ContactEvents events(model, alone.topology);
  using Kind = ContactEvents::Source::Kind;
  REQUIRE(events.sources().size() == 1);
  CHECK(events.sources()[0].kind == Kind::touch);
  double value = 0.0;
  std::int32_t direction = 0;
  REQUIRE(events.values(alone.here(), &value, &direction) == SPRINGNET_OK);
  CHECK(value == doctest::Approx(0.2).epsilon(1e-8));  // the gap, and the contact tolerance
  CHECK(direction == -1);

  State state(model.node_count(), 0);
  put_vector(state.view.position, 0, {0.1, 0, -1e-12});
  put_vector(state.view.velocity, 0, {0.5, 0, -3.5});
  model.time = 0.06;
  const std::int32_t fired = 1;
  REQUIRE(events.fire(0.06, state, &fired) == SPRINGNET_OK);
  CHECK(model.contact.committed(0).has(0));
  CHECK((vector_at(state.view.velocity, 0) - Vector3(0.5, 0, 0)).norm() < 1e-14);
  REQUIRE(model.journal.events().size() == 1);
  CHECK(model.journal.events()[0].kind == Event::Kind::touched);
  CHECK((model.journal.events()[0].impulse - Vector3(0, 0, 7)).norm() < 1e-12);  // m v

  // On the plane: a release, whose value is the negative normal force.
  model.state.swap(state);
  model.changed();
  REQUIRE(events.sources().size() == 1);
  CHECK(events.sources()[0].kind == Kind::release);
  REQUIRE(events.values(alone.here(), &value, &direction) == SPRINGNET_OK);
  CHECK(value == doctest::Approx(-20.0).epsilon(1e-14));
  CHECK(direction == 1);
  model.loads.set_host_force(0, {0, 0, 25});
  REQUIRE(events.values(alone.here(), &value, &direction) == SPRINGNET_OK);
  CHECK(value == doctest::Approx(5.0).epsilon(1e-14));
}

TEST_CASE("contact changes: a node that got behind an obstacle is stopped, another is not") {
  Network net;
  net.add_node(point({0, 0, 1.0}, 1.0, {0, 0, -1}));
  net.add_node(point({1, 0, 1.0}, 1.0, {0, 0, -1}));
  net.add_plane({"floor", Vector3::Zero(), Vector3::UnitZ()});
  Alone alone(net);
  Model& model = alone.model;
  put_vector(model.state.view.position, 0, {0, 0, -1e-6});
  REQUIRE(stop_penetration(model) == SPRINGNET_OK);
  CHECK(model.contact.committed(0).has(0));
  CHECK_FALSE(model.contact.committed(1).has(0));
  CHECK(vector_at(model.state.view.velocity, 0).norm() < 1e-14);
  CHECK(vector_at(model.state.view.velocity, 1) == Vector3(0, 0, -1));
}

TEST_CASE("linear model: with rods under tension it is the derivative of the constrained motion") {
  // A pendulum of two rods with a spring at its end. Directions and changes of acceleration are projected onto the
  // rods.
  Network net;
  const std::vector<Vector3> places{{0, 0, 0}, {0.6, 0, -0.8}, {0.6, 1.0, -0.8}, {1.5, 1.3, -0.2}};
  for (const Vector3& p : places) net.add_node(point(p, 1.0 + 0.5 * p[0]));
  net.fix(0);
  net.add_rigid(0, 1);
  net.add_rigid(1, 2);
  net.add_spring(2, 3, net.add_material(damped(30.0, 0.5)), 0.9);
  net.set_gravity({0, 0, -9.81});
  Alone alone(net);
  Model& model = alone.model;
  Sweep sweep(model);
  const auto n = static_cast<Eigen::Index>(model.node_count());
  REQUIRE(alone.linear.linearise(alone.here(), 0.0) == SPRINGNET_OK);

  const springnet_vectors place = model.state.view.position;
  const Eigen::VectorXd start = [&] {
    Eigen::VectorXd x(3 * n);
    for (Eigen::Index k = 0; k < n; ++k)
      for (Eigen::Index c = 0; c < 3; ++c) x[c * n + k] = vector_at(place, static_cast<std::uint32_t>(k))[c];
    return x;
  }();
  // The acceleration at x, projected onto the lengths of the rods.
  const auto acceleration_at = [&](const Eigen::VectorXd& x) {
    Columns position(model.node_count()), velocity(model.node_count()), a(model.node_count());
    for (Eigen::Index i = 0; i < 3 * n; ++i) position.values[static_cast<std::size_t>(i)] = x[i];
    REQUIRE(model.constraints.project(*model.placement(0.0), position.view(), velocity.view(), model.journal.message) ==
            SPRINGNET_OK);
    springnet_evaluation at = alone.here();
    at.position = read_only(position.view());
    at.velocity = read_only(velocity.view());
    at.acceleration = a.view();
    REQUIRE(sweep.evaluate(at) == SPRINGNET_OK);
    Eigen::VectorXd all = Eigen::Map<const Eigen::VectorXd>(a.values.data(), 3 * n);
    return all;
  };
  for (int trial = 0; trial < 4; ++trial) {
    Eigen::VectorXd d(3 * n), zero = Eigen::VectorXd::Zero(3 * n), derivative(3 * n);
    for (Eigen::Index i = 0; i < 3 * n; ++i) d[i] = std::sin(1.0 + 7.0 * trial + 3.0 * static_cast<double>(i));
    REQUIRE(alone.linear.project(nullptr, d.data()) == SPRINGNET_OK);
    REQUIRE(alone.linear.times(d.data(), zero.data(), false, derivative.data()) == SPRINGNET_OK);
    // Central differences of second order, h = 1e-5: 1e-9 of entries of order 100, and rounding 1e-16 / h of them.
    constexpr double h = 1e-5;
    Eigen::VectorXd difference = (acceleration_at(start + h * d) - acceleration_at(start - h * d)) / (2.0 * h);
    REQUIRE(alone.linear.project(nullptr, difference.data()) == SPRINGNET_OK);
    CHECK((derivative - difference).norm() < 1e-7 * difference.norm());
  }
  alone.topology.cut({0});
  CHECK_FALSE(alone.linear.known());
}

TEST_CASE(
    "integrator calls: foreign states, times outside of the advance and numbers that are not finite are refused") {
  Network net = oscillator(damped(10.0, 0.0), 1.0, 0.1);
  Alone alone(net);
  Model& model = alone.model;
  IntegratorCalls calls(model);
  calls.begin_advance(0.5);
  springnet_state* const mine = calls.create_state();
  State& state = calls.created_state(mine);
  CHECK_NOTHROW(calls.check_commit(0.5, state, false));
  CHECK_THROWS_AS(calls.check_commit(0.51, state, false), Error);
  CHECK_THROWS_AS(calls.check_commit(-0.1, state, false), Error);
  CHECK_THROWS_AS(calls.check_commit(std::nan(""), state, false), Error);
  state.view.velocity.y[1] = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(calls.check_commit(0.5, state, false), Error);
  springnet_state foreign{};
  CHECK_THROWS_AS(static_cast<void>(calls.created_state(&foreign)), Error);
  mine->position.x = nullptr;  // the engine does not rely on pointers that the integrator can write
  CHECK(calls.created_state(mine).view.position.x != nullptr);
  model.in_callback = true;
  CHECK_THROWS_AS(static_cast<void>(calls.create_state()), Error);
  calls.destroy_state(mine);
  model.in_callback = false;
  CHECK_NOTHROW(static_cast<void>(calls.created_state(mine)));
  calls.destroy_state(mine);
  CHECK_THROWS_AS(static_cast<void>(calls.created_state(mine)), Error);
  calls.refuse("that was wrong", true);
  CHECK(calls.misuse() == "that was wrong");
  calls.begin_advance(1.0);
  CHECK(calls.misuse().empty());
}

TEST_CASE("journal: notes are kept once, count() adds up, and both are bounded") {
  Journal journal;
  journal.note("once");
  journal.note("once");
  CHECK(journal.notes().size() == 1);
  CHECK(journal.count("touches") == 1.0);
  CHECK(journal.count("touches") == 2.0);
  CHECK(journal.numbers().at("touches") == 2.0);
  CHECK(journal.count("iterations", 2.5) == 2.5);
  CHECK(journal.count("iterations", 0.5) == 3.0);
  journal.note("limit 0.1 s", "limit");
  journal.note("limit 0.2 s", "limit");
  CHECK(journal.notes() == std::vector<std::string>{"once", "limit 0.1 s"});
  for (int i = 0; i < 2000; ++i) {
    journal.note(std::to_string(i));
    journal.report("number " + std::to_string(i), i);
  }
  CHECK(journal.notes().size() == 200);
  CHECK(journal.numbers().size() == 500);
  journal.report("touches", 7.0);  // known numbers still change
  CHECK(journal.numbers().at("touches") == 7.0);
}

TEST_CASE("recent touches: only those in quick succession count") {
  RecentTouches touches;
  CHECK(touches.count(3, 1.0, 0.1) == 1);
  CHECK(touches.count(3, 1.05, 0.1) == 2);
  CHECK(touches.count(4, 1.05, 0.1) == 1);
  CHECK(touches.count(3, 1.2, 0.1) == 1);
}

TEST_CASE("impacts: what slides fast and sinks in slowly is found without a look at each rounding of its path") {
  constexpr double sinking = 1e-8, until = 0.01, touches = 0.0051, radius = 0.1;  // m/s, s, s, m
  struct Path {
    Eigen::Matrix3d axes = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
    std::array<Vector3, 3> corners{axes * Vector3(-1, -1, 0), axes* Vector3(3, -1, 0), axes* Vector3(0, 3, 0)};
    Vector3 velocity = axes * Vector3(0.9, 0.1, -sinking), start = axes * Vector3(0.31, 0.023, 0.5);
    int looked_at = 0;
  } path;
  Network net;
  net.begin_body("floor");
  for (const Vector3& corner : path.corners) {
    Node node = point(corner);
    node.fixed = true;
    net.add_node(node);
  }
  net.add_face({0, 1, 2});
  net.end_body();
  net.set_extent(0, 0.02, 0.0);
  net.begin_body("ball");
  net.add_node(point(path.start, 1.0, path.velocity));
  net.end_body();
  net.set_extent(1, 0.0, radius);
  net.add_contact({{}, {0, 1, 2}, {3}});
  Alone alone(net);
  path.start = path.axes * Vector3(0.31, 0.023, 0.01 + radius - alone.model.contact_tolerance() + sinking * touches);
  ContactEvents events(alone.model, alone.topology);
  springnet_impact_search search{};
  search.struct_size = sizeof search;
  search.step_until = search.until = until;
  search.user = &path;
  search.state_at = [](void* user, const springnet_dense_output* output) -> springnet_status {
    Path& given = *static_cast<Path*>(user);
    ++given.looked_at;
    const std::array positions{output->position.x, output->position.y, output->position.z};
    const std::array velocities{output->velocity.x, output->velocity.y, output->velocity.z};
    const Vector3 ball = given.start + output->time * given.velocity;
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < 4; ++k) {
        const auto axis = static_cast<Eigen::Index>(c);
        positions[c][k] = k == 3 ? ball[axis] : given.corners[k][axis];
        velocities[c][k] = k == 3 ? given.velocity[axis] : 0.0;
      }
    return SPRINGNET_OK;
  };
  double time = 0.0;
  REQUIRE(BodyImpactSearch(alone.model, events, search).find(time) == SPRINGNET_OK);
  // A few roundings of the distance, 1e-16 m each, which take 1e-8 s.
  CHECK(std::abs(time - touches) < 1e-7);
  CHECK(path.looked_at < 200);
}

TEST_CASE("neighbours are there on request, until connections change") {
  Network net;
  const MaterialIndex material = net.add_material(damped(1.0, 0.5));
  for (int k = 0; k < 4; ++k) net.add_node(point({1.0 * k, 0, 0}));
  for (std::uint32_t k = 0; k < 3; ++k) net.add_spring(k, k + 1, material);
  Engine engine(net, *plugins(), {.renumber = false});
  const auto neighbours_of_2 = [&] {
    const springnet_network& network = engine.network_with_neighbours();
    return std::vector<std::uint32_t>(network.neighbours + network.neighbour_start[2],
                                      network.neighbours + network.neighbour_start[3]);
  };
  CHECK(engine.network_info().neighbours == nullptr);
  CHECK(neighbours_of_2() == std::vector<std::uint32_t>{1, 3});
  CHECK(engine.network_info().neighbours != nullptr);
  CHECK(engine.topology().cut(std::vector<std::uint32_t>{1}) == 1);
  CHECK(engine.network_info().neighbours == nullptr);
  CHECK(engine.network_info().neighbour_start == nullptr);
  CHECK(neighbours_of_2() == std::vector<std::uint32_t>{3});
}
