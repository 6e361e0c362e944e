#include <doctest/doctest.h>

#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "shipped.hpp"

using namespace springnet::test;

namespace {

struct Expected {
  const char* unit;
  double smallest;
  double default_value;
  std::uint32_t flags;
};
constexpr double none = std::numeric_limits<double>::infinity();
constexpr std::uint32_t required = SPRINGNET_REQUIRED, above = SPRINGNET_EXCLUDES_SMALLEST,
                        learnable = SPRINGNET_LEARNABLE;

void check_parameters(const springnet_component& component,
                      const std::vector<std::pair<std::string, Expected>>& expected) {
  CAPTURE(std::string(component.id));
  REQUIRE(component.parameter_count == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const springnet_parameter& p = *component.parameters[i];
    CAPTURE(std::string(p.name));
    CHECK(p.name == expected[i].first);
    CHECK(std::string(p.unit) == expected[i].second.unit);
    CHECK(p.smallest == expected[i].second.smallest);
    CHECK(p.default_value == expected[i].second.default_value);
    CHECK(p.flags == expected[i].second.flags);
  }
}

}  // namespace

TEST_CASE("every shipped plugin is complete and its ids are unique") {
  std::set<std::string> plugins;
  std::set<std::pair<std::uint32_t, std::string>> components;
  for (const springnet_plugin* plugin : shipped_plugins()) {
    CAPTURE(std::string(plugin->id));
    CHECK(plugin->magic == SPRINGNET_MAGIC);
    CHECK(plugin->struct_size == sizeof(springnet_plugin));
    CHECK(plugin->abi_major == SPRINGNET_ABI_MAJOR);
    CHECK(plugins.insert(plugin->id).second);
    CHECK(std::string(plugin->licence) == "MIT");
    REQUIRE(plugin->component_count == 1);
    const springnet_component& component = *plugin->components[0];
    CHECK(components.insert({component.kind, component.id}).second);
    CHECK_FALSE(std::string(component.summary).empty());
    CHECK((component.capabilities & SPRINGNET_HAS_DERIVATIVES) != 0);
    for (std::uint32_t i = 0; i < component.parameter_count; ++i) {
      const springnet_parameter& p = *component.parameters[i];
      CAPTURE(std::string(p.name));
      CHECK_FALSE(std::string(p.unit).empty());
      CHECK_FALSE(std::string(p.summary).empty());
      CHECK(p.scale > 0.0);
      if ((p.flags & SPRINGNET_REQUIRED) == 0) {
        CHECK(p.default_value >= p.smallest);
        CHECK(p.default_value <= p.largest);
      }
    }
  }
}

TEST_CASE("parameters of the shipped laws: names, units, bounds, defaults") {
  check_parameters(spring("linear"), {{"stiffness", {"N/m", 0.0, 0.0, required | learnable}}});
  check_parameters(spring("nonlinear"), {{"stiffness", {"N/m", -none, 0.0, required | learnable}},
                                         {"cubic", {"N/m^3", -none, 0.0, learnable}},
                                         {"quintic", {"N/m^5", -none, 0.0, learnable}}});
  check_parameters(spring("exponential"), {{"stiffness", {"N/m", 0.0, 0.0, required | learnable}},
                                           {"exponent", {"1", 0.0, 10.0, above | learnable}}});
  check_parameters(spring("rupturing"), {{"stiffness", {"N/m", 0.0, 0.0, required | learnable}},
                                         {"strength", {"N", 0.0, 0.0, required | above | learnable}},
                                         {"breaks_in_compression", {"1", 0.0, 0.0, 0}}});
  CHECK(spring("rupturing").parameters[2]->type == SPRINGNET_BOOLEAN);
  check_parameters(viscosity("linear"), {{"damping", {"N s/m", 0.0, 0.0, required | learnable}}});
  check_parameters(viscosity("relative"), {{"damping", {"N s/m", 0.0, 0.0, required | learnable}}});
  check_parameters(viscosity("power"), {{"damping", {"N (s/m)^exponent", 0.0, 0.0, required | learnable}},
                                        {"exponent", {"1", 0.0, 2.0, above | learnable}},
                                        {"linear_below", {"m/s", 0.0, 1e-6, above}}});
  check_parameters(shipped(SPRINGNET_NEURON, "point_mass"), {});
  check_parameters(shipped(SPRINGNET_NEURON, "dragged"), {{"drag", {"kg/s", 0.0, 0.0, required | learnable}}});
}

TEST_CASE("flags of the shipped laws: quantities read, functions provided") {
  for (const char* id : {"linear", "nonlinear", "exponential", "rupturing"}) {
    CAPTURE(std::string(id));
    CHECK(law_of(spring(id)).invariant == SPRINGNET_LENGTH);
    CHECK((spring(id).capabilities & SPRINGNET_HAS_ENERGY) != 0);
    CHECK((spring(id).capabilities & SPRINGNET_ACTS_IN_COMPRESSION) != 0);
    CHECK((spring(id).capabilities & SPRINGNET_READS_RATE) == 0);
    CHECK(((spring(id).capabilities & SPRINGNET_HAS_RUPTURE) != 0) == (std::string(id) == "rupturing"));
  }
  CHECK(law_of(viscosity("linear")).invariant == SPRINGNET_LENGTH);
  CHECK(law_of(viscosity("power")).invariant == SPRINGNET_LENGTH);
  CHECK(law_of(viscosity("relative")).invariant == SPRINGNET_RELATIVE_SPEED);
  CHECK((viscosity("linear").capabilities & SPRINGNET_READS_RATE) != 0);
  CHECK((viscosity("power").capabilities & SPRINGNET_READS_RATE) != 0);
  CHECK((viscosity("relative").capabilities & SPRINGNET_READS_RATE) == 0);
  CHECK((viscosity("linear").capabilities & SPRINGNET_HAS_ENERGY) == 0);
}

TEST_CASE("promises of the shipped laws: which fit elements, divide by the reference, are monotone") {
  const auto has = [](const springnet_component& component, std::uint64_t flag) {
    return (component.capabilities & flag) != 0;
  };
  for (const char* id : {"linear", "nonlinear", "exponential", "rupturing"}) {
    CAPTURE(std::string(id));
    const std::string name = id;
    CHECK(has(spring(id), SPRINGNET_FITS_ELEMENTS));
    CHECK(has(spring(id), SPRINGNET_DIVIDES_BY_REFERENCE) == (name == "exponential"));
    CHECK(has(spring(id), SPRINGNET_MONOTONE) == (name == "linear" || name == "exponential"));
    CHECK_FALSE(has(spring(id), SPRINGNET_NOT_ZERO_AT_REST | SPRINGNET_ADDS_POWER | SPRINGNET_READS_TIME));
    CHECK(spring(id).needs == 0);
  }
  for (const char* id : {"linear", "power"}) {
    CHECK(has(viscosity(id), SPRINGNET_FITS_ELEMENTS));
    CHECK(has(viscosity(id), SPRINGNET_MONOTONE));
  }
  CHECK_FALSE(has(viscosity("relative"), SPRINGNET_FITS_ELEMENTS));
}
