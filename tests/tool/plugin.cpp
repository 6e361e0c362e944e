#include <algorithm>
#include <vector>

#include <doctest/doctest.h>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

TEST_CASE("plugin list has every component, with plugin and file") {
  const TemporaryFolder folder;
  const Answer answer = testing::springnet(folder, "plugin list --json");
  REQUIRE(answer.status == 0);
  const auto components = answer.json()["components"];
  struct Wanted {
    const char* kind;
    const char* id;
  };
  for (const Wanted& wanted : {Wanted{"spring function", "linear"}, Wanted{"spring function", "rupturing"},
                               Wanted{"viscosity function", "linear"}, Wanted{"viscosity function", "relative"},
                               Wanted{"neuron", "point_mass"}, Wanted{"neuron", "dragged"},
                               Wanted{"integrator", "recurrent"}, Wanted{"integrator", "cvode"}}) {
    CAPTURE(wanted.kind);
    CAPTURE(wanted.id);
    const auto found = std::find_if(components.begin(), components.end(), [&](const auto& component) {
      return component["kind"] == wanted.kind && component["id"] == wanted.id;
    });
    REQUIRE(found != components.end());
    CHECK_FALSE((*found)["version"].template get<std::string>().empty());
    CHECK_FALSE((*found)["summary"].template get<std::string>().empty());
    CHECK(std::filesystem::exists((*found)["file"].template get<std::string>()));
  }
  const std::string text = testing::springnet(folder, "plugin list").out;
  for (const auto& component : components) {
    CHECK(text.find(component["summary"].get<std::string>()) != std::string::npos);
  }
}

TEST_CASE("plugin list shows refused files with the reason") {
  const TemporaryFolder folder;
  folder.write("broken.springnet.so", "this is no library");
  const Answer answer = testing::springnet(folder, "plugin list --plugins .");
  CHECK(answer.status == 0);
  CHECK(answer.out.find("refused:") != std::string::npos);
  CHECK(answer.out.find("broken.springnet.so") != std::string::npos);
  const auto refused = testing::springnet(folder, "plugin list --json --plugins .").json()["refused"];
  const auto broken = std::find_if(refused.begin(), refused.end(), [](const auto& refusal) {
    return refusal["file"].template get<std::string>().ends_with("broken.springnet.so");
  });
  REQUIRE(broken != refused.end());
  CHECK_FALSE((*broken)["reason"].get<std::string>().empty());
}

TEST_CASE("plugin show has parameters with unit, default, bounds and choices") {
  const TemporaryFolder folder;
  const Answer answer = testing::springnet(folder, "plugin show recurrent --json");
  REQUIRE(answer.status == 0);
  const auto components = answer.json();
  REQUIRE(components.size() == 1);
  CHECK(components[0]["kind"] == "integrator");
  CHECK(components[0]["abi"].get<std::string>().starts_with("2."));
  const auto& update = components[0]["parameters"][0];
  CHECK(update["name"] == "update");
  CHECK(update["type"] == "choice");
  const std::vector<std::string> choices = update["choices"];
  CHECK(std::find(choices.begin(), choices.end(), "wavefront") != choices.end());

  const auto linear = testing::springnet(folder, "plugin show linear --kind spring --json").json();
  REQUIRE(linear.size() == 1);
  const auto& stiffness = linear[0]["parameters"][0];
  CHECK(stiffness["name"] == "stiffness");
  CHECK(stiffness["unit"] == "N/m");
  CHECK(stiffness["smallest"] == 0.0);
  const std::vector<std::string> capabilities = linear[0]["capabilities"];
  CHECK(std::find(capabilities.begin(), capabilities.end(), "energy") != capabilities.end());

  const std::string text = testing::springnet(folder, "plugin show recurrent").out;
  for (const char* part :
       {"recurrent (integrator)", "update", "\"automatic\"", "synchronous | wavefront", "max_sweeps"}) {
    CAPTURE(part);
    CHECK(text.find(part) != std::string::npos);
  }
}

