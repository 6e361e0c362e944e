#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "facts.hpp"
#include "tool.hpp"

using namespace springnet;
using springnet::testing::has;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

// A bar that hangs and swings, of one stiffness and damping.
std::string bar(double stiffness, double damping) {
  return "title = \"a hanging bar\"\n"
         "[simulation]\nduration = 0.6\ntime_step = 0.02\n"
         "integrator = { name = \"recurrent\", theta = 0.5, force_tolerance = 1e-9 }\n"
         "[gravity]\nacceleration = [0, 0, -9.81]\n"
         "[[body]]\nname = \"bar\"\nmesh = { lattice = [2, 2, 4], spacing = 1.0, diagonals = \"face\" }\n"
         "neuron = { type = \"point_mass\", mass = 2.0 }\n"
         "spring = { type = \"linear\", stiffness = " +
         std::to_string(stiffness) + " }\nviscosity = { type = \"linear\", damping = " + std::to_string(damping) +
         " }\n"
         "[[fix]]\nselect = { body = \"bar\", box = { min = [-1, -1, 2.9], max = [2, 2, 3.1] } }\n"
         "[output]\ninterval = 0.02\n";
}

}  // namespace

TEST_CASE("learn finds the values of a run, and writes a scene that runs with them") {
  const TemporaryFolder folder;
  folder.write("real.toml", bar(400, 3));
  folder.write("guess.toml", bar(250, 1));
  REQUIRE(testing::springnet(folder, "run real.toml -o seen --quiet").status == 0);
  const std::string learn = "learn guess.toml --observations seen/trajectory.csv --parameters ";
  const Answer answer =
      testing::springnet(folder, learn + "spring.stiffness:together,viscosity.damping@bar:together -o out");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(has(answer.out, "2 variables from "));
  CHECK(has(answer.out, "\n  spring.stiffness:together "));
  CHECK(has(answer.out, "\n  viscosity.damping@bar:together "));
  CHECK(has(answer.err, "100 % of the time"));
  const std::string page = testing::read_text(folder.path() / "out/learning.html");
  CHECK(page.starts_with("<!DOCTYPE html>"));
  CHECK(has(page, "Course of the search"));
  CHECK(has(page, "viscosity.damping"));
  const auto json = testing::read_json(folder.path() / "out/learning.json");
  CHECK(json["variables"] == 2);
  CHECK(json["undetermined_directions"] == 0);
  for (const auto& each : json["parameters"])
    CHECK(each["value"].get<double>() == doctest::Approx(each["kind"] == "spring" ? 400.0 : 3.0).epsilon(1e-6));
  REQUIRE(testing::springnet(folder, "run out/learned.toml -o again --quiet").status == 0);
  // Height of the lowest node at the end, m.
  const auto height = [&](const char* file) {
    const std::string text = testing::read_text(folder.path() / file);
    const std::size_t line = text.rfind("\n0.6,0,");
    REQUIRE(line != std::string::npos);
    std::size_t cell = line;
    for (int comma = 0; comma < 4; ++comma) cell = text.find(',', cell) + 1;
    return std::stod(text.substr(cell));
  };
  CHECK(height("again/trajectory.csv") == doctest::Approx(height("seen/trajectory.csv")).epsilon(1e-8));
  CHECK(height("seen/trajectory.csv") < -0.05);
  const Answer online =
      testing::springnet(folder, learn + "spring.stiffness:together --method online --json -o online");
  CAPTURE(online.err);
  REQUIRE(online.status == 0);
  CHECK(online.json()["cost"].get<double>() < 0.5 * online.json()["start_cost"].get<double>());
  CHECK(online.json()["parameters"][0]["upper"].is_null());
  const auto quiet = testing::springnet(folder, learn + "spring.stiffness:together --json -o one");
  CHECK(quiet.status == 0);
  CHECK(quiet.err.empty());
  CHECK(quiet.json() == testing::read_json(folder.path() / "one/learning.json"));
}

