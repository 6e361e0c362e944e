// The page as a file; tests/view/browser.cpp opens it.
#include <algorithm>
#include <cmath>
#include <cstring>

#include <doctest/doctest.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "scenes.hpp"
#include "temporary_folder.hpp"
#include "view/content.hpp"
#include "view/units.hpp"

using namespace springnet;
using testing::plugins;
using testing::TemporaryFolder;

namespace {

RunSummary run(const Scene& scene, const TemporaryFolder& folder) {
  return run_scene(scene, plugins(), {folder.path(), "everything", {}});
}

std::string page_in(const TemporaryFolder& folder) { return testing::read_text(folder.path() / "view.html"); }

std::string element(const std::string& page, const std::string& id) {
  const std::string start = " id=\"" + id + "\">";
  const std::size_t begin = page.find(start);
  if (begin == std::string::npos) return "";
  return page.substr(begin + start.size(), page.find("</script>", begin) - begin - start.size());
}

nlohmann::json description(const std::string& page) { return nlohmann::json::parse(element(page, "description")); }

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

std::vector<unsigned char> decode(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> bytes;
  unsigned held = 0, bits = 0;
  for (const char digit : text) {
    if (digit == '=') break;
    held = held << 6U | static_cast<unsigned>(digits.find(digit));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<unsigned char>(held >> bits & 255U));
  }
  return bytes;
}

template <class Number>
std::vector<Number> block(const std::string& page, const std::string& id) {
  const std::vector<unsigned char> bytes = decode(element(page, id));
  std::vector<Number> numbers(bytes.size() / sizeof(Number));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(Number));
  return numbers;
}

}  // namespace

TEST_CASE("the page contains its libraries, with their licence, and refers to nothing outside") {
  const TemporaryFolder folder;
  const RunSummary summary = run(testing::everything_to_see(), folder);
  CHECK(std::count(summary.files.begin(), summary.files.end(), "view.html") == 1);
  const std::string page = page_in(folder);
  CHECK(page.find("REVISION=\"111\"") != std::string::npos);
  CHECK(page.find("OrbitControls") != std::string::npos);
  CHECK(page.find("Dygraph") != std::string::npos);
  CHECK(page.find("MIT licence") != std::string::npos);
  CHECK(page.find("Content-Security-Policy\" content=\"default-src 'none'") != std::string::npos);
  for (const char* reference : {"src=\"http", "src='http", "href=", "@import", "url(http", "src=\"//", "<link"}) {
    CAPTURE(reference);
    CHECK(page.find(reference) == std::string::npos);
  }
  for (const char* marker : {"@style@", "@libraries@", "@program@", "@data@", "@notices@"}) {
    CHECK(page.find(marker) == std::string::npos);
  }
}

TEST_CASE("nothing of the scene ends an element of the page early") {
  const TemporaryFolder folder;
  run(testing::everything_to_see(), folder);
  const std::string page = page_in(folder);
  CHECK(description(page)["title"] == testing::bad_title);
  CHECK(page.find("<b id=\"broken\">") == std::string::npos);
  CHECK(count(page, "</script>") == count(page, "<script"));
}

