#include <doctest/doctest.h>

#include <limits>
#include <string>

#include <springnet/sdk/metadata.hpp>

namespace {
using namespace springnet::sdk;

struct Owner {
  static constexpr Parameter parameters[] = {
      number("stiffness", "N/m", "tension per elongation").above(0).at_most(1e9).learnable(100),
      number("phase", "rad", "where it starts").preset(0.5), integer("order", "of the method").preset(2).at_least(1),
      boolean("soft", "softer"), choice("update", {"synchronous", "wavefront"}, "rule of update").preset(1)};
};
struct Bare {};
template <class Component>
struct List {
  static constexpr std::span<const Parameter> get() { return parameters_of<Component>(); }
};
}  // namespace

TEST_CASE("parameters arrive in the C structs as declared") {
  using Table = ParameterTable<List<Owner>>;
  REQUIRE(Table::count == 5);
  const auto& stiffness = *Table::pointer[0];
  CHECK(stiffness.struct_size == sizeof(springnet_parameter));
  CHECK(stiffness.type == SPRINGNET_NUMBER);
  CHECK(std::string(stiffness.name) == "stiffness");
  CHECK(std::string(stiffness.unit) == "N/m");
  CHECK(std::string(stiffness.summary) == "tension per elongation");
  CHECK(stiffness.smallest == 0.0);
  CHECK(stiffness.largest == 1e9);
  CHECK(stiffness.scale == 100.0);
  CHECK(stiffness.flags == (SPRINGNET_REQUIRED | SPRINGNET_EXCLUDES_SMALLEST | SPRINGNET_LEARNABLE));

  const auto& phase = *Table::pointer[1];
  CHECK(phase.default_value == 0.5);
  CHECK(phase.flags == 0);
  CHECK(phase.smallest == -std::numeric_limits<double>::infinity());
  CHECK(phase.largest == std::numeric_limits<double>::infinity());

  CHECK(Table::pointer[2]->type == SPRINGNET_INTEGER);
  CHECK(Table::pointer[3]->type == SPRINGNET_BOOLEAN);
  CHECK(Table::pointer[3]->largest == 1.0);
  CHECK(Table::pointer[3]->flags == 0);

  const auto& update = *Table::pointer[4];
  CHECK(update.type == SPRINGNET_CHOICE);
  REQUIRE(update.choice_count == 2);
  CHECK(std::string(update.choices[1]) == "wavefront");
  CHECK(update.default_value == 1.0);
  CHECK(update.largest == 1.0);
}

TEST_CASE("a component may have no parameters") {
  CHECK(ParameterTable<List<Bare>>::count == 0);
  CHECK(ParameterTable<List<Bare>>::pointer == nullptr);
}