TEST_CASE("the commands of learning.md that need nothing else find what the page says") {
  const std::string page = testing::read_text(SPRINGNET_LEARNING_PAGE);
  const std::size_t begin = page.find("springnet new --example"), end = page.find("```", begin);
  REQUIRE(end != std::string::npos);
  const TemporaryFolder folder;
  const Answer answer =
      testing::shell(folder, "set -e; springnet() { \"$SPRINGNET\" \"$@\"; }\n" + page.substr(begin, end - begin));
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(has(page, "It finds 3 N/m and 2 N s/m in five iterations."));
  CHECK(has(answer.out, "5 iterations"));
  CHECK(has(answer.out, "3 ± "));  // the interval is narrower than the digits shown
  const nlohmann::json learned = testing::read_json(folder.path() / "learned/learning.json");
  for (const auto& each : learned["parameters"])
    CHECK(each["value"].get<double>() == doctest::Approx(each["kind"] == "spring" ? 3.0 : 2.0).epsilon(1e-9));
}

TEST_CASE("the changes of learning.md are those of a scene that is learned from") {
  const std::string page = testing::read_text(SPRINGNET_LEARNING_PAGE), begin = "```toml shrinks.toml\n";
  const std::size_t at = page.find(begin) + begin.size();
  const std::string changes = page.substr(at, page.find("```", at) - at);
  const auto muscle = [&](double stiffness) {
    std::string text = bar(stiffness, 3) + changes;
    for (std::size_t k = text.find("\"bar\""); k != std::string::npos; k = text.find("\"bar\"", k))
      text.replace(k, 5, "\"muscle\"");
    return text.replace(text.find("duration = 0.6"), 14, "duration = 2.4");
  };
  const TemporaryFolder folder;
  folder.write("real.toml", muscle(400));
  folder.write("guess.toml", muscle(300));
  const Answer run = testing::springnet(folder, "run real.toml -o seen --quiet");
  CAPTURE(run.err);
  REQUIRE(run.status == 0);
  const Answer answer = testing::springnet(
      folder, "learn guess.toml --observations seen/trajectory.csv --parameters spring.stiffness:together --json");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(answer.json()["parameters"][0]["value"].get<double>() == doctest::Approx(400.0).epsilon(1e-5));
}

TEST_CASE("learn compares both methods by the cost of the whole motion, in the report, the result and the page") {
  const TemporaryFolder folder;
  folder.write("real.toml", bar(400, 3));
  folder.write("guess.toml", bar(250, 1));
  REQUIRE(testing::springnet(folder, "run real.toml -o seen --quiet").status == 0);
  const std::string learn =
      "learn guess.toml --observations seen/trajectory.csv --parameters "
      "spring.stiffness:together,viscosity.damping:together --compare ";
  const Answer answer = testing::springnet(folder, learn + "-o both");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  const auto json = testing::read_json(folder.path() / "both/learning.json");
  REQUIRE(json["courses"].size() == 2);
  const auto &whole = json["courses"][0], &online = json["courses"][1];
  CHECK(whole["method"] == "trajectory");
  CHECK(online["method"] == "online");
  const std::vector<std::size_t> first = online["parameters"];
  REQUIRE(first.size() == 2);
  CHECK(json["parameters"][first[1]]["kind"] == "viscosity");
  const auto last_of = [](const auto& course) { return course["points"].back(); };
  CHECK(whole["points"][0]["cost"] == online["points"][0]["cost"]);
  CHECK(last_of(whole)["cost"].template get<double>() <= json["cost"].get<double>() * (1 + 1e-9) + 1e-20);
  CHECK(last_of(online)["cost"].template get<double>() < online["points"][0]["cost"].get<double>());
  CHECK(last_of(online)["cost"].template get<double>() > 10.0 * last_of(whole)["cost"].template get<double>());
  CHECK(last_of(online)["work_in_motions"] == 3.0);
  // The table of the report: each with its cost at the end.
  for (const auto& course : json["courses"])
    CHECK(has(answer.out, fmt::format("{:.6g}", last_of(course)["cost"].template get<double>())));
  CHECK(has(answer.out, "WORK, WHOLE MOTIONS"));
  // The other way round: the values are those of the other method, the courses the same.
  const Answer other = testing::springnet(folder, learn + "--method online --json -o other");
  REQUIRE(other.status == 0);
  CHECK(other.json()["courses"] == json["courses"]);
  CHECK(other.json()["parameters"][0]["value"] == last_of(online)["values"][0]);
  // The plot: a panel of the cost and one for each variable, each with both.
  const std::string page = testing::read_text(folder.path() / "both/learning.html");
  const std::string begin = "id=\"panels\">";
  const std::size_t at = page.find(begin);
  REQUIRE(at != std::string::npos);
  const auto panels =
      nlohmann::json::parse(page.substr(at + begin.size(), page.find("</script>", at) - at - begin.size()));
  std::size_t compared = 0;
  for (const auto& panel : panels) {
    if (panel["x_label"] != "work, whole motions") continue;
    REQUIRE(panel["curves"].size() == 2);
    for (std::size_t k = 0; k < 2; ++k) {
      const auto &curve = panel["curves"][k], &points = json["courses"][k]["points"];
      CHECK(curve["label"] == json["courses"][k]["method"]);
      REQUIRE(curve["x"].size() == points.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        CHECK(curve["x"][i] == points[i]["work_in_motions"]);
        const double expected = compared == 0 ? std::log10(points[i]["rms"].get<double>())
                                              : points[i]["values"][compared - 1].get<double>();
        CHECK(curve["y"][i].get<double>() == doctest::Approx(expected).epsilon(1e-12));
      }
    }
    ++compared;
  }
  CHECK(compared == 3);
  CHECK_FALSE(has(testing::springnet(folder,
                                     "learn guess.toml --observations seen/trajectory.csv --parameters "
                                     "spring.stiffness:together --json -o alone")
                      .out,
                  "courses"));
  for (const char* const wrong : {"--starts 2", "--resume", "--experiment guess.toml=seen/trajectory.csv"})
    CHECK(has(testing::springnet(folder, learn + wrong + " -o wrong").err, "leave out --"));
}

