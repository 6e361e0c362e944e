// Curves of laws, and sample scenes.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "tool.hpp"

using namespace springnet;
using testing::Answer;
using testing::TemporaryFolder;

namespace {

// The panels of a page, as its script gets them.
nlohmann::json panels_of(const TemporaryFolder& folder, const std::string& arguments) {
  const Answer answer = testing::springnet(folder, "plugin show " + arguments + " --plot plot.html");
  CAPTURE(answer.err);
  REQUIRE(answer.status == 0);
  const std::string page = testing::read_text(folder.path() / "plot.html");
  const std::string start = "<script type=\"application/json\" id=\"panels\">";
  const std::size_t begin = page.find(start);
  REQUIRE(begin != std::string::npos);
  const std::size_t text = begin + start.size();
  return nlohmann::json::parse(page.substr(text, page.find("</script>", text) - text));
}

// y of a curve against a formula of x, within rounding.
template <class Formula>
void check_curve(const nlohmann::json& curve, const Formula& formula) {
  REQUIRE(curve["x"].size() == 401);
  for (std::size_t k = 0; k < curve["x"].size(); ++k) {
    const double x = curve["x"][k], wanted = formula(x);
    CAPTURE(x);
    if (std::isnan(wanted))
      CHECK(curve["y"][k].is_null());
    else
      CHECK(std::abs(curve["y"][k].get<double>() - wanted) <= 1e-12 * (1.0 + std::abs(wanted)));
  }
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

}  // namespace

TEST_CASE("curves are the law's force, stiffness and energy for the parameters and range given") {
  const TemporaryFolder folder;
  const auto panels = panels_of(folder, "nonlinear --set stiffness=3 --set cubic=2 --range 0.8:2");
  REQUIRE(panels.size() == 3);
  CHECK(panels[0]["x"] == nlohmann::json::array({0.8, 2.0}));
  CHECK(panels[0]["x_label"] == "length, m");
  CHECK(panels[0]["y_label"] == "force, N");
  check_curve(panels[0]["curves"][0], [](double l) { return 3 * (l - 1) + 2 * std::pow(l - 1, 3); });
  CHECK(panels[1]["y_label"] == "stiffness dQ/dq, N/m");
  check_curve(panels[1]["curves"][0], [](double l) { return 3 + 6 * std::pow(l - 1, 2); });
  CHECK(panels[2]["y_label"] == "energy, J");
  check_curve(panels[2]["curves"][0], [](double l) { return 1.5 * std::pow(l - 1, 2) + 0.5 * std::pow(l - 1, 4); });
}

TEST_CASE("a law that reads the rate is drawn over the rate") {
  const TemporaryFolder folder;
  const auto panels = panels_of(folder, "linear --kind viscosity --set damping=4");
  REQUIRE(panels.size() == 2);
  CHECK(panels[0]["y_label"] == "force over the rate, N");
  check_curve(panels[0]["curves"][0], [](double rate) { return 4 * rate; });
  CHECK(panels[1]["y_label"] == "damping dQ/dq', N s/m");
  const auto speeds = panels_of(folder, "relative --set damping=4 --range 0:3");
  CHECK(speeds[0]["x_label"] == "relative speed, m/s");
  check_curve(speeds[0]["curves"][0], [](double speed) { return 4 * speed; });
}

// A spring and a dashpot in series whose length is l0 + a sin(w t): after the transient its loop is an ellipse of the
// area, the work dissipated in a cycle, pi a^2 k (w tau) / (1 + (w tau)^2).
TEST_CASE("the loop of a law with memory encloses the work that it dissipates") {
  const TemporaryFolder folder;
  const double k = 2.0, tau = 0.05, a = 0.2;
  const auto panels =
      panels_of(folder, "maxwell --set stiffness=2 --set relaxation_time=0.05 --range 0.8:1.2 --period 1");
  const auto& loop = panels.back();
  CHECK(loop["is_path"] == true);
  REQUIRE(loop["curves"].size() == 2);
  const auto& cycle = loop["curves"][1];
  double area = 0.0;
  for (std::size_t i = 1; i < cycle["x"].size(); ++i) {
    area += 0.5 * (cycle["y"][i].get<double>() + cycle["y"][i - 1].get<double>()) *
            (cycle["x"][i].get<double>() - cycle["x"][i - 1].get<double>());
  }
  const double w = 2.0 * std::acos(-1.0) * tau;
  // Second order in the time step, 1/400 of the period and 1/20 of tau.
  CHECK(area == doctest::Approx(std::acos(-1.0) * a * a * k * w / (1.0 + w * w)).epsilon(1e-3));
}

TEST_CASE("what a plot leaves out or assumes it says") {
  const TemporaryFolder folder;
  REQUIRE(testing::springnet(folder, "plugin show rupturing --plot a.svg --range 0.5:4").status == 0);
  const std::string svg = testing::read_text(folder.path() / "a.svg");
  CHECK(svg.find("breaks at") != std::string::npos);
  CHECK(svg.find("Not given, a sample value: stiffness") != std::string::npos);
  REQUIRE(testing::springnet(folder, "plugin show linear --kind spring --set stiffness=2 --plot b.svg").status == 0);
  const std::string given = testing::read_text(folder.path() / "b.svg");
  CHECK(given.find("Not given") == std::string::npos);
  CHECK(given.find("breaks at") == std::string::npos);
  CHECK(given.find("stiffness\u00a0=\u00a02\u00a0N/m") != std::string::npos);
}

TEST_CASE("a scene's laws are drawn, formulas and their poles, too") {
  const TemporaryFolder folder;
  // Beyond 1.5 m force and energy have no value.
  const std::string file = "'" SPRINGNET_EXAMPLES "/laws/fene.toml'";
  const auto panels = panels_of(folder, file + " --range 0.5:4");
  REQUIRE(panels.size() == 3);
  CHECK(panels[0]["x"][1] == doctest::Approx(2.0));  // its rest length is 0.5 m
  check_curve(panels[2]["curves"][0], [](double l) { return -0.5 * 3 * 2.25 * std::log1p(-(l / 1.5) * (l / 1.5)); });
  const std::string page = testing::read_text(folder.path() / "plot.html");
  CHECK(page.find("spring function by a formula") != std::string::npos);
  CHECK(page.find("stiffness*length/(1 - (length/limit)^2)") != std::string::npos);
  CHECK(count_of(page, ">not finite<") == 2);
  CHECK(count_of(page, ">cut off: larger values are not drawn<") >= 1);
  const auto other = panels_of(folder, file + " --set body.0.spring.stiffness=30");
  check_curve(other[0]["curves"][0], [](double l) { return 30 * l / (1 - (l / 1.5) * (l / 1.5)); });
  folder.write("pair.toml", testing::pair_scene);
  CHECK(panels_of(folder, "pair.toml").size() == 5);
}

TEST_CASE("every shipped law has curves, on pictures that are well-formed") {
  const TemporaryFolder folder;
  std::size_t count = 0;
  const auto list = testing::springnet(folder, "plugin list --json").json();
  for (const auto& component : list["components"]) {
    const std::string kind = component["kind"], id = component["id"];
    if (kind.find("function") == std::string::npos) continue;
    CAPTURE(id);
    const auto panels =
        panels_of(folder, fmt::format("{} --kind {}", id, kind.starts_with("spring") ? "spring" : "viscosity"));
    CHECK(panels.size() >= 1);
    for (const auto& panel : panels) {
      CHECK_FALSE(panel["curves"].empty());
      CHECK(panel["x"][0] < panel["x"][1]);
      CHECK(panel["y"][0] < panel["y"][1]);
    }
    ++count;
  }
  CHECK(count == 19);
}

TEST_CASE("mistakes in the arguments of a plot are told") {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& arguments, int status, const char* what) {
    const Answer answer = testing::springnet(folder, "plugin show " + arguments);
    CAPTURE(arguments);
    CAPTURE(answer.err);
    CHECK(answer.status == status);
    CHECK(answer.err.find(what) != std::string::npos);
  };
  refused("linear --kind spring --plot a.png", 2, "must end in .svg or .html");
  refused("linear --kind spring --plot a.svg --set stifness=1", 2, "did you mean 'stiffness'");
  refused("linear --kind spring --plot a.svg --set stiffness=-1", 2, "stiffness");
  refused("linear --kind spring --plot a.svg --set stiffness=soft", 2, "is no number");
  refused("linear --kind spring --plot a.svg --range 2:1", 2, "the smaller one first");
  refused("muscle --plot a.svg --set activation=2", 2, "activation");
  refused("recurrent --plot a.svg", 2, "is no law");
  refused("linear --set stiffness=1", 2, "--plot");
  refused("linear --range 0.5:1", 2, "--plot");
  refused("linear --at 1 --plot a.svg", 2, "--plot");
  refused("linear --at one", 2, "--at");
  refused("linear --rate 1", 2, "--at");
  refused("recurrent --at 1", 2, "is no law");
  refused("nothing.toml --plot a.svg", 2, "nothing.toml");
  refused("nothing.toml", 2, "cannot be read");
  refused("linear --kind spring --plot missing/a.svg", 2, "missing");
  CHECK_FALSE(std::filesystem::exists(folder.path() / "a.svg"));
}

