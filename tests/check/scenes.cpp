// Laws of scenes: with the scene's own parameters, lengths and elements.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <springnet/formula.hpp>
#include <springnet/scene.hpp>

#include "check/check.hpp"
#include "check/scene_laws.hpp"

using namespace springnet;
using check::Result;

namespace {

check::Options row_options(std::uint64_t seed = 3) {
  static const auto host = std::make_shared<const PluginHost>(PluginHost::with_default_search());
  check::Options row_options;
  row_options.seed = seed;
  row_options.host = host;
  row_options.limits.seconds = 120.0;  // none of these laws hangs; with sanitizers a busy machine takes its time
  return row_options;
}

LawFormula formula(const char* force) {
  LawFormula law;
  law.force = force;
  for (const std::string& name : parameters_of(law)) law.parameters.push_back({name});
  return law;
}

// A row of springs of these lengths, each with a material of its own.
Network row(const std::vector<std::pair<double, LawUse>>& springs) {
  Network net;
  Node node;
  net.add_node(node);
  for (const auto& [length, law] : springs) {
    node.position.x() += length;
    const NodeIndex next = net.add_node(node);
    net.add_spring(next - 1, next, net.add_material({law, std::nullopt}));
  }
  return net;
}

const check::Finding& finding(const check::Report& report, const char* check) {
  const auto found = std::find_if(report.findings.begin(), report.findings.end(),
                                  [&](const check::Finding& each) { return each.check == check; });
  REQUIRE(found != report.findings.end());
  return *found;
}

}  // namespace

TEST_CASE("the laws of the examples pass without a warning") {
  std::vector<std::filesystem::path> scenes;
  for (const auto& entry : std::filesystem::directory_iterator(EXAMPLES "/laws"))
    if (entry.path().extension() == ".toml") scenes.push_back(entry.path());
  REQUIRE(scenes.size() >= 11);
  for (const auto& scene : scenes)
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const check::Report report =
          check::check_laws_of(load_scene(scene, *row_options().host).network, row_options(seed));
      CHECK(report.passed());
      for (const check::Finding& each : report.findings) {
        CAPTURE(scene.filename().string());
        CAPTURE(each.check);
        CAPTURE(each.outcome.why);
        const bool of_elements = each.check == "order" && each.outcome.result == Result::skipped;
        CHECK((each.outcome.result == Result::passed || of_elements));
      }
    }
}

TEST_CASE("no order is told of springs that break in the test") {
  LawFormula law = formula("stiffness*e");
  law.parameters.push_back({"strength"});
  law.margin = "1 - stiffness*e/strength";
  const auto component = component_of(law);
  const auto outcome = [&](double strength) {
    const LawUse use{"formula", {{"stiffness", 100.0}, {"strength", strength}}, {}, component};
    return finding(check::check_laws_of(row({{0.5, use}}), row_options()), "order").outcome;
  };
  const check::Outcome broken = outcome(0.5), whole = outcome(100.0);
  CAPTURE(broken.why);
  CHECK(broken.result == Result::skipped);
  CHECK(broken.why.find("springs of the test's chain break") != std::string::npos);
  CHECK(whole.result == Result::passed);
}

