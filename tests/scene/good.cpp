// Scenes that are right: every key does what the reference page says.
#include <array>
#include <limits>
#include <numeric>
#include <set>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "everything.hpp"
#include "facts.hpp"
#include "scenes.hpp"

using springnet::LawUse;
using springnet::Network;
using springnet::Scene;
using springnet::Vector3;

TEST_CASE("the paper's cube") {
  const Scene scene = parse(R"(
[simulation]
duration  = 22.5             # s
time_step = 0.05             # s, the paper's time constant t_c
integrator = { name = "recurrent", update = "wavefront", force_tolerance = 1e-6 }

[[body]]
name   = "cube"
mesh   = { lattice = [4, 4, 4], spacing = 1.0, origin = [0, 0, 0.081], diagonals = "space" }
neuron = { type = "point_mass", mass = 1.0 }
spring = { type = "linear", stiffness = 3.0 }
viscosity = { type = "linear", damping = 2.0 }

[gravity]
acceleration = [0, 0, -0.2]

[[plane]]
point  = [0, 0, 0]
normal = [0, 0, 1]
)");
  const Network& network = scene.network;
  CHECK(network.nodes().size() == 64);
  CHECK(network.springs().size() == 252);
  REQUIRE(network.materials().size() == 1);
  CHECK(network.materials()[0].spring == LawUse{"linear", {{"stiffness", 3.0}}});
  CHECK(network.materials()[0].viscosity == LawUse{"linear", {{"damping", 2.0}}});
  CHECK(network.nodes()[63].position == Vector3(3, 3, 3.081));
  CHECK(network.gravity() == Vector3(0, 0, -0.2));
  CHECK(network.planes().size() == 1);
  CHECK(scene.duration == 22.5);
  CHECK(scene.options.time_step == 0.05);
  CHECK(scene.options.integrator == LawUse{"recurrent", {{"update", 1.0}, {"force_tolerance", 1e-6}}});
  CHECK(scene.network.neurons().size() == 1);
}

TEST_CASE("keys that are left out have their defaults") {
  const Scene scene = parse(small);
  CHECK(scene.title.empty());
  CHECK(scene.options.integrator == LawUse{"recurrent", {}});
  CHECK(scene.options.threads == 0);
  CHECK(scene.options.instruction_set == springnet::InstructionSet::best);
  CHECK(scene.options.renumber);
  CHECK(scene.output.interval == 0);
  CHECK(scene.output.trajectory);
  CHECK_FALSE(scene.output.reactions);
  CHECK(scene.output.surfaces);
  CHECK(scene.output.rigid);
  CHECK(scene.output.elements);
  CHECK(scene.output.nodes.empty());
  CHECK(scene.output.springs.empty());
  CHECK(scene.output.position);
  CHECK(scene.output.velocity);
  CHECK_FALSE(scene.output.force);
  CHECK(scene.output.format == springnet::OutputOptions::Format::csv);
  CHECK(scene.output.precision == springnet::OutputOptions::Precision::float64);
  CHECK_FALSE(scene.output.vtk);
  CHECK(scene.output.vtk_interval == 0);
  CHECK(scene.network.gravity() == Vector3::Zero());
  CHECK(scene.network.nodes()[0].position == Vector3::Zero());
  CHECK(scene.network.nodes()[0].velocity == Vector3::Zero());
  CHECK_FALSE(scene.network.materials()[0].viscosity.has_value());
  CHECK(scene.network.springs().size() == 54);  // no diagonals
}

TEST_CASE("an integrator may be no more than a name") {
  const std::string text = "[simulation]\nintegrator = \"cvode\"\n" + small.substr(13);
  CHECK(parse(text).options.integrator == LawUse{"cvode", {}});
}

TEST_CASE("a single node needs no law") {
  const std::string body = simulation + "[[body]]\nname = \"a\"\nneuron = { type = \"point_mass\", mass = 3 }\n";
  CHECK(parse(body + "nodes = [[1, 2, 3]]").network.nodes()[0].position == Vector3(1, 2, 3));
  const Scene lattice = parse(body + "mesh = { lattice = [1, 1, 1], spacing = 1, origin = [1, 2, 3] }");
  REQUIRE(lattice.network.nodes().size() == 1);
  CHECK(lattice.network.nodes()[0].position == Vector3(1, 2, 3));
  CHECK(lattice.network.nodes()[0].mass == 3);
  CHECK(lattice.network.bodies()[0].name == "a");
}