TEST_CASE("learn takes several experiments, optimisers and starts") {
  const TemporaryFolder folder;
  const std::string pull = "[[force]]\nselect = { body = \"bar\", nodes = [0] }\nforce = [30, 0, 0]\n";
  folder.write("real.toml", bar(400, 3));
  folder.write("pulled.toml", bar(400, 3) + pull);
  folder.write("guess.toml", bar(250, 1));
  folder.write("guess_pulled.toml", bar(250, 1) + pull);
  REQUIRE(testing::springnet(folder, "run real.toml -o seen --quiet").status == 0);
  REQUIRE(testing::springnet(folder, "run pulled.toml -o pulled --quiet").status == 0);
  const std::string learn =
      "learn guess.toml --observations seen/trajectory.csv --parameters "
      "spring.stiffness:together,viscosity.damping:together ";
  const std::string both = learn + "--experiment guess_pulled.toml=pulled/trajectory.csv ";
  const Answer one = testing::springnet(folder, learn + "--json -o one");
  REQUIRE(one.status == 0);
  for (const char* more : {"--optimiser lbfgs --iterations 200", "--threads 2", "--starts 2 --start-factor 2"}) {
    CAPTURE(more);
    const Answer answer = testing::springnet(folder, both + more + " --json -o both");
    CAPTURE(answer.err);
    REQUIRE(answer.status == 0);
    const auto json = answer.json();
    CHECK(json["observed_values"].get<int>() == 2 * one.json()["observed_values"].get<int>());
    for (const auto& each : json["parameters"])
      CHECK(each["value"].get<double>() == doctest::Approx(each["kind"] == "spring" ? 400.0 : 3.0).epsilon(1e-5));
    CHECK(json["starts"].size() == (has(more, "starts") ? 2 : 0));
  }
  // The loads of the second are not those of the scene that is written.
  CHECK_FALSE(has(testing::read_text(folder.path() / "both/learned.toml"), "[[force]]"));
  // With observations of the other experiment nothing fits.
  const Answer crossed =
      testing::springnet(folder, learn + "--experiment guess_pulled.toml=seen/trajectory.csv --json -o crossed");
  REQUIRE(crossed.status == 0);
  CHECK(crossed.json()["rms"].get<double>() > 1e-3);
}

