// Scenes that are wrong in one way each: the message has file, line, column, key and remedy.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <unistd.h>

#include "everything.hpp"
#include "facts.hpp"
#include "scenes.hpp"

using springnet::testing::has_facts;

namespace {

// A scene with one mark '^' before the place that the message has to name.
struct Marked {
  std::string text, place;
  explicit Marked(std::string marked) : text(std::move(marked)) {
    const std::size_t mark = text.find('^');
    REQUIRE(mark != std::string::npos);
    text.erase(mark, 1);
    const std::string before = text.substr(0, mark);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t start = before.rfind('\n');
    place = fmt::format("test.toml:{}:{}: ", line, mark - (start == std::string::npos ? 0 : start + 1) + 1);
  }
};

struct Case {
  std::string scene;
  std::vector<std::string> words;
};

void check(const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    const Marked marked(c.scene);
    const std::string message = refusal(marked.text);
    CAPTURE(c.scene);
    CAPTURE(message);
    CAPTURE(marked.place);
    CHECK(message.starts_with(marked.place));
    for (const std::string& word : c.words) {
      CAPTURE(word);
      CHECK(has_facts(message, word));
    }
  }
}

// The small scene with another line in place of one of its own.
std::string replaced(std::size_t line, const std::string& other) {
  std::string text = small;
  std::size_t begin = 0;
  for (std::size_t i = 1; i < line; ++i) begin = text.find('\n', begin) + 1;
  return text.replace(begin, text.find('\n', begin) - begin, other);
}

std::string added(const std::string& more) { return small + more + "\n"; }

}  // namespace

TEST_CASE("the unchanged scene is accepted, so that refusals below are due to the change") {
  CHECK(refusal(small) == "");
}

TEST_CASE("unknown keys, with the nearest known one") {
  check({
      {replaced(2, "^duratoin = 1.0"), {"simulation.duratoin", "no key 'duratoin'", "did you mean 'duration'?"}},
      {replaced(6, "mesh = { lattice = [3, 3, 3], ^spaceing = 1.0 }"), {"body.0.mesh.spaceing", "'spacing'"}},
      {replaced(8, "spring = { type = \"linear\", ^stifness = 3.0 }"),
       {"body.0.spring.stifness", "'stifness' | 'linear'", "did you mean 'stiffness'?", "known: type, stiffness"}},
      {added("[^gravitation]\nacceleration = [0, 0, -1]"),
       {"gravitation", "known: version, title, rules, simulation, gravity"}},
      {added("[[^bodies]]\nname = \"b\""), {"bodies", "known: "}},
      {added("[[fix]]\nselect = { ^noeds = [0] }"), {"fix.0.select.noeds", "did you mean 'nodes'?"}},
      {added("[[node]]\nselect = { nodes = [0] }\nneuron = { type = \"point_mass\", ^mass = 1 }"),
       {"node.0.neuron.mass", "known: type"}},
  });
}