TEST_CASE("every key: simulation and output") {
  const Scene scene = parse(everything);
  CHECK(scene.title == "everything");
  CHECK(scene.duration == 2.5);
  CHECK(scene.options.time_step == 0.02);
  CHECK(scene.options.integrator == LawUse{"recurrent", {{"update", 0.0}, {"max_sweeps", 77.0}}});
  CHECK(scene.options.threads == 2);
  CHECK(scene.options.instruction_set == springnet::InstructionSet::generic);
  CHECK_FALSE(scene.options.renumber);
  CHECK(scene.output.interval == 0.1);
  CHECK_FALSE(scene.output.trajectory);
  CHECK(scene.output.reactions);
  CHECK_FALSE(scene.output.surfaces);
  CHECK_FALSE(scene.output.rigid);
  CHECK_FALSE(scene.output.elements);
  CHECK(scene.output.energies);
  CHECK_FALSE(scene.output.states);
  CHECK(scene.output.law_states.empty());
  CHECK(scene.output.nodes == std::vector<springnet::NodeIndex>{8, 9, 10});
  CHECK(scene.output.springs == std::vector<springnet::SpringIndex>{0, 5});
  CHECK(scene.output.position);
  CHECK_FALSE(scene.output.velocity);
  CHECK(scene.output.force);
  CHECK(scene.output.format == springnet::OutputOptions::Format::binary);
  CHECK(scene.output.precision == springnet::OutputOptions::Precision::float32);
  CHECK(scene.output.vtk);
  CHECK(scene.output.vtk_interval == 0.5);
  CHECK(scene.network.gravity() == Vector3(0, 0, -9.81));
}

TEST_CASE("every key: bodies, in the order of the file") {
  const Network network = parse(everything).network;
  REQUIRE(network.bodies().size() == 2);
  CHECK(network.bodies()[0].name == "block");
  CHECK(network.bodies()[0].node_count == 8);
  CHECK(network.bodies()[0].spring_count == 12);
  CHECK(network.bodies()[1].name == "chain");
  CHECK(network.bodies()[1].first_node == 8);
  CHECK(network.bodies()[1].first_spring == 12);
  CHECK(network.nodes()[7].position == Vector3(1, 2, 8));
  CHECK(network.nodes()[7].velocity == Vector3(0, 0, -1));
  CHECK(network.nodes()[7].mass == 2);
  CHECK(network.nodes()[9].position == Vector3(11, 0, 0));
  CHECK(network.neurons()[network.nodes()[9].neuron] == LawUse{"dragged", {{"drag", 0.5}}});
  CHECK(network.springs()[1].rest_length == 1.0);  // y, 2 m, scaled by 0.5
  CHECK(network.springs()[13].rest_length == 2.0);
  const springnet::Material& block = network.materials()[network.springs()[1].material];
  CHECK(block.spring == LawUse{"linear", {{"stiffness", 3.0}}});
  CHECK(block.viscosity == LawUse{"power", {{"damping", 2.0}, {"exponent", 1.5}}});
  const springnet::Material& chain = network.materials()[network.springs()[13].material];
  CHECK_FALSE(chain.spring.has_value());
  CHECK(chain.viscosity == LawUse{"relative", {{"damping", 1.0}}});
}

TEST_CASE("every key: connections") {
  const Network network = parse(everything).network;
  REQUIRE(network.springs().size() == 17);
  const springnet::Spring& pair = network.springs()[14];
  CHECK(pair.first == 1);
  CHECK(pair.second == 8);
  CHECK(pair.rest_length == 4.5);
  CHECK(network.materials()[pair.material].spring ==
        LawUse{"rupturing", {{"stiffness", 5.0}, {"strength", 2.0}, {"breaks_in_compression", 1.0}}});
  const springnet::Spring& nearest = network.springs()[15];
  CHECK(nearest.first == 7);
  CHECK(nearest.second == 8);
  // Twice the distance of (1, 2, 8) and (10, 0, 0); a rounding or two.
  CHECK(nearest.rest_length == doctest::Approx(2 * std::sqrt(81.0 + 4.0 + 64.0)).epsilon(1e-15));
  const springnet::Spring& within = network.springs()[16];
  CHECK(within.first == 8);
  CHECK(within.second == 10);
  CHECK(within.rest_length == 3);
}