TEST_CASE("learn warns of a bad fit, and tells why it could not follow a better one") {
  const TemporaryFolder folder;
  folder.write("real.toml", bar(400, 3));
  // Of another mass, which is not learned.
  std::string heavy = bar(250, 1);
  heavy.replace(heavy.find("-9.81"), 5, "-30.0");
  folder.write("guess.toml", heavy);
  REQUIRE(testing::springnet(folder, "run real.toml -o seen --quiet").status == 0);
  const std::string learn = "learn guess.toml --observations seen/trajectory.csv --parameters ";
  const Answer bad = testing::springnet(folder, learn + "viscosity.damping@bar:together,mass@bar -o bad");
  CAPTURE(bad.err);
  REQUIRE(bad.status == 0);
  CHECK(has(bad.out, "\n  warning: The differences that are left are "));
  CHECK(has(bad.out, "\n  mass@bar of node 0 "));
  const std::string page = testing::read_text(folder.path() / "bad/learning.html");
  CHECK(has(page, "<p class=\"warning\" role=\"alert\">The differences that are left are "));
  CHECK(has(page, "<td>viscosity.damping@bar:together</td>"));
  CHECK(has(page, "learned, with its 95 % interval"));
  CHECK(testing::read_json(folder.path() / "bad/learning.json")["parameters"].back()["body"] == "bar");

  // Softer springs reach a floor with a rigidly connected node, which is not differentiated at a located time.
  const auto over_floor = [](double stiffness, const std::string& more) {
    std::string text = bar(stiffness, 3) + "[[rigid]]\npairs = [[{ node = 0 }, { node = 1 }]]\n" + more;
    return text.replace(text.find("theta = 0.5"), 11, "theta = 0.5, events = \"located\"");
  };
  folder.write("soft.toml", over_floor(100, ""));
  folder.write("stiff.toml",
               over_floor(800, "[[plane]]\nname = \"floor\"\npoint = [0, 0, -0.2]\nnormal = [0, 0, 1]\n"));
  const Answer soft = testing::springnet(folder, "run soft.toml -o soft --quiet");
  CAPTURE(soft.err);
  REQUIRE(soft.status == 0);
  const Answer early = testing::springnet(
      folder, "learn stiff.toml --observations soft/trajectory.csv --parameters spring.stiffness:together -o early");
  CAPTURE(early.err);
  CAPTURE(early.out);
  CHECK(early.status == 0);
  CHECK(has(early.out, "With values from the first part of the motion more of it fails"));
  CHECK(has(early.out, "as rigid connections join the nodes"));
  const auto json = testing::read_json(folder.path() / "early/learning.json");
  CHECK(json["cost"].get<double>() < json["start_cost"].get<double>());
}

TEST_CASE("learn goes on with --resume, to the same files") {
  const TemporaryFolder folder;
  folder.write("real.toml", bar(400, 3));
  folder.write("guess.toml", bar(250, 1));
  REQUIRE(testing::springnet(folder, "run real.toml -o seen --quiet").status == 0);
  const std::string learn =
      "learn guess.toml --observations seen/trajectory.csv --parameters "
      "spring.stiffness,viscosity.damping:together --iterations 6 --starts 4 ";
  REQUIRE(testing::springnet(folder, learn + "--quiet -o whole").status == 0);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "whole/learning.state"));
  CHECK(has(testing::springnet(folder, learn + "--resume -o whole").err, "the search has reached its end"));
  // SIGTERM as Ctrl-C, or a kill that leaves no time for anything, after the first iterations.
  for (const std::string signal : {"TERM", "KILL"}) {
    CAPTURE(signal);
    const Answer stopped =
        testing::shell(folder, "rm -f lines; mkfifo lines; \"$SPRINGNET\" " + learn + "-o " + signal +
                                   " 2>lines >/dev/null & P=$!\n"
                                   "{ read -r LINE; read -r LINE; read -r LINE; kill -" +
                                   signal + " $P; cat >/dev/null; } <lines; wait $P");
    REQUIRE(std::filesystem::exists(folder.path() / signal / "learning.state"));
    CHECK(std::filesystem::exists(folder.path() / signal / "learning.json") == (signal == "TERM"));
    CHECK(stopped.status == (signal == "TERM" ? 0 : 137));
    CHECK(has(testing::springnet(folder, learn + "--guess-weight 1 --resume -o " + signal).err,
              "weight of the guess: 0 there, 1 now"));
    const Answer resumed = testing::springnet(folder, learn + "--resume -o " + signal);
    CAPTURE(resumed.err);
    REQUIRE(resumed.status == 0);
    for (const char* file : {"learning.json", "learned.toml"})
      CHECK(testing::read_text(folder.path() / signal / file) == testing::read_text(folder.path() / "whole" / file));
    CHECK_FALSE(std::filesystem::exists(folder.path() / signal / "learning.state"));
  }
}