TEST_CASE("wrong types") {
  check({
      {replaced(2, "duration = ^\"long\""), {"simulation.duration", "number | is a text"}},
      {replaced(2, "duration = ^[1]"), {"number | is a list"}},
      {replaced(2, "duration = ^2020-01-01"), {"number | is a date"}},
      {replaced(5, "name = ^7"), {"body.0.name", "text in quotes | is a number"}},
      {replaced(5, "name = ^\"\""), {"must not be empty"}},
      {replaced(6, "mesh = ^3"), {"body.0.mesh", "table with a lattice, a file or points | is a number"}},
      {replaced(6, "mesh = { lattice = ^3, spacing = 1.0 }"), {"list | is a number"}},
      {replaced(6, "mesh = { lattice = ^[3, 3], spacing = 1.0 }"), {"3 elements | has 2"}},
      {replaced(6, "mesh = { lattice = [3, ^2.5, 3], spacing = 1.0 }"),
       {"body.0.mesh.lattice.1", "whole number, is 2.5"}},
      {replaced(8, "spring = ^\"linear\""), {"table with type and parameters | is a text"}},
      {replaced(8, "spring = { type = \"linear\", stiffness = ^\"3 N/m\" }"), {"number | is a text"}},
      {replaced(8, "spring = { type = \"linear\", stiffness = ^\"granite\" }"), {"number | 'granite' | very soft"}},
      {added("^gravity = [0, 0, -1]"), {"body.0.gravity", "no key 'gravity'"}},
      {"body = ^3\n" + simulation, {"body"}},
      {added("[gravity]\nacceleration = ^-9.81"), {"gravity.acceleration", "numbers [x, y, z] | is a number"}},
      {added("[gravity]\nacceleration = ^[0, -9.81]"), {"3 elements | has 2"}},
      {added("[gravity]\nacceleration = [0, 0, ^\"down\"]"), {"gravity.acceleration.2", "must be a number"}},
      {added("[output]\ntrajectory = ^1"), {"output.trajectory", "true or false | is a number"}},
      {added("[output]\nnodes = ^[0]"), {"output.nodes", "table with a selection | is a list"}},
      {added("[output]\nnodes = { nodes = [^27] }"), {"output.nodes.nodes.0", "there is no node 27"}},
      {added("[output]\nsprings = ^{ box = { min = [9, 9, 9] } }"), {"output.springs", "selects no spring"}},
      {added("[output]\nquantities = [\"force\", ^\"speed\"]"), {"output.quantities.1", "must be one of 'position'"}},
      {added("[output]\nquantities = ^[]"), {"output.quantities", "quantity", "output.trajectory = false"}},
      {added("[output]\nformat = ^\"binry\""), {"output.format", "did you mean 'binary'"}},
      {added("[output]\nprecision = ^\"half\""), {"output.precision", "must be one of 'double', 'single'"}},
      {added("[output]\nstates = ^true"), {"output.states", "no spring or element", "internal states"}},
      {added("[output]\nenergies = ^1"), {"output.energies", "true or false | is a number"}},
      {added("[output]\nvtk_interval = ^-1"), {"output.vtk_interval", "at least 0"}},
      {added("^[fix]\nselect = { nodes = [0] }"), {"[[fix]]"}},
      {added("[[fix]]\nselect = ^[0]"), {"fix.0.select", "table with a selection | is a list"}},
      {added("[[spring]]\nselect = {}\nspring = ^\"soft\""), {"\"none\" to remove"}},
  });
}

TEST_CASE("missing keys are named, with an example") {
  check({
      {"^\n", {"'simulation' | missing"}},
      {"^[simulation]\nduration = 1.0\n", {"simulation | 'time_step' | missing | a number above 0, s"}},
      {"^" + simulation, {"[[body]]"}},
      {simulation + "^[[body]]\nmesh = {}", {"body.0 | 'name' | missing | a text"}},
      {simulation + "^[[body]]\nname = \"a\"\n", {"body.0 | mesh = | 'nodes'"}},
      {replaced(6, "mesh = ^{ spacing = 1.0 }"), {"'lattice' | missing"}},
      {replaced(6, "mesh = ^{ lattice = [3, 3, 3] }"), {"'spacing' | missing"}},
      {replaced(7, "neuron = ^{ mass = 1.0 }"), {"'type' | missing | the name of a neuron"}},
      {replaced(7, "neuron = ^{ type = \"point_mass\" }"), {"'mass'", "'density' | kg/m^3"}},
      {replaced(8, "spring = ^{ stiffness = 3.0 }"), {"'type' | missing | the name of a spring function"}},
      {added("^[[fix]]"), {"fix.0 | 'select' | missing"}},
      {added("^[[force]]\nselect = {}"), {"force = | total = | traction = | pressure ="}},
      {added("^[[plane]]\npoint = [0, 0, 0]"), {"'normal' | missing"}},
      {added("^[[cut]]\nselect = {}"), {"'time' | missing"}},
      {added("^[[cut]]\ntime = 1"), {"'select' | 'polygon'"}},
      {added("^[[node]]\nselect = {}"), {"'mass' | 'velocity' | 'neuron'"}},
      {added("^[[spring]]\nselect = {}"), {"'spring' | 'rest_length'"}},
      {added("[[fix]]\nselect = { box = ^{} }"), {"'min' | 'max'"}},
      {added("[[fix]]\nselect = { sphere = ^{ center = [0, 0, 0] } }"), {"'radius' | missing"}},
  });
  // A parameter that the law requires.
  const std::string message = refusal(replaced(8, "spring = { type = \"linear\" }"));
  CAPTURE(message);
  CHECK(has_facts(message, "test.toml:8:10: | body.0.spring | 'linear' | 'stiffness' | N/m"));
}