TEST_CASE("the sample scene of every shipped component runs as it is") {
  const TemporaryFolder folder;
  const std::map<std::string, std::string> kinds{{"spring function", "spring"},
                                                 {"viscosity function", "viscosity"},
                                                 {"neuron", "neuron"},
                                                 {"integrator", "integrator"}};
  std::size_t count = 0;
  const auto list = testing::springnet(folder, "plugin list --json").json();
  for (const auto& component : list["components"]) {
    const std::string id = component["id"];
    CAPTURE(id);
    const Answer sample = testing::springnet(
        folder, fmt::format("plugin show {} --kind {} --sample", id, kinds.at(component["kind"].get<std::string>())));
    REQUIRE(sample.status == 0);
    CHECK(sample.out.find("\"" + id + "\"") != std::string::npos);
    folder.write("sample.toml", sample.out);
    const Answer answer = testing::springnet(folder, "run sample.toml -q -o out");
    CAPTURE(answer.err);
    CHECK(answer.status == 0);
    ++count;
  }
  CHECK(count == 25);
}

#ifdef SPRINGNET_CHROMIUM
TEST_CASE("the page shows the values at the pointer and leaves the browser's console empty") {
  const TemporaryFolder folder;
  static_cast<void>(panels_of(folder, "linear --kind spring --set stiffness=3 --range 0.5:1.5"));
  // The pointer in the middle of the first panel: at the length 1 m the force is 0; then at the right end.
  std::string page = testing::read_text(folder.path() / "plot.html");
  page.insert(page.rfind("</body>"), R"(<script>
const shown = [], panel = JSON.parse(document.getElementById("panels").textContent)[0];
for (const share of [0.5, 1]) {
  const at = new DOMPoint(panel.frame[0] + share * (panel.frame[2] - panel.frame[0]), panel.frame[1] + 20)
    .matrixTransform(document.querySelector("svg").getScreenCTM());
  document.querySelector("svg").dispatchEvent(new PointerEvent("pointermove", { clientX: at.x, clientY: at.y }));
  shown.push(document.getElementById("values").textContent);
}
document.title = shown.join(" | ").replace(/\n/g, "; ");
</script>)");
  folder.write("pointer.html", page);
  const Answer answer = testing::shell(folder, "timeout 60 '" SPRINGNET_CHROMIUM
                                               "' --headless --no-sandbox --disable-gpu --no-first-run "
                                               "--disable-background-networking --user-data-dir=profile "
                                               "--virtual-time-budget=2000 --enable-logging=stderr --v=0 "
                                               "--dump-dom 'file://" +
                                                   (folder.path() / "pointer.html").string() + "'");
  CHECK(answer.status == 0);
  CHECK(answer.err.find(":CONSOLE") == std::string::npos);
  CHECK(answer.out.find("<title>length, m: 1; force, N: 0 | length, m: 1.5; force, N: 1.5</title>") !=
        std::string::npos);
}
#endif

