// The formulas of examples/laws against closed forms of the literature that they name, written here with the standard
// library: forces and energies over their ranges, and that each scene runs.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <string>

#include <doctest/doctest.h>

#include <springnet/events.hpp>
#include <springnet/scene.hpp>
#include <springnet/simulation.hpp>

#include "../tool/tool.hpp"

using namespace springnet;

namespace {

const PluginHost& plugins() {
  static const PluginHost host = PluginHost::with_default_search();
  return host;
}

Scene example(const std::string& name) {
  return load_scene(std::filesystem::path(EXAMPLES) / "laws" / (name + ".toml"), plugins());
}

struct Answer {
  double force = 0.0, slope = 0.0, energy = std::nan(""), margin = std::nan("");
};
// At a length (m), of a spring at rest at `rest`, whose length changes by `rate`.
Answer at(const LawUse& use, double length, double rest, double rate = 0.0) {
  const Component& law = *use.component;
  std::vector<double> values;
  std::vector<const double*> parameters;
  for (std::uint32_t k = 0; k < law.description->parameter_count; ++k)
    values.push_back(use.parameters.at(law.description->parameters[k]->name));
  for (const double& value : values) parameters.push_back(&value);
  const std::vector<std::uint32_t> strides(values.size() + 1, 0);
  Answer answer;
  springnet_law_batch batch{};
  batch.struct_size = sizeof batch;
  batch.count = 1;
  batch.q = &length;
  batch.rate = &rate;
  batch.reference = &rest;
  batch.parameters = parameters.data();
  batch.parameter_strides = strides.data();
  batch.force = &answer.force;
  batch.force_by_q = &answer.slope;
  if ((law.description->capabilities & SPRINGNET_HAS_ENERGY) != 0) batch.energy = &answer.energy;
  if ((law.description->capabilities & SPRINGNET_HAS_RUPTURE) != 0) batch.margin = &answer.margin;
  REQUIRE(law.law().evaluate(law.law().context, &batch) == SPRINGNET_OK);
  return answer;
}

// By length (m) and rate (m/s).
using ClosedForm = std::function<double(double, double)>;
const std::map<std::string, ClosedForm>& closed_forms() {
  static const std::map<std::string, ClosedForm> forms{
      {"fene", [](double r, double) { return 3.0 * r / (1.0 - r * r / 2.25); }},
      {"morse",
       [](double r, double) {
         const double y = std::exp(-3.0 * (r - 1.0));
         return 2.0 * 2.0 * 3.0 * y * (1.0 - y);
       }},
      {"worm_like_chain",
       [](double r, double) {
         const double x = r / 2.0;
         return 0.5 / 0.1 * (0.25 / ((1.0 - x) * (1.0 - x)) - 0.25 + x);
       }},
      {"mooney_rivlin",
       [](double r, double) {
         const double l = r / 0.5;
         return 2e-4 * (2e5 + 5e4 / l) * (l - 1.0 / (l * l));
       }},
      {"gent",
       [](double r, double) {
         const double l = r / 0.5, i = l * l + 2.0 / l - 3.0;
         return 1e-4 * 4e5 * 20.0 / (20.0 - i) * (l - 1.0 / (l * l));
       }},
      {"tendon",
       [](double r, double) {
         const double x = (r - 0.1) / 0.1;
         if (x < 0.0) return 0.0;
         if (x < 0.04) return 30.0 * (std::exp(60.0 * x) - 1.0);
         return 30.0 * (std::exp(2.4) - 1.0) + 1800.0 * std::exp(2.4) * (x - 0.04);
       }},
      {"lennard_jones",
       [](double r, double) {
         return -(48.0 * std::pow(0.5, 12.0) / std::pow(r, 13.0) - 24.0 * std::pow(0.5, 6.0) / std::pow(r, 7.0));
       }},
      {"hertz",
       [](double r, double) {
         const double d = 0.2 - r;
         return d > 0.0 ? -4.0 / 3.0 * 1e5 * std::sqrt(0.05) * d * std::sqrt(d) : 0.0;
       }},
      {"bingham",
       [](double, double rate) {
         return (rate < 0.0 ? -1.0 : 1.0) * 2.0 * (1.0 - std::exp(-std::abs(rate) / 0.01)) + 0.5 * rate;
       }},
      {"carreau", [](double, double rate) { return rate * (0.1 + 1.9 * std::pow(1.0 + rate * rate / 0.04, -0.3)); }}};
  return forms;
}

// Compares from one length to another; energies with the integral of the force by Gauss' rule between each two.
void check(const std::string& name, double rest, double from, double to) {
  CAPTURE(name);
  const auto force = [&](double length) { return closed_forms().at(name)(length, 0.0); };
  const Scene scene = example(name);
  CHECK(scene.network.springs()[0].rest_length == doctest::Approx(rest).epsilon(1e-15));
  const LawUse& law = *scene.network.materials()[scene.network.springs()[0].material].spring;
  constexpr int steps = 200;
  double before = 0.0, largest = 0.0;
  for (int i = 0; i <= steps; ++i) largest = std::max(largest, std::abs(force(from + (to - from) * i / steps)));
  for (int i = 0; i <= steps; ++i) {
    const double length = from + (to - from) * i / steps, width = (to - from) / steps;
    const Answer own = at(law, length, rest);
    CAPTURE(length);
    // Roundings of some operations with numbers up to the largest force.
    CHECK(std::abs(own.force - force(length)) <= 1e-13 * largest + 1e-12 * std::abs(force(length)));
    if (std::isnan(own.energy)) continue;
    if (i > 0) {
      double work = 0.0;
      const double middle = length - 0.5 * width;
      for (const auto& [x, w] :
           {std::pair(0.0, 8.0 / 9.0), std::pair(std::sqrt(0.6), 5.0 / 9.0), std::pair(-std::sqrt(0.6), 5.0 / 9.0)})
        work += 0.5 * width * w * force(middle + 0.5 * width * x);
      // The rule is exact to the sixth power of the width.
      CHECK(std::abs(own.energy - before - work) <= 1e-6 * std::abs(work) + 1e-9 * largest * std::abs(to - from));
    }
    before = own.energy;
  }
}

}  // namespace