TEST_CASE("missing laws and unknown components, with the nearest known ones") {
  check({
      {simulation + "^[[body]]\nname = \"a\"\nmesh = { lattice = [2, 1, 1], spacing = 1 }\n"
                    "neuron = { type = \"point_mass\", mass = 1 }",
       {"body.0 | 'spring' | 'viscosity' | 'material'", "add spring = "}},
      {replaced(8, "spring = { type = ^\"linaer\", stiffness = 3.0 }"),
       {"body.0.spring.type", "no spring function 'linaer'", "did you mean 'linear'?",
        "known: damaging, exponential, fibre_solid, linear"}},
      {replaced(8, "spring = { type = ^\"relative\", damping = 3.0 }"), {"'relative' is a viscosity function"}},
      {replaced(7, "neuron = { type = ^\"point\", mass = 1.0 }"), {"'point' | did you mean 'point_mass'?"}},
      {"[simulation]\nintegrator = ^\"newton\"\nduration = 1\ntime_step = 1",
       {"no integrator 'newton'", "known: cvode"}},
      {"[simulation]\nintegrator = { name = ^\"cvod\" }\nduration = 1\ntime_step = 1", {"'cvode'"}},
      {added("^[[connect]]\npairs = [[{ node = 0 }, { node = 5 }]]"), {"add spring = "}},
  });
}

TEST_CASE("an unknown law names the plugins that were not taken") {
  springnet::PluginHost host;
  host.load("/nowhere/broken.springnet.so");
  try {
    static_cast<void>(springnet::parse_scene(small, "s.toml", host));
    FAIL("taken");
  } catch (const springnet::Error& error) {
    const std::string message = error.what();
    CAPTURE(message);
    CHECK(error.kind() == springnet::ErrorKind::input);
    CHECK(has_facts(message, "s.toml:7:19: | body.0.neuron.type | 'point_mass'"));
    CHECK(has_facts(message, "/nowhere/broken.springnet.so: cannot be opened"));
  }
}

