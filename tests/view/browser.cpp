// Pages in a headless Chromium: they draw, their controls work, the console stays empty.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <set>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "browser.hpp"
#include "csv.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"
#include "view/base64.hpp"
#include "view/content.hpp"

using namespace springnet;
using testing::console;
using testing::element;
using testing::plugins;
using testing::TemporaryFolder;
using testing::Visit;
using testing::visit;

namespace {

// The page in a window narrower than the browser allows its own to be: in a frame.
Visit visit_small(const TemporaryFolder& folder, int width, int height) {
  std::ofstream page(folder.path() / "frame.html", std::ios::binary);
  page << fmt::format(
      R"(<iframe id=f style="border:0;width:{}px;height:{}px" src="view.html#selftest=1"></iframe><script>
const waiting = setInterval(function () {{
  const found = document.getElementById("f").contentDocument.getElementById("selftest");
  if (!found) return;
  clearInterval(waiting);
  const script = document.createElement("script");
  script.type = "application/json"; script.id = "selftest";
  script.textContent = found.textContent;
  document.body.append(script);
}}, 50);
</script>)",
      width, height);
  page.close();
  return visit(folder, "file://" + (folder.path() / "frame.html").string() + "#selftest",
               "--allow-file-access-from-files --dump-dom");
}

std::string address(const TemporaryFolder& folder, const std::string& hash) {
  return "file://" + (folder.path() / "view.html").string() + "#" + hash;
}

// The share of a picture that has not its most frequent colour, and the number of colours: read by the browser.
nlohmann::json look_at(const TemporaryFolder& folder, const std::string& picture) {
  const std::string bytes = testing::read_text(folder.path() / picture);
  std::ofstream page(folder.path() / "look.html", std::ios::binary);
  page << "<img id=i src=\"data:image/png;base64," << view::base64(std::as_bytes(std::span(bytes))) << R"("><script>
window.onload = function () {
  const image = document.getElementById("i"), canvas = document.createElement("canvas"), counts = new Map();
  canvas.width = image.naturalWidth; canvas.height = image.naturalHeight;
  const context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  const data = new Uint32Array(context.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
  data.forEach(function (pixel) { counts.set(pixel, (counts.get(pixel) || 0) + 1); });
  const script = document.createElement("script");
  script.type = "application/json"; script.id = "colours";
  script.textContent = JSON.stringify({ width: canvas.width, height: canvas.height, colours: counts.size,
    drawn: 1 - Math.max.apply(null, Array.from(counts.values())) / data.length });
  document.body.append(script);
};
</script>)";
  page.close();
  return element(visit(folder, "file://" + (folder.path() / "look.html").string(), "--dump-dom").dom, "colours");
}

// "−0.75, 12 mm" in m; likewise for seconds and newtons. The page writes a minus sign, not a hyphen.
std::vector<double> numbers_in(const nlohmann::json& text) {
  std::string line = text.get<std::string>();
  for (std::size_t at = line.find("\u2212"); at != std::string::npos; at = line.find("\u2212")) {
    line.erase(at, 2);
    line[at] = '-';
  }
  double unit = 1.0;
  if (line.ends_with(" mm")) unit = 1e-3;
  if (line.ends_with(" %")) unit = 1e-2;
  std::vector<double> numbers;
  const char* at = line.c_str();
  for (char* end = nullptr;; at = *end == ',' ? end + 1 : end) {
    const double number = std::strtod(at, &end);
    if (end == at) return numbers;
    numbers.push_back(unit * number);
  }
}

