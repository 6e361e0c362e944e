#include <algorithm>

#include <doctest/doctest.h>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

TEST_CASE("validate prints a table and writes validation.json and report.html") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(folder, "validate pair.toml");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  for (const char* part : {"max error", "0.1 s *", "0.05 s", "0.025 s", "cvode", "observed order"}) {
    CAPTURE(part);
    CHECK(answer.out.find(part) != std::string::npos);
  }
  const auto json = testing::read_json(folder.path() / "results/pair/validation.json");
  CHECK(json["reference"]["integrator"] == "cvode");
  CHECK(json["reference"]["relative_tolerance"] == 1e-8);
  CHECK(json["reference"]["uncertainty_m"].get<double>() >= 0.0);
  REQUIRE(json["runs"].size() == 3);
  for (const auto& run : json["runs"]) {
    for (const char* key : {"integrator", "time_step_s", "max_error_m", "rms_error_m", "wall_s", "outcome"}) {
      CAPTURE(key);
      CHECK(run.contains(key));
    }
    CHECK(run["max_error_m"].get<double>() > 10.0 * json["reference"]["uncertainty_m"].get<double>());
  }
  // A smooth motion: first order, but for the second-order part of these coarse steps.
  CHECK(json["observed_order"].get<double>() == doctest::Approx(1.0).epsilon(0.15));
  const std::string html = testing::read_text(folder.path() / "results/pair/report.html");
  CHECK(html.starts_with("<!doctype html>"));
  CHECK(html.find("<svg") != std::string::npos);
}

TEST_CASE("the requested time steps are compared, and --json prints what is written") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const Answer answer = testing::springnet(folder, "validate --time-steps 0.2,0.02 pair.toml --json -o out");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(answer.err.empty());
  const auto json = answer.json();
  CHECK(json == testing::read_json(folder.path() / "out/validation.json"));
  REQUIRE(json["runs"].size() == 3);
  CHECK(json["runs"][0]["time_step_s"] == 0.2);
  CHECK(json["runs"][1]["time_step_s"] == 0.1);
  CHECK(json["runs"][1]["of_scene"] == true);
  CHECK(json["runs"][2]["time_step_s"] == 0.02);
}

TEST_CASE("a tolerance that is not met has status 1, one that is met 0") {
  const TemporaryFolder folder;
  folder.write("pair.toml", testing::pair_scene);
  const auto json = testing::springnet(folder, "validate pair.toml --json --time-steps 0.05").json();
  const double error = json["runs"][0]["max_error_m"];
  const Answer met =
      testing::springnet(folder, "validate pair.toml -q --time-steps 0.05 --tolerance " + std::to_string(1.1 * error));
  CHECK(met.status == 0);
  CHECK(met.err.empty());
  const Answer missed =
      testing::springnet(folder, "validate pair.toml -q --time-steps 0.05 --tolerance " + std::to_string(0.9 * error));
  CHECK(missed.status == 1);
  CHECK(missed.err.find("tolerance") != std::string::npos);
  // The files are written all the same.
  CHECK(std::filesystem::exists(folder.path() / "results/pair/report.html"));
}

TEST_CASE("a diverging run is reported, and the others are compared") {
  const TemporaryFolder folder;
  std::string scene = testing::pair_scene;
  scene.replace(scene.find("max_sweeps = 500"), 16, "update = \"synchronous\"");
  folder.write("pair.toml", scene);
  // t^2 k / m is 2 with a time step of 1 s.
  const Answer answer = testing::springnet(folder, "validate pair.toml --json --duration 2 --time-steps 1,0.05");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  const auto runs = answer.json()["runs"];
  REQUIRE(runs.size() == 3);
  CHECK(runs[0]["outcome"] != "settled");
  CHECK(runs[0]["error"].is_string());
  CHECK(runs[1]["outcome"] == "settled");
  CHECK(runs[2]["outcome"] == "settled");
  // It is the scene's own run that a tolerance judges.
  CHECK(testing::springnet(folder, "validate pair.toml -q --duration 2 --time-steps 0.05 --time-step 1 --tolerance 10")
            .status == 1);
  // Without a tolerance, nothing was validated either if that run failed.
  CHECK(testing::springnet(folder, "validate pair.toml -q --duration 2 --time-steps 0.05 --time-step 1").status == 1);
}