TEST_CASE("numbers out of range, nan, inf and numbers too great for any") {
  check({
      {replaced(7, "neuron = { type = \"point_mass\", mass = ^-1.0 }"), {"body.0.neuron.mass", "above 0 kg | is -1"}},
      {replaced(7, "neuron = { type = \"point_mass\", mass = ^0 }"), {"above 0 kg | is 0"}},
      {replaced(7, "neuron = { type = \"point_mass\", mass = ^nan }"), {"number | is nan"}},
      {replaced(7, "neuron = { type = \"point_mass\", mass = ^inf }"), {"finite number | is inf"}},
      {replaced(7, "neuron = { type = \"dragged\", mass = 1, drag = ^-1 }"), {"at least 0 kg/s | is -1"}},
      {replaced(8, "spring = { type = \"linear\", stiffness = ^-3.0 }"),
       {"body.0.spring.stiffness", "at least 0 N/m | is -3"}},
      {replaced(8, "spring = { type = \"linear\", stiffness = ^nan }"), {"number | is nan"}},
      {replaced(8, "spring = { type = \"linear\", stiffness = ^-inf }"), {"finite number | is -inf"}},
      {replaced(8, "spring = { type = \"linear\", stiffness = 1e400^ }"), {"'1e400'", "not TOML"}},
      {replaced(2, "duration = ^-1"), {"at least 0 s | is -1"}},
      {replaced(3, "time_step = ^0"), {"above 0 s | is 0"}},
      {replaced(3, "time_step = 0.1\nthreads = ^-1"), {"at least 0 | is -1"}},
      {replaced(3, "time_step = 0.1\nthreads = ^5000"), {"at most 1024 | is 5000"}},
      {replaced(3, "time_step = 0.1\nthreads = ^1.5"), {"whole number | is 1.5"}},
      {replaced(3, "time_step = 0.1\ninstruction_set = ^\"avx3\""), {"must be one of 'best'", "did you mean"}},
      {replaced(3, "time_step = 0.1\nintegrator = { name = \"recurrent\", update = ^\"wave\" }"),
       {"simulation.integrator.update", "must be one of 'synchronous', 'wavefront'", "is 'wave'; did you mean"}},
      {replaced(3, "time_step = 0.1\nintegrator = { name = \"recurrent\", max_sweeps = ^10.5 }"),
       {"whole number, is 10.5"}},
      {replaced(6, "mesh = { lattice = [3, ^0, 3], spacing = 1.0 }"), {"at least 1 | is 0"}},
      {replaced(6, "mesh = { lattice = [3, 3, ^5000000000], spacing = 1.0 }"), {"at most 4294967295"}},
      {replaced(6, "mesh = ^{ lattice = [4000, 4000, 4000], spacing = 1.0 }"), {"6.4e+10 nodes", "use fewer nodes"}},
      {replaced(6, "mesh = { lattice = [3, 3, 3], spacing = ^0.0 }"), {"above 0 m | is 0"}},
      {replaced(6, "mesh = { lattice = [3, 3, 3], spacing = [1, ^-1, 1] }"), {"body.0.mesh.spacing.1", "is -1"}},
      {replaced(6, "mesh = ^{ lattice = [3, 3, 3], spacing = 1e308 }"), {"is inf"}},
      {replaced(6, "mesh = { lattice = [3, 3, 3], spacing = 1, diagonals = ^\"spaces\" }"), {"did you mean 'space'?"}},
      {added("velocity = [0, ^nan, 0]"), {"body.0.velocity.1", "is nan"}},
      {added("rest_length_scale = ^0"), {"above 0 | is 0"}},
      {added("[gravity]\nacceleration = [0, 0, ^-inf]"), {"is -inf"}},
      {added("[output]\ninterval = ^-0.1"), {"at least 0 s"}},
      {added("[[node]]\nselect = {}\nmass = ^0"), {"above 0 kg"}},
      {added("[[spring]]\nselect = {}\nrest_length = ^-1"), {"at least 0 m"}},
      {added("[[force]]\nselect = {}\nforce = [0, 0, ^nan]"), {"force.0.force.2"}},
      {added("[[force]]\nselect = {}\nforce = [0, 0, 1]\nfrom = 2\nuntil = ^1"), {"which is never"}},
      {added("[[plane]]\npoint = [0, 0, 0]\nnormal = ^[0, 0, 0]"), {"must not be zero"}},
      {added("[[cut]]\ntime = ^-1\nselect = {}"), {"at least 0 s"}},
      {added("[[cut]]\ntime = 1\npolygon = ^[[0, 0, 0], [1, 0, 0]]"), {"three corners | has 2"}},
      {added("[[cut]]\ntime = 1\npolygon = ^[]"), {"has no corners"}},
      {added("[[cut]]\ntime = 1\npolygon = ^[[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]]"), {"must be planar"}},
      {added("[[fix]]\nselect = { box = { min = [0, 0, ^nan] } }"), {"is nan"}},
      {added("[[fix]]\nselect = { box = ^{ min = [0, 1, 0], max = [1, 0, 1] } }"), {"'min' | 'max'"}},
      {added("[[fix]]\nselect = { sphere = { center = [0, 0, 0], radius = ^0 } }"), {"above 0 m"}},
  });
}

TEST_CASE("nodes and springs that are refused") {
  const std::string body = simulation + R"([[body]]
name = "a"
neuron = { type = "point_mass", mass = 1 }
spring = { type = "linear", stiffness = 1 }
)";
  const std::string plane = "[[plane]]\nname = \"p\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n";
  check({
      {body + "nodes = [[0, 0, 0], [1, 0, 0]]\nsprings = [[0, 1], ^[1, 1]]",
       {"body.0.springs.1", "joins a node to itself"}},
      {body + "nodes = [[0, 0, 0], [1, 0, 0]]\nsprings = [[0, ^2]]", {"node 2 | has 2"}},
      {body + "nodes = [[0, 0, 0], [1, 0, 0]]\nsprings = [[^-1, 0]]", {"at least 0 | is -1"}},
      {body + "nodes = [[0, 0, 0], [1, 0, 0]]\nsprings = [^[0]]", {"2 elements | has 1"}},
      {body + "nodes = [[1, 0, 0], [1, 0, 0]]\nsprings = [^[0, 1]]", {"has length zero", "move one"}},
      {body + "nodes = [[1, 0, 0], [1, ^inf, 0]]\nsprings = [[0, 1]]", {"finite number | is inf"}},
      {body + "nodes = ^[]", {"lists no node"}},
      {simulation + "^[[body]]\nname = \"a\"\nneuron = { type = \"point_mass\", mass = 1 }\n"
                    "nodes = [[0, 0, 0], [1, 0, 0]]\nsprings = [[0, 1]]",
       {"'spring' | 'viscosity' | 'material'"}},
      {simulation + "^[[body]]\nname = \"a\"\nmesh = {}\nnodes = [[0, 0, 0]]", {"'mesh' | 'nodes'"}},
      {added("springs = ^[[0, 1]]"), {"mesh | springs"}},
      {added("[[body]]\nname = ^\"a\"\nmesh = {}"), {"body.1.name", "name"}},
      {added(plane + "^" + plane), {"two planes 'p'"}},
  });
}

