// Tables of laws against their description.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/plugin_host.hpp>

#include "facts.hpp"
#include "not_finite.hpp"

using springnet::check_table;
using springnet::complete_tables;
using springnet::TableValues;
using springnet::testing::has_facts;
using springnet::testing::inf;

namespace {

// Elongations (increasing, two or more), forces (as many), weights (optional, as many, 0 to 1).
struct DescribedTables {
  springnet_table elongations{
      sizeof(springnet_table), SPRINGNET_INCREASING, "elongations", "m", "of each point", 2, 0, -inf, inf};
  springnet_table forces{sizeof(springnet_table), 0, "forces", "N", "at each of them", 1, 0, -inf, inf};
  springnet_table weights{sizeof(springnet_table), SPRINGNET_OPTIONAL, "weights", "1", "of each point", 0, 1, 0, 1};
  const springnet_table* list[3] = {&elongations, &forces, &weights};
  springnet_law law{};
  springnet_component component{};
  DescribedTables() {
    law.table_count = 3;
    law.tables = list;
    component.kind = SPRINGNET_SPRING_FUNCTION;
    component.id = "curve";
    component.implementation = &law;
  }
  [[nodiscard]] std::string error_of(const TableValues& values) const {
    try {
      static_cast<void>(complete_tables(component, values, "here"));
    } catch (const springnet::Error& error) {
      CHECK(error.kind() == springnet::ErrorKind::input);
      return error.what();
    }
    return {};
  }
};

}  // namespace

TEST_CASE("complete_tables: in the component's order, empty where an optional one is not given") {
  const DescribedTables described;
  const TableValues given{{"forces", {3, 4}}, {"elongations", {1, 2}}};
  const auto complete = complete_tables(described.component, given, "here");
  REQUIRE(complete.size() == 3);
  CHECK(complete[0].data() == given.at("elongations").data());
  CHECK(complete[1].data() == given.at("forces").data());
  CHECK(complete[1].size() == 2);
  CHECK(complete[2].empty());
  CHECK(described.error_of({{"forces", {3, 4}}, {"elongations", {1, 2}}, {"weights", {0, 1}}}).empty());
}

TEST_CASE("complete_tables: missing, unknown, of another length, wrong values") {
  const DescribedTables d;
  CHECK(has_facts(d.error_of({}), "here: | 'curve' | needs the table 'elongations' (m: of each point)"));
  CHECK(has_facts(d.error_of({{"elongations", {1, 2}}}), "'forces' (N"));
  CHECK(has_facts(d.error_of({{"force", {1, 2}}}), "no table 'force' | did you mean 'forces' | 'elongations' (m)"));
  CHECK(has_facts(d.error_of({{"elongations", {1, 2}}, {"forces", {1, 2, 3}}}),
                  "'forces' | has 3 values | 'elongations' has 2"));
  CHECK(has_facts(d.error_of({{"elongations", {1, 2}}, {"forces", {1, 2}}, {"weights", {1}}}),
                  "'weights' | has 1 value, | 'forces' has 2"));
  CHECK(has_facts(d.error_of({{"elongations", {1, 2}}, {"forces", {1, 2}}, {"weights", {0.5, 1.5}}}),
                  "'weights' | row 2 must be at most 1, is 1.5"));
  CHECK(has_facts(d.error_of({{"elongations", {2, 1}}, {"forces", {1, 2}}}), "'elongations' | row 2 | 2 m, is 1"));
}

TEST_CASE("complete_tables: only laws have tables") {
  DescribedTables described;
  described.component.kind = SPRINGNET_NEURON;
  CHECK(springnet::tables_of(described.component).empty());
  CHECK(has_facts(described.error_of({{"forces", {1}}}), "neuron 'curve' | no table 'forces' | it has no tables"));
}

TEST_CASE("check_table: the first row that is wrong, from 0; none if it is their number") {
  const DescribedTables d;
  CHECK_FALSE(check_table(d.elongations, std::vector<double>{1, 2, 3}).has_value());
  const auto row = [](const springnet_table& table, const std::vector<double>& values) {
    const auto wrong = check_table(table, values);
    REQUIRE(wrong.has_value());
    CHECK_FALSE(wrong->what.empty());
    return wrong->row ? static_cast<int>(*wrong->row) : -1;
  };
  CHECK(row(d.elongations, {1, 1}) == 1);
  CHECK(row(d.elongations, {1, 2, std::nan(""), 4}) == 2);
  CHECK(row(d.elongations, {1, 2, inf}) == 2);
  CHECK(row(d.elongations, {1}) == -1);
  CHECK(row(d.weights, {}) == -1);
  CHECK(row(d.weights, {-0.1}) == 0);
  CHECK(row(d.forces, std::vector<double>(springnet::most_table_values + 1)) == -1);
}