TEST_CASE("learn finds fields, masses and loads from the tables of motion and reactions of a run") {
  const TemporaryFolder folder;
  const auto pushed = [](double stiffness, double force) {
    return bar(stiffness, 3) + "reactions = true\n[[force]]\nforce = [" + std::to_string(force) +
           ", 0, 0]\nselect = { body = \"bar\", box = { min = [-1, -1, -0.1], max = [2, 2, 0.1] } }\n";
  };
  folder.write("real.toml", pushed(400, 3));
  folder.write("guess.toml", pushed(250, 2));
  REQUIRE(testing::springnet(folder, "run real.toml -o seen --quiet").status == 0);
  const Answer answer = testing::springnet(folder,
                                           "learn guess.toml --observations seen/trajectory.csv seen/reactions.csv "
                                           "--parameters spring.stiffness:field=1,mass:together,load@0 -o out");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(has(answer.out, "10 variables from "));
  CHECK(has(answer.out, "greatest of the field"));
  CHECK(has(answer.out, "load of load 0"));
  const auto json = testing::read_json(folder.path() / "out/learning.json");
  CHECK(json["undetermined_directions"] == 0);
  for (const auto& each : json["parameters"]) {
    const bool is_field = each["kind"] == "spring";
    CHECK(each.contains("variables") == is_field);
    CHECK(each["value"].get<double>() == doctest::Approx(is_field                 ? 400.0
                                                         : each["kind"] == "mass" ? 2.0
                                                                                  : 1.5)
                                             .epsilon(1e-6));
  }
  CHECK(has(testing::read_text(folder.path() / "out/learned.toml"), "[[force]]"));
  // Points of the surface, from the positions without their nodes.
  std::string points = "time,x,y,z\n";
  const std::string table = testing::read_text(folder.path() / "seen/trajectory.csv");
  for (std::size_t line = table.find('\n') + 1; line < table.size(); line = table.find('\n', line) + 1) {
    const std::size_t node = table.find(',', line), x = table.find(',', node + 1);
    std::size_t end = x;
    for (int cell = 0; cell < 3; ++cell) end = table.find(',', end + 1);
    points += table.substr(line, node - line) + table.substr(x, end - x) + "\n";
  }
  folder.write("scan.csv", points);
  const Answer scanned = testing::springnet(folder,
                                            "learn guess.toml --observations scan.csv "
                                            "--parameters spring.stiffness:together,load --json -o scanned");
  CAPTURE(scanned.err);
  REQUIRE(scanned.status == 0);
  const auto of_scan = scanned.json();
  for (const auto& each : of_scan["parameters"])
    CHECK(each["value"].get<double>() == doctest::Approx(each["kind"] == "spring" ? 400.0 : 1.5).epsilon(1e-6));
}