TEST_CASE("connections that are refused") {
  const std::string law = "spring = { type = \"linear\", stiffness = 1 }\n";
  check({
      {added("^[[connect]]\n" + law), {"'pairs' | 'from' | 'within'"}},
      {added("[[connect]]\n" + law + "pairs = ^[]"), {"lists no pair"}},
      {added("[[connect]]\n" + law + "pairs = [^[{ node = 4 }, { body = \"a\", node = 4 }]]"),
       {"joins a node to itself"}},
      {added("[[connect]]\n" + law + "pairs = [[{ node = ^27 }, { node = 4 }]]"), {"node 27 | the network | has 27"}},
      {added("[[connect]]\n" + law + "pairs = [[{ body = ^\"b\", node = 1 }, { node = 4 }]]"),
       {"there is no body 'b'"}},
      {added("[[connect]]\n" + law + "pairs = [[^{ body = \"a\" }, { node = 4 }]]"), {"'node' | missing"}},
      {added("[[connect]]\n" + law + "pairs = [[{ node = 0 }, { node = 4 }]]\nwithin = ^1"), {"combined with 'pairs'"}},
      {added("^[[connect]]\n" + law + "from = {}\nto = {}"), {"needs either within"}},
      {added("^[[connect]]\n" + law + "from = {}\nto = {}\nwithin = 1\nnearest = true"), {"needs either within"}},
      {added("^[[connect]]\n" + law + "from = {}\nto = {}\nnearest = false"), {"needs either within"}},
      {added("[[connect]]\n" + law + "from = {}\nto = {}\nwithin = ^0.5"), {"no two nodes", "increase the distance"}},
      {added("[[connect]]\n" + law + "from = {}\nto = {}\nwithin = ^-1"), {"above 0 m"}},
      {added("[[connect]]\n" + law + "from = {}\nto = {}\nwithin = 1\nrest_length = 1\nrest_length_scale = ^1"),
       {"combined with 'rest_length'"}},
  });
}

TEST_CASE("rigid connections that are refused") {
  const std::string pair = "pairs = [[{ node = 0 }, { node = 1 }]]\n";
  check({
      {added("^[[rigid]]"), {"rigid.0 | 'pairs' | 'from' | 'within'"}},
      {added("[[rigid]]\npairs = ^[]"), {"lists no pair"}},
      {added("[[rigid]]\npairs = [^[{ node = 4 }, { node = 4 }]]"), {"joins a node to itself"}},
      {added("[[rigid]]\npairs = [[{ node = 4 }, { ^nod = 5 }]]"), {"rigid.0.pairs.0.1.nod", "known: body, node"}},
      {added("[[rigid]]\n" + pair + "^spring = 1"), {"no key 'spring'", "did you mean 'springs'"}},
      {added("[[rigid]]\n" + pair + "length = ^2"), {"rigid.0.length", "2 m | 1 m", "length"}},
      {added("[[rigid]]\n" + pair + "length = ^0"), {"above 0 m | is 0"}},
      {added("[[rigid]]\n" + pair + "^[[rigid]]\n" + pair), {"rigid.1", "two | node 0 | node 1"}},
      {added("^[[rigid]]\nfrom = {}\nto = {}"), {"needs either within"}},
      {added("[[rigid]]\nfrom = {}\nto = {}\nwithin = ^0.5"), {"no two nodes", "increase the distance"}},
      {added("[[rigid]]\nsprings = ^{ nodes = [0] }"), {"selects no spring"}},
      {added("[[rigid]]\nsprings = {}\nwithin = ^1"), {"'springs'"}},
      {added("[[rigid]]\nsprings = {}\npairs = ^[]"), {"'springs'"}},
  });
}