TEST_CASE("every key: overrides of nodes and springs") {
  const Network network = parse(everything).network;
  for (const unsigned node : {4u, 5u}) {
    CHECK(network.nodes()[node].mass == 4);
    CHECK(network.nodes()[node].velocity == Vector3(1, 2, 3));
    CHECK(network.neurons()[network.nodes()[node].neuron] == LawUse{"dragged", {{"drag", 0.25}}});
  }
  CHECK(network.nodes()[6].mass == 2);
  const springnet::Spring& first = network.springs()[0];
  CHECK(first.rest_length == 0.75);
  CHECK(network.materials()[first.material].spring == LawUse{"nonlinear", {{"stiffness", 1.0}, {"cubic", 2.0}}});
  CHECK_FALSE(network.materials()[first.material].viscosity.has_value());
  const springnet::Spring& link = network.springs()[12];
  CHECK(link.rest_length == 3);
  CHECK(network.materials()[link.material].spring == LawUse{"linear", {{"stiffness", 7.0}}});
  CHECK(network.materials()[link.material].viscosity == LawUse{"linear", {{"damping", 7.0}}});
  CHECK(network.materials()[network.springs()[13].material].viscosity->id == "relative");
}

TEST_CASE("every key: what acts on the network") {
  const Network network = parse(everything).network;
  const std::set<springnet::NodeIndex> fixed{0, 1, 6, 10};  // 10 by [[fix]], the others move
  for (springnet::NodeIndex node = 0; node < network.nodes().size(); ++node) {
    CHECK(network.nodes()[node].fixed == (fixed.count(node) == 1));
  }
  REQUIRE(network.loads().size() == 4);
  CHECK(network.loads()[1].course.factors.back() == 1.5);
  CHECK(network.loads()[2].course.mean == 1.0);
  CHECK(network.loads()[3].faces.size() == 12);
  CHECK(network.loads()[3].follow);
  CHECK(network.loads()[3].course.ramp == 0.5);
  CHECK(network.loads()[0].nodes == std::vector<springnet::NodeIndex>{3});
  CHECK(network.loads()[0].force == Vector3(1, 0, 0));
  CHECK(network.loads()[0].from == 0.5);
  CHECK(network.loads()[0].until == 1.5);
  REQUIRE(network.planes().size() == 1);
  CHECK(network.planes()[0].name == "floor");
  CHECK(network.planes()[0].point == Vector3(0, 0, -1));
  CHECK(network.planes()[0].normal == Vector3(0, 0, 1));
  REQUIRE(network.cuts().size() == 2);
  CHECK(network.cuts()[0].time == 1);
  CHECK(network.cuts()[0].springs == std::vector<springnet::SpringIndex>{3});
  CHECK(network.cuts()[1].polygon.size() == 3);
  CHECK(network.cuts()[1].polygon[2] == Vector3(0.5, 5, 9));

  REQUIRE(network.changes().size() == 5);
  CHECK(network.changes()[0].time == 1.5);
  CHECK(network.changes()[0].springs == std::vector<springnet::SpringIndex>{1});
  CHECK(network.changes()[0].spring.at("stiffness") == 5.0);
  CHECK(network.changes()[0].viscosity.at("exponent") == 1.25);
  CHECK(network.changes()[0].reference == 1.0);
  CHECK(network.changes()[1].reference_scale == 2.0);
  CHECK(network.changes()[2].nodes == std::vector<springnet::NodeIndex>{9});
  CHECK(network.changes()[2].neuron.at("drag") == 0.75);
  CHECK(network.changes()[2].mass == 3.0);
  CHECK(network.changes()[3].remove);
  CHECK(network.changes()[4].integrator.value().id == "verlet");
}

TEST_CASE("every key: rigid connections") {
  const Network network = parse(everything).network;
  const std::vector<std::array<unsigned, 2>> ends{{8, 9}, {0, 1}, {2, 3}, {9, 10}};
  REQUIRE(network.rigids().size() == ends.size());
  for (std::size_t k = 0; k < ends.size(); ++k) {
    CAPTURE(k);
    CHECK(network.rigids()[k].first == ends[k][0]);
    CHECK(network.rigids()[k].second == ends[k][1]);
    CHECK(network.rigids()[k].length == (k == 3 ? 2.0 : 1.0));
  }
  CHECK(network.springs().size() == 17);  // none goes, none comes
}