TEST_CASE("learn takes the weight of the guess from a rule, and judges by what is held out") {
  const TemporaryFolder folder;
  folder.write("real.toml", bar(400, 3));
  folder.write("guess.toml", bar(250, 3));
  REQUIRE(testing::springnet(folder, "run real.toml -o seen --quiet").status == 0);
  // Every other line is held out; standard deviations of 1 mm, and noise of about that size.
  const std::string table = testing::read_text(folder.path() / "seen/trajectory.csv");
  std::string learned = "time,node,x,y,z,s\n", held_out = learned;
  std::size_t number = 0;
  for (std::size_t from = table.find('\n') + 1; from < table.size(); ++number) {
    const std::size_t end = table.find('\n', from);
    std::vector<double> cells;
    for (std::size_t cell = from; cells.size() < 5; cell = table.find(',', cell) + 1)
      cells.push_back(std::stod(table.substr(cell, end - cell)));
    for (std::size_t k = 2; k < 5; ++k) cells[k] += 1.4e-3 * std::sin(static_cast<double>(7 * number * number + k));
    (number % 2 == 0 ? learned : held_out) +=
        fmt::format("{},{},{},{},{},0.001\n", cells[0], cells[1], cells[2], cells[3], cells[4]);
    from = end + 1;
  }
  folder.write("learned.csv", learned);
  folder.write("held_out.csv", held_out);
  const std::string command = "learn guess.toml --observations learned.csv --parameters spring.stiffness ";
  for (const char* const rule : {"discrepancy", "l-curve"}) {
    CAPTURE(rule);
    const Answer answer = testing::springnet(
        folder, command + "--held-out held_out.csv --quiet -o out --guess-weight " + std::string(rule));
    CAPTURE(answer.err);
    REQUIRE(answer.status == 0);
    const auto json = testing::read_json(folder.path() / "out/learning.json");
    CHECK(json["guess_weight"].get<double>() > 0.0);
    CHECK(json["guess_curve"].size() > 3);
    CHECK(json["parameters"][5]["from_guess"].get<double>() > 0.0);
    CHECK(json["parameters"][5]["has_influence"] == true);
    // Of other nodes than those that were seen.
    CHECK(json["held_out"]["start_rms"].get<double>() > 50.0);
    CHECK(json["held_out"]["rms"].get<double>() < 4.0);
  }
  const Answer told = testing::springnet(folder, command + "--held-out held_out.csv -o told --guess-weight 1");
  CHECK(has(told.out, "held out: "));
  const Answer wrong = testing::springnet(folder, command + "--guess-weight -1");
  CHECK(wrong.status == 2);
  CHECK(has(wrong.err, "--guess-weight"));
  const Answer plain = testing::springnet(folder,
                                          "learn guess.toml --observations seen/trajectory.csv --parameters "
                                          "spring.stiffness --guess-weight discrepancy");
  CHECK(plain.status == 2);
  CHECK(has(plain.err, "standard deviations"));
  const Answer twice = testing::springnet(folder, command + "--held-out learned.csv");
  CHECK(twice.status == 2);
  CHECK(has(twice.err,
            "learned.csv:2: positions of node 0 at 0 s are held out and learned from as well, in "
            "learned.csv:2"));
}