TEST_CASE("positions, tensions, events and energies are those of the run") {
  const TemporaryFolder folder;
  const Scene scene = testing::everything_to_see();
  run(scene, folder);
  const std::string page = page_in(folder);
  const nlohmann::json about = description(page);
  CHECK(about["rounded"] == false);
  const std::size_t frames = about["frames"];
  REQUIRE(frames == 61);
  const auto positions = block<float>(page, "positions");
  const auto speeds = block<float>(page, "speeds");
  const auto tensions = block<float>(page, "tensions");
  const auto scalars = block<double>(page, "scalars");
  const auto contact = block<std::uint8_t>(page, "contact");
  const auto places = block<float>(page, "surface_poses");
  REQUIRE(positions.size() == frames * 3 * 65);
  REQUIRE(tensions.size() == frames * scene.network.springs().size());
  const std::size_t width = scalars.size() / frames;

  // Exact, but for what is only rounding: 0 on the page.
  const auto same = [](float shown, double value, double floor) {
    return shown == static_cast<float>(value) || (shown == 0.0F && std::abs(value) < floor);
  };
  Simulation simulation(scene.network, plugins(), scene.options);
  std::size_t touching = 0;
  for (std::size_t frame = 0; frame < frames; ++frame) {
    if (frame + 1 == frames) {
      simulation.advance_to(scene.duration);
    } else if (frame > 0) {
      simulation.step();
    }
    CHECK(scalars[frame * width] == doctest::Approx(simulation.time()).epsilon(1e-15));
    if (frame + 1 == frames) break;  // the run's last step ends at the duration itself
    CHECK(scalars[frame * width + 1] == simulation.kinetic_energy());
    CHECK(scalars[frame * width + 2] == simulation.potential_energy());
    CHECK(scalars[frame * width + 4] == static_cast<double>(simulation.sweeps()));
    for (NodeIndex node = 0; node < 65; ++node) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        CHECK(same(positions[(frame * 65 + node) * 3 + axis],
                   simulation.position(node)[static_cast<Eigen::Index>(axis)], 1e-14));
      }
      CHECK(same(speeds[frame * 65 + node], simulation.velocity(node).norm(), 1e-12));
      const bool touches = (contact[frame * 9 + node / 8] >> node % 8 & 1) != 0;
      CHECK(touches == simulation.touching(node));
      touching += touches ? 1 : 0;
    }
    for (SpringIndex k = 0; k < scene.network.springs().size(); ++k) {
      CHECK(same(tensions[frame * scene.network.springs().size() + k], simulation.tension(k), 1e-12));
    }
    CHECK(places[frame * 14 + 9] == static_cast<float>(simulation.surface_position(1).z()));
  }
  CHECK(touching > 0);  // the ground was reached
  const auto removed = block<std::uint32_t>(page, "removed_springs");
  const auto gone = block<std::uint32_t>(page, "removed_frames");
  REQUIRE(removed.size() == count_events(simulation).cut);
  REQUIRE_FALSE(removed.empty());
  for (std::size_t k = 0; k < removed.size(); ++k) {
    CHECK_FALSE(simulation.alive(removed[k]));
    CHECK(scalars[gone[k] * width] == doctest::Approx(0.5).epsilon(1e-9));  // the time of the cut
  }
  // Triangles are torn where the spring along an edge is gone: all of them in the one cut.
  const auto torn = block<std::uint32_t>(page, "face_frames");
  REQUIRE(torn.size() == 6 * 9 * 2);
  std::size_t cut_off = 0;
  for (std::size_t k = 0; k < torn.size(); ++k) {
    const bool tears = std::any_of(removed.begin(), removed.end(), [&](std::uint32_t each) {
      const Face& face = scene.network.faces()[k];
      const Spring& spring = scene.network.springs()[each];
      return std::count(face.begin(), face.end(), spring.first) + std::count(face.begin(), face.end(), spring.second) ==
             2;
    });
    CHECK(torn[k] == (tears ? gone[0] : view::not_shown));
    cut_off += tears ? 1 : 0;
  }
  // The two beside the spring listed in the cut, and those about the edges along z that its square crosses.
  CHECK(cut_off > 4);
  CHECK(cut_off < torn.size() / 4);
}

