// Simulation::extend(): what is there goes on, what is added joins in; against networks that are built anew.

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/mesh.hpp>
#include <springnet/scene_writer.hpp>

#include "mixed_net.hpp"
#include "saved_states.hpp"

using namespace springnet;
using namespace springnet::testing;

namespace {

Simulation in_order(const Network& net, const LawUse& integrator, double step) {
  SimulationOptions options;
  options.time_step = step;
  options.integrator = integrator;
  options.threads = 1;
  options.renumber = false;
  return {net, plugins(), options};
}

// Nodes and springs at random near those that are there.
void add_some(Dice& dice, Network& net, MaterialIndex material) {
  const auto old = static_cast<std::uint32_t>(net.nodes().size());
  for (int i = 0; i < 3; ++i) {
    const NodeIndex to = dice.below(old), other = dice.below(old);
    const NodeIndex added = net.add_node(point(net.nodes()[to].position + Vector3(0.4, 0.3, 0.5) + dice.in_box(0.1)));
    net.add_spring(added, to, material);
    if (other != to) net.add_spring(added, other, material, 1.5);
  }
}

}  // namespace

TEST_CASE("an extension by nothing changes no bit of what follows, contacts, motions and memory included") {
  const Network net = eventful();
  for (const double theta : {1.0, 0.5})
    for (const LawUse& integrator :
         {recurrent(newton, 0.0, {{"theta", theta}}), recurrent(coloured, 1e-9, {{"theta", theta}}), cvode(1e-7),
          LawUse{"verlet", {{"substeps", 10}}}, testing::generalized_alpha()}) {
      CAPTURE(integrator.id);
      Simulation own = in_order(net, integrator, 0.01), plain = in_order(net, integrator, 0.01);
      for (Simulation* const each : {&own, &plain}) {
        each->advance_to(0.15);
        each->set_force(5, {0.3, 0, 1.0});
        each->move_node(7, each->position(7) + Vector3(0, 0.02, 0.03), 0.25);
        each->move_surface(2, {1.5, 1.5, 3.4}, 0.3);
        each->set_parameter({1, 8}, ComponentKind::spring_function, "stiffness", {500.0, 200.0});
        each->set_masses({9}, {1.5});
        each->cut({11});
        each->advance_to(0.2);
        static_cast<void>(each->save());  // lays out what was changed
        each->drop_history();
      }
      own.extend([](Network&) {});
      CHECK(own.time() == plain.time());
      CHECK(own.events().size() == plain.events().size());
      CHECK(own.steps() == plain.steps());
      CHECK(own.mass(9) == 1.5);
      for (int i = 0; i < 15; ++i) {
        CHECK(distance(own, plain) == 0.0);
        for (auto s = static_cast<SpringIndex>(own.spring_count() - 2); s < own.spring_count(); ++s)
          CHECK(own.internal_states(s) == plain.internal_states(s));
        own.step();
        plain.step();
      }
      CHECK(own.events().size() == plain.events().size());
      CHECK(own.surface_impulse(2) == plain.surface_impulse(2));
      CHECK(own.contact_impulse(0) == plain.contact_impulse(0));
    }
}

TEST_CASE("where nothing interacts the others keep their bits") {
  const Network net = eventful();
  for (const LawUse& integrator : {single_sweep(), LawUse{"verlet", {{"substeps", 10}}}}) {
    CAPTURE(integrator.id);
    Simulation own = in_order(net, integrator, 0.002), plain = in_order(net, integrator, 0.002);
    for (Simulation* const each : {&own, &plain}) {
      each->advance_to(0.1);
      each->drop_history();
    }
    const std::size_t nodes = own.node_count(), springs = own.spring_count();
    own.extend([](Network& now) {
      Lattice lattice;
      lattice.origin = {20, 20, 20};
      now.add_lattice("graft", lattice, Node{}, now.add_material(damped(200.0, 1.0)));
      now.add_plane({"far", {0, 0, -50}, Vector3::UnitZ()});
    });
    CHECK(own.node_count() == nodes + 8);
    CHECK(own.spring_count() == springs + 12);
    CHECK(own.surface_count() == 4);
    CHECK(own.surface_name(3) == "ball");
    for (int i = 0; i < 60; ++i) {
      CHECK(distance(own, plain) == 0.0);
      own.step();
      plain.step();
    }
    // The graft falls freely.
    CHECK(own.velocity(static_cast<NodeIndex>(nodes))[2] == doctest::Approx(-2.0 * 0.12).epsilon(1e-6));
  }
}