TEST_CASE("motions and obstacles that are refused") {
  const std::string move = "[[move]]\nselect = { nodes = [0] }\n";
  const std::string table = "table = [[0, 0, 0, 0], [1, 0, 0, 1]]\n";
  const std::string sinusoid = "sinusoid = { amplitude = [1, 0, 0], frequency = 1 }\n";
  const std::string plane = "[[plane]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\n";
  const std::string ball = "[[instrument]]\nsphere = { center = [9, 9, 9], radius = 1 }\n";
  const std::string box = "[[instrument]]\nbox = { center = [9, 9, 9], ";
  check({
      {added("^[[move]]\n" + table), {"move.0 | 'select' | missing"}},
      {added("^" + move), {"move.0 | table = | sinusoid ="}},
      {added(move + "table = ^[]"), {"two rows [t, x, y, z] | has 0"}},
      {added(move + "table = ^[[0, 0, 0, 0]]"), {"or more, has 1"}},
      {added(move + "table = [[0, 0, 0, 0], ^[1, 0, 0]]"), {"move.0.table.1", "4 elements | has 3"}},
      {added(move + "table = [[0, 0, 0, 0], [1, 0, 0, ^nan]]"), {"move.0.table.1.3", "is nan"}},
      {added(move + "table = [[0, 0, 0, 0], [2, 0, 0, 1], [^1, 0, 0, 0]]"), {"move.0.table.2.0", "1 s follows 2 s"}},
      {added(move + "table = [[0, 0, 0, 0], [^0, 0, 0, 1]]"), {"0 s follows 0 s"}},
      {added(move + table + "interpolation = ^\"cubic\""), {"'smooth', 'linear' | is 'cubic'"}},
      {added(move + table + "sinusoid = ^{ amplitude = [1, 0, 0], frequency = 1 }"), {"move.0.sinusoid | 'table'"}},
      {added(move + table + "from = ^1"), {"'table'"}},
      {added(move + table + "until = ^1"), {"'table'"}},
      {added(move + sinusoid + "interpolation = ^\"linear\""), {"'sinusoid'"}},
      {added(move + "sinusoid = ^{ frequency = 1 }"), {"'amplitude' | missing"}},
      {added(move + "sinusoid = ^{ amplitude = [1, 0, 0] }"), {"'frequency' | missing"}},
      {added(move + "sinusoid = { amplitude = ^[0, 0, 0], frequency = 1 }"), {"must not be zero"}},
      {added(move + "sinusoid = { amplitude = [1, 0, 0], frequency = ^0 }"), {"above 0 Hz | is 0"}},
      {added(move + "sinusoid = { amplitude = [1, 0, 0], frequency = 1, ^pahse = 0 }"), {"did you mean 'phase'?"}},
      {added(move + sinusoid + "from = 2\nuntil = ^1"), {"'from' | 2 s | 1 s"}},
      {added(move + sinusoid + "until = ^0"), {"'from' | 0 s"}},
      {added(move + sinusoid + "from = ^inf"), {"must be a finite number"}},
      {added(move + table + "[[move]]\nselect = ^{ nodes = [0, 1] }\n" + sinusoid), {"node 0 is moved twice"}},
      {added(plane + "friction = ^\"hold\""), {"'held' | 'none' | 'hold' | did you mean 'held'?"}},
      {added(plane + "friction = ^-0.1"), {"at least 0 | is -0.1"}},
      {added(plane + "friction = ^true"),
       {"plane.0.friction", "'held', 'none' or a coefficient of friction | is true or false"}},
      {added(plane + "motion = ^{}"), {"plane.0.motion | table = | sinusoid ="}},
      {added(plane + "motion = ^1"), {"table or sinusoid | is a number"}},
      {added(plane + "motion = { ^select = {} }"), {"plane.0.motion.select", "known: table, interpolation, sinusoid"}},
      {added("^[[instrument]]\nname = \"tip\""), {"instrument.0 | sphere = | capsule = | box ="}},
      {added("^" + ball + "capsule = { from = [0, 0, 9], to = [0, 0, 8], radius = 1 }"),
       {"sphere = | capsule = | box ="}},
      {added("[[instrument]]\nsphere = ^{ center = [9, 9, 9] }"), {"'radius' | missing"}},
      {added("[[instrument]]\nsphere = { center = [9, 9, 9], radius = ^0 }"), {"above 0 m | is 0"}},
      {added("[[instrument]]\ncapsule = ^{ from = [9, 9, 9], radius = 1 }"), {"'to' | missing"}},
      {added("[[instrument]]\ncapsule = { from = [9, 9, 9], to = [9, 9, 8], radius = ^-1 }"), {"above 0 m"}},
      {added(ball + "friction = ^\"nono\""), {"did you mean 'none'?"}},
      {added("^" + ball + "box = { center = [9, 9, 9], size = [1, 1, 1] }"), {"sphere = | capsule = | box ="}},
      {added("[[instrument]]\nbox = ^{ size = [1, 1, 1] }"), {"instrument.0.box | 'center' | missing"}},
      {added(box + "size = ^[1, 1] }"), {"instrument.0.box.size", "3 elements | has 2"}},
      {added(box + "size = [1, ^0, 1] }"), {"instrument.0.box.size.1 | above 0 m | is 0"}},
      {added(box + "size = [1, 2, 3], radius = ^0.6 }"), {"0.5 m | 0.6 m"}},
      {added(box + "size = [1, 2, 3], radius = ^-1 }"), {"at least 0 m | is -1"}},
      {added(box + "size = [1, 2, 3], rotation = { axis = ^[0, 0, 0], angle = 1 } }"), {"has length zero"}},
      {added(box + "size = [1, 2, 3], rotation = ^{ axis = [0, 0, 1] } }"), {"'angle' | missing"}},
      {added(plane + "restitution = ^1.5"), {"plane.0.restitution | at most 1 | is 1.5"}},
      {added(ball + "restitution = ^-0.5"), {"instrument.0.restitution | at least 0 | is -0.5"}},
      {added(plane + "turn = ^{ axis = [0, 0, 1] }"), {"plane.0.turn | rate = | table ="}},
      {added(plane + "turn = ^{ rate = 1 }"), {"'axis' | missing"}},
      {added(plane + "turn = ^1"), {"table with axis, and rate or table | is a number"}},
      {added(plane + "turn = { axis = ^[0, 0, 0], rate = 1 }"), {"length zero | direction"}},
      {added(plane + "turn = { axis = [0, 0, 1], rate = ^0 }"), {"0 rad/s"}},
      {added(plane + "turn = { axis = [0, 0, 1], rate = ^inf }"), {"must be a finite number"}},
      {added(plane + "turn = { axis = [0, 0, 1], rate = 1, from = 1, until = ^1 }"), {"above 'from', 1 s"}},
      {added(plane + "turn = { axis = [0, 0, 1], rate = 1, interpolation = ^\"linear\" }"),
       {"plane.0.turn.interpolation | 'rate'"}},
      {added(plane + "turn = { axis = [0, 0, 1], table = [[0, 0], [1, 2]], rate = ^1 }"),
       {"plane.0.turn.rate | 'table'"}},
      {added(plane + "turn = { axis = [0, 0, 1], table = [[0, 0], ^[1, 2, 3]] }"), {"2 elements | has 3"}},
      {added(ball + "turn = { axis = [0, 0, 1], table = ^[[0, 0]] }"), {"two rows [t, angle] | has 1"}},
      {added(ball + "turn = { axis = [0, 0, 1], ^angle = 1 }"), {"instrument.0.turn.angle", "known: axis, through"}},
      {added(ball + "motion = { table = ^[] }"), {"instrument.0.motion.table", "needs two rows"}},
      {added(plane + "name = \"a\"\n^" + ball + "name = \"a\""), {"plane 'a' | instrument 'a'"}},
  });
}

