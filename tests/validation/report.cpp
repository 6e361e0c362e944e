// A made-up validation as JSON, as a page and as a table.
#include <cmath>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>
#include <springnet/validation.hpp>

#include "validation/scale.hpp"

using namespace springnet;

namespace {

Validation made_up() {
  Validation validation;
  validation.scene = "dir/a<b>.toml";
  validation.title = "A & B";
  validation.nodes = 3;
  validation.springs = 2;
  validation.duration = 1.0;
  validation.times = {0.0, 0.5, 1.0};
  validation.reference = "cvode";
  validation.relative_tolerance = 1e-8;
  validation.certifying_tolerance = 1e-10;
  validation.certification.max = 2e-9;
  validation.certification.max_by_time = {0.0, 1e-9, 2e-9};
  ValidationRun coarse;
  coarse.integrator.id = "recurrent";
  coarse.time_step = 0.5;
  coarse.outcome = "diverging";
  coarse.failure = "step from 0.5 s to 1 s: it grew <without> bound";
  coarse.reached = 0.5;
  coarse.error.max_by_time = {0.0, 0.75};
  coarse.error.max = 0.75;
  ValidationRun fine = coarse;
  fine.time_step = 0.25;
  fine.of_scene = true;
  fine.outcome = "settled";
  fine.failure.clear();
  fine.reached = 1.0;
  fine.steps = 4;
  fine.sweeps = 22;
  fine.wall = 0.125;
  fine.order = 0.984;
  fine.error = {0.0625, 0.03125, 2, 0.5, {0.0, 0.0625, 0.03}};
  validation.runs = {coarse, fine};
  validation.displacement = {1.25, 1, 0.75, 0.5};
  ValidationRun second = fine;
  second.of_scene = false;
  second.integrator.parameters["theta"] = 0.5;
  second.error = {0.0025, 0.00125, 2, 0.5, {0.0, 0.0025, 0.002}};
  second.wall = 0.25;
  validation.second_order = second;
  validation.observed_order = NAN;
  validation.notes = {"a note with <tags>"};
  return validation;
}

}  // namespace

TEST_CASE("validation.json has the numbers under their names") {
  const auto json = nlohmann::json::parse(to_json(made_up()));
  CHECK(json["reference"]["integrator"] == "cvode");
  CHECK(json["reference"]["relative_tolerance"] == 1e-8);
  CHECK(json["reference"]["uncertainty_m"] == 2e-9);
  REQUIRE(json["runs"].size() == 2);
  const auto& failed = json["runs"][0];
  CHECK(failed["outcome"] == "diverging");
  CHECK(failed["error"] == "step from 0.5 s to 1 s: it grew <without> bound");
  CHECK(failed["order"].is_null());
  const auto& run = json["runs"][1];
  CHECK(run["integrator"] == "recurrent");
  CHECK(run["time_step_s"] == 0.25);
  CHECK(run["of_scene"] == true);
  CHECK(run["max_error_m"] == 0.0625);
  CHECK(run["rms_error_m"] == 0.03125);
  CHECK(run["max_error_node"] == 2);
  CHECK(run["wall_s"] == 0.125);
  CHECK(run["outcome"] == "settled");
  CHECK(run["error"].is_null());
  CHECK(run["sweeps_per_step"] == 5.5);
  CHECK(run["max_error_share"] == 0.05);
  CHECK(json["observed_order"].is_null());
  CHECK(json["displacement"]["max_m"] == 1.25);
  CHECK(json["displacement"]["node"] == 1);
  CHECK(json["displacement"]["time_s"] == 0.75);
  CHECK(json["displacement"]["deformation_m"] == 0.5);
  CHECK(json["second_order"]["theta"] == 0.5);
  CHECK(json["second_order"]["better"] == true);
  CHECK(json["second_order"]["max_error_m"] == 0.0025);
  CHECK(json["second_order"]["max_error_share"] == 0.002);
  CHECK(json["times_s"].size() == 3);
}