TEST_CASE("learn corrects the rules whose words a scene has") {
  const TemporaryFolder folder;
  std::string words = bar(250, 1), real = words;
  const std::string spring = "spring = { type = \"linear\", stiffness = " + std::to_string(250.0) + " }";
  words.replace(words.find(spring), spring.size(), "spring = { type = \"linear\", stiffness = \"firm\" }");
  real.replace(real.find(spring), spring.size(), "spring = { type = \"linear\", stiffness = 2500.0 }");
  folder.write("real.toml", real);
  folder.write("words.toml", words);
  REQUIRE(testing::springnet(folder, "run real.toml -o seen --quiet").status == 0);
  const std::string learn =
      "learn words.toml --observations seen/trajectory.csv --parameters spring.stiffness:together";
  const Answer answer = testing::springnet(folder, learn + " --correct-rules -o out");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  CHECK(has(answer.out, "body.0.spring.stiffness from 'firm': guessed "));
  CHECK(has(answer.out, "learned 2500"));
  folder.write("learned.fcl", testing::read_text(folder.path() / "out/learned.fcl"));
  const auto guess = [&](const std::string& scene) {
    folder.write("own.toml", scene);
    const Answer inspected = testing::springnet(folder, "inspect own.toml --json");
    REQUIRE(inspected.status == 0);
    return nlohmann::json::parse(inspected.out)["guesses"][0]["value"].get<double>();
  };
  const double before = guess(words), after = guess("rules = \"learned.fcl\"\n" + words);
  // One body alone moves a term by most of the way, not by all of it.
  CHECK(std::abs(std::log(before / 2500.0)) > 1.0);
  CHECK(std::abs(std::log(after / 2500.0)) < 0.3 * std::abs(std::log(before / 2500.0)));
  CHECK(has(testing::read_text(folder.path() / "learned.fcl"), "// Sources:"));

  // What a search does not write is not left from one before it.
  REQUIRE(testing::springnet(folder, learn + " -o out --quiet").status == 0);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "out/learned.fcl"));
  // Rules whose values jump are not corrected; what was learned is there all the same. A guess may be at its bound.
  std::string jumps = testing::read_text(folder.path() / "learned.fcl");
  for (std::size_t at = 0; (at = jumps.find("METHOD : COG;", at)) != std::string::npos;)
    jumps.replace(at, 13, "METHOD : MM;");
  const std::string output = "VAR_OUTPUT\n";
  jumps.replace(jumps.find(output), output.size(), output + "  restitution : REAL;\n");
  jumps.insert(
      jumps.find("DEFUZZIFY density"),
      "DEFUZZIFY restitution\n  RANGE := (0 .. 1);\n  TERM bouncing := 1;\n  METHOD : COGS;\nEND_DEFUZZIFY\n\n");
  folder.write("jumps.fcl", jumps);
  folder.write("jumps.toml", "rules = \"jumps.fcl\"\n" + words +
                                 "[[plane]]\nname = \"floor\"\npoint = [0, 0, -9]\nnormal = [0, 0, 1]\n"
                                 "restitution = \"bouncing\"\n");
  const Answer jump = testing::springnet(folder,
                                         "learn jumps.toml --observations seen/trajectory.csv --parameters "
                                         "spring.stiffness:together --correct-rules -o jump");
  CAPTURE(jump.err);
  CAPTURE(jump.out);
  REQUIRE(jump.status == 0);
  CHECK(has(jump.out, "learned.fcl is not written"));
  CHECK(has(jump.out, "METHOD MM"));
  CHECK(std::filesystem::exists(folder.path() / "jump/learned.toml"));

  const Answer without = testing::springnet(folder,
                                            "learn real.toml --observations seen/trajectory.csv --parameters "
                                            "spring.stiffness:together --correct-rules -o none");
  CHECK(without.status == 2);
  CHECK(has(without.err, "--correct-rules"));
}

TEST_CASE("values without words have a guess of a width that is told") {
  const TemporaryFolder folder;
  folder.write("guess.toml", bar(250, 1));
  // One place, seen once, says little of two values.
  folder.write("seen.csv", "time,node,x,y,z,s\n0.2,0,0,0,-0.15,0.05\n");
  const std::string learn =
      "learn guess.toml --observations seen.csv --parameters spring.stiffness:together,viscosity.damping:together ";
  const auto learned = [&](const std::string& options, const std::string& to) {
    REQUIRE(testing::springnet(folder, learn + options + " -o " + to).status == 0);
    return testing::read_json(folder.path() / to / "learning.json");
  };
  const auto free = learned("", "free"), held = learned("--guess-width 0.01", "held"),
             loose = learned("--guess-width 3", "loose");
  CHECK(free["guess_weight"] == 0.0);
  CHECK(held["guess_weight"] == 1.0);
  const auto change = [](const auto& json) {
    const auto& first = json["parameters"][0];
    return std::abs(std::log(first["value"].template get<double>() / first["start"].template get<double>()));
  };
  // 0.01 of the logarithm: a place that is off by less than some standard deviations does not move it by more.
  CHECK(change(held) < 0.02);
  CHECK(change(loose) > 10.0 * change(held));
  CHECK(held["parameters"][0]["from_guess"].get<double>() > 0.9);
  CHECK(loose["parameters"][0]["from_guess"].get<double>() < held["parameters"][0]["from_guess"].get<double>());
}