TEST_CASE("laws of the literature as formulas: forces by closed forms, energies by their integrals") {
  check("fene", 0.5, 0.05, 1.45);
  check("morse", 1.0, 0.5, 1.9);
  check("worm_like_chain", 0.2, 0.05, 1.9);
  check("mooney_rivlin", 0.5, 0.3, 1.5);
  check("gent", 0.5, 0.3, 2.0);
  check("tendon", 0.1, 0.095, 0.108);
  check("lennard_jones", 0.6, 0.48, 1.2);
  check("hertz", 0.2, 0.19, 0.21);
}

TEST_CASE("dampers of the literature as formulas") {
  for (const char* name : {"bingham", "carreau"}) {
    CAPTURE(name);
    const Scene scene = example(name);
    const LawUse& law = *scene.network.materials()[scene.network.springs()[0].material].viscosity;
    for (const double rate : {-3.0, -0.3, -0.01, -1e-4, 0.0, 1e-4, 0.02, 0.4, 5.0}) {
      CAPTURE(rate);
      const double force = at(law, 1.1, 1.0, rate).force;
      CHECK(force == doctest::Approx(closed_forms().at(name)(1.1, rate)).epsilon(1e-12));
      CHECK(force * rate >= 0.0);
    }
  }
}

TEST_CASE("Morse's bond breaks at twice its length, in the run too") {
  const Scene scene = example("morse");
  const LawUse& law = *scene.network.materials()[0].spring;
  CHECK(at(law, 1.0, 1.0).margin == 1.0);
  CHECK(at(law, 2.0, 1.0).margin == 0.0);

  std::ifstream file(std::filesystem::path(EXAMPLES) / "laws/morse.toml");
  std::string text(std::istreambuf_iterator<char>(file), {});
  const std::size_t farthest = text.find("[1, 0.9,");
  REQUIRE(farthest != std::string::npos);
  for (const bool breaks : {false, true}) {
    CAPTURE(breaks);
    text.replace(farthest, 8, breaks ? "[1, 1.2," : "[1, 0.9,");
    const Scene run = parse_scene(text, "morse", plugins());
    const auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
    Simulation simulation(run.network, host, run.options);
    double longest = 0.0;
    while (simulation.time() < 1.0 - 1e-9) {
      simulation.step();
      if (count_events(simulation).ruptured == 0)
        longest = (simulation.positions().col(1) - simulation.positions().col(0)).norm();
    }
    CHECK(count_events(simulation).ruptured == (breaks ? 1 : 0));
    if (!breaks) continue;
    CHECK(simulation.tension(0) == 0.0);
    CHECK(longest < 2.0);
    CHECK(longest > 2.0 - 1.5 * 1.2 * run.options.time_step);  // the step before it
  }
}