TEST_CASE("two nodes at one place need a rest length to be connected") {
  const std::string twice = added(
      "[[body]]\nname = \"b\"\nnodes = [[0, 0, 0]]\nneuron = { type = \"point_mass\", mass = 1 }\n"
      "[[connect]]\nspring = { type = \"linear\", stiffness = 1 }\n"
      "pairs = [[{ body = \"a\", node = 0 }, { body = \"b\", node = 0 }]]\n");
  const std::string message = refusal(twice);
  CAPTURE(message);
  CHECK(message.starts_with("test.toml:13:1: connect.0: "));
  CHECK(has_facts(message, "length zero"));
  CHECK(refusal(twice + "rest_length = 0.5\n") == "");
}

TEST_CASE("selections of nothing, or of something that does not exist") {
  check({
      {added("[[fix]]\nselect = ^{ box = { min = [9, 9, 9], max = [10, 10, 10] } }"),
       {"fix.0.select | no node", "[0, 0, 0] | [2, 2, 2]"}},
      {added("[[fix]]\nselect = ^{ nodes = [] }"), {"selects no node"}},
      {added("[[fix]]\nselect = { nodes = [0, ^27] }"), {"node 27 | the network | has 27"}},
      {added("[[fix]]\nselect = { body = \"a\", nodes = [0, ^27] }"), {"node 27 | body 'a'"}},
      {added("[[fix]]\nselect = { nodes = [^-1] }"), {"at least 0"}},
      {added("[[fix]]\nselect = { body = ^\"A\" }"), {"'A' | did you mean 'a'?"}},
      {added("[[fix]]\nselect = { body = ^[] }"), {"names no body"}},
      {added("[[fix]]\nselect = { body = [\"a\", \"a\"], nodes = ^[0] }"), {"one body"}},
      {added("[[fix]]\nselect = { springs = ^[0] }"), {"'nodes' | springs"}},
      {added("[[cut]]\ntime = 0\nselect = { springs = [^54] }"), {"spring 54 | the network | has 54"}},
      {added("[[cut]]\ntime = 0\nselect = ^{ nodes = [0] }"), {"no spring | both ends"}},
      {added("[[spring]]\nselect = ^{ sphere = { center = [0, 0, 0], radius = 0.5 } }\nrest_length = 1"),
       {"selects no spring"}},
  });
}