TEST_CASE("additions, removals and changes at random against a network that is built anew, in every integrator") {
  for (const auto& [integrator, step] : all_integrators()) {
    CAPTURE(integrator.id);
    MixedNet net(true, 3);
    Simulation simulation = simulate(net.base(), integrator, step);
    Dice dice(17), again(17);
    const Material suture = damped(150.0, 1.0);
    for (int i = 0; i < 4; ++i) simulation.step();
    for (int i = 0; i < 5; ++i) net.change(dice, simulation);
    simulation.cut({2, 9, 30});
    Network built = net.built(simulation);
    again = dice;
    simulation.extend([&](Network& now) { add_some(dice, now, now.add_material(suture)); });
    add_some(again, built, built.add_material(suture));
    Simulation fresh = simulate(built, integrator, step);
    REQUIRE(simulation.node_count() == fresh.node_count());
    CHECK(force_difference(simulation, fresh) < 1e-11);
    for (int i = 0; i < 4; ++i) {
      simulation.step();
      fresh.step();
    }
    CHECK(distance(simulation, fresh) < 1e-7);
    // Once more, on top of that.
    simulation.extend([&](Network& now) { add_some(dice, now, now.add_material(suture)); });
    simulation.step();
    CHECK(simulation.node_count() == fresh.node_count() + 3);
  }
}

TEST_CASE("many small extensions give the forces of the whole network") {
  MixedNet net(false, 3);
  Simulation simulation = simulate(net.base(), single_sweep(), 1e-4);
  Dice dice(23);
  std::vector<Spring> added;
  std::vector<double> masses;
  const NodeIndex old = static_cast<NodeIndex>(simulation.node_count());
  for (int i = 0; i < 60; ++i) {
    if (i % 3 == 0) net.change(dice, simulation);
    if (i % 10 == 0) simulation.cut({dice.below(static_cast<std::uint32_t>(simulation.spring_count()))});
    simulation.step();
    simulation.extend([&](Network& now) {
      const std::size_t before = now.springs().size();
      add_some(dice, now, now.add_material(damped(150.0, 1.0)));
      for (std::size_t s = before; s < now.springs().size(); ++s) added.push_back(now.springs()[s]);
    });
  }
  Network built = net.built(simulation);
  for (NodeIndex k = old; k < simulation.node_count(); ++k)
    built.add_node(point(simulation.position(k), 1.0, simulation.velocity(k)));
  const MaterialIndex material = built.add_material(damped(150.0, 1.0));
  const auto first = static_cast<SpringIndex>(simulation.spring_count() - added.size());
  for (std::size_t s = 0; s < added.size(); ++s)
    if (simulation.alive(first + static_cast<SpringIndex>(s)))
      built.add_spring(added[s].first, added[s].second, material, added[s].rest_length);
  CHECK(force_difference(simulation, simulate(built, single_sweep(), 1e-4)) < 1e-11);
}

TEST_CASE("an extended simulation is saved and restored in one of the same network") {
  for (const LawUse& integrator : {recurrent(newton, 0.0), LawUse{"verlet", {{"substeps", 10}}}}) {
    CAPTURE(integrator.id);
    Simulation own = in_order(eventful(), integrator, 0.01);
    own.advance_to(0.1);
    own.set_rest_lengths({4}, {0.8});
    std::shared_ptr<const Network> whole;
    own.extend([&](Network& now) {
      Dice dice(2);
      add_some(dice, now, now.add_material(damped(80.0, 1.0)));
      whole = std::make_shared<const Network>(now);
    });
    own.step();
    own.set_rest_lengths({static_cast<SpringIndex>(own.spring_count() - 1)}, {1.2});
    own.step();
    const std::string saved = own.save();
    Simulation other = in_order(*whole, integrator, 0.01);
    other.restore(saved);
    for (int i = 0; i < 10; ++i) {
      CHECK(distance(own, other) == 0.0);
      own.step();
      other.step();
    }
  }
}

TEST_CASE("a state from after an extension goes on in another process, with the network as a scene") {
  Simulation own = in_order(eventful(), recurrent(newton, 0.0), 0.01);
  own.advance_to(0.1);
  const std::string before = own.save();
  Scene scene;
  const auto add = [&](Network& now) {
    const NodeIndex added = now.add_node(point({9, 9, 9}));
    now.add_spring(5, added, now.add_material(damped(80.0, 1.0)), 0.4);
  };
  own.extend([&](Network& now) {
    add(now);
    scene.network = now;
  });
  own.step();
  const std::string saved = own.save();
  scene.duration = 1.0;
  scene.options.time_step = 0.01;
  const Scene read = parse_scene(to_scene(scene, *plugins()), "extended", *plugins());
  Simulation other = in_order(read.network, recurrent(newton, 0.0), 0.01);
  other.restore(saved);
  // Or by the way that the first one went.
  Simulation third = in_order(eventful(), recurrent(newton, 0.0), 0.01);
  third.restore(before);
  third.extend(add);
  third.restore(saved);
  for (int i = 0; i < 10; ++i) {
    CHECK(distance(own, other) == 0.0);
    CHECK(distance(own, third) == 0.0);
    own.step();
    other.step();
    third.step();
  }
}

