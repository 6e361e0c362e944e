// Help, wrong usage, and the exit status of each kind of error.
#include <doctest/doctest.h>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

TEST_CASE("the version is printed") {
  const TemporaryFolder folder;
  const Answer answer = testing::springnet(folder, "--version");
  CHECK(answer.status == 0);
  CHECK(answer.out.starts_with("springnet "));
  CHECK(answer.out.find('.') != std::string::npos);
}

TEST_CASE("every command has a help with its exit status") {
  const TemporaryFolder folder;
  for (const char* command :
       {"", "new", "run", "validate", "inspect", "convert", "plugin list", "plugin show", "plugin new"}) {
    CAPTURE(command);
    const Answer answer = testing::springnet(folder, std::string(command) + " --help");
    CHECK(answer.status == 0);
    CHECK(answer.err.empty());
    CHECK(answer.out.find("Exit status:") != std::string::npos);
    CHECK(answer.out.find("--help") != std::string::npos);
  }
  CHECK(testing::springnet(folder, "run --help").out.find("trajectory.csv") != std::string::npos);
  CHECK(testing::springnet(folder, "plugin --help").out.find("show") != std::string::npos);
}

TEST_CASE("wrong usage has status 2 and names what is wrong") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  struct Wrong {
    const char* arguments;
    const char* message;
  };
  for (const Wrong& wrong : {Wrong{"", "a command is missing"},
                             Wrong{"vaidate pair.toml", "did you mean 'validate'"},
                             Wrong{"run", "SCENE is required"},
                             Wrong{"run --thrads 2 pair.toml", "did you mean '--threads'"},
                             Wrong{"run pair.toml --time-step 0", "--time-step: must be a number above 0"},
                             Wrong{"run pair.toml --duration nan", "--duration: must be a number above 0"},
                             Wrong{"run pair.toml --threads -2", "--threads"},
                             Wrong{"run pair.toml --threads 4294967295", "from 0 to 1024"},
                             Wrong{"run pair.toml --threads 1.5", "--threads"},
                             Wrong{"run pair.toml --threads ''", "--threads"},
                             Wrong{"run pair.toml --time-step 1 --time-step 2", "--time-step"},
                             Wrong{"run pair.toml --time-step 1e999", "--time-step: must be a number above 0"},
                             Wrong{"run pair.toml --integrator ''", "--integrator: the value is empty"},
                             Wrong{"run pair.toml --plugins ''", "--plugins: the value is empty"},
                             Wrong{"run pair.toml --plugins . --plugins ''", "--plugins: the value is empty"},
                             Wrong{"run pair.toml -o ''", "--output: the value is empty"},
                             Wrong{"run pair.toml --set ''", "--set: the value is empty"},
                             Wrong{"run ''", "SCENE: the value is empty"},
                             Wrong{"convert ''", "FILE: the value is empty"},
                             Wrong{"convert pair.toml -o ''", "--output: the value is empty"},
                             Wrong{"inspect pair.toml --set ''", "--set: the value is empty"},
                             Wrong{"plugin show ''", "ID: the value is empty"},
                             Wrong{"plugin list --plugins ''", "--plugins: the value is empty"},
                             Wrong{"validate pair.toml --integrator ''", "--integrator: the value is empty"},
                             Wrong{"validate pair.toml --time-steps ''", "--time-steps"},
                             Wrong{"run pair.toml --set output", "output"},
                             Wrong{"run pair.toml --set output.intervall=1", "did you mean 'interval'"},
                             Wrong{"run pair.toml --realtime=0", "--realtime: must be a number above 0"},
                             Wrong{"run pair.toml --realtime=fast", "--realtime"},
                             Wrong{"convert", "FILE is required"},
                             Wrong{"convert nowhere.bin", "nowhere.bin: cannot be read"},
                             Wrong{"run nowhere.toml", "nowhere.toml"},
                             Wrong{"inspect nowhere.toml", "nowhere.toml"},
                             Wrong{"validate pair.toml --time-steps 0.1,x", "--time-steps"},
                             Wrong{"validate pair.toml --time-steps 7", "at most the duration"},
                             Wrong{"validate pair.toml --tolerance -1", "--tolerance"},
                             Wrong{"validate pair.toml --reference-tolerance 1", "from 1e-11 to 0.001"},
                             Wrong{"plugin", "a command is missing"},
                             Wrong{"plugin shw", "did you mean 'show'"},
                             Wrong{"plugin show linear --kind springs", "springs"}}) {
    CAPTURE(wrong.arguments);
    const Answer answer = testing::springnet(folder, wrong.arguments);
    CAPTURE(answer.err);
    CHECK(answer.status == 2);
    CHECK(answer.out.empty());
    CHECK(answer.err.starts_with("springnet: error: "));
    CHECK(answer.err.find(wrong.message) != std::string::npos);
  }
}

TEST_CASE("an invalid scene has status 2 and names file and line") {
  const TemporaryFolder folder;
  folder.write("bad.toml", "[simulation]\nduration = 1\ntime_stp = 0.1\n");
  for (const char* command : {"run", "validate", "inspect"}) {
    CAPTURE(command);
    const Answer answer = testing::springnet(folder, std::string(command) + " bad.toml");
    CHECK(answer.status == 2);
    CHECK(answer.err.find("bad.toml:3:") != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder.path() / "results"));
  }
}

TEST_CASE("an unknown law is an error of the scene, an unknown integrator of the command line one of the plugins") {
  const TemporaryFolder folder;
  std::string scene = testing::pair_scene;
  scene.replace(scene.find("type = \"linear\", stiffness"), 16, "type = \"linaer\", ");
  folder.write("unknown.toml", scene);
  const Answer law = testing::springnet(folder, "run unknown.toml");
  CHECK(law.status == 2);
  CHECK(law.err.find("unknown.toml:") != std::string::npos);
  CHECK(law.err.find("did you mean 'linear'") != std::string::npos);

  folder.write("pair.toml", testing::pair_scene);
  const Answer integrator = testing::springnet(folder, "run pair.toml --integrator cvodes");
  CHECK(integrator.status == 3);
  CHECK(integrator.err.find("did you mean 'cvode'") != std::string::npos);
}

TEST_CASE("results that cannot be printed are a failure") {
  if (!std::filesystem::exists("/dev/full")) return;
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  CHECK(testing::shell(folder, "\"$SPRINGNET\" inspect pair.toml > /dev/full").status == 1);
  CHECK(testing::shell(folder, "\"$SPRINGNET\" plugin list --json > /dev/full").status == 1);
}