TEST_CASE("every key: motions") {
  const Network network = parse(everything).network;
  REQUIRE(network.moves().size() == 2);
  CHECK(network.moves()[0].nodes == std::vector<springnet::NodeIndex>{0, 1});
  const springnet::Motion& table = network.moves()[0].motion;
  CHECK(table.interpolation == springnet::Motion::Interpolation::linear);
  CHECK(table.times == std::vector<double>{0, 1, 2.5});
  REQUIRE(table.displacements.size() == 3);
  CHECK(table.displacements[2] == Vector3(-1, 0, 0.5));
  CHECK(table.amplitude == Vector3::Zero());
  const springnet::Motion& sinusoid = network.moves()[1].motion;
  CHECK(network.moves()[1].nodes == std::vector<springnet::NodeIndex>{6});
  CHECK(sinusoid.times.empty());
  CHECK(sinusoid.amplitude == Vector3(0, 0.1, 0));
  CHECK(sinusoid.frequency == 2.5);
  CHECK(sinusoid.phase == 0.5);
  CHECK(sinusoid.from == 0.25);
  CHECK(sinusoid.until == 2.25);
}

TEST_CASE("every key: surfaces") {
  using springnet::Friction;
  const Network network = parse(everything).network;
  const springnet::Plane& floor = network.planes().at(0);
  CHECK(floor.friction.kind == Friction::Kind::coulomb);
  CHECK(floor.friction.coefficient == 0.3);
  REQUIRE(floor.motion.has_value());
  CHECK(floor.motion->interpolation == springnet::Motion::Interpolation::smooth);
  CHECK(floor.motion->displacements.at(1) == Vector3(0, 0, 0.25));
  CHECK(floor.restitution == 0.75);
  REQUIRE(floor.turn.has_value());
  CHECK(floor.turn->axis == Vector3(0, 0, 1));
  CHECK_FALSE(floor.turn->through.has_value());
  CHECK(floor.turn->rate == -0.5);
  CHECK(floor.turn->from == 0.25);
  CHECK(floor.turn->until == 2.0);
  REQUIRE(network.instruments().size() == 3);
  const springnet::Instrument& ball = network.instruments()[0];
  CHECK(ball.name == "ball");
  CHECK(ball.first == Vector3(5, 5, 5));
  CHECK(ball.second == Vector3(5, 5, 5));
  CHECK(ball.radius == 0.5);
  CHECK(ball.friction.kind == Friction::Kind::none);
  REQUIRE(ball.motion.has_value());
  CHECK(ball.motion->frequency == 0.5);
  CHECK(ball.motion->until == 1.5);
  const springnet::Instrument& probe = network.instruments()[1];
  CHECK(probe.first == Vector3(0, 0, 20));
  CHECK(probe.second == Vector3(0, 0, 30));
  CHECK(probe.radius == 0.25);
  CHECK(probe.friction.kind == Friction::Kind::held);
  CHECK_FALSE(probe.motion.has_value());
  CHECK(probe.restitution == 0.5);
  CHECK_FALSE(probe.box.has_value());
  const springnet::Instrument& slab = network.instruments()[2];
  CHECK(slab.first == Vector3(0, 20, 0));
  REQUIRE(slab.box.has_value());
  CHECK(slab.box->size == Vector3(1, 2, 3));
  CHECK(slab.box->radius == 0.125);
  CHECK(slab.box->axes.col(0).isApprox(Vector3(std::cos(0.5), std::sin(0.5), 0), 1e-15));
  CHECK(slab.restitution == 0);
  REQUIRE(slab.turn.has_value());
  CHECK(slab.turn->axis == Vector3(0, 1, 0));
  CHECK(slab.turn->through == Vector3(0, 19, 0));
  CHECK(slab.turn->times == std::vector<double>{0, 1});
  CHECK(slab.turn->angles == std::vector<double>{0, 1.5});
  CHECK(slab.turn->interpolation == springnet::Motion::Interpolation::linear);
}

TEST_CASE("defaults of friction, interpolation and time windows") {
  const std::string plane = small + "[[plane]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\n";
  CHECK(parse(plane).network.planes()[0].friction.kind == springnet::Friction::Kind::held);
  CHECK(parse(plane + "friction = \"held\"").network.planes()[0].friction.kind == springnet::Friction::Kind::held);
  const springnet::Friction smooth = parse(plane + "friction = 0").network.planes()[0].friction;
  CHECK(smooth.kind == springnet::Friction::Kind::coulomb);
  CHECK(smooth.coefficient == 0);
  const Network network = parse(small +
                                "[[move]]\nselect = { nodes = [0] }\ntable = [[0, 0, 0, 0], [1, 1, 0, 0]]\n"
                                "[[move]]\nselect = { nodes = [1] }\n"
                                "sinusoid = { amplitude = [0, 0, 1], frequency = 1 }\n")
                              .network;
  CHECK(network.moves()[0].motion.interpolation == springnet::Motion::Interpolation::smooth);
  CHECK(network.moves()[1].motion.phase == 0);
  CHECK(network.moves()[1].motion.from == 0);
  CHECK(network.moves()[1].motion.until == std::numeric_limits<double>::infinity());
}

