#include <doctest/doctest.h>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

TEST_CASE("inspect says what a scene is made of, and writes nothing") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(folder, "inspect pair.toml");
  CHECK(answer.status == 0);
  CHECK(answer.err.empty());
  for (const char* part : {"A pair", "2, 1 of them fixed", "linear (1)", "4 N/m", "0.5 N s/m", "synchronous limit"}) {
    CAPTURE(part);
    CHECK(answer.out.find(part) != std::string::npos);
  }
  CHECK_FALSE(std::filesystem::exists(folder.path() / "results"));
}

TEST_CASE("inspect --json has the same as numbers, and sees --set") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const auto json =
      testing::springnet(folder,
                         "inspect pair.toml --json --set body.0.spring.stiffness=6 --set body.0.neuron.mass=0.25")
          .json();
  CHECK(json["nodes"] == 2);
  CHECK(json["springs"] == 1);
  CHECK(json["fixed_nodes"] == 1);
  CHECK(json["total_mass_kg"] == 0.5);
  CHECK(json["stiffness_n_per_m"]["largest"] == 6.0);
  CHECK(json["parts"] == 1);
}
