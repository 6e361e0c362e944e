// Pages in a headless Chromium: they draw, their controls work, nothing is complained about.
#include <cstdlib>
#include <fstream>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "csv.hpp"
#include "output/view/base64.hpp"
#include "scenes.hpp"
#include "temporary_folder.hpp"

using namespace springnet;
using testing::plugins;
using testing::TemporaryFolder;

namespace {

struct Visit {
  int status;
  std::string dom, log;
};

// A page that tries itself gets 25 s of the browser's clock: on a busy machine it waits long for a picture.
// --no-sandbox: tests run as root in containers. swiftshader: there is no graphics card.
Visit visit(const TemporaryFolder& folder, const std::string& address, const std::string& action) {
  const int patience = address.find("selftest") == std::string::npos ? 4000 : 25000;  // ms
  const std::string line =
      fmt::format("cd '{}' && timeout 120 '" SPRINGNET_CHROMIUM
                  "' --headless --no-sandbox --enable-unsafe-swiftshader --disable-quic --no-first-run "
                  "--disable-background-networking --disable-component-update --disable-sync --disable-extensions "
                  "--hide-scrollbars --window-size=1280,800 --user-data-dir=profile --virtual-time-budget={} "
                  "--enable-logging=stderr --v=0 {} '{}' > dom.txt 2> log.txt",
                  folder.path().string(), patience, action, address);
  const int status = std::system(line.c_str());
  return {status, testing::read_text(folder.path() / "dom.txt"), testing::read_text(folder.path() / "log.txt")};
}

std::string address(const TemporaryFolder& folder, const std::string& hash) {
  return "file://" + (folder.path() / "view.html").string() + "#" + hash;
}

nlohmann::json element(const std::string& dom, const std::string& id) {
  const std::string start = "<script type=\"application/json\" id=\"" + id + "\">";
  const std::size_t begin = dom.find(start);
  REQUIRE_MESSAGE(begin != std::string::npos, "no ", id, " in the page");
  const std::size_t text = begin + start.size();
  return nlohmann::json::parse(dom.substr(text, dom.find("</script>", text) - text));
}

// Messages on the browser's console: errors, warnings, refused requests. Not that software draws slowly.
std::string console(const std::string& log) {
  std::istringstream lines(log);
  std::string found;
  for (std::string line; std::getline(lines, line);) {
    if (line.find(":CONSOLE") == std::string::npos || line.find("GL Driver Message") != std::string::npos) continue;
    found += line + "\n";
  }
  return found;
}

// What share of a picture is not of its commonest colour, and how many colours it has: read by the browser.
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
  CHECK(found["works"] == true);
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
  // Each switch takes away what can be seen; the broken springs lie where triangles are torn.
  for (const char* what : {"springs", "broken", "nodes", "faces", "instruments"}) {
    CAPTURE(what);
    CHECK(found["toggled"][what].get<int>() > 100);
  }
  CHECK(found["plots"].get<int>() >= 2);
  CHECK(found["legend"].get<std::string>().find("tension of springs, N") != std::string::npos);
  // A drag of 60 pixels turns the eye by some degrees; a click in the middle of a curve goes near the middle.
  CHECK(found["eye_moved"].get<double>() > 0.1);
  CHECK(std::abs(found["curve_clicked"].get<int>() - 30) <= 6);
  CHECK(found["played"].get<int>() > 0);  // how fast is up to the browser's clock, which is no clock here
  CHECK(page.dom.find("<b id=\"broken\"") == std::string::npos);  // the title stayed a title
}

TEST_CASE("a screenshot of the page is not blank, and the address says what is on it") {
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
  CHECK(found["works"] == false);
  CHECK(found["plots"].get<int>() >= 2);
  CHECK(page.dom.find("This browser draws nothing in three dimensions here") != std::string::npos);
}