// The values of picked items at the end of the run of everything_to_see(), against a simulation. `place` (m) and
// `tension` (N): how far the page rounds positions and tensions.
void check_values(const nlohmann::json& shown, const Scene& scene, double place, double tension) {
  Simulation simulation(scene.network, plugins(), scene.options);
  simulation.advance_to(scene.duration);
  const auto near = [&](const nlohmann::json& text, std::size_t k, double value, double slack) {
    const std::vector<double> numbers = numbers_in(text);
    REQUIRE(numbers.size() > k);
    CAPTURE(numbers[k]);
    CAPTURE(value);
    CHECK(std::abs(numbers[k] - value) <= slack + 5e-5 * std::abs(value));
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    near(shown["node"]["position"], axis, simulation.position(0)[row], place);
    near(shown["last_node"]["position"], axis, simulation.position(64)[row], place);
  }
  near(shown["node"]["speed"], 0, simulation.velocity(0).norm(), place);
  const SpringIndex k = static_cast<SpringIndex>(scene.network.springs().size()) / 2;
  const Spring& spring = scene.network.springs()[k];
  REQUIRE(simulation.alive(k));
  const double length = (simulation.position(spring.first) - simulation.position(spring.second)).norm();
  near(shown["spring"]["length"], 0, length, 2.0 * place);
  near(shown["spring"]["at rest"], 0, spring.rest_length, 0.0);
  near(shown["spring"]["stretch"], 0, length / spring.rest_length - 1.0, 5e-4 + 2.0 * place);
  near(shown["spring"]["tension"], 0, simulation.tension(k), tension);
  near(shown["rigid"]["length"], 0, scene.network.rigids()[0].length, 2.0 * place);
}

}  // namespace