TEST_CASE("plugin show has tables with unit and rules") {
  const TemporaryFolder folder;
  const auto tables = testing::springnet(folder, "plugin show table --json").json()[0]["tables"];
  REQUIRE(tables.size() == 2);
  CHECK(tables[0]["name"] == "elongations");
  CHECK(tables[0]["unit"] == "m");
  CHECK(tables[0]["increasing"] == true);
  CHECK(tables[0]["required"] == true);
  CHECK(tables[0]["least"] == 2);
  CHECK(tables[0]["as_long_as"].is_null());
  CHECK(tables[1]["as_long_as"] == "elongations");
  const std::string text = testing::springnet(folder, "plugin show table").out;
  for (const char* part : {"TABLE", "elongations", "at least 2", "any, increasing", "forces", "as elongations"}) {
    CAPTURE(part);
    CHECK(text.find(part) != std::string::npos);
  }
  CHECK(testing::springnet(folder, "plugin show linear --kind spring").out.find("TABLE") == std::string::npos);
}

TEST_CASE("a name of several kinds is shown for each, or for the requested kind") {
  const TemporaryFolder folder;
  CHECK(testing::springnet(folder, "plugin show linear --json").json().size() == 2);
  const Answer one = testing::springnet(folder, "plugin show linear --kind viscosity");
  CHECK(one.status == 0);
  CHECK(one.out.find("linear (viscosity function)") != std::string::npos);
  CHECK(one.out.find("linear (spring function)") == std::string::npos);
}

TEST_CASE("components of one name in several plugins are all shown, each with its full name for scenes") {
  const TemporaryFolder folder;
  const std::string rival = " --plugins '" SPRINGNET_FIXTURES "/rival'";
  const Answer both = testing::springnet(folder, "plugin show linear --kind spring" + rival);
  CHECK(both.status == 0);
  CHECK(both.err.empty());
  CHECK(both.out.find("type = \"linear@org.example.rival\"") != std::string::npos);
  CHECK(both.out.find("type = \"linear@springnet.spring.linear\"") != std::string::npos);
  CHECK(testing::springnet(folder, "plugin show linear --json" + rival).json().size() == 3);
  const auto one = testing::springnet(folder, "plugin show linear@org.example.rival --json" + rival).json();
  REQUIRE(one.size() == 1);
  CHECK(one[0]["plugin"] == "org.example.rival");
  CHECK(testing::springnet(folder, "plugin show liner --kind spring" + rival).status == 3);
}

TEST_CASE("the line that plugin show prints for a scene is valid in a scene") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  folder.write("table.csv", "elongations,forces\n-1,-1\n1,1\n");
  const auto line_of = [&](const std::string& arguments) {
    const std::string text = testing::springnet(folder, "plugin show " + arguments).out;
    const std::size_t line = text.find("= {", text.find("in a scene:"));
    REQUIRE(line != std::string::npos);
    return text.substr(line + 2, text.find('\n', line) - line - 2);
  };
  struct Place {
    const char* shown;
    const char* key;
  };
  for (const Place& place :
       {Place{"linear --kind spring", "body.0.spring"}, Place{"nonlinear", "body.0.spring"},
        Place{"exponential", "body.0.spring"}, Place{"rupturing", "body.0.spring"}, Place{"table", "body.0.spring"},
        Place{"linear --kind viscosity", "body.0.viscosity"}, Place{"relative", "body.0.viscosity"},
        Place{"power", "body.0.viscosity"}, Place{"point_mass", "body.0.neuron"}, Place{"dragged", "body.0.neuron"},
        Place{"recurrent", "simulation.integrator"}, Place{"cvode", "simulation.integrator"}}) {
    const std::string value = line_of(place.shown);
    CAPTURE(value);
    const Answer answer =
        testing::springnet(folder, "inspect pair.toml --set '" + std::string(place.key) + "=" + value + "'");
    CAPTURE(answer.err);
    CHECK(answer.status == 0);
  }
}

TEST_CASE("an unknown component has status 3 and the nearest names") {
  const TemporaryFolder folder;
  const Answer any = testing::springnet(folder, "plugin show recurent");
  CHECK(any.status == 3);
  CHECK(any.err.find("did you mean 'recurrent'") != std::string::npos);
  CHECK(testing::springnet(folder, "plugin show recurrent --kind neuron").status == 3);
}
