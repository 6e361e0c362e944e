// Tables of laws in scenes: lists and columns of files, and what is wrong with them, with file, line, column and key.
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "facts.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using springnet::testing::has_facts;

namespace {

// The small scene with these keys in its law `table`, in line 8, column 31 on.
std::string with_law(const std::string& keys) {
  std::string text = small;
  const std::string law = "type = \"linear\", stiffness = 3.0";
  return text.replace(text.find(law), law.size(), "type = \"table\", " + keys);
}

const TableValues& tables_of(const Scene& scene) { return scene.network.materials().at(0).spring->tables; }

// A scene's folder with a file curve.csv.
struct Folder {
  testing::TemporaryFolder root;
  explicit Folder(const std::string& csv) {
    std::filesystem::create_directories(root.path() / "scene");
    root.write("scene/curve.csv", csv);
    root.write("outside.csv", "elongations,forces\n0,0\n1,1\n");
  }
  [[nodiscard]] std::string refusal(const std::string& keys, OutsideFiles outside = OutsideFiles::refused) const {
    try {
      static_cast<void>(parse_scene(with_law(keys), "s.toml", plugins(), {}, root.path() / "scene", outside));
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::input);
      return error.what();
    }
    return {};
  }
};

const std::string both_columns = R"(elongations = { file = "curve.csv" }, forces = { file = "curve.csv" })";

}  // namespace

TEST_CASE("lists and columns of files are the same tables") {
  const TableValues expected{{"elongations", {-0.1, 0, 0.1, 0.2}}, {"forces", {-0.2, 0, 0.5, 2.5}}};
  const Scene lists = parse(with_law("elongations = [-0.1, 0, 0.1, 0.2], forces = [-0.2, 0.0, 0.5, 2.5]"));
  CHECK(tables_of(lists) == expected);
  const Scene columns = parse(with_law(R"(elongations = { file = "curve.csv", column = "elongation" },)"
                                       R"( forces = { file = "curve.csv", column = "force" }, beyond = "constant")"));
  CHECK(tables_of(columns) == expected);
  CHECK(columns.network.materials().at(0).spring->parameters == ParameterValues{{"beyond", 1.0}});
  const Scene mixed =
      parse(with_law(R"(elongations = [-0.1, 0, 0.1, 0.2], forces = { column = "force", file = "./curve.csv" })"));
  CHECK(tables_of(mixed) == expected);
  CHECK_NOTHROW(Simulation(mixed.network, std::make_shared<PluginHost>(PluginHost::with_default_search()), {}));
}

TEST_CASE("a column has the name of the table unless the scene gives one") {
  CHECK(Folder("forces,elongations\n0,0\n1,1\n").refusal(both_columns).empty());
}

TEST_CASE("what a list has wrong is told at its place") {
  const std::string x = "elongations = [0, 1, 2], ";
  CHECK(
      has_facts(refusal(with_law("forces = [0, 1]")), "test.toml:8:10: | body.0.spring | 'table' | 'elongations' (m"));
  CHECK(has_facts(refusal(with_law("elongations = [0, 1]")), "test.toml:8:10: | body.0.spring | 'forces' (N"));
  CHECK(has_facts(refusal(with_law(x + "forces = [0, 1]")),
                  "test.toml:8:10: | 'forces' | 2 values | 'elongations' has 3"));
  CHECK(has_facts(refusal(with_law("elongations = [0], forces = [1]")),
                  "test.toml:8:42: body.0.spring.elongations: | 2 values or more, has 1"));
  CHECK(has_facts(refusal(with_law("elongations = [], forces = []")), "body.0.spring.elongations: | has 0"));
  CHECK(has_facts(refusal(with_law("elongations = [0, 0.5, 0.5], forces = [1, 2, 3]")),
                  "test.toml:8:51: body.0.spring.elongations.2: | above the one before, 0.5 m, is 0.5"));
  CHECK(has_facts(refusal(with_law("elongations = [1, 0], forces = [1, 2]")), "elongations.1: | 1 m, is 0"));
  CHECK(has_facts(refusal(with_law(x + "forces = [0, nan, 2]")), "body.0.spring.forces.1: | nan"));
  CHECK(has_facts(refusal(with_law(x + "forces = [0, 1, -inf]")), "body.0.spring.forces.2: | finite | -inf"));
  CHECK(has_facts(refusal(with_law(x + "forces = [0, 1, '2']")), "body.0.spring.forces.2: | number | a text"));
  CHECK(has_facts(refusal(with_law(x + "forces = [0, 1, [2]]")), "body.0.spring.forces.2: | number | a list"));
  CHECK(has_facts(refusal(with_law(x + "forces = 3")),
                  "body.0.spring.forces: | a list of numbers, or a table | a number"));
  CHECK(has_facts(refusal(with_law(x + "forces = 'curve.csv'")), "body.0.spring.forces: | a list | a text"));
  CHECK(has_facts(refusal(with_law(x + "froces = [0, 1, 2]")),
                  "body.0.spring.froces: | no key 'froces' | 'table' | 'forces' | elongations"));
  CHECK(has_facts(refusal(with_law(x + "forces = [0, 1, 2], file = 'curve.csv'")), "no key 'file'"));
}