TEST_CASE("learn refuses observations and selections with what is wrong, and where") {
  const TemporaryFolder folder;
  folder.write("bar.toml", bar(250, 1));
  folder.write("seen.csv", "time,node,x,y,z\n0.1,0,0,0,-0.01\n0.2,77,0,0,0\n");
  folder.write("good.csv", "time,node,x,y,z\n0.1,0,0,0,-0.01\n0.2,1,1,0,-0.1\n");
  std::string three = bar(250, 1);
  three.replace(three.find("[2, 2, 4]"), 9, "[2, 2, 3]");
  three.replace(three.find("2.9"), 3, "1.9");
  folder.write("short.toml", three);
  folder.write("late.csv", "time,node,x,y,z\n-0.1,0,0,0,-0.01\n");
  folder.write("far.csv", "time,node,x,y,z\n0.1,0,0,0,-0.01\n1000000000,1,0,0,0\n");
  folder.write("odd.csv", "time,node,x,y,z\n0.1,0,0,0,red\n");
  folder.write("none.csv", "time,node,x,y,z\n0.1,0,nan,nan,\n");
  folder.write("speed.csv", "time,node,vx,vy,vz\n0.1,1,0,0,-0.01\n");
  struct Wrong {
    const char* arguments;
    const char* message;
  };
  for (const Wrong& wrong :
       {Wrong{"seen.csv --parameters mass", "seen.csv:3"},
        Wrong{"late.csv --parameters mass", "late.csv: nothing is observed during the motion"},
        Wrong{"far.csv --parameters mass", "far.csv:3"},
        Wrong{"odd.csv --parameters mass", "odd.csv:2"},
        Wrong{"none.csv --parameters mass", "none.csv"},
        Wrong{"absent.csv --parameters mass", "absent.csv"},
        Wrong{"seen.csv --parameters spring.stifness", "did you mean 'stiffness'"},
        Wrong{"seen.csv --parameters mass@bat", "did you mean 'bar'"},
        Wrong{"seen.csv --parameters mass@liver", "there is no body 'liver'; there are: bar"},
        Wrong{"good.csv --parameters mass --experiment bar.toml", "--experiment bar.toml: write SCENE=FILE"},
        Wrong{"good.csv --parameters mass --experiment bar.toml=good.csv,", "write SCENE=FILE"},
        Wrong{"good.csv --parameters mass --experiment bar.toml=odd.csv", "odd.csv:2"},
        Wrong{"good.csv --parameters mass --experiment absent.toml=good.csv", "absent.toml"},
        Wrong{"good.csv --parameters mass --experiment short.toml=good.csv",
              "experiment 2 (short.toml) is of another object than experiment 1 (bar.toml): it has 12 nodes"},
        Wrong{"good.csv --parameters mass --optimiser newton", "--optimiser"},
        Wrong{"good.csv --parameters mass --starts 0", "--starts"},
        Wrong{"good.csv --parameters mass --starts 2 --method online", "--starts is of --method trajectory"},
        Wrong{"good.csv --parameters mass --resume", "learning.state: there is none"},
        Wrong{"good.csv --parameters mass --method online --guess-weight 1",
              "--guess-weight is of --method trajectory"},
        Wrong{"good.csv --parameters mass --method online --iterations 5", "--iterations is of --method trajectory"},
        Wrong{"good.csv --parameters mass --method online --certainty-products 5",
              "--certainty-products is of --method trajectory"},
        Wrong{"good.csv --parameters mass --rate 0.1", "--rate is of --method online"},
        Wrong{"good.csv --parameters mass --seed 2", "--seed is of searches from several starts"},
        Wrong{"speed.csv --parameters mass --outlier-distance 0.1", "--outlier-distance is of positions and points"},
        Wrong{"good.csv --parameters mass --method online --guess-width 1", "--guess-width is of --method trajectory"},
        Wrong{"good.csv --parameters mass --method online --smoothness 1", "--smoothness is of --method trajectory"},
        Wrong{"good.csv --parameters friction", "give one a first guess: friction = 0.3"},
        Wrong{"good.csv --parameters mass,mass@bar", "node 0 is among 'mass', too"},
        Wrong{"seen.csv --parameters mass:field=two", "the degree of a field"},
        Wrong{"seen.csv --parameters load", "there are no loads"},
        Wrong{"seen.csv", "--parameters is required"}}) {
    CAPTURE(wrong.arguments);
    const Answer answer = testing::springnet(folder, std::string("learn bar.toml --observations ") + wrong.arguments);
    CAPTURE(answer.err);
    CHECK(answer.status == 2);
    CHECK(has(answer.err, wrong.message));
    CHECK(answer.out.empty());
  }
}