TEST_CASE("the curves of elements are their values in the run") {
  const Scene scene = testing::with_elements();
  const TemporaryFolder folder;
  REQUIRE_FALSE(run(scene, folder).failure);
  const std::string page = page_in(folder);
  const nlohmann::json about = description(page);
  REQUIRE(about["curves"].size() == 2);
  CHECK(about["curves"][0]["label"] == "volume (element 0)");
  CHECK(about["curves"][0]["unit"] == "m^3");
  CHECK(about["curves"][1]["unit"] == "m^2");
  CHECK(about["curves"][0]["reference"] == 0.25);
  CHECK(about["curves"][0]["kind"] == "volume");
  CHECK(about["curves"][1]["element"] == 1);

  const auto scalars = block<double>(page, "scalars");
  const auto positions = block<float>(page, "positions");
  const std::size_t frames = about["frames"];
  REQUIRE(frames == 51);
  const std::size_t width = scalars.size() / frames;
  REQUIRE(width == view::fixed_scalars + 2);
  Simulation simulation(scene.network, plugins(), scene.options);
  double smallest = 1.0, largest = 0.0;
  for (std::size_t frame = 0; frame + 1 < frames; ++frame) {  // the run's last step ends at the duration itself
    if (frame > 0) simulation.step();
    const double volume = scalars[frame * width + view::fixed_scalars];
    CHECK(volume == simulation.element_value(0));
    CHECK(scalars[frame * width + view::fixed_scalars + 1] == simulation.element_value(1));
    const auto place = [&](std::size_t node) {
      const float* at = positions.data() + (frame * 4 + node) * 3;
      return Vector3(at[0], at[1], at[2]);
    };
    const Vector3 a = place(1) - place(0), b = place(2) - place(0), c = place(3) - place(0);
    CHECK(volume == doctest::Approx(a.dot(b.cross(c)) / 6.0).epsilon(1e-6));  // of positions in 32 bits
    CHECK(scalars[frame * width + view::fixed_scalars + 1] ==
          doctest::Approx((b - a).cross(c - a).norm() / 2.0).epsilon(1e-6));
    smallest = std::min(smallest, volume);
    largest = std::max(largest, volume);
  }
  CHECK(largest > 1.1 * smallest);  // it moved
}

TEST_CASE("a long run is rounded and thinned to the requested size, with notes on the page and in the summary") {
  const TemporaryFolder folder;
  Scene scene = testing::everything_to_see();
  scene.options.time_step = 0.005;  // far more records than the 60 for which springs would be left out
  run(scene, folder);
  const std::string whole = page_in(folder);
  // A third of what the data take: 16 bits would give a half.
  const double program = view::program_bytes();
  scene.output.view_size = program + (static_cast<double>(whole.size()) - program) / 3.0;
  const RunSummary summary = run(scene, folder);
  const std::string page = page_in(folder);
  CHECK(static_cast<double>(page.size()) <= scene.output.view_size);
  const nlohmann::json about = description(page);
  CHECK(about["rounded"] == true);
  CHECK(about["frames"] < 301);
  CHECK(about["frames"] >= 100);
  CHECK(about["records"] == 301);
  std::string notes, in_summary;
  for (const std::string note : about["notes"]) notes += note + "\n";
  for (const std::string& note : summary.notes) in_summary += note + "\n";
  CHECK(notes.find("of 301 records are shown") != std::string::npos);
  CHECK(notes.find("rounded to 16 bits") != std::string::npos);
  CHECK(in_summary.find("view.html: ") != std::string::npos);
  CHECK(in_summary.find("of 301 records are shown") != std::string::npos);

  // The last record is in both, there rounded to half of a 65535th of the range.
  const auto exact = block<float>(whole, "positions");
  const auto shares = block<std::uint16_t>(page, "positions");
  const auto range = block<float>(page, "positions_range");
  const float step = (range[1] - range[0]) / 65535.0F;
  REQUIRE(shares.size() == about["frames"].get<std::size_t>() * 195);
  for (std::size_t k = 0; k < 195; ++k) {
    const float value = range[0] + static_cast<float>(shares[shares.size() - 195 + k]) * step;
    CHECK(std::abs(value - exact[exact.size() - 195 + k]) <= 0.51F * step);
  }
}

TEST_CASE("the estimate is near the size of the page, on the safe side") {
  const TemporaryFolder folder;
  Scene scene = testing::everything_to_see();
  run(scene, folder);
  const auto bytes = static_cast<double>(page_in(folder).size());
  CHECK(bytes <= estimate_view(scene));
  CHECK(bytes >= 0.9 * estimate_view(scene));
  scene.output.view_size = 1.2e6;
  CHECK(estimate_view(scene) == 1.2e6);
  scene.output.view = false;
  CHECK(estimate_view(scene) == 0.0);
  run(scene, folder);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "view.html"));
}