TEST_CASE("laws without tables have no such keys; laws given by name alone have no tables") {
  std::string text = small;
  CHECK(has_facts(refusal(text.replace(text.find("stiffness = 3.0"), 15, "stiffness = 3.0, forces = [1]")),
                  "body.0.spring.forces: | no key 'forces'"));
}

TEST_CASE("what a file has wrong is told with the place in the scene and the line of the file") {
  const auto refused = [](const std::string& csv, const std::string& keys = both_columns) {
    return Folder(csv).refusal(keys);
  };
  const std::string head = "# measured\nelongations,forces\n";
  CHECK(refused(head + "0,0\n1,1\n").empty());
  CHECK(has_facts(
      refused(head + "0,0\n\n1,1\n1,2\n"),
      "s.toml:8:51: body.0.spring.elongations.file: | curve.csv:6: | 'elongations' | above the one before, 1 m"));
  CHECK(has_facts(refused(head + "0,0\n1,x\n"), "body.0.spring.forces.file: | curve.csv:4: | 'forces' | number"));
  CHECK(has_facts(refused(head + "0,0\n1,nan\n"), "body.0.spring.forces.file: | curve.csv:4: | finite"));
  CHECK(has_facts(refused(head + "0,0\n1,1,1\n"), "curve.csv:4: | 3 cells | 2"));
  CHECK(has_facts(refused(head + "0,0\n"), "elongations.file: | curve.csv: | 2 values or more, has 1"));
  CHECK(has_facts(refused("a,b\n0,0\n1,1\n"), "elongations.file: | curve.csv:1: | no column is named 'elongations'"));
  CHECK(has_facts(refused(""), "elongations.file: | curve.csv: | header"));
  CHECK(has_facts(refused(head, "elongations = { file = 'none.csv' }, forces = [1]"), "none.csv: | no such file"));
  CHECK(has_facts(refused(head, "elongations = { column = 'forces' }, forces = [1]"),
                  "body.0.spring.elongations: | 'file' is missing | CSV"));
  CHECK(has_facts(refused(head, "elongations = { file = 'curve.csv', colum = 'forces' }, forces = [1]"),
                  "body.0.spring.elongations.colum: | no key 'colum' | 'column'"));
  CHECK(has_facts(refused(head, "elongations = { file = 3 }, forces = [1]"), "elongations.file: | text | number"));
}

TEST_CASE("files of tables lie in the scene's folder") {
  const Folder folder("elongations,forces\n0,0\n1,1\n");
  const std::string keys = "elongations = { file = '../outside.csv' }, forces = { file = '../outside.csv' }";
  CHECK(has_facts(folder.refusal(keys), "body.0.spring.elongations.file: | outside | --allow-outside"));
  CHECK(folder.refusal(keys, OutsideFiles::allowed).empty());
}

TEST_CASE("a table has at most a million values") {
  std::string text = "0";
  for (int k = 0; k < 1'000'000; ++k) text += ",0";
  CHECK(has_facts(refusal(with_law("elongations = [0, 1], forces = [" + text + "]")),
                  "body.0.spring.forces: | at most 1,000,000 numbers, has 1,000,001"));
}

TEST_CASE("what a law refuses of its tables is told where they stand") {
  CHECK(has_facts(refusal(with_law("elongations = [0, 1, 1.0000000000000002], forces = [0, 1, 1e300]")),
                  "body.0.spring: | 'table' | slope after point 2 is not finite"));
}

TEST_CASE("every place of a law takes tables, connections, elements and changes of springs too") {
  const std::string law =
      R"({ type = "table", elongations = { file = "curve.csv", column = "elongation" }, forces = [-1, 0, 2, 5] })";
  const Scene scene = parse(small + "[[connect]]\npairs = [[{ node = 0 }, { node = 5 }]]\nspring = " + law +
                            "\n[[element]]\ninvariant = \"angle\"\nnodes = [[0, 1, 4]]\nspring = " + law +
                            "\n[[spring]]\nselect = { springs = [3] }\nspring = " + law + "\n");
  const Network& network = scene.network;
  for (const MaterialIndex material :
       {network.springs()[54].material, network.elements()[0].material, network.springs()[3].material})
    CHECK(network.materials()[material].spring->tables.at("forces") == std::vector<double>{-1, 0, 2, 5});
  CHECK(network.materials().size() == 2);  // the same one in all three
}
