// What laws make of their tables: made once for each distinct use, freed exactly once, and errors on the way.
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/sdk/message.hpp>

#define SPRINGNET_STATIC_PLUGIN prepared
#include <springnet/sdk/law.hpp>

#include "facts.hpp"
#include "nets.hpp"

namespace {

namespace sdk = springnet::sdk;

int made = 0, freed = 0;

struct Slope {
  double value;
  std::vector<double> optional;
  Slope(double of, std::vector<double> more) : value(of), optional(std::move(more)) { ++made; }
  Slope(const Slope&) = delete;
  Slope& operator=(const Slope&) = delete;
  ~Slope() { ++freed; }
};

struct Counted : sdk::SpringFunction {
  static constexpr const char* id = "counted";
  static constexpr const char* summary = "counts what it prepares";
  static constexpr sdk::Parameter parameters[] = {sdk::number("factor", "1", "of the slope").preset(1)};
  static constexpr sdk::Table tables[] = {sdk::table("slopes", "N/m", "the first counts").within(0, 1e6),
                                          sdk::table("more", "1", "whatever").optional()};
  [[nodiscard]] Slope prepare(const sdk::TableSource& source) const {
    if (source[0][0] == 13.0) throw std::runtime_error("thirteen is too much");
    return {source[0][0] * source.parameter(0), {source[1].begin(), source[1].end()}};
  }
  static auto force(const auto& e, const auto&) {
    return (e.table.value + static_cast<double>(e.table.optional.size())) * e.elongation();
  }
};

}  // namespace

SPRINGNET_PLUGIN("test.prepared", "1.0.0", "springnet", "MIT", Counted);

using namespace springnet;
using namespace springnet::testing;

namespace {

springnet_status refuse(void*, springnet_preparation* preparation) {
  sdk::detail::write_message(preparation->message, "the curve is upside down");
  return SPRINGNET_FAILED;
}
springnet_status refuse_in_silence(void*, springnet_preparation*) { return SPRINGNET_FAILED; }
springnet_status never(void*, springnet_preparation*) {
  FAIL("nothing was prepared, so nothing is to be released");
  return SPRINGNET_OK;
}

// Counted with another function `prepare`.
struct Refusing {
  springnet_law law = *static_cast<const springnet_law*>(springnet_plugin_entry_prepared.components[0]->implementation);
  springnet_component component = *springnet_plugin_entry_prepared.components[0];
  const springnet_component* components[1] = {&component};
  springnet_plugin plugin = springnet_plugin_entry_prepared;
  Refusing(const char* id, const char* plugin_id, springnet_status (*prepare)(void*, springnet_preparation*)) {
    law.prepare = prepare;
    law.release = never;
    component.id = id;
    component.implementation = &law;
    plugin.id = plugin_id;
    plugin.components = components;
    plugin.component_count = 1;
  }
};

std::shared_ptr<const PluginHost> host() {
  static const Refusing refusing("refusing", "test.refusing", refuse),
      silent("silent", "test.silent", refuse_in_silence);
  auto plugin_host = std::make_shared<PluginHost>(PluginHost::with_default_search());
  REQUIRE(plugin_host->add(springnet_plugin_entry_prepared));
  REQUIRE(plugin_host->add(refusing.plugin));
  REQUIRE(plugin_host->add(silent.plugin));
  return plugin_host;
}

Network chain_of(const std::vector<Material>& materials) {
  Network net;
  for (std::size_t k = 0; k <= materials.size(); ++k) net.add_node(point({1.1 * static_cast<double>(k), 0, 0}));
  for (NodeIndex k = 0; k < materials.size(); ++k) net.add_spring(k, k + 1, net.add_material(materials[k]), 1.0);
  net.fix(0);
  return net;
}
Material counted(double slope, double factor = 1.0, std::vector<double> more = {}) {
  LawUse law{"counted", {{"factor", factor}}, {{"slopes", {slope, 2.0}}}};
  if (!more.empty()) law.tables["more"] = std::move(more);
  return {law, std::nullopt};
}

std::string refusal(const LawUse& law) {
  made = freed = 0;
  try {
    Simulation(chain_of({counted(5.0), {law, std::nullopt}}), host(), {});
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::input);
    CHECK(made == freed);
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("each distinct use is prepared once, shared by equal ones, and freed with the simulation") {
  made = freed = 0;
  {
    Material viscous = counted(5.0);
    viscous.viscosity = LawUse{"linear", {{"damping", 1.0}}};
    const Network net =
        chain_of({counted(5.0), counted(7.0), counted(5.0), viscous, counted(5.0, 3.0), counted(5.0, 1.0, {1, 1, 1})});
    CHECK(net.materials().size() == 5);
    Simulation simulation(net, host(), {});
    CHECK(made == 4);  // slope 5 with and without viscosity is one
    CHECK(freed == 0);
    const double x = 0.1;
    for (const auto& [spring, slope] :
         std::vector<std::pair<SpringIndex, double>>{{0, 5}, {1, 7}, {2, 5}, {3, 5}, {4, 15}, {5, 8}})
      CHECK(simulation.tension(spring) == doctest::Approx(slope * x));
    simulation.advance_to(0.1);
    Simulation moved = std::move(simulation);
    moved.advance_to(0.2);
    CHECK(made == 4);
    CHECK(freed == 0);
  }
  CHECK(freed == 4);
}

TEST_CASE("a law that cannot prepare its tables is an error of input that names it, and nothing leaks") {
  using springnet::testing::has_facts;
  CHECK(has_facts(refusal({"counted", {}, {{"slopes", {13.0}}}}), "'counted' | material 1 | thirteen is too much"));
  CHECK(has_facts(refusal({"refusing", {}, {{"slopes", {1.0}}}}), "'refusing' | material 1 | upside down"));
  CHECK(has_facts(refusal({"silent", {}, {{"slopes", {1.0}}}}), "'silent' | material 1 | without giving a reason"));
  CHECK(made == 1);
}

TEST_CASE("tables of a program are checked as those of a scene") {
  CHECK(has_facts(refusal({"counted", {}}), "'counted' | needs the table 'slopes' (N/m"));
  CHECK(has_facts(refusal({"counted", {}, {{"slope", {1.0}}}}), "no table 'slope' | 'slopes'"));
  CHECK(has_facts(refusal({"counted", {}, {{"slopes", {1.0, -2.0}}}}), "'slopes' | row 2 | at least 0 N/m, is -2"));
  CHECK(has_facts(refusal({"counted", {}, {{"slopes", {}}}}), "'slopes' | 1 value or more, has 0"));
  CHECK(has_facts(refusal({"linear", {{"stiffness", 1.0}}, {{"slopes", {1.0}}}}), "'linear' | no table 'slopes'"));
  Network net;
  CHECK_THROWS_WITH_AS(net.add_material({LawUse{"counted", {}, {{"slopes", {1.0, INFINITY}}}}, std::nullopt}),
                       doctest::Contains("table 'slopes': row 2 must be a finite number"), Error);
}

TEST_CASE("materials differ by their tables, and only by what differs") {
  Network net;
  CHECK(net.add_material(counted(1.0)) == 0);
  CHECK(net.add_material(counted(2.0)) == 1);
  CHECK(net.add_material(counted(1.0)) == 0);
  CHECK(net.add_material(counted(1.0, 1.0, {0.0})) == 2);
  CHECK(net.add_material(counted(1.0, 1.0, {-0.0})) == 2);
  CHECK(net.add_material(counted(1.0, 1.0, {0.0, 0.0})) == 3);
  CHECK(net.materials().size() == 4);
}