TEST_CASE("the elements that are checked are the scene's: its lengths, with the parameters that belong to them") {
  const auto component = component_of(formula("stiffness*e/(1 - (length/limit)^2)"));
  const auto law = [&](double stiffness, double limit) {
    return LawUse{"formula", {{"stiffness", stiffness}, {"limit", limit}}, {}, component};
  };
  const Network net = row({{0.2, law(1.0, 0.9)},
                           {0.1, law(1.0, 0.9)},
                           {0.2, law(1.0, 0.9)},
                           {7.0, law(3.0, 30.0)},
                           {5.0, LawUse{"linear", {{"stiffness", 2.0}}}}});
  const std::vector<check::SceneLaw> laws = check::laws_of(net, *row_options().host);
  REQUIRE(laws.size() == 2);
  REQUIRE(laws[0].parameters.size() == 2);
  REQUIRE(laws[0].elements.size() >= 3);
  // The median, the smallest, the largest.
  CHECK(laws[0].elements[0].reference == doctest::Approx(0.2));
  CHECK(laws[0].elements[1].reference == doctest::Approx(0.1));
  CHECK(laws[0].elements[2].reference == doctest::Approx(7.0));
  for (const check::UsedElement& each : laws[0].elements) CHECK(each.parameters == (each.reference > 1.0 ? 1u : 0u));
  CHECK(laws[1].use.id == "linear");
  // Limits of 0.9 m and 30 m are beyond twice of these lengths, not of each other's.
  const check::Report report = check::check_laws_of(net, row_options());
  CHECK(report.findings.size() == 28);
  CHECK(finding(report, "finite").outcome.result == Result::passed);
}

TEST_CASE("a pole that a scene's lengths may reach is told, and one that answers nan beyond is not") {
  const auto found = [](const char* force, double limit) {
    const LawUse law = law_of(formula(force), {{"stiffness", 2.0}, {"limit", limit}});
    return finding(check::check_laws_of(row({{0.5, law}, {0.6, law}}), row_options()), "finite").outcome;
  };
  const check::Outcome pole = found("stiffness*e/(1 - (length/limit)^2)", 0.8);
  CHECK(pole.result == Result::failed);
  CHECK(pole.why.find("a pole at a stretch of 1.6") != std::string::npos);
  CHECK(pole.why.find("if(…, nan)") != std::string::npos);
  CHECK(found("stiffness*e/(1 - (length/limit)^2)", 1.3).result == Result::passed);
  const check::Outcome honest = found("stiffness*e/sqrt(1 - (length/limit)^2)^2", 0.8);
  CHECK(honest.result == Result::passed);
  CHECK(honest.why.find("follows from parameters") != std::string::npos);
  // An end that no parameter moves could be declared.
  CHECK(found("limit*stiffness*log(1.5 - stretch)", 1.0).result == Result::failed);
}

TEST_CASE("formulas are judged as strictly as plugins, and told what to write in a scene") {
  struct Wrong {
    const char *force, *check, *part;
  };
  for (const Wrong& each :
       {Wrong{"stiffness*(e + 0.1)", "rest", "write declares = [\"not zero at rest\"]"},
        Wrong{"stiffness*e - 0.3*stiffness*rate", "dissipation", "write declares = [\"adds power\"]"},
        Wrong{"stiffness*e/(1.5 - stretch)", "finite", "write if(…, nan) for nan beyond it, or stretch = [a, b]"},
        Wrong{"stiffness*log(1.5 - stretch)", "finite", "stretch = [a, b]"}}) {
    CAPTURE(std::string(each.force));
    const LawUse law = law_of(formula(each.force), {{"stiffness", 2.0}});
    const check::Outcome outcome = finding(check::check_laws_of(row({{0.5, law}}), row_options()), each.check).outcome;
    CAPTURE(outcome.why);
    CHECK(outcome.result == Result::failed);
    CHECK(outcome.why.find(each.part) != std::string::npos);
    CHECK(outcome.why.find("SPRINGNET_") == std::string::npos);
  }
  LawFormula loaded = formula("stiffness*(e + 0.1)");
  loaded.not_zero_at_rest = true;
  CHECK(check::check_laws_of(row({{0.5, law_of(loaded, {{"stiffness", 2.0}})}}), row_options()).passed());
  LawFormula pushes = formula("stiffness*e");
  pushes.pulls_only = true;
  const check::Outcome outcome =
      finding(check::check_laws_of(row({{0.5, law_of(pushes, {{"stiffness", 2.0}})}}), row_options()), "promises")
          .outcome;
  CHECK(outcome.why.find("take \"pulls only\" out") != std::string::npos);
}

