// Values of parameters against their description, and suggestions for misspelt names.
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <springnet/error.hpp>
#include <springnet/plugin_host.hpp>
#include <springnet/suggestion.hpp>

#include "not_finite.hpp"

using springnet::check_value;
using springnet::choice_index;
using springnet::complete_parameters;
using springnet::parameter_index;
using springnet::suggestion;
using springnet::testing::inf;
using springnet::testing::nan_value;

namespace {

springnet_parameter make(std::uint32_t type, const char* name, double value, double smallest, double largest,
                         std::uint32_t flags = 0) {
  springnet_parameter parameter{};
  parameter.struct_size = sizeof parameter;
  parameter.type = type;
  parameter.name = name;
  parameter.unit = "kg";
  parameter.summary = "a summary";
  parameter.default_value = value;
  parameter.smallest = smallest;
  parameter.largest = largest;
  parameter.scale = 1;
  parameter.flags = flags;
  return parameter;
}

const char* const methods[] = {"bdf", "adams"};

struct Described {
  springnet_parameter mass = make(SPRINGNET_NUMBER, "mass", 1, 0, inf, SPRINGNET_EXCLUDES_SMALLEST);
  springnet_parameter count = make(SPRINGNET_INTEGER, "count", 2, 0, 10);
  springnet_parameter method = make(SPRINGNET_CHOICE, "method", 1, 0, 0);
  springnet_parameter stiffness = make(SPRINGNET_NUMBER, "stiffness", nan_value, 0, 100, SPRINGNET_REQUIRED);
  const springnet_parameter* list[4] = {&mass, &count, &method, &stiffness};
  springnet_component component{};
  Described() {
    method.choices = methods;
    method.choice_count = 2;
    component.kind = SPRINGNET_NEURON;
    component.id = "described";
    component.parameter_count = 4;
    component.parameters = list;
  }
};

std::string error_of(const springnet_component& component, const springnet::ParameterValues& values) {
  try {
    static_cast<void>(complete_parameters(component, values, "here"));
  } catch (const springnet::Error& error) {
    CHECK(error.kind() == springnet::ErrorKind::input);
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("check_value: bounds, with the unit, and what is no number") {
  const springnet_parameter open = make(SPRINGNET_NUMBER, "mass", 1, 0, inf, SPRINGNET_EXCLUDES_SMALLEST);
  CHECK(check_value(open, 1e-300) == "");
  CHECK(check_value(open, 1e300) == "");
  CHECK(check_value(open, 0) == "must be above 0 kg, is 0");
  CHECK(check_value(open, -1) == "must be above 0 kg, is -1");
  CHECK(check_value(open, nan_value) == "must be a finite number, is nan");
  CHECK(check_value(open, inf) == "must be a finite number, is inf");

  springnet_parameter closed = make(SPRINGNET_NUMBER, "share", 0, 0, 1);
  closed.unit = "1";
  CHECK(check_value(closed, 0) == "");
  CHECK(check_value(closed, 1) == "");
  CHECK(check_value(closed, -0.5) == "must be at least 0, is -0.5");
  CHECK(check_value(closed, 1.5) == "must be at most 1, is 1.5");
}

TEST_CASE("check_value: whole numbers, booleans, choices") {
  const springnet_parameter integer = make(SPRINGNET_INTEGER, "count", 0, 0, 10);
  CHECK(check_value(integer, 10) == "");
  CHECK(check_value(integer, 2.5) == "must be a whole number, is 2.5");
  CHECK(check_value(integer, 11) == "must be at most 10 kg, is 11");

  // Bounds mean nothing for booleans and choices.
  const springnet_parameter boolean = make(SPRINGNET_BOOLEAN, "on", 0, 5, 6);
  CHECK(check_value(boolean, 0) == "");
  CHECK(check_value(boolean, 1) == "");
  CHECK(check_value(boolean, 0.5) == "must be true or false (1 or 0), is 0.5");

  const Described described;
  CHECK(check_value(described.method, 0) == "");
  CHECK(check_value(described.method, 1) == "");
  CHECK(check_value(described.method, 2) == "must be one of 'bdf', 'adams' (0 to 1), is 2");
  CHECK(check_value(described.method, -1) != "");
  CHECK(check_value(described.method, 0.5) != "");
}

TEST_CASE("indices of parameters and choices") {
  const Described described;
  CHECK(parameter_index(described.component, "method") == 2);
  CHECK(parameter_index(described.component, "metho") == -1);
  CHECK(choice_index(described.method, "adams") == 1);
  CHECK(choice_index(described.method, "Adams") == -1);
}

TEST_CASE("complete_parameters: in the component's order, defaults filled in") {
  const Described described;
  const std::vector<double> expected{1, 7, 1, 3.5};
  CHECK(complete_parameters(described.component, {{"stiffness", 3.5}, {"count", 7}}, "here") == expected);
}

TEST_CASE("complete_parameters: unknown, missing, out of range") {
  const Described described;
  CHECK(error_of(described.component, {{"stiffness", 1}, {"stifness", 1}}) ==
        "here: neuron 'described' has no parameter 'stifness'; did you mean 'stiffness'? it has mass (kg), count (kg), "
        "method (kg), stiffness (kg)");
  CHECK(error_of(described.component, {}) == "here: neuron 'described' needs a value for 'stiffness' (kg: a summary)");
  CHECK(error_of(described.component, {{"stiffness", 101}}) ==
        "here: parameter 'stiffness' of neuron 'described' must be at most 100 kg, is 101");

  springnet_component without{};
  without.kind = SPRINGNET_NEURON;
  without.id = "plain";
  CHECK(complete_parameters(without, {}, "here").empty());
  CHECK(error_of(without, {{"mass", 1}}) == "here: neuron 'plain' has no parameter 'mass'; it has no parameters");
}

TEST_CASE("suggestion: the nearest names by edit distance") {
  const std::vector<std::string> known{"linear", "nonlinear", "exponential", "rupturing", "damping", "stiffness"};
  CHECK(suggestion("linaer", known) == "did you mean 'linear'?");       // two letters swapped
  CHECK(suggestion("liner", known) == "did you mean 'linear'?");        // one missing
  CHECK(suggestion("Linear", known) == "did you mean 'linear'?");       // capitals
  CHECK(suggestion("stifness", known) == "did you mean 'stiffness'?");  //
  CHECK(suggestion("damp", known) == "did you mean 'damping'?");        // cut short
  CHECK(suggestion("expnential", known) == "did you mean 'exponential'?");
  CHECK(suggestion("zzz", known) == "");
  CHECK(suggestion("", known) == "");
  CHECK(suggestion("linear", {}) == "");
}

TEST_CASE("suggestion: several that are equally near, and names of a letter") {
  CHECK(suggestion("node", {"nodes", "mode", "nude"}) == "did you mean 'mode', 'nodes' or 'nude'?");
  CHECK(suggestion("cat", {"bat", "hat"}) == "did you mean 'bat' or 'hat'?");
  CHECK(suggestion("x", {"y", "z"}) == "");
}