TEST_CASE("the page needs no other file and shows text as text") {
  const std::string html = to_html(made_up());
  for (const char* outside : {"http:", "https:", "<script", "<link", "src=", "@import"}) {
    CAPTURE(outside);
    CHECK(html.find(outside) == std::string::npos);
  }
  // Frames of its own pictures clip their curves.
  for (std::size_t at = html.find("url("); at != std::string::npos; at = html.find("url(", at + 1))
    CHECK(html.compare(at, 5, "url(#") == 0);
  CHECK(html.find("<tags>") == std::string::npos);
  CHECK(html.find("<without>") == std::string::npos);
  CHECK(html.find("a<b>") == std::string::npos);
  CHECK(html.find("A &amp; B") != std::string::npos);
  for (const char* number :
       {"<strong>62.5 mm</strong>", "<strong>5 %</strong> of 1.25 m", "2.5 mm instead of 62.5 mm", "25 times"}) {
    CAPTURE(number);
    CHECK(html.find(number) != std::string::npos);
  }
  CHECK(html.find("diverging at 0.5 s") != std::string::npos);
  std::size_t plots = 0;
  for (std::size_t at = html.find("<svg"); at != std::string::npos; at = html.find("<svg", at + 1)) ++plots;
  CHECK(plots == 2);
}

TEST_CASE("the page of a scene whose own run failed says so") {
  Validation validation = made_up();
  validation.runs[0].of_scene = true;
  validation.runs[1].of_scene = false;
  const std::string html = to_html(validation);
  CHECK(html.find("0.5 s: <strong>diverging</strong>") != std::string::npos);
  CHECK_FALSE(validation.within(1e9));
}

TEST_CASE("the columns of the table are aligned") {
  const std::string table = to_table(made_up());
  CHECK(table.find("0.25 s *") != std::string::npos);
  CHECK(table.find("0.98") != std::string::npos);
  const std::size_t heading = table.find("outcome"), first = table.find("diverging"), second = table.find("settled");
  const auto column = [&](std::size_t at) { return at - table.rfind('\n', at); };
  CHECK(column(heading) == column(first));
  CHECK(column(heading) == column(second));
  // One unit a column, that of the scene's own run; shares of 1.25 m.
  CHECK(table.find("max error, mm") != std::string::npos);
  CHECK(table.find(" 62.5 ") != std::string::npos);
  CHECK(table.find(" 750 ") != std::string::npos);
  CHECK(table.find(" 2.5 ") != std::string::npos);
  CHECK(table.find(" 5 % ") != std::string::npos);
  CHECK(table.find(" 60 % ") != std::string::npos);
  CHECK(table.find("1.25 m from the start (node 1, 0.75 s)") != std::string::npos);
  CHECK(table.find("better: theta = 0.5") != std::string::npos);
  CHECK(table.find("note: a note with <tags>") != std::string::npos);
}

TEST_CASE("theta = 0.5 is proposed only if it halves the errors, or is the only one to reach the end") {
  Validation validation = made_up();
  CHECK(validation.second_order_is_better());
  validation.second_order->error.rms = 0.02;  // of 0.03125
  CHECK_FALSE(validation.second_order_is_better());
  CHECK(to_table(validation).find("better:") == std::string::npos);
  CHECK(to_html(validation).find("Better:") == std::string::npos);
  validation.runs[1].failure = "no";
  CHECK(validation.second_order_is_better());
  validation.second_order->failure = "neither";
  CHECK_FALSE(validation.second_order_is_better());
  validation = made_up();
  validation.certification.max = 0.05;  // larger than the differences
  CHECK_FALSE(validation.second_order_is_better());
  validation.second_order.reset();
  CHECK_FALSE(validation.second_order_is_better());
  CHECK(nlohmann::json::parse(to_json(validation))["second_order"].is_null());
}

TEST_CASE("lengths have one to three digits before the point, columns one unit") {
  CHECK(length_text(0.0) == "0 m");
  CHECK(length_text(12.34567) == "12.3 m");
  CHECK(length_text(0.000455) == "455 µm");
  CHECK(length_text(0.0009996) == "1 mm");
  CHECK(length_text(-0.002) == "-2 mm");
  CHECK(length_text(3e-8) == "30 nm");
  CHECK(length_text(NAN) == "-");
  CHECK(share_text(0.1534) == "15.3 %");
  CHECK(share_text(12.0) == "1200 %");
  CHECK(share_text(NAN) == "-");
  Validation validation = made_up();
  CHECK(std::string(unit_of_errors(validation).name) == "mm");
  validation.runs[1].failure = "no";
  CHECK(std::string(unit_of_errors(validation).name) == "m");  // nothing to judge by
  validation.runs[0].failure.clear();
  CHECK(std::string(unit_of_errors(validation).name) == "mm");
}

TEST_CASE("without a displacement there is no share") {
  Validation validation = made_up();
  validation.displacement = {};
  CHECK(to_table(validation).find(" - ") != std::string::npos);
  CHECK(nlohmann::json::parse(to_json(validation))["runs"][1]["max_error_share"].is_null());
}