TEST_CASE("a run that fails leaves a page with what was computed, and says why") {
  const TemporaryFolder folder;
  Scene scene = testing::everything_to_see();
  // A load throws a node some hundred metres in one step: that does not settle.
  scene.options.time_step = 0.005;
  scene.options.integrator = {"recurrent",
                              {{"update", testing::wavefront}, {"unsettled", testing::on_unsettled_error}}};
  scene.network.add_load({{55}, Vector3(1e6, 0.0, 0.0), 0.7, 10.0});
  const RunSummary summary = run(scene, folder);
  REQUIRE(summary.failure);
  const std::string page = page_in(folder);
  const nlohmann::json about = description(page);
  CHECK(about["frames"] == summary.records);
  CHECK(about["frames"] > 20);
  CHECK(about["failure"].get<std::string>() == summary.error);
  CHECK(page.find("</html>") != std::string::npos);
}

TEST_CASE("during a run the page says so, and a writer that is destroyed writes what it has") {
  const TemporaryFolder folder;
  const Scene scene = testing::everything_to_see();
  Simulation simulation(scene.network, plugins(), scene.options);
  {
    ViewWriter writer(folder.path() / "view.html", scene);
    CHECK(page_in(folder).find("has not ended") != std::string::npos);
    writer.record(simulation);
  }
  CHECK(description(page_in(folder))["frames"] == 1);
  CHECK_THROWS_WITH_AS(ViewWriter(folder.path() / "no" / "view.html", scene), doctest::Contains("cannot be created"),
                       Error);
}

TEST_CASE("a page that cannot be written is an error, and no part of it is left") {
  const TemporaryFolder folder;
  const Scene scene = testing::everything_to_see();
  const Simulation simulation(scene.network, plugins(), scene.options);
  ViewWriter writer(folder.path() / "view.html", scene);
  writer.record(simulation);
  // A folder has the name of the file that the page is written to first.
  std::filesystem::create_directories(folder.path() / "view.html.part" / "full");
  CHECK_THROWS_WITH_AS(writer.close(), doctest::Contains("view.html.part: a folder has the name"), Error);
  // Nor is the page left that says that the run goes on.
  CHECK_FALSE(std::filesystem::exists(folder.path() / "view.html"));
}

TEST_CASE("curves are drawn of all elements if they are few, else of enclosed volumes") {
  Network network;
  const MaterialIndex material = network.add_material({LawUse{"linear", {{"stiffness", 1.0}}}, std::nullopt});
  for (const Vector3& place : {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)}) {
    Node node;
    node.position = place;
    network.add_node(node);
  }
  network.add_element(Invariant::volume, {0, 1, 2, 3}, material);
  CHECK(view::plotted_elements(network) == std::vector<ElementIndex>{0});
  for (int k = 0; k < 8; ++k) network.add_element(Invariant::area, {0, 1, 2}, material);
  CHECK(view::plotted_elements(network).empty());
  network.add_element(Invariant::enclosed_volume, {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}, material);
  CHECK(view::plotted_elements(network) == std::vector<ElementIndex>{9});
}

TEST_CASE("the page has the resultant of each load and the forces on nodes of every record") {
  const TemporaryFolder folder;
  const Scene scene = testing::barely_bent();
  REQUIRE_FALSE(run(scene, folder).failure);
  const std::string page = page_in(folder);
  const nlohmann::json about = description(page);
  CHECK(about["forces"] == 10);
  REQUIRE(about["loads"].size() == 2);
  CHECK(about["loads"][0]["arrows"] == 9);
  CHECK(about["loads"][1]["arrows"] == 1);
  CHECK(about["notes"].empty());
  CHECK(about["materials"][0] == "spring linear (stiffness 10000 N/m), viscosity linear (damping 10 N s/m)");
  const auto nodes = block<std::uint32_t>(page, "arrow_nodes");
  REQUIRE(nodes.size() == 10);
  CHECK(nodes[0] == 7);
  CHECK(nodes[9] == 4);
  const auto resultants = block<float>(page, "load_resultants");
  const auto forces = block<float>(page, "arrow_forces");
  const auto scalars = block<double>(page, "scalars");
  const std::size_t frames = about["frames"];
  REQUIRE(frames == 51);
  REQUIRE(resultants.size() == frames * 6);
  REQUIRE(forces.size() == frames * 30);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const bool acts = scalars[frame * scalars.size() / frames] < 0.24 - 1e-6;
    CHECK(resultants[6 * frame + 2] == doctest::Approx(-0.09F));
    CHECK(resultants[6 * frame + 4] == (acts ? 0.045F : 0.0F));
    CHECK(forces[30 * frame + 5] == -0.01F);
    CHECK(forces[30 * frame + 28] == (acts ? 0.045F : 0.0F));
  }
}