TEST_CASE("plugin show --at prints what a law answers") {
  const TemporaryFolder folder;
  const auto columns = [&](const std::string& arguments) {
    const Answer answer = testing::springnet(folder, "plugin show " + arguments + " --json");
    CAPTURE(answer.err);
    REQUIRE(answer.status == 0);
    std::map<std::string, std::vector<double>> result;
    const auto laws = answer.json();
    for (const auto& column : laws[0]["columns"])
      result[column["name"].get<std::string>()] = column["values"].get<std::vector<double>>();
    return result;
  };
  // 3 N/m (l - 2 m) by hand.
  auto linear = columns("linear --kind spring --set stiffness=3 --reference 2 --at 1.5,2,2.25");
  CHECK(linear.at("force") == std::vector<double>{-1.5, 0.0, 0.75});
  CHECK(linear.at("stiffness") == std::vector<double>{3.0, 3.0, 3.0});
  CHECK(linear.at("energy") == std::vector<double>{0.375, 0.0, 0.09375});
  CHECK(columns("linear --kind viscosity --set damping=0.5 --at 1,2 --rate -4").at("force") ==
        std::vector<double>{-2.0, -2.0});
  std::ofstream(folder.path() / "scene.toml")
      << "[simulation]\nduration = 1.0\ntime_step = 0.1\n[[body]]\nname = \"a\"\nnodes = [[0, 0, 0], [0.5, 0, 0]]\n"
         "springs = [[0, 1]]\nneuron = { type = \"point_mass\", mass = 1.0 }\n"
         "spring = { formula = \"k*e^3\", k = 2.0 }\n";
  CHECK(columns("scene.toml --at 1.5").at("force") == std::vector<double>{2.0});
  const Answer text = testing::springnet(folder, "plugin show scene.toml --at 1.5");
  CHECK(text.out.find("length, m  force, N  stiffness, N/m") != std::string::npos);
}