TEST_CASE("the page draws the network; scrub bar, keys, switches and picking work; the console stays empty") {
  const TemporaryFolder folder;
  const Scene scene = testing::everything_to_see();
  REQUIRE_FALSE(run_scene(scene, plugins(), {folder.path(), "everything", {}}).failure);
  const Visit page = visit(folder, address(folder, "selftest=1"), "--dump-dom");
  CHECK(page.status == 0);
  CHECK(console(page.log) == "");
  const nlohmann::json found = element(page.dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  CHECK(found["has_webgl"] == true);
  CHECK(found["frames"] == 61);

  // The scrub bar moves the nodes, to where the trajectory has them.
  const testing::Csv csv = testing::read_csv(folder.path() / "trajectory.csv");
  for (const auto& stop : found["stops"]) {
    const std::size_t frame = stop["frame"];
    CAPTURE(frame);
    CHECK(stop["time"].get<double>() == doctest::Approx(csv.number(frame * 65, 0)).epsilon(1e-12));
    REQUIRE(stop["places"].size() == 195);
    for (std::size_t k = 0; k < 195; ++k) {
      // Lengths of some metres as 32 bit floats.
      CHECK(std::abs(stop["places"][k].get<double>() - csv.number(frame * 65 + k / 3, 2 + k % 3)) < 1e-6);
    }
    // The picture is some 1000 x 540; the network alone covers far more than a hundredth of it, and leaves some free.
    CHECK(stop["pixels"].get<int>() > 10000);
    CHECK(stop["pixels"].get<int>() < 600000);
  }
  CHECK(found["stops"][0]["frame"] == 0);
  CHECK(found["stops"][1]["frame"] == 30);
  CHECK(found["stops"][2]["frame"] == 60);
  CHECK(found["stops"][0]["places"] != found["stops"][2]["places"]);
  CHECK(found["stops"][0]["clock"] != found["stops"][2]["clock"]);

  // Something is picked at the place of node 0: it, or what is in front of it.
  CHECK((found["picked"].contains("node") || found["picked"].contains("spring")));
  CHECK(found["picked_text"].get<std::string>().find("of box") != std::string::npos);
  CHECK(found["keys"] == nlohmann::json::array({0, 1, 60, 59}));
  // Each switch hides something visible; the broken springs lie where triangles are torn.
  for (const char* what : {"springs", "broken", "nodes", "faces", "instruments", "forces"}) {
    CAPTURE(what);
    CHECK(found["toggled"][what].get<int>() > 100);
  }
  CHECK(found["plots"].get<int>() >= 2);
  CHECK(found["legend"].get<std::string>().find("tension of springs, N") != std::string::npos);
  CHECK(found["touch_control"] == false);  // no bodies in contact
  CHECK_FALSE(found.contains("touches"));
  // A drag of 60 pixels turns the eye by some degrees; a click in the middle of a curve goes near the middle.
  CHECK(found["eye_moved"].get<double>() > 0.1);
  CHECK(std::abs(found["curve_clicked"].get<int>() - 30) <= 6);
  check_values(found["numbers"], scene, 1e-6, 1e-6);
  CHECK(found["numbers"]["spring"]["law"] == "spring linear (stiffness 30 N/m), viscosity linear (damping 1 N s/m)");
  CHECK(found["numbers"]["rigid"]["nodes"] == "63 and 64");
  CHECK(found["key"].get<std::string>().find("rigid connection") != std::string::npos);
  CHECK(found["key"].get<std::string>().find("force of the scene\u2019s loads") != std::string::npos);
  CHECK(found["slider_keeps_arrow_keys"] == true);
  CHECK(found["picks_hidden_spring"] == false);
  // In a picture of another size everything is in view again.
  for (const auto& most : found["resized"]) {
    CHECK(most.get<double>() < 1.0);
    CHECK(most.get<double>() > 0.3);
  }
  // Other colours; contact has no bar in the legend.
  CHECK(found["speed"]["changed"].get<int>() > 1000);
  CHECK(found["speed"]["legend"].get<std::string>().find("speed, m/s") != std::string::npos);
  CHECK(found["speed"]["bar"].get<int>() > 0);
  CHECK(found["contact"]["changed"].get<int>() > 1000);
  CHECK(found["contact"]["legend"].get<std::string>().find("orange: in contact") != std::string::npos);
  CHECK(found["contact"]["bar"] == 0);
  CHECK(found["layout"]["outside"] == nlohmann::json::array());
  CHECK(found["layout"]["legend_over_picture"] == true);
  CHECK(found["covered"] == 0);
  CHECK(found["banner"].is_null());
  for (const char* part : {"leaves out", "work of loads and moving obstacles", "damping"}) {
    CHECK(found["remark"][0].get<std::string>().find(part) != std::string::npos);
  }
  CHECK(found["facts"].get<std::string>().find("time step 0.025 s") != std::string::npos);
  CHECK(found["played"].get<int>() > 0);  // how fast is up to the browser's clock, which is no clock here
  CHECK(page.dom.find("<b id=\"broken\"") == std::string::npos);  // the title stayed a title
}

TEST_CASE("a screenshot of the page is not blank, and parameters of the address apply") {
  const TemporaryFolder folder;
  REQUIRE_FALSE(run_scene(testing::everything_to_see(), plugins(), {folder.path(), "everything", {}}).failure);
  const auto picture = [&](const std::string& hash) {
    const Visit page = visit(folder, address(folder, hash), "--screenshot=picture.png");
    CHECK(page.status == 0);
    CHECK(console(page.log) == "");
    return look_at(folder, "picture.png");
  };
  const nlohmann::json whole = picture("time=1");
  CHECK(whole["width"] == 1280);
  CHECK(whole["drawn"].get<double>() > 0.2);  // background, network, panel, curves
  CHECK(whole["colours"].get<int>() > 1000);  // shaded surfaces
  const nlohmann::json bare = picture("time=1&bare=1&labels=0");
  CHECK(bare["drawn"].get<double>() > 0.05);
  const nlohmann::json far = picture("time=1&bare=1&labels=0&zoom=0.3&instruments=0");
  CHECK(far["drawn"].get<double>() > 0.002);
  CHECK(far["drawn"].get<double>() < 0.5 * bare["drawn"].get<double>());
}

TEST_CASE("without WebGL the page says so, and keeps its curves") {
  const TemporaryFolder folder;
  REQUIRE_FALSE(run_scene(testing::everything_to_see(), plugins(), {folder.path(), "everything", {}}).failure);
  const Visit page = visit(folder, address(folder, "selftest=1"), "--disable-3d-apis --dump-dom");
  const nlohmann::json found = element(page.dom, "selftest");
  CHECK(found["has_webgl"] == false);
  CHECK(found["plots"].get<int>() >= 2);
  CHECK(page.dom.find("WebGL is missing or disabled") != std::string::npos);
}

TEST_CASE("loads are drawn as resultants, on request at each node; displacements are exaggerated on request") {
  const TemporaryFolder folder;
  Scene scene = testing::barely_bent();
  scene.options.time_step = 0.0008;  // so many records that the page samples only every second position
  REQUIRE_FALSE(run_scene(scene, plugins(), {folder.path(), "beam", {}}).failure);
  const Visit page = visit(folder, address(folder, "selftest=1"), "--dump-dom");
  CHECK(console(page.log) == "");
  const nlohmann::json found = element(page.dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  REQUIRE(found["arrows"].size() == 2);
  const nlohmann::json &resultants = found["arrows"][0], &nodes = found["arrows"][1];
  // In the middle of the run one of the two loads is over.
  REQUIRE(resultants["count"] == 1);
  CHECK(resultants["legend"] == "longest arrow 90 mN, a load\u2019s resultant");
  REQUIRE(nodes["count"] == 9);
  CHECK(nodes["legend"] == "longest arrow 45 mN");  // of the load that is over
  // The resultant acts in the middle of the nine nodes at the end.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double mean = 0.0;
    for (const auto& place : nodes["places"]) mean += place[axis].get<double>() / 9.0;
    CHECK(resultants["places"][0][axis].get<double>() == doctest::Approx(mean).epsilon(1e-6));
  }
  for (const auto& each : found["arrows"]) {
    CHECK(each["longest"].get<double>() < 0.17);  // of the network's diagonal
    CHECK(each["pixels"].get<int>() > 50);
    CHECK(each["pixels"].get<int>() < 10000);  // of some 500,000
  }
  for (const auto& most : found["resized"]) CHECK(most.get<double>() < 0.9);  // all nodes in view, with a margin
  // The page stores positions as 32 bit floats: a stretch within their rounding is shown as 0.
  for (const auto& stretch : found["stretches_at_start"]) CHECK(stretch == "0 %");
  CHECK(found["stretches_at_start"].size() == scene.network.springs().size());

  // Displacements drawn larger: marked, picked where they are drawn, with true numbers.
  const nlohmann::json& larger = found["exaggerated"];
  const std::vector<double> factors = larger["factors"];
  REQUIRE(factors.size() > 3);
  CHECK(factors[0] == 1.0);
  CHECK(factors.back() >= 100.0);
  CHECK(larger["note"] == fmt::format("displacement \u00d7 {:g}", factors.back()));
  CHECK(larger["error"].get<double>() < 1e-6);
  CHECK(larger["moved"].get<double>() > 0.01);
  CHECK(larger["moved"].get<double>() < 1.0);
  CHECK(larger["changed"].get<int>() > 1000);
  CHECK(larger["values_unchanged"] == true);
  CHECK(larger["picked"] == 72);
  CHECK(larger["farthest"].get<double>() < 1.0);  // all of it in view
  CHECK(larger["restored"] == true);
  // So does the address, with any factor; obstacles stay in place, and the label says so.
  REQUIRE_FALSE(run_scene(testing::everything_to_see(), plugins(), {folder.path(), "everything", {}}).failure);
  const Visit other = visit(folder, address(folder, "displacement=1.5&time=1"), "--dump-dom");
  CHECK(console(other.log) == "");
  CHECK(other.dom.find("displacement \u00d7 1.5, obstacles \u00d7 1<") != std::string::npos);
}

TEST_CASE("forces between bodies in contact are pairs of arrows, in the middle of where they touch") {
  const TemporaryFolder folder;
  REQUIRE_FALSE(run_scene(testing::lifted_balls(), plugins(), {folder.path(), "balls", {}}).failure);
  const Visit page = visit(folder, address(folder, "selftest=1"), "--dump-dom");
  CHECK(console(page.log) == "");
  const nlohmann::json found = element(page.dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  CHECK(found["touch_control"] == true);
  CHECK(found["key"].get<std::string>().find("force between bodies in contact") != std::string::npos);
  const nlohmann::json& touches = found["touches"];
  CHECK(touches["most"] == 2);
  CHECK(touches["count_at_start"] == 0);
  CHECK(touches["legend"] == "longest arrow between bodies 10 N");
  CHECK(touches["longest"].get<double>() == doctest::Approx(0.16));  // of the diagonal
  CHECK(touches["pixels"].get<int>() > 50);
  REQUIRE(touches["arrows"].size() == 4);
  for (std::size_t k = 0; k < 4; ++k) {
    CAPTURE(k);
    const nlohmann::json& arrow = touches["arrows"][k];
    const double height = k < 2 ? 0.225 : 0.425;  // at the end, lifted by 0.125 m
    CHECK(arrow["place"][2].get<double>() == doctest::Approx(height).epsilon(1e-6));
    CHECK(touches["exaggerated"][k][2].get<double>() == doctest::Approx(height + 4 * 0.125).epsilon(1e-6));
    // The upper touch carries half; down on the lower ball, up on the one above.
    CHECK(arrow["share"].get<double>() == doctest::Approx(k < 2 ? 1.0 : 0.5).epsilon(1e-5));
    CHECK(arrow["direction"][2].get<double>() == doctest::Approx(k % 2 == 0 ? -1.0 : 1.0).epsilon(1e-6));
    for (const std::size_t axis : {0, 1}) CHECK(arrow["place"][axis].get<double>() == 0.0);
  }
  const auto picture = [&](const std::string& hash) {
    CHECK(console(visit(folder, address(folder, hash), "--screenshot=picture.png").log) == "");
    return testing::read_text(folder.path() / "picture.png");
  };
  const std::string shown = picture("time=0.5&bare=1&labels=0");
  CHECK(picture("time=0.5&bare=1&labels=0&touches=1") == shown);
  CHECK(picture("time=0.5&bare=1&labels=0&touches=0") != shown);
}

TEST_CASE("an impact does not shorten the arrows of bodies at rest; the legend has its force") {
  const TemporaryFolder folder;
  Scene scene;
  testing::add_ball(scene.network, "ball", {0, 0, 0.3}, testing::at_rest, 0.5, 0.1);
  testing::add_ball(scene.network, "ground", {0, 0, 0}, testing::at_rest, 1.0, 0.1, true);
  testing::touch_all(scene.network, testing::frictionless);
  scene.network.set_gravity({0, 0, -10});
  scene.duration = 1.0;
  scene.options.time_step = 0.02;
  scene.options.integrator = testing::verlet;
  REQUIRE_FALSE(run_scene(scene, plugins(), {folder.path(), "balls", {}}).failure);
  const Visit page = visit(folder, address(folder, "selftest=1"), "--dump-dom");
  CHECK(console(page.log) == "");
  const nlohmann::json found = element(page.dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  const nlohmann::json& touches = found["touches"];
  REQUIRE(touches["arrows"].size() == 2);
  for (const auto& arrow : touches["arrows"]) CHECK(arrow["share"].get<double>() == doctest::Approx(1.0).epsilon(1e-5));
  CHECK(touches["largest_share"] == 1.0);
  // It arrives with about 1.4 m/s, and is stopped within a step.
  const std::string legend = touches["legend"], start = "longest arrow between bodies 5 N; beyond: up to ";
  REQUIRE(legend.starts_with(start));
  CHECK(std::stod(legend.substr(start.size())) ==
        doctest::Approx(0.5 * std::sqrt(2.0 * 10.0 * 0.1) / 0.02).epsilon(0.2));
}

TEST_CASE(
    "a failed run has a banner with the reason, whatever characters are in it; a stopped one says where it ended") {
  const TemporaryFolder folder;
  Scene scene = testing::barely_bent();
  Node far;
  far.mass = 1e15;
  far.position = Vector3(0.0, 0.0, 1e6);
  far.fixed = true;
  scene.network.add_node(far);
  scene.network.set_gravity(Vector3(0.0, 0.0, -10.0));
  const auto banner = [&](const std::string& reason) {
    Simulation simulation(scene.network, plugins(), scene.options);
    {
      ViewWriter writer(folder.path() / "view.html", scene);
      writer.record(simulation);
      simulation.advance_to(0.1);
      writer.record(simulation);
      if (!reason.empty()) writer.failed(reason);
      writer.close();
    }
    const Visit page = visit_small(folder, 360, 640);
    CHECK(console(page.log) == "");
    const nlohmann::json found = element(page.dom, "selftest");
    CHECK(found["errors"] == nlohmann::json::array());
    CHECK(found["layout"]["outside"] == nlohmann::json::array());
    // Some joules beside 1e22 J of the far node: below the rounding of their sum.
    CHECK(simulation.kinetic_energy() > 0.1);
    CHECK(found["curves"][0]["values"][0] == "kinetic 0");
    return found["banner"];
  };
  const std::string hostile = "spring '</script><script>springnet.errors.push(1)</script>' & \"x\"\n";
  const nlohmann::json failed = banner(hostile + std::string(3000, 'x'));
  CHECK(failed["kind"] == "failed");
  CHECK(failed["text"].get<std::string>().starts_with("The run failed at 0.1 s of 0.5 s: " + hostile));
  CHECK(failed["height"].get<int>() < 200);  // a long one is scrolled
  CHECK(failed["height"].get<int>() > 50);
  const nlohmann::json ended = banner("");
  CHECK(ended["kind"] == "stopped");
  CHECK(ended["text"].get<std::string>().starts_with("The run ended early, at 0.1 s of 0.5 s."));
}

TEST_CASE("a window of 360 x 640 has nothing outside of it, a picture as wide as it, and the legend below") {
  const TemporaryFolder folder;
  REQUIRE_FALSE(run_scene(testing::everything_to_see(), plugins(), {folder.path(), "everything", {}}).failure);
  const Visit page = visit_small(folder, 360, 640);
  CHECK(console(page.log) == "");
  const nlohmann::json found = element(page.dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  const nlohmann::json& layout = found["layout"];
  CHECK(layout["window"].get<int>() <= 360);
  CHECK(layout["window"].get<int>() > 340);  // a scroll bar at most
  CHECK(layout["legend_over_picture"] == false);
  CHECK(found["legend"].get<std::string>().find("blue: compression") != std::string::npos);
  CHECK(layout["scroll_width"] == layout["window"]);
  CHECK(layout["outside"] == nlohmann::json::array());
  CHECK(layout["view"] == layout["window"]);
  CHECK(layout["height"].get<int>() > 300);
  for (const auto& width : layout["plots"]) CHECK(width.get<int>() > 300);
  for (const auto& curve : found["curves"]) CHECK(curve["cut"].get<int>() <= 1);
  CHECK(found["covered"] == 0);
}

TEST_CASE("a page with rounded numbers shows significant digits only, and a thinned one keeps its last record") {
  const TemporaryFolder folder;
  Scene scene = testing::everything_to_see();
  scene.options.time_step = 0.005;
  REQUIRE_FALSE(run_scene(scene, plugins(), {folder.path(), "everything", {}}).failure);
  const auto whole = static_cast<double>(testing::read_text(folder.path() / "view.html").size());
  const double program = view::program_bytes();
  scene.output.view_size = program + (whole - program) / 3.0;
  REQUIRE_FALSE(run_scene(scene, plugins(), {folder.path(), "everything", {}}).failure);
  const Visit page = visit(folder, address(folder, "selftest=1"), "--dump-dom");
  CHECK(console(page.log) == "");
  const nlohmann::json found = element(page.dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  const nlohmann::json about = element(page.dom, "description");
  REQUIRE(about["rounded"] == true);
  CHECK(found["frames"] < 301);
  CHECK(found["stops"][2]["time"].get<double>() == doctest::Approx(1.5).epsilon(1e-9));
  CHECK(found["notes"].size() == 2);
  // The resolution is about 5 m / 65535 for positions, some N / 32767 for tensions: shown to the next power of ten.
  check_values(found["numbers"], scene, 1e-3, 1e-3);
  for (const char* what : {"node", "last_node"}) {
    for (const double number : numbers_in(found["numbers"][what]["position"])) {
      CHECK(std::abs(number - 1e-4 * std::round(1e4 * number)) < 1e-12);
    }
  }
}

TEST_CASE("curves of elements have their values, in a unit and with digits that distinguish them") {
  const TemporaryFolder folder;
  const Scene scene = testing::with_elements();
  REQUIRE_FALSE(run_scene(scene, plugins(), {folder.path(), "elements", {}}).failure);
  const nlohmann::json found = element(visit(folder, address(folder, "selftest=1"), "--dump-dom").dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  REQUIRE(found["curves"].size() == 4);
  Simulation simulation(scene.network, plugins(), scene.options);
  simulation.advance_to(scene.duration);
  const auto value = [](const nlohmann::json& text) {
    return std::stod(text.get<std::string>().substr(4));
  };  // now 1.2
  CHECK(found["curves"][2]["title"] == "volume, dm\u00b3");
  CHECK(value(found["curves"][2]["values"][0]) == doctest::Approx(1e3 * simulation.element_value(0)).epsilon(1e-3));
  CHECK(found["curves"][3]["title"] == "area, cm\u00b2");
  for (const auto& curve : found["curves"]) {
    CAPTURE(curve["title"].get<std::string>());
    const std::vector<std::string> ticks = curve["ticks"];
    CHECK(ticks.size() >= 2);
    CHECK(std::set<std::string>(ticks.begin(), ticks.end()).size() == ticks.size());
  }
}

TEST_CASE("what the labels of many curves share is in the title, and none of their values is cut off") {
  const TemporaryFolder folder;
  REQUIRE_FALSE(run_scene(testing::with_elements(7), plugins(), {folder.path(), "elements", {}}).failure);
  const Visit page = visit_small(folder, 800, 600);
  const nlohmann::json found = element(page.dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  REQUIRE(found["curves"].size() == 4);
  CHECK(found["curves"][3]["title"] == "area, elements, cm\u00b2");
  REQUIRE(found["curves"][3]["values"].size() == 7);
  CHECK(found["curves"][3]["values"][6].get<std::string>().starts_with("7 "));  // element 0 is the volume
  for (const auto& curve : found["curves"]) CHECK(curve["cut"].get<int>() <= 1);
}

TEST_CASE("records inside the steps of an integrator leave no gaps in the curve of its evaluations") {
  const TemporaryFolder folder;
  Scene scene = testing::with_elements();
  scene.options.integrator = {"cvode", {}};
  scene.options.time_step = 0.002;
  REQUIRE_FALSE(run_scene(scene, plugins(), {folder.path(), "elements", {}}).failure);
  const nlohmann::json found = element(visit(folder, address(folder, "selftest=1"), "--dump-dom").dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  CHECK(found["curves"][1]["title"] == "evaluations per internal step");
  CHECK(found["curves"][1]["values"][0].get<std::string>().find_first_of("123456789") != std::string::npos);
  CHECK(found["curves"][1]["gaps"] == 0);
  CHECK(found["facts"].get<std::string>().find("records every 0.002 s") != std::string::npos);
  CHECK(found["facts"].get<std::string>().find("time step") == std::string::npos);
}

TEST_CASE("internal states are colours of springs, and values of the one that is picked") {
  const TemporaryFolder folder;
  const Scene scene = testing::with_memory();
  REQUIRE_FALSE(run_scene(scene, plugins(), {folder.path(), "memory", {}}).failure);
  const Visit page = visit(folder, address(folder, "selftest=1"), "--dump-dom");
  CHECK(console(page.log) == "");
  const nlohmann::json found = element(page.dom, "selftest");
  CHECK(found["errors"] == nlohmann::json::array());
  REQUIRE(found["states"].size() == 2);
  for (const auto& each : found["states"]) {
    CHECK(each["changed"].get<int>() > 1000);
    CHECK(each["bar"].get<int>() > 0);
    CHECK(each["legend"].get<std::string>().find("pale: springs without it") != std::string::npos);
  }
  CHECK(found["states"][0]["legend"].get<std::string>().starts_with("flow of plastic, m"));
  CHECK(found["states"][1]["legend"].get<std::string>().starts_with("damage of damaging"));
  CHECK(found["states"][0]["option"] == "flow of plastic (m)");
  // Every value of every spring at the end.
  Simulation simulation(scene.network, plugins(), scene.options);
  simulation.advance_to(scene.duration);
  const nlohmann::json& values = found["state_values"];
  REQUIRE(values.size() == scene.network.springs().size());
  std::size_t with_flow = 0, with_damage = 0;
  for (SpringIndex k = 0; k < values.size(); ++k) {
    CAPTURE(k);
    const std::vector<double> states = simulation.internal_states(k);
    const bool damage = !states.empty() && simulation.internal_state_names(k)[0].name == "damage";
    for (const bool of_damage : {false, true}) {
      const nlohmann::json& value = values[k][of_damage ? 1 : 0];
      if (states.empty() || damage != of_damage) {
        CHECK(value.is_null());
        continue;
      }
      ++(of_damage ? with_damage : with_flow);
      CHECK(value.get<double>() == doctest::Approx(states[0]).epsilon(1e-6));
    }
  }
  CHECK(with_flow > 10);
  CHECK(with_damage > 10);
  // A picture of a state differs from that of another, and the address selects it.
  const auto picture = [&](const std::string& hash) {
    const Visit visited = visit(folder, address(folder, hash), "--screenshot=picture.png");
    CHECK(console(visited.log) == "");
    return testing::read_text(folder.path() / "picture.png");
  };
  CHECK(picture("time=1&color=flow%20of%20plastic") != picture("time=1"));
}

TEST_CASE("a page of laws without memory offers no states") {
  const TemporaryFolder folder;
  REQUIRE_FALSE(run_scene(testing::barely_bent(), plugins(), {folder.path(), "beam", {}}).failure);
  const nlohmann::json found = element(visit(folder, address(folder, "selftest=1"), "--dump-dom").dom, "selftest");
  CHECK(found["states"] == nlohmann::json::array());
}