TEST_CASE("a spring cannot lose all of its functions") {
  check(
      {{added("^[[spring]]\nselect = { springs = [5] }\nspring = \"none\""), {"spring 5 | function", "use [[cut]]"}}});
}

TEST_CASE("text that is not TOML") {
  check({
      {"[simulation]\nduration = 1\nduration = ^2", {"cannot redefine"}},
      {"[simulation^\nduration = 1", {"not TOML"}},
  });
  CHECK(has_facts(refusal("a = \"\xff\""), "test.toml:1:"));
}

TEST_CASE("a scene that was cut short or damaged anywhere is taken or refused, and nothing else happens") {
  const std::string whole = everything;
  std::size_t taken = 0, refused = 0;
  const auto count = [&](const std::string& text) {
    const std::string message = refusal(text);
    CHECK_FALSE(message.starts_with("not an error of input"));
    ++(message.empty() ? taken : refused);
  };
  for (std::size_t i = 0; i < whole.size(); i += 5) {
    CAPTURE(i);
    count(whole.substr(0, i));
    std::string damaged = whole;
    damaged[i] = "]0-\"\xff"[i / 5 % 5];
    count(damaged);
  }
  CHECK(taken > 0);  // damage in comments, another digit
  CHECK(refused > taken);
}

TEST_CASE("files that cannot be read") {
  namespace fs = std::filesystem;
  const auto load = [](const fs::path& file) -> std::string {
    try {
      static_cast<void>(springnet::load_scene(file, plugins()));
    } catch (const springnet::Error& error) {
      CHECK(error.kind() == springnet::ErrorKind::input);
      return error.what();
    }
    return {};
  };
  CHECK(has_facts(load("nowhere.toml"), "nowhere.toml: | No such file"));
  const fs::path folder = fs::temp_directory_path() / fmt::format("springnet_scene_test_{}", getpid());
  fs::create_directories(folder);
  CHECK(has_facts(load(folder), "folder"));
  const fs::path file = folder / "wrong.toml";
  std::ofstream(file) << "[simulation]\nduration = -1\n";
  CHECK(load(file).starts_with(file.string() + ":2:12: simulation.duration: "));
  std::ofstream(file, std::ios::trunc) << small;
  CHECK(load(file) == "");
  fs::remove_all(folder);
}