TEST_CASE("what is no addition is refused, and leaves the simulation as it was") {
  const Network net = eventful();
  Simulation own = in_order(net, single_sweep(), 0.002), plain = in_order(net, single_sweep(), 0.002);
  own.advance_to(0.1);
  plain.advance_to(0.1);
  const auto refused = [&](const std::function<void(Network&)>& add, std::string_view what) {
    std::string text;
    try {
      own.extend(add);
    } catch (const Error& error) {
      text = error.what();
    }
    CHECK_MESSAGE(text.find(what) != std::string::npos, text);
  };
  refused([](Network& now) { now.set_gravity({0, 0, -1}); }, "gravity");
  refused([](Network& now) { now.fix(3); }, "node 3 was fixed");
  refused([](Network& now) { now.set_rest_length(4, 9.0); }, "number 4 of the springs");
  refused([](Network& now) { now = Network(); }, "in place of");
  refused([](Network& now) { now.add_plane({"wall", {0, 0, 2}, Vector3::UnitZ()}); }, "wall");
  refused([](Network& now) { now.add_node(point({0, 0, -9})); }, "floor");
  refused([&](Network&) { own.step(); }, "between two steps");
  refused([](Network& now) { now.add_spring(0, 1, now.add_material({LawUse{"liner", {}}, std::nullopt})); }, "linear");
  CHECK_THROWS_AS(own.extend([](Network&) { throw std::runtime_error("mine"); }), std::runtime_error);
  for (int i = 0; i < 20; ++i) {
    CHECK(distance(own, plain) == 0.0);
    own.step();
    plain.step();
  }
}

TEST_CASE("a body of a mesh is added, with its faces, and touches what is there") {
  Mesh mesh;  // two hexahedra above the cube
  for (int z = 0; z < 2; ++z)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 3; ++x) mesh.points.emplace_back(x, y, 5.0 + z);
  for (std::uint32_t x = 0; x < 2; ++x) {
    const std::uint32_t corners[] = {x, x + 1, x + 4, x + 3, x + 6, x + 7, x + 10, x + 9};
    mesh.add_cell(CellType::hexahedron, corners);
  }
  const auto add = [&](Network& net) {
    const auto first = static_cast<NodeIndex>(net.nodes().size());
    const MaterialIndex material =
        net.add_material({LawUse{"linear", {{"stiffness", 80.0}}}, LawUse{"linear", {{"damping", 0.3}}}});
    net.begin_body("organ");
    for (const Vector3& place : mesh.points) net.add_node(point(place, 0.5));
    for (const auto& [a, b] : edges_of(mesh, {.face_diagonals = true, .space_diagonals = true}))
      net.add_spring(first + a, first + b, material);
    for (const Face& face : surface_of(mesh)) net.add_face({first + face[0], first + face[1], first + face[2]});
    net.end_body();
    net.add_spring(63, first, material);
  };
  const Network base = cube(300.0, 2.0, 2.0, 1e-3);
  for (const auto& [integrator, step] : all_integrators()) {
    CAPTURE(integrator.id);
    Simulation simulation = simulate(base, integrator, step);
    for (int i = 0; i < 3; ++i) simulation.step();
    simulation.extend(add);
    CHECK(simulation.node_count() == base.nodes().size() + 12);
    CHECK(simulation.present_network().bodies().back().name == "organ");
    CHECK(simulation.cast_ray({0.3, 0.2, 9.0}, {0, 0, -1})->face >= 0);
    // A network that has it from the start, put into the same state. The last spring is as long as it was when it was
    // added.
    Network whole = base;
    add(whole);
    const auto joint = static_cast<SpringIndex>(whole.springs().size() - 1);
    whole.set_rest_length(joint, simulation.rest_length(joint));
    Simulation rebuilt = simulate(whole, integrator, step);
    for (NodeIndex k = 0; k < whole.nodes().size(); ++k) {
      rebuilt.set_position(k, simulation.position(k));
      rebuilt.set_velocity(k, simulation.velocity(k));
    }
    // Sums of forces of some hundred newtons in another order.
    CHECK(force_difference(simulation, rebuilt) < 1e-10);
    for (int i = 0; i < 3; ++i) simulation.step();
    CHECK(std::isfinite(simulation.kinetic_energy()));
  }
}

TEST_CASE("callbacks and snapshots go on after an extension") {
  Simulation simulation = simulate(cube(300.0, 2.0, 2.0, 1e-3), recurrent(newton, 1e-8), 0.01);
  std::size_t steps = 0, events = 0;
  simulation.on_step([&](const StepReport&) { ++steps; });
  simulation.on_event([&](const Event&) { ++events; });
  simulation.keep_snapshots();
  simulation.cut({0});
  simulation.step();
  simulation.extend([](Network& net) { net.add_node(point({9, 9, 9})); });
  REQUIRE(simulation.snapshot() != nullptr);
  CHECK(simulation.snapshot()->positions.cols() == 65);
  CHECK(events == 1);  // the cut is not told again
  simulation.cut({1});
  simulation.step();
  CHECK(events == 2);
  CHECK(steps == 2);
  CHECK(simulation.snapshot()->time == simulation.time());
}
