// Scenes that are small to write and would be costly to read: refused before anything is made of them.
#include <sys/stat.h>

#include <string>

#include <doctest/doctest.h>

#include "facts.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using springnet::testing::has_facts;

namespace {

std::string repeated(const std::string& piece, std::size_t count) {
  std::string text;
  for (std::size_t k = 0; k < count; ++k) text += piece;
  return text;
}

std::string load_refusal(const std::filesystem::path& file) {
  try {
    static_cast<void>(load_scene(file, plugins()));
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    return error.what();
  }
  return {};
}

const std::string too_deep = "nests deeper than 32 levels";

}  // namespace

TEST_CASE("too deep nesting is refused with its place, before the TOML library sees it") {
  // An overflow of the stack in that library, for keys with many dots.
  CHECK(refusal("a" + repeated(".a", 100'000) + " = 1").starts_with("test.toml:1:66: this nests deeper"));
  CHECK(has_facts(refusal(small + "[a" + repeated(".a", 100'000) + "]"), "test.toml:9:65: this nests deeper"));
  CHECK(has_facts(refusal("[[a" + repeated(" . \"a.b\"", 100'000) + "]]"), too_deep));
  CHECK(has_facts(refusal("a = " + repeated("[", 100'000)), too_deep));
  CHECK(has_facts(refusal("a = " + repeated("[\n # [\n", 100'000)), too_deep));
  CHECK(has_facts(refusal("a = " + repeated("{ a = ", 100'000)), too_deep));
  CHECK(has_facts(refusal("a = " + repeated("{ a.a = [", 12)), too_deep));
  CHECK(has_facts(refusal("a = \"\"\"\n\\\"\"\" ' # \"\"\"\"\"\nb = " + repeated("[", 33)),
                  "test.toml:3:37: this nests"));
  CHECK(has_facts(refusal("a = '''\n'' \\ ''''\nb = " + repeated("[", 33)), "test.toml:3:37: this nests"));
}

TEST_CASE("brackets and dots that do not nest are no levels") {
  const std::string harmless =
      repeated("# [{[{[{ a.a.a.a \" ' '''\n", 50) + "title = '''\n" + repeated("[{ .. \"", 50) + "'''\n";
  CHECK(refusal(harmless + small) == "");
  const std::string escaped = "title = \"" + repeated("\\\"[.{", 50) + "\"\n";
  CHECK(refusal(escaped + small) == "");
  const std::string many_quotes = "title = \"\"\"" + repeated("\"\"[[..\\\\\\\"", 50) + "\"\"\"\"\"\n";
  CHECK(refusal(many_quotes + small) == "");
  const std::string list = repeated("[0.5, 1.5,\n 2.5], ", 500);
  CHECK(refusal(simulation + "[[body]]\nname = \"a\"\nneuron = { type = \"point_mass\", mass = 1 }\nnodes = [" + list +
                "]\n") == "");
  CHECK(has_facts(refusal("a" + repeated(".a", 31) + " = 1"), "there is no key 'a'"));
  CHECK(has_facts(refusal("a = " + repeated("[", 32) + repeated("]", 32)), "there is no key 'a'"));
}

TEST_CASE("overrides have the same limits") {
  CHECK(has_facts(refusal(small, {{"a" + repeated(".a", 100'000), "1"}}), too_deep));
  CHECK(has_facts(refusal(small, {{"title", repeated("[", 100'000)}}), too_deep));
  CHECK(has_facts(refusal(small, {{"title", "{ a" + repeated(".a", 100'000) + " = 1 }"}}), too_deep));
}

TEST_CASE("a scene has a greatest size") {
  const std::string text = small + "#" + std::string(64'000'000, ' ');
  CHECK(has_facts(refusal(text), "test.toml: | 64,000,000 bytes | mesh file"));
  CHECK(has_facts(load_refusal("/dev/zero"), "/dev/zero: | 64,000,000 bytes"));
}

TEST_CASE("a pipe without a writer is refused") {
  const testing::TemporaryFolder folder;
  const std::filesystem::path pipe = folder.path() / "pipe.toml";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(has_facts(load_refusal(pipe), "pipe.toml: | pipe"));
  CHECK(has_facts(load_refusal("/dev/null"), "'simulation'"));
}

TEST_CASE("texts are quoted shortened") {
  const std::string name(1'000'000, 'x');
  const auto quotes_little = [](const std::string& message) { return !message.empty() && message.size() < 2000; };
  CHECK(has_facts(refusal(name + " = 1"), std::string(60, 'x') + "… (1,000,000 characters)'; known: "));
  CHECK(quotes_little(refusal(name + " = 1")));
  CHECK(quotes_little(refusal(name + " = 1\n" + name + " = 2")));
  CHECK(quotes_little(refusal("[" + name + "]\n[" + name + "]")));
  CHECK(quotes_little(refusal("title = " + name)));
  CHECK(quotes_little(refusal(small + "[[fix]]\nselect = { body = \"" + std::string(4000, 'x') + "\" }")));
  CHECK(has_facts(refusal("title = \"" + name + "\"\n" + small), "4,096 | 1,000,000"));
  CHECK(quotes_little(refusal(small, {{name, "1"}})));
  CHECK(quotes_little(refusal(small, {{"title", name}})));
  CHECK(quotes_little(refusal(small, {{"simulation.duration." + name, "1"}})));
}

TEST_CASE("a scene may name its version") {
  CHECK(refusal("version = 1\n" + small) == "");
  const std::string newer = refusal("version = 2\nwhat_comes_then = true\n" + small);
  CHECK(has_facts(newer, "test.toml:1:11: | version 2 | version 1 | version = 1"));
  CHECK(has_facts(refusal("version = 0\n" + small), "must be at least 1"));
  CHECK(has_facts(refusal("version = \"1\"\n" + small), "whole number | a text"));
}

TEST_CASE("springs and rigid connections found by distance are counted before they are made") {
  const std::string many = simulation +
                           "[[body]]\nname = \"a\"\nmesh = { lattice = [20, 20, 20], spacing = 1.0 }\n"
                           "neuron = { type = \"point_mass\", mass = 1.0 }\n"
                           "spring = { type = \"linear\", stiffness = 3.0 }\n";
  const std::string all = "from = {}\nto = {}\nwithin = 100.0\n";
  const std::string connect = refusal(many + "[[connect]]\nspring = { type = \"linear\", stiffness = 1 }\n" + all);
  CHECK(has_facts(connect, "test.toml:13:10: connect.0.within: | 10,000,000 | 8,000 | 'from' | 'to'"));
  CHECK(has_facts(connect, "lower the distance"));
  const std::string rigid = refusal(many + "[[rigid]]\n" + all);
  CHECK(has_facts(rigid, "test.toml:12:10: rigid.0.within: | 320,000"));
  CHECK(has_facts(rigid, "at most 20 a node"));
  // Springs that were joined to be rigid.
  const std::string law = "[[connect]]\nspring = { type = \"linear\", stiffness = 1 }\n";
  const std::string dense = refusal(small + law + "from = {}\nto = {}\nwithin = 9.0\n" + law +
                                    "from = {}\nto = {}\nwithin = 9.0\n[[rigid]]\nsprings = {}\n");
  CHECK(dense == "");  // 351 pairs of 27 nodes, each once
}

TEST_CASE("a large rigid piece is noted as costly") {
  const std::string text = simulation +
                           "[[body]]\nname = \"a\"\nmesh = { lattice = [8, 8, 8], spacing = 1.0 }\n"
                           "neuron = { type = \"point_mass\", mass = 1.0 }\n"
                           "spring = { type = \"linear\", stiffness = 3.0 }\n[[rigid]]\nsprings = ";
  const Scene whole = parse(text + "{}");
  REQUIRE(whole.notes.size() == 1);
  CHECK(has_facts(whole.notes[0], "rigid.0 | 512 nodes | 1,344 connections | seconds"));
  CHECK(parse(text + "{ box = { max = [2, 2, 2] } }").notes.empty());
}

TEST_CASE("a lattice that memory cannot hold is refused before it is made") {
  const std::string message =
      refusal(simulation +
              "[[body]]\nname = \"a\"\nmesh = { lattice = [1100, 1100, 1100], spacing = 1.0, diagonals = "
              "\"none\" }\nneuron = { type = \"point_mass\" }\ndensity = 1.0\n"
              "material = { youngs_modulus = 1.0 }\n");
  CHECK(has_facts(message, "test.toml:6:8: body.0.mesh: | lattice 'a' | 1.331e+09 nodes"));
  CHECK(has_facts(message, "GB: use fewer nodes"));
}

TEST_CASE("a cutting polygon has a greatest number of corners") {
  const std::string corners = repeated("[0, 0, 0], ", 10'001);
  CHECK(has_facts(refusal(small + "[[cut]]\ntime = 1\npolygon = [" + corners + "]\n"),
                  "test.toml:11:11: cut.0.polygon: | 10,001 | 10,000"));
}

TEST_CASE("lengths that rounding swallows are refused with the key that puts them there") {
  const std::string body = simulation +
                           "[[body]]\nname = \"a\"\nneuron = { type = \"point_mass\", mass = 1.0 }\n"
                           "spring = { type = \"linear\", stiffness = 3.0 }\n";
  const std::string lattice = refusal(body + "mesh = { lattice = [2, 1, 1], spacing = 1.0, origin = [1e20, 0, 0] }\n");
  CHECK(has_facts(lattice, "test.toml:8:55: body.0.mesh.origin: | spring 0 | node 0 | node 1"));
  CHECK(has_facts(lattice, "rounding | origin"));
  const std::string listed = refusal(body + "nodes = [[1e15, 0, 0], [1000000000000001, 0, 0]]\nsprings = [[0, 1]]\n");
  CHECK(has_facts(listed, "test.toml:8:9: body.0.nodes: | spring 0 | node 0 | node 1"));
  const std::string far = body + "nodes = [[1e9, 0, 0], [1000000001, 0, 0]]\n";
  const std::string pairs = "pairs = [[{ node = 0 }, { node = 1 }]]\n";
  CHECK(refusal(far + "[[connect]]\nspring = { type = \"linear\", stiffness = 1 }\n" + pairs) == "");
  CHECK(has_facts(refusal(far + "[[rigid]]\n" + pairs), "test.toml:9:1: rigid.0: | node 0 | node 1"));
}

TEST_CASE("a node that starts behind an obstacle is refused with the obstacle's place in the scene") {
  const auto refused = [](const std::string& text) -> std::string {
    try {
      check_starts(parse(text));
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::input);
      return error.what();
    }
    return {};
  };
  const std::string floor = "[[plane]]\nname = \"floor\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n";
  const std::string high = "[[plane]]\npoint = [0, 0, 1.5]\nnormal = [0, 0, 1]\n";
  const std::string ball = "[[instrument]]\nsphere = { center = [0, 0, 0], radius = 0.5 }\n";
  CHECK(refused(small + floor) == "");
  CHECK(has_facts(refused(small + floor + high), "test.toml:13:1: plane.1: | node 0 | 1.5 m | plane 1"));
  CHECK(has_facts(refused(small + floor + ball), "test.toml:13:1: instrument.0: | node 0 | 0.5 m | instrument 0"));
  CHECK(refused(small + ball + "motion = { table = [[0, 0, 0, -9], [1, 0, 0, 0]] }\n") == "");
  // Node 0 is at the origin: inside the box, whose nearest face is at x = -0.1, until it is turned upright.
  const std::string box = "[[instrument]]\nbox = { center = [0.4, 0, 0.5], size = [1, 0.5, 0.5] }\n";
  CHECK(refused(small + box) == "");
  const std::string low = "[[instrument]]\nname = \"block\"\nbox = { center = [0.4, 0, 0.1], size = [1, 0.5, 0.5] }\n";
  CHECK(has_facts(refused(small + low), "test.toml:9:1: instrument.0: | node 0 | 0.1 m | instrument 'block'"));
  const std::string turn = "turn = { axis = [0, 1, 0], through = [0.4, 0, 0], table = [[-2, 0], [-1, 1.5707963]] }\n";
  CHECK(refused(small + low + turn) == "");
  // That one comes to be about (0.9, 0, 0), 0.5 m wide: node 1 is at (1, 0, 0).
  CHECK(has_facts(refused(small + box + turn), "node 1 | 0.15 m | instrument 0"));
  CHECK(refused(small + ball + "[[fix]]\nselect = { nodes = [0] }\n") == "");
}

TEST_CASE("planes and instruments that together have too much to do with the nodes are refused") {
  const std::string plane = "[[plane]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\n";
  const std::string ball = "[[instrument]]\nsphere = { center = [0, 0, -9], radius = 0.5 }\n";
  CHECK(refusal(small + repeated(plane, 10) + repeated(ball, 10)) == "");
  CHECK(has_facts(refusal(small + repeated(plane, 10'000) + ball), "instrument.0: | 10,001 | 27 nodes | 10,000"));
  CHECK(has_facts(
      refusal(simulation +
              "[[body]]\nname = \"a\"\nmesh = { lattice = [100, 100, 20], spacing = 1.0 }\n"
              "neuron = { type = \"point_mass\", mass = 1.0 }\nspring = { type = \"linear\", stiffness = 3.0 }\n" +
              repeated(plane, 501)),
      "plane.500: | 501 | 200,000 nodes | 500"));
}

TEST_CASE("a body without a mass: the message names both keys that give one") {
  const std::string body = simulation +
                           "[[body]]\nname = \"a\"\nmesh = { lattice = [2, 2, 2], spacing = 1.0 }\n"
                           "spring = { type = \"linear\", stiffness = 3.0 }\n";
  const std::string none = refusal(body + "neuron = { type = \"point_mass\" }\n");
  CHECK(has_facts(none, "test.toml:8:10: body.0.neuron: | 'mass' | 'density'"));
  CHECK(has_facts(refusal(body + "density = 1.0\n"), "mass | density"));
  CHECK(refusal(body + "density = 1.0\nneuron = { type = \"point_mass\" }\n") == "");
  CHECK(has_facts(refusal(body + "density = 1.0\nneuron = { type = \"point_mass\", mass = 1 }\n"),
                  "body.0.neuron.mass | 'density'"));
}