TEST_CASE("every scene of examples/laws runs, with the tension of the closed form at the place of its ends") {
  std::size_t count = 0, compared = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(EXAMPLES) / "laws")) {
    if (entry.path().extension() != ".toml") continue;
    ++count;
    CAPTURE(entry.path().filename().string());
    const Scene scene = load_scene(entry.path(), plugins());
    const auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
    Simulation simulation(scene.network, host, scene.options);
    const auto law = closed_forms().find(entry.path().stem().string());
    double largest = 0.0, shortest = INFINITY, longest = 0.0;
    while (simulation.time() < scene.duration - 0.5 * scene.options.time_step) {
      simulation.step();
      if (law == closed_forms().end()) continue;
      const Vector3 between = simulation.positions().col(1) - simulation.positions().col(0);
      const double length = between.norm();
      const double rate = between.dot(simulation.velocities().col(1) - simulation.velocities().col(0)) / length;
      const double wanted = law->second(length, rate), own = simulation.tension(0);
      CAPTURE(simulation.time());
      CHECK(std::abs(own - wanted) <= 1e-11 * std::max(1.0, std::abs(wanted)));
      largest = std::max(largest, std::abs(own));
      shortest = std::min(shortest, length);
      longest = std::max(longest, length);
    }
    CHECK(simulation.positions().allFinite());
    if (law == closed_forms().end()) continue;
    ++compared;
    CHECK(largest > 0.0);
    CHECK(longest > 1.05 * shortest);  // it moves
  }
  CHECK(count >= 11);
  CHECK(compared == closed_forms().size());
}

TEST_CASE("every law of examples/laws is drawn as its page says") {
  const testing::TemporaryFolder folder;
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(EXAMPLES) / "laws")) {
    if (entry.path().extension() != ".toml") continue;
    ++count;
    CAPTURE(entry.path().filename().string());
    REQUIRE(testing::springnet(folder, "plugin show '" + entry.path().string() + "' --plot law.svg").status == 0);
    const std::string figure = testing::read_text(folder.path() / "law.svg");
    CHECK(figure.starts_with("<svg"));
    CHECK(figure.find("</svg>") != std::string::npos);
    CHECK(figure.find("function by a formula") != std::string::npos);  // the law's name in its title
    std::size_t lines = 0;
    for (std::size_t at = figure.find(" d=\""); at != std::string::npos; at = figure.find(" d=\"", at + 1)) {
      const std::string path = figure.substr(at + 4, figure.find('"', at + 4) - at - 4);
      CHECK(path.find_first_not_of("MLHVZz0123456789.,- ") == std::string::npos);  // finite
      ++lines;
    }
    CHECK(lines > 0);
  }
  CHECK(count >= 11);
}

TEST_CASE("a sheet by a formula moves as the membrane's plugin, with the same material") {
  std::ifstream file(std::filesystem::path(EXAMPLES) / "laws/st_venant_sheet.toml");
  std::string text(std::istreambuf_iterator<char>(file), {});
  const Scene scene = parse_scene(text, "sheet", plugins());
  const std::size_t begin = text.find("spring    = { youngs_modulus"), end = text.find("\"\"\" }", begin) + 5;
  REQUIRE(end > begin);
  text.replace(begin, end - begin,
               "spring = { type = \"membrane\", youngs_modulus = 1e5, poisson_ratio = 0.3, thickness = 1e-3, model = "
               "\"st_venant_kirchhoff\" }");
  const Scene plugin = parse_scene(text, "sheet", plugins());
  const auto host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  const auto after = [&](const Network& net) {
    SimulationOptions options = scene.options;
    options.integrator = {"recurrent", {{"update", 4.0}, {"force_tolerance", 1e-9}}};
    Simulation simulation(net, host, options);
    for (int i = 0; i < 40; ++i) simulation.step();
    return Eigen::Matrix3Xd(simulation.positions());
  };
  const Eigen::Matrix3Xd a = after(scene.network), b = after(plugin.network);
  CHECK((a - b).cwiseAbs().maxCoeff() <= 1e-9);
  CHECK((a.rowwise().minCoeff())[2] < -0.01);  // it hangs
}