TEST_CASE("the page has the forces between bodies of every record") {
  const TemporaryFolder folder;
  const Scene scene = testing::lifted_balls();
  REQUIRE_FALSE(run(scene, folder).failure);
  const std::string page = page_in(folder);
  const nlohmann::json about = description(page);
  REQUIRE(about["frames"] == 9);
  CHECK(about["notes"].empty());
  const auto touches = block<float>(page, "touches");
  constexpr std::size_t width = 3 * view::touch_numbers;  // of three balls three pairs can touch
  REQUIRE(touches.size() == 9 * width);
  CHECK(std::count(touches.begin(), touches.begin() + width, 0.0F) == static_cast<std::ptrdiff_t>(width));
  for (std::size_t frame = 1; frame < 9; ++frame) {
    CAPTURE(frame);
    for (std::size_t k = 0; k < 2; ++k) {
      const float* touch = touches.data() + frame * width + k * view::touch_numbers;
      const double height = 0.1 + 0.2 * static_cast<double>(k) + 0.25 * 0.0625 * static_cast<double>(frame);
      CHECK(touch[0] == static_cast<float>(k));
      CHECK(touch[1] == 0.0F);
      CHECK(touch[3] == doctest::Approx(height).epsilon(1e-6));                 // the tolerance of gaps, 1e-8 m
      CHECK(touch[6] == doctest::Approx(k == 0 ? -10.0 : -5.0).epsilon(1e-5));  // on the lower one
    }
    CHECK(touches[(frame + 1) * width - 1] == 0.0F);
  }
}

TEST_CASE("a turning box has its shape, and its orientation in each frame") {
  const TemporaryFolder folder;
  Scene scene = testing::with_elements();
  Instrument slab;
  slab.name = "slab";
  slab.first = {5, 0, 0};
  slab.box.emplace();
  slab.box->size = {1.0, 2.0, 0.5};
  slab.box->radius = 0.125;
  slab.box->axes = Eigen::AngleAxisd(0.5, Vector3::UnitX()).toRotationMatrix();
  slab.turn.emplace();
  slab.turn->rate = 2.0;
  scene.network.add_instrument(slab);
  scene.network.add_plane({"floor", Vector3(0, 0, -9), Vector3::UnitZ()});
  run(scene, folder);
  const std::string page = page_in(folder);
  const nlohmann::json about = description(page), drawn = about["surfaces"][1];
  CHECK(about["surfaces"][0]["kind"] == "plane");
  CHECK(about["surfaces"][0]["moves"] == false);
  CHECK(drawn["kind"] == "box");
  CHECK(drawn["name"] == "slab");
  CHECK(drawn["moves"] == true);
  CHECK(drawn["radius"] == 0.125);
  CHECK(drawn["size"] == nlohmann::json({1.0, 2.0, 0.5}));
  CHECK(drawn["point"] == nlohmann::json({5.0, 0.0, 0.0}));
  CHECK(drawn["orientation"][0].get<double>() == doctest::Approx(std::sin(0.25)));
  CHECK(drawn["orientation"][3].get<double>() == doctest::Approx(std::cos(0.25)));
  const auto poses = block<float>(page, "surface_poses");
  const auto scalars = block<double>(page, "scalars");
  const std::size_t frames = about["frames"], width = scalars.size() / frames;
  REQUIRE(poses.size() == frames * 14);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const double half = scalars[frame * width];  // rad: half of 2 rad/s times the time
    const float* plane = &poses[frame * 14];
    CHECK(std::vector<float>(plane, plane + 7) == std::vector<float>{0, 0, -9, 0, 0, 0, 1});
    const float* box = plane + 7;
    CHECK(box[0] == 5.0F);
    CHECK(box[5] == doctest::Approx(std::sin(half)).epsilon(1e-6));  // numbers of 32 bits
    CHECK(box[6] == doctest::Approx(std::cos(half)).epsilon(1e-6));
  }
}