TEST_CASE("of a law that declares to be monotone the largest fall is told, of several scalars each along its own") {
  LawFormula wave = formula("stiffness*sin(4*strain)");
  wave.monotone = true;
  const check::Outcome one =
      finding(check::check_laws_of(row({{1.0, law_of(wave, {{"stiffness", 2.0}})}}), row_options()), "promises")
          .outcome;
  CAPTURE(one.why);
  CHECK(one.result == Result::failed);
  // sin(4 x) from strains of -1 to 1: from its maximum of 1 at pi/8 to sin(4), or from -sin(4) to its minimum.
  CHECK(one.why.find("falls by 3.5") != std::string::npos);

  const auto sheet = [](double stiffening) {
    LawFormula law;
    law.shape = Invariant::triangle;
    law.scalars = {{"a", "length(0, 1)"}, {"b", "length(0, 2)"}};
    law.forces = {"stiffness*(a - rest(a))", "stiffness*(b - rest(b)) + stiffening*(b - rest(b))^3"};
    law.parameters = {{"stiffness"}, {"stiffening"}};
    law.monotone = true;
    const std::vector<Vector3> corners{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.2, 0.0}};
    Network net;
    for (const Vector3& at : corners) {
      Node node;
      node.position = at;
      net.add_node(node);
    }
    const MaterialIndex material =
        net.add_material({law_of(law, {{"stiffness", 2.0}, {"stiffening", stiffening}}), std::nullopt});
    net.add_element(Invariant::triangle, {0, 1, 2}, material, corners);
    return finding(check::check_laws_of(net, row_options()), "promises").outcome;
  };
  CHECK(sheet(5.0).result == Result::passed);
  const check::Outcome several = sheet(-50.0);
  CAPTURE(several.why);
  CHECK(several.result == Result::failed);
  CHECK(several.why.find("force 1 falls by") != std::string::npos);
}

TEST_CASE("zero rest lengths, unused materials, and many springs are no trouble") {
  Network net = row({{1.0, LawUse{"linear", {{"stiffness", 2.0}}}}});
  net.set_rest_length(0, 0.0);
  static_cast<void>(net.add_material({LawUse{"linear", {{"stiffness", 3.0}}}, LawUse{"linear", {{"damping", 0.1}}}}));
  CHECK(check::check_laws_of(net, row_options()).passed());
  std::vector<std::pair<double, LawUse>> many;
  for (int k = 1; k <= 3000; ++k) many.emplace_back(0.01 * k, LawUse{"linear", {{"stiffness", 1.0 * k}}});
  const check::Report report = check::check_laws_of(row(many), row_options());
  CHECK(report.passed());
  CHECK(report.findings.size() == 14);
}

TEST_CASE("laws that vary faster than the net do not fail `order`, though coarse steps have none") {
  const auto order_of = [](const LawFormula& law, double time) {
    const LawUse use = law_of(law, {{"stiffness", 5.0}, {"tau", time}});
    return finding(check::check_laws_of(row({{0.5, use}, {0.6, use}}), row_options()), "order").outcome;
  };
  LawFormula maxwell;
  maxwell.force = "stiffness*(e - z)";
  maxwell.states.push_back({"z", "(e - z)/tau"});
  maxwell.parameters = {{"stiffness"}, {"tau"}};
  for (const double time : {1e-1, 1e-2, 1e-3}) {
    const check::Outcome outcome = order_of(maxwell, time);
    CAPTURE(time);
    CAPTURE(outcome.why);
    CHECK(outcome.result == Result::passed);
  }
  const check::Outcome fast = order_of(maxwell, 1e-6);
  CHECK(fast.result == Result::skipped);
  CHECK(fast.why.find("a state relaxes within 1e-06 s") != std::string::npos);
  CHECK(order_of(formula("stiffness*sin(e/tau)"), 1e-4).result == Result::passed);
  CHECK(order_of(formula("stiffness*e*exp(-time/tau)"), 1e-3).result == Result::passed);
}
