// Scenes that are small to write and would be costly to read: refused before anything is made of them.
#include <sys/stat.h>

#include <string>

#include <doctest/doctest.h>

#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

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

TEST_CASE("what nests too deep is refused where it does, before the TOML library sees it") {
  // An overflow of the stack in that library, for keys with many dots.
  CHECK(refusal("a" + repeated(".a", 100'000) + " = 1").starts_with("test.toml:1:66: this nests deeper"));
  CHECK(contains(refusal(small + "[a" + repeated(".a", 100'000) + "]"), "test.toml:9:65: this nests deeper"));
  CHECK(contains(refusal("[[a" + repeated(" . \"a.b\"", 100'000) + "]]"), too_deep));
  CHECK(contains(refusal("a = " + repeated("[", 100'000)), too_deep));
  CHECK(contains(refusal("a = " + repeated("[\n # [\n", 100'000)), too_deep));
  CHECK(contains(refusal("a = " + repeated("{ a = ", 100'000)), too_deep));
  CHECK(contains(refusal("a = " + repeated("{ a.a = [", 12)), too_deep));
  CHECK(
      contains(refusal("a = \"\"\"\n\\\"\"\" ' # \"\"\"\"\"\nb = " + repeated("[", 33)), "test.toml:3:37: this nests"));
  CHECK(contains(refusal("a = '''\n'' \\ ''''\nb = " + repeated("[", 33)), "test.toml:3:37: this nests"));
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
  CHECK(contains(refusal("a" + repeated(".a", 31) + " = 1"), "there is no key 'a'"));
  CHECK(contains(refusal("a = " + repeated("[", 32) + repeated("]", 32)), "there is no key 'a'"));
}

TEST_CASE("overrides have the same limits") {
  CHECK(contains(refusal(small, {{"a" + repeated(".a", 100'000), "1"}}), too_deep));
  CHECK(contains(refusal(small, {{"title", repeated("[", 100'000)}}), too_deep));
  CHECK(contains(refusal(small, {{"title", "{ a" + repeated(".a", 100'000) + " = 1 }"}}), too_deep));
}

TEST_CASE("a scene has a greatest size") {
  const std::string text = small + "#" + std::string(64'000'000, ' ');
  CHECK(refusal(text) == "test.toml: a scene has at most 64,000,000 bytes; put nodes and springs into a mesh file");
  CHECK(load_refusal("/dev/zero") ==
        "/dev/zero: a scene has at most 64,000,000 bytes; put nodes and springs into a mesh file");
}

TEST_CASE("a pipe that nobody writes to is no scene") {
  const testing::TemporaryFolder folder;
  const std::filesystem::path pipe = folder.path() / "pipe.toml";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(contains(load_refusal(pipe), "it is a pipe that nothing writes to"));
  CHECK(contains(load_refusal("/dev/null"), "the key 'simulation' is missing"));
}

TEST_CASE("texts are quoted shortened") {
  const std::string name(1'000'000, 'x');
  const auto quotes_little = [](const std::string& message) { return !message.empty() && message.size() < 2000; };
  CHECK(contains(refusal(name + " = 1"), std::string(60, 'x') + "… (1,000,000 characters)'; known: "));
  CHECK(quotes_little(refusal(name + " = 1")));
  CHECK(quotes_little(refusal(name + " = 1\n" + name + " = 2")));
  CHECK(quotes_little(refusal("[" + name + "]\n[" + name + "]")));
  CHECK(quotes_little(refusal("title = " + name)));
  CHECK(quotes_little(refusal(small + "[[fix]]\nselect = { body = \"" + std::string(4000, 'x') + "\" }")));
  CHECK(contains(refusal("title = \"" + name + "\"\n" + small), "at most 4,096 bytes, has 1,000,000; shorten it"));
  CHECK(quotes_little(refusal(small, {{name, "1"}})));
  CHECK(quotes_little(refusal(small, {{"title", name}})));
  CHECK(quotes_little(refusal(small, {{"simulation.duration." + name, "1"}})));
}

TEST_CASE("a scene may name its version") {
  CHECK(refusal("version = 1\n" + small) == "");
  const std::string newer = refusal("version = 2\nwhat_comes_then = true\n" + small);
  CHECK(contains(newer, "test.toml:1:11: version: this scene is of version 2, but springnet "));
  CHECK(contains(newer, " reads version 1; take a newer springnet"));
  CHECK(contains(refusal("version = 0\n" + small), "must be at least 1"));
  CHECK(contains(refusal("version = \"1\"\n" + small), "must be a whole number, is a text"));
}
