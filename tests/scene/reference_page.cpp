// The reference page, the list of keys and the reader say the same.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <toml++/toml.h>

#include "everything.hpp"
#include "scenes.hpp"

namespace {

std::string read_page() {
  std::ifstream stream(REFERENCE_PAGE);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::set<std::string> listed() { return {springnet::scene_keys().begin(), springnet::scene_keys().end()}; }

// Where the keys of a table are listed: those of selections once, as "select.…", those of obstacles' motions and turns
// and of columns of files likewise.
std::string listed_path(const std::string& path) {
  if (path.ends_with(".select") || path == "rigid.springs" || path == "output.nodes" || path == "output.springs") {
    return "select";
  }
  for (const char* joined : {"connect", "rigid"}) {
    for (const char* end : {".from", ".to"}) {
      if (path == std::string(joined) + end) return "select";
    }
  }
  if (path == "contact.between") return "select";
  if (path.ends_with(".elongations")) return "values";
  for (const char* shared : {"motion", "turn"}) {
    if (path.ends_with(std::string(".") + shared)) return shared;
  }
  return path;
}

void collect(const toml::node& node, const std::string& path, std::set<std::string>& keys) {
  if (const toml::array* array = node.as_array()) {
    for (const toml::node& element : *array) collect(element, path, keys);
  }
  const toml::table* table = node.as_table();
  if (table == nullptr) return;
  const std::string prefix = path.empty() ? "" : listed_path(path) + ".";
  for (const auto& [key, value] : *table) {
    keys.insert(prefix + std::string(key.str()));
    collect(value, prefix + std::string(key.str()), keys);
  }
}

}  // namespace

TEST_CASE("each key is listed once") { CHECK(listed().size() == springnet::scene_keys().size()); }

TEST_CASE("the scenes of every key use every key, and nothing else but parameters of components") {
  std::set<std::string> used;
  for (const char* scene : {everything, everything_of_meshes}) collect(toml::parse(std::string_view(scene)), "", used);
  for (const std::string& key : listed()) CHECK_MESSAGE(used.count(key) == 1, key, " is in no scene that is read");
  const std::set<std::string> known = listed();
  const std::set<std::string> components{
      "simulation.integrator", "body.neuron",       "body.spring",   "body.viscosity",   "connect.spring",
      "connect.viscosity",     "node.neuron",       "spring.spring", "spring.viscosity", "body.material.law",
      "element.spring",        "element.viscosity", "change.spring", "change.viscosity", "change.inputs",
      "change.neuron",         "change.integrator"};
  for (const std::string& key : used) {
    const bool is_parameter = components.count(key.substr(0, key.rfind('.'))) == 1;
    CHECK_MESSAGE((known.count(key) == 1 || is_parameter), key, " is read but not listed");
  }
}

namespace {

// Replaces the value of the first such key by a date, which no key takes.
bool spoil(toml::node& node, const std::string& key) {
  if (toml::array* array = node.as_array()) {
    return std::any_of(array->begin(), array->end(), [&](toml::node& element) { return spoil(element, key); });
  }
  toml::table* table = node.as_table();
  const std::size_t dot = key.find('.');
  const std::string name = key.substr(0, dot);
  if (table == nullptr || !table->contains(name)) return false;
  if (dot != std::string::npos) return spoil(*table->get(name), key.substr(dot + 1));
  table->insert_or_assign(name, toml::date{2020, 1, 1});
  return true;
}

}  // namespace

TEST_CASE("a date is refused where the value of any key is expected, so that every key is read") {
  for (const std::string& key : springnet::scene_keys()) {
    std::vector<std::string> places{key};
    if (key.starts_with("select.")) {
      places.clear();
      for (const char* place : {"fix", "node", "cut", "spring", "force"}) places.push_back(place + ("." + key));
    }
    if (key.starts_with("values.")) places = {"body.spring.elongations." + key.substr(7)};
    if (key.starts_with("motion.") || key.starts_with("turn.")) places = {"plane." + key, "instrument." + key};
    toml::table table;
    const bool spoilt = [&] {
      for (const char* scene : {everything, everything_of_meshes}) {
        table = toml::parse(std::string_view(scene));
        for (const std::string& place : places) {
          if (spoil(table, place)) return true;
        }
      }
      return false;
    }();
    CAPTURE(key);
    REQUIRE(spoilt);
    std::ostringstream text;
    text << table;
    const std::string message = refusal(text.str());
    CAPTURE(message);
    CHECK(message.find("is a date or time") != std::string::npos);
  }
}

TEST_CASE("the reference page has a row for every key, and no row for any other") {
  const std::string page = read_page();
  REQUIRE_FALSE(page.empty());
  std::set<std::string> rows;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `")) continue;
    const std::string key = line.substr(3, line.find('`', 3) - 3);
    CHECK_MESSAGE(rows.insert(key).second, key, " has two rows");
  }
  for (const std::string& key : listed()) CHECK_MESSAGE(rows.count(key) == 1, key, " has no row in the reference page");
  const std::set<std::string> known = listed();
  for (const std::string& key : rows) CHECK_MESSAGE(known.count(key) == 1, key, " is in the reference page only");
}

TEST_CASE("the examples of the reference page are scenes") {
  const std::string page = read_page();
  std::size_t examples = 0;
  std::string scene;
  for (std::size_t begin = page.find("```toml\n"); begin != std::string::npos; begin = page.find("```toml\n", begin)) {
    begin += 8;
    const std::size_t end = page.find("```", begin);
    std::string text = page.substr(begin, end - begin);
    // The first example is a whole scene, the others are added to it.
    if (examples == 0) scene = text;
    if (examples > 0) text = scene + text;
    CAPTURE(text);
    CHECK(refusal(text) == "");
    ++examples;
  }
  CHECK(examples >= 5);
}