TEST_CASE("springs are made rigid once where several join the same nodes") {
  const std::string twice =
      small + "[[connect]]\npairs = [[{ node = 1 }, { node = 0 }]]\nspring = { type = \"linear\", stiffness = 1 }\n";
  const Network network = parse(twice + "[[rigid]]\nsprings = { nodes = [0, 1, 2] }\n").network;
  REQUIRE(network.rigids().size() == 2);  // 0 to 1, 1 to 2
  CHECK(network.rigids()[1].second == 2);
}

TEST_CASE("forces, cuts and motions outside of the simulated time are noted") {
  CHECK(springnet::notes_of(parse(everything)).empty());
  const std::string load = "[[force]]\nselect = {}\nforce = [0, 0, 1]\n";
  const std::string table = "table = [[2, 0, 0, 0], [3, 0, 0, 1]]";
  const Scene scene = parse(small + load + "from = 1\n" + load + "until = 0\n" + load + "from = 0.9\n" +
                            "[[cut]]\ntime = 1\nselect = {}\n[[cut]]\ntime = 1.5\nselect = {}\n" +
                            "[[move]]\nselect = { nodes = [0] }\n" + table +
                            "\n[[plane]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\nmotion = { " + table +
                            " }\n[[instrument]]\nname = \"tip\"\nsphere = { center = [9, 9, 9], radius = 1 }\n" +
                            "motion = { sinusoid = { amplitude = [1, 0, 0], frequency = 1 }, from = 7 }\n" +
                            "turn = { axis = [0, 0, 1], rate = 1, from = 6 }\n");
  const std::vector<std::string> expected{"Force 0 | starts at 1 s",
                                          "Force 1 | ends at 0 s",
                                          "Cut 1 | 1.5 s",
                                          "move 0 | starts at 2 s",
                                          "plane 0 | starts at 2 s",
                                          "motion | instrument 'tip' | starts at 7 s",
                                          "turn | instrument 'tip' | starts at 6 s"};
  const std::vector<std::string> notes = springnet::notes_of(scene);
  REQUIRE(notes.size() == expected.size());
  for (std::size_t k = 0; k < notes.size(); ++k) {
    CAPTURE(notes[k]);
    CHECK(springnet::testing::has_facts(notes[k], expected[k] + " | 0 to 1 s"));
  }
  Scene longer = scene;
  longer.duration = 8;
  CHECK(springnet::notes_of(longer).size() == 1);  // the force that ends at 0 s
  longer.duration = 0;
  CHECK(springnet::notes_of(longer).empty());
}

TEST_CASE("a force without a time window always acts") {
  const Network network = parse(small + "[[force]]\nselect = {}\nforce = [0, 0, 1]\n").network;
  CHECK(network.loads()[0].from == -std::numeric_limits<double>::infinity());
  CHECK(network.loads()[0].until == std::numeric_limits<double>::infinity());
  CHECK(network.loads()[0].nodes.size() == 27);
}

TEST_CASE("all four kinds of diagonals") {
  const std::array<std::pair<const char*, std::size_t>, 4> kinds{
      {{"none", 144}, {"face", 144 + 216}, {"space", 144 + 108}, {"all", 144 + 216 + 108}}};
  for (const auto& kind : kinds) {
    const std::string name = kind.first;
    CAPTURE(name);
    const std::vector<springnet::SceneOverride> set{{"body.0.mesh.lattice", "[4, 4, 4]"},
                                                    {"body.0.mesh.diagonals", fmt::format("'{}'", name)}};
    CHECK(parse(small, set).network.springs().size() == kind.second);
  }
}

TEST_CASE("a lattice of a million nodes takes seconds") {
  const Scene scene =
      parse(small, {{"body.0.mesh", "{ lattice = [100, 100, 100], spacing = 0.01, diagonals = 'space' }"}});
  CHECK(scene.network.nodes().size() == 1'000'000);
  CHECK(scene.network.springs().size() == 6'851'196);
}