TEST_CASE("a pressure on a closed surface has forces on nodes but no resultant, until a part of it is torn") {
  const TemporaryFolder folder;
  Scene scene = testing::everything_to_see();  // cut at 0.5 s
  Load load;
  load.faces = scene.network.faces();
  load.pressure = -0.01;
  load.follow = true;
  load.from = 0.0;
  load.course.ramp = 0.4;
  scene.network.add_load(load);
  scene.duration = 0.6;
  REQUIRE_FALSE(run(scene, folder).failure);
  const std::string page = page_in(folder);
  const nlohmann::json about = description(page);
  const std::size_t frames = about["frames"], arrows = about["loads"][1]["arrows"];
  REQUIRE(frames == 25);
  CHECK(about["loads"][1]["nodes"] == 56);
  REQUIRE(arrows == 56);
  const auto resultants = block<float>(page, "load_resultants");
  const auto forces = block<float>(page, "arrow_forces");
  const auto sum_of_sizes = [&](std::size_t frame) {
    double sum = 0.0;
    for (std::size_t k = 1; k <= arrows; ++k) {
      const float* force = forces.data() + 3 * (frame * (arrows + 1) + k);
      sum += std::sqrt(static_cast<double>(force[0] * force[0] + force[1] * force[1] + force[2] * force[2]));
    }
    return sum;
  };
  const auto resultant = [&](std::size_t frame) {
    const float* force = resultants.data() + 6 * frame + 3;
    return std::abs(force[0]) + std::abs(force[1]) + std::abs(force[2]);
  };
  CHECK(sum_of_sizes(0) == 0.0);
  // 54 m^2 under 0.01 Pa, less where edges turn the sums of the three sides; half of the ramp.
  CHECK(sum_of_sizes(8) > 0.2);
  CHECK(sum_of_sizes(8) < 0.27);
  CHECK(sum_of_sizes(16) > 1.9 * sum_of_sizes(8));
  for (std::size_t frame = 0; frame < 20; ++frame) CHECK(resultant(frame) == 0.0F);
  CHECK(sum_of_sizes(24) < 0.98 * sum_of_sizes(19));  // a few of 108 triangles are torn
  CHECK(resultant(24) > 1e-3F);
}

TEST_CASE("of very many forces some of each load are drawn, with a note") {
  Network network;
  Load load;
  load.force = Vector3::UnitX();
  for (NodeIndex k = 0; k < 1000; ++k) {
    Node node;
    node.position = Vector3(k, 0.0, 0.0);
    load.nodes.push_back(network.add_node(node));
  }
  network.add_load(load);
  network.add_load({{3}, Vector3::UnitY()});  // hidden among the others, but a load of its own
  network.add_load({{1}, Vector3::Zero()});   // nothing to draw
  const view::Forces forces = view::forces_of(network, view::select(network, 10.0, 1e6));
  CHECK(forces.all == 1001);
  REQUIRE(forces.loads.size() == 2);
  CHECK(forces.loads[0].arrows == 199);
  CHECK(forces.loads[1].arrows == 1);
  REQUIRE(forces.arrows.size() == 200);
  CHECK(forces.arrows[0].node == 0);
  CHECK(forces.arrows[198].node == 994);
  CHECK(forces.arrows[199].node == 3);
  REQUIRE(forces.notes.size() == 1);
  CHECK(forces.notes[0].find("200 of 1001 forces") != std::string::npos);
}

TEST_CASE("of very many loads some are drawn, spread over all, with a note") {
  Network network;
  for (NodeIndex k = 0; k < 1000; ++k) {
    Node node;
    node.position = Vector3(k, 0.0, 0.0);
    network.add_load({{network.add_node(node)}, Vector3::UnitX()});
  }
  const view::Forces forces = view::forces_of(network, view::select(network, 10.0, 1e6));
  REQUIRE(forces.loads.size() == view::max_arrows);
  CHECK(forces.loads[199].load == 995);
  REQUIRE(forces.notes.size() == 2);
  CHECK(forces.notes[0].find("200 of 1000 loads") != std::string::npos);
}

TEST_CASE("the page lists what the sum of kinetic and potential energy leaves out in this run") {
  const TemporaryFolder folder;
  const auto left_out = [&](const Scene& scene) {
    run(scene, folder);
    std::string all;
    const nlohmann::json about = description(page_in(folder));
    for (const std::string part : about["energy_leaves_out"]) all += part + "; ";
    return all;
  };
  Scene scene = testing::with_elements();
  CHECK(left_out(scene) == "");
  CHECK(left_out(testing::everything_to_see()) ==
        "the work of loads and moving obstacles; damping; contact; removed springs; ");
  Motion motion;
  motion.times = {0.0, 1.0};
  motion.displacements = {Vector3::Zero(), Vector3::UnitX()};
  scene.network.add_move({{0}, motion});
  CHECK(left_out(scene) == "the work of moved nodes; ");
}

TEST_CASE("a law that no plugin has is described without units") {
  for (const PluginHost* host : {plugins().get(), static_cast<const PluginHost*>(nullptr)}) {
    const auto text = [host](const LawUse& law) { return view::text_of(host, ComponentKind::spring_function, law); };
    CHECK(text({"of_nobody", {{"length", 2.5}}}) == "of_nobody (length 2.5)");
    CHECK(text({"linear", {}}) == "linear");
  }
}

TEST_CASE("a page whose program alone exceeds the requested size says so") {
  const TemporaryFolder folder;
  Scene scene = testing::everything_to_see();
  const auto notes_size = [&](double size) {
    scene.output.view_size = size;
    const RunSummary summary = run(scene, folder);
    return std::any_of(summary.notes.begin(), summary.notes.end(), [](const std::string& note) {
      return note.find("output.view_size") != std::string::npos && note.find("program") != std::string::npos;
    });
  };
  CHECK(notes_size(1000.0));
  const nlohmann::json notes = description(page_in(folder))["notes"];
  CHECK(std::any_of(notes.begin(), notes.end(), [](const auto& note) {
    return note.template get<std::string>().find("output.view_size") != std::string::npos;
  }));
  CHECK_FALSE(notes_size(16e6));
}

TEST_CASE("a page with internal states has them all, within its estimate") {
  const TemporaryFolder folder;
  Scene scene = testing::with_memory();
  scene.output.law_states = find_law_states(scene.network, *plugins());
  run(scene, folder);
  const std::string page = page_in(folder);
  const nlohmann::json about = description(page);
  CHECK(about["energy_leaves_out"] ==
        nlohmann::json::array({"the work of moved nodes", "damping", "what laws with memory dissipate"}));
  CHECK(about["states"].size() == 2);
  CHECK(about["material_states"] == nlohmann::json::array({{0}, {1}, nlohmann::json::array()}));
  std::size_t with_states = 0;
  for (const Spring& spring : scene.network.springs()) with_states += spring.material < 2 ? 1 : 0;
  CHECK(block<float>(page, "states").size() == about["frames"].get<std::size_t>() * with_states);
  CHECK(static_cast<double>(page.size()) <= estimate_view(scene));
  CHECK(static_cast<double>(page.size()) >= 0.9 * estimate_view(scene));
  // A page that is too large keeps within its limit.
  scene.options.time_step = 0.0005;
  scene.output.view_size = view::program_bytes() + 2e5;
  run(scene, folder);
  CHECK(static_cast<double>(page_in(folder).size()) <= scene.output.view_size);
  CHECK(description(page_in(folder))["states"].size() == 2);
}
